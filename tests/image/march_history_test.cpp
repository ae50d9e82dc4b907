// What the march keeps of a view from frame to frame.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <vector>

#include "halton.h"
#include "history_test.h"
#include "study/metrics.h"

namespace fumarole::test {
namespace {

/// The eye 5 m from a lump of noise in a sun, partly behind a ball.
Scene lump_scene(glm::vec3 sigma_s)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    BoxMedium cloud;
    cloud.min = {-1.5, -6.5, -1.5};
    cloud.max = {1.5, -3.5, 1.5};
    cloud.profile = NoiseProfile{.feature_size = 1.2, .octaves = 2, .threshold = 0.4, .seed = 5};
    cloud.sigma_s = sigma_s;
    cloud.sigma_a = glm::vec3(0.2f);
    cloud.g = 0.3f;
    scene.media = {cloud};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    scene.surfaces = {SphereSurface{{0.3, -4.6, 0.1}, 0.5, glm::vec3(0.5f)}};
    return scene;
}

constexpr glm::vec3 kGrey(2), kColored(1, 2, 3);

/// Round the middle of the lump.
void orbit(Camera& camera, double degrees)
{
    const double angle = glm::radians(degrees);
    camera.look_at = {0, -5, 0};
    camera.position = camera.look_at + 5.0 * glm::dvec3(std::sin(angle), std::cos(angle), 0.1);
}

Settings temporal(int steps)
{
    Settings settings;
    settings.temporal = true;
    settings.steps = steps;
    settings.shadow_map = 256;
    settings.bounces = 0;
    return settings;
}

class MarchHistory : public HistoryTest {
protected:
    /// A picture on its own, with the jitter of a view's frame of that number.
    LayerImages alone(Renderer& renderer, const Scene& scene, Settings settings,
                      std::uint64_t number)
    {
        settings.temporal = false;
        HostPicture picture(gl(), glm::ivec2(scene.resolution));
        View view = renderer.make_view(View::History::none);
        picture.frame.jitter_offset = golden_fraction(static_cast<double>(number));
        draw_frames(renderer, view, picture, scene, settings, 1, number);
        return renderer.read_layers(view, picture.frame, settings);
    }
};

TEST_F(MarchHistory, TheFirstFrameIsThePlainMarch)
{
    for (const glm::vec3& sigma_s : {kGrey, kColored}) {
        const Scene scene = lump_scene(sigma_s);
        for (const int resolution : {1, 2, 4}) {
            Settings settings = temporal(12);
            settings.resolution = resolution;
            Renderer renderer(get_proc());
            View view = renderer.make_view();
            renderer.set_scene(scene, settings);
            renderer.wait_until_ready();
            const LayerImages plain = alone(renderer, scene, settings, 3);
            EXPECT_EQ(run(renderer, view, scene, settings, 1, 3).history, "none: first frame");
            EXPECT_EQ(layers.scattering, plain.scattering) << resolution;
            EXPECT_EQ(layers.transmittance, plain.transmittance) << resolution;
        }
    }
}

/// Sums over the frames of a still, each drawn alone.
struct FrameSums {
    std::vector<double> scattering, transmittance, depth;
    std::vector<double> least, most;  ///< optical depth
};

TEST_F(MarchHistory, AStillHasTheMeanOfItsFramesOpticalDepths)
{
    constexpr int kFrames = 24;
    for (const glm::vec3& sigma_s : {kGrey, kColored}) {
        const Scene scene = lump_scene(sigma_s);
        Settings settings = temporal(8);
        settings.resolution = 1;  // between texels a mean of depths is no mean of depths
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        const std::size_t size = scene.resolution.x * scene.resolution.y * 3u;
        FrameSums sums{std::vector<double>(size), std::vector<double>(size),
                       std::vector<double>(size), std::vector<double>(size, 1e9),
                       std::vector<double>(size)};
        for (std::uint64_t i = 0; i < kFrames; ++i) {
            const LayerImages one = alone(renderer, scene, settings, i);
            for (std::size_t k = 0; k < size; ++k) {
                const double depth = -std::log(double(one.transmittance[k]));
                sums.scattering[k] += double(one.scattering[k]) / kFrames;
                sums.transmittance[k] += double(one.transmittance[k]) / kFrames;
                sums.depth[k] += depth / kFrames;
                sums.least[k] = std::min(sums.least[k], depth);
                sums.most[k] = std::max(sums.most[k], depth);
            }
        }
        EXPECT_EQ(run(renderer, view, scene, settings, kFrames).history, "kept: nothing moved");
        int noisy = 0;
        for (std::size_t k = 0; k < size; ++k) {
            if (sums.most[k] - sums.least[k] > 0.5)
                continue;  // the ray may have met something else: see march_history.glsl
            noisy += sums.most[k] - sums.least[k] > 0.1 ? 1 : 0;
            const double transmittance = std::exp(-sums.depth[k]);
            ASSERT_NEAR(layers.transmittance[k], transmittance, 1e-5) << k;
            // What is kept of the scattering is corrected frame by frame, this at the end: they
            // differ by the product of two differences.
            const double taken = 1 - sums.transmittance[k];
            const double scattering =
                sums.scattering[k] * (taken > 1e-3 ? (1 - transmittance) / taken : 1.0);
            ASSERT_NEAR(layers.scattering[k], scattering, 2e-3 * scattering + 1e-5) << k;
        }
        EXPECT_GT(noisy, 300) << "or there was nothing to average";
    }
}

// Where nothing is taken away there is no depth to go by.
TEST_F(MarchHistory, AGlowIsTheMeanOfItsFrames)
{
    constexpr int kFrames = 12;
    Scene scene = lump_scene(kGrey);
    auto& cloud = std::get<BoxMedium>(scene.media[0]);
    cloud.sigma_s = cloud.sigma_a = glm::vec3(0);
    cloud.emission = {1, 2, 3};
    const Settings settings = temporal(8);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    std::vector<double> mean(scene.resolution.x * scene.resolution.y * 3u);
    double moved = 0;
    for (std::uint64_t i = 0; i < kFrames; ++i) {
        const LayerImages one = alone(renderer, scene, settings, i);
        for (std::size_t k = 0; k < mean.size(); ++k)
            mean[k] += double(one.scattering[k]) / kFrames;
        moved = std::max(moved, std::abs(double(one.scattering[mean.size() / 2]) * (double(i) + 1) -
                                         mean[mean.size() / 2] * kFrames));
    }
    run(renderer, view, scene, settings, kFrames);
    // With history it is another program, and a GPU's compiler may fuse other sums: places differ
    // by a float's rounding, which now and then tips that of a lookup in the noise over. One sample
    // of all frames is then off by 2 filter_rounding() of the difference between two nodes, under
    // 0.5, of what glows along a step of 3.5 m / 8.
    const double tipped = 2 * filter_rounding() * 0.5 * 3.5 / 8 / kFrames;
    for (std::size_t k = 0; k < mean.size(); ++k)
        ASSERT_NEAR(layers.scattering[k], mean[k],
                    1e-5 * (1 + mean[k]) + cloud.emission[int(k % 3)] * tipped)
            << k;
    EXPECT_GT(moved, 0.01) << "or there was nothing to average";
}

// Few steps err to one side, each frame alike: not so much once depths are averaged and light is
// taken from where it counts.
TEST_F(MarchHistory, AStillOfFewStepsIsAsBrightAsOneOfMany)
{
    const Scene scene = lump_scene(glm::vec3(6));
    Settings many = temporal(512);
    many.jitter = Settings::Jitter::none;
    const Settings few = temporal(8);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, few);
    renderer.wait_until_ready();
    const LayerImages truth = alone(renderer, scene, many, 0);
    run(renderer, view, scene, few, 48);
    const study::Metrics m = study::compare(layers.scattering, truth.scattering);
    const study::Metrics t = study::compare(layers.transmittance, truth.transmittance);
    figure("bias of the scattering", m.bias);
    figure("bias of the transmittance", t.bias);
    EXPECT_LT(std::abs(m.bias), 5e-3);
    EXPECT_LT(std::abs(t.bias), 5e-4);
}

