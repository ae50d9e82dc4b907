// Light that a medium scatters, and light that reaches surfaces through it, against closed forms
// and against integrals in double.

#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "image_test.h"

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr glm::dvec3 kSlabMin(-40, -6, -40), kSlabMax(40, -4, 40);

class Lighting : public ImageTest {
protected:
    static BoxMedium slab(glm::vec3 sigma_s, glm::vec3 sigma_a, float g)
    {
        BoxMedium box;
        box.min = kSlabMin;
        box.max = kSlabMax;
        box.sigma_s = sigma_s;
        box.sigma_a = sigma_a;
        box.g = g;
        return box;
    }
    static Scene wide_scene(int size = 16)
    {
        Scene scene = empty_scene(size);
        scene.camera.vfov_deg = 40;
        scene.camera.ortho_height = 3;
        return scene;
    }
    /// Pixels so narrow that those of a layer see what changes around a sun, whose tiles are
    /// marched for each pixel else.
    static Scene narrow_pixels()
    {
        Scene scene = wide_scene(64);
        scene.camera.vfov_deg = 20;
        return scene;
    }
};

TEST_F(Lighting, SunInAUniformSlabThatShadesItself)
{
    const glm::vec3 irradiance(5, 4, 3);
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic})
        for (const glm::dvec3 to_sun : {glm::dvec3(0.3, 0.8, 0.5), glm::dvec3(0.2, -0.9, 0.3)})
            for (const float g : {0.6f, -0.4f})
                for (const Settings& settings :
                     {plain_settings(1), plain_settings(2), plain_settings(4), plain_froxels()}) {
                    const int resolution = settings.resolution;
                    Scene scene = narrow_pixels();
                    scene.camera.projection = projection;
                    const SunLight sun{glm::normalize(to_sun), irradiance};
                    scene.lights = {sun};
                    const BoxMedium medium = slab({0.2f, 0.5f, 1.0f}, {0.1f, 0.1f, 0.0f}, g);
                    scene.media = {medium};
                    const Still still = render(scene, settings);
                    const PictureField field = [&](glm::dvec2 at) {
                        return study::sun_in_slab(scene, study::pixel_ray(scene, at), medium, sun);
                    };
                    const Image truth = resolved(scene, resolution, field);
                    const Image actual = picture_of(still, still.scattering);
                    // The source is constant within a step, which costs (k x)^2 / 24 + k x^2 / 12
                    // with x = sigma_t ds: 1.6e-4 for k = 1.24 and 64 steps in 2 m, a third more
                    // where the steps are longest.
                    const double largest =
                        *std::max_element(truth.pixels.begin(), truth.pixels.end());
                    EXPECT_TRUE(images_near(actual, truth, 2.2e-4 * largest, 1.6e-4 * largest,
                                            "midpoint rule on the sun's shadow over 64 steps"))
                        << "g " << g << ", sun y " << to_sun.y << ", resolution " << resolution
                        << ", " << mode_name(settings.mode);
                    figure("relative error", max_difference(actual, truth) / largest);
                }
}

TEST_F(Lighting, ForwardScatteringIsBrightTowardsTheSun)
{
    Scene scene = wide_scene();
    Settings settings = plain_settings();
    settings.volume_shadows = false;
    const auto middle = [&](glm::dvec3 to_sun, float g) {
        scene.lights = {SunLight{to_sun, glm::vec3(1)}};
        scene.media = {slab(glm::vec3(0.1f), glm::vec3(0), g)};
        return pixel(render(scene, settings).scattering, 16, 8, 8).r;
    };
    const glm::dvec3 ahead(0, -1, 0.01), behind(0, 1, 0.01);
    EXPECT_GT(middle(ahead, 0.7f), 50 * middle(behind, 0.7f))
        << "(1.7 / 0.3)^3 = 180 exactly ahead";
    EXPECT_GT(middle(behind, -0.7f), 50 * middle(ahead, -0.7f));
    EXPECT_NEAR(middle(ahead, 0.0f), middle(behind, 0.0f), 1e-7);
}

