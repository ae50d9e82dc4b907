#include <cmath>
#include <utility>

#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

#include "host_picture.h"

namespace fumarole::test {
namespace {

/// Fog with a lump in it, lit by a sun, before a ball.
Scene foggy_scene(glm::vec3 sigma_s)
{
    Scene scene = empty_scene(32);
    BoxMedium fog;
    fog.min = {-3, -9, -3};
    fog.max = {3, -2, 3};
    fog.sigma_s = sigma_s;
    fog.sigma_a = glm::vec3(0.05f);
    fog.emission = glm::vec3(0.1f);
    scene.media = {fog};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    scene.surfaces = {SphereSurface{{0.3, -6, 0.1}, 0.8, glm::vec3(0.5f)}};
    return scene;
}

constexpr glm::vec3 kGrey(0.2f), kColored(0.1f, 0.2f, 0.3f);

std::vector<Settings> all_modes()
{
    Settings march, gathered, froxels;
    gathered.temporal = true;
    froxels.mode = Settings::Mode::froxel;
    froxels.slices = 16;
    return {march, gathered, froxels};
}

class ViewTest : public ImageTest {
protected:
    /// A host's picture: the scene's surfaces.
    void draw_scene(Renderer& renderer, HostPicture& picture, const Scene& scene,
                    const Settings& settings, std::uint64_t number = 0)
    {
        picture.look(scene.camera);
        picture.frame.index = number;
        renderer.draw_surfaces(picture.frame, settings, true);
    }
    std::vector<float> read(gl::TextureView texture, int channels = 4)
    {
        return gl::read_texture(gl(), texture, channels);
    }
};

// A player's view and a mirror's, one of them in froxels, the other with a history.
TEST_F(ViewTest, ViewsSideBySideAllocateNothing)
{
    const Scene scene = foggy_scene(kColored);
    Scene other = scene;
    other.camera.look_at = {0.3, -1, 0.1};
    const std::vector<Settings> modes = all_modes();
    Renderer renderer(get_proc());
    renderer.set_scene(scene, modes[0]);
    HostPicture large(gl(), {48, 36}), middle(gl(), {40, 40}), small(gl(), {20, 24});
    View marched = renderer.make_view(), gathered = renderer.make_view(),
         froxels = renderer.make_view();
    const auto draw_all = [&](std::uint64_t number) {
        draw_scene(renderer, large, scene, modes[0], number);
        renderer.composite(marched, large.frame, modes[0]);
        draw_scene(renderer, middle, other, modes[1], number);
        renderer.composite(gathered, middle.frame, modes[1]);
        draw_scene(renderer, small, other, modes[2], number);
        renderer.composite(froxels, small.frame, modes[2]);
    };
    draw_all(0);
    const std::uint64_t made = renderer.device().allocations();
    for (std::uint64_t i = 1; i <= 100; ++i)
        draw_all(i);
    EXPECT_EQ(renderer.device().allocations(), made);
    EXPECT_STREQ(marched.history(), "");
    EXPECT_STREQ(gathered.history(), "kept: nothing moved");
    EXPECT_STREQ(froxels.history(), "kept: nothing moved");
    renderer.composite(marched, small.frame, modes[0]);
    EXPECT_GT(renderer.device().allocations(), made) << "another size, or nothing is counted";
}

TEST_F(ViewTest, LayersAreTexturesThatMakeTheComposite)
{
    for (const glm::vec3& sigma_s : {kGrey, kColored})
        for (const Settings& settings : all_modes()) {
            const Scene scene = foggy_scene(sigma_s);
            Renderer renderer(get_proc());
            renderer.set_scene(scene, settings);
            View view = renderer.make_view();
            EXPECT_FALSE(view.own_layers().scattering) << "of no frame";
            HostPicture picture(gl(), {40, 32});
            draw_scene(renderer, picture, scene, settings);
            const std::vector<float> before = read(picture.frame.color);
            renderer.composite(view, picture.frame, settings);
            const std::vector<float> after = read(picture.frame.color);
            const LayerTextures layers = renderer.layers(view, picture.frame, settings);
            ASSERT_EQ(layers.scattering.size, picture.frame.color.size);
            ASSERT_EQ(layers.transmittance.size, picture.frame.color.size);
            const std::vector<float> scattering = read(layers.scattering),
                                     transmittance = read(layers.transmittance);
            double dimmed = 0;
            for (std::size_t i = 0; i < after.size(); ++i) {
                if (i % 4 == 3)
                    continue;
                ASSERT_NEAR(after[i], before[i] * transmittance[i] + scattering[i],
                            1e-5 * (1 + after[i]));
                dimmed = std::max(dimmed, 1.0 - transmittance[i]);
            }
            EXPECT_GT(dimmed, 0.1);
            const OwnLayers own = view.own_layers();
            const bool froxel = settings.mode == Settings::Mode::froxel;
            EXPECT_EQ(own.grey, sigma_s == kGrey);
            EXPECT_EQ(static_cast<bool>(own.transmittance), !own.grey);
            EXPECT_EQ(own.scattering.size.z > 1, froxel);
            EXPECT_EQ(static_cast<bool>(own.depth), !froxel);
            if (!froxel) {
                const glm::ivec2 texels(own.scattering.size);
                EXPECT_EQ(texels, (picture.size() + own.scale - 1) / own.scale + 2 * own.guard);
            }
        }
}

TEST_F(ViewTest, LayersOfAnotherFrameAreRefused)
{
    const Scene scene = foggy_scene(kGrey);
    const Settings settings;
    Renderer renderer(get_proc());
    renderer.set_scene(scene, settings);
    View view = renderer.make_view();
    HostPicture picture(gl(), {40, 32}), other(gl(), {32, 32});
    picture.look(scene.camera);
    other.look(scene.camera);
    EXPECT_THROW(renderer.layers(view, picture.frame, settings), Error);
    draw_scene(renderer, picture, scene, settings);
    renderer.composite(view, picture.frame, settings);
    EXPECT_TRUE(renderer.layers(view, picture.frame, settings));
    EXPECT_THROW(renderer.layers(view, other.frame, settings), Error);
    Settings more = settings;
    more.steps = 7;
    EXPECT_THROW(renderer.layers(view, picture.frame, more), Error);
}

TEST_F(ViewTest, ATargetGetsWhatTheColourWouldHave)
{
    Scene scene = foggy_scene(kColored);
    for (const Settings& settings : all_modes())
        for (const bool empty : {false, true}) {
            Scene shown = scene;
            if (empty)
                shown.media.clear();
            Renderer renderer(get_proc());
            renderer.set_scene(shown, settings);
            HostPicture picture(gl(), {40, 32}), other(gl(), {40, 32}), small(gl(), {32, 32});
            draw_scene(renderer, picture, shown, settings);
            const std::vector<float> before = read(picture.frame.color);
            picture.frame.target = other.frame.color;
            View view = renderer.make_view(), in_place = renderer.make_view();
            renderer.composite(view, picture.frame, settings);
            EXPECT_EQ(read(picture.frame.color), before) << "only read";
            picture.frame.target = {};
            renderer.composite(in_place, picture.frame, settings);
            EXPECT_EQ(read(other.frame.color), read(picture.frame.color));
            EXPECT_EQ(read(picture.frame.color) == before, empty);
            for (const gl::TextureView wrong : {small.frame.color, picture.frame.color}) {
                picture.frame.target = wrong;
                EXPECT_THROW(renderer.composite(view, picture.frame, settings), Error);
            }
        }
}

TEST_F(ViewTest, OutlivesItsRendererAndServesNoOther)
{
    const Scene scene = foggy_scene(kGrey);
    const Settings settings;
    HostPicture picture(gl(), {40, 32});
    auto renderer = std::make_unique<Renderer>(get_proc());
    renderer->set_scene(scene, settings);
    View view = renderer->make_view();
    draw_scene(*renderer, picture, scene, settings);
    renderer->composite(view, picture.frame, settings);
    Renderer moved = std::move(*renderer);
    moved.composite(view, picture.frame, settings);
    View to = std::move(view);
    moved.composite(to, picture.frame, settings);
    Renderer other(get_proc());
    other.set_scene(scene, settings);
    EXPECT_THROW(other.composite(to, picture.frame, settings), Error);
    moved = std::move(other);
    EXPECT_THROW(moved.composite(to, picture.frame, settings), Error);
}

TEST_F(ViewTest, ResetLetsTheNextFrameBeginAnew)
{
    const Scene scene = foggy_scene(kColored);
    for (const Settings& settings : all_modes()) {
        if (!settings.keeps_history())
            continue;
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        View view = renderer.make_view(), none = renderer.make_view(View::History::none);
        HostPicture picture(gl(), {40, 32});
        for (std::uint64_t i = 0; i < 3; ++i) {
            draw_scene(renderer, picture, scene, settings, i);
            renderer.composite(view, picture.frame, settings);
        }
        EXPECT_STREQ(view.history(), "kept: nothing moved");
        const std::uint64_t made = renderer.device().allocations();
        view.reset_history();
        renderer.composite(view, picture.frame, settings);
        EXPECT_STREQ(view.history(), "none: first frame");
        EXPECT_EQ(renderer.device().allocations(), made) << "its textures stay";
        renderer.composite(none, picture.frame, settings);
        renderer.composite(none, picture.frame, settings);
        const bool froxel = settings.mode == Settings::Mode::froxel;
        EXPECT_STREQ(none.history(), froxel ? "off" : "");
    }
}

// The eye goes to and fro where a quarter of the size is just enough, 3 % nearer and farther, as a
// hand-held one does.
TEST_F(ViewTest, AnEyeAboutALimitKeepsItsLayersSize)
{
    Scene scene = asset::load_scene(std::string(FUM_TEST_DATA) + "/smoke_plume_sun.json").scene;
    scene.surfaces.clear();
    Settings settings;
    settings.bounces = 0;
    Renderer renderer(get_proc());
    renderer.set_scene(scene, settings);
    HostPicture picture(gl(), {64, 48});
    const double tangent = std::tan(glm::radians(scene.camera.vfov_deg) / 2);
    const auto frame_at = [&](double zoom, std::uint64_t number) -> const Frame& {
        Scene zoomed = scene;
        zoomed.camera.vfov_deg = 2 * glm::degrees(std::atan(tangent / zoom));
        picture.look(zoomed.camera);
        picture.frame.index = number;
        return picture.frame;
    };
    const View fresh = renderer.make_view();
    double few = 1, many = 100;  // zooms with half and with a quarter
    for (int i = 0; i < 40; ++i) {
        const double zoom = std::sqrt(few * many);
        (renderer.settled(fresh, frame_at(zoom, 0), settings).resolution == 2 ? few : many) = zoom;
    }
    View kept = renderer.make_view(), none = renderer.make_view(View::History::none);
    const auto changes = [&](View& view, double begin) {
        int last = 0, count = -1;
        for (std::uint64_t i = 0; i < 8; ++i) {
            const Frame& frame = frame_at(begin * (i % 2 == 0 ? 0.97 : 1.03), i);
            renderer.composite(view, frame, settings);
            const int now = renderer.settled(view, frame, settings).resolution;
            count += now != std::exchange(last, now) ? 1 : 0;
        }
        return count;
    };
    EXPECT_EQ(changes(none, many), 7) << "not about a limit";
    EXPECT_EQ(changes(kept, many), 0);
    EXPECT_EQ(changes(kept, 1.5 * many), 0);
    EXPECT_EQ(renderer.settled(kept, frame_at(many * 1.03, 0), settings).resolution, 4);
    EXPECT_EQ(changes(kept, many), 0);
    EXPECT_EQ(renderer.settled(kept, frame_at(many * 1.03, 0), settings).resolution, 2);
    kept.reset_history();
    EXPECT_EQ(renderer.settled(kept, frame_at(many * 1.03, 0), settings).resolution, 4) << "a cut";
}

}  // namespace
}  // namespace fumarole::test
