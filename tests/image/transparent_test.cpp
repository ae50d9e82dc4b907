// Transparents through the media: closed forms of a fog that glows, the reference, and what must
// change nothing at all.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <random>

#include "fog_panes.h"
#include "host_picture.h"
#include "image_test.h"
#include "study/metrics.h"
#include "study/reference.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

class Transparents : public ImageTest {
protected:
    static Image composite(const Scene& scene, const Settings& settings)
    {
        const Still still = render(scene, settings);
        return picture_of(still, still.composite);
    }
    /// Light that scatters once.
    static study::ReferenceStill reference_of(const Scene& scene, double tolerance)
    {
        study::ReferenceOptions options;
        options.tolerance = tolerance;
        return study::render_reference(scene, options);
    }
    /// What is in pieces, and in lists, between whose depths a march interpolates.
    static void expect_as_in_lists(const Image& in_pieces, const Image& listed,
                                   const Image& without, const Settings& settings)
    {
        const double exact = settings.mode == Settings::Mode::froxel ? 5e-6 : 1e-3;
        EXPECT_TRUE(images_near(in_pieces, listed, exact, exact / 5, "lists' depths"));
        EXPECT_GT(max_difference(in_pieces, without), 0.15) << "to be seen";
    }
    /// Fog with a box in it.
    static Scene box_scene()
    {
        Scene scene = sprite_scene(1, 47);
        scene.transparents.clear();
        return scene;
    }
    static std::vector<Settings> modes()
    {
        return {plain_settings(1), plain_settings(2), plain_settings(4), plain_froxels(1)};
    }
};

TEST_F(Transparents, APaneOfEachBlendInUniformFogIsTheClosedForm)
{
    const glm::vec3 radiance(0.3f, 0.2f, 0.6f), filter(0.5f, 1, 0.25f);
    const float alpha = 0.25f;
    for (const Settings& settings : modes())
        for (const double depth : {3.0, 4.5, 5.7, 8.0})
            for (const Kind kind : {Kind::alpha, Kind::premultiplied, Kind::add, Kind::multiply}) {
                SCOPED_TRACE(testing::Message()
                             << depth << ", blend " << int(kind) << ", mode " << int(settings.mode)
                             << ", 1/" << settings.resolution);
                Scene scene = fog_scene();
                QuadTransparent quad = pane(depth, kind);
                quad.look.radiance = radiance;
                quad.look.filter = filter;
                quad.look.alpha = alpha;
                scene.transparents = {quad};
                const auto truth = [&](glm::dvec2 at) {
                    const FogRay ray{ray_at(scene, at).length_per_z};
                    const glm::dvec3 behind = ray.behind(depth), own(radiance);
                    const glm::dvec3 in_front = kind == Kind::alpha ? own * 0.25 + behind * 0.75
                                                : kind == Kind::premultiplied ? own + behind * 0.75
                                                : kind == Kind::add           ? own + behind
                                                                    : behind * glm::dvec3(filter);
                    return in_front * ray.passed(depth) + ray.glowed(depth);
                };
                // Values of about 1 in 32 bits; smaller layers are interpolated, as extinction_test
                // says.
                const double exact = settings.resolution == 1 ? 3e-6 : 3e-4;
                EXPECT_TRUE(images_near(composite(scene, settings), ideal(scene, truth), exact,
                                        exact, "roundings, and the layer's interpolation"));
            }
}

TEST_F(Transparents, EveryPairOfFactorsIsOpenGLs)
{
    const double depth = 5;
    const glm::dvec4 source(0.25, 0.5, 1.5, 0.75);
    const int size = 8;
    for (const Settings& settings : {plain_settings(1), plain_froxels(1)})
        for (int s = 0; s <= int(BlendFactor::src_alpha_saturate); ++s)
            for (int d = 0; d <= int(BlendFactor::src_alpha_saturate); ++d) {
                SCOPED_TRACE(testing::Message() << s << ", " << d);
                Scene scene = fog_scene(size);
                QuadTransparent quad = pane(depth, Kind::factors);
                quad.look.blend.source = static_cast<BlendFactor>(s);
                quad.look.blend.destination = static_cast<BlendFactor>(d);
                quad.look.radiance = glm::vec3(source);
                quad.look.alpha = 0.75f;
                scene.transparents = {quad};
                const auto truth = [&](glm::dvec2 at) {
                    const FogRay ray{ray_at(scene, at).length_per_z};
                    const glm::dvec4 behind(ray.behind(depth), 1);
                    const auto factor = [&](int name) -> glm::dvec4 {
                        const std::array<glm::dvec4, 11> all{glm::dvec4(0),
                                                             glm::dvec4(1),
                                                             source,
                                                             1.0 - source,
                                                             behind,
                                                             1.0 - behind,
                                                             glm::dvec4(source.a),
                                                             glm::dvec4(1 - source.a),
                                                             glm::dvec4(1),
                                                             glm::dvec4(0),
                                                             glm::dvec4(0, 0, 0, 1)};
                        return all.at(static_cast<std::size_t>(name));
                    };
                    const glm::dvec3 in_front(source * factor(s) + behind * factor(d));
                    return in_front * ray.passed(depth) + ray.glowed(depth);
                };
                EXPECT_TRUE(images_near(composite(scene, settings), ideal(scene, truth), 1e-5, 1e-5,
                                        "roundings, squared where what is behind is a factor"));
            }
}

/// Panes that no one sees, at any depths.
std::vector<Transparent> invisible(int count, std::uint32_t seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> depth(0.5, 9), tilt(-1.5, 1.5);
    std::vector<Transparent> all;
    for (int i = 0; i < count; ++i) {
        QuadTransparent quad = pane(depth(random), static_cast<Kind>(i % 4));
        quad.edges[0].y = tilt(random);
        quad.edges[1].y = tilt(random);
        quad.look.alpha = 0;
        quad.look.radiance = i % 4 == 0 ? glm::vec3(5) : glm::vec3(0);  // alpha hides it
        all.emplace_back(quad);
    }
    return all;
}

