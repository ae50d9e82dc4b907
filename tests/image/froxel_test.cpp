// What is the froxels' own: exactness between columns and slices, how their choices differ, and
// what they keep from frame to frame.

#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "history_test.h"
#include "study/metrics.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

class Froxel : public HistoryTest {
protected:
    /// On the GPU after a picture of so many frames.
    static std::uint64_t bytes_of(const Scene& scene, const Settings& settings, int frames)
    {
        SceneRenderer renderer(get_proc());
        StillReport report;
        StillOptions options;
        options.timed_frames = frames;
        renderer.render(scene, settings, options, &report);
        return report.gpu_bytes;
    }
    /// The eye in uniform fog that scatters and glows, a wall of steps in it from 2 to 12 m.
    static Scene stairs_in_fog(Camera::Projection projection)
    {
        Scene scene = empty_scene(40);
        scene.resolution = {43, 40};
        scene.camera.vfov_deg = 50;
        scene.camera.projection = projection;
        scene.camera.ortho_height = 6;
        BoxMedium fog;
        fog.min = {-60, -40, -60};
        fog.max = {60, 2, 60};
        fog.sigma_a = kSigma;
        fog.emission = kEmission;
        scene.media = {fog};
        for (int i = 0; i < 8; ++i) {
            const double depth = 2 + 1.3 * i;
            scene.surfaces.emplace_back(BoxSurface{
                {-20 + 0.35 * i, -depth - 0.1, -20}, {-2 + 0.7 * i, -depth, 20}, glm::vec3(1)});
        }
        return scene;
    }
    static constexpr glm::vec3 kSigma{0.0f, 0.2f, 0.9f};
    static constexpr glm::vec3 kEmission{0.3f, 0.2f, 0.1f};
};

// Fog is what it is at every pixel's own depth and along its own ray, wherever columns and slices
// lie, at the corners of the picture too.
TEST_F(Froxel, UniformFogIsExactAtEveryDepthAndCorner)
{
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic}) {
        const Scene scene = stairs_in_fog(projection);
        for (const int tile : {1, 7, 16})
            for (const int slices : {1, 64})
                for (const auto spacing :
                     {Settings::SliceSpacing::exponential, Settings::SliceSpacing::power,
                      Settings::SliceSpacing::linear}) {
                    Settings settings = plain_froxels(tile);
                    settings.slices = slices;
                    settings.slice_spacing = spacing;
                    const Still still = render(scene, settings);
                    double worst_t = 0, worst_s = 0;
                    for (int y = 0; y < still.height; ++y)
                        for (int x = 0; x < still.width; ++x) {
                            const PixelRay ray = ray_of(scene, x, y);
                            const double z = std::min(
                                still.depth[static_cast<std::size_t>(y * still.width + x)], 40.0f);
                            const double length = (z - scene.camera.near) * ray.length_per_z;
                            const glm::vec3 t = pixel(still.transmittance, still.width, x, y);
                            const glm::vec3 s = pixel(still.scattering, still.width, x, y);
                            for (int c = 0; c < 3; ++c) {
                                const double sigma = kSigma[c];
                                const double glow =
                                    kEmission[c] *
                                    (sigma > 0 ? -std::expm1(-sigma * length) / sigma : length);
                                worst_t =
                                    std::max(worst_t, std::abs(t[c] - std::exp(-sigma * length)));
                                worst_s = std::max(worst_s, std::abs(s[c] - glow) / (0.1 + glow));
                            }
                        }
                    EXPECT_LT(worst_t, 2e-5) << "32-bit sums; tile " << tile << ", slices "
                                             << slices << ", spacing " << static_cast<int>(spacing);
                    EXPECT_LT(worst_s, 1e-4) << "of radiance; tile " << tile << ", slices "
                                             << slices << ", spacing " << static_cast<int>(spacing);
                }
    }
}