// What the setting is for: a view that moves has less noise for the same steps. What is left is
// what few steps do whatever their jitter, and what smears where media of some depth move against
// themselves.
TEST_F(MarchHistory, AMovingViewHasAQuarterOfTheError)
{
    Scene scene = lump_scene(kGrey);
    scene.resolution = {96, 96};
    constexpr int kSteps = 8, kFrames = 20;
    Settings many = temporal(512);
    many.jitter = Settings::Jitter::none;
    const auto error = [&](const LayerImages& shown, const LayerImages& truth) {
        return study::compare(shown.scattering, truth.scattering).relmse;
    };
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, many);
    renderer.wait_until_ready();
    double few = 0, twice = 0, with = 0;
    for (std::uint64_t i = 0; i < kFrames; ++i) {
        orbit(scene.camera, 0.5 * static_cast<double>(i));
        const FrameReport report = run(renderer, view, scene, temporal(kSteps), 1, i);
        if (i + 6 < kFrames)
            continue;
        EXPECT_EQ(report.history, "reprojected");
        const LayerImages mean = layers;
        Renderer other(get_proc());
        other.set_scene(scene, many);
        other.wait_until_ready();
        const LayerImages truth = alone(other, scene, many, 0);
        with += error(mean, truth);
        few += error(alone(other, scene, temporal(kSteps), i), truth);
        twice += error(alone(other, scene, temporal(2 * kSteps), i), truth);
    }
    figure("relMSE, 8 steps with a history", with / 6);
    figure("relMSE, 8 steps without", few / 6);
    figure("relMSE, 16 steps without", twice / 6);
    EXPECT_LT(with, 0.3 * few);
}