TEST_F(Transparents, InvisibleOnesChangeNoBitAtAnyDepthInAnyOrder)
{
    Scene scene = fog_scene();
    scene.surfaces = {SphereSurface{{0.3, -5, 0.2}, 0.5, glm::vec3(0.5f)}};
    for (Settings settings : modes())
        for (const Settings::Format format :
             {Settings::Format::rgba32f, Settings::Format::rgba16f}) {
            settings.format = format;
            scene.transparents.clear();
            const Image without = composite(scene, settings);
            for (const int count : {1, 2, 7, 64}) {
                SCOPED_TRACE(testing::Message() << count << " panes, mode " << int(settings.mode));
                scene.transparents = invisible(count, static_cast<std::uint32_t>(count));
                EXPECT_EQ(composite(scene, settings).pixels, without.pixels);
            }
        }
}

TEST_F(Transparents, TheWrongWaysShowTheirFaults)
{
    // One accumulator loses light that is scattered in behind a pane that no one sees; two add what
    // a pane emits twice.
    Scene scene = fog_scene();
    for (const Settings& right : {plain_settings(1), plain_froxels(1)}) {
        Settings single = right, doubled = right;
        single.transparency = Settings::Transparency::single;
        doubled.transparency = Settings::Transparency::doubled;
        scene.transparents.clear();
        const Image without = composite(scene, right);
        scene.transparents = {pane(5, Kind::add)};
        EXPECT_LT(composite(scene, single).at(16, 16, 1), without.at(16, 16, 1) - 0.05f);
        EXPECT_LT(max_difference(composite(scene, doubled), without), 1e-5);
        QuadTransparent bright = pane(5, Kind::add);
        bright.look.radiance = glm::vec3(0.5f);
        scene.transparents = {bright};
        EXPECT_GT(composite(scene, doubled).at(16, 16, 1),
                  composite(scene, right).at(16, 16, 1) + 0.1f);
    }
}

TEST_F(Transparents, ShuffledEqualSortedBitForBit)
{
    for (const bool reads_picture : {false, true})
        for (const Settings& settings : modes()) {
            Scene scene = fog_scene();
            scene.transparents = crossing(reads_picture);
            const Image sorted = composite(scene, settings);
            std::mt19937 random(3);
            for (int turn = 0; turn < 3; ++turn) {
                std::shuffle(scene.transparents.begin(), scene.transparents.end(), random);
                EXPECT_EQ(composite(scene, settings).pixels, sorted.pixels)
                    << "mode " << int(settings.mode) << ", 1/" << settings.resolution;
            }
        }
}

TEST_F(Transparents, TheLaterOfTwoAtOneDepthIsInFront)
{
    Scene scene = empty_scene(8);
    QuadTransparent red = pane(5, Kind::alpha), blue = red;
    red.look.radiance = {1, 0, 0};
    blue.look.radiance = {0, 0, 1};
    scene.transparents = {red, blue};
    EXPECT_EQ(pixel(render(scene, plain_settings()).composite, 8, 4, 4), glm::vec3(0, 0, 1));
    scene.transparents = {blue, red};
    EXPECT_EQ(pixel(render(scene, plain_settings()).composite, 8, 4, 4), glm::vec3(1, 0, 0));
}

TEST_F(Transparents, AnOpticalDepthOfTenThousandLeavesNoTraceOfAPaneBehindIt)
{
    for (const Settings& settings : modes()) {
        Scene scene = fog_scene();
        std::get<BoxMedium>(scene.media[0]).sigma_a = glm::vec3(5e3f);
        std::get<BoxMedium>(scene.media[0]).emission = glm::vec3(5e3f);
        const Image without = composite(scene, settings);
        QuadTransparent deep = pane(5.5, Kind::factors);
        deep.look.blend = {Kind::factors, BlendFactor::dst_color, BlendFactor::one_minus_dst_color};
        deep.look.radiance = glm::vec3(100);
        for (const BlendFactor destination : {BlendFactor::one_minus_dst_color, BlendFactor::one}) {
            deep.look.blend.destination = destination;  // in lists, and in order
            scene.transparents = {deep, pane(8, Kind::alpha), pane(5.9, Kind::multiply)};
            const Image with = composite(scene, settings);
            for (const float value : with.pixels)
                ASSERT_TRUE(std::isfinite(value));
            EXPECT_LT(max_difference(with, without), 1e-5)
                << "mode " << int(settings.mode) << ", 1/" << settings.resolution;
        }
        QuadTransparent front = pane(3, Kind::alpha);
        front.look.radiance = {0.25f, 0.5f, 0.75f};
        scene.transparents = {front};
        EXPECT_NEAR(composite(scene, settings).at(16, 16, 1), 0.5, 1e-6);
    }
}