// A box seen askew is cut at its own faces within slices, its scattering as its extinction: white
// in a white world, it can't be seen.
TEST_F(Froxel, ABoxAskewEndsAtItsFaces)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    scene.camera.position = {4, 3, 2.5};
    BoxMedium box;
    box.min = {-0.5, -0.7, -0.6};
    box.max = {0.6, 0.4, 0.5};
    box.sigma_s = {0.3f, 1.0f, 3.0f};
    scene.camera.look_at = (box.min + box.max) / 2.0;
    scene.media = {box};
    scene.world.radiance = glm::vec3(1);
    Settings settings = plain_froxels();
    settings.ambient_volume_size = 0;  // a furnace: its world is not dimmed
    const Still still = render(scene, settings);
    EXPECT_TRUE(images_near(
        picture_of(still, still.transmittance),
        ideal(scene,
              [&](glm::dvec2 at) {
                  return glm::exp(-glm::dvec3(box.sigma_s) *
                                  box_segment(ray_at(scene, at), box.min, box.max).length());
              }),
        2e-5, 1e-6, "where a ray meets a face, in 32-bit floats, 1e-6 m at 5 m, times sigma"));
    EXPECT_TRUE(images_near(picture_of(still, still.composite),
                            ideal(scene, [](glm::dvec2) { return glm::dvec3(1); }), 1e-5, 1e-6,
                            "64 sums in 32-bit floats"));
}

// A slice's own extinction dims its source by (1 - exp(-tau)) / tau. Wronski leaves that out, so it
// is too bright by the inverse, whatever the number of slices in view.
TEST_F(Froxel, WronskisIntegrationIsTooBrightByItsKnownFactor)
{
    Scene scene = empty_scene(16);
    BoxMedium glow;
    glow.min = {-20, -8, -20};
    glow.max = {20, -4, 20};
    glow.sigma_a = glm::vec3(1);
    glow.emission = glm::vec3(1);
    scene.media = {glow};
    Settings settings = plain_froxels();
    settings.slice_spacing = Settings::SliceSpacing::linear;
    for (const int slices : {4, 16, 64}) {
        settings.slices = slices;
        settings.integration = Settings::Integration::hillaire;
        const Still right = render(scene, settings);
        settings.integration = Settings::Integration::wronski;
        const Still wrong = render(scene, settings);
        for (const int at : {0, 8}) {
            const double tau = 4.0 / slices * ray_of(scene, at, at).length_per_z;
            const double factor = tau / -std::expm1(-tau);
            const double measured =
                pixel(wrong.scattering, 16, at, at).r / pixel(right.scattering, 16, at, at).r;
            EXPECT_NEAR(measured, factor, 1e-4) << slices << " slices, pixel " << at;
            figure(fmt::format("Wronski over Hillaire, {} slices", slices), measured);
        }
        EXPECT_EQ(right.transmittance, wrong.transmittance);
    }
}

// Tricubic lookup smooths: a uniform medium stays as it is within what a B-spline of slices does to
// an exponential, tau^2 / 6 of a slice of optical depth tau.
TEST_F(Froxel, TricubicLookupKeepsUniformFog)
{
    Scene scene = stairs_in_fog(Camera::Projection::perspective);
    Settings settings = plain_froxels(4);
    settings.slices = 256;
    const Still linear = render(scene, settings);
    settings.lookup = Settings::Lookup::tricubic;
    const Still cubic = render(scene, settings);
    // The thickest of 256 slices over 40 m: 0.21 m, of 0.9 1/m.
    const double tolerance = 0.19 * 0.19 / 6;
    EXPECT_TRUE(images_near(picture_of(cubic, cubic.transmittance),
                            picture_of(linear, linear.transmittance), tolerance, tolerance / 2,
                            "a B-spline of an exponential"));
    EXPECT_NE(cubic.transmittance, linear.transmittance);
}

/// A lump of noise in a sun, partly behind a ball.
Scene lump_scene(int size)
{
    Scene scene = empty_scene(size);
    scene.camera.vfov_deg = 40;
    BoxMedium cloud;
    cloud.min = {-1.5, -6.5, -1.5};
    cloud.max = {1.5, -3.5, 1.5};
    cloud.profile = NoiseProfile{.feature_size = 1.2, .octaves = 2, .threshold = 0.4, .seed = 5};
    cloud.sigma_s = {2.0f, 2.0f, 2.0f};
    cloud.sigma_a = {0.2f, 0.2f, 0.2f};
    cloud.g = 0.3f;
    scene.media = {cloud};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    scene.surfaces = {SphereSurface{{0.3, -4.6, 0.1}, 0.5, glm::vec3(0.5f)}};
    return scene;
}

