#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace fumarole::light {

/// The least and the largest depth in squares of a shadow map's texels: of 8 along an edge, of 16,
/// and so on to all of it. A rectangle of any size takes up to nine lookups. After the min-max
/// mipmaps of Chen, Baran, Durand and Jarosz, "Real-Time Volumetric Shadows using 1D Min-Max
/// Mipmaps", I3D 2011, in two dimensions.
class DepthPyramid {
public:
    struct Extent {
        float least, most;
    };

    /// @param texels size * size depths, 0..1, row by row
    DepthPyramid(std::span<const float> texels, int size);

    /// Of all texels that a bilinear lookup at uv, 0..1, from `low` to `high` reads, and of their
    /// neighbourhood. Beyond the map its edge goes on.
    [[nodiscard]] Extent over(glm::dvec2 low, glm::dvec2 high) const;

private:
    static constexpr int kBlock = 8;
    struct Level {
        int edge = 0;  ///< blocks
        std::vector<Extent> blocks;
    };

    int size_;
    std::vector<Level> levels_;
};

}  // namespace fumarole::light