/// Crossing panes of every blend, a picture and a mesh, in light that is scattered.
Scene smoky_scene()
{
    Scene scene = empty_scene(48);
    GridMedium smoke;
    glm::dmat4 place(0.12);
    place[3] = {-1, -6, -1, 1};
    smoke.density = lump(place);
    smoke.sigma_s_per_density = {2.0f, 2.5f, 3.0f};
    smoke.sigma_a_per_density = {0.2f, 0.3f, 0.4f};
    smoke.g = 0.3f;
    scene.media.emplace_back(smoke);
    scene.world.radiance = {0.3f, 0.25f, 0.2f};
    scene.lights = {SunLight{glm::normalize(glm::dvec3(1, 0.5, 1)), glm::vec3(4)}};
    scene.surfaces = {BoxSurface{{-9, -9, -9}, {9, -7.2, 9}, glm::vec3(0.5f)},
                      SphereSurface{{-0.4, -4.4, -0.4}, 0.25, glm::vec3(0.7f)}};
    const auto quad = [&](glm::dvec3 corner, glm::dvec3 across, Kind kind) -> TransparentLook& {
        QuadTransparent one;
        one.corner = corner;
        one.edges = {across, glm::dvec3(0, 0, 1.2)};
        one.look.blend.kind = kind;
        scene.transparents.emplace_back(one);
        return look_of(scene.transparents.back());
    };
    TransparentLook& glass = quad({0.7, -4.4, -0.6}, {-1.2, -1.2, 0}, Kind::alpha);
    glass.radiance = {0.05f, 0.22f, 0.3f};
    glass.alpha = 0.45f;
    quad({-0.7, -4.5, -0.7}, {1.3, -1.1, 0}, Kind::multiply).filter = {0.85f, 0.45f, 0.25f};
    TransparentLook& light = quad({0.5, -5.2, -0.3}, {-0.9, -2.4, 0}, Kind::add);
    light.radiance = {0.12f, 0.09f, 0.03f};
    light.depth_fade = 0.4f;

    auto image = std::make_shared<TransparentImage>();
    image->width = image->height = 4;
    for (int i = 0; i < 16; ++i) {
        const float alpha = float(i % 4) / 4;
        image->texels.emplace_back(glm::vec3(0.5f, 0.25f * float(i / 4), 0.5f) * alpha, alpha);
    }
    BillboardTransparent board;
    board.center = {0.2, -5.1, 0.3};
    board.size = {0.8, 0.6};
    board.look.image = image;
    scene.transparents.emplace_back(board);

    auto mesh = std::make_shared<Mesh>();
    mesh->positions = {
        {-0.9f, -5, 0}, {0.1f, -4.6f, 0.1f}, {-0.3f, -5.4f, 0.8f}, {0.4f, -5.3f, 0.4f}};
    mesh->normals.assign(4, glm::vec3(0, 0, 1));
    mesh->triangles = {0, 1, 2, 1, 3, 2};
    MeshTransparent sheet;
    sheet.mesh = mesh;
    sheet.look.blend.kind = Kind::premultiplied;
    sheet.look.radiance = {0.1f, 0.1f, 0.02f};
    sheet.look.alpha = 0.3f;
    scene.transparents.emplace_back(sheet);
    return scene;
}

TEST_F(Transparents, AllKindsInSmokeAreTheReference)
{
    const Scene scene = smoky_scene();
    // To 0.3 % of a pixel it errs by a fiftieth of the least bound, in a third of the time.
    const study::ReferenceStill truth = reference_of(scene, 3e-3);
    struct Case {
        const char* name;
        Settings settings;
        double bound;
    };
    Settings froxel = find_preset("froxel"), half;
    half.bounces = froxel.bounces = 0;
    Settings full = half;
    full.resolution = 1;
    half.resolution = 2;
    for (const Case& one :
         {Case{"half", half, 5e-4}, Case{"full", full, 5e-4}, Case{"froxel", froxel, 3e-3}}) {
        const Still still = render(scene, one.settings);
        const double error = study::compare(still.composite, truth.composite).relmse;
        figure(one.name, error);
        EXPECT_LT(error, one.bound) << one.name;
    }
}

TEST_F(Transparents, CrossingPanesInTheSmokeOfS2AreTheReference)
{
    const fs::path file = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference" / "S2.json";
    if (!fs::exists(file))
        GTEST_SKIP() << "no reference scenes: " << file << " is not there";
    Scene scene = asset::load_scene(file).scene;
    scene.resolution = {64, 36};
    QuadTransparent glass, filter, glow, sheet;
    glass.corner = {-2.2, -1, 0.6};
    glass.edges = {glm::dvec3(2.6, 0.9, 0), glm::dvec3(0, 0, 3.6)};
    glass.look.radiance = {0.05f, 0.22f, 0.3f};
    glass.look.alpha = 0.45f;
    filter.corner = {-1.6, 0.9, 1};
    filter.edges = {glm::dvec3(3.2, -1.6, 0), glm::dvec3(0, 0, 3)};
    filter.look.blend.kind = Kind::multiply;
    filter.look.filter = {0.85f, 0.45f, 0.25f};
    glow.corner = {-0.6, -0.3, 1.6};
    glow.edges = {glm::dvec3(2.4, 0.2, 0), glm::dvec3(0, 0.4, 2.6)};
    glow.look.blend.kind = Kind::add;
    glow.look.radiance = {0.12f, 0.09f, 0.03f};
    sheet.corner = {-2.6, 2, 2.4};
    sheet.edges = {glm::dvec3(5, 0, 0), glm::dvec3(0, 0, 2.2)};
    sheet.look.blend.kind = Kind::premultiplied;
    sheet.look.radiance = {0.1f, 0.1f, 0.02f};
    sheet.look.alpha = 0.3f;
    scene.transparents = {glass, filter, glow, sheet};
    // Of pixels' centres, in so small a picture, surfaces' edges alone make up 2e-3; they are all
    // that there is to see, and the panes are to add nothing to it. (At 480x270 in 8 frames it is
    // X.)
    const auto error = [&](const Scene& seen, const Settings& settings) {
        return study::compare(render(seen, settings).composite, reference_of(seen, 1e-2).composite)
            .relmse;
    };
    Scene plain = scene;
    plain.transparents.clear();
    Settings settings;
    settings.bounces = 0;
    const double without = error(plain, settings), with = error(scene, settings);
    figure("without", without);
    figure("with", with);
    EXPECT_LT(with, 1.1 * without);
}

class TransparentLayers : public Transparents, public testing::WithParamInterface<int> {};

/// In lists, in order at the depths of each, in order, and in pieces.
INSTANTIATE_TEST_SUITE_P(Ways, TransparentLayers, testing::Values(0, 8, 24, 7));

