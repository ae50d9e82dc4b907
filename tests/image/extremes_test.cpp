// Sizes and numbers at the ends of what there is: no NaN, no infinity, and where there is a closed
// form, still it.

#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "image_test.h"

namespace fumarole::test {
namespace {

class Extremes : public ImageTest {
protected:
    static void expect_finite(const Still& still, const std::string& what)
    {
        const std::pair<const char*, const std::vector<float>*> layers[] = {
            {"composite", &still.composite},
            {"scattering", &still.scattering},
            {"transmittance", &still.transmittance},
            {"surfaces through media", &still.surface_lit}};
        for (const auto& [name, values] : layers)
            for (std::size_t i = 0; i < values->size(); ++i) {
                const float v = (*values)[i];
                if (std::isfinite(v) && v >= 0)
                    continue;
                ADD_FAILURE() << what << ": " << name << " is " << v << " at value " << i;
                break;
            }
        for (const float t : still.transmittance)
            if (t > 1) {
                ADD_FAILURE() << what << ": transmittance " << t;
                break;
            }
    }
    static Scene fog_scene(int size = 16)
    {
        Scene scene = empty_scene(size);
        scene.camera.vfov_deg = 40;
        BoxMedium fog;
        fog.min = {-8, -12, -8};
        fog.max = {8, 2, 8};
        scene.media = {fog};
        return scene;
    }
};

TEST_F(Extremes, OddSizes)
{
    for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(3, 5), glm::uvec2(33, 17),
                                  glm::uvec2(2, 1), glm::uvec2(64, 1)})
        for (const int resolution : {1, 2, 4})
            for (const auto upsample : {Settings::Upsample::bilinear2x2,
                                        Settings::Upsample::tent4x4, Settings::Upsample::box4x4}) {
                Scene scene = fog_scene();
                scene.resolution = size;
                scene.camera.vfov_deg = 20;
                auto& fog = std::get<BoxMedium>(scene.media[0]);
                fog.min = {-800, -6, -800};
                fog.max = {800, -4, 800};
                fog.sigma_a = glm::vec3(0.5f);
                Settings settings = plain_settings(resolution);
                settings.upsample = upsample;
                const Still still = render(scene, settings);
                const PictureField field = [&](glm::dvec2 at) {
                    return glm::dvec3(std::exp(-1.0 * ray_at(scene, at).length_per_z));
                };
                const std::string what = fmt::format("{} x {} at 1/{}, upsample {}", size.x, size.y,
                                                     resolution, static_cast<int>(upsample));
                expect_finite(still, what);
                if (upsample == Settings::Upsample::bilinear2x2) {
                    EXPECT_TRUE(images_near(picture_of(still, still.transmittance),
                                            resolved(scene, resolution, field), 5e-6, 5e-6,
                                            "64 factors of exp in 32-bit floats"))
                        << what;
                }
            }
}

TEST_F(Extremes, OpticalDepthFrom1e6thTo1e4)
{
    Scene scene = fog_scene();
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    fog.min = {-40, -6, -40};
    fog.max = {40, -4, 40};
    for (const double tau : {1e-6, 1e-4, 1e-2, 1.0, 30.0, 1e3, 1e4}) {
        // Emission in step with absorption, so the radiance is 1 - T.
        fog.sigma_a = glm::vec3(static_cast<float>(tau / 2));
        fog.emission = fog.sigma_a;
        for (const int resolution : {1, 2}) {
            const Still still = render(scene, plain_settings(resolution));
            const auto expect = [&](const std::vector<float>& layer, bool radiance, double relative,
                                    double absolute) {
                const Image truth = resolved(scene, resolution, [&](glm::dvec2 at) {
                    const double t = -tau * ray_at(scene, at).length_per_z;
                    return glm::dvec3(radiance ? -std::expm1(t) : std::exp(t));
                });
                const double largest = *std::max_element(truth.pixels.begin(), truth.pixels.end());
                EXPECT_TRUE(images_near(picture_of(still, layer), truth,
                                        relative * largest + absolute,
                                        relative * largest + absolute,
                                        "64 factors in 32-bit floats, relative to the largest"))
                    << (radiance ? "radiance" : "transmittance") << ", optical depth " << tau;
            };
            expect(still.scattering, true, 5e-6, 0);
            // exp is off by 2^-24 for each unit of its argument, so T by 30 of them at tau = 30.
            expect(still.transmittance, false, 5e-6 + 1e-6 * tau, 1e-30);
        }
        for (const auto format : {Settings::Format::r11g11b10f, Settings::Format::rgba16f}) {
            Settings settings = plain_settings(2);
            settings.format = format;
            settings.targets = Settings::Targets::two;  // the small format has no alpha
            expect_finite(render(scene, settings), fmt::format("optical depth {}", tau));
        }
    }
}