TEST_F(Lighting, VolumeShadowsOffLeavesTheSunUndimmed)
{
    Scene scene = wide_scene();
    scene.lights = {SunLight{{0.3, 0.8, 0.5}, glm::vec3(2)}};
    const BoxMedium medium = slab(glm::vec3(0.5f), glm::vec3(0.2f), 0.3f);
    scene.media = {medium};
    const glm::dvec3 wi = glm::normalize(glm::dvec3(0.3, 0.8, 0.5));
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const double length = box_segment(ray, kSlabMin, kSlabMax).length();
        return glm::dvec3(2 * 0.5 * henyey_greenstein(glm::dot(wi, ray.direction), 0.3) *
                          -std::expm1(-0.7 * length) / 0.7);
    });
    for (Settings settings : plain_siblings()) {
        settings.volume_shadows = false;
        const Still still = render(scene, settings);
        EXPECT_TRUE(images_near(picture_of(still, still.scattering), truth, 2e-6, 1e-6,
                                "a constant source is a closed form; 32-bit sums"))
            << mode_name(settings.mode);
    }
}

/// Fog all around, a light in it; the integral along the ray in double.
glm::dvec3 point_in_fog(const PixelRay& ray, const BoxMedium& fog, glm::dvec3 light,
                        glm::dvec3 intensity, double near)
{
    const Segment inside = box_segment(ray, fog.min, fog.max, near * ray.length_per_z);
    const double nearest = glm::dot(light - ray.origin, ray.direction);
    glm::dvec3 radiance;
    for (int c = 0; c < 3; ++c) {
        const double sigma_s = fog.sigma_s[c], sigma_t = sigma_s + double(fog.sigma_a[c]);
        const auto source = [&](double t) {
            const glm::dvec3 to_light = light - (ray.origin + ray.direction * t);
            const double d = glm::length(to_light);
            const double cos_theta = glm::dot(-to_light / d, -ray.direction);
            return intensity[c] / (d * d) * sigma_s * henyey_greenstein(cos_theta, double(fog.g)) *
                   std::exp(-sigma_t * (d + t - inside.begin));
        };
        // Panels meet at the peak.
        const double middle = std::clamp(nearest, inside.begin, inside.end);
        radiance[c] = integrate(inside.begin, middle, 400, source) +
                      integrate(middle, inside.end, 400, source);
    }
    return radiance;
}

TEST_F(Lighting, PointLightInUniformFogConvergesToTheIntegral)
{
    Scene scene = wide_scene();
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = {0.05f, 0.1f, 0.3f};
    fog.sigma_a = {0.02f, 0.0f, 0.1f};
    fog.g = 0.5f;
    scene.media = {fog};
    const glm::dvec3 light(0.8, -5, 0.5), intensity(10, 8, 6);
    scene.lights = {PointLight{light, intensity}};
    const PictureField field = [&](glm::dvec2 at) {
        return point_in_fog(ray_at(scene, at), fog, light, intensity, scene.camera.near);
    };
    const Image truth = ideal(scene, field);
    double mean = 0;
    for (const float v : truth.pixels)
        mean += double(v) / static_cast<double>(truth.pixels.size());
    double before = 0;
    for (Settings settings : plain_siblings()) {
        before = 0;
        for (const int steps : {64, 128, 256, 512}) {
            set_steps(settings, steps);
            const Still still = render(scene, settings);
            const double error = rms_difference(picture_of(still, still.scattering), truth) / mean;
            figure(
                fmt::format("{}: rms error over mean at {} steps", mode_name(settings.mode), steps),
                error);
            if (before > 0) {
                EXPECT_LT(error, 0.6 * before) << steps << " steps, " << mode_name(settings.mode);
            }
            before = error;
        }
        EXPECT_LT(before, 2e-3) << "rms over mean at 512 steps, " << mode_name(settings.mode);
    }
    // The mean of 1/d^2 and of the phase over each step: what midpoints take 256 steps for. What is
    // left is the extinction, looked up at one place of a step.
    Settings over_steps = plain_settings();
    over_steps.falloff = Settings::Falloff::exact;
    for (const auto& [steps, allowed] : {std::pair{64, 1e-2}, {256, 2e-3}, {512, 5e-4}}) {
        set_steps(over_steps, steps);
        const Still still = render(scene, over_steps);
        EXPECT_LT(rms_difference(picture_of(still, still.scattering), truth) / mean, allowed)
            << steps << " steps, exact falloff";
    }
    // The nearest ray passes at a tenth of the longest step's length from the light at 64 steps; at
    // 512 the peak of 1/d^2 spans several steps and midpoints see it.

    // A full picture, layer at half and quarter size: the same samples, interpolated.
    Settings settings = plain_settings(1);
    settings.steps = 512;
    for (const int resolution : {2, 4}) {
        settings.resolution = resolution;
        const Still still = render(scene, settings);
        const Image samples = resolved(scene, resolution, field);
        EXPECT_LT(rms_difference(picture_of(still, still.scattering), samples) / mean, 2e-3)
            << "resolution " << resolution;
    }
}