double relative_mse(const Still& a, const Still& b)
{
    return study::compare(a.scattering, b.scattering).relmse;
}

// Columns of a pixel and many slices: the march at full resolution, whose samples these then are.
TEST_F(Froxel, ConvergesToTheMarchAsFroxelsShrink)
{
    const Scene scene = lump_scene(32);
    Settings march = plain_settings();
    march.steps = 512;
    const Still truth = render(scene, march);
    double before = 1;
    for (const auto& [tile, slices] : {std::pair{8, 32}, {4, 64}, {2, 128}, {1, 256}}) {
        Settings settings = plain_froxels(tile);
        settings.slices = slices;
        const double error = relative_mse(render(scene, settings), truth);
        figure(fmt::format("relMSE of scattering, tile {}, {} slices", tile, slices), error);
        EXPECT_LT(error, 0.5 * before) << tile << ", " << slices;
        before = error;
    }
    EXPECT_LT(before, 2e-5) << "at tile 1 the columns are the march's rays";
}

// -- history -------------------------------------------------------------------------------------

Settings gathering(int tile)
{
    Settings settings;
    settings.mode = Settings::Mode::froxel;
    settings.tile = tile;
    settings.slices = 24;
    settings.shadow_map = 256;
    settings.bounces = 0;
    settings.format = Settings::Format::rgba32f;
    return settings;
}

// Without jitter every frame is the same, and so is what they gather.
TEST_F(Froxel, HistoryOfAStillSceneIsTheSceneItself)
{
    const Scene scene = lump_scene(24);
    Settings settings = gathering(4);
    settings.jitter = Settings::Jitter::none;
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    EXPECT_EQ(run(renderer, view, scene, settings, 1).history, "none: first frame");
    const LayerImages first = layers;
    EXPECT_EQ(run(renderer, view, scene, settings, 40).history, "kept: nothing moved");
    for (std::size_t i = 0; i < first.scattering.size(); ++i) {
        ASSERT_NEAR(layers.scattering[i], first.scattering[i], 1e-5f * (1 + first.scattering[i]));
        ASSERT_NEAR(layers.transmittance[i], first.transmittance[i], 1e-5f);
    }
}

// A long mean makes small steps, which 16 bits can't take but by a dither: it is to bring them as
// near to the truth as 32 bits, and no further away from it the longer they gather.
TEST_F(Froxel, AStillConvergesAndDoesNotStall)
{
    const Scene scene = lump_scene(24);
    const auto gathered = [&](Settings::Format format, int frames) {
        Settings settings = gathering(4);
        settings.history_format = format;
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        run(renderer, view, scene, settings, frames);
        return layers.scattering;
    };
    const std::vector<float> truth = gathered(Settings::Format::rgba32f, 2048);
    double bias = 0;
    const auto error = [&](Settings::Format format, int frames) {
        const study::Metrics m = study::compare(gathered(format, frames), truth);
        const char* bits = format == Settings::Format::rgba32f ? "32 bits" : "16 bits";
        figure(fmt::format("relMSE after {} frames, {}", frames, bits), m.relmse);
        figure(fmt::format("bias after {} frames, {}", frames, bits), m.bias);
        bias = m.bias;
        return m.relmse;
    };
    const double at_1 = error(Settings::Format::rgba32f, 1);
    const double at_16 = error(Settings::Format::rgba32f, 16);
    const double at_256 = error(Settings::Format::rgba32f, 256);
    EXPECT_LT(at_16, at_1 / 10) << "independent samples make it 16";
    EXPECT_LT(at_256, at_16 / 16);
    EXPECT_LT(error(Settings::Format::rgba16f, 256), 1.5 * at_256);
    EXPECT_LT(error(Settings::Format::rgba16f, 1024), 0.5 * at_256) << "by less the more there are";
    EXPECT_LT(std::abs(bias), 1.0 / 2048)
        << "what a half rounds by at most; without a dither it is 0.1";
}

TEST_F(Froxel, HistoryIsDroppedForAReasonThatIsTold)
{
    Settings settings = gathering(4);
    Settings others = settings;
    others.shadow_steps = 4;
    expect_dropped_for_reasons(lump_scene(24), settings, others,
                               [&](const Scene& scene, const Settings& how, std::uint64_t number) {
                                   Renderer renderer(get_proc());
                                   View view = renderer.make_view();
                                   renderer.set_scene(scene, how);
                                   run(renderer, view, scene, how, 1, number);
                                   return layers.scattering;
                               });
}