TEST_F(Extremes, LightsInTheMediumOnTheCameraAndOf1e5)
{
    Scene scene = fog_scene();
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    scene.surfaces = {BoxSurface{{-8, -9, -8}, {8, -8, 8}, glm::vec3(0.5f)}};
    const std::pair<const char*, glm::dvec3> positions[] = {
        {"on the camera", scene.camera.position},
        {"on the camera's axis", {0, -3, 0}},
        {"on a pixel's ray", ray_of(scene, 5, 9).direction * 4.0},
        {"on the surface", {0.2, -8, 0.1}},
        {"on the medium's corner", {8, 2, 8}},
    };
    for (const auto& [name, position] : positions)
        for (const float g : {0.0f, 0.999f, -0.999f})
            for (const float sigma : {1e-6f, 0.5f, 1e3f}) {
                fog.sigma_s = glm::vec3(sigma);
                fog.g = g;
                scene.lights = {PointLight{position, glm::vec3(1e5f)},
                                SpotLight{position, {0, -1, 0}, 179.9, 0, glm::vec3(1e5f)}};
                for (const auto format : {Settings::Format::rgba32f, Settings::Format::rgba16f}) {
                    Settings settings = plain_settings(2);
                    settings.format = format;
                    const Still still = render(scene, settings);
                    expect_finite(still, fmt::format("{}, g {}, sigma {}", name, g, sigma));
                    if (format == Settings::Format::rgba16f) {
                        EXPECT_LE(
                            *std::max_element(still.scattering.begin(), still.scattering.end()),
                            65504.0f);
                    }
                }
            }
}

TEST_F(Extremes, ASampleOnALightToTheBit)
{
    Scene scene = fog_scene(1);  // its one ray is exactly -y
    scene.camera.near = 1;
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    fog.min.y = -9;
    fog.sigma_s = glm::vec3(0.1f);
    fog.g = 0.5f;
    scene.lights = {PointLight{{0, -5, 0}, glm::vec3(1)},
                    SpotLight{{0, -5, 0}, {0, -1, 0}, 45, 0.15f, glm::vec3(1)}};
    for (const int shadow_steps : {1, 16}) {
        Settings settings = plain_settings();
        settings.steps = 1;  // its middle is 5 m away
        settings.shadow_steps = shadow_steps;
        const Still still = render(scene, settings);
        expect_finite(still, "a light at the sample");
        EXPECT_GT(still.scattering[0], 1.0f) << "it is very bright there";
        EXPECT_LT(still.scattering[0], 1e12f) << "as bright as 10 micrometres away, no more";
        figure("radiance at a light", still.scattering[0]);
    }
}

TEST_F(Extremes, RadianceBeyondTheFormatIsItsLargestValue)
{
    Scene scene = fog_scene();
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    fog.emission = glm::vec3(1e5f);
    for (const auto& [format, limit] : {std::pair{Settings::Format::rgba16f, 65504.0f},
                                        {Settings::Format::r11g11b10f, 64512.0f}}) {
        fog.sigma_a = {0, 0, 1e-3f};  // coloured: two targets, so that the small format is used
        Settings settings = plain_settings(2);
        settings.format = format;
        const Still still = render(scene, settings);
        for (const float s : still.scattering)
            ASSERT_EQ(s, limit) << "12 m of 1e5 W/m^2/sr a metre";
        for (const float s : still.composite)
            ASSERT_TRUE(std::isfinite(s));
    }
}

// The sun in the eye's very direction, where 1 + g^2 - 2 g cos all but cancels.
TEST_F(Extremes, SunStraightAheadAndBehindAtTheLargestG)
{
    Scene scene = fog_scene(15);
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    fog.sigma_s = glm::vec3(0.1f);
    for (const float g : {0.999f, -0.999f, 0.9999f, -0.9999f})
        for (const glm::ivec2 at : {glm::ivec2(7, 7), {2, 11}, {13, 4}, {0, 14}}) {
            const glm::dvec3 ahead = ray_of(scene, at.x, at.y).direction;
            scene.lights = {SunLight{g > 0 ? ahead : -ahead, glm::vec3(1)}};
            fog.g = g;
            Settings settings = plain_settings();
            settings.g_clamp = 0.9999f;
            settings.volume_shadows = false;
            const Still still = render(scene, settings);
            expect_finite(still, fmt::format("g {}, pixel {}, {}", g, at.x, at.y));
            const PixelRay ray = ray_of(scene, at.x, at.y);
            const double length =
                box_segment(ray, fog.min, fog.max, 0.01 * ray.length_per_z).length();
            const double expected = 0.1 * henyey_greenstein(1.0, std::abs(double(g))) *
                                    -std::expm1(-0.1 * length) / 0.1;
            const double actual = pixel(still.scattering, 15, at.x, at.y).r;
            // A 32-bit cosine is off by 2.4e-7 at the most, and 2 (1 - cos) / (1 - g)^2 is added to
            // 1: 0.48 at 0.999, to the power -3/2; and 48 at 0.9999. It can't be above the peak.
            const double slack = std::abs(g) < 0.9995f ? 0.48 : 48;
            EXPECT_LT(actual, 1.001 * expected) << "g " << g << ", pixel " << at.x << ", " << at.y;
            EXPECT_GT(actual, 0.99 * expected * std::pow(1 + slack, -1.5))
                << "g " << g << ", pixel " << at.x << ", " << at.y;
            figure("forward peak over its closed form", actual / expected);
        }
}