/// Of lump(), 16 voxels across about (0, -5, 0).
const glm::dmat4 kWorldFromLump = study::voxels(0.25, {-1.9, -6.9, -1.9});

TEST_F(Lighting, SelfShadowOfAGridConvergesWithShadowSteps)
{
    Scene scene = wide_scene(8);
    GridMedium smoke;
    smoke.density = lump(kWorldFromLump);
    smoke.sigma_s_per_density = glm::vec3(1.5f);
    smoke.sigma_a_per_density = glm::vec3(0.5f);
    smoke.g = 0.3f;
    scene.media = {smoke};
    const glm::dvec3 wi = glm::normalize(glm::dvec3(0.7, 0.3, 0.6));
    scene.lights = {SunLight{wi, glm::vec3(4)}};

    const VoxelLookup lookup(*smoke.density);
    const glm::dmat4 index_from_world = glm::inverse(smoke.density->world_from_index);
    const glm::dvec3 low(-2.2, -7.2, -2.2), high(2.4, -2.6, 2.4);  // around the field
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const Segment inside = box_segment(ray, low, high);
        constexpr int kSteps = 200;
        const double ds = inside.length() / kSteps;
        double tau = 0, radiance = 0;
        for (int i = 0; i < kSteps && ds > 0; ++i) {
            const glm::dvec3 p = ray.origin + ray.direction * (inside.begin + (i + 0.5) * ds);
            const double density = lookup.sample(glm::dvec3(index_from_world * glm::dvec4(p, 1))).x;
            const Segment way = box_segment({p, wi, 1}, low, high);
            const double shadow = 2 * grid_column(lookup, index_from_world, p, wi, way, 20);
            radiance += density * 1.5 * 4 * henyey_greenstein(glm::dot(wi, ray.direction), 0.3) *
                        std::exp(-shadow - tau - density * ds) * ds;
            tau += 2 * density * ds;
        }
        return glm::dvec3(radiance);
    });
    const double largest = *std::max_element(truth.pixels.begin(), truth.pixels.end());
    for (Settings settings : plain_siblings()) {
        SCOPED_TRACE(mode_name(settings.mode));
        set_steps(settings, 256);
        settings.shadow_volume_size = 0;
        double before = 0;
        for (const int shadow_steps : {1, 2, 4, 8, 16}) {
            settings.shadow_steps = shadow_steps;
            const Still still = render(scene, settings);
            const double error =
                rms_difference(picture_of(still, still.scattering), truth) / largest;
            figure(fmt::format("{}: rms error over largest at {} shadow steps",
                               mode_name(settings.mode), shadow_steps),
                   error);
            if (before > 0) {
                EXPECT_LT(error, std::max(0.6 * before, 1e-3)) << shadow_steps << " shadow steps";
            }
            before = error;
        }
        EXPECT_LT(before, 1e-3)
            << "16 midpoints in a lump of 16 voxels, and 8 bits of filter weights";
    }
}

