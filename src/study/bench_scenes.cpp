#include "study/bench_scenes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <tbb/parallel_for.h>

#include "study/handmade_vdb.h"
#include "write/whole_file.h"

namespace fumarole::study {

namespace {

constexpr double kPlumeHeight = 6;  ///< metres, and as wide
constexpr float kLeastDensity = 1e-3f;

/// Smooth noise, 0..1, that repeats after kPeriod cells. From a table: a large grid takes half a
/// billion values of it.
class NoiseTable {
public:
    NoiseTable()
    {
        std::uint32_t state = 1;
        for (float& value : values_) {  // xorshift32 (Marsaglia 2003)
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            value = static_cast<float>(state) * 0x1p-32f;
        }
    }

    [[nodiscard]] float operator()(glm::vec3 p) const
    {
        const glm::vec3 cell = glm::floor(p);
        const glm::ivec3 c(cell);
        glm::vec3 t = p - cell;
        t = t * t * (3.0f - 2.0f * t);
        const auto row = [&](int y, int z) {
            return glm::mix(at(c.x, y, z), at(c.x + 1, y, z), t.x);
        };
        return glm::mix(glm::mix(row(c.y, c.z), row(c.y + 1, c.z), t.y),
                        glm::mix(row(c.y, c.z + 1), row(c.y + 1, c.z + 1), t.y), t.z);
    }

private:
    static constexpr int kPeriod = 32;
    [[nodiscard]] float at(int x, int y, int z) const
    {
        const auto wrap = [](int i) { return static_cast<std::size_t>(i & (kPeriod - 1)); };
        return values_[wrap(x) + kPeriod * (wrap(y) + kPeriod * wrap(z))];
    }
    std::array<float, std::size_t(kPeriod) * kPeriod * kPeriod> values_;
};

/// Where the plume's axis is at a height 0..1, and how wide it is there, in heights.
glm::vec2 axis_at(float height)
{
    return 0.05f * height * glm::vec2(std::sin(7 * height), std::cos(5 * height));
}

float radius_at(float height)
{
    return 0.06f + 0.28f * height;
}

/// Density at p: x, y -0.5..0.5, z 0..1.
float plume_density(const NoiseTable& noise, glm::vec3 p)
{
    const float across = glm::length(glm::vec2(p) - axis_at(p.z)) / radius_at(p.z);
    if (across >= 1)
        return 0;
    float sum = 0, weight = 0.5f;
    for (float frequency = 9; frequency < 40; frequency *= 2, weight *= 0.5f)
        sum += weight * noise(p * frequency);
    const float body = 1 - across * across;
    const float ends = glm::smoothstep(0.0f, 0.05f, p.z) * glm::smoothstep(1.0f, 0.75f, p.z);
    const float density = glm::clamp(body + 3 * (sum - 0.55f), 0.0f, 1.0f) * body * ends;
    return density < kLeastDensity ? 0 : density;
}

/// Bricks of one layer, and what holds for its voxels.
struct BrickLayer {
    std::vector<glm::ivec3> bricks;
    std::vector<float> values;
    glm::ivec3 min{1 << 30}, max{-1};
    std::uint64_t active = 0;
    float max_value = 0;
};

BrickLayer fill_layer(const NoiseTable& noise, int n, int brick_z)
{
    constexpr int kDim = VoxelGrid::kBrickDim;
    BrickLayer layer;
    std::array<float, VoxelGrid::kBrickVoxels> values{};
    for (int by = 0; by < n / kDim; ++by)
        for (int bx = 0; bx < n / kDim; ++bx) {
            const glm::ivec3 first = kDim * glm::ivec3(bx, by, brick_z);
            bool any = false;
            for (int i = 0; i < VoxelGrid::kBrickVoxels; ++i) {
                const glm::ivec3 voxel = first + glm::ivec3(i & 7, i >> 3 & 7, i >> 6);
                const glm::vec3 p =
                    (glm::vec3(voxel) + 0.5f) / static_cast<float>(n) - glm::vec3(0.5f, 0.5f, 0);
                const float value = plume_density(noise, p);
                values[static_cast<std::size_t>(i)] = value;
                if (value == 0)
                    continue;
                any = true;
                ++layer.active;
                layer.max_value = std::max(layer.max_value, value);
                layer.min = glm::min(layer.min, voxel);
                layer.max = glm::max(layer.max, voxel);
            }
            if (!any)
                continue;
            layer.bricks.emplace_back(bx, by, brick_z);
            layer.values.insert(layer.values.end(), values.begin(), values.end());
        }
    return layer;
}

BoxSurface ground(float albedo)
{
    return {.min = {-60, -60, -1}, .max = {60, 60, 0}, .albedo = glm::vec3(albedo)};
}

}  // namespace

VoxelGrid make_plume(int n)
{
    assert(n >= VoxelGrid::kBrickDim && n % VoxelGrid::kBrickDim == 0);
    const NoiseTable noise;
    std::vector<BrickLayer> layers(static_cast<std::size_t>(n / VoxelGrid::kBrickDim));
    tbb::parallel_for(0, static_cast<int>(layers.size()), [&](int z) {
        layers[static_cast<std::size_t>(z)] = fill_layer(noise, n, z);
    });
    VoxelGrid grid;
    grid.name = "density";
    const double voxel = kPlumeHeight / n;
    grid.world_from_index =
        glm::scale(glm::translate(glm::dmat4(1.0), {-kPlumeHeight / 2, -kPlumeHeight / 2, 0}),
                   glm::dvec3(voxel));
    grid.index_min = glm::ivec3(n);
    grid.index_max = glm::ivec3(-1);
    std::size_t values = 0;
    for (const BrickLayer& layer : layers)
        values += layer.values.size();
    grid.values.reserve(values);
    for (BrickLayer& layer : layers) {
        grid.bricks.insert(grid.bricks.end(), layer.bricks.begin(), layer.bricks.end());
        grid.values.insert(grid.values.end(), layer.values.begin(), layer.values.end());
        grid.index_min = glm::min(grid.index_min, layer.min);
        grid.index_max = glm::max(grid.index_max, layer.max);
        grid.active_voxels += layer.active;
        grid.max_value = std::max(grid.max_value, layer.max_value);
        layer = {};  // a large grid is not held twice
    }
    return grid;
}

GridMedium plume_medium(std::shared_ptr<const VoxelGrid> density)
{
    GridMedium medium;
    medium.grid = "density";
    medium.density = std::move(density);
    medium.sigma_s_per_density = {7, 8.5, 11};
    medium.sigma_a_per_density = {0.7, 0.85, 1.1};
    medium.g = 0.3f;
    return medium;
}

Scene plume_scene(std::shared_ptr<const VoxelGrid> density)
{
    Scene scene;
    scene.camera = {.position = {0.8, -12.5, 2.4},
                    .look_at = {0, 0, 2.8},
                    .vfov_deg = 29,
                    .near = 0.1,
                    .far = 200};
    scene.world.radiance = {0.02, 0.03, 0.05};
    scene.lights = {SunLight{.direction_to_light = glm::normalize(glm::dvec3(-0.75, -0.15, 0.63)),
                             .irradiance = {12, 10.3, 8}}};
    scene.media = {plume_medium(std::move(density))};
    scene.surfaces = {
        SphereSurface{.center = {1.4, -1.2, 0.6}, .radius = 0.6, .albedo = {0.6, 0.55, 0.5}},
        ground(0.035f)};
    return scene;
}

void write_plume(const VoxelGrid& grid, const std::filesystem::path& file)
{
    HandmadeVdb made;
    made.world_from_index = grid.world_from_index;
    made.bricks.resize(grid.bricks.size());
    for (std::size_t i = 0; i < grid.bricks.size(); ++i) {
        made.bricks[i].brick = grid.bricks[i];
        std::copy_n(grid.values.begin() + static_cast<std::ptrdiff_t>(i) * VoxelGrid::kBrickVoxels,
                    VoxelGrid::kBrickVoxels, made.bricks[i].values.begin());
    }
    write::write_whole(file, handmade_vdb(made));
}

Scene fog_scene()
{
    Scene scene;
    scene.camera = {.position = {0, -11, 2.4}, .look_at = {0, 0, 1.9}, .near = 0.1, .far = 40};
    scene.lights = {PointLight{.position = {-1.3, 0.6, 2.9}, .radiant_intensity = {32, 29, 24}}};
    scene.media = {BoxMedium{.min = {-5, -5, -0.5},
                             .max = {5, 5, 5.5},
                             .profile = HomogeneousProfile{},
                             .sigma_s = glm::vec3(0.1f),
                             .sigma_a = glm::vec3(0.02f),
                             .g = 0.3f}};
    scene.surfaces = {
        SphereSurface{.center = {0.5, -0.2, 1.8}, .radius = 0.7, .albedo = {0.6, 0.2, 0.15}},
        BoxSurface{.min = {-0.1, 0.5, -1}, .max = {0.2, 0.8, 3.6}, .albedo = glm::vec3(0.5f)},
        ground(0.5f)};
    return scene;
}

Scene haze_scene()
{
    Scene scene;
    scene.camera = {.position = {0, -4, 1.7},
                    .look_at = {0.4, 40, 4.4},
                    .vfov_deg = 50,
                    .near = 0.1,
                    .far = 400};
    scene.lights = {SunLight{.direction_to_light = glm::normalize(glm::dvec3(-0.5, 0.55, 0.67)),
                             .irradiance = {12, 10.6, 8.6}}};
    scene.media = {BoxMedium{.min = {-60, -10, -0.5},
                             .max = {60, 190, 60},
                             .profile = ExpHeightProfile{.scale_height = 12, .z0 = 0},
                             .sigma_s = {0.016, 0.018, 0.021},
                             .sigma_a = glm::vec3(0.0015f),
                             .g = 0.6f}};
    scene.surfaces = {
        BoxSurface{.min = {-45, -8, -1}, .max = {45, 190, 0}, .albedo = {0.16, 0.15, 0.13}}};
    for (int house = 0; house < 5; ++house) {
        const double y = 12 + 26 * house, height = 8 + 3 * house;
        scene.surfaces.emplace_back(BoxSurface{
            .min = {-17, y, 0}, .max = {-6, y + 14, height}, .albedo = glm::vec3(0.45f)});
        scene.surfaces.emplace_back(BoxSurface{
            .min = {7, y + 8, 0}, .max = {17, y + 20, height - 2}, .albedo = glm::vec3(0.5f)});
    }
    return scene;
}

Scene noise_scene()
{
    Scene scene;
    scene.camera = {
        .position = {0, -14, 2.4}, .look_at = {0, 0, 2}, .vfov_deg = 32, .near = 0.1, .far = 60};
    scene.lights = {SunLight{.direction_to_light = glm::normalize(glm::dvec3(-1, -0.4, 1)),
                             .irradiance = {10, 9, 8}}};
    scene.media = {BoxMedium{.min = {-4, -3, 0.5},
                             .max = {4, 3, 3.5},
                             .profile = NoiseProfile{.feature_size = 1.5, .octaves = 4},
                             .sigma_s = glm::vec3(4.0f),
                             .sigma_a = glm::vec3(0.2f),
                             .g = 0.2f}};
    scene.surfaces = {ground(0.3f)};
    return scene;
}

Scene with_lights(Scene scene, int count)
{
    const glm::vec3 all(300, 290, 270);  // W/sr
    scene.lights.clear();
    for (int i = 0; i < count; ++i) {
        const double angle = glm::two_pi<double>() * i / count + 0.4;
        scene.lights.emplace_back(
            PointLight{.position = scene.camera.look_at +
                                   glm::dvec3(4 * std::cos(angle), 4 * std::sin(angle), 1.5),
                       .radiant_intensity = all / static_cast<float>(count)});
    }
    return scene;
}

}  // namespace fumarole::study
