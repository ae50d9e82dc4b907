// Where it is told how much of a gap a node sees: under a roof that has gaps, and nowhere else.
#include "light/sky_seen.h"

#include <gtest/gtest.h>

namespace fumarole::test {
namespace {

using light::sky_seen;

BoxSurface box(glm::dvec3 min, glm::dvec3 max)
{
    BoxSurface one;
    one.min = min;
    one.max = max;
    return one;
}

/// Walls on a ground, and a roof of `slabs` with gaps of this width between them; none: no roof.
std::vector<Surface> hall(int slabs, double gap)
{
    std::vector<Surface> all{box({-300, -300, -2}, {300, 300, 0}),
                             box({-6.2, -4.2, 0}, {-6, 4.2, 4}), box({6, -4.2, 0}, {6.2, 4.2, 4}),
                             box({-6, 4, 0}, {6, 4.2, 4}), box({-6, -4.2, 0}, {6, -4, 4})};
    const double pitch = slabs > 0 ? 12.4 / slabs : 0;
    for (int i = 0; i < slabs; ++i)
        all.emplace_back(box({-6.2 + i * pitch + (i > 0 ? gap / 2 : 0), -4.2, 4},
                             {-6.2 + (i + 1) * pitch - (i + 1 < slabs ? gap / 2 : 0), 4.2, 4.2}));
    return all;
}

Bounds haze()
{
    Bounds bounds;
    bounds.add({-9, -7, 0});
    bounds.add({9, 7, 6});
    return bounds;
}

TEST(SkySeen, InPartsUnderARoofWithGaps)
{
    EXPECT_TRUE(sky_seen(hall(6, 0.4), haze()).in_parts);
    EXPECT_FALSE(sky_seen(hall(6, 0.4), haze()).why.empty());
}

TEST(SkySeen, NotInACourtNorInAClosedRoomNorOnAPlain)
{
    EXPECT_FALSE(sky_seen(hall(0, 0), haze()).in_parts) << "a court";
    EXPECT_FALSE(sky_seen(hall(1, 0), haze()).in_parts) << "a closed room";
    EXPECT_FALSE(sky_seen({box({-300, -300, -2}, {300, 300, 0})}, haze()).in_parts) << "a plain";
    EXPECT_FALSE(sky_seen({}, haze()).in_parts);
    EXPECT_FALSE(sky_seen(hall(6, 0.4), Bounds()).in_parts) << "no media";
}

TEST(SkySeen, NotOfSurfacesThatWouldTakeLongToDraw)
{
    auto mesh = std::make_shared<Mesh>();
    mesh->positions = {{-6, -4, 4}, {6, -4, 4}, {6, 4, 4}};
    for (int i = 0; i < 11000; ++i)
        mesh->triangles.insert(mesh->triangles.end(), {0u, 1u, 2u});
    MeshSurface many;
    many.mesh = mesh;
    std::vector<Surface> surfaces = hall(6, 0.4);
    surfaces.emplace_back(many);
    EXPECT_FALSE(sky_seen(surfaces, haze()).in_parts);
    EXPECT_NE(sky_seen(surfaces, haze()).why.find("triangles"), std::string::npos);
}

}  // namespace
}  // namespace fumarole::test
