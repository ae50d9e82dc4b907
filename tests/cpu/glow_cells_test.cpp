#include "medium/glow_cells.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace fumarole::medium {
namespace {

/// What gets out of a ball of optical depth `tau` from its middle to its rim that glows evenly
/// (Case, de Hoffmann and Placzek 1953, sec. 10.1).
double escapes_from_ball(double tau)
{
    return 3 / (8 * tau * tau * tau) * (2 * tau * tau - 1 + (1 + 2 * tau) * std::exp(-2 * tau));
}

TEST(GlowCells, AsMuchGetsOutOfABallAsTheClosedFormHasIt)
{
    const glm::dvec3 middle(3, -2, 5);
    const auto ball = [&](glm::dvec3 place) { return glm::length(place - middle) < 1 ? 1.0 : 0.0; };
    for (const double tau : {0.1, 0.5, 1.0, 2.0, 4.0}) {
        const glm::dvec3 sigma_t(tau, 0.5 * tau, 0);
        const GlowCells cells = glow_cells(
            {middle - 1.0, middle + 1.0}, [&](glm::dvec3 at) { return glm::dvec3(ball(at)); },
            [&](glm::dvec3 at) { return sigma_t * ball(at); });
        const glm::dvec3 found = cells.escapes(std::array{middle});
        EXPECT_NEAR(found.x / (escapes_from_ball(tau) * std::exp(tau)), 1, 0.03) << tau;
        EXPECT_NEAR(found.y / (escapes_from_ball(tau / 2) * std::exp(tau / 2)), 1, 0.02) << tau;
        EXPECT_EQ(found.z, 1) << tau;
    }
}

// A slab of soot beside what glows hides half of it: from a place amid the glow as much as from
// all of it, and from one behind the slab as much as is hidden there.
TEST(GlowCells, PlacesAreSeenThroughWhatStandsBesideThem)
{
    const Bounds box{glm::dvec3(0), {4, 1, 1}};
    const auto soot = [](glm::dvec3 at) { return glm::dvec3(at.x > 2 ? 3.0 : 0.0); };
    const auto glow = [](glm::dvec3 at) { return glm::dvec3(at.x < 1 ? 1.0 : 0.0); };
    const GlowCells cells = glow_cells(box, glow, soot);
    EXPECT_NEAR(cells.escapes(std::array{glm::dvec3(0.5, 0.5, 0.5)}).x, 1, 0.02);
    EXPECT_GT(cells.escapes(std::array{glm::dvec3(3, 0.5, 0.5)}).x, 1.5);
    EXPECT_EQ(cells.count, glm::ivec3(16, 4, 4));
}

TEST(GlowCells, WithoutAnythingThatDimsAllGetsOut)
{
    EXPECT_EQ(GlowCells().escapes(std::array{glm::dvec3(0)}), glm::dvec3(1));
    const GlowCells flat = glow_cells(
        {glm::dvec3(0), {1, 1, 0}}, [](glm::dvec3) { return glm::dvec3(1); },
        [](glm::dvec3) { return glm::dvec3(1); });
    const glm::dvec3 from_a_plane = flat.escapes(std::array{glm::dvec3(0.5, 0.5, 0)});
    EXPECT_EQ(from_a_plane, glm::dvec3(1)) << "a box without a volume glows nothing";
}

}  // namespace
}  // namespace fumarole::medium