TEST_P(TransparentLayers, MakeUpTheComposite)
{
    Scene scene = smoky_scene();
    if (GetParam() > 0)
        scene.transparents = GetParam() == 7 ? crossing_cards() : sprites(GetParam());
    Settings settings;
    settings.format = Settings::Format::rgba32f;
    settings.bounces = 0;
    StillOptions options;
    options.foreground = true;
    const Still still = scene_renderer().render(scene, settings, options);
    double worst = 0, cover = 0;
    for (std::size_t i = 0; i < still.composite.size(); ++i) {
        const float behind = still.surface_lit[i] * still.transmittance[i] + still.scattering[i];
        worst = std::max(
            worst, std::abs(double(still.composite[i]) -
                            double(behind * still.transparents_kept[i] + still.transparents[i])));
    }
    // No sky is seen: the foreground is the composite, and hides all.
    for (std::size_t i = 0; i < still.depth.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            cover = std::max(
                {cover,
                 std::abs(double(still.foreground[4 * i + c]) - double(still.composite[3 * i + c])),
                 std::abs(double(still.foreground[4 * i + 3]) - 1)});
    EXPECT_EQ(scene_renderer().renderer().fragment_count().fragments == 0, GetParam() > 0);
    EXPECT_LT(worst, 1e-6);
    EXPECT_LT(cover, 1e-6);
}

TEST_F(Transparents, APaneBeforeTheSkyIsPartOfTheForeground)
{
    Scene scene = empty_scene(8);
    scene.world.radiance = kSky;
    QuadTransparent quad = pane(5, Kind::alpha);
    quad.look.radiance = {1, 0.5f, 0.25f};
    quad.look.alpha = 0.5f;
    scene.transparents = {quad};
    StillOptions options;
    options.foreground = true;
    const Still still = scene_renderer().render(scene, plain_settings(), options);
    const std::array<float, 4> expected{0.5f, 0.25f, 0.125f, 0.5f};
    for (std::size_t c = 0; c < 4; ++c)
        EXPECT_NEAR(still.foreground.at(c), expected.at(c), 1e-6f);
}

TEST_F(Transparents, ShowLayersCountsThem)
{
    Scene scene = fog_scene();
    for (const double depth : {3.0, 4.0, 5.0, 5.5, 7.0})
        scene.transparents.emplace_back(pane(depth, Kind::add));
    for (const Settings& settings : plain_siblings()) {
        const InspectionStill still =
            scene_renderer().inspect(scene, settings, {.kind = Inspection::Kind::layers});
        EXPECT_EQ(still.legend.low, 0);
        EXPECT_EQ(still.legend.high, 10);  // the round number above 5
        EXPECT_TRUE(still.legend.false_color);
    }
}

/// Sheets behind each other in one mesh, whose outline says nothing of how many they are.
MeshTransparent sheets(int count)
{
    auto mesh = std::make_shared<Mesh>();
    for (int i = 0; i < count; ++i) {
        const float y = -4 - 0.01f * float(i);
        const auto first = static_cast<std::uint32_t>(mesh->positions.size());
        mesh->positions.insert(mesh->positions.end(),
                               {{-9, y, -9}, {9, y, -9}, {9, y, 9}, {-9, y, 9}});
        mesh->triangles.insert(mesh->triangles.end(),
                               {first, first + 1, first + 2, first, first + 2, first + 3});
    }
    mesh->normals.assign(mesh->positions.size(), glm::vec3(0, 1, 0));
    MeshTransparent all;
    all.mesh = mesh;
    all.look.blend.kind = Kind::add;
    all.look.radiance = glm::vec3(0.25f);
    return all;
}

TEST_F(Transparents, WhatDoesNotFitIsToldAndFitsTheNextFrame)
{
    constexpr int kSheets = 40, kSize = 16;
    Scene scene = empty_scene(kSize);
    scene.transparents = {sheets(kSheets)};
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    HostPicture picture(gl(), glm::ivec2(kSize));
    picture.look(scene.camera);
    const auto draw = [&] {
        picture.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        renderer.composite(view, picture.frame, plain_settings());
        renderer.wait_until_ready();
        return picture.read();
    };
    constexpr std::uint64_t kAll = std::uint64_t{kSheets} * kSize * kSize;
    const Image first = draw();
    const FragmentCount lost = renderer.fragment_count();
    EXPECT_EQ(lost.fragments, kAll);
    EXPECT_GT(lost.lost, 0u);
    EXPECT_LT(first.at(8, 8, 0), 0.25f * kSheets);
    EXPECT_GT(first.at(8, 8, 0), 0.0f);
    const Image second = draw();
    EXPECT_EQ(renderer.fragment_count(), (FragmentCount{kAll, 0}));
    EXPECT_EQ(second.at(8, 8, 0), 0.25f * kSheets);
    // And a still has all of them at once.
    EXPECT_EQ(pixel(render(scene, plain_settings()).composite, kSize, 3, 3).x, 0.25f * kSheets);
}

TEST_F(Transparents, FourMillionFragmentsAreDrawnWithoutLoss)
{
    constexpr int kSheets = 32;
    Scene scene = empty_scene(8);
    scene.resolution = {480, 270};
    scene.transparents = {sheets(kSheets)};
    const Still still = render(scene, plain_settings());
    constexpr std::uint64_t kAll = std::uint64_t{kSheets} * 480 * 270;
    EXPECT_EQ(scene_renderer().renderer().fragment_count(), (FragmentCount{kAll, 0}));
    for (const float value : still.composite)
        ASSERT_EQ(value, 0.25f * kSheets);
}

TEST_F(Transparents, PanesInOrderAreWhatListsMakeOfThem)
{
    Scene scene = fog_scene(33);
    scene.surfaces = {BoxSurface{{-0.5, -5.4, -9}, {0.7, -4.6, -0.3}, glm::vec3(0.5f)}};
    // Their planes cross, and they don't: three upright ones, and two above each other.
    QuadTransparent front = pane(4.4, Kind::alpha), middle = pane(5, Kind::multiply),
                    last = pane(5.7, Kind::add), low, high;
    front.corner = {1, -4.4, -1};
    front.edges = {glm::dvec3(-1.7, -0.3, 0), glm::dvec3(0.2, 0, 1.6)};
    front.look.alpha = 0.5f;
    front.look.radiance = {0.5f, 0.25f, 1};
    middle.look.filter = {0.5f, 1, 0.25f};
    last.corner.x = 0.6;
    last.look.radiance = {1, 0.5f, 0.25f};
    low.corner = {-0.6, -6, -0.6};
    low.edges = {glm::dvec3(1.3, 0, 0), glm::dvec3(0, 0.8, 0)};
    low.look = front.look;
    high = low;
    high.corner.z = 0.9;
    scene.transparents = {middle, low, front, high, last};
    const Scene listed = in_lists(scene);
    for (Settings settings : modes()) {
        settings.splits = 64;  // between which lists interpolate, over the fog's faces too
        SCOPED_TRACE(testing::Message()
                     << "mode " << int(settings.mode) << ", 1/" << settings.resolution);
        const double exact = settings.mode == Settings::Mode::froxel ? 3e-6 : 1e-3;
        EXPECT_TRUE(images_near(composite(scene, settings), composite(listed, settings), exact,
                                exact / 5, "the depths of the lists"));
    }
}

TEST_F(Transparents, SpritesInOrderAreWhatListsMakeOfThem)
{
    for (const bool is_parallel : {false, true})
        for (const int count : {8, 24})
            for (Settings settings : modes()) {
                Scene scene = sprite_scene(count);
                if (is_parallel) {
                    scene.camera.projection = Camera::Projection::orthographic;
                    scene.camera.ortho_height = 3;
                }
                settings.splits = 64;
                SCOPED_TRACE(testing::Message()
                             << count << ", mode " << int(settings.mode) << ", 1/"
                             << settings.resolution << (is_parallel ? ", orthographic" : ""));
                const Image listed = composite(in_lists(scene), settings);
                EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u);
                const Image in_order = composite(scene, settings);
                EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
                // Of no more than eight that face the eye a march keeps what it met at the depth of
                // each; else at the depths that lists have: then all that is left are roundings.
                const bool interpolates = settings.mode != Settings::Mode::froxel && count <= 8;
                const double exact = interpolates ? 1e-3 : 5e-6;
                EXPECT_TRUE(images_near(in_order, listed, exact, exact / 5, "lists' depths"));
                scene.transparents.clear();
                EXPECT_GT(max_difference(in_order, composite(scene, settings)), 0.3);
            }
}