// In fog that changes slowly from place to place, what is reprojected is what is there: no ghost of
// where the view was, no drift of brightness with the way it goes, though scattering towards the
// eye changes with the angle.
TEST_F(Froxel, AMovingViewIsReprojected)
{
    Scene scene = empty_scene(32);
    scene.camera.vfov_deg = 40;
    BoxMedium fog;
    fog.min = {-30, -30, -30};
    fog.max = {30, 2, 30};
    fog.profile = ExpHeightProfile{.scale_height = 3};
    fog.sigma_s = glm::vec3(0.1f);
    fog.g = 0.3f;
    scene.media = {fog};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    Settings settings = gathering(4);
    settings.slices = 64;
    settings.jitter = Settings::Jitter::none;
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    struct Way {
        const char* name;
        glm::dvec3 travel, turn;  ///< a frame
    };
    constexpr double kTravel = 0.04, kTurn = 0.01;
    const Way ways[] = {
        {"right", {kTravel, 0, 0}, {0, 0, 0}},    {"left", {-kTravel, 0, 0}, {0, 0, 0}},
        {"back", {0, kTravel, 0}, {0, 0, 0}},     {"ahead", {0, -kTravel, 0}, {0, 0, 0}},
        {"turn right", {0, 0, 0}, {kTurn, 0, 0}}, {"rise", {0, 0, kTravel}, {0, 0, 0}},
    };
    for (const Way& way : ways) {
        renderer.set_scene(scene, settings);
        view.reset_history();
        FrameReport report;
        for (int i = 0; i < 24; ++i) {
            scene.camera.position = way.travel * double(i);
            scene.camera.look_at =
                scene.camera.position + glm::dvec3(0, -1, 0) + way.turn * double(i);
            report = run(renderer, view, scene, settings, 1);
        }
        EXPECT_EQ(report.history, "reprojected");
        const std::vector<float> moved = layers.scattering;
        view.reset_history();
        run(renderer, view, scene, settings, 1);
        const study::Metrics m = study::compare(moved, layers.scattering);
        figure(fmt::format("relMSE after 24 frames, {}", way.name), m.relmse);
        figure(fmt::format("bias after 24 frames, {}", way.name), m.bias);
        EXPECT_LT(m.relmse, 5e-4) << way.name
                                  << ": reprojection smooths the fog's fall with height";
        EXPECT_LT(std::abs(m.bias), 0.02) << way.name;
    }
}

// Extinction of one colour is kept as one number in volumes that are there anyway. A medium of
// another colour, out of view, has it kept as three: the same picture, of more bytes.
TEST_F(Froxel, ExtinctionOfOneColorTakesOneNumber)
{
    Scene scene = empty_scene(32);
    scene.camera.vfov_deg = 40;
    BoxMedium fog;
    fog.min = {-30, -30, -30};
    fog.max = {30, 2, 30};
    fog.profile = ExpHeightProfile{.scale_height = 3};
    fog.sigma_s = {0.05f, 0.1f, 0.2f};
    fog.sigma_a = {0.01f, 0.02f, 0.04f};
    scene.media = {fog};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(4)}};
    BoxMedium behind;
    behind.min = {-1, 1, -1};
    behind.max = {1, 1.5, 1};
    behind.sigma_s = {0.1f, 0, 0};
    Settings settings = gathering(4);
    settings.format = settings.history_format = Settings::Format::rgba32f;
    settings.bounces = 0;
    const auto moved_view = [&] {
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        std::uint64_t bytes = 0;
        for (int i = 0; i < 6; ++i) {
            scene.camera.position = {0.02 * i, 0, 0};
            scene.camera.look_at = scene.camera.position + glm::dvec3(0, -1, 0);
            bytes = run(renderer, view, scene, settings, 1).gpu_bytes;
        }
        return bytes;
    };
    const std::uint64_t of_one = moved_view();
    const LayerImages one = layers;
    scene.media.emplace_back(behind);
    const std::uint64_t of_three = moved_view();
    for (std::size_t i = 0; i < one.scattering.size(); ++i) {
        ASSERT_NEAR(layers.scattering[i], one.scattering[i], 1e-5f * (1 + one.scattering[i]));
        ASSERT_NEAR(layers.transmittance[i], one.transmittance[i], 1e-5f);
    }
    // Of 32 bits: two volumes of two channels, where one colour has its transmittance in one.
    const auto froxels = static_cast<std::uint64_t>(10 * 10 * (settings.slices + 1));
    EXPECT_GE(of_three, of_one + 8 * froxels);
}

