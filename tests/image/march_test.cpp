// What the march leaves out to be fast: empty bricks, what lies behind next to nothing, and a
// second pass over the picture.

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "image_test.h"

namespace fumarole::test {
namespace {

class MarchSpeed : public ImageTest {
protected:
    /// Coloured smoke in some of 6^3 bricks of 0.8 m, with gaps between, before a wall and the sky.
    static Scene patches()
    {
        GridMedium smoke;
        const glm::dmat4 placed =
            glm::scale(glm::translate(glm::dmat4(1), {-2.4, 4, -2.4}), glm::dvec3(0.1));
        smoke.density = make_grid({6, 6, 6}, placed, [](glm::ivec3 i) {
            const glm::ivec3 brick = i / 8;
            const bool there = (brick.x * 5 + brick.y * 3 + brick.z * 7) % 4 == 0;
            return there ? 0.5 + 0.4 * std::sin(i.x + 0.7 * i.y + 0.3 * i.z) : 0.0;
        });
        smoke.sigma_s_per_density = {1, 2, 3};
        smoke.sigma_a_per_density = glm::vec3(0.2f);
        smoke.g = 0.3f;
        Scene scene = empty_scene();
        scene.resolution = {96, 64};
        scene.camera.position = {0, -3, 0.4};
        scene.camera.look_at = {0, 5, 0};
        scene.camera.vfov_deg = 50;
        scene.media = {smoke};
        scene.world.radiance = {0.2f, 0.3f, 0.4f};
        scene.lights = {SunLight{{0.3, -0.4, 0.8}, {5, 4, 3}}};
        return scene;
    }