/// An octahedron, whose triangles wind either way.
std::shared_ptr<Mesh> gem(bool clockwise)
{
    auto mesh = std::make_shared<Mesh>();
    mesh->positions = {{0.7f, 0, 0},  {-0.7f, 0, 0}, {0, 0.5f, 0},
                       {0, -0.5f, 0}, {0, 0, 0.6f},  {0, 0, -0.6f}};
    mesh->normals.assign(6, glm::vec3(0, 0, 1));
    for (std::uint32_t i = 0; i < 8; ++i) {
        const std::uint32_t x = i & 1, y = 2 + (i >> 1 & 1), z = 4 + (i >> 2);
        if (((i ^ i >> 1 ^ i >> 2) % 2 == 0) == clockwise)
            mesh->triangles.insert(mesh->triangles.end(), {x, z, y});
        else
            mesh->triangles.insert(mesh->triangles.end(), {x, y, z});
    }
    return mesh;
}

/// Such a gem amid sprites, between the nearest and the card.
Scene gem_scene(bool clockwise)
{
    Scene scene = sprite_scene(4);
    for (std::size_t i = 0; i < 3; ++i)
        std::get<BillboardTransparent>(scene.transparents.at(i)).center.y = i < 2 ? -3.5 : -6.2;
    MeshTransparent glass;
    glass.mesh = gem(clockwise);
    glass.translate = {0.1, -5.1, 0.35};
    glass.look.alpha = 0.4f;
    glass.look.radiance = {0.1f, 0.3f, 0.2f};
    glass.look.depth_fade = 0.2f;
    scene.transparents.emplace_back(glass);
    return scene;
}

TEST_F(Transparents, AConvexMeshIsInOrderAndIsWhatListsMakeOfIt)
{
    for (const bool is_parallel : {false, true})
        for (const bool clockwise : {false, true})
            for (const Settings& settings : modes()) {
                Scene scene = gem_scene(clockwise);
                if (is_parallel) {
                    scene.camera.projection = Camera::Projection::orthographic;
                    scene.camera.ortho_height = 3;
                }
                SCOPED_TRACE(testing::Message() << "mode " << int(settings.mode) << ", 1/"
                                                << settings.resolution << ", " << clockwise);
                const Image in_order = composite(scene, settings);
                EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
                const Image of_lists = composite(in_lists(scene, 3.5), settings);
                EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u);
                EXPECT_TRUE(images_near(in_order, of_lists, 1e-5, 1e-6, "roundings"));
            }
}

TEST_F(Transparents, ConvexMeshesAskewAreInOrderByTheirBoxes)
{
    // Their depths overlap; a plane between their boxes tells.
    Scene scene = gem_scene(false);
    scene.camera.look_at = {1, -1, 0};
    MeshTransparent near = std::get<MeshTransparent>(scene.transparents.back()), far = near;
    near.translate = {3.6, -3.6, 0};
    far.translate = {3.6, -4.7, 0};
    far.look.radiance = {1, 0.1f, 0.5f};
    scene.transparents = {near, far};
    const Settings settings = plain_froxels();
    const Image in_order = composite(scene, settings);
    EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
    QuadTransparent asks;  // beside both, and not seen
    asks.corner = {1, -1, -1};
    asks.edges = {glm::dvec3(0, 0, 2), glm::dvec3(0.1, 0.1, 0)};
    asks.look.blend = {Kind::factors, BlendFactor::dst_alpha, BlendFactor::one};
    scene.transparents.emplace_back(asks);
    const Image listed = composite(scene, settings);
    EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u);
    EXPECT_TRUE(images_near(in_order, listed, 1e-5, 1e-6, "roundings"));
    std::get<MeshTransparent>(scene.transparents.at(1)).translate.y = -4.2;
    scene.transparents.pop_back();
    composite(scene, settings);
    EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u) << "no plane between";
}

TEST_F(Transparents, AConvexMeshInAHostsMirroredPictureIsWhatListsMakeOfIt)
{
    const Settings settings = plain_settings();
    const auto draw = [&](const Scene& scene) {
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        View view = renderer.make_view();
        HostPicture picture(gl(), glm::ivec2(33));
        picture.look(scene.camera);
        picture.frame.clip_from_view[1][1] *= -1;
        for (int i = 0; i < 2; ++i) {  // of which the second has room for all in lists
            picture.fill(glm::vec3(0.5f), scene.camera.near, [](int, int) { return 0.0; });
            renderer.composite(view, picture.frame, settings);
            renderer.wait_until_ready();
        }
        return picture.read();
    };
    Scene scene = gem_scene(false);
    const Image in_order = draw(scene);
    EXPECT_TRUE(images_near(in_order, draw(in_lists(scene, 3.5)), 1e-5, 1e-6, "roundings"));
    scene.transparents.pop_back();
    EXPECT_GT(max_difference(in_order, draw(scene)), 0.1);
}

