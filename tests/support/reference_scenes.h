#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>

#include <fumarole/scene.h>

// Small scenes for the reference's tests.

namespace fumarole::study {

/// One pixel that looks along +y from the origin, at nothing.
inline Scene looking()
{
    Scene scene;
    scene.resolution = {1, 1};
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, 1, 0};
    scene.camera.near = 0.001;
    scene.camera.far = 1e6;
    scene.world.radiance = glm::vec3(0);
    return scene;
}

inline BoxMedium fog(glm::dvec3 min, glm::dvec3 max, glm::vec3 sigma_s, glm::vec3 sigma_a)
{
    BoxMedium box;
    box.min = min;
    box.max = max;
    box.profile = HomogeneousProfile{};
    box.sigma_s = sigma_s;
    box.sigma_a = sigma_a;
    return box;
}

/// Voxels of 1 m: density(i, j, k) over 0..n-1.
template <class F> GridMedium grid_medium(int n, const F& density, double voxel = 1)
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "density";
    grid->world_from_index = glm::dmat4(voxel);
    grid->world_from_index[3][3] = 1;
    grid->index_min = glm::ivec3(0);
    grid->index_max = glm::ivec3(n - 1);
    const int bricks = (n + 7) / 8;
    for (int bz = 0; bz < bricks; ++bz)
        for (int by = 0; by < bricks; ++by)
            for (int bx = 0; bx < bricks; ++bx) {
                grid->bricks.emplace_back(bx, by, bz);
                for (int z = 0; z < 8; ++z)
                    for (int y = 0; y < 8; ++y)
                        for (int x = 0; x < 8; ++x) {
                            const glm::ivec3 at = glm::ivec3(bx, by, bz) * 8 + glm::ivec3(x, y, z);
                            const bool in = glm::all(glm::lessThan(at, glm::ivec3(n)));
                            const float value = in ? static_cast<float>(density(at)) : 0.0f;
                            grid->values.push_back(value);
                            grid->max_value = std::max(grid->max_value, value);
                        }
            }
    GridMedium medium;
    medium.density = grid;
    return medium;
}

inline double smooth_blob(glm::ivec3 at)
{
    const glm::dvec3 d = glm::dvec3(at) - 5.5;
    return std::max(0.0, 1 - glm::dot(d, d) / 36) * (1 + 0.5 * std::sin(2.1 * at.x + at.y));
}

/// A blob of smoke on a table beside a ball, under a sun, a point light and a coloured world.
inline Scene blob_scene()
{
    Scene scene = looking();
    scene.resolution = {12, 8};
    scene.camera.position = {2.75, -12, 4};
    scene.camera.look_at = {2.75, 2.75, 2.5};
    scene.camera.vfov_deg = 35;
    scene.world.radiance = {0.3f, 0.2f, 0.5f};
    GridMedium smoke = grid_medium(12, smooth_blob, 0.5);
    smoke.sigma_s_per_density = {1.0f, 0.7f, 0.4f};
    smoke.sigma_a_per_density = glm::vec3(0.2f);
    smoke.g = 0.35f;
    scene.media.emplace_back(smoke);
    scene.surfaces.emplace_back(SphereSurface{{4.5, 0.5, 1}, 1.2, glm::vec3(0.5f)});
    scene.surfaces.emplace_back(BoxSurface{{-10, -10, -2}, {15, 15, -0.5}, glm::vec3(0.4f)});
    scene.lights.emplace_back(SunLight{glm::normalize(glm::dvec3(1, -1, 2)), {2, 2, 1}});
    scene.lights.emplace_back(PointLight{{1, 1, 6}, {20, 10, 10}});
    return scene;
}

/// A dark sky with one bright texel, somewhat above the horizon.
inline World lamp_world()
{
    auto map = std::make_shared<Environment>();
    map->width = 32;
    map->height = 16;
    map->radiance.assign(32 * 16, glm::vec3(0.05f, 0.1f, 0.2f));
    map->radiance[5 * 32 + 20] = {60, 50, 40};
    World world;
    world.environment = map;
    return world;
}

}  // namespace fumarole::study
