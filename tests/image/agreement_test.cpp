// The passes on the GPU, with many steps, against the reference on the CPU: two programs that share
// nothing but the scene, over everything that a scene can say and no closed form covers.

#include <cmath>
#include <fmt/format.h>

#include "image_test.h"
#include "study/metrics.h"
#include "study/reference.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

std::shared_ptr<const Mesh> tetrahedron()
{
    auto mesh = std::make_shared<Mesh>();
    const std::array<glm::vec3, 4> corners{glm::vec3(0, 0, 1), glm::vec3(0.9f, 0, -0.4f),
                                           glm::vec3(-0.5f, 0.8f, -0.4f),
                                           glm::vec3(-0.5f, -0.8f, -0.4f)};
    const int faces[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
    for (const auto& face : faces) {
        const glm::vec3 a = corners[static_cast<std::size_t>(face[0])],
                        b = corners[static_cast<std::size_t>(face[1])],
                        c = corners[static_cast<std::size_t>(face[2])];
        for (const glm::vec3& p : {a, b, c}) {
            mesh->triangles.push_back(static_cast<std::uint32_t>(mesh->positions.size()));
            mesh->positions.push_back(p);
            mesh->normals.push_back(glm::normalize(glm::cross(b - a, c - a)));
        }
    }
    return mesh;
}

/// Three grids in one place: density, a flame in its middle, and a tint of its scattering.
GridMedium fire()
{
    const glm::dmat4 place = glm::dmat4(0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0, -0.8, 5, -0.8, 1);
    const auto blob = [](glm::ivec3 at, double radius) {
        const double d = glm::length(glm::dvec3(at) - 7.5) / radius;
        return d < 1 ? std::pow(1 - d * d, 2) * (1 + 0.4 * std::sin(1.3 * at.x + 0.9 * at.z)) : 0.0;
    };
    GridMedium medium;
    medium.density = make_grid(glm::ivec3(2), place, [&](glm::ivec3 at) { return blob(at, 7.5); });
    medium.emission = make_grid(glm::ivec3(2), place, [&](glm::ivec3 at) { return blob(at, 4.0); });
    auto tint = std::make_shared<VoxelGrid>(*medium.density);
    tint->channels = 3;
    tint->values.clear();
    for (std::size_t i = 0; i < medium.density->values.size(); ++i)
        for (const double share : {1.0, 0.3 + 0.4 * std::abs(std::sin(0.01 * double(i))), 0.5})
            tint->values.push_back(static_cast<float>(share));
    tint->max_value = 1;
    medium.color = tint;
    medium.sigma_s_per_density = {2, 3, 4};
    medium.sigma_a_per_density = {0.5f, 0.2f, 0.1f};
    medium.emission_per_unit = {3, 1, 0.2f};
    medium.g = 0.5f;
    return medium;
}

BoxMedium clouds(glm::dvec3 drift)
{
    BoxMedium box;
    box.min = {-2, 4, -1.5};
    box.max = {2, 7, 1.5};
    NoiseProfile noise;
    noise.feature_size = 0.8;
    noise.octaves = 3;
    noise.threshold = 0.4;
    noise.seed = 5;
    noise.drift = drift;
    box.profile = noise;
    box.sigma_s = {0.8f, 0.6f, 0.4f};
    box.sigma_a = {0.05f, 0.05f, 0.2f};
    box.g = -0.2f;
    return box;
}

BoxMedium haze()
{
    BoxMedium box;
    box.min = {-3, 3, -2};
    box.max = {3, 9, 2};
    box.profile = ExpHeightProfile{1.2, -0.5};
    box.sigma_s = glm::vec3(0.05f);
    box.sigma_a = glm::vec3(0.01f);
    box.g = 0.7f;
    return box;
}

Scene lit_scene()
{
    Scene scene = empty_scene(24);
    scene.camera.look_at = {0, 1, 0};
    scene.camera.vfov_deg = 28;
    scene.time = 1.7;
    scene.lights.emplace_back(SunLight{glm::normalize(glm::dvec3(-1, -1, 1)), {2, 2, 1.5f}});
    SpotLight spot;
    spot.position = {1.8, 3.5, 1.7};
    spot.direction = glm::normalize(glm::dvec3(-1, 1.3, -1));
    spot.cone_deg = 40;
    spot.blend = 0.4;
    spot.radiant_intensity = {20, 25, 30};
    scene.lights.emplace_back(spot);
    scene.lights.emplace_back(PointLight{{-1.6, 4.2, 1.4}, {5, 3, 2}});
    return scene;
}

class Agreement : public ImageTest {
protected:
    void expect_agreement(const Scene& scene, const char* name, double allowed)
    {
        Settings settings = plain_settings();
        settings.steps = 128;
        settings.distribution = 0;
        settings.shadow_steps = 48;
        settings.shadow_map = 4096;
        settings.shadow_volume_size = 0;   // the march itself is meant
        settings.ambient_volume_size = 0;  // and no field, by which what glows would light
        const Still still = render(scene, settings);
        study::ReferenceOptions options;
        options.tolerance = 2e-3;
        options.bounces = study::kLampsAndWorldOnce;
        const study::ReferenceStill reference = study::render_reference(scene, options);
        const auto check = [&](const char* target, const std::vector<float>& picture,
                               const std::vector<float>& expected) {
            const study::Metrics m = study::compare(picture, expected);
            figure(fmt::format("{} {} relMSE", name, target), m.relmse);
            EXPECT_LE(m.relmse, allowed) << target;
            EXPECT_LE(std::abs(m.bias), 2e-3) << target;
        };
        check("transmittance", still.transmittance, reference.transmittance);
        check("scattering", still.scattering, reference.scattering);
        if (!scene.surfaces.empty())
            check("surface_lit", still.surface_lit, reference.surface_lit);
    }
};

// 1e-5 is 0.3 % of each pixel: what 128 midpoints leave at the edges of the media.
TEST_F(Agreement, FireTintedAndGlowing)
{
    Scene scene = lit_scene();
    scene.media.emplace_back(fire());
    expect_agreement(scene, "fire", 1e-5);
}

/// Noise is dear on a software rasteriser.
Scene cloudy_scene(glm::dvec3 drift)
{
    Scene scene = lit_scene();
    scene.lights.resize(1);
    scene.resolution = {16, 16};
    scene.media = {clouds(drift)};
    return scene;
}

TEST_F(Agreement, DriftingNoise)
{
    expect_agreement(cloudy_scene({0.3, 0, 0.1}), "noise", 1e-5);
}

// 1e-5 as above, and as much again for the grid, which NoiseOutOfAGridIsTheNoise holds to that.
TEST_F(Agreement, NoiseThatStandsStill)
{
    expect_agreement(cloudy_scene(glm::dvec3(0)), "standing noise", 2e-5);
}

// What a grid changes of a picture is what it errs, and it ends at the medium's faces: the box's
// corners lie inside of the haze, where a voxel more would be seen.
TEST_F(Agreement, NoiseOutOfAGridIsTheNoise)
{
    Scene scene = cloudy_scene(glm::dvec3(0));
    scene.resolution = {64, 64};
    auto& cloud = std::get<BoxMedium>(scene.media[0]);
    std::get<NoiseProfile>(cloud.profile).threshold = 0.1f;
    scene.media.emplace_back(haze());
    Settings settings = plain_settings();
    settings.steps = 128;
    for (const int shadow_volume_size : {0, Settings::kAutomatic}) {
        settings.shadow_volume_size = shadow_volume_size;
        settings.noise_grid = true;
        const Still read = render(scene, settings);
        settings.noise_grid = false;
        const Still worked_out = render(scene, settings);
        EXPECT_NE(read.transmittance, worked_out.transmittance) << "it was one way twice";
        const study::Metrics transmittance =
                                 study::compare(read.transmittance, worked_out.transmittance),
                             scattering = study::compare(read.scattering, worked_out.scattering);
        figure("transmittance relMSE", transmittance.relmse);
        figure("scattering relMSE", scattering.relmse);
        EXPECT_LT(transmittance.relmse, 1e-5);
        EXPECT_LT(scattering.relmse, 1e-5);
        EXPECT_LT(std::abs(transmittance.bias), 5e-4);
        EXPECT_LT(std::abs(scattering.bias), 5e-4);
    }
}

TEST_F(Agreement, MediaOfDifferentGOverlap)
{
    Scene scene = lit_scene();
    scene.media = {fire(), haze()};
    expect_agreement(scene, "mixed g", 1e-5);
}

// A flame of a real fire, and the smoke in front of it.
TEST_F(Agreement, FireOfASampleGlowsByItsTemperature)
{
    Scene scene = lit_scene();
    scene.camera.position = {1.5, -14.5, 1.7};
    scene.camera.look_at = {0, 0, 1.5};
    scene.camera.vfov_deg = 14;
    scene.lights.resize(1);
    GridMedium medium;
    medium.file = FUM_TEST_DATA "/fire_plume.vdb";
    medium.grid = "density";
    medium.sigma_s_per_density = {8, 8.5f, 9};
    medium.sigma_a_per_density = {4, 4.25f, 4.5f};
    medium.g = 0.3f;
    medium.temperature_grid = "temperature";
    medium.blackbody_intensity = 3;
    medium.blackbody_tint = {1, 0.9f, 0.8f};
    asset::LoadedScene loaded{scene, {}};
    loaded.scene.media = {medium};
    asset::load_scene_files(loaded);
    EXPECT_THAT(loaded.notes, testing::Contains(testing::HasSubstr("thousands of kelvin")));
    expect_agreement(loaded.scene, "sample fire", 5e-5);
}

TEST_F(Agreement, HotSmokeGlowsAndAFlameInIt)
{
    Scene scene = lit_scene();
    GridMedium medium = fire();
    auto kelvin = std::make_shared<VoxelGrid>(*medium.density);
    for (float& value : kelvin->values)
        value = 293 + 1800 * value;
    kelvin->max_value = 293 + 1800 * kelvin->max_value;
    kelvin->index_min = glm::ivec3(0);
    kelvin->index_max = glm::ivec3(15);
    medium.temperature = kelvin;
    medium.blackbody_intensity = 8;
    scene.media.emplace_back(medium);
    expect_agreement(scene, "hot smoke", 1e-5);
}

TEST_F(Agreement, OrthographicCamera)
{
    Scene scene = lit_scene();
    scene.camera.projection = Camera::Projection::orthographic;
    scene.camera.ortho_height = 2.8;
    scene.media = {fire(), haze()};
    expect_agreement(scene, "orthographic", 1e-5);
}

// Shadows of the mesh and the ball come from a shadow map here and from rays there: along their
// edges the two differ by a texel, which 1e-3 allows for.
TEST_F(Agreement, MeshAndBallThrowShadowsThroughHaze)
{
    Scene scene = lit_scene();
    scene.media.emplace_back(haze());
    MeshSurface mesh;
    mesh.mesh = tetrahedron();
    mesh.translate = {0.5, 5.5, 0.2};
    mesh.scale = 0.6;
    scene.surfaces.emplace_back(mesh);
    scene.surfaces.emplace_back(SphereSurface{{-0.7, 5.8, -0.2}, 0.5, glm::vec3(0.6f)});
    scene.surfaces.emplace_back(BoxSurface{{-4, 3, -2.5}, {4, 10, -1.2}, glm::vec3(0.3f)});
    expect_agreement(scene, "mesh", 1e-3);
}

}  // namespace
}  // namespace fumarole::test
