#include <fumarole/asset/scene_file.h>

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <variant>
#include <vector>

#include "support/scene_schema.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

// The example of the format's description, with the keys that we added.
constexpr std::string_view kFullScene = R"({
  "title": "everything at once",
  "resolution": [640, 360],
  "time": 1.5,
  "camera": {"position": [0,-11,2.4], "look_at": [0,0,1.9], "up": [0,0,1], "vfov_deg": 32.0,
             "near": 0.1, "far": 40.0, "projection": "orthographic", "ortho_height": 6.5},
  "world_radiance": [0.15, 0.2, 0.3],
  "lights": [
    {"type": "sun", "direction_to_light": [-0.69,-0.23,0.69], "irradiance_W_per_m2": [5,4.75,4.25],
     "angle_deg": 0.5, "blender_strength": 3, "color": "any"},
    {"type": "point", "position": [-1.3,0.6,2.9], "radiant_intensity_W_per_sr": [31.8,28.6,23.9], "radius": 0.1},
    {"type": "spot", "position": [0,0,5], "direction": [0,0,-2], "cone_deg": 60, "blend": 0.25,
     "radiant_intensity_W_per_sr": [30,31,32]},
    {"type": "rect", "center": [0,0,5], "edges": [[2,0,0],[0,1,0]], "radiance_W_per_m2_sr": [10,10,9], "two_sided": true},
    {"type": "disk", "center": [0,1,5], "normal": [0,0,-2], "radius": 0.75, "radiance_W_per_m2_sr": [8,7,6]}
  ],
  "media": [
    {"type": "vdb", "file": "smoke_plume.vdb", "grid": "density", "translate": [1,2,3], "scale": 0.5,
     "sigma_s_per_density": [4,6,10], "sigma_a_per_density": [0.5,0.75,1.25], "g": 0.4,
     "emission_grid": "flame", "emission_per_unit": [3,0.9,0.18], "color_grid": "Cd",
     "temperature_grid": "temperature", "temperature_scale": 850, "blackbody_intensity": 2.5,
     "blackbody_tint": [1,0.75,0.5]},
    {"type": "box", "min": [-5,-5,-0.5], "max": [5,5,5.5], "profile": "homogeneous",
     "sigma_s": [0.1,0.2,0.3], "sigma_a": [0.02,0.03,0.04], "g": 0.3, "emission": [1,2,3]},
    {"type": "box", "min": [-60,-20,-0.5], "max": [60,180,60], "profile": "exp_height",
     "scale_height": 12, "z0": -3, "sigma_s": [0.018,0.018,0.018]},
    {"type": "box", "min": [-5,-5,0], "max": [5,5,4], "profile": "noise",
     "noise": {"feature_size": 1.25, "octaves": 4, "gain": 0.6, "lacunarity": 2.5, "threshold": 0.35,
               "seed": 4294967295, "drift_m_per_s": [0.5,0,-0.25]},
     "sigma_s": [2,2,2], "sigma_a": [0.1,0.1,0.1], "g": -0.2}
  ],
  "surfaces": [
    {"type": "sphere", "center": [0.25,0.1,2.4], "radius": 0.6, "albedo": [0.6,0.55,0.5], "note": {"a": [1]}},
    {"type": "box", "min": [-60,-60,-1], "max": [60,60,0], "albedo": [0.4,0.4,0.4]},
    {"type": "mesh", "file": "sub/column.gltf", "translate": [1,0,0], "scale": 2.5, "albedo": [0.1,0.2,0.3],
     "roughness": 0.25, "metallic": 0.75, "emission": [1,2,3]}
  ],
  "transparents": [
    {"type": "quad", "corner": [-2.2,-1,0.6], "edges": [[2.6,0.9,0],[0,0,3.6]], "blend": "alpha",
     "radiance": [0.05,0.22,0.3], "alpha": 0.45, "depth_fade": 0.5},
    {"type": "quad", "corner": [-1.6,0.9,1], "edges": [[3.2,-1.6,0],[0,0,3]], "blend": "multiply", "filter": [0.85,0.45,0.25],
     "casts": true},
    {"type": "quad", "corner": [-0.6,-0.3,1.6], "edges": [[2.4,0.2,0],[0,0.4,2.6]], "blend": "add", "radiance": [0.12,0.09,0.03]},
    {"type": "billboard", "center": [0,0,2], "size": [1,0.5], "image": "sub/spark.png", "blend": "premultiplied",
     "scale": 4.0, "alpha": 0.75},
    {"type": "mesh", "file": "glass.gltf", "translate": [0,1,0], "scale": 2,
     "blend": {"source": "dst_color", "destination": "one_minus_src_alpha"}, "radiance": [1,2,3], "alpha": 0.1}
  ],
  "probes": [
    {"position": [0,0,1.5], "radius": 4.5, "falloff": 0.25, "parallax": "box", "parallax_min": [-3.3,-2,0],
     "parallax_max": [3.3,4,5], "size": 64},
    {"position": [1,2,3], "parallax": "sphere"}
  ]
})";

constexpr std::string_view kCamera =
    R"("camera": {"position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40})";

std::string minimal(const std::string& more = "")
{
    return "{" + std::string(kCamera) + more + "}";
}

Scene parse(const TempFolder& folder, std::string_view text)
{
    Scene scene = asset::parse_scene(folder.write("fog.json", text));
    EXPECT_EQ(test::problem_of_accepted(std::string(text)), "") << text;
    return scene;
}

// The message of the Error that reading `text` throws; "" if it throws none.
std::string problem(const TempFolder& folder, std::string_view text)
{
    try {
        parse(folder, text);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

void expect_equal(const Scene& a, const Scene& b)
{
    EXPECT_EQ(a.resolution, b.resolution);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.camera.position, b.camera.position);
    EXPECT_EQ(a.camera.look_at, b.camera.look_at);
    EXPECT_EQ(a.camera.up, b.camera.up);
    EXPECT_EQ(a.camera.vfov_deg, b.camera.vfov_deg);
    EXPECT_EQ(a.camera.near, b.camera.near);
    EXPECT_EQ(a.camera.far, b.camera.far);
    EXPECT_EQ(a.camera.projection, b.camera.projection);
    EXPECT_EQ(a.camera.ortho_height, b.camera.ortho_height);
    EXPECT_EQ(a.world.radiance, b.world.radiance);
    EXPECT_EQ(a.world.environment_file, b.world.environment_file);
    EXPECT_EQ(a.world.environment_scale, b.world.environment_scale);

    ASSERT_EQ(a.lights.size(), b.lights.size());
    for (std::size_t i = 0; i < a.lights.size(); ++i) {
        ASSERT_EQ(a.lights[i].index(), b.lights[i].index());
        if (const auto* sun = std::get_if<SunLight>(&a.lights[i])) {
            EXPECT_EQ(sun->direction_to_light, std::get<SunLight>(b.lights[i]).direction_to_light);
            EXPECT_EQ(sun->irradiance, std::get<SunLight>(b.lights[i]).irradiance);
        } else if (const auto* point = std::get_if<PointLight>(&a.lights[i])) {
            const auto& other = std::get<PointLight>(b.lights[i]);
            EXPECT_EQ(point->position, other.position);
            EXPECT_EQ(point->radiant_intensity, other.radiant_intensity);
        } else if (!std::holds_alternative<SpotLight>(a.lights[i])) {
            EXPECT_EQ(a.lights[i], b.lights[i]);
        } else {
            const auto& spot = std::get<SpotLight>(a.lights[i]);
            const auto& other = std::get<SpotLight>(b.lights[i]);
            EXPECT_EQ(spot.position, other.position);
            EXPECT_EQ(spot.direction, other.direction);
            EXPECT_EQ(spot.cone_deg, other.cone_deg);
            EXPECT_EQ(spot.blend, other.blend);
            EXPECT_EQ(spot.radiant_intensity, other.radiant_intensity);
        }
    }

    ASSERT_EQ(a.media.size(), b.media.size());
    for (std::size_t i = 0; i < a.media.size(); ++i) {
        ASSERT_EQ(a.media[i].index(), b.media[i].index());
        if (const auto* grid = std::get_if<GridMedium>(&a.media[i])) {
            const auto& other = std::get<GridMedium>(b.media[i]);
            EXPECT_EQ(grid->file, other.file);
            EXPECT_EQ(grid->grid, other.grid);
            EXPECT_EQ(grid->emission_grid, other.emission_grid);
            EXPECT_EQ(grid->color_grid, other.color_grid);
            EXPECT_EQ(grid->translate, other.translate);
            EXPECT_EQ(grid->scale, other.scale);
            EXPECT_EQ(grid->sigma_s_per_density, other.sigma_s_per_density);
            EXPECT_EQ(grid->sigma_a_per_density, other.sigma_a_per_density);
            EXPECT_EQ(grid->g, other.g);
            EXPECT_EQ(grid->emission_per_unit, other.emission_per_unit);
            EXPECT_EQ(*grid, other);
            continue;
        }
        const auto& box = std::get<BoxMedium>(a.media[i]);
        const auto& other = std::get<BoxMedium>(b.media[i]);
        EXPECT_EQ(box.min, other.min);
        EXPECT_EQ(box.max, other.max);
        EXPECT_EQ(box.sigma_s, other.sigma_s);
        EXPECT_EQ(box.sigma_a, other.sigma_a);
        EXPECT_EQ(box.g, other.g);
        EXPECT_EQ(box.emission, other.emission);
        ASSERT_EQ(box.profile.index(), other.profile.index());
        if (const auto* falloff = std::get_if<ExpHeightProfile>(&box.profile)) {
            EXPECT_EQ(falloff->scale_height,
                      std::get<ExpHeightProfile>(other.profile).scale_height);
            EXPECT_EQ(falloff->z0, std::get<ExpHeightProfile>(other.profile).z0);
        } else if (const auto* noise = std::get_if<NoiseProfile>(&box.profile)) {
            const auto& twin = std::get<NoiseProfile>(other.profile);
            EXPECT_EQ(noise->feature_size, twin.feature_size);
            EXPECT_EQ(noise->octaves, twin.octaves);
            EXPECT_EQ(noise->gain, twin.gain);
            EXPECT_EQ(noise->lacunarity, twin.lacunarity);
            EXPECT_EQ(noise->threshold, twin.threshold);
            EXPECT_EQ(noise->seed, twin.seed);
            EXPECT_EQ(noise->drift, twin.drift);
        }
    }

    ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
    for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
        ASSERT_EQ(a.surfaces[i].index(), b.surfaces[i].index());
        if (const auto* sphere = std::get_if<SphereSurface>(&a.surfaces[i])) {
            const auto& other = std::get<SphereSurface>(b.surfaces[i]);
            EXPECT_EQ(sphere->center, other.center);
            EXPECT_EQ(sphere->radius, other.radius);
            EXPECT_EQ(sphere->albedo, other.albedo);
        } else if (const auto* box = std::get_if<BoxSurface>(&a.surfaces[i])) {
            const auto& other = std::get<BoxSurface>(b.surfaces[i]);
            EXPECT_EQ(box->min, other.min);
            EXPECT_EQ(box->max, other.max);
            EXPECT_EQ(box->albedo, other.albedo);
        } else {
            const auto& mesh = std::get<MeshSurface>(a.surfaces[i]);
            const auto& other = std::get<MeshSurface>(b.surfaces[i]);
            EXPECT_EQ(mesh.file, other.file);
            EXPECT_EQ(mesh.translate, other.translate);
            EXPECT_EQ(mesh.scale, other.scale);
            EXPECT_EQ(mesh.albedo, other.albedo);
        }
        EXPECT_EQ(a.surfaces[i], b.surfaces[i]) << "surface " << i;
    }

    ASSERT_EQ(a.transparents.size(), b.transparents.size());
    for (std::size_t i = 0; i < a.transparents.size(); ++i)
        EXPECT_TRUE(a.transparents[i] == b.transparents[i]) << "transparent " << i;
    EXPECT_TRUE(a.probes == b.probes);
}