    static Still draw(const Scene& scene, Settings settings, bool skip, double& samples)
    {
        settings.empty_space_skipping = skip;
        StillReport report;
        Still still = scene_renderer().render(scene, settings, {}, &report);
        samples = report.samples;
        return still;
    }
};

TEST_F(MarchSpeed, EmptyBricksLeftOutLeaveThePictureAsItIs)
{
    const Scene scene = patches();
    const auto compare = [&](int resolution, medium::Storage storage, medium::Layout layout) {
        Settings settings = plain_settings(resolution);
        settings.storage = storage;
        settings.layout = layout;
        settings.jitter = Settings::Jitter::blue;
        double samples = 0, all_samples = 0;
        const Still with = draw(scene, settings, true, samples),
                    without = draw(scene, settings, false, all_samples);
        // A tile of a quarter-size layer is 32 pixels wide: here each sees some smoke.
        EXPECT_LT(samples, resolution == 4 ? all_samples + 1 : all_samples);
        // Both take the same samples of what is not 0; a place on a brick's border may round to
        // either side of it, where the field is 0 to rounding.
        EXPECT_LT(max_difference(picture_of(with, with.composite),
                                 picture_of(without, without.composite)),
                  1e-6)
            << "1 / " << resolution;
        EXPECT_LT(max_difference(picture_of(with, with.transmittance),
                                 picture_of(without, without.transmittance)),
                  1e-6);
    };
    for (const int resolution : {1, 2, 4})
        compare(resolution, medium::Storage::r32f, medium::Layout::automatic);
    for (const medium::Storage storage : {medium::Storage::r8, medium::Storage::automatic})
        compare(2, storage, medium::Layout::bricks);
}

// Where no surface shades a tile it is not asked for. Half of the smoke lies in the shadow of a
// board.
TEST_F(MarchSpeed, LitTilesLeaveThePictureAsItIs)
{
    Scene scene = patches();
    scene.surfaces = {
        BoxSurface{.min = {-3, -1, 1.6}, .max = {-0.6, 6, 1.7}, .albedo = glm::vec3(0.5f)}};
    for (const int resolution : {1, 2}) {
        Settings settings = plain_settings(resolution);
        const Still with = render(scene, settings);
        settings.empty_space_skipping = false;
        const Still without = render(scene, settings);
        const Image shaded = picture_of(with, with.scattering);
        EXPECT_LT(max_difference(shaded, picture_of(without, without.scattering)), 1e-6)
            << "1 / " << resolution;
        Scene bare = scene;
        bare.surfaces[0] =
            BoxSurface{.min = {-3, 20, 1.6}, .max = {-0.6, 26, 1.7}, .albedo = glm::vec3(0.5f)};
        settings.empty_space_skipping = true;
        const Still all_lit = render(bare, settings);
        EXPECT_GT(max_difference(shaded, picture_of(all_lit, all_lit.scattering)), 0.1)
            << "the board shades some of it";
    }
}

TEST_F(MarchSpeed, EmptyPartsOfNoiseLeftOutLeaveEveryBitOfThePictureAsItIs)
{
    Scene scene = patches();
    BoxMedium cloud{.min = {-2, 4, -1.5},
                    .max = {2, 8, 2},
                    .profile = NoiseProfile{.feature_size = 1.3, .octaves = 3, .threshold = 0.58},
                    .sigma_s = {3, 4, 5}};
    for (const int resolution : {1, 2, 4})
        for (const bool drifts : {false, true}) {
            std::get<NoiseProfile>(cloud.profile).drift.x = drifts ? 1 : 0;
            scene.media = {cloud};
            scene.time = 0.4;
            Settings settings = plain_settings(resolution);
            settings.jitter = Settings::Jitter::blue;
            settings.spacing = Settings::Spacing::fixed;
            double samples = 0, all_samples = 0;
            const Still with = draw(scene, settings, true, samples),
                        without = draw(scene, settings, false, all_samples);
            EXPECT_EQ(with.composite, without.composite) << "1 / " << resolution;
            EXPECT_EQ(with.transmittance, without.transmittance) << "1 / " << resolution;
            if (drifts)
                EXPECT_EQ(samples, all_samples);
            else
                EXPECT_LT(samples, (resolution == 1 ? 0.85 : 1) * all_samples);
        }
}

TEST_F(MarchSpeed, SurfacesThatAreNotLookedUpThrowNoShadowOnTheMedia)
{
    Scene scene = patches();
    const BoxSurface ground{.min = {-30, -30, -4}, .max = {30, 30, -3}, .albedo = glm::vec3(0.4f)};
    const BoxSurface roof{.min = {-1, 5, 3}, .max = {1, 7, 3.1}, .albedo = glm::vec3(0.4f)};
    const glm::dvec3 above(0.3, 6, 6);
    const std::vector<Light> lights{
        SunLight{.direction_to_light = {0.1, -0.2, 1}, .irradiance = glm::vec3(6)},
        PointLight{.position = above, .radiant_intensity = glm::vec3(90)},
        SpotLight{.position = above,
                  .direction = {0, 0, -1},
                  .cone_deg = 120,
                  .radiant_intensity = glm::vec3(90)}};
    for (const Light& light : lights)
        for (const bool roofed : {false, true}) {
            scene.lights = {light};
            scene.surfaces = {ground};
            if (roofed)
                scene.surfaces.emplace_back(roof);
            Settings settings = plain_settings();
            settings.spacing = Settings::Spacing::fixed;
            const Still quick = render(scene, settings);
            settings.empty_space_skipping = false;
            const Still slow = render(scene, settings);
            EXPECT_LT(max_difference(picture_of(quick, quick.composite),
                                     picture_of(slow, slow.composite)),
                      1e-6)
                << "a light of kind " << light.index() << (roofed ? ", with a roof" : "");
        }
}

TEST_F(MarchSpeed, NothingIsDrawnWhereNoBrickIsInView)
{
    Scene scene = patches();
    scene.camera.look_at = {5, 5, 0};  // the smoke is in the left part of the picture alone
    for (const int resolution : {1, 2, 4}) {
        const Still still = render(scene, plain_settings(resolution));
        int untouched = 0;
        for (std::size_t y = 0; y < 64; ++y)
            for (std::size_t x = 88; x < 96; ++x)
                for (std::size_t c = 0; c < 3; ++c) {
                    const std::size_t i = (y * 96 + x) * 3 + c;
                    untouched += still.composite[i] == still.surface_lit[i] ? 1 : 0;
                }
        EXPECT_EQ(untouched, 64 * 8 * 3) << "1 / " << resolution;
    }
}

TEST_F(MarchSpeed, EarlyEndErrsByNoMoreThanWhatItStillLetThrough)
{
    BoxMedium fog;
    fog.min = {-9, 2, -9};
    fog.max = {9, 12, 9};
    fog.sigma_s = {0.9f, 0.9f, 0.9f};
    fog.sigma_a = {0.1f, 0.1f, 0.1f};
    Scene scene = empty_scene();
    scene.resolution = {32, 32};
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, 1, 0};
    scene.media = {fog};
    scene.world.radiance = glm::vec3(2);
    Settings settings = plain_settings();
    settings.ambient_volume_size =
        0;  // the same from all around: no source is brighter than the world
    const Still whole = render(scene, settings);
    double before = 0;
    for (const float end : {1e-3f, 1e-2f, 1e-1f}) {
        settings.min_transmittance = end;
        const Still cut = render(scene, settings);
        const double transmittance = max_difference(picture_of(cut, cut.transmittance),
                                                    picture_of(whole, whole.transmittance));
        const double scattering =
            max_difference(picture_of(cut, cut.scattering), picture_of(whole, whole.scattering));
        EXPECT_LE(transmittance, end);
        EXPECT_LE(scattering, end * 0.9 * 2.0 * 1.001);  // albedo, radiance; rounding of sums
        EXPECT_GT(scattering, before) << "a ray must have ended early to be judged";
        before = scattering;
    }
}

TEST_F(MarchSpeed, OnePassBlendsWhatTwoDo)
{
    const Scene scene = patches();
    for (const Settings::Mode mode : {Settings::Mode::raymarch, Settings::Mode::froxel})
        for (const auto upsample : {Settings::Upsample::bilinear2x2, Settings::Upsample::tent4x4}) {
            Settings settings = plain_settings(2);
            settings.mode = mode;
            settings.upsample = upsample;
            settings.resolve_passes = 1;
            const Still one = render(scene, settings);
            settings.resolve_passes = 2;
            const Still two = render(scene, settings);
            // The same product and sum, once in a register and once through a 32-bit picture.
            EXPECT_LT(
                max_difference(picture_of(one, one.composite), picture_of(two, two.composite)),
                5e-7);
        }
}

// 1/d^2 of a light 5 cm beside a ray of 20 m, in 8 steps: the pole lies within one of them.
TEST_F(MarchSpeed, FalloffOverAStepIsItsIntegral)
{
    BoxMedium fog;
    fog.min = {-20, 0, -20};
    fog.max = {20, 20, 20};
    fog.sigma_s = glm::vec3(1e-4f);
    Scene scene = empty_scene();
    scene.resolution = {3, 3};
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, 1, 0};
    scene.camera.vfov_deg = 20;
    scene.media = {fog};
    const glm::dvec3 light(0.05, 7.3, 0);
    scene.lights = {PointLight{light, glm::vec3(10)}};
    Settings settings = plain_settings();
    settings.steps = 8;
    settings.falloff = Settings::Falloff::exact;
    const auto middle = [](const Still& still) { return still.scattering[(1 * 3 + 1) * 3]; };
    const double exact = 1e-4 * 10 / (4 * M_PI) *
                         (std::atan((20 - light.y) / light.x) + std::atan(light.y / light.x)) /
                         light.x;
    EXPECT_NEAR(middle(render(scene, settings)), exact, 2e-3 * exact)
        << "extinction of 1e-4 a metre, to the light and to the eye";
    settings.falloff = Settings::Falloff::sampled;
    EXPECT_GT(std::abs(middle(render(scene, settings)) - exact), 0.1 * exact);
}