// Albedo 1, the world's light undimmed, the same world behind: what a ray loses it gains, exactly,
// since a step's source and its transmittance come from one tau.
TEST_F(Lighting, WhiteFurnace)
{
    Scene scene = wide_scene(32);
    scene.world.radiance = glm::vec3(1);
    BoxMedium uniform = slab({0.1f, 1.0f, 10.0f}, glm::vec3(0), 0.0f);
    BoxMedium noisy = uniform;
    noisy.sigma_s = glm::vec3(2);
    noisy.profile = NoiseProfile{.feature_size = 1.0, .octaves = 3, .seed = 3};
    GridMedium smoke;
    smoke.density = lump(kWorldFromLump);
    smoke.sigma_s_per_density = {0.5f, 2.0f, 8.0f};
    smoke.g = 0.7f;
    for (const Medium& medium : {Medium(uniform), Medium(noisy), Medium(smoke)}) {
        scene.media = {medium};
        for (Settings settings :
             {plain_settings(), plain_froxels(4), Settings{}, find_preset("froxel")}) {
            settings.ambient_volume_size = 0;
            const bool plain = settings.format == Settings::Format::rgba32f;
            const Still still = render(scene, settings);
            const Image one = ideal(scene, [](glm::dvec2) { return glm::dvec3(1); });
            EXPECT_LT(*std::min_element(still.transmittance.begin(), still.transmittance.end()),
                      0.7f)
                << "there is a medium to see";
            // The froxels' 16-bit values are of a straight ray; the corner's is 1.13 times as long.
            const double slant = settings.mode == Settings::Mode::froxel ? 1.13 : 1;
            // OpenGL leaves open how what is stored in 16 bits is rounded, and in how many bits it
            // is filtered: cut off, a value under 1 is off by 2^-11 and not 2^-12.
            const double rounding = is_software() ? 5e-4 : 1e-3;
            const double tolerance = plain ? 64 * 0x1p-24 : rounding * slant;
            EXPECT_TRUE(images_near(picture_of(still, still.composite), one, tolerance, tolerance,
                                    "rounding: of 64 steps' 32-bit sums, 2^-24 each, or of two "
                                    "16-bit values under 1"))
                << "medium of kind " << medium.index() << ", " << mode_name(settings.mode);
            figure(fmt::format("furnace error, {}, {}", mode_name(settings.mode),
                               plain ? "32-bit" : "default"),
                   max_difference(picture_of(still, still.composite), one));
        }
    }
}

// -- surfaces ------------------------------------------------------------------------------------

/// Looks down on a ground at z = 0, from (0, 0, 5).
Scene ground_scene(int size = 16)
{
    Scene scene = empty_scene(size);
    scene.camera.position = {0, 0, 5};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 40;
    scene.surfaces = {BoxSurface{{-50, -50, -1}, {50, 50, 0}, glm::vec3(0.6f, 0.4f, 0.2f)}};
    return scene;
}

glm::dvec3 on_ground(const PixelRay& ray)
{
    return ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
}

TEST_F(Lighting, SunThroughASlabOntoTheGround)
{
    Scene scene = ground_scene();
    const glm::dvec3 wi = glm::normalize(glm::dvec3(0.4, 0.1, 0.8));
    const glm::dvec3 irradiance(3, 2, 1), sigma_t(0.2, 0.5, 1.5), albedo(0.6f, 0.4f, 0.2f);
    scene.lights = {SunLight{wi, irradiance}};
    scene.world.radiance = {0.1f, 0.2f, 0.3f};
    BoxMedium above;  // over the eye: between it and the ground there is nothing
    above.min = {-60, -60, 6};
    above.max = {60, 60, 7.5};
    above.sigma_s = 0.5 * sigma_t;
    above.sigma_a = 0.5 * sigma_t;
    scene.media = {above};
    Settings settings = plain_settings();
    settings.ambient_volume_size = 0;  // the sun is what the slab dims
    const Still still = render(scene, settings);
    const auto lit = [&](double dimmed) {
        return ideal(scene, [&, dimmed](glm::dvec2) {
            const glm::dvec3 through = glm::exp(-sigma_t * (dimmed * 1.5 / wi.z));
            return albedo / kPi *
                   (irradiance * wi.z * through + kPi * glm::dvec3(scene.world.radiance));
        });
    };
    EXPECT_TRUE(images_near(picture_of(still, still.surface), lit(0), 2e-6, 1e-6,
                            "Lambert, 32-bit floats"));
    EXPECT_TRUE(images_near(picture_of(still, still.surface_lit), lit(1), 2e-6, 1e-6,
                            "a uniform medium's shadow is a closed form"));
    EXPECT_EQ(still.composite, still.surface_lit)
        << "a medium behind the eye veils nothing, and still shades the view";
}

