#include "light/sky_seen.h"

#include <algorithm>
#include <fmt/format.h>

#include "light/surface_rays.h"

namespace fumarole::light {

namespace {

/// A ball of no mesh is drawn with as many, more or less.
constexpr double kTrianglesOfBall = 500, kTrianglesOfBox = 12;

struct Size {
    double shapes = 0;     ///< that a ray is tested against
    double triangles = 0;  ///< that are drawn
};

Size size_of_surfaces(const std::vector<Surface>& surfaces)
{
    Size size;
    for (const Surface& surface : surfaces) {
        const auto* mesh = std::get_if<MeshSurface>(&surface);
        const double own = mesh == nullptr || mesh->mesh == nullptr
                               ? 0.0
                               : static_cast<double>(mesh->mesh->triangles.size()) / 3;
        size.shapes += std::max(own, 1.0);
        size.triangles += mesh != nullptr                               ? own
                          : std::holds_alternative<BoxSurface>(surface) ? kTrianglesOfBox
                                                                        : kTrianglesOfBall;
    }
    return size;
}

}  // namespace

SkySeen sky_seen(const std::vector<Surface>& surfaces, const Bounds& media)
{
    if (surfaces.empty() || media.empty())
        return {};
    // A ground leaves half of the sphere free, and a wall on it a quarter.
    constexpr double kLittle = 0.15;
    /// Of the places that are not in a solid.
    constexpr double kEnoughPlaces = 0.125;
    // As many tests of a ray and a triangle take a twentieth of a second; a CPU draws as many
    // triangles in some seconds.
    constexpr double kTests = 1e7, kMostTriangles = 1e4;
    constexpr int kFewestPlaces = 8, kMostPlaces = 48, kLooks = 48;
    const Size size = size_of_surfaces(surfaces);
    if (size.triangles > kMostTriangles)
        return {false, fmt::format("surfaces have {:.2g} triangles, more than {:.2g}",
                                   size.triangles, kMostTriangles)};
    const int most =
        std::clamp(static_cast<int>(kTests / (size.shapes * kLooks)), kFewestPlaces, kMostPlaces);
    const SurfaceRays rays(surfaces);
    const std::vector<glm::dvec3> looks = even_directions(kLooks);
    int places = 0, under_gaps = 0;
    for (int i = 0; i < most; ++i) {
        const glm::dvec3 place = spread_place(media, i);
        if (rays.is_near(place, 0))
            continue;
        ++places;
        const auto seen = std::count_if(looks.begin(), looks.end(), [&](const glm::dvec3& look) {
            return !rays.first(place, look);
        });
        under_gaps += seen > 0 && static_cast<double>(seen) <= kLittle * kLooks ? 1 : 0;
    }
    if (places == 0)
        return {};
    return {under_gaps >= kEnoughPlaces * places,
            fmt::format("{:.0f} % of places amid the media see a little of the sky",
                        100.0 * under_gaps / places)};
}

}  // namespace fumarole::light
