#pragma once

#include <cstdint>
#include <glm/glm.hpp>

// What the scene format says of a noise profile's gradients: those of the lattice are hashed from
// integers alone, so that all machines and both processors have the same.

namespace fumarole {

/// x of PCG3D, of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
inline std::uint32_t noise_hash(std::uint32_t x, std::uint32_t y, std::uint32_t z)
{
    x = x * 1664525u + 1013904223u;
    y = y * 1664525u + 1013904223u;
    z = z * 1664525u + 1013904223u;
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16u;
    y ^= y >> 16u;
    z ^= z >> 16u;
    x += y * z;
    return x;
}

/// At a point of the lattice: one of the 12 directions to a cube's edges, of length sqrt(2).
inline glm::vec3 noise_gradient(glm::uvec3 point, std::uint32_t seed)
{
    const std::uint32_t h = noise_hash(point.x + seed, point.y, point.z) >> 16u;
    const float first = (h & 0x1000u) != 0 ? 1.0f : -1.0f;
    const float second = (h & 0x2000u) != 0 ? 1.0f : -1.0f;
    switch (h % 3u) {  // the coordinate that it leaves out
    case 0:
        return {0.0f, first, second};
    case 1:
        return {first, 0.0f, second};
    default:
        return {first, second, 0.0f};
    }
}

/// The weight of the farther of two neighbours, of Perlin 2002, "Improving Noise". f: 0..1.
template <class T> T noise_fade(T f)
{
    return f * f * f * (f * (f * T(6) - T(15)) + T(10));
}

/// Of octave i: each has its own, so octaves of an even lacunarity don't line up.
inline std::uint32_t noise_octave_seed(std::uint32_t seed, int octave)
{
    return seed + 0x9e3779b9u * static_cast<std::uint32_t>(octave);
}

}  // namespace fumarole