TEST_F(Transparents, AMeshThatIsNotConvexOrIsCrossedTakesLists)
{
    const Settings settings = plain_froxels();
    const auto fragments = [&](const Scene& scene) {
        composite(scene, settings);
        return scene_renderer().renderer().fragment_count().fragments;
    };
    Scene scene = gem_scene(false);
    EXPECT_EQ(fragments(scene), 0u);
    std::get<BillboardTransparent>(scene.transparents.at(0)).center = {0, -5.1, 0.3};
    EXPECT_GT(fragments(scene), 0u) << "a card in the gem";
    scene = gem_scene(false);
    const auto dent = [&](const auto& change) {
        auto mesh = std::make_shared<Mesh>(*gem(false));
        change(*mesh);
        std::get<MeshTransparent>(scene.transparents.back()).mesh = mesh;
        return fragments(scene);
    };
    EXPECT_GT(dent([](Mesh& mesh) { mesh.positions[4].z = -0.2f; }), 0u) << "a dent";
    EXPECT_GT(dent([](Mesh& mesh) { std::swap(mesh.triangles[0], mesh.triangles[1]); }), 0u)
        << "a triangle that winds the other way";
    EXPECT_EQ(dent([](Mesh& mesh) { mesh.triangles.resize(12); }), 0u) << "half of it";
}

TEST_F(Transparents, WhatLiesFlatIsInASmallerLayerWhatItIsInOneAsLargeAsThePicture)
{
    // Between two rays of it lies a metre of its depth, over which the fog dims by more than half.
    // Beside a surface a pixel takes one ray's.
    Scene scene = fog_scene(33);
    scene.surfaces = {BoxSurface{{-0.3, -5.4, -9}, {0.3, -4.6, -0.3}, glm::vec3(0.5f)}};
    QuadTransparent water = pane(5, Kind::alpha);
    water.corner = {4, 3, -0.95};
    water.edges = {glm::dvec3(-8, 0, 0), glm::dvec3(0, -11, 0)};
    water.look.alpha = 0.75f;
    water.look.radiance = {0.3f, 0.2f, 0.6f};
    scene.transparents = {water};
    const auto of_panes = [&](int resolution) {
        Settings settings = plain_settings(resolution);
        settings.splits = 64;
        const Still still = render(scene, settings);
        return picture_of(still, still.transparents);
    };
    const Image large = of_panes(1);
    for (const int resolution : {2, 4})
        EXPECT_TRUE(images_near(of_panes(resolution), large, 5e-3, 1e-3,
                                "the layer's and the depths' interpolation"));
}

TEST_F(Transparents, TheLaterOfSpritesAtOneDepthIsInFrontWhicheverWayTheEyeLooks)
{
    for (const glm::dvec3 toward : {glm::dvec3(0.3, -1, 0.2), {-0.7, 0.4, 0.1}, {0.1, 0.2, -0.9}}) {
        Scene scene = sprite_scene(8);
        scene.camera.look_at = toward;
        const std::vector<Transparent> kinds = scene.transparents;
        scene.transparents.clear();
        const glm::dvec3 forward = glm::normalize(toward);
        const glm::dvec3 across = glm::normalize(glm::cross(forward, scene.camera.up));
        for (std::size_t i = 0; i < 6; ++i) {
            auto board = std::get<BillboardTransparent>(kinds.at(i));
            board.center = 5.0 * forward + (0.1 * double(i * 5 % 6) - 0.25) * across;
            scene.transparents.emplace_back(board);
        }
        const Settings settings = plain_froxels();
        const Image in_order = composite(scene, settings);
        EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
        Scene listed = scene;
        BillboardTransparent asks;  // for what is behind it, and is not seen
        asks.center = 3.0 * forward;
        asks.size = glm::dvec2(9);
        asks.look.blend = {Kind::factors, BlendFactor::dst_alpha, BlendFactor::one};
        listed.transparents.emplace_back(asks);
        EXPECT_TRUE(images_near(in_order, composite(listed, settings), 5e-6, 1e-6, "roundings"));
        EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u);
        std::reverse(scene.transparents.begin(), scene.transparents.end());
        EXPECT_GT(max_difference(composite(scene, settings), in_order), 0.05);
    }
}

TEST_F(Transparents, SpritesThatCrossAreInPiecesWhatListsMakeOfThem)
{
    for (const bool is_parallel : {false, true})
        for (Settings settings : modes())
            for (const std::size_t count : {2, 3, 7}) {
                settings.splits = 64;
                Scene scene = box_scene(), without = scene;
                scene.transparents = crossing_cards();
                scene.transparents.erase(scene.transparents.begin(),
                                         scene.transparents.end() - count);
                if (is_parallel) {
                    scene.camera.projection = Camera::Projection::orthographic;
                    scene.camera.ortho_height = 3;
                }
                without.camera = scene.camera;
                SCOPED_TRACE(testing::Message()
                             << count << ", mode " << int(settings.mode) << ", 1/"
                             << settings.resolution << (is_parallel ? ", orthographic" : ""));
                const Image listed = composite(in_lists(scene), settings);
                EXPECT_GT(scene_renderer().renderer().fragment_count().fragments, 0u);
                const Image in_pieces = composite(scene, settings);
                EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
                expect_as_in_lists(in_pieces, listed, composite(without, settings), settings);
            }
}

