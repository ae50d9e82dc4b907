// Transparents of a host's own, by both ways: as fragments in the library's lists, and shaded by
// the host with what the media do before them.

#include <cmath>
#include <fmt/format.h>

#include "fog_panes.h"
#include "host_picture.h"
#include "support/host_draws.h"
#include <fumarole/errors.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

/// A pane of a scene as a host draws it.
struct HostPane {
    HostPanes::Place place;
    glm::vec4 color{0};
    unsigned blend = 0;
};

HostPane as_hosts(const Transparent& transparent)
{
    const auto& quad = std::get<QuadTransparent>(transparent);
    const TransparentLook& look = quad.look;
    HostPane pane{{quad.corner, quad.edges}, glm::vec4(look.radiance, look.alpha), 0};
    const auto factors = [](BlendFactor source, BlendFactor behind) {
        return host_blend(unsigned(source), unsigned(behind));
    };
    switch (look.blend.kind) {
    case Kind::alpha:
        pane.blend = factors(BlendFactor::src_alpha, BlendFactor::one_minus_src_alpha);
        break;
    case Kind::premultiplied:
        pane.blend = factors(BlendFactor::one, BlendFactor::one_minus_src_alpha);
        break;
    case Kind::add:
        pane.blend = factors(BlendFactor::one, BlendFactor::one);
        break;
    case Kind::multiply:
        pane.blend = factors(BlendFactor::zero, BlendFactor::src_color);
        pane.color = glm::vec4(look.filter, look.alpha);
        break;
    case Kind::factors:
        pane.blend = factors(look.blend.source, look.blend.destination);
    }
    return pane;
}

class HostTransparents : public ImageTest {
protected:
    static std::vector<Settings> modes()
    {
        return {plain_settings(1), plain_settings(2), plain_settings(4), plain_froxels(1)};
    }

    HostTransparents() : panes_{gl()} {}

    /// A frame of the fog before its sky.
    HostPicture picture_of(const Scene& scene) const
    {
        HostPicture picture(gl(), glm::ivec2(scene.resolution));
        picture.look(scene.camera);
        picture.fill(scene.world.radiance, scene.camera.near, [](int, int) { return 0.0; });
        return picture;
    }

    static std::vector<TransparentExtent> extents(const std::vector<Transparent>& all,
                                                  const Frame& frame)
    {
        std::vector<TransparentExtent> out;
        for (const Transparent& one : all)
            out.push_back(as_hosts(one).place.extent(frame));
        return out;
    }

    /// A frame of `scene`, with what the host draws into its lists, once these have room.
    Image composite(const Scene& scene, const Settings& settings,
                    const std::vector<Transparent>& hosts, bool gives_depth = true)
    {
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        View view = renderer.make_view();
        Image image;
        for (int turn = 0; turn < 2; ++turn) {
            HostPicture picture = picture_of(scene);
            picture.frame.transparents = extents(hosts, picture.frame);
            if (!hosts.empty()) {
                renderer.begin_transparents(view, picture.frame, settings, HostPanes::kLists);
                draw(picture.frame, hosts, gives_depth);
                renderer.end_transparents(view);
            }
            renderer.composite(view, picture.frame, settings);
            renderer.wait_until_ready();
            image = picture.read();
        }
        EXPECT_EQ(renderer.fragment_count().lost, 0u);
        return image;
    }

    void draw(const Frame& frame, const std::vector<Transparent>& hosts,
              bool gives_depth = true) const
    {
        for (std::size_t i = 0; i < hosts.size(); ++i) {
            const HostPane pane = as_hosts(hosts[i]);
            panes_.list(frame, pane.place, pane.color, pane.blend, unsigned(i), gives_depth);
        }
    }

    HostPanes panes_;
};

TEST_F(HostTransparents, FragmentsOfAHostAreTheScenesBitForBit)
{
    for (const bool reads_picture : {false, true})
        for (Settings settings : modes())
            for (const Settings::Format format :
                 {Settings::Format::rgba32f, Settings::Format::rgba16f}) {
                SCOPED_TRACE(testing::Message() << "mode " << int(settings.mode) << ", 1/"
                                                << settings.resolution << ", " << int(format));
                settings.format = format;
                const std::vector<Transparent> panes = crossing(reads_picture);
                Scene without = fog_scene();
                without.transparents = {two_deep(5)};
                Scene scene = without, half = without;
                scene.transparents.insert(scene.transparents.end(), panes.begin(), panes.end());
                const Image scenes = composite(scene, settings, {});
                EXPECT_EQ(composite(without, settings, panes).pixels, scenes.pixels);
                // Half of them the host's, half the scene's.
                half.transparents.insert(half.transparents.end(), panes.begin(), panes.begin() + 5);
                const std::vector<Transparent> rest(panes.begin() + 5, panes.end());
                EXPECT_EQ(composite(half, settings, rest).pixels, scenes.pixels);
            }
}