// Extinction of three numbers and transmittance are where the formats have place for them, whether
// what is integrated lies where the history was or not, whether light is dimmed by the media or by
// the grid, and while a light changes.
TEST_F(Froxel, ThreeNumbersOfExtinctionAreTheSameInEveryFormat)
{
    using Format = Settings::Format;
    Scene scene = empty_scene(16);
    BoxMedium fog;
    fog.min = {-60, -12, -60};
    fog.max = {60, 2, 60};
    fog.sigma_s = {0.02f, 0.05f, 0.1f};
    BoxMedium haze = fog;
    haze.sigma_s = {};
    haze.sigma_a = {0.2f, 0.01f, 0.0f};
    haze.emission = {0.01f, 0.02f, 0.03f};
    scene.media = {fog, haze};
    const auto gathered = [&](Format target, Format kept, Settings::FroxelShadows shadows) {
        Settings settings = gathering(8);
        settings.jitter = Settings::Jitter::none;
        settings.format = target;
        settings.history_format = kept;
        settings.froxel_shadows = shadows;
        settings.ambient_volume_size = 0;
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        for (const float sun : {4.0f, 3.0f}) {
            scene.lights = {SunLight{{0.5, 0.3, 0.8}, sun * glm::vec3(1, 0.7f, 0.4f)}};
            renderer.set_scene(scene, settings);
            run(renderer, view, scene, settings, 3, sun == 4 ? 0 : 3);
        }
        return layers;
    };
    const auto check = [&](const LayerImages& truth, Format target, Format kept,
                           Settings::FroxelShadows shadows) {
        const LayerImages seen = gathered(target, kept, shadows);
        const bool small = target == Format::r11g11b10f || kept == Format::r11g11b10f;
        double worst = 0;
        for (std::size_t i = 0; i < truth.scattering.size(); ++i)
            for (const double ratio :
                 {double(seen.scattering[i]) / double(truth.scattering[i]),
                  double(seen.transmittance[i]) / double(truth.transmittance[i])})
                worst = std::max(worst, std::abs(ratio - 1));
        EXPECT_LT(worst, small ? 0.08 : 4e-3)
            << "units in the last place, of 5 or 10 bits, a few times over; target "
            << static_cast<int>(target) << ", history " << static_cast<int>(kept);
    };
    const auto media = Settings::FroxelShadows::media, grid = Settings::FroxelShadows::grid;
    const LayerImages truth = gathered(Format::rgba32f, Format::rgba32f, media);
    EXPECT_LT(truth.transmittance[0], 0.9f * truth.transmittance[2]);
    EXPECT_LT(truth.transmittance[2], 0.9f * truth.transmittance[1]);
    check(truth, Format::r11g11b10f, Format::r11g11b10f, media);
    check(truth, Format::r11g11b10f, Format::rgba16f, media);
    check(truth, Format::rgba16f, Format::r11g11b10f, media);
    check(truth, Format::rgba16f, Format::rgba16f, media);
    check(truth, Format::rgba16f, Format::rgba32f, media);
    check(gathered(Format::rgba32f, Format::rgba32f, grid), Format::rgba16f, Format::rgba16f, grid);
}

// Froxels of 32 bits, or of a target of 32, keep 32 unless they are asked for less.
TEST_F(Froxel, WhatIsKeptIsAsFineAsWhatIsIntegrated)
{
    const Scene scene = lump_scene(24);
    const auto gathered = [&](Settings::Format target, Settings::Format kept) {
        Settings settings = gathering(4);
        settings.format = target;
        settings.history_format = kept;
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        run(renderer, view, scene, settings, 3);
        return layers.scattering;
    };
    using Format = Settings::Format;
    for (const Format target : {Format::rgba16f, Format::rgba32f}) {
        const std::vector<float> chosen = gathered(target, Format::automatic);
        EXPECT_EQ(chosen, gathered(target, target));
        const Format other = target == Format::rgba16f ? Format::rgba32f : Format::rgba16f;
        EXPECT_NE(chosen, gathered(target, other)) << "or there is nothing to choose";
    }
}