TEST_F(Transparents, ARingOfSpritesIsInPiecesWhatListsMakeOfIt)
{
    // Each passes before the next. Leaning along itself, no plane tells that of another; else each
    // lies wholly behind the plane of the one before.
    const std::vector<Transparent> looks = sprites(10);
    for (const double lean : {0.0, 1.05}) {
        Scene scene = box_scene();
        const Scene without = scene;
        for (int i = 0; i < 3; ++i) {
            const double turn = 2.0943951 * i + 0.2;
            const glm::dvec3 along(std::cos(turn), 0, std::sin(turn)), side(-along.z, 0, along.x);
            const glm::dvec3 away(0, -0.5, 0);
            const glm::dvec3 a = along + std::cos(lean) * away, b = side + std::sin(lean) * away;
            QuadTransparent plank;
            plank.corner = glm::dvec3(0, -5, 0.2) - 1.2 * a + 0.25 * b;
            plank.edges = {2.4 * a, 0.45 * b};
            plank.look = look_of(looks.at(static_cast<std::size_t>(3 * i)));
            scene.transparents.emplace_back(plank);
        }
        for (Settings settings : modes()) {
            settings.splits = 64;
            const Image listed = composite(in_lists(scene, 5), settings);
            const Image in_pieces = composite(scene, settings);
            EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{}) << lean;
            expect_as_in_lists(in_pieces, listed, composite(without, settings), settings);
        }
    }
}

TEST_F(Transparents, InvisibleSpritesInPiecesChangeNoBit)
{
    for (Settings settings : modes())
        for (const Settings::Format format :
             {Settings::Format::rgba32f, Settings::Format::rgba16f}) {
            settings.format = format;
            Scene scene = box_scene();
            const Image without = composite(scene, settings);
            scene.transparents = crossing_cards(false);
            EXPECT_EQ(composite(scene, settings).pixels, without.pixels)
                << "mode " << int(settings.mode);
            EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
        }
}

/// Panes that all cross, near the middle of the picture.
std::vector<Transparent> fan(int count)
{
    std::vector<Transparent> all;
    for (int i = 0; i < count; ++i) {
        QuadTransparent quad = pane(5 + 0.01 * i, Kind::add);
        quad.edges[0].y = 3.0 * std::cos(0.9 * i);
        quad.edges[1].y = 3.0 * std::sin(0.9 * i);
        quad.corner.y -= (quad.edges[0].y + quad.edges[1].y) / 2;
        quad.look.radiance = glm::vec3(0.25f);
        all.emplace_back(quad);
    }
    return all;
}

TEST_F(Transparents, EachPixelIsInOnePieceOfASprite)
{
    // As they add the same everywhere, a pixel that no piece has, or that two have, would be seen.
    Scene scene = empty_scene(61);
    scene.transparents = fan(7);
    const Image all = composite(scene, plain_settings());
    EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
    for (const float value : all.pixels)
        ASSERT_EQ(value, 7 * 0.25f);
}

TEST_F(Transparents, MorePiecesThanAFrameMayHaveTakeLists)
{
    Scene scene = sprite_scene(8);
    const auto fragments = [&] {
        composite(scene, plain_settings());
        return scene_renderer().renderer().fragment_count().fragments;
    };
    EXPECT_EQ(fragments(), 0u);
    auto& card = std::get<QuadTransparent>(scene.transparents.back());
    card.corner = {1.5, -6, -0.8};
    card.edges[0] = {-3, 2, 0};  // amid the billboards
    EXPECT_EQ(fragments(), 0u);
    scene.transparents = fan(40);
    EXPECT_GT(fragments(), 0u);
}

TEST_F(Transparents, ShuffledSpritesEqualSortedBitForBit)
{
    for (const int count : {8, 40})
        for (const Settings& settings : modes()) {
            Scene scene = sprite_scene(count);
            const Image sorted = composite(scene, settings);
            EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
            std::mt19937 random(3);
            for (int turn = 0; turn < 2; ++turn) {
                std::shuffle(scene.transparents.begin(), scene.transparents.end(), random);
                EXPECT_EQ(composite(scene, settings).pixels, sorted.pixels)
                    << count << ", mode " << int(settings.mode) << ", 1/" << settings.resolution;
            }
        }
}

TEST_F(Transparents, InvisibleSpritesChangeNoBit)
{
    Scene scene = sprite_scene(3);
    for (Settings settings : modes())
        for (const Settings::Format format :
             {Settings::Format::rgba32f, Settings::Format::rgba16f}) {
            settings.format = format;
            scene.transparents.clear();
            const Image without = composite(scene, settings);
            for (const int count : {3, 8, 64}) {
                SCOPED_TRACE(testing::Message()
                             << count << " sprites, mode " << int(settings.mode));
                scene.transparents = sprites(count, false);
                EXPECT_EQ(composite(scene, settings).pixels, without.pixels);
                EXPECT_EQ(scene_renderer().renderer().fragment_count(), FragmentCount{});
            }
        }
}

TEST_F(Transparents, SpritesInAHostsPictureOfAnyFormatAreWhatListsMakeOfThem)
{
    struct Case {
        GLenum format;
        double step;  ///< of a channel at 1
    };
    constexpr int kSize = 24;
    Settings settings = plain_settings();
    for (const Case& one :
         {Case{GL_RGBA32F, 1e-6}, Case{GL_RGBA16F, 1.0 / 2048}, Case{GL_R11F_G11F_B10F, 1.0 / 64},
          Case{GL_RGBA8, 1.001 / 255}, Case{GL_SRGB8_ALPHA8, 1.001 / 255}})
        for (const int count : {3, 24}) {
            SCOPED_TRACE(testing::Message() << std::hex << one.format << std::dec << ", " << count);
            Scene scene = empty_scene(kSize);
            scene.transparents = sprites(count);
            const auto draw = [&](const Scene& shown) {
                Renderer renderer(get_proc());
                renderer.set_scene(shown, settings);
                View view = renderer.make_view();
                HostPicture picture(gl(), glm::ivec2(kSize), GL_DEPTH_COMPONENT32F, one.format);
                picture.look(shown.camera);
                for (int i = 0; i < 2; ++i) {  // of which the second has room for all in lists
                    picture.fill({0.3f, 0.15f, 0.5f}, shown.camera.near,
                                 [](int x, int) { return x; });
                    renderer.composite(view, picture.frame, settings);
                    renderer.wait_until_ready();
                }
                return picture.read();
            };
            const Image listed = draw(in_lists(scene)), in_order = draw(scene);
            EXPECT_TRUE(images_near(in_order, listed, one.step, one.step, "a step of the format"));
            scene.transparents.clear();
            EXPECT_GT(max_difference(in_order, draw(scene)), 0.1);
        }
}

