#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fumarole/scene.h>

// Scenes that a benchmark makes itself, the same on every machine.

namespace fumarole::study {

/// A plume of smoke 6 m tall in a grid of n^3 voxels: the same smoke, however finely it is cut.
/// @param n voxels along an edge, a multiple of 8
VoxelGrid make_plume(int n);

/// That smoke's medium and the scene that shows it: a sun, a sky, a ball, the ground.
GridMedium plume_medium(std::shared_ptr<const VoxelGrid> density);
Scene plume_scene(std::shared_ptr<const VoxelGrid> density);

/// Writes a grid whose bricks lie at indices >= 0 as a .vdb. @throws Error naming the file.
void write_plume(const VoxelGrid& grid, const std::filesystem::path& file);

/// Uniform fog with a point light in it; a hazy street in the sun; clouds of noise.
Scene fog_scene();
Scene haze_scene();
Scene noise_scene();

/// The scene with `count` point lights in a ring about it instead of its own, of the same power
/// together however many they are.
Scene with_lights(Scene scene, int count);

}  // namespace fumarole::study