/// A view on its way, 4 cm a frame: relMSE of its last frames' scattering and, of one on its own,
/// the same; bias of the former.
struct OnTheWay {
    double with = 0, alone = 0, bias = 0;
};

class MovingMarchHistory : public MarchHistory {
protected:
    OnTheWay travel(Scene scene, int steps, glm::dvec3 way)
    {
        scene.resolution = {96, 96};
        constexpr int kFrames = 24, kLast = 4;
        Settings many = temporal(768);
        many.jitter = Settings::Jitter::none;
        Renderer renderer(get_proc()), other(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, temporal(steps));
        other.set_scene(scene, many);
        renderer.wait_until_ready();
        other.wait_until_ready();
        OnTheWay found;
        for (int i = 0; i < kFrames; ++i) {
            scene.camera.position = 0.04 * (i - kFrames / 2) * way;
            scene.camera.look_at = scene.camera.position + glm::dvec3(0, -1, 0);
            const auto number = static_cast<std::uint64_t>(i);
            run(renderer, view, scene, temporal(steps), 1, number);
            if (i + kLast < kFrames)
                continue;
            const LayerImages kept = layers;
            const LayerImages truth = alone(other, scene, many, 0);
            const study::Metrics with = study::compare(kept.scattering, truth.scattering);
            found.with += with.relmse / kLast;
            found.bias += with.bias / kLast;
            found.alone += study::compare(alone(other, scene, temporal(steps), number).scattering,
                                          truth.scattering)
                               .relmse /
                           kLast;
        }
        return found;
    }
};

// What a frame shows well by itself is not blurred by what was gathered.
TEST_F(MovingMarchHistory, DetailWithoutNoiseIsNotBlurred)
{
    const OnTheWay found = travel(lump_scene(kGrey), 96, {1, 0, 0});
    figure("relMSE with a history", found.with);
    figure("relMSE without", found.alone);
    EXPECT_LT(found.with, 3 * found.alone) << "it was 11 times";
}

// Of few steps most rays past a beam's edge miss it: what they have met is no place to look for
// them in the last frame.
TEST_F(MovingMarchHistory, RaysThatMissABeamGoByThoseBesideThem)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = glm::vec3(0.1f);
    scene.media = {fog};
    scene.lights = {SpotLight{{0, -5, 3}, {0, 0, -1}, 40, 0.3, glm::vec3(10)}};
    const OnTheWay found = travel(scene, 12, {1, 0, 0});
    figure("relMSE with a history", found.with);
    figure("relMSE without", found.alone);
    EXPECT_LT(found.with, 0.06 * found.alone) << "0.7 where each goes by itself";
}

// What a slanted ray sees of a slab changes as the eye goes away from it, each frame the same way.
TEST_F(MovingMarchHistory, BrightnessDoesNotLag)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    BoxMedium slab;
    slab.min = {-200, -6, -200};
    slab.max = {200, -4, 200};
    slab.sigma_s = {0.2f, 0.5f, 1.0f};
    slab.sigma_a = glm::vec3(0.1f);
    slab.g = 0.4f;
    scene.media = {slab};
    scene.lights = {SunLight{{0.3, 0.8, 0.5}, {5, 4, 3}}};
    const OnTheWay found = travel(scene, 48, {0, 1, 0});
    figure("bias with a history", found.bias);
    EXPECT_LT(std::abs(found.bias), 4e-4) << "it was 5.4e-4";
}

