// Which surfaces can stand between a light and the media.

#include <gtest/gtest.h>

#include "light/shadow_views.h"

namespace fumarole::test {
namespace {

const Bounds kMedia{{-1, -1, 1}, {1, 1, 2}};

Bounds box(glm::dvec3 centre, glm::dvec3 half)
{
    return {centre - half, centre + half};
}

TEST(CanShade, SurfacesOnASunsWayAlone)
{
    const SunLight high{.direction_to_light = {0.5, 0, 1}, .irradiance = glm::vec3(1)};
    const auto shades = [&](const Bounds& surface) {
        return light::can_shade(position_of(high), surface, kMedia);
    };
    EXPECT_FALSE(shades({{-60, -60, -1}, {60, 60, 0}})) << "a ground";
    EXPECT_FALSE(shades({{-60, -60, -1}, {60, 60, 1}})) << "that the media stand on";
    EXPECT_TRUE(shades({{-60, -60, -1}, {60, 60, 1.1}})) << "that they are in";
    EXPECT_TRUE(shades(box({5, 0, 11.5}, glm::dvec3(0.1)))) << "far up";
    EXPECT_FALSE(shades(box({0, 0, 11.5}, glm::dvec3(0.1)))) << "overhead, and beside the light";
    EXPECT_FALSE(shades(box({5, 2, 11.5}, glm::dvec3(0.1)))) << "aside";
    EXPECT_FALSE(shades(box({-5, 0, 1.5}, glm::dvec3(0.1)))) << "behind";
    EXPECT_TRUE(shades(box({0, 0, 1.5}, glm::dvec3(0.1)))) << "within";

    const SunLight level{.direction_to_light = {0, -1, 0}, .irradiance = glm::vec3(1)};
    EXPECT_TRUE(light::can_shade(position_of(level), box({0, -50, 1.5}, glm::dvec3(0.1)), kMedia));
    EXPECT_FALSE(light::can_shade(position_of(level), box({0, 50, 1.5}, glm::dvec3(0.1)), kMedia));
    EXPECT_FALSE(light::can_shade(position_of(level), box({0, -50, 0.5}, glm::dvec3(0.1)), kMedia));
}

TEST(CanShade, SurfacesBetweenALampAndTheMediaAlone)
{
    const glm::dvec3 position(0, 0, 5);
    for (const Light& lamp :
         {Light(PointLight{.position = position}), Light(SpotLight{.position = position})}) {
        const auto shades = [&](const Bounds& surface) {
            return light::can_shade(position_of(lamp), surface, kMedia);
        };
        EXPECT_FALSE(shades({{-60, -60, -1}, {60, 60, 0}}));
        EXPECT_TRUE(shades(box({0, 0, 3}, glm::dvec3(0.1))));
        EXPECT_FALSE(shades(box({0, 0, 6}, glm::dvec3(0.1))));
        EXPECT_FALSE(shades(box({3, 0, 3}, glm::dvec3(0.1))));
    }
}

}  // namespace
}  // namespace fumarole::test