TEST_F(HostTransparents, AFragmentKnowsItsOwnDepth)
{
    const std::vector<Transparent> hosts = crossing(false);
    const Scene scene = fog_scene();
    for (const Settings& settings : plain_siblings())
        EXPECT_LT(max_difference(composite(scene, settings, hosts, false),
                                 composite(scene, settings, hosts)),
                  2e-6);
    // Of a camera whose rays are parallel: at one depth, a tenth of a millimetre before the other.
    Renderer renderer(get_proc());
    Scene empty = empty_scene(8);
    renderer.set_scene(empty, plain_settings());
    View view = renderer.make_view();
    for (const double first : {4.9999, 5.0001}) {
        HostPicture picture = picture_of(empty);
        picture.frame.depth_convention = {};
        picture.fill(glm::vec3(0), 1, [](int, int) { return 1.0; });
        picture.frame.clip_from_view = glm::dmat4(1.0);
        picture.frame.clip_from_view[2][2] = -2.0 / 9;  // from 1 to 10 m
        picture.frame.clip_from_view[3][2] = -11.0 / 9;
        renderer.begin_transparents(view, picture.frame, plain_settings(), HostPanes::kLists);
        const HostPane near = as_hosts(pane(first, Kind::alpha)),
                       far = as_hosts(pane(5, Kind::alpha));
        panes_.list(picture.frame, near.place, {1, 0, 0, 1}, near.blend, 0, false);
        panes_.list(picture.frame, far.place, {0, 0, 1, 1}, far.blend, 1, true);
        renderer.end_transparents(view);
        Frame frame = picture.frame;
        renderer.composite(view, frame, plain_settings());
        EXPECT_EQ(picture.read().at(4, 4, first < 5 ? 0 : 2), 1) << first;
    }
}

TEST_F(HostTransparents, AtOneDepthTheLargerDrawIsInFrontAndTheHostsBeforeTheScenes)
{
    Scene scene = empty_scene(8);
    QuadTransparent green = pane(5, Kind::alpha);
    green.look.radiance = {0, 1, 0};
    scene.transparents = {green};
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    const HostPane at = as_hosts(green);
    for (const unsigned of_red : {0u, 2u}) {
        HostPicture picture = picture_of(scene);
        renderer.begin_transparents(view, picture.frame, plain_settings(), HostPanes::kLists);
        panes_.list(picture.frame, at.place, {1, 0, 0, 1}, at.blend, of_red);
        panes_.list(picture.frame, at.place, {0, 0, 1, 1}, at.blend, 1);
        renderer.end_transparents(view);
        renderer.composite(view, picture.frame, plain_settings());
        const Image image = picture.read();
        EXPECT_EQ(image.at(4, 4, 0), of_red == 2 ? 1 : 0);
        EXPECT_EQ(image.at(4, 4, 2), of_red == 2 ? 0 : 1);
        EXPECT_EQ(image.at(4, 4, 1), 0);
    }
}

TEST_F(HostTransparents, ASurfaceHidesThem)
{
    const Scene scene = empty_scene(8);
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    HostPicture picture = picture_of(scene);
    picture.fill(glm::vec3(0), scene.camera.near, [](int x, int) { return x < 4 ? 4.0 : 6.0; });
    const HostPane at = as_hosts(pane(5, Kind::add));
    renderer.begin_transparents(view, picture.frame, plain_settings(), HostPanes::kLists);
    panes_.list(picture.frame, at.place, {1, 1, 1, 1}, at.blend, 0);
    renderer.end_transparents(view);
    renderer.composite(view, picture.frame, plain_settings());
    const Image image = picture.read();
    EXPECT_EQ(image.at(3, 4, 0), 0);
    EXPECT_EQ(image.at(4, 4, 0), 1);
}

TEST_F(HostTransparents, WhatDoesNotFitIsToldAndFitsTheNextFrame)
{
    constexpr int kLayers = 40, kSize = 16;
    const Scene scene = empty_scene(kSize);
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    const auto draw = [&] {
        HostPicture picture = picture_of(scene);
        renderer.begin_transparents(view, picture.frame, plain_settings(), HostPanes::kLists);
        for (int i = 0; i < kLayers; ++i) {
            const HostPane at = as_hosts(pane(4 + 0.01 * i, Kind::add));
            panes_.list(picture.frame, at.place, glm::vec4(0.25f), at.blend, unsigned(i));
        }
        renderer.end_transparents(view);
        renderer.composite(view, picture.frame, plain_settings());
        renderer.wait_until_ready();
        return picture.read();
    };
    constexpr std::uint64_t kAll = std::uint64_t{kLayers} * kSize * kSize;
    const Image first = draw();
    const FragmentCount lost = renderer.fragment_count();
    EXPECT_EQ(lost.fragments, kAll);
    EXPECT_GT(lost.lost, 0u);
    EXPECT_LT(first.at(8, 8, 0), 0.25f * kLayers);
    EXPECT_EQ(draw().at(8, 8, 0), 0.25f * kLayers);
    EXPECT_EQ(renderer.fragment_count(), (FragmentCount{kAll, 0}));
}