TEST_F(Lighting, PointLightThroughFogOntoTheGround)
{
    Scene scene = ground_scene();
    const glm::dvec3 light(1, 0.5, 3), intensity(20, 10, 5), sigma_t(0.1, 0.3, 0.6);
    scene.lights = {PointLight{light, intensity}};
    BoxMedium fog;
    fog.min = {-60, -60, -0.5};
    fog.max = {60, 60, 2};
    fog.sigma_a = sigma_t;
    scene.media = {fog};
    const Still still = render(scene, plain_settings());
    const auto lit = [&](bool dimmed) {
        return ideal(scene, [&, dimmed](glm::dvec2 at) {
            const glm::dvec3 to_light = light - on_ground(ray_at(scene, at));
            const double d = glm::length(to_light), cos_theta = to_light.z / d;
            const glm::dvec3 through = glm::exp(-sigma_t * (dimmed ? 2 / cos_theta : 0));
            return glm::dvec3(0.6f, 0.4f, 0.2f) / kPi * intensity / (d * d) * cos_theta * through;
        });
    };
    EXPECT_TRUE(images_near(picture_of(still, still.surface), lit(false), 5e-6, 2e-6,
                            "Lambert and 1/d^2, 32-bit floats"));
    EXPECT_TRUE(images_near(picture_of(still, still.surface_lit), lit(true), 5e-6, 2e-6,
                            "and a closed form of the fog's shadow"));
    const Image through = ideal(scene, [&](glm::dvec2 at) {
        return glm::exp(-sigma_t * (2 * ray_at(scene, at).length_per_z));
    });
    EXPECT_TRUE(images_near(picture_of(still, still.transmittance), through, 2e-5, 1e-5,
                            "the ground's depth, reversed 32-bit, is 1e-6 of 5 m"));
}

TEST_F(Lighting, SmokeShadowOnTheGroundHasTheSmokesColour)
{
    Scene scene = ground_scene();
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(glm::dvec3(kPi))}};
    GridMedium smoke;
    const glm::dmat4 world_from_index(0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0, -0.75, -0.75, 8, 1);
    smoke.density = make_grid({2, 2, 2}, world_from_index, [](glm::ivec3) { return 0.5; });
    smoke.sigma_s_per_density = {0.5f, 1.0f, 3.0f};
    smoke.sigma_a_per_density = {0.5f, 0.0f, 1.0f};
    scene.media = {smoke};
    const Still still = render(scene, plain_settings());
    // 16 voxels of 0.5, a triangle of one voxel's base at each end: 16 * 0.1 m * 0.5 in all.
    const glm::dvec3 expected = glm::dvec3(0.6f, 0.4f, 0.2f) * glm::exp(-glm::dvec3(1, 1, 4) * 0.8);
    const glm::vec3 shadow = pixel(still.surface_lit, 16, 8, 8);
    const glm::vec3 open = pixel(still.surface_lit, 16, 1, 1);
    for (int c = 0; c < 3; ++c) {
        // 64 midpoints over 17 voxels: the triangles' kinks cost (17/64)^2 / 8 of a voxel each.
        EXPECT_NEAR(shadow[c], expected[c], 2e-3 * expected[c]) << "channel " << c;
        EXPECT_FLOAT_EQ(open[c], glm::vec3(0.6f, 0.4f, 0.2f)[c]) << "beside the shadow";
    }
}

double cone(double cos_angle, double cone_deg, double blend)
{
    const double edge = std::cos(cone_deg * kPi / 360);
    const double x = std::clamp((cos_angle - edge) / ((1 - edge) * blend), 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

TEST_F(Lighting, SpotConeOnTheGround)
{
    Scene scene = ground_scene(32);
    const SpotLight spot{
        {0.2, -0.1, 4}, glm::normalize(glm::dvec3(0.1, 0, -1)), 30, 0.5, glm::vec3(20)};
    scene.lights = {spot};
    const Still still = render(scene, plain_settings());
    int inside = 0, outside = 0, blend = 0;
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const glm::dvec3 to_light = spot.position - on_ground(ray_at(scene, at));
        const double d = glm::length(to_light);
        const double share = cone(glm::dot(-to_light / d, spot.direction), 30, 0.5);
        ++(share == 0 ? outside : share == 1 ? inside : blend);
        return glm::dvec3(0.6f, 0.4f, 0.2f) / kPi * 20.0 / (d * d) * (to_light.z / d) * share;
    });
    EXPECT_GT(std::min({inside, outside, blend}), 20) << "pixels inside, outside, between";
    // GLSL 4.50, section 4.7.1: a division may be off by 2.5 units in the last place and an inverse
    // square root by 2, where a rasteriser on the processor rounds both to half a unit. With the
    // three sums of the product the cosine is off by 6 units and not 2.5.
    EXPECT_TRUE(images_near(picture_of(still, still.surface), truth,
                            is_software() ? 5e-6 : 5e-6 * 6 / 2.5, 2e-6,
                            "32-bit cosine near 1, over (1 - cos 15 deg) / 2"));
}

