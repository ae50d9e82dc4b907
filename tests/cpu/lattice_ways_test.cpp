// The directions of the volumes of light against integrals over the sphere in closed form.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "light/lattice_ways.h"

namespace fumarole::test {
namespace {

/// Of x^a y^b z^c over the sphere.
double moment(int a, int b, int c)
{
    if (a % 2 != 0 || b % 2 != 0 || c % 2 != 0)
        return 0;
    const auto half = [](int n) { return std::tgamma((n + 1) / 2.0); };
    return 2 * half(a) * half(b) * half(c) / std::tgamma((a + b + c + 3) / 2.0);
}

double sum(const std::vector<light::LatticeWay>& ways, int a, int b, int c)
{
    double all = 0;
    for (const light::LatticeWay& way : ways) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(way.step));
        all += way.solid_angle * std::pow(d.x, a) * std::pow(d.y, b) * std::pow(d.z, c);
    }
    return all;
}

TEST(LatticeWays, SumPolynomialsExactly)
{
    const auto expect_to = [](int count, int degree) {
        const auto ways = light::lattice_ways(count);
        ASSERT_EQ(ways.size(), static_cast<std::size_t>(count));
        for (int a = 0; a <= degree; ++a)
            for (int b = 0; a + b <= degree; ++b)
                for (int c = 0; a + b + c <= degree; ++c)
                    EXPECT_NEAR(sum(ways, a, b, c), moment(a, b, c), 1e-12)
                        << count << " ways: x^" << a << " y^" << b << " z^" << c;
    };
    expect_to(light::kNearWays, 7);
    expect_to(light::kAllWays, 11);
    const auto few = light::lattice_ways(light::kNearWays);
    EXPECT_GT(std::abs(sum(few, 8, 0, 0) - moment(8, 0, 0)), 1e-3) << "no more than was promised";
}

TEST(LatticeWays, HaveTheirOppositesAndBeginWithTheNearOnes)
{
    const auto all = light::lattice_ways(light::kAllWays),
               near = light::lattice_ways(light::kNearWays);
    for (const light::LatticeWay& way : all)
        EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const light::LatticeWay& other) {
            return other.step == -way.step && other.solid_angle == way.solid_angle;
        }));
    for (std::size_t i = 0; i < near.size(); ++i)
        EXPECT_EQ(all[i].step, near[i].step);
}

}  // namespace
}  // namespace fumarole::test
