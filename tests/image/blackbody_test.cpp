// Media that glow by their temperature, in every mode: against the closed form of a uniform one,
// and where they are lights of their own smoke.

#include <cmath>
#include <fmt/format.h>

#include "image_test.h"
#include "study/metrics.h"
#include "study/reference_blackbody.h"

namespace fumarole::test {
namespace {

/// Voxels of `voxel` metres, the first at `first`.
glm::dmat4 placed(double voxel, glm::dvec3 first)
{
    return glm::dmat4(voxel, 0, 0, 0, 0, voxel, 0, 0, 0, 0, voxel, 0, first.x, first.y, first.z, 1);
}

class Blackbody : public ImageTest {
protected:
    static std::vector<std::pair<const char*, Settings>> modes()
    {
        Settings march, froxels;
        froxels.mode = Settings::Mode::froxel;
        return {{"plain march", plain_settings()},
                {"plain froxels", plain_froxels()},
                {"march", march},
                {"froxels", froxels}};
    }
};

// From inside of it to a wall inside of it, so that no voxel at its faces is seen.
TEST_F(Blackbody, UniformSlabIsKirchhoffs)
{
    constexpr double kWall = 4, kKelvin = 1800;
    Scene scene = empty_scene(16);
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 30;
    scene.world.radiance = glm::vec3(0);
    scene.surfaces = {BoxSurface{{-9, -kWall - 1, -9}, {9, -kWall, 9}, glm::vec3(0)}};
    const auto uniform = [](double value) {
        return make_grid(glm::ivec3(5), placed(0.5, glm::dvec3(-10)),
                         [value](glm::ivec3) { return value; });
    };
    GridMedium fire;
    fire.temperature = uniform(kKelvin / 1200);
    fire.temperature_scale = 1200;
    fire.blackbody_intensity = 20;
    fire.blackbody_tint = {1, 0.8f, 0.5f};
    const glm::dvec3 emission = 20.0 * glm::dvec3(1, 0.8, 0.5) * study::blackbody_emission(kKelvin);
    for (const glm::vec3 sigma_a : {glm::vec3(0), glm::vec3(0.1f, 0.4f, 1.5f)}) {
        if (sigma_a != glm::vec3(0))
            fire.density = uniform(1);
        fire.sigma_s_per_density = glm::vec3(0);
        fire.sigma_a_per_density = sigma_a;
        scene.media = {fire};
        const PictureField truth = [&](glm::dvec2 at) {
            const double per_z = ray_at(scene, at).length_per_z;
            const double length = (kWall - scene.camera.near) * per_z;
            glm::dvec3 sum;
            for (int c = 0; c < 3; ++c) {
                const double s = double(sigma_a[c]);
                sum[c] = emission[c] * (s == 0 ? length : -std::expm1(-s * length) / s);
            }
            return sum;
        };
        for (const auto& [name, settings] : modes()) {
            const Still still = render(scene, settings);
            const study::Metrics m = study::compare(still.scattering, ideal(scene, truth).pixels);
            figure(fmt::format("{} {} relMSE", name, sigma_a.r > 0 ? "dims" : "glows"), m.relmse);
            // 1e-4 is 1 % of each pixel: 0.13 % of the colour's polynomial, the 11 bits of the
            // layer, and in froxels a wall between two slices.
            EXPECT_LT(m.relmse, 1e-4) << name;
            EXPECT_LT(std::abs(m.bias), 0.006) << name;
        }
    }
}

/// A ball of smoke that is hot in its middle.
/// @param temperature by the distance from there, in radii of the smoke
template <class F> GridMedium hot_ball(const F& temperature)
{
    const auto ball = [](const auto& value) {
        return make_grid(glm::ivec3(8), placed(0.18, {-5.67, -15.67, -5.67}), [&](glm::ivec3 at) {
            return value(glm::length(glm::dvec3(at) - 31.5) / 25);
        });
    };
    GridMedium smoke;
    smoke.density = ball([](double r) { return r < 1 ? 1.0 : 0.0; });
    smoke.sigma_s_per_density = glm::vec3(0.3f);
    smoke.sigma_a_per_density = glm::vec3(0.03f);
    smoke.temperature = ball(temperature);
    return smoke;
}

// The same light as an emission grid's of as much in each voxel; their faces differ, where a
// temperature falls to half over half a voxel and its light to a sixteenth.
TEST_F(Blackbody, LightsItsSmokeAsAnyEmissionDoes)
{
    Scene scene = empty_scene(24);
    scene.camera.position = {0, 6, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 40;
    scene.world.radiance = glm::vec3(0);
    const GridMedium hot = hot_ball([](double r) { return r < 0.5 ? 2000.0 : 0.0; });
    GridMedium glows = hot;
    glows.temperature = nullptr;
    auto flame = std::make_shared<VoxelGrid>(*hot.temperature);
    for (float& value : flame->values)
        value /= 2000;
    flame->max_value = 1;
    glows.emission = flame;
    glows.emission_per_unit = study::blackbody_emission(2000);
    for (const Settings::Mode mode : {Settings::Mode::raymarch, Settings::Mode::froxel}) {
        Settings settings;
        settings.mode = mode;
        const auto mean = [&](const GridMedium& medium, int bounces) {
            scene.media = {medium};
            settings.bounces = bounces;
            const Still still = render(scene, settings);
            double sum = 0;
            for (const float v : still.scattering)
                sum += double(v);
            return sum / double(still.scattering.size());
        };
        const double seen = mean(hot, 0), lit = mean(hot, 8), like = mean(glows, 0),
                     like_lit = mean(glows, 8);
        figure("light sent back by the smoke, of what is seen", lit / seen - 1);
        EXPECT_GT(lit, 1.2 * seen);
        // Less of the smoke is lit by a little less of the ball, from a little deeper.
        EXPECT_NEAR(lit / seen, like_lit / like, 0.1 * (lit / seen - 1));
        // A third of a voxel less of 12.5 all around.
        EXPECT_GT(seen, 0.9 * like);
        EXPECT_LT(seen, like);
    }
}

// The air around a flame costs no step and widens no bounds: the picture is that without it, to
// what the steps differ by.
TEST_F(Blackbody, AirIsNotSeen)
{
    Scene scene = empty_scene(24);
    scene.camera.position = {0, 6, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 40;
    scene.world.radiance = glm::vec3(0.1f);
    const GridMedium hot = hot_ball([](double r) { return 2000 * std::exp(-8 * r * r); });
    GridMedium in_air = hot;
    auto air = std::make_shared<VoxelGrid>(*hot.temperature);
    for (float& value : air->values)
        value = std::max(value, 293.0f);
    air->index_min = glm::ivec3(0);
    air->index_max = glm::ivec3(63);
    in_air.temperature = air;
    for (const Settings& settings : plain_siblings()) {
        scene.media = {hot};
        const Still alone = render(scene, settings);
        scene.media = {in_air};
        const Still within = render(scene, settings);
        const study::Metrics m = study::compare(within.scattering, alone.scattering);
        figure("relMSE of air", m.relmse);
        EXPECT_LT(m.relmse, 1e-4);
        EXPECT_LT(max_difference(picture_of(within, within.transmittance),
                                 picture_of(alone, alone.transmittance)),
                  2e-3)
            << "its steps lie elsewhere";
        // A corner of the picture, past the smoke, in front of the air.
        EXPECT_EQ(within.scattering[0], 0.0f);
    }
    GridMedium cold = in_air;
    cold.density = nullptr;
    cold.blackbody_intensity = 1;
    cold.temperature_scale = 0.22;
    scene.media = {cold};
    const Still still = render(scene, plain_settings());
    for (const float v : still.scattering)
        ASSERT_EQ(v, 0.0f) << "440 K are not seen";
}

}  // namespace
}  // namespace fumarole::test