// A host's own surface, of which the renderer knows its depth alone, moves before fog: what it hid
// is seen anew at once, what it hides is gone at once, whether the view moves or not.
TEST_F(MarchHistory, WhatIsUncoveredHasNoTrail)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    BoxMedium fog;
    fog.min = {-30, -12, -30};
    fog.max = {30, -1, 30};
    fog.sigma_a = {0.1f, 0.2f, 0.3f};
    fog.emission = glm::vec3(0.3f);
    scene.media = {fog};
    Settings settings = temporal(16);
    settings.jitter = Settings::Jitter::none;
    for (const double travel : {0.0, 0.02}) {
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        HostPicture picture(gl(), glm::ivec2(48));
        Settings plain = settings;
        plain.temporal = false;
        Renderer other(get_proc());
        other.set_scene(scene, plain);
        other.wait_until_ready();
        View other_view = other.make_view();
        const auto draw = [&](Renderer& by, View& in, const Settings& how, int post) {
            picture.look(scene.camera);
            picture.fill(glm::vec3(0), scene.camera.near,
                         [&](int x, int) { return x >= post && x < post + 12 ? 3.0 : 10.0; });
            by.composite(in, picture.frame, how);
            return picture.read();
        };
        for (int i = 0; i < 12; ++i) {
            scene.camera.position.x = travel * i;
            scene.camera.look_at = scene.camera.position + glm::dvec3(0, -1, 0);
            const int post = 4 + (i < 6 ? 0 : 4 * (i - 5));
            ++picture.frame.index;
            EXPECT_LT(max_difference(draw(renderer, view, settings, post),
                                     draw(other, other_view, plain, post)),
                      1e-2)
                << "frame " << i << ", " << travel << " m a frame: of radiances up to 1.4";
        }
    }
}

TEST_F(MarchHistory, IsDroppedForAReasonThatIsTold)
{
    Settings settings = temporal(12);
    Settings others = settings;
    others.min_transmittance = 0.01f;
    expect_dropped_for_reasons(lump_scene(kGrey), settings, others,
                               [&](const Scene& scene, const Settings& how, std::uint64_t number) {
                                   Renderer renderer(get_proc());
                                   View view = renderer.make_view();
                                   renderer.set_scene(scene, how);
                                   renderer.wait_until_ready();
                                   return alone(renderer, scene, how, number).scattering;
                               });
}

TEST_F(MarchHistory, ViewsKeepTheirOwn)
{
    const Scene scene = lump_scene(kColored);
    Scene other = scene;
    orbit(other.camera, 20);
    const Settings settings = temporal(12);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    run(renderer, view, scene, settings, 4);
    const LayerImages alone = layers;
    HostPicture left(gl(), glm::ivec2(48)), right(gl(), glm::ivec2(48));
    View left_view = renderer.make_view(), right_view = renderer.make_view();
    for (std::uint64_t i = 0; i < 4; ++i) {
        draw_frames(renderer, right_view, right, other, settings, 1, i);
        draw_frames(renderer, left_view, left, scene, settings, 1, i);
    }
    EXPECT_EQ(renderer.read_layers(left_view, left.frame, settings).scattering, alone.scattering);
}

// Not even by squares that overflow while it is held to what is around.
TEST_F(MarchHistory, WhatIsNoNumberDoesNotLiveOn)
{
    for (const glm::vec3& sigma_s : {kGrey, kColored})
        for (const float irradiance : {1e5f, 1e25f, std::numeric_limits<float>::max()}) {
            Scene scene = lump_scene(sigma_s);
            scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(irradiance)}};
            Settings settings = temporal(12);
            settings.format = Settings::Format::rgba32f;
            Renderer renderer(get_proc());
            View view = renderer.make_view();
            renderer.set_scene(scene, settings);
            renderer.wait_until_ready();
            for (std::uint64_t i = 0; i < 6; ++i) {
                orbit(scene.camera, 0.5 * static_cast<double>(std::min<std::uint64_t>(i, 3)));
                run(renderer, view, scene, settings, 1, i);
                for (const float v : layers.scattering)
                    ASSERT_TRUE(std::isfinite(v)) << irradiance << ", frame " << i;
                for (const float v : layers.transmittance)
                    ASSERT_TRUE(v >= 0 && v <= 1) << irradiance << ", frame " << i;
            }
        }
}

// Nothing is made where it is off, or for a picture of no view.
TEST_F(MarchHistory, CostsNothingWhereItIsNotAsked)
{
    const Scene scene = lump_scene(kGrey);
    const auto bytes = [&](bool on, View::History history) {
        Settings settings = temporal(12);
        settings.temporal = on;
        Renderer renderer(get_proc());
        View view = renderer.make_view(history);
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        HostPicture picture(gl(), glm::ivec2(48));
        return draw_frames(renderer, view, picture, scene, settings, 2).gpu_bytes;
    };
    const std::uint64_t without = bytes(false, View::History::kept);
    EXPECT_EQ(bytes(true, View::History::none), without);
    EXPECT_GT(bytes(true, View::History::kept), without);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, temporal(12));
    renderer.wait_until_ready();
    run(renderer, view, scene, temporal(12), 2);
    Settings off = temporal(12);
    off.temporal = false;
    EXPECT_EQ(run(renderer, view, scene, off).history, "");
    EXPECT_EQ(renderer.take_report().gpu_bytes, without) << "given back when it is switched off";
}

}  // namespace
}  // namespace fumarole::test