// All that froxels take, by what slices add to it, of the default formats: source and extinction of
// this frame, and of the last one's, where this frame's are integrated; of one colour of extinction
// transmittance besides. What glows and a history take no more. At 3840x2160 482 x 272 columns of
// three numbers are 205 MB of the 400 that a picture may take.
TEST_F(Froxel, AFroxelTakesTwiceWhatItHasToKeep)
{
    struct Case {
        const char* name;
        std::vector<glm::vec3> sigma_s;  ///< by medium
        bool glows;
        std::uint64_t bytes;  ///< of a froxel
    };
    const Case cases[] = {
        {"grey", {{2, 2, 2}}, false, 16},
        {"grey and glowing", {{2, 2, 2}}, true, 16},
        {"of one colour", {{1, 2, 3}}, true, 20},
        {"of two colours", {{1, 2, 3}, {3, 2, 1}}, true, 24},
    };
    const std::uint64_t columns = 10 * 10;
    for (const Case& c : cases) {
        Scene scene = lump_scene(64);
        BoxMedium lump = std::get<BoxMedium>(scene.media[0]);
        lump.sigma_a = glm::vec3(0);
        lump.emission = glm::vec3(c.glows ? 1 : 0);
        scene.media.clear();
        for (const glm::vec3 sigma_s : c.sigma_s) {
            lump.sigma_s = sigma_s;
            scene.media.emplace_back(lump);
        }
        const auto bytes = [&](int slices, int frames) {
            Settings settings;
            settings.mode = Settings::Mode::froxel;
            settings.bounces = 0;
            settings.slices = slices;
            return bytes_of(scene, settings, frames);
        };
        // A frame alone, and one with a history of more slices: what else they take is the same.
        EXPECT_EQ(bytes(64, 2) - bytes(16, 1), (64 - 16) * c.bytes * columns) << c.name;
        const std::uint64_t at_4k = std::uint64_t{482} * 272 * (64 + 1) * c.bytes;
        figure(fmt::format("MB of froxels at 3840x2160, {}", c.name),
               static_cast<double>(at_4k) / 1e6);
        EXPECT_LE(at_4k, 205000000U) << c.name;
    }
}

// A view that moves ahead looks its history up behind the middle of the last slice. What was
// integrated is behind it, and is not to be met.
TEST_F(Froxel, AHistoryEndsAtItsLastSlice)
{
    Scene scene = empty_scene(32);
    BoxMedium fog;
    fog.min = {-60, -60, -60};
    fog.max = {60, 60, 60};
    fog.sigma_s = {1e-4f, 2e-4f, 3e-4f};  // transmittance is many times a froxel's extinction
    scene.media = {fog};
    scene.world.radiance = glm::vec3(1);
    Settings settings = gathering(4);
    settings.jitter = Settings::Jitter::none;
    settings.ambient_volume_size = 0;
    settings.range = Settings::Range::camera;
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    // By a fifth of the last slice, back and ahead.
    for (int i = 0; i < 24; ++i) {
        scene.camera.position = {0, i % 2 == 0 ? 0.5 : 0, 0};
        scene.camera.look_at = scene.camera.position + glm::dvec3(0, -1, 0);
        run(renderer, view, scene, settings, 1);
    }
    const LayerImages moved = layers;
    view.reset_history();
    run(renderer, view, scene, settings, 1);
    for (std::size_t i = 0; i < moved.scattering.size(); ++i) {
        ASSERT_NEAR(moved.scattering[i], layers.scattering[i], 1e-3f * layers.scattering[i]) << i;
        ASSERT_NEAR(moved.transmittance[i], layers.transmittance[i], 1e-4f) << i;
    }
}