// -- where a texel is too large -------------------------------------------------------------------

/// What pixels see of fog around a sun, marched at half the size: each by a ray of its own where
/// what the fog scatters changes within a texel.
class FineTiles : public ImageTest {
protected:
    static Scene fog_ahead()
    {
        Scene scene = empty_scene();
        scene.resolution = {64, 64};
        scene.camera.position = {0, 0, 0};
        scene.camera.look_at = {0, 1, 0};
        scene.camera.vfov_deg = 20;
        BoxMedium fog;
        fog.min = {-40, 2, -40};
        fog.max = {40, 12, 40};
        fog.sigma_s = glm::vec3(1e-4f);
        scene.media = {fog};
        return scene;
    }
    static constexpr glm::dvec3 kLow{-40, 2, -40}, kHigh{40, 12, 40};

    /// The largest error of a pixel, of its value, in the red channel.
    static double worst(const Scene& scene, const Settings& settings,
                        const std::function<double(const PixelRay&)>& exact)
    {
        const Still still = render(scene, settings);
        double most = 0;
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x) {
                const double actual =
                    still.scattering[static_cast<std::size_t>((y * still.width + x) * 3)];
                const double once = exact(ray_of(scene, x, y));
                most = std::max(most, std::abs(actual / once - 1));
                const double blended = pixel(still.composite, still.width, x, y).r;
                if (!scene.surfaces.empty())
                    continue;
                // Before a black world: no tile is blended twice.
                EXPECT_NEAR(blended / actual, 1, 1e-3) << "pixel " << x << " " << y;
            }
        return most;
    }
};

