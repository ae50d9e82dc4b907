// glsl/lib/falloff.glsl against sums in double.

#include <cmath>
#include <numbers>

#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// Mean of 1 / distance over a disc of radius 1 to a point of its plane, d from its middle: in
/// directions from the point, what each sees of the disc.
double mean_over_disc(double d)
{
    d = std::abs(d - 1) < 1e-4 ? 1 : d;  // at the rim: from within
    constexpr int kDirections = 200000;
    double sum = 0;
    for (int i = 0; i < kDirections; ++i) {
        const double theta = 2 * kPi * (i + 0.5) / kDirections;
        const double half2 = std::max(0.0, 1 - d * d * std::sin(theta) * std::sin(theta));
        if (d <= 1)
            sum += std::sqrt(half2) - d * std::cos(theta);
        else if (half2 > 0 && std::cos(theta) > 0)
            sum += 2 * std::sqrt(half2);
    }
    return 2 * sum / kDirections;  // over the disc's pi
}

class FalloffKernel : public GlTest {
protected:
    std::vector<glm::vec4> distances(const std::vector<glm::vec4>& distance_and_radius)
    {
        const Kernel kernel(gl(), R"(
#include "lib/phase.glsl"
#include "lib/falloff.glsl"
void kernel(int i)
{
    out_data[i] = vec4(distance_of_disc(in_data[i].x * in_data[i].x, in_data[i].y));
}
)");
        return kernel(distance_and_radius);
    }
};

TEST_F(FalloffKernel, DistanceOfADiscIsThatOfItsMean)
{
    std::vector<glm::vec4> at;
    for (double d = 0; d < 8; d += d < 2 ? 0.05 : 0.5)
        at.emplace_back(0.3 * d, 0.3, 0, 0);
    const std::vector<glm::vec4> found = distances(at);
    for (std::size_t i = 0; i < at.size(); ++i) {
        const double d = double(at[i].x) / 0.3;
        EXPECT_NEAR(0.3 / double(found[i].x) / mean_over_disc(d), 1, 0.004) << d << " radii";
    }
    EXPECT_EQ(distances({{0.7f, 0, 0, 0}})[0].x, 0.7f) << "a line alone";
    EXPECT_EQ(distances({{0, 0, 0, 0}})[0].x, 0.0f);
}

// Averaged over a picture, means over discs are what was there.
TEST_F(FalloffKernel, ADiscLosesNoLight)
{
    std::vector<glm::vec4> at;
    constexpr double kRing = 0.01, kEnd = 20;
    for (double d = 0.5 * kRing; d < kEnd; d += kRing)
        at.emplace_back(d, 1, 0, 0);
    double difference = 0;
    const std::vector<glm::vec4> found = distances(at);
    for (std::size_t i = 0; i < at.size(); ++i)
        difference += 2 * kPi * kRing * (double(at[i].x) / double(found[i].x) - 1.0);
    // Beyond the end it holds pi / (4 end) more. The whole within one radius is 2 pi.
    EXPECT_NEAR(difference + kPi / (4 * kEnd), 0, 0.01 * 2 * kPi) << "of 1 / d over the plane";
}

}  // namespace
}  // namespace fumarole::test