// Fog many scale heights deep, lit from below and above: exp must not overflow on the way.
TEST_F(Extremes, LightFromBelowThroughManyScaleHeights)
{
    Scene scene = empty_scene(16);
    scene.camera.position = {0, 30, 150};
    scene.camera.look_at = {0, 0, 150};
    scene.camera.vfov_deg = 20;
    BoxMedium fog;
    fog.min = {-50, -50, 0};
    fog.max = {50, 50, 200};
    fog.sigma_s = glm::vec3(0.5f);
    fog.profile = ExpHeightProfile{.scale_height = 1, .z0 = 0};
    BoxMedium haze = fog;  // so that there is something to light up there
    haze.profile = HomogeneousProfile{};
    haze.sigma_s = glm::vec3(1e-3f);
    scene.surfaces = {BoxSurface{{-5, -5, 140}, {5, 5, 160}, glm::vec3(0.5f)}};
    for (const glm::dvec3 light : {glm::dvec3(0, 20, 0.5), glm::dvec3(0, 20, 90), {0, 20, 199}}) {
        const glm::vec3 intensity(1e4f);
        scene.lights = {PointLight{light, intensity}};
        scene.media = {fog, haze};
        const Still still = render(scene, plain_settings());
        expect_finite(still, fmt::format("light at {} m", light.z));
        // The wall at y = 5, through fog of column exp(-z) between both heights.
        const PixelRay ray = ray_of(scene, 8, 8);
        const glm::dvec3 p = ray.origin + ray.direction * ((5 - 30) / ray.direction.y);
        const glm::dvec3 to_light = light - p;
        const double d = glm::length(to_light);
        const double low = std::min(light.z, p.z), high = std::max(light.z, p.z);
        const double tau = 0.5 * (std::exp(-low) - std::exp(-high)) / ((high - low) / d) + 1e-3 * d;
        const double expected =
            0.5 / std::numbers::pi * 1e4 / (d * d) * (to_light.y / d) * std::exp(-tau);
        EXPECT_NEAR(pixel(still.surface_lit, 16, 8, 8).r, expected, 1e-4 * expected)
            << "light at " << light.z << " m, wall at 150 m, scale height 1 m";
    }
}

// A grid of huge and tiny densities side by side, in every storage.
TEST_F(Extremes, GridValuesFromTinyToHuge)
{
    Scene scene = empty_scene(16);
    scene.camera.vfov_deg = 40;
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(3)}};
    for (const double largest : {1e-30, 1.0, 1e30}) {
        GridMedium smoke;
        const glm::dmat4 world_from_index(0.2, 0, 0, 0, 0, 0.2, 0, 0, 0, 0, 0.2, 0, -1.5, -6, -1.5,
                                          1);
        smoke.density = make_grid({2, 2, 2}, world_from_index, [&](glm::ivec3 v) {
            return largest * std::pow(10.0, -((v.x + v.y + v.z) % 8));
        });
        smoke.sigma_s_per_density = glm::vec3(static_cast<float>(1 / largest));
        scene.media = {smoke};
        Still first;
        for (const auto storage :
             {medium::Storage::r32f, medium::Storage::r16f, medium::Storage::r8}) {
            Settings settings = plain_settings();
            settings.storage = storage;
            const Still still = render(scene, settings);
            expect_finite(still, fmt::format("largest {}", largest));
            if (storage == medium::Storage::r32f) {
                first = still;
            }
            EXPECT_TRUE(images_near(picture_of(still, still.transmittance),
                                    picture_of(first, first.transmittance), 0.01, 0.005,
                                    "r8 keeps 1/510 of the largest, over 3.4 m at 1 / m"))
                << "largest " << largest;
        }
        EXPECT_LT(pixel(first.transmittance, 16, 8, 8).r, 0.9f);
    }
}

}  // namespace
}  // namespace fumarole::test