TEST_F(FineTiles, HaveTheLobeRoundASunInView)
{
    Scene scene = fog_ahead();
    const glm::dvec3 wi = glm::normalize(glm::dvec3(0.03, 1, -0.02));
    for (const auto passes : {Settings::Passes::fragment, Settings::Passes::compute})
        for (const float g : {0.98f, -0.98f, 0.997f, -0.997f}) {
            std::get<BoxMedium>(scene.media[0]).g = g;
            scene.lights = {SunLight{g > 0 ? wi : -wi, glm::vec3(2)}};
            Settings settings = plain_settings(2);
            settings.passes = passes;
            settings.g_clamp = 0.999f;
            const double error = worst(scene, settings, [&](const PixelRay& ray) {
                const double phase = henyey_greenstein(glm::dot(wi, ray.direction), std::abs(g));
                return 2 * phase * 1e-4 * box_segment(ray, kLow, kHigh).length();
            });
            figure(fmt::format("g {}", g), error);
            // What dims it, 1e-3 to 2e-3, and beyond them texels that span a twentieth of the lobe.
            EXPECT_LT(error, 6e-3);
        }
}

// Each frame has its own: a sun that leaves the view takes them with it.
TEST_F(FineTiles, ComeAndGoWithTheSun)
{
    Scene scene = fog_ahead();
    std::get<BoxMedium>(scene.media[0]).g = 0.98f;
    const auto with_sun = [&](glm::dvec3 wi) {
        scene.lights = {SunLight{glm::normalize(wi), glm::vec3(2)}};
        return worst(scene, plain_settings(2), [&](const PixelRay& ray) {
            const double phase =
                henyey_greenstein(glm::dot(glm::normalize(wi), ray.direction), 0.98f);
            return 2 * phase * 1e-4 * box_segment(ray, kLow, kHigh).length();
        });
    };
    EXPECT_LT(with_sun({0.03, 1, -0.02}), 6e-3);
    EXPECT_LT(with_sun({1, 0.3, 0}), 6e-3);
    EXPECT_LT(with_sun({-0.1, 1, 0.1}), 6e-3);
}