// A picture that has sRGB texels is blended as they are, and so is what it is told to have of
// transparents that ask what is behind them.
TEST_F(Transparents, WhatAHostsPictureHasOfThemIsWhatIsReadBack)
{
    constexpr int kSize = 8;
    const Scene scene = in_lists(sprite_scene(3, kSize));
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    for (const GLenum format : {GL_RGBA8, GL_SRGB8_ALPHA8})
        for (const auto way : {Settings::Transparency::split, Settings::Transparency::single}) {
            SCOPED_TRACE(testing::Message() << std::hex << format << ", " << int(way));
            Settings settings = plain_settings();
            settings.transparency = way;
            View view = renderer.make_view();
            HostPicture picture(gl(), glm::ivec2(kSize), GL_DEPTH_COMPONENT32F, format);
            picture.look(scene.camera);
            TransparentImages told;
            for (int i = 0; i < 2; ++i) {  // of which the second has room for all in lists
                picture.fill({0.3f, 0.15f, 0.5f}, scene.camera.near, [](int, int) { return 0; });
                renderer.composite(view, picture.frame, settings);
                renderer.wait_until_ready();
                told = renderer.read_transparents(view, picture.frame, settings);
            }
            const Image has = picture.read(), added = picture.turned(told.added),
                        kept = picture.turned(told.kept);
            int met = 0;
            for (std::size_t i = 0; i < has.pixels.size(); ++i) {
                if (kept.pixels[i] != 0)  // no fragment
                    continue;
                ++met;
                ASSERT_NEAR(added.pixels[i], has.pixels[i], 1e-6) << i;
            }
            EXPECT_GT(met, kSize * kSize);
        }
}

TEST_F(Transparents, AViewLetsGoOfWhatTheyNeedOnceThereAreNone)
{
    constexpr int kSize = 64;
    const Settings settings = plain_settings();
    Renderer renderer(get_proc());
    for (const bool fog : {true, false})
        for (const bool listed : {true, false}) {
            SCOPED_TRACE(testing::Message()
                         << (fog ? "fog, " : "") << (listed ? "lists" : "order"));
            Scene scene = sprite_scene(3, kSize);
            if (!fog)
                scene.media.clear();
            Scene none = scene;
            none.transparents.clear();
            View view = renderer.make_view();
            HostPicture picture(gl(), glm::ivec2(kSize), GL_DEPTH_COMPONENT32F, GL_RGBA16F);
            picture.look(scene.camera);
            picture.fill({0.3f, 0.15f, 0.5f}, scene.camera.near, [](int, int) { return 0; });
            const auto bytes = [&](const Scene& shown) {
                renderer.set_scene(shown, settings);
                renderer.composite(view, picture.frame, settings);
                renderer.wait_until_ready();
                return renderer.device().bytes();
            };
            const std::uint64_t with = bytes(listed ? in_lists(scene) : scene);
            EXPECT_LE(bytes(none) + kSize * kSize * 4 * sizeof(float), with);
        }
}

TEST_F(Transparents, ASequenceOfImagesShowsTheImageOfEachFrame)
{
    const Settings settings = plain_settings(2);
    const auto at = [](int time) {
        Scene scene = sprite_scene(8);
        for (Transparent& one : scene.transparents) {
            TransparentLook& look = look_of(one);
            if (look.image == nullptr)
                continue;
            TransparentImage image = *look.image;
            for (glm::vec4& texel : image.texels)
                texel *= 1 - 0.3f * float(time);
            look.image = std::make_shared<TransparentImage>(image);
        }
        return scene;
    };
    const auto draw = [&](Renderer& renderer, View& view, const Scene& scene) {
        renderer.set_scene(scene, settings);
        HostPicture picture(gl(), glm::ivec2(33));
        picture.look(scene.camera);
        picture.fill(glm::vec3(0.5f), scene.camera.near, [](int, int) { return 0.0; });
        renderer.composite(view, picture.frame, settings);
        return picture.read();
    };
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    Image before;
    for (int time = 0; time < 3; ++time) {
        Renderer anew(get_proc());
        View of_it = anew.make_view();
        const Image picture = draw(renderer, view, at(time));
        EXPECT_EQ(picture.pixels, draw(anew, of_it, at(time)).pixels) << time;
        EXPECT_NE(picture.pixels, before.pixels) << time;
        before = picture;
    }
}

TEST_F(Transparents, ASceneWithoutThemHasNoPassAndNoMemory)
{
    Scene scene = fog_scene();
    Renderer renderer(get_proc());
    renderer.set_scene(scene, plain_settings());
    View view = renderer.make_view();
    HostPicture picture(gl(), glm::ivec2(32));
    renderer.set_timing(renderer.measuring_timing());
    const auto draw = [&] {
        return draw_frames(renderer, view, picture, scene, plain_settings(), 2);
    };
    const auto passes = [](const FrameReport& report) {
        return std::count_if(report.pass_ms.begin(), report.pass_ms.end(), [](const auto& pass) {
            return pass.first.find("transparent") != std::string::npos;
        });
    };
    const FrameReport without = draw();
    EXPECT_EQ(passes(without), 0);
    scene.transparents = {pane(5, Kind::add)};
    renderer.set_scene(scene, plain_settings());
    const FrameReport with = draw();
    EXPECT_EQ(passes(with), 2);
    EXPECT_EQ(with.transparents, FragmentCount{}) << "a pane by itself is in no list";
    EXPECT_GT(with.gpu_bytes, without.gpu_bytes);
    EXPECT_EQ(with.work, SceneWork{}) << "nothing else sees a pane";
    scene.transparents.clear();
    renderer.set_scene(scene, plain_settings());
    const FrameReport again = draw();
    EXPECT_EQ(passes(again), 0);
}

}  // namespace
}  // namespace fumarole::test