TEST_F(Froxel, ViewsKeepTheirOwnHistory)
{
    const Scene scene = lump_scene(24);
    Scene other = scene;
    other.camera.look_at = {0.5, -1, 0.2};
    const Settings settings = gathering(4);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    run(renderer, view, scene, settings, 4);
    const LayerImages alone = layers;

    HostPicture left(gl(), glm::ivec2(24)), right(gl(), glm::ivec2(24));
    left.look(scene.camera);
    right.look(other.camera);
    View left_view = renderer.make_view(), right_view = renderer.make_view();
    for (std::uint64_t i = 0; i < 4; ++i) {
        left.frame.index = right.frame.index = i;
        for (const bool is_left : {false, true}) {
            const Frame& frame = (is_left ? left : right).frame;
            renderer.draw_surfaces(frame, settings, false);
            renderer.composite(is_left ? left_view : right_view, frame, settings);
        }
    }
    EXPECT_EQ(renderer.read_layers(left_view, left.frame, settings).scattering, alone.scattering);
}

// -- shadows -------------------------------------------------------------------------------------

// 2017 marched shadows inside the view: a cloud beside it threw none.
TEST_F(Froxel, GridShadowsMissWhatIsOutOfView)
{
    Scene scene = empty_scene(16);
    scene.camera.vfov_deg = 40;
    BoxMedium fog;
    fog.min = {-2, -6, -2};
    fog.max = {2, -4, 2};
    fog.sigma_s = glm::vec3(0.05f);
    scene.media = {fog};
    scene.lights = {SunLight{{1, 0, 0}, glm::vec3(3)}};
    BoxMedium cloud;
    cloud.min = {10, -7, -7};
    cloud.max = {11, -3, 7};
    cloud.sigma_a = glm::vec3(2);
    const auto middle = [&](Settings::FroxelShadows shadows, bool clouded) {
        scene.media = {fog};
        if (clouded)
            scene.media.emplace_back(cloud);
        Settings settings = plain_froxels(2);
        settings.froxel_shadows = shadows;
        return pixel(render(scene, settings).scattering, 16, 8, 8).r;
    };
    const auto media = Settings::FroxelShadows::media, grid = Settings::FroxelShadows::grid;
    EXPECT_NEAR(middle(media, true) / middle(media, false), std::exp(-2.0), 1e-3);
    EXPECT_NEAR(middle(grid, true) / middle(grid, false), 1, 0.01) << "2017's fault is to be there";
    // In view it sees the fog's own shadow.
    fog.sigma_s = glm::vec3(0.5f);
    EXPECT_NEAR(middle(grid, false) / middle(media, false), 1, 0.15);
}

// -- references ----------------------------------------------------------------------------------

// The same pictures as the march is held to in reference_test.cpp. S2's scattering is left out
// there too: the world's light is not dimmed by the media yet.
TEST_F(Froxel, AgreesWithPathTracing)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference";
    if (!fs::exists(folder / "S1.json"))
        GTEST_SKIP() << "no reference pictures in " << folder;
    Settings settings = find_preset("froxel");
    settings.bounces = 0;  // the path tracer's light scatters once
    settings.tile = 4;
    settings.slices = 128;
    const auto check = [&](const char* scene, const char* layer, const std::vector<float>& picture,
                           double relmse) {
        const Image reference =
            write::read_exr(folder / fmt::format("{}_{}.exr", scene, layer), {"R", "G", "B"});
        const study::Metrics m = study::compare(picture, reference.pixels);
        figure(fmt::format("{} {} relMSE", scene, layer), m.relmse);
        figure(fmt::format("{} {} bias", scene, layer), m.bias);
        EXPECT_LE(m.relmse, relmse) << scene << ' ' << layer;
        EXPECT_LT(std::abs(m.bias), 0.02) << scene << ' ' << layer;
    };
    for (const char* scene : {"S1", "S2"}) {
        const asset::LoadedScene loaded = asset::load_scene(folder / fmt::format("{}.json", scene));
        StillOptions options;
        options.timed_frames = 3;
        StillReport report;
        const Still still = scene_renderer().render(loaded.scene, settings, options, &report);
        EXPECT_EQ(report.history, "kept: nothing moved");
        const bool s1 = std::string_view(scene) == "S1";
        check(scene, "transmittance", still.transmittance, s1 ? 1e-3 : 5e-3);
        if (s1)
            check(scene, "scattering", still.scattering, 2e-3);
    }
}

}  // namespace
}  // namespace fumarole::test