// A surface before part of the fog: a pixel has its own depth.
TEST_F(FineTiles, EndAtThePixelsOwnDepth)
{
    Scene scene = fog_ahead();
    scene.surfaces = {BoxSurface{{0.013, 4, -40}, {40, 4.1, 40}, glm::vec3(0.5f)}};
    // From behind and the left, so that the surface throws no shadow on what is seen.
    const glm::dvec3 wi = glm::normalize(glm::dvec3(0.1, 1, -0.02));
    BoxMedium& fog = std::get<BoxMedium>(scene.media[0]);
    fog.min = {-3, 2, -3};  // as wide as the view, so that a texel of the shadow map is narrow
    fog.max = {3, 12, 3};
    fog.g = -0.98f;
    scene.lights = {SunLight{-wi, glm::vec3(2)}};
    const double error = worst(scene, plain_settings(2), [&](const PixelRay& ray) {
        Segment in = box_segment(ray, fog.min, fog.max);
        const Segment behind = box_segment(ray, {0.013, 4, -40}, {40, 4.1, 40});
        if (behind.length() > 0)
            in.end = behind.begin;
        const double phase = henyey_greenstein(glm::dot(wi, ray.direction), 0.98f);
        return 2 * phase * 1e-4 * in.length();
    });
    figure("error", error);
    EXPECT_LT(error, 6e-3);
}

TEST_F(FineTiles, HaveTheLightAroundALamp)
{
    Scene scene = fog_ahead();
    const glm::dvec3 at(0.31, 7.3, -0.12);
    scene.lights = {PointLight{at, glm::vec3(10)}};
    Settings settings = plain_settings(2);
    settings.falloff = Settings::Falloff::exact;
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic}) {
        scene.camera.projection = projection;
        scene.camera.ortho_height = 3;
        const double error = worst(scene, settings, [&](const PixelRay& ray) {
            const Segment in = box_segment(ray, kLow, kHigh);
            const double nearest = glm::dot(at - ray.origin, ray.direction);
            const double d = glm::length(at - ray.origin - ray.direction * nearest);
            return 1e-4 * 10 / (4 * M_PI) *
                   (std::atan((in.end - nearest) / d) - std::atan((in.begin - nearest) / d)) / d;
        });
        figure("error", error);
        // Farther out, of 16 pixels from it, a texel's disc and its neighbours differ by less.
        EXPECT_LT(error, 0.02);
    }
}

// Thick fog dims it on both ways, by most where a step is far from it.
TEST_F(FineTiles, HaveTheMeanOfALampThatTheMediumDims)
{
    Scene scene = fog_ahead();
    scene.resolution = {15, 15};
    BoxMedium& fog = std::get<BoxMedium>(scene.media[0]);
    fog.sigma_s = {0.2f, 0.5f, 1.0f};
    fog.sigma_a = glm::vec3(0.1f);
    fog.g = 0.5f;
    const glm::dvec3 at(0.31, 7.3, -0.12);
    scene.lights = {PointLight{at, glm::vec3(10)}};
    Settings settings = plain_settings();
    settings.falloff = Settings::Falloff::exact;
    settings.steps = 16;
    const Still still = render(scene, settings);
    double worst = 0;
    for (int i = 0; i < 15 * 15; ++i) {
        const PixelRay ray = ray_of(scene, i % 15, i / 15);
        const Segment in = box_segment(ray, kLow, kHigh);
        const double nearest = glm::dot(at - ray.origin, ray.direction);
        const double d = glm::length(at - ray.origin - ray.direction * nearest);
        for (int c = 0; c < 3; ++c) {
            const double sigma_t = double(fog.sigma_s[c]) + double(fog.sigma_a[c]);
            // Over the angle that the lamp sees the ray under, in which 1/d^2 is even.
            const double exact =
                10 * double(fog.sigma_s[c]) / d *
                integrate(std::atan((in.begin - nearest) / d), std::atan((in.end - nearest) / d),
                          200, [&](double angle) {
                              const double s = nearest + d * std::tan(angle);
                              return henyey_greenstein(-std::sin(angle), 0.5) *
                                     std::exp(-sigma_t * (s - in.begin + d / std::cos(angle)));
                          });
            worst = std::max(
                worst, std::abs(still.scattering[static_cast<std::size_t>(3 * i + c)] / exact - 1));
        }
    }
    figure("error", worst);
    EXPECT_LT(worst, 0.01);
}