TEST_F(Lighting, SpotConeInFog)
{
    Scene scene = wide_scene();
    const SpotLight spot{{0, -5, 3}, {0, 0, -1}, 40, 0.3, glm::vec3(10)};
    scene.lights = {spot};
    BoxMedium fog;
    fog.min = {-8, -12, -8};
    fog.max = {8, 2, 8};
    fog.sigma_s = glm::vec3(0.1f);
    scene.media = {fog};
    Settings settings = plain_settings();
    settings.steps = 1024;
    const Still still = render(scene, settings);
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const Segment in = box_segment(ray, fog.min, fog.max, 0.01 * ray.length_per_z);
        return glm::dvec3(integrate(in.begin, in.end, 2000, [&](double t) {
            const glm::dvec3 to_light = spot.position - (ray.origin + ray.direction * t);
            const double d = glm::length(to_light);
            return 10 / (d * d) * cone(glm::dot(-to_light / d, spot.direction), 40, 0.3) * 0.1 /
                   (4 * kPi) * std::exp(-0.1 * (d + t - in.begin));
        }));
    });
    EXPECT_GT(truth.at(8, 2, 0), 1e-3f) << "the beam is in the picture";
    const double largest = *std::max_element(truth.pixels.begin(), truth.pixels.end());
    EXPECT_TRUE(images_near(picture_of(still, still.scattering), truth, 2e-3 * largest,
                            5e-4 * largest, "1024 midpoints across the beam's soft edge"));
    figure("beam error over largest",
           max_difference(picture_of(still, still.scattering), truth) / largest);
}

// -- several media -------------------------------------------------------------------------------

TEST_F(Lighting, CoefficientsOfOverlappingMediaAdd)
{
    Settings settings = plain_settings();
    settings.ambient_volume_size = 0;  // 16 bits
    Scene scene = narrow_pixels();
    scene.lights = {SunLight{{0.3, 0.8, 0.5}, glm::vec3(3)}};
    scene.world.radiance = glm::vec3(0.2f);
    BoxMedium a = slab({0.1f, 0.2f, 0.3f}, glm::vec3(0.1f), 0.8f);
    BoxMedium b = slab({0.3f, 0.6f, 0.9f}, {0.0f, 0.1f, 0.3f}, -0.2f);
    a.emission = {0.1f, 0, 0};
    b.emission = {0.1f, 0.2f, 0};
    scene.media = {a, b};
    const Still two = render(scene, settings);
    // g: (1 * 0.8 + 3 * -0.2) / 4, since b scatters three times as much in each channel.
    BoxMedium sum = slab(a.sigma_s + b.sigma_s, a.sigma_a + b.sigma_a, 0.05f);
    sum.emission = a.emission + b.emission;
    scene.media = {sum};
    const Still one = render(scene, settings);
    EXPECT_TRUE(images_near(picture_of(two, two.composite), picture_of(one, one.composite), 3e-6,
                            1e-6, "32-bit sums in another order"));
    // A medium that does not scatter has no say in g.
    a.g = 0.05f;
    a.sigma_s += b.sigma_s;
    b.sigma_s = glm::vec3(0);
    b.g = 0.9f;
    scene.media = {b, a};
    const Still third = render(scene, settings);
    EXPECT_TRUE(images_near(picture_of(third, third.composite), picture_of(one, one.composite),
                            3e-6, 1e-6, "32-bit sums in another order"));
}

// -- noise ---------------------------------------------------------------------------------------

class NoiseMedium : public ImageTest {
protected:
    static Scene noisy_scene()
    {
        Scene scene = empty_scene(32);
        scene.camera.vfov_deg = 50;
        BoxMedium box;
        box.min = {-1.2, -6, -1};
        box.max = {1, -4, 1.1};
        box.sigma_a = glm::vec3(3);
        box.profile = NoiseProfile{.feature_size = 0.7,
                                   .octaves = 4,
                                   .threshold = 0.3,
                                   .seed = 11,
                                   .drift = {0.3, -0.2, 0.1}};
        scene.media = {box};
        return scene;
    }
};

