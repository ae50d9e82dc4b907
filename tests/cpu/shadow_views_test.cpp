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

surface::SurfaceSet::Instance solid(const Bounds& bounds, bool is_box)
{
    surface::SurfaceSet::Instance instance;
    instance.bounds = bounds;
    instance.is_box = is_box;
    return instance;
}

TEST(OutsideOfBoxes, IsWhatAGroundLeavesOfTheMedia)
{
    const auto ground = [](double height) {
        return std::vector{solid({{-60, -60, -1}, {60, 60, height}}, true)};
    };
    EXPECT_EQ(light::outside_of_boxes(kMedia, ground(0.5)).min.z, 1) << "below them";
    EXPECT_EQ(light::outside_of_boxes(kMedia, ground(1.25)).min.z, 1.25);
    EXPECT_EQ(light::outside_of_boxes(kMedia, ground(1.25)).max.z, 2);
    EXPECT_TRUE(light::outside_of_boxes(kMedia, ground(3)).empty()) << "buried";
    const std::vector wall{solid({{0.5, -60, -60}, {60, 60, 60}}, true)};
    EXPECT_EQ(light::outside_of_boxes(kMedia, wall).max.x, 0.5);
    const std::vector post{solid({{-0.1, -0.1, -1}, {0.1, 0.1, 3}}, true)};
    EXPECT_EQ(light::outside_of_boxes(kMedia, post).min, kMedia.min) << "media go around it";
    const std::vector ball{solid({{-60, -60, -119}, {60, 60, 1.25}}, false)};
    EXPECT_EQ(light::outside_of_boxes(kMedia, ball).min.z, 1) << "it does not fill its bounds";
}

TEST(CanShadeSurfaces, OneBeforeAnotherAndAMeshBeforeItself)
{
    const SunLight high{.direction_to_light = {0.5, 0, 1}, .irradiance = glm::vec3(1)};
    const std::vector suns{position_of(high)};
    const auto ground = solid({{-60, -60, -1}, {60, 60, 0}}, true);
    const auto ball = solid(box({0, 0, 1}, glm::dvec3(1)), false);
    const auto behind_edge = solid(box({-80, 0, -40}, glm::dvec3(1)), false);
    auto mesh = ground;
    mesh.is_box = mesh.closed = false;
    EXPECT_FALSE(light::can_shade_surfaces(suns, std::vector{ground}));
    EXPECT_FALSE(light::can_shade_surfaces(suns, std::vector{ball}));
    EXPECT_TRUE(light::can_shade_surfaces(suns, std::vector{ground, ball}));
    EXPECT_TRUE(light::can_shade_surfaces(suns, std::vector{ground, behind_edge}));
    EXPECT_TRUE(light::can_shade_surfaces(suns, std::vector{mesh}));
    EXPECT_FALSE(light::can_shade_surfaces({}, std::vector{ground, ball})) << "no light";
}

}  // namespace
}  // namespace fumarole::test