TEST_F(HostTransparents, ReadTransparentsAndShowLayersKnowThem)
{
    const Scene scene = fog_scene(8);
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    HostPicture picture = picture_of(scene);
    const auto list = [&] {
        renderer.begin_transparents(view, picture.frame, plain_settings(), HostPanes::kLists);
        draw(picture.frame, {pane(3, Kind::add), pane(2, Kind::multiply)});
        renderer.end_transparents(view);
    };
    EXPECT_TRUE(renderer.read_transparents(view, picture.frame, plain_settings()).kept.empty());
    list();
    renderer.composite(view, picture.frame, plain_settings());
    const TransparentImages images =
        renderer.read_transparents(view, picture.frame, plain_settings());
    ASSERT_EQ(images.added.size(), 3u * 64);
    for (std::size_t i = 0; i < images.added.size(); ++i)  // of a factor of what is behind, maybe
        ASSERT_EQ(images.kept[i], 0) << i;
    list();
    const InspectionLegend legend =
        renderer.inspect(view, picture.frame, plain_settings(), {.kind = Inspection::Kind::layers});
    EXPECT_EQ(legend.high, 2);
    // A frame that does without them has none of those.
    const Image with = picture.read();
    renderer.composite(view, picture.frame, plain_settings());
    EXPECT_TRUE(renderer.read_transparents(view, picture.frame, plain_settings()).kept.empty());
}

TEST_F(HostTransparents, APaneThatAHostShadesIsTheClosedForm)
{
    const glm::vec4 color(0.3f, 0.2f, 0.6f, 0.25f);
    for (const Settings& settings : modes()) {
        const Scene scene = fog_scene();
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        View view = renderer.make_view();
        for (const double depth : {3.0, 4.5, 5.7, 8.0})
            for (const unsigned blend : {0u, 1u, 2u, 3u}) {
                SCOPED_TRACE(testing::Message()
                             << depth << ", blend " << blend << ", mode " << int(settings.mode)
                             << ", 1/" << settings.resolution);
                HostPicture picture = picture_of(scene);
                const HostPanes::Place place = as_hosts(pane(depth, Kind::alpha)).place;
                picture.frame.transparents = {place.extent(picture.frame)};
                renderer.composite(view, picture.frame, settings);
                panes_.shade(picture.frame, view.volume_at(), place, color, blend);
                const auto truth = [&](glm::dvec2 at) {
                    const FogRay ray{ray_at(scene, at).length_per_z};
                    const glm::dvec3 behind = ray.behind(depth), own(color);
                    const glm::dvec3 in_front = blend == 0   ? own * 0.25 + behind * 0.75
                                                : blend == 1 ? own + behind * 0.75
                                                : blend == 2 ? own + behind
                                                             : behind * own;
                    return in_front * ray.passed(depth) + ray.glowed(depth);
                };
                const double exact = settings.resolution == 1 ? 3e-6 : 3e-4;
                EXPECT_TRUE(images_near(picture.read(), ideal(scene, truth), exact, exact,
                                        "roundings, and the layer's interpolation"));
            }
    }
}

TEST_F(HostTransparents, AHostsShaderLooksUpWhatTheListsDoInEveryVariant)
{
    // Grey and coloured, of either mode, of every size and of froxels that are smoothed: one
    // program.
    Settings smooth = plain_froxels(4), grey = plain_settings(2), grey_froxels = plain_froxels(2);
    smooth.lookup = Settings::Lookup::tricubic;
    grey.targets = Settings::Targets::mono;
    std::vector<Settings> all = modes();
    all.insert(all.end(), {smooth, grey, grey_froxels});
    for (const bool is_grey : {false, true})
        for (const Settings& settings : all) {
            SCOPED_TRACE(testing::Message() << "grey " << is_grey << ", mode " << int(settings.mode)
                                            << ", 1/" << settings.resolution);
            Scene scene = fog_scene();
            if (is_grey)
                std::get<BoxMedium>(scene.media[0]).sigma_a = glm::vec3(0.8f);
            QuadTransparent glass = pane(5, Kind::alpha);
            glass.edges[0].y = 1;
            glass.look.radiance = {0.3f, 0.2f, 0.6f};
            glass.look.alpha = 0.5f;
            scene.transparents = {glass};
            // With one that asks for what is behind it goes into lists: alone it is kept exactly by
            // each ray.
            QuadTransparent asks = glass;
            asks.look.radiance = glm::vec3(0);
            asks.look.blend = {Kind::factors, BlendFactor::dst_alpha, BlendFactor::one};
            scene.transparents.emplace_back(asks);
            const Image listed = composite(scene, settings, {});
            scene.transparents.clear();
            Renderer renderer(get_proc());
            renderer.set_scene(scene, settings);
            renderer.wait_until_ready();
            View view = renderer.make_view();
            HostPicture picture = picture_of(scene);
            const HostPane at = as_hosts(glass);
            picture.frame.transparents = {at.place.extent(picture.frame)};
            renderer.composite(view, picture.frame, settings);
            panes_.shade(picture.frame, view.volume_at(), at.place, at.color, 0);
            EXPECT_LT(max_difference(picture.read(), listed), 1e-6);
        }
}