TEST_F(NoiseMedium, IsTheSameEachTimeAndStaysInItsBox)
{
    const Scene scene = noisy_scene();
    const Still first = render(scene, plain_settings());
    render(empty_scene(8), plain_settings());
    const Still second = render(scene, plain_settings());
    EXPECT_EQ(first.transmittance, second.transmittance);
    const auto& box = std::get<BoxMedium>(scene.media[0]);
    int dense = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            const float t = pixel(first.transmittance, 32, x, y).r;
            const double length = box_segment(ray_of(scene, x, y), box.min, box.max).length();
            if (length == 0) {
                EXPECT_EQ(t, 1.0f) << "pixel " << x << ", " << y << " looks past the box";
            }
            // The profile lies in 0..1, so the box can't take more than its full coefficient.
            EXPECT_GE(t, std::exp(-3 * length) * 0.999) << "pixel " << x << ", " << y;
            dense += t < 0.7f ? 1 : 0;
        }
    EXPECT_GT(dense, 100) << "pixels with something to see in them";

    Scene other = scene;
    std::get<NoiseProfile>(std::get<BoxMedium>(other.media[0]).profile).seed = 12;
    EXPECT_NE(render(other, plain_settings()).transmittance, first.transmittance);
}

// Where another medium has the march go on past the box, the noise still ends at its faces.
TEST_F(NoiseMedium, EndsAtItsBoxInsideALargerMedium)
{
    Scene scene = noisy_scene();
    BoxMedium haze;
    haze.min = {-9, -9, -9};
    haze.max = {9, -2, 9};
    haze.sigma_a = glm::vec3(0.02f);
    scene.media.emplace_back(haze);
    const auto box = std::get<BoxMedium>(scene.media[0]);
    const Still still = render(scene, plain_settings());
    int past = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
            const PixelRay ray = ray_of(scene, x, y);
            if (box_segment(ray, box.min, box.max).length() > 0)
                continue;
            ++past;
            EXPECT_NEAR(pixel(still.transmittance, 32, x, y).r,
                        std::exp(-0.02 * box_segment(ray, haze.min, haze.max).length()), 1e-5)
                << "pixel " << x << ", " << y << " looks past the box, through haze alone";
        }
    EXPECT_GT(past, 100);
}

// Along x are more nodes than a texture has: 14 a metre, of a thousand in each layer.
TEST_F(NoiseMedium, IsWorkedOutWhereItsGridWouldNotFit)
{
    Scene scene = noisy_scene();
    auto& box = std::get<BoxMedium>(scene.media[0]);
    const double reach = std::max(250.0, 0.05 * gl().capabilities().max_texture_3d);
    box.min.x = -reach;
    box.max.x = reach;
    auto& noise = std::get<NoiseProfile>(box.profile);
    noise.octaves = 1;
    noise.drift = glm::dvec3(0);
    Settings settings = plain_settings();
    for (const auto layout : {medium::Layout::dense, medium::Layout::bricks}) {
        settings.layout = layout;
        settings.noise_grid = true;
        const Still still = render(scene, settings);
        settings.noise_grid = false;
        EXPECT_EQ(still.transmittance, render(scene, settings).transmittance);
    }
}

TEST_F(NoiseMedium, DriftMovesItAsAWhole)
{
    Scene later = noisy_scene();
    later.time = 2.5;
    // The same view of a field that has not moved yet: eye and box taken back by time * drift.
    Scene moved = noisy_scene();
    const glm::dvec3 shift = glm::dvec3(0.3, -0.2, 0.1) * -2.5;
    moved.camera.position += shift;
    moved.camera.look_at += shift;
    auto& box = std::get<BoxMedium>(moved.media[0]);
    box.min += shift;
    box.max += shift;
    const Still a = render(later, plain_settings()), b = render(moved, plain_settings());
    EXPECT_TRUE(images_near(picture_of(a, a.transmittance), picture_of(b, b.transmittance), 2e-5,
                            2e-6,
                            "positions of 5 m in 32-bit floats, sigma 3 over 1/0.7 of slope"));
    const Still still = render(noisy_scene(), plain_settings());
    EXPECT_GT(
        max_difference(picture_of(a, a.transmittance), picture_of(still, still.transmittance)), 0.1)
        << "it does move";
}

}  // namespace
}  // namespace fumarole::test