TEST(SceneFile, ReadsEveryKey)
{
    const TempFolder folder;
    const Scene scene = parse(folder, kFullScene);
    EXPECT_EQ(scene.resolution, glm::uvec2(640, 360));
    EXPECT_EQ(scene.time, 1.5);
    EXPECT_EQ(scene.camera.position, glm::dvec3(0, -11, 2.4));
    EXPECT_EQ(scene.camera.look_at, glm::dvec3(0, 0, 1.9));
    EXPECT_EQ(scene.camera.vfov_deg, 32);
    EXPECT_EQ(scene.camera.near, 0.1);
    EXPECT_EQ(scene.camera.far, 40);
    EXPECT_EQ(scene.camera.projection, Camera::Projection::orthographic);
    EXPECT_EQ(scene.camera.ortho_height, 6.5);
    EXPECT_EQ(scene.world.radiance, glm::vec3(0.15f, 0.2f, 0.3f));

    ASSERT_EQ(scene.lights.size(), 5u);
    const auto& sun = std::get<SunLight>(scene.lights[0]);
    EXPECT_NEAR(glm::length(sun.direction_to_light), 1, 1e-15);
    EXPECT_NEAR(sun.direction_to_light.x, -0.69 / std::sqrt(0.69 * 0.69 * 2 + 0.23 * 0.23), 1e-15);
    EXPECT_EQ(sun.irradiance, glm::vec3(5, 4.75f, 4.25f));
    EXPECT_EQ(std::get<PointLight>(scene.lights[1]).position, glm::dvec3(-1.3, 0.6, 2.9));
    EXPECT_EQ(std::get<PointLight>(scene.lights[1]).radiant_intensity,
              glm::vec3(31.8f, 28.6f, 23.9f));
    const auto& spot = std::get<SpotLight>(scene.lights[2]);
    EXPECT_EQ(spot.position, glm::dvec3(0, 0, 5));
    EXPECT_EQ(spot.direction, glm::dvec3(0, 0, -1));
    EXPECT_EQ(spot.cone_deg, 60);
    EXPECT_EQ(spot.blend, 0.25);
    EXPECT_EQ(spot.radiant_intensity, glm::vec3(30, 31, 32));
    const auto& rect = std::get<RectLight>(scene.lights[3]);
    EXPECT_EQ(rect.center, glm::dvec3(0, 0, 5));
    EXPECT_EQ(rect.edges[0], glm::dvec3(2, 0, 0));
    EXPECT_EQ(rect.edges[1], glm::dvec3(0, 1, 0));
    EXPECT_EQ(rect.radiance, glm::vec3(10, 10, 9));
    EXPECT_TRUE(rect.two_sided);
    const auto& disk = std::get<DiskLight>(scene.lights[4]);
    EXPECT_EQ(disk.center, glm::dvec3(0, 1, 5));
    EXPECT_EQ(disk.normal, glm::dvec3(0, 0, -1));
    EXPECT_EQ(disk.radius, 0.75);
    EXPECT_EQ(disk.radiance, glm::vec3(8, 7, 6));
    EXPECT_FALSE(disk.two_sided);

    ASSERT_EQ(scene.media.size(), 4u);
    const auto& grid = std::get<GridMedium>(scene.media[0]);
    EXPECT_EQ(fs::path(grid.file), folder.path() / "smoke_plume.vdb");
    EXPECT_EQ(grid.grid, "density");
    EXPECT_EQ(grid.translate, glm::dvec3(1, 2, 3));
    EXPECT_EQ(grid.scale, 0.5);
    EXPECT_EQ(grid.sigma_s_per_density, glm::vec3(4, 6, 10));
    EXPECT_EQ(grid.sigma_a_per_density, glm::vec3(0.5f, 0.75f, 1.25f));
    EXPECT_EQ(grid.g, 0.4f);
    EXPECT_EQ(grid.emission_grid, "flame");
    EXPECT_EQ(grid.emission_per_unit, glm::vec3(3, 0.9f, 0.18f));
    EXPECT_EQ(grid.temperature_grid, "temperature");
    EXPECT_EQ(grid.temperature_scale, 850);
    EXPECT_EQ(grid.blackbody_intensity, 2.5f);
    EXPECT_EQ(grid.blackbody_tint, glm::vec3(1, 0.75f, 0.5f));
    EXPECT_EQ(grid.color_grid, "Cd");
    EXPECT_EQ(grid.density, nullptr);
    const auto& fog = std::get<BoxMedium>(scene.media[1]);
    EXPECT_TRUE(std::holds_alternative<HomogeneousProfile>(fog.profile));
    EXPECT_EQ(fog.min, glm::dvec3(-5, -5, -0.5));
    EXPECT_EQ(fog.max, glm::dvec3(5, 5, 5.5));
    EXPECT_EQ(fog.sigma_s, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(fog.sigma_a, glm::vec3(0.02f, 0.03f, 0.04f));
    EXPECT_EQ(fog.g, 0.3f);
    EXPECT_EQ(fog.emission, glm::vec3(1, 2, 3));
    const auto& falloff = std::get<ExpHeightProfile>(std::get<BoxMedium>(scene.media[2]).profile);
    EXPECT_EQ(falloff.scale_height, 12);
    EXPECT_EQ(falloff.z0, -3);
    EXPECT_EQ(std::get<BoxMedium>(scene.media[2]).sigma_a, glm::vec3(0));
    const auto& noise = std::get<NoiseProfile>(std::get<BoxMedium>(scene.media[3]).profile);
    EXPECT_EQ(noise.feature_size, 1.25);
    EXPECT_EQ(noise.octaves, 4);
    EXPECT_EQ(noise.gain, 0.6);
    EXPECT_EQ(noise.lacunarity, 2.5);
    EXPECT_EQ(noise.threshold, 0.35);
    EXPECT_EQ(noise.seed, 4294967295u);
    EXPECT_EQ(noise.drift, glm::dvec3(0.5, 0, -0.25));

    ASSERT_EQ(scene.surfaces.size(), 3u);
    EXPECT_EQ(std::get<SphereSurface>(scene.surfaces[0]).radius, 0.6);
    EXPECT_EQ(std::get<BoxSurface>(scene.surfaces[1]).min, glm::dvec3(-60, -60, -1));
    const auto& mesh = std::get<MeshSurface>(scene.surfaces[2]);
    EXPECT_EQ(fs::path(mesh.file), folder.path() / "sub" / "column.gltf");
    EXPECT_EQ(mesh.scale, 2.5);
    EXPECT_EQ(mesh.albedo, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(mesh.gloss, (Gloss{.roughness = 0.25f, .metallic = 0.75f}));
    EXPECT_EQ(mesh.emission, glm::vec3(1, 2, 3));
    EXPECT_EQ(std::get<SphereSurface>(scene.surfaces[0]).gloss, std::nullopt);
    EXPECT_EQ(std::get<SphereSurface>(scene.surfaces[0]).emission, glm::vec3(0));
    ASSERT_EQ(scene.probes.size(), 2u);
    EXPECT_TRUE(scene.probes[0] == (LightProbe{.position = {0, 0, 1.5},
                                               .radius = 4.5,
                                               .falloff = 0.25,
                                               .parallax = LightProbe::Parallax::box,
                                               .parallax_min = {-3.3, -2, 0},
                                               .parallax_max = {3.3, 4, 5},
                                               .size = 64}));
    EXPECT_TRUE(scene.probes[1] ==
                (LightProbe{.position = {1, 2, 3}, .parallax = LightProbe::Parallax::sphere}));
}

// glTF 2.0's defaults of both factors are 1.
TEST(SceneFile, OneOfRoughnessAndMetallicMakesASurfaceGlossy)
{
    const TempFolder folder;
    const auto gloss_of = [&](const std::string& keys) {
        const Scene scene = parse(
            folder, minimal(R"(, "surfaces": [{"type": "sphere", "center": [0,0,0], "radius": 1)" +
                            keys + "}]"));
        return std::get<SphereSurface>(scene.surfaces.at(0)).gloss;
    };
    EXPECT_EQ(gloss_of(""), std::nullopt);
    EXPECT_EQ(gloss_of(R"(, "emission": [1,1,1])"), std::nullopt);
    EXPECT_EQ(gloss_of(R"(, "roughness": 0.5)"), (Gloss{.roughness = 0.5f, .metallic = 1}));
    EXPECT_EQ(gloss_of(R"(, "metallic": 0)"), (Gloss{.roughness = 1, .metallic = 0}));
    EXPECT_EQ(gloss_of(R"(, "metallic": 1, "roughness": 0)"),
              (Gloss{.roughness = 0, .metallic = 1}));
}

// A mesh that states no albedo has what it states, and the rest from its file; one that states it
// has nothing from there.
TEST(SceneFile, ASceneWinsOverAMeshsMaterial)
{
    const TempFolder folder;
    const auto mesh = [&](const std::string& keys) {
        asset::LoadedScene loaded;
        loaded.scene = parse(
            folder, minimal(R"(, "surfaces": [{"type": "mesh", "file": "a.gltf")" + keys + "}]"));
        Mesh triangle;
        triangle.material =
            MeshMaterial{{0.1f, 0.2f, 0.3f}, {.roughness = 0.4f, .metallic = 0.6f}, {7, 8, 9}};
        std::get<MeshSurface>(loaded.scene.surfaces.at(0)).mesh =
            std::make_shared<const Mesh>(triangle);
        // Saved before its files are loaded, it says as little as it did.
        const Scene saved = parse(folder, asset::scene_to_json(loaded.scene, folder.path()));
        EXPECT_EQ(std::get<MeshSurface>(saved.surfaces.at(0)).from_mesh,
                  std::get<MeshSurface>(loaded.scene.surfaces.at(0)).from_mesh);
        asset::load_scene_files(loaded);
        return std::get<MeshSurface>(loaded.scene.surfaces.at(0));
    };
    MeshSurface found = mesh("");
    EXPECT_EQ(found.albedo, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(found.gloss, (Gloss{.roughness = 0.4f, .metallic = 0.6f}));
    EXPECT_EQ(found.emission, glm::vec3(7, 8, 9));
    EXPECT_EQ(found.from_mesh, FromMesh());

    found = mesh(R"(, "metallic": 0, "emission": [0,0,0])");
    EXPECT_EQ(found.albedo, glm::vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(found.gloss, (Gloss{.roughness = 0.4f, .metallic = 0}));
    EXPECT_EQ(found.emission, glm::vec3(0));

    found = mesh(R"(, "albedo": [0.5,0.5,0.5])");
    EXPECT_EQ(found.albedo, glm::vec3(0.5f));
    EXPECT_EQ(found.gloss, std::nullopt);
    EXPECT_EQ(found.emission, glm::vec3(0));
}

TEST(SceneFile, LeavesDefaultsWhereKeysAreMissing)
{
    const TempFolder folder;
    const Scene scene = parse(
        folder,
        minimal(R"(, "media": [{"type": "vdb", "file": "a.vdb", "sigma_s_per_density": [1,2,3]},
                                {"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma_s": [1,1,1]}])"));
    EXPECT_EQ(scene.resolution, Scene().resolution);
    EXPECT_EQ(scene.camera.up, Camera().up);
    EXPECT_EQ(scene.camera.near, Camera().near);
    EXPECT_EQ(scene.camera.far, Camera().far);
    EXPECT_EQ(scene.camera.projection, Camera::Projection::perspective);
    EXPECT_EQ(scene.world.radiance, glm::vec3(0));
    EXPECT_TRUE(scene.lights.empty());
    EXPECT_TRUE(scene.surfaces.empty());
    const auto& grid = std::get<GridMedium>(scene.media.at(0));
    EXPECT_EQ(grid.grid, "");
    EXPECT_EQ(grid.emission_grid, "");
    EXPECT_EQ(grid.sigma_a_per_density, glm::vec3(0));
    EXPECT_EQ(grid.g, 0);
    EXPECT_EQ(grid.scale, 1);
    const auto& box = std::get<BoxMedium>(scene.media.at(1));
    EXPECT_TRUE(std::holds_alternative<HomogeneousProfile>(box.profile));
    EXPECT_EQ(box.emission, glm::vec3(0));
}

TEST(SceneFile, WorldIsAColourOrAMap)
{
    const TempFolder folder;
    const Scene scene = parse(
        folder, minimal(R"(, "world_radiance": {"environment": "../sky.exr", "scale": 0.5})"));
    EXPECT_EQ(fs::path(scene.world.environment_file), folder.path().parent_path() / "sky.exr");
    EXPECT_EQ(scene.world.environment_scale, 0.5f);
}

TEST(SceneFile, AcceptsTheEdgesOfEveryRange)
{
    const TempFolder folder;
    for (
        const char* more :
        {R"(, "resolution": [1, 16384])", R"(, "resolution": [480.0, 2.7e2])",
         R"(, "world_radiance": [0, 0, 0])", R"(, "time": -3)",
         R"(, "surfaces": [{"type": "sphere", "center": [0,0,0], "radius": 1e-9, "albedo": [0,1,1]}])",
         R"(, "media": [{"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma_s": [0,0,0], "g": -0.999}])",
         R"(, "media": [{"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma_s": [0,0,0],
              "profile": "noise"}])",
         R"(, "lights": [{"type": "sun", "direction_to_light": [0,1e-320,0], "irradiance_W_per_m2": [0,0,0]}])"})
        EXPECT_EQ(problem(folder, minimal(more)), "") << more;
}

TEST(SceneFile, AnOrthographicCameraNeedsAHeightOrAnAngle)
{
    const TempFolder folder;
    const auto camera = [&](const char* members) {
        return std::string(R"({"camera": {"position": [0,-5,1], "look_at": [0,0,1])") + members +
               "}}";
    };
    const Scene high =
        parse(folder, camera(R"(, "projection": "orthographic", "ortho_height": 24)"));
    EXPECT_EQ(high.camera.ortho_height, 24);
    const Scene wide = parse(folder, camera(R"(, "projection": "orthographic", "vfov_deg": 50)"));
    EXPECT_EQ(wide.camera.vfov_deg, 50);
    EXPECT_EQ(wide.camera.ortho_height, 0);
    for (const char* neither : {R"(, "projection": "orthographic")", R"(, "ortho_height": 24)",
                                R"(, "projection": "orthographic", "ortho_height": 0)"})
        EXPECT_NE(problem(folder, camera(neither)).find("missing key 'vfov_deg'"),
                  std::string::npos)
            << neither;
    // Written and read back it is the same.
    asset::save_scene(high, folder.path() / "t.json");
    EXPECT_EQ(asset::parse_scene(folder.path() / "t.json").camera, high.camera);
}

// What stands in a message: the place, the key, what was expected.
struct BadScene {
    const char* name;
    std::string text;
    std::vector<std::string> expected;
};

void PrintTo(const BadScene& item, std::ostream* out)
{
    *out << item.name;
}

std::string camera_with(const char* members)
{
    return std::string(
               R"({"camera": {"position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40, )") +
           members + "}}";
}
std::string light(const char* members)
{
    return minimal(std::string(R"(, "lights": [{)") + members + "}]");
}
std::string medium(const char* members)
{
    return minimal(
        std::string(
            R"(, "media": [{"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma_s": [1,1,1], )") +
        members + "}]");
}
std::string grid(const char* members)
{
    return minimal(
        std::string(
            R"(, "media": [{"type": "vdb", "file": "a.vdb", "sigma_s_per_density": [1,1,1], )") +
        members + "}]");
}
std::string probe(const std::string& members)
{
    return minimal(R"(, "probes": [{)" + members + "}]");
}

std::string transparent(const std::string& members)
{
    return minimal(R"(, "transparents": [{)" + members + "}]");
}

std::string board(const char* members)
{
    return transparent(std::string(R"("type": "billboard", "center": [0,0,0], "size": [1,1], )") +
                       members);
}

std::string surface(const char* members)
{
    return minimal(std::string(R"(, "surfaces": [{)") + members + "}]");
}
std::string noise(const char* member)
{
    return medium((std::string(R"("profile": "noise", "noise": {)") + member + "}").c_str());
}

std::vector<BadScene> bad_scenes()
{
    const std::string deep_list = std::string(200000, '[') + std::string(200000, ']');
    std::string deep_object;
    for (int i = 0; i < 50000; ++i)
        deep_object += R"({"note":)";
    return {
        {"empty", "", {"not valid JSON", "line 1, column 1"}},
        {"only_space", " \n ", {"not valid JSON", "line 2"}},
        {"list", "[]", {"expected an object"}},
        {"number", "7", {"expected an object", "got 7"}},
        {"cut", "{\n \"camera\":\n  {", {"line 3, column 3", "unexpected end of input"}},
        {"comma",
         "{\n \"time\": 1,\n}",
         {"line 3, column 1", "expected string literal", "the comma before it"}},
        {"comma_in_list", "[1, 2, ]", {"take out the comma before it"}},
        {"comment", "{ // said\n \"time\": 1}", {"line 1, column 3", "JSON has no comments"}},
        {"comment_at_end", "{\"time\": 1 /* s */}", {"JSON has no comments"}},
        {"hash", "# said\n{}", {"JSON has no comments"}},
        {"quotes", "{'time': 1}", {"double quotes"}},
        {"utf16", std::string("\xff\xfe{\0", 4), {"UTF-16", "UTF-8"}},
        {"nan", minimal(",\n \"time\": NaN"), {"line 2, column 10", "invalid literal", "no NaN"}},
        {"infinity",
         minimal(R"(, "time": -Infinity)"),
         {"line 1", "not valid JSON", "no infinity"}},
        {"overflow", minimal(R"(, "time": 1e999)"), {"line 1", "number overflow", "1e999"}},
        {"utf8", minimal(", \"t\xff\": 1"), {"not valid JSON", "UTF-8"}},
        {"two_documents", minimal() + minimal(), {"not valid JSON"}},
        {"deep_list", minimal(R"(, "note": )" + deep_list), {"nested deeper than 32"}},
        {"deep_object", deep_object, {"nested deeper than 32"}},
        {"twice", minimal(R"(, "time": 1, "time": 2)"), {"key 'time' occurs twice"}},
        {"twice_inside",
         light(R"("type": "sun", "type": "sun")"),
         {"lights[0]: key 'type' occurs twice"}},

        {"no_camera", "{}", {"missing key 'camera'", "vfov_deg"}},
        {"top_key",
         minimal(R"(, "medium": [])"),
         {"fog.json: unknown key 'medium' (known: ", "media"}},
        {"control_in_key", minimal(R"(, "a\nb": 1)"), {"unknown key 'a\\x0ab'"}},
        {"resolution_zero",
         minimal(R"(, "resolution": [0, 4])"),
         {"resolution[0]", "[1, 16384]", "got 0"}},
        {"resolution_big",
         minimal(R"(, "resolution": [4, 16385])"),
         {"resolution[1]", "16384", "got 16385"}},
        {"resolution_half",
         minimal(R"(, "resolution": [4.5, 4])"),
         {"resolution[0]", "whole number", "got 4.5"}},
        {"resolution_one",
         minimal(R"(, "resolution": [4])"),
         {"resolution: expected a list of two numbers", "a list of 1"}},
        {"resolution_text",
         minimal(R"(, "resolution": "4x4")"),
         {"resolution: expected a list of two numbers", "'4x4'"}},
        {"time_text",
         minimal(R"(, "time": "now")"),
         {"time: expected a number", "seconds", "'now'"}},
        {"time_null", minimal(R"(, "time": null)"), {"time: expected a number", "got null"}},
        {"time_bool", minimal(R"(, "time": true)"), {"time: expected a number", "got true"}},
        {"world_grey",
         minimal(R"(, "world_radiance": 1)"),
         {"world_radiance: expected a list of three numbers", "got 1"}},
        {"world_negative",
         minimal(R"(, "world_radiance": [0,0,-1])"),
         {"world_radiance[2]", "W/m^2/sr", "got -1"}},
        {"world_no_map",
         minimal(R"(, "world_radiance": {"scale": 1})"),
         {"world_radiance: missing key 'environment'"}},
        {"world_empty_map",
         minimal(R"(, "world_radiance": {"environment": ""})"),
         {"world_radiance.environment", "name of a file"}},
        {"world_scale",
         minimal(R"(, "world_radiance": {"environment": "a.exr", "scale": -1})"),
         {"world_radiance.scale", "got -1"}},
        {"world_key",
         minimal(R"(, "world_radiance": {"environment": "a.exr", "rotate": 1})"),
         {"world_radiance: unknown key 'rotate' (known: environment, scale)"}},
        // Keys that are looked at twice, and those that others leave room for, once each.
        {"transparent_key",
         minimal(R"(, "transparents": [{"type": "billboard", "center": [0,0,0], "size": [1,1],
                                        "texture": "a.png"}])"),
         {"transparents[0]: unknown key 'texture' (known: type, center, size, blend, radiance, "
          "filter, alpha, depth_fade, image, scale, casts)"}},

        {"camera_keys", R"({"camera": [{"time": 0}]})", {"camera[0]: missing key 'position'"}},
        {"camera_no_keys", R"({"camera": []})", {"camera: expected a camera, or a list"}},
        {"camera_key_time",
         R"({"camera": [{"position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40}]})",
         {"camera[0]: missing key 'time'", "seconds"}},
        {"camera_keys_order",
         R"({"camera": [{"time": 2, "position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40},
                        {"time": 2, "position": [0,-5,1], "look_at": [0,0,1]}]})",
         {"camera[1].time: expected more than the key's before, got 2 after 2"}},
        {"camera_keys_projection",
         R"({"camera": [{"time": 1, "position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40},
                        {"time": 2, "position": [0,-5,1], "look_at": [0,0,1],
                         "projection": "orthographic"}]})",
         {"camera[1].projection: expected the same in all keys"}},
        {"frame_rate",
         R"({"camera": {"position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40},
             "frames_per_second": 0})",
         {"frames_per_second: expected a number", "1/s"}},
        {"camera_empty",
         R"({"camera": {}})",
         {"camera: missing key 'position'", "three numbers", "metres"}},
        {"camera_look_at",
         R"({"camera": {"position": [0,0,0], "vfov_deg": 3}})",
         {"camera: missing key 'look_at'"}},
        {"camera_vfov",
         R"({"camera": {"position": [0,0,0], "look_at": [0,1,0]}})",
         {"camera: missing key 'vfov_deg'", "(0, 180)"}},
        {"camera_typo",
         R"({"camera": {"position": [0,0,0], "look_at": [0,1,0], "fov": 40}})",
         {"camera: unknown key 'fov'", "vfov_deg"}},
        {"vfov_zero",
         R"({"camera": {"position": [0,0,0], "look_at": [0,1,0], "vfov_deg": 0}})",
         {"camera.vfov_deg", "(0, 180)", "got 0"}},
        {"vfov_wide",
         R"({"camera": {"position": [0,0,0], "look_at": [0,1,0], "vfov_deg": 180}})",
         {"camera.vfov_deg", "(0, 180)", "got 180"}},
        {"look_at_self",
         R"({"camera": {"position": [0,1,0], "look_at": [0,1,0], "vfov_deg": 9}})",
         {"camera.look_at", "another point"}},
        {"far_away",
         R"({"camera": {"position": [0,1e300,0], "look_at": [0,1,0], "vfov_deg": 9}})",
         {"camera.position[1]", "1e+300"}},
        {"near_zero", camera_with(R"("near": 0)"), {"camera.near", "(0, ", "got 0"}},
        {"near_far",
         camera_with(R"("near": 2, "far": 2)"),
         {"camera.far", "more than near", "got 2"}},
        {"up_zero", camera_with(R"("up": [0,0,0])"), {"camera.up", "expected a direction"}},
        {"up_parallel", camera_with(R"("up": [0,-3,0])"), {"camera.up", "parallel"}},
        {"projection",
         camera_with(R"("projection": "fisheye")"),
         {"camera.projection", "'perspective', 'orthographic'", "'fisheye'"}},
        {"ortho_height", camera_with(R"("ortho_height": -1)"), {"camera.ortho_height", "got -1"}},

        {"lights_object",
         minimal(R"(, "lights": {})"),
         {"lights: expected a list", "got an object"}},
        {"light_number", minimal(R"(, "lights": [3])"), {"lights[0]: expected an object", "got 3"}},
        {"light_no_type", light(""), {"lights[0]: missing key 'type'", "'sun', 'point', 'spot'"}},
        {"light_type",
         light(R"("type": "area")"),
         {"lights[0].type", "'sun', 'point', 'spot'", "'area'"}},
        {"light_type_number", light(R"("type": 1)"), {"lights[0].type", "'sun'", "got 1"}},
        {"sun_no_direction",
         light(R"("type": "sun", "irradiance_W_per_m2": [1,1,1])"),
         {"lights[0]: missing key 'direction_to_light'"}},
        {"sun_zero",
         light(
             R"("type": "sun", "direction_to_light": [0,0,-0.0], "irradiance_W_per_m2": [1,1,1])"),
         {"lights[0].direction_to_light", "expected a direction"}},
        {"sun_irradiance",
         light(R"("type": "sun", "direction_to_light": [0,0,1], "irradiance_W_per_m2": [1,-1,1])"),
         {"lights[0].irradiance_W_per_m2[1]", "W/m^2", "got -1"}},
        {"sun_intensity",
         light(
             R"("type": "sun", "direction_to_light": [0,0,1], "radiant_intensity_W_per_sr": [1,1,1])"),
         {"lights[0]: unknown key 'radiant_intensity_W_per_sr'", "irradiance_W_per_m2"}},
        {"point_position",
         light(R"("type": "point", "position": [0,0], "radiant_intensity_W_per_sr": [1,1,1])"),
         {"lights[0].position", "three numbers", "a list of 2"}},
        {"point_intensity",
         light(R"("type": "point", "position": [0,0,0])"),
         {"lights[0]: missing key 'radiant_intensity_W_per_sr'", "W/sr"}},
        {"rect_edges_missing",
         light(R"("type": "rect", "center": [0,0,0], "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0]: missing key 'edges'", "two edges"}},
        {"rect_one_edge",
         light(
             R"("type": "rect", "center": [0,0,0], "edges": [[1,0,0]], "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0].edges", "two edges"}},
        {"rect_without_area",
         light(
             R"("type": "rect", "center": [0,0,0], "edges": [[1,0,0],[0,0,0]], "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0].edges", "span an area"}},
        {"rect_askew",
         light(
             R"("type": "rect", "center": [0,0,0], "edges": [[1,0,0],[1,1,0]], "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0].edges", "right angles, got 45.00 degrees"}},
        {"rect_sides",
         light(
             R"("type": "rect", "center": [0,0,0], "edges": [[1,0,0],[0,1,0]], "two_sided": 1, "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0].two_sided", "true or false"}},
        {"disk_radius",
         light(
             R"("type": "disk", "center": [0,0,0], "normal": [0,0,1], "radius": 0, "radiance_W_per_m2_sr": [1,1,1])"),
         {"lights[0].radius", "metres"}},
        {"spot_direction",
         light(
             R"("type": "spot", "position": [0,0,0], "direction": [0,0,0], "radiant_intensity_W_per_sr": [1,1,1])"),
         {"lights[0].direction", "expected a direction"}},
        {"spot_cone",
         light(
             R"("type": "spot", "position": [0,0,0], "direction": [0,0,1], "cone_deg": 180, "radiant_intensity_W_per_sr": [1,1,1])"),
         {"lights[0].cone_deg", "(0, 180)"}},
        {"spot_blend",
         light(
             R"("type": "spot", "position": [0,0,0], "direction": [0,0,1], "blend": 1.5, "radiant_intensity_W_per_sr": [1,1,1])"),
         {"lights[0].blend", "[0, 1]", "1.5"}},

        {"medium_type",
         minimal(R"(, "media": [{"type": "sphere"}])"),
         {"media[0].type", "'vdb', 'box'"}},
        {"second_medium",
         minimal(R"(, "media": [{"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma_s": [1,1,1]},
            {"type": "box", "min": [0,0,0], "max": [1,1,1], "sigma": [1,1,1]}])"),
         {"fog.json: media[1]: unknown key 'sigma' (known: type, ", "sigma_s"}},
        {"box_no_sigma",
         minimal(R"(, "media": [{"type": "box", "min": [0,0,0], "max": [1,1,1]}])"),
         {"media[0]: missing key 'sigma_s'", "1/m"}},
        {"box_no_min",
         minimal(R"(, "media": [{"type": "box", "max": [1,1,1], "sigma_s": [1,1,1]}])"),
         {"media[0]: missing key 'min'"}},
        {"box_flat",
         minimal(
             R"(, "media": [{"type": "box", "min": [0,0,1], "max": [1,1,1], "sigma_s": [1,1,1]}])"),
         {"media[0].max", "more than min", "z = 1"}},
        {"sigma_negative",
         medium(R"("sigma_a": [0,0,-0.1])"),
         {"media[0].sigma_a[2]", "1/m", "got -0.1"}},
        {"sigma_huge", medium(R"("sigma_a": [0,1e200,0])"), {"media[0].sigma_a[1]", "1e+200"}},
        {"sigma_grey",
         medium(R"("sigma_a": 0.5)"),
         {"media[0].sigma_a", "three numbers", "got 0.5"}},
        {"sigma_nested", medium(R"("sigma_a": [0,[1],0])"), {"media[0].sigma_a[1]", "a list of 1"}},
        {"g_one", medium(R"("g": 1)"), {"media[0].g", "(-1, 1)", "got 1"}},
        {"g_minus_one", medium(R"("g": -1.0)"), {"media[0].g", "(-1, 1)", "got -1"}},
        {"g_rounds_to_one", medium(R"("g": 0.9999999999)"), {"media[0].g", "(-1, 1)"}},
        {"emission_negative", medium(R"("emission": [-1,0,0])"), {"media[0].emission[0]"}},
        {"profile",
         medium(R"("profile": "fractal")"),
         {"media[0].profile", "'homogeneous', 'exp_height', 'noise'", "'fractal'"}},
        {"scale_height_missing",
         medium(R"("profile": "exp_height")"),
         {"media[0]: missing key 'scale_height'", "metres"}},
        {"scale_height_zero",
         medium(R"("profile": "exp_height", "scale_height": 0)"),
         {"media[0].scale_height", "got 0"}},
        {"z0_elsewhere", medium(R"("z0": 1)"), {"media[0]: unknown key 'z0'"}},
        {"noise_elsewhere", medium(R"("noise": {})"), {"media[0]: unknown key 'noise'"}},
        {"noise_list",
         medium(R"("profile": "noise", "noise": [])"),
         {"media[0].noise: expected an object"}},
        {"noise_key",
         noise(R"("size": 1)"),
         {"media[0].noise: unknown key 'size'", "feature_size"}},
        {"feature_size", noise(R"("feature_size": 0)"), {"media[0].noise.feature_size", "got 0"}},
        {"octaves_0", noise(R"("octaves": 0)"), {"media[0].noise.octaves", "[1, 16]", "got 0"}},
        {"octaves_17", noise(R"("octaves": 17)"), {"media[0].noise.octaves", "[1, 16]", "got 17"}},
        {"octaves_1_5", noise(R"("octaves": 1.5)"), {"media[0].noise.octaves", "whole number"}},
        {"gain", noise(R"("gain": 0)"), {"media[0].noise.gain", "(0, 1]"}},
        {"lacunarity", noise(R"("lacunarity": 0.5)"), {"media[0].noise.lacunarity", "[1, 16]"}},
        {"threshold", noise(R"("threshold": 1)"), {"media[0].noise.threshold", "[0, 1)"}},
        {"seed_negative", noise(R"("seed": -1)"), {"media[0].noise.seed", "got -1"}},
        {"seed_large", noise(R"("seed": 4294967296)"), {"media[0].noise.seed", "4294967296"}},
        {"seed_huge", noise(R"("seed": 123456789012345678901234567890)"), {"media[0].noise.seed"}},
        {"drift",
         noise(R"("drift_m_per_s": 1)"),
         {"media[0].noise.drift_m_per_s", "three numbers", "m/s"}},

        {"vdb_no_file",
         minimal(R"(, "media": [{"type": "vdb", "sigma_s_per_density": [1,1,1]}])"),
         {"media[0]: missing key 'file'"}},
        {"vdb_no_sigma",
         minimal(R"(, "media": [{"type": "vdb", "file": "a.vdb"}])"),
         {"media[0]: missing key 'sigma_s_per_density'"}},
        {"vdb_file_number",
         minimal(R"(, "media": [{"type": "vdb", "file": 1, "sigma_s_per_density": [1,1,1]}])"),
         {"media[0].file", "expected a text", "got 1"}},
        {"vdb_file_nul",
         minimal(
             R"(, "media": [{"type": "vdb", "file": "a\u0000b", "sigma_s_per_density": [1,1,1]}])"),
         {"media[0].file", "name of a file"}},
        {"vdb_sigma_s",
         grid(R"("sigma_s": [1,1,1])"),
         {"media[0]: unknown key 'sigma_s'", "sigma_s_per_density"}},
        {"vdb_scale", grid(R"("scale": 0)"), {"media[0].scale", "got 0"}},
        {"vdb_grid", grid(R"("grid": ["a"])"), {"media[0].grid", "expected a text"}},
        {"emission_without_grid",
         grid(R"("emission_per_unit": [1,1,1])"),
         {"media[0]", "'emission_per_unit' needs 'emission_grid'"}},
        {"grid_without_emission",
         grid(R"("emission_grid": "flame")"),
         {"media[0]", "'emission_grid' needs 'emission_per_unit'"}},
        {"temperature_scale_zero",
         grid(R"("temperature_grid": "heat", "temperature_scale": 0)"),
         {"media[0].temperature_scale", "kelvin per unit", "got 0"}},
        {"temperature_scale_alone",
         grid(R"("temperature_scale": 1000)"),
         {"media[0]", "'temperature_scale' needs 'temperature_grid'"}},
        {"blackbody_intensity_negative",
         grid(R"("temperature_grid": "heat", "blackbody_intensity": -1)"),
         {"media[0].blackbody_intensity", "got -1"}},
        {"blackbody_intensity_alone",
         grid(R"("blackbody_intensity": 1)"),
         {"media[0]", "'blackbody_intensity' needs 'temperature_grid'"}},
        {"blackbody_tint_of_two",
         grid(R"("temperature_grid": "heat", "blackbody_tint": [1,1])"),
         {"media[0].blackbody_tint", "three numbers"}},
        {"blackbody_tint_alone",
         grid(R"("blackbody_tint": [1,1,1])"),
         {"media[0]", "'blackbody_tint' needs 'temperature_grid'"}},

        {"surface_type",
         surface(R"("type": "plane")"),
         {"surfaces[0].type", "'sphere', 'box', 'mesh'"}},
        {"sphere_radius",
         surface(R"("type": "sphere", "center": [0,0,0])"),
         {"surfaces[0]: missing key 'radius'"}},
        {"sphere_radius_zero",
         surface(R"("type": "sphere", "center": [0,0,0], "radius": 0)"),
         {"surfaces[0].radius", "got 0"}},
        {"albedo_bright",
         surface(R"("type": "sphere", "center": [0,0,0], "radius": 1, "albedo": [0,1.01,0])"),
         {"surfaces[0].albedo[1]", "[0, 1]", "1.01"}},
        {"albedo_dark",
         surface(R"("type": "sphere", "center": [0,0,0], "radius": 1, "albedo": [-0.1,0,0])"),
         {"surfaces[0].albedo[0]", "[0, 1]", "-0.1"}},
        {"roughness_large",
         surface(R"("type": "sphere", "center": [0,0,0], "radius": 1, "roughness": 1.5)"),
         {"surfaces[0].roughness", "[0, 1]", "1.5"}},
        {"metallic_negative",
         surface(R"("type": "box", "min": [0,0,0], "max": [1,1,1], "metallic": -0.1)"),
         {"surfaces[0].metallic", "[0, 1]", "-0.1"}},
        {"surface_emission_negative",
         surface(R"("type": "mesh", "file": "a.gltf", "emission": [0,-1,0])"),
         {"surfaces[0].emission[1]", "W/m^2/sr", "-1"}},
        {"box_radius",
         surface(R"("type": "box", "min": [0,0,0], "max": [1,1,1], "radius": 1)"),
         {"surfaces[0]: unknown key 'radius'"}},
        {"box_inverted",
         surface(R"("type": "box", "min": [0,2,0], "max": [1,1,1])"),
         {"surfaces[0].max", "more than min", "y = 1"}},
        {"mesh_file", surface(R"("type": "mesh")"), {"surfaces[0]: missing key 'file'"}},
        {"mesh_scale",
         surface(R"("type": "mesh", "file": "a.obj", "scale": -1)"),
         {"surfaces[0].scale", "got -1"}},

        {"transparent_type",
         transparent(R"("type": "sphere")"),
         {"transparents[0].type", "'quad', 'billboard', 'mesh'", "'sphere'"}},
        {"probe_without_place", probe(R"("radius": 1)"), {"probes[0]: missing key 'position'"}},
        {"probe_radius",
         probe(R"("position": [0,0,0], "radius": 0)"),
         {"probes[0].radius", "metres", "got 0"}},
        {"probe_falloff",
         probe(R"("position": [0,0,0], "falloff": 1.5)"),
         {"probes[0].falloff", "[0, 1]", "1.5"}},
        {"probe_parallax",
         probe(R"("position": [0,0,0], "parallax": "cube")"),
         {"probes[0].parallax", "'none', 'sphere', 'box'", "'cube'"}},
        {"probe_without_box",
         probe(R"("position": [0,0,0], "parallax": "box")"),
         {"probes[0]: missing key 'parallax_min'"}},
        {"probe_box_inside_out",
         probe(
             R"("position": [0,0,0], "parallax": "box", "parallax_min": [0,0,0], "parallax_max": [1,0,1])"),
         {"probes[0].parallax_max", "more than parallax_min", "y = 0"}},
        {"probe_box_unused",
         probe(R"("position": [0,0,0], "parallax_min": [0,0,0])"),
         {"probes[0]: unknown key 'parallax_min'"}},
        {"probe_size",
         probe(R"("position": [0,0,0], "size": 1024)"),
         {"probes[0].size", "[16, 512] (pixels)", "1024"}},
        {"transparent_corner",
         transparent(R"("type": "quad", "edges": [[1,0,0],[0,0,1]])"),
         {"transparents[0]: missing key 'corner'"}},
        {"transparent_flat",
         transparent(R"("type": "quad", "corner": [0,0,0], "edges": [[1,0,0],[2,0,0]])"),
         {"transparents[0].edges", "span an area"}},
        {"transparent_size",
         transparent(R"("type": "billboard", "center": [0,0,0], "size": [1,0])"),
         {"transparents[0].size[1]", "got 0"}},
        {"transparent_size_of_three",
         transparent(R"("type": "billboard", "center": [0,0,0], "size": [1,1,1])"),
         {"transparents[0].size", "two numbers"}},
        {"transparent_blend",
         board(R"("blend": "screen")"),
         {"transparents[0].blend", "'alpha', 'premultiplied', 'add', 'multiply'", "'screen'"}},
        {"transparent_factor",
         board(R"("blend": {"source": "half", "destination": "one"})"),
         {"transparents[0].blend.source", "'src_alpha_saturate'", "'half'"}},
        {"transparent_half_a_pair",
         board(R"("blend": {"source": "one"})"),
         {"transparents[0].blend: missing key 'destination'"}},
        {"transparent_alpha", board(R"("alpha": 1.5)"), {"transparents[0].alpha", "[0, 1]", "1.5"}},
        {"transparent_alpha_of_add",
         board(R"("blend": "add", "alpha": 0.5)"),
         {"transparents[0]", "'alpha' is of no use", "add"}},
        {"transparent_filter",
         board(R"("filter": [1,1,1])"),
         {"transparents[0]", "'filter' needs", "multiply"}},
        {"transparent_board_that_casts",
         board(R"("casts": true)"),
         {"transparents[0]", "'casts' is for quads and meshes", "take a quad"}},
        {"transparent_that_casts_what_is_behind",
         transparent(R"("type": "mesh", "file": "a.obj", "casts": true,
                        "blend": {"source": "zero", "destination": "dst_color"})"),
         {"transparents[0]", "'casts' needs a blend", "what is behind"}},
        {"transparent_radiance_of_a_filter",
         board(R"("blend": "multiply", "radiance": [1,1,1])"),
         {"transparents[0]", "'radiance' is of no use"}},
        {"transparent_image_twice",
         board(R"("image": "a.png", "radiance": [1,1,1])"),
         {"transparents[0]", "'radiance' and 'image'"}},
        {"transparent_scale_alone",
         board(R"("scale": 2)"),
         {"transparents[0]", "'scale' needs 'image'"}},
        {"transparent_fade",
         board(R"("depth_fade": -1)"),
         {"transparents[0].depth_fade", "metres", "got -1"}},
        {"transparent_image_of_a_mesh",
         transparent(R"("type": "mesh", "file": "a.obj", "image": "a.png")"),
         {"transparents[0]: unknown key 'image'"}},
    };
}

class BadSceneFile : public testing::TestWithParam<BadScene> {};

TEST_P(BadSceneFile, IsRefusedByName)
{
    const TempFolder folder;
    const std::string message = problem(folder, GetParam().text);
    EXPECT_NE(message, "") << "was accepted";
    EXPECT_TRUE(message.starts_with((folder.path() / "fog.json").string() + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), folder.path().string().size() + 400) << message;
    for (const std::string& part : GetParam().expected)
        EXPECT_NE(message.find(part), std::string::npos) << "no \"" << part << "\" in: " << message;
    if (!test::is_beyond_a_schema(message)) {
        EXPECT_NE(test::problem_of_accepted(GetParam().text), "") << "by the schema it is right";
    }
}

INSTANTIATE_TEST_SUITE_P(All, BadSceneFile, testing::ValuesIn(bad_scenes()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(SceneFile, NamesAFileThatCannotBeRead)
{
    const TempFolder folder;
    for (const fs::path& file : {folder.path() / "none.json", folder.path()}) {
        try {
            asset::parse_scene(file);
            ADD_FAILURE() << file;
        } catch (const Error& error) {
            EXPECT_TRUE(std::string(error.what()).starts_with(file.string())) << error.what();
        }
    }
}

TEST(SceneFile, RefusesEveryPrefixOfAScene)
{
    const TempFolder folder;
    for (std::size_t length = 0; length < kFullScene.size(); ++length)
        ASSERT_NE(problem(folder, kFullScene.substr(0, length)), "") << "at " << length;
}

TEST(SceneFile, SurvivesAnyBytes)
{
    const TempFolder folder;
    std::mt19937 random(7);
    constexpr std::string_view kTokens[] = {
        "[",       "]",       "{",    "}",     ",",
        ":",       "\"",      "-",    "1e9",   "null",
        "\\u0000", "\\ud800", "\xff", "1e308", "99999999999999"};
    int refused = 0;
    for (int round = 0; round < 1500; ++round) {
        std::string text(kFullScene);
        const int changes = 1 + static_cast<int>(random() % 3);
        for (int i = 0; i < changes; ++i) {
            const std::size_t at = random() % text.size();
            switch (random() % 4) {
            case 0:
                text[at] = static_cast<char>(random());
                break;
            case 1:
                text.erase(at, random() % 20);
                break;
            case 2:
                text.insert(at, kTokens[random() % std::size(kTokens)]);
                break;
            default:
                text.insert(at, text.substr(random() % text.size(), random() % 60));
            }
        }
        refused += problem(folder, text).empty() ? 0 : 1;  // anything but Error ends the test
    }
    EXPECT_GT(refused, 750);
}

TEST(SceneFile, ReferenceScenesAreValid)
{
    const fs::path references = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference";
    if (!fs::exists(references / "S1.json"))
        GTEST_SKIP() << "no reference scenes in " << references;
    const Scene fog = asset::parse_scene(references / "S1.json");
    EXPECT_EQ(fog.surfaces.size(), 4u);
    const Scene smoke = asset::parse_scene(references / "S2.json");
    EXPECT_EQ(std::get<GridMedium>(smoke.media.at(0)).g, 0.4f);
    EXPECT_TRUE(fs::exists(std::get<GridMedium>(smoke.media.at(0)).file));
}

TEST(SceneFile, SampleScenesAreValid)
{
    int found = 0;
    for (const auto& entry : fs::directory_iterator(FUM_TEST_DATA)) {
        if (entry.path().extension() != ".json")
            continue;
        SCOPED_TRACE(entry.path());
        const Scene scene = asset::parse_scene(entry.path());
        EXPECT_FALSE(scene.media.empty());
        for (const Medium& item : scene.media) {
            const auto* volume = std::get_if<GridMedium>(&item);
            EXPECT_TRUE(volume == nullptr || fs::exists(volume->file));
        }
        ++found;
    }
    EXPECT_GE(found, 4);
}

TEST(WriteScene, ReadsBackToTheSameBits)
{
    const TempFolder folder;
    Scene scene = parse(folder, kFullScene);
    asset::save_scene(scene, folder.path() / "copy.json");
    expect_equal(scene, asset::parse_scene(folder.path() / "copy.json"));

    scene.world.environment_file = (folder.path() / "sky \"é\".exr").string();
    scene.world.environment_scale = 0.1f;
    scene.world.radiance = glm::vec3(0);
    scene.camera.projection = Camera::Projection::perspective;
    scene.time = 0;
    asset::save_scene(scene, folder.path() / "copy.json");
    expect_equal(scene, asset::parse_scene(folder.path() / "copy.json"));
}

TEST(WriteScene, KeepsAwkwardNumbers)
{
    const TempFolder folder;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> exponent(-30, 11);
    std::uniform_real_distribution<double> mantissa(-1, 1);
    const auto number = [&] { return mantissa(random) * std::pow(10.0, exponent(random)); };
    Scene scene;
    for (int i = 0; i < 500; ++i) {
        PointLight light_of;
        light_of.position = {number(), number(), number()};
        light_of.radiant_intensity = glm::abs(glm::vec3(number(), number(), number()));
        scene.lights.emplace_back(light_of);
        SunLight sun;
        sun.direction_to_light = glm::normalize(glm::dvec3(number(), number(), number()));
        scene.lights.emplace_back(sun);
    }
    PointLight edge;
    edge.position = {-0.0, std::numeric_limits<double>::denorm_min(), 0.1 + 0.2};
    edge.radiant_intensity = {std::numeric_limits<float>::denorm_min(), 16777217, 1e12f * 0.999f};
    scene.lights.emplace_back(edge);
    asset::save_scene(scene, folder.path() / "numbers.json");
    const Scene back = asset::parse_scene(folder.path() / "numbers.json");
    expect_equal(scene, back);
    EXPECT_TRUE(std::signbit(std::get<PointLight>(back.lights.back()).position.x));
}

TEST(WriteScene, IsLaidOutToBeRead)
{
    const TempFolder folder;
    const std::string text = asset::scene_to_json(parse(folder, kFullScene), folder.path());
    EXPECT_NE(text.find("\n  \"resolution\": [640, 360],\n"), std::string::npos) << text;
    EXPECT_NE(text.find("\n    {\"type\": \"point\", \"position\": [-1.3, 0.6, 2.9],\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("\"file\": \"sub/column.gltf\""), std::string::npos) << text;
    std::size_t start = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos;
         end = text.find('\n', start)) {
        EXPECT_LE(end - start, 120u) << text.substr(start, end - start);
        start = end + 1;
    }
}

TEST(WriteScene, NamesFilesRelativeToWhereTheyStand)
{
    const TempFolder folder;
    Scene scene;
    const auto written = [&](const fs::path& file) {
        scene.media = {GridMedium{}};
        std::get<GridMedium>(scene.media[0]).file = file.string();
        const std::string text = asset::scene_to_json(scene, folder.path() / "scenes");
        const std::size_t at = text.find("\"file\": \"") + 9;
        return text.substr(at, text.find('"', at) - at);
    };
    EXPECT_EQ(written(folder.path() / "scenes" / "a" / "b.vdb"), "a/b.vdb");
    EXPECT_EQ(written(folder.path() / "vdb" / "b.vdb"), "../vdb/b.vdb");
    EXPECT_EQ(written("/elsewhere/b.vdb"), "/elsewhere/b.vdb");
}

TEST(WriteScene, WorksWithRelativeFolders)
{
    const TempFolder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.path());
    Scene scene = parse(folder, minimal());
    scene.media = {GridMedium{}};
    std::get<GridMedium>(scene.media[0]).file = "a.vdb";
    asset::save_scene(scene, "copy.json");
    const Scene back = asset::parse_scene("copy.json");
    fs::current_path(before);
    EXPECT_EQ(std::get<GridMedium>(back.media.at(0)).file, "a.vdb");
}

TEST(WriteScene, RefusesWhatNoFileMaySay)
{
    const TempFolder folder;
    const fs::path file = folder.write("kept.json", "as it was");
    const auto message = [&](const Scene& scene) -> std::string {
        try {
            asset::save_scene(scene, file);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    Scene scene;
    scene.camera.vfov_deg = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(message(scene).find("camera.vfov_deg is not finite"), std::string::npos);
    scene = {};
    scene.media = {GridMedium{}};
    EXPECT_NE(message(scene).find("media[0].file"), std::string::npos);
    scene = {};
    scene.surfaces = {SphereSurface{{0, 0, 0}, 1, glm::vec3(2)}};
    EXPECT_NE(message(scene).find("surfaces[0].albedo[0]"), std::string::npos);
    scene = {};
    scene.world.environment_file = "sky\xff.exr";
    EXPECT_NE(message(scene).find("UTF-8"), std::string::npos);
    EXPECT_EQ(test::read_bytes(file), "as it was");
}

std::size_t files_in(const fs::path& folder)
{
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteScene, LeavesNothingBehindWhenItFails)
{
    const TempFolder folder;
    const Scene scene = parse(folder, kFullScene);
    EXPECT_THROW(asset::save_scene(scene, folder.path() / "none" / "a.json"), Error);
    EXPECT_THROW(asset::save_scene(scene, folder.path()), Error);
    fs::create_directories(folder.path() / "taken.json" / "inside");
    EXPECT_THROW(asset::save_scene(scene, folder.path() / "taken.json"), Error);
    EXPECT_EQ(files_in(folder.path()), 2u);  // fog.json, taken.json
    if (fs::exists("/dev/full")) {
        EXPECT_THROW(asset::save_scene(scene, "/dev/full"), Error);
        EXPECT_TRUE(fs::is_character_file("/dev/full"));
    }
}

// A limit on the size of files is the disk that fills up half way.
TEST(WriteScene, KeepsTheOldFileWhenTheDiskIsFull)
{
    const TempFolder folder;
    const Scene scene = parse(folder, kFullScene);
    const fs::path file = folder.write("kept.json", "as it was");
    const pid_t child = fork();
    if (child == 0) {
        rlimit limit{};
        limit.rlim_cur = limit.rlim_max = 256;
        std::signal(SIGXFSZ, SIG_IGN);
        setrlimit(RLIMIT_FSIZE, &limit);
        try {
            asset::save_scene(scene, file);
        } catch (const Error&) {
            std::_Exit(0);
        }
        std::_Exit(1);
    }
    ASSERT_GT(child, 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "no Error in the child";
    EXPECT_EQ(test::read_bytes(file), "as it was");
    EXPECT_EQ(files_in(folder.path()), 2u);
}

TEST(WriteScene, WritesThroughALink)
{
    const TempFolder folder;
    const Scene scene = parse(folder, minimal());
    const fs::path target = folder.write("target.json", "old");
    fs::create_symlink(target, folder.path() / "link.json");
    asset::save_scene(scene, folder.path() / "link.json");
    EXPECT_TRUE(fs::is_symlink(folder.path() / "link.json"));
    expect_equal(scene, asset::parse_scene(target));
}

TEST(LoadScene, ReadsEachMeshOnce)
{
    const TempFolder folder;
    folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    fs::create_directories(folder.path() / "sub");
    folder.write("two.json", minimal(R"(, "surfaces": [{"type": "mesh", "file": "t.obj"},
                                        {"type": "mesh", "file": "sub/../t.obj", "scale": 2}])"));
    const asset::LoadedScene loaded = asset::load_scene(folder.path() / "two.json");
    const auto& first = std::get<MeshSurface>(loaded.scene.surfaces.at(0));
    const auto& second = std::get<MeshSurface>(loaded.scene.surfaces.at(1));
    ASSERT_NE(first.mesh, nullptr);
    EXPECT_EQ(first.mesh, second.mesh);
    EXPECT_EQ(first.mesh->triangles.size(), 3u);
}

TEST(LoadScene, ReadsTheMeshesOfTransparentsWithThoseOfSurfaces)
{
    const TempFolder folder;
    folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("two.json", minimal(R"(, "surfaces": [{"type": "mesh", "file": "t.obj"}],
                                        "transparents": [{"type": "mesh", "file": "t.obj"}])"));
    const asset::LoadedScene loaded = asset::load_scene(folder.path() / "two.json");
    const auto& mesh = std::get<MeshTransparent>(loaded.scene.transparents.at(0)).mesh;
    ASSERT_NE(mesh, nullptr);
    EXPECT_EQ(mesh, std::get<MeshSurface>(loaded.scene.surfaces.at(0)).mesh);
}

TEST(LoadScene, NamesTheMissingPictureOfATransparent)
{
    const TempFolder folder;
    folder.write("a.json", minimal(R"(, "transparents": [{"type": "billboard", "center": [0,0,0],
                                        "size": [1,1], "image": "none.png"}])"));
    try {
        asset::load_scene(folder.path() / "a.json");
        FAIL() << "was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  (folder.path() / "none.png").string() + ": no such picture");
    }
}

TEST(LoadScene, ReadsEachGridOnceAndKeepsWhatIsThere)
{
    const fs::path sample = fs::path(FUM_TEST_DATA) / "fire_plume.vdb";
    if (!fs::exists(sample))
        GTEST_SKIP() << "no " << sample;
    GridMedium fire;
    fire.file = sample.string();
    fire.grid = "density";
    fire.emission_grid = "flame";
    GridMedium other = fire;
    other.grid = "";
    GridMedium filled;
    filled.density = std::make_shared<const VoxelGrid>();
    GridMedium half_filled = fire;
    half_filled.density = filled.density;
    asset::LoadedScene loaded;
    loaded.scene.media = {fire, other, filled};
    asset::load_scene_files(loaded);
    const auto& a = std::get<GridMedium>(loaded.scene.media[0]);
    const auto& b = std::get<GridMedium>(loaded.scene.media[1]);
    ASSERT_NE(a.density, nullptr);
    ASSERT_NE(a.emission, nullptr);
    EXPECT_EQ(a.density, b.density);
    EXPECT_EQ(a.emission, b.emission);
    EXPECT_NE(a.density, a.emission);
    EXPECT_EQ(std::get<GridMedium>(loaded.scene.media[2]).density, filled.density);

    loaded.scene.media = {half_filled};
    asset::load_scene_files(loaded);
    EXPECT_EQ(std::get<GridMedium>(loaded.scene.media[0]).density, filled.density);
    EXPECT_NE(std::get<GridMedium>(loaded.scene.media[0]).emission, nullptr);
}

TEST(LoadScene, ChoosesAndSaysTheUnitOfATemperature)
{
    const fs::path sample = fs::path(FUM_TEST_DATA) / "fire_plume.vdb";
    if (!fs::exists(sample))
        GTEST_SKIP() << "no " << sample;
    GridMedium fire;
    fire.file = sample.string();
    fire.grid = "density";
    fire.temperature_grid = "temperature";
    asset::LoadedScene loaded;
    loaded.scene.media = {fire};
    asset::load_scene_files(loaded);
    const auto& read = std::get<GridMedium>(loaded.scene.media[0]);
    ASSERT_NE(read.temperature, nullptr);
    EXPECT_EQ(read.temperature_scale, 1000);
    ASSERT_EQ(loaded.notes.size(), 1u);
    EXPECT_NE(loaded.notes[0].find("grid 'temperature' holds up to 2.84: taken as thousands of "
                                   "kelvin, 2840 K at most (\"temperature_scale\": 1000)"),
              std::string::npos)
        << loaded.notes[0];
    // What was chosen is written, and nothing is said of what is stated.
    const std::string text = asset::scene_to_json(loaded.scene, sample.parent_path());
    EXPECT_NE(text.find("\"temperature_scale\": 1000"), std::string::npos) << text;
    fire.temperature_scale = 100;
    loaded = {};
    loaded.scene.media = {fire};
    asset::load_scene_files(loaded);
    EXPECT_EQ(std::get<GridMedium>(loaded.scene.media[0]).temperature_scale, 100);
    EXPECT_TRUE(loaded.notes.empty());
}

TEST(LoadScene, ATemperatureHasOneNumberAVoxel)
{
    const fs::path cloud = fs::path(FUM_TEST_SHARED) / "field/22_color/cd.vdb";
    if (!fs::exists(cloud))
        GTEST_SKIP() << "no " << cloud;
    GridMedium fire;
    fire.file = cloud.string();
    fire.temperature_grid = "Cd";
    asset::LoadedScene loaded;
    loaded.scene.media = {fire};
    try {
        asset::load_scene_files(loaded);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what())
                      .find("cd.vdb: grid 'Cd' has three numbers a voxel, and a temperature_grid "
                            "needs one"),
                  std::string::npos)
            << error.what();
    }
}

TEST(LoadScene, NamesAFileThatIsNotThere)
{
    const TempFolder folder;
    for (const char* more :
         {R"(, "media": [{"type": "vdb", "file": "gone.vdb", "sigma_s_per_density": [1,1,1]}])",
          R"(, "surfaces": [{"type": "mesh", "file": "gone.obj"}])",
          R"(, "world_radiance": {"environment": "gone.exr"})"}) {
        const fs::path file = folder.write("gone.json", minimal(more));
        try {
            asset::load_scene(file);
            ADD_FAILURE() << more;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("gone."), std::string::npos) << error.what();
        }
    }
}

TEST(SceneFile, CameraPathComesBackAsItWas)
{
    const TempFolder folder;
    const fs::path file = folder.write("path.json", R"({"time": 0.5, "frames_per_second": 30,
        "camera": [{"time": 0, "position": [0,-5,1], "look_at": [0,0,1], "vfov_deg": 40, "near": 0.2},
                   {"time": 1, "position": [1,-5,1], "look_at": [0.1,0,1]},
                   {"time": 3, "position": [2,-5,1], "look_at": [0,0,1.5], "vfov_deg": 20}]})");
    const Scene scene = asset::parse_scene(file);
    ASSERT_EQ(scene.camera_path.size(), 3u);
    EXPECT_EQ(scene.frames_per_second, 30);
    EXPECT_EQ(scene.camera_path[1].camera.near, 0.2) << "left out: as in the key before";
    EXPECT_EQ(scene.camera_path[1].camera.vfov_deg, 40);
    EXPECT_NEAR(scene.camera.position.x, 0.5, 0.2)
        << "the camera is the path's at the scene's time";
    asset::save_scene(scene, folder.path() / "again.json");
    const Scene again = asset::parse_scene(folder.path() / "again.json");
    EXPECT_EQ(again.frames_per_second, 30);
    ASSERT_EQ(again.camera_path.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(again.camera_path[i].time, scene.camera_path[i].time);
        EXPECT_EQ(again.camera_path[i].camera.position, scene.camera_path[i].camera.position);
        EXPECT_EQ(again.camera_path[i].camera.look_at, scene.camera_path[i].camera.look_at);
        EXPECT_EQ(again.camera_path[i].camera.vfov_deg, scene.camera_path[i].camera.vfov_deg);
    }
}

}  // namespace
}  // namespace fumarole