TEST_F(HostTransparents, WithoutAMediumTheHostsShaderFindsNothing)
{
    const Scene scene = empty_scene(8);
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    HostPicture picture = picture_of(scene);
    picture.frame.transparents = {TransparentExtent{}};
    renderer.composite(view, picture.frame, plain_settings());
    panes_.shade(picture.frame, view.volume_at(), as_hosts(pane(5, Kind::alpha)).place,
                 {0.5f, 0.25f, 1, 0.5f}, 0);
    EXPECT_EQ(picture.read().at(4, 4, 0), 0.25f);
    EXPECT_EQ(picture.read().at(4, 4, 2), 0.5f);
}

TEST_F(HostTransparents, ViewsSideBySideHaveTheirOwn)
{
    const Scene scene = fog_scene(16);
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    renderer.wait_until_ready();
    const HostPane at = as_hosts(pane(5, Kind::add));
    const auto draw = [&](View& march, View& froxels, bool together) {
        HostPicture a = picture_of(scene), b = picture_of(scene);
        a.frame.transparents = b.frame.transparents = {at.place.extent(a.frame)};
        renderer.composite(march, a.frame, plain_settings());
        if (!together)
            panes_.shade(a.frame, march.volume_at(), at.place, glm::vec4(1), 2);
        renderer.composite(froxels, b.frame, plain_froxels());
        if (together)
            panes_.shade(a.frame, march.volume_at(), at.place, glm::vec4(1), 2);
        return a.read().pixels;
    };
    View march = renderer.make_view(), froxels = renderer.make_view();
    EXPECT_EQ(draw(march, froxels, true), draw(march, froxels, false));
}

TEST_F(HostTransparents, MistakesAreTold)
{
    const auto error_of = [](const auto& f) {
        try {
            f();
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string("none");
    };
    using testing::HasSubstr;
    const Settings settings = plain_settings();
    Renderer renderer(get_proc());
    renderer.set_scene(fog_scene(8), settings);
    View view = renderer.make_view();
    HostPicture picture = picture_of(fog_scene(8)), other = picture_of(fog_scene(16));
    const auto begin = [&](TransparentBindings bindings = HostPanes::kLists) {
        renderer.begin_transparents(view, picture.frame, settings, bindings);
    };
    EXPECT_THAT(error_of([&] { renderer.end_transparents(view); }),
                HasSubstr("call begin_transparents()"));
    EXPECT_THAT(error_of([&] { begin({.block = 4000}); }),
                HasSubstr("TransparentBindings: uniform block 4000 is none of the"));
    EXPECT_THAT(error_of([&] { begin({.first_buffer = 4294967295u}); }),
                HasSubstr("storage buffer 4294967295"));
    begin();
    EXPECT_THAT(error_of([&] { begin(); }), HasSubstr("call end_transparents() after them"));
    EXPECT_THAT(error_of([&] { renderer.composite(view, picture.frame, settings); }),
                HasSubstr("end_transparents() before composite()"));
    renderer.end_transparents(view);
    EXPECT_THAT(error_of([&] { renderer.composite(view, other.frame, settings); }),
                HasSubstr("a frame of 8 x 8, and composite() one of 16 x 16"));
    renderer.composite(view, picture.frame, settings);  // and nothing is stuck
    EXPECT_THAT(error_of([&] { static_cast<void>(view.volume_at()); }),
                HasSubstr("Frame::transparents"));
    picture.frame.transparents = {{.view_z = {2, 1}}};
    EXPECT_THAT(error_of([&] { renderer.composite(view, picture.frame, settings); }),
                HasSubstr("from view_z 2 to 1 m"));
}

}  // namespace
}  // namespace fumarole::test
