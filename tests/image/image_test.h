#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <string_view>

#include "study/stability_bench.h"
#include "support/gl_test.h"
#include "support/image_compare.h"
#include <fumarole/write/image_writer.h>

// What the pictures are held against, worked out in double and without the library's own code:
// the rays of a camera, boxes, integrals, and what a bilinear resolve makes of exact samples.

namespace fumarole::test {

/// The ray of a point of the picture: p = origin + direction * t, t in metres along the ray.
struct PixelRay {
    glm::dvec3 origin{0};
    glm::dvec3 direction{0};  ///< unit length
    double length_per_z = 1;  ///< metres of ray per metre of view depth
};

/// Where a ray is inside of something; empty if begin >= end.
struct Segment {
    double begin = 0, end = 0;  ///< metres along the ray
    [[nodiscard]] double length() const { return end > begin ? end - begin : 0; }
};

/// Something that varies over a picture; `at` is in pixels from its top left corner, so pixel (x,
/// y) is at (x + 0.5, y + 0.5).
using PictureField = std::function<glm::dvec3(glm::dvec2 at)>;

class ImageTest : public GlTest {
protected:
    /// 64 midpoint steps to their end, no jitter, 32-bit layer, light scattered once, as closed
    /// forms have it: what is left is the method.
    static Settings plain_settings(int resolution = 1);

    /// The same for froxels of a pixel: columns are the picture's rays, so what holds for the march
    /// at full resolution holds for them.
    static Settings plain_froxels(int tile = 1);
    /// Both, for what holds in both modes.
    static std::vector<Settings> plain_siblings() { return {plain_settings(), plain_froxels()}; }
    /// Steps of the march, slices of the froxels.
    static void set_steps(Settings& settings, int steps)
    {
        settings.steps = steps;
        settings.slices = steps;
    }

    static PixelRay ray_at(const Scene& scene, glm::dvec2 at);
    static PixelRay ray_of(const Scene& scene, int x, int y)
    {
        return ray_at(scene, {x + 0.5, y + 0.5});
    }

    static Image picture_of(const Still& still, const std::vector<float>& rgb);
    /// The field at each pixel's centre.
    static Image ideal(const Scene& scene, const PictureField& field);
    /// The field at each layer texel's centre, brought to full size as a 2x2 bilinear resolve
    /// without depth edges does: texels past the picture's edge repeat the last.
    static Image resolved(const Scene& scene, int resolution, const PictureField& field);

    static double max_difference(const Image& a, const Image& b);
    static double rms_difference(const Image& a, const Image& b);

    /// Keeps a measured number in the test's XML; printed too if FUM_TEST_FIGURES is set.
    static void figure(std::string_view name, double value);
};

/// Where the ray is inside a box, from `near` metres on.
Segment box_segment(const PixelRay& ray, glm::dvec3 min, glm::dvec3 max, double near = 0);

/// Gauss-Legendre of 5 points on each of n panels.
double integrate(double begin, double end, int panels, const std::function<double(double)>& f);

/// [1/sr]; cos_theta = dot(-wi, wo).
double henyey_greenstein(double cos_theta, double g);

using study::make_grid;

/// A soft lump, denser on one side, in 2 x 2 x 2 bricks.
std::shared_ptr<VoxelGrid> lump(const glm::dmat4& world_from_index);

/// Integral of a grid's trilinear field along a segment of a ray [m * density].
double grid_column(const VoxelLookup& grid, const glm::dmat4& index_from_world, glm::dvec3 p,
                   glm::dvec3 direction, Segment segment, int panels);

}  // namespace fumarole::test