// A slab that dims the sun as it dims the eye: both grow evenly along a ray, and steps of half a
// metre have the integral wherever they are sampled.
TEST_F(FineTiles, HaveTheMeanOfASunThatTheirMediumDims)
{
    Scene scene = fog_ahead();
    scene.resolution = {7, 7};
    BoxMedium& fog = std::get<BoxMedium>(scene.media[0]);
    fog.min = {-40, 4, -40};
    fog.max = {40, 6, 40};
    fog.sigma_s = {0.2f, 0.5f, 1.0f};
    fog.sigma_a = glm::vec3(0.5f);
    Settings settings = plain_settings();
    settings.steps = 4;
    settings.jitter = Settings::Jitter::blue;
    for (const double side : {1.0, -1.0}) {
        fog.g = static_cast<float>(0.4 * side);
        const glm::dvec3 wi = glm::normalize(side * glm::dvec3(0.1, 1, 0.1));
        scene.lights = {SunLight{wi, glm::vec3(3)}};
        for (std::uint32_t index = 0; index < 4; ++index) {
            StillOptions options;
            options.seed = index;
            const Still still = scene_renderer().render(scene, settings, options);
            for (int i = 0; i < 49; ++i) {
                const PixelRay ray = ray_of(scene, i % 7, i / 7);
                const Segment in = box_segment(ray, fog.min, fog.max);
                const double phase = henyey_greenstein(glm::dot(wi, ray.direction), fog.g);
                for (int c = 0; c < 3; ++c) {
                    const double sigma_s = fog.sigma_s[c], sigma_t = sigma_s + 0.5;
                    const double exact =
                        3 * phase * sigma_s * integrate(in.begin, in.end, 8, [&](double s) {
                            const double y = ray.direction.y * s;
                            const double to_sun = (side > 0 ? 6 - y : 4 - y) / wi.y;
                            return std::exp(-sigma_t * (s - in.begin + to_sun));
                        });
                    const double actual = still.scattering[static_cast<std::size_t>(3 * i + c)];
                    EXPECT_NEAR(actual / exact, 1, 2e-4)
                        << "side " << side << ", frame " << index << ", pixel " << i;
                }
            }
        }
    }
}

/// A cube and a sheet in haze of 40 m, of which steps are longer than these are deep.
class SmallInWideHaze : public ImageTest, public testing::WithParamInterface<glm::dvec3> {};

TEST_P(SmallInWideHaze, HasStepsOfItsOwn)
{
    const glm::dvec3 half = GetParam();
    Scene scene = empty_scene(32);
    scene.camera.position = {0, -15, 1.2};
    scene.camera.vfov_deg = 3;
    BoxMedium haze;
    haze.min = glm::dvec3(-20);
    haze.max = glm::dvec3(20);
    haze.sigma_a = {0.02f, 0.01f, 0.03f};
    BoxMedium small = haze;
    small.min = -half;
    small.max = half;
    small.sigma_a = {3, 6, 1};
    scene.media = {haze, small};
    const Still still = render(scene, plain_settings());
    const Image expected = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        glm::dvec3 tau(0);
        for (const BoxMedium& box : {haze, small})
            tau += glm::dvec3(box.sigma_a) *
                   std::max(box_segment(ray, box.min, box.max, scene.camera.near * ray.length_per_z)
                                .length(),
                            0.0);
        return glm::exp(-tau);
    });
    EXPECT_TRUE(images_near(picture_of(still, still.transmittance), expected, 2e-4, 2e-5,
                            "steps end where it begins and ends, in 32-bit distances"));
}

INSTANTIATE_TEST_SUITE_P(Boxes, SmallInWideHaze,
                         testing::Values(glm::dvec3(0.2), glm::dvec3(15, 15, 0.02)));

}  // namespace
}  // namespace fumarole::test
