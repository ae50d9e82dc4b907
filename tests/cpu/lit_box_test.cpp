// What of the box around media the nodes lie in that surfaces are lit by.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "light/lit_box.h"

namespace fumarole::light {
namespace {

constexpr double kSpacing = 0.2;  // metres
const Bounds kMedia{{-2, -2, 0.1}, {2, 2, 6}};
const Bounds kAround{{-4, -4, -2.9}, {4, 4, 9}};

surface::SurfaceSet::Instance box(glm::dvec3 low, glm::dvec3 high)
{
    surface::SurfaceSet::Instance instance;
    instance.bounds = {low, high};
    instance.is_box = true;
    return instance;
}

Bounds lit(const std::vector<surface::SurfaceSet::Instance>& surfaces)
{
    return lit_box(kAround, kMedia, surfaces, kSpacing);
}

TEST(LitBox, ABoxIsAloneWhereNothingElseStandsAround)
{
    std::vector<surface::SurfaceSet::Instance> surfaces{box({-50, -50, -1}, {50, 50, 0})};
    EXPECT_EQ(lone_box(kAround, surfaces), &surfaces.front());
    surfaces.push_back(box({30, 30, 0}, {32, 32, 2}));  // beyond
    EXPECT_EQ(lone_box(kAround, surfaces), &surfaces.front());
    surfaces.push_back(box({3, 3, 0}, {5, 5, 2}));
    EXPECT_EQ(lone_box(kAround, surfaces), nullptr);
    surfaces = {box({-1, -1, 0}, {1, 1, 2})};
    surfaces.front().is_box = false;
    EXPECT_EQ(lone_box(kAround, surfaces), nullptr);
    EXPECT_EQ(lone_box(kAround, {}), nullptr);
}

TEST(LitBox, OverAGroundNobodyAsksWhatIsAboveTheMedia)
{
    const surface::SurfaceSet::Instance ground = box({-50, -50, -1}, {50, 50, 0});
    const Bounds found = lit({ground});
    EXPECT_TRUE(kAround.contains(found));
    EXPECT_TRUE(found.contains(kMedia));
    for (const int axis : {0, 1}) {  // as far as before along it
        EXPECT_EQ(found.min[axis], kAround.min[axis]);
        EXPECT_EQ(found.max[axis], kAround.max[axis]);
    }
    EXPECT_NEAR(found.max.z, kMedia.max.z + 2 * kSpacing, 1e-12);
    // Its top is clear of where light fades.
    EXPECT_GT(0 - found.min.z, 0.15 * (found.max.z - found.min.z));
}

TEST(LitBox, ThinGroundsAndWallsAreClearOfWhereLightFades)
{
    const std::vector<Bounds> grounds{
        {{-50, -50, -0.01}, {50, 50, 0}},  // a sheet
        {{-50, 2.5, -50}, {50, 2.6, 50}},  // a wall behind
        {{-50, -50, 6.5}, {50, 50, 6.6}},  // a ceiling
        {{-0.5, -0.5, 2}, {0.5, 0.5, 3}},  // amid the media
        {{2.5, -0.5, 2}, {3, 0.5, 3}},     // beside them
    };
    for (const Bounds& ground : grounds) {
        const Bounds found = lit({box(ground.min, ground.max)});
        EXPECT_TRUE(kAround.contains(found) && found.contains(kMedia));
        const glm::dvec3 fades = 0.15 * (found.max - found.min);
        for (int axis = 0; axis < 3; ++axis) {
            const double low = std::max(ground.min[axis], kAround.min[axis]),
                         high = std::min(ground.max[axis], kAround.max[axis]);
            EXPECT_TRUE(found.min[axis] == kAround.min[axis] ||
                        low - found.min[axis] >= fades[axis])
                << axis << ", z " << ground.min.z;
            EXPECT_TRUE(found.max[axis] == kAround.max[axis] ||
                        found.max[axis] - high >= fades[axis])
                << axis << ", z " << ground.min.z;
        }
    }
}

TEST(LitBox, WhatHidesTheSkyFromEachOtherHasAllNodes)
{
    const auto is_all = [](const Bounds& found) {
        return found.min == kAround.min && found.max == kAround.max;
    };
    surface::SurfaceSet::Instance ball = box({-1, 1, 0}, {1, 3, 2});
    ball.is_box = false;
    const surface::SurfaceSet::Instance ground = box({-50, -50, -1}, {50, 50, 0});
    EXPECT_TRUE(is_all(lit({ball}))) << "a mesh may hide it from itself";
    EXPECT_TRUE(is_all(lit({ground, ball})));
    const surface::SurfaceSet::Instance below = box({-50, -50, -21}, {50, 50, -20});
    EXPECT_TRUE(is_all(lit({below}))) << "it reaches none";
    EXPECT_EQ(lit({below, ground}).max, lit({ground}).max) << "what lies far off changes nothing";
}

}  // namespace
}  // namespace fumarole::light
