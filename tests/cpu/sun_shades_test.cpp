#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "pass/sun_shades.h"

namespace fumarole::pass {
namespace {

constexpr int kSize = 200;  // no power of two, no multiple of a block

/// A shadow map of a ground far off, boxes of many sizes before it, and lit sky beside it.
std::vector<float> city(std::mt19937& random)
{
    std::vector<float> texels(std::size_t{kSize} * kSize, 0.8f);
    std::uniform_int_distribution<int> place(0, kSize - 1), edge(1, 30);
    std::uniform_real_distribution<float> depth(0.1f, 0.7f);
    for (int box = 0; box < 40; ++box) {
        const int x0 = place(random), y0 = place(random);
        const int x1 = std::min(kSize, x0 + edge(random)), y1 = std::min(kSize, y0 + edge(random));
        const float at = box % 5 == 0 ? 1.0f : depth(random);  // 1: nothing
        for (int y = y0; y < y1; ++y)
            std::fill_n(texels.begin() + y * kSize + x0, x1 - x0, at);
    }
    return texels;
}

/// What a bilinear comparison at uv reads.
std::pair<float, float> tapped(const std::vector<float>& texels, glm::dvec2 uv)
{
    const glm::ivec2 first(glm::floor(uv * double{kSize} - 0.5));
    std::pair<float, float> ends{2.0f, -1.0f};
    for (int i = 0; i < 4; ++i) {
        const glm::ivec2 at = glm::clamp(first + glm::ivec2(i & 1, i >> 1), 0, kSize - 1);
        const float depth = texels[static_cast<std::size_t>(at.y * kSize + at.x)];
        ends = {std::min(ends.first, depth), std::max(ends.second, depth)};
    }
    return ends;
}

TEST(DepthPyramid, HoldsWhatLookupsInARectangleRead)
{
    std::mt19937 random(3);
    const std::vector<float> texels = city(random);
    const light::DepthPyramid pyramid(texels, kSize);
    std::uniform_real_distribution<double> unit(0, 1), past(-0.1, 1.1);
    int tight = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec2 a(past(random), past(random));
        const glm::dvec2 b = a + 0.4 * unit(random) * glm::dvec2(unit(random), unit(random));
        const auto [least, most] = pyramid.over(a, b);
        for (int k = 0; k < 20; ++k) {
            const glm::dvec2 uv = glm::mix(a, b, glm::dvec2(unit(random), unit(random)));
            const auto [low, high] = tapped(texels, uv);
            ASSERT_LE(least, low);
            ASSERT_GE(most, high);
        }
        tight += least == most ? 1 : 0;
    }
    EXPECT_GT(tight, 20) << "rectangles that lie on the bare ground are seen to";
    const auto all = pyramid.over({0, 0}, {1, 1});
    EXPECT_EQ(all.least, *std::min_element(texels.begin(), texels.end()));
    EXPECT_EQ(all.most, *std::max_element(texels.begin(), texels.end()));
}

TEST(SunShade, SaysLitAndDarkOnlyWhereAllPointsAre)
{
    std::mt19937 random(5);
    const std::vector<float> texels = city(random);
    const light::LightAxes axes(glm::normalize(glm::dvec3(0.4, -0.5, 0.8)));
    Bounds covered, casters;
    covered.add(glm::dvec3(-40, -40, -40));
    covered.add(glm::dvec3(40, 40, 40));
    casters.add(glm::dvec3(-60, -60, -60));
    casters.add(glm::dvec3(60, 60, 60));
    const light::View view = light::parallel_view(axes, covered, casters, kSize);
    const light::SunShadow shadow{view, light::DepthPyramid(texels, kSize)};
    const SunShade shade(shadow);

    std::uniform_real_distribution<double> unit(0, 1), both(-1, 1);
    int found[3] = {};
    for (int i = 0; i < 4000; ++i) {
        const bool perspective = i % 2 == 0;
        const glm::dvec3 eye(20 * both(random), 20 * both(random), 20 * both(random));
        CameraRays rays;
        rays.direction = glm::normalize(glm::dvec3(both(random), both(random), both(random)));
        const glm::dvec3 dx(0.3 * both(random), 0.3 * both(random), 0.3 * both(random)),
            dy(0.3 * both(random), 0.3 * both(random), 0.3 * both(random));
        (perspective ? rays.direction_dx : rays.origin_dx) = dx;
        (perspective ? rays.direction_dy : rays.origin_dy) = dy;
        const CameraRays seen = shade.seen(rays, eye);
        const glm::dvec2 ndc(both(random), both(random)), reach(0.05 * unit(random));
        const double near = 30 * unit(random);
        const glm::dvec2 range(near, near + 8 * unit(random));
        const Shade said = shade.over(seen, ndc, reach, range);
        ++found[static_cast<int>(said)];
        if (said == Shade::mixed)
            continue;
        for (int k = 0; k < 20; ++k) {
            const glm::dvec2 at = ndc + reach * glm::dvec2(both(random), both(random));
            const double z = glm::mix(range.x, range.y, unit(random));
            const glm::dvec3 p =
                eye + rays.origin + rays.origin_dx * at.x + rays.origin_dy * at.y +
                z * (rays.direction + rays.direction_dx * at.x + rays.direction_dy * at.y);
            // As the GPU looks it up.
            const glm::dvec2 uv = glm::dvec2(view.clip_from_world * glm::dvec4(p, 1.0)) * 0.5 + 0.5;
            const double depth =
                std::clamp(glm::dot(p - view.origin, view.axis) / view.range, 0.0, 1.0);
            const auto [low, high] = tapped(texels, uv);
            if (said == Shade::lit)
                ASSERT_LE(depth, static_cast<double>(low));
            else
                ASSERT_GT(depth, static_cast<double>(high));
        }
    }
    for (const int n : found)
        EXPECT_GT(n, 40) << "each of the three is looked at";
}

}  // namespace
}  // namespace fumarole::pass
