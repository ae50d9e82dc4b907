// glsl/lib/phase.glsl against what a phase function is: it integrates to 1 over the sphere, its
// mean cosine is g, and it agrees with the formula in double.

#include <cmath>
#include <numbers>

#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// Henyey and Greenstein 1941, with 1 - g and 1 - cos kept as they are given.
double henyey_greenstein(double cos_theta, double g)
{
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cos_theta, 1.5));
}

class Phase : public GlTest {
protected:
    std::vector<double> phase(const std::vector<glm::vec4>& cos_and_g)
    {
        const Kernel kernel(gl(), R"(
#include "lib/phase.glsl"
void kernel(int i) { out_data[i] = vec4(phase_henyey_greenstein(in_data[i].x, in_data[i].y), phase_isotropic(), 0, 0); }
)");
        std::vector<double> values;
        for (const glm::vec4& v : kernel(cos_and_g))
            values.push_back(v.x);
        return values;
    }
};

TEST_F(Phase, IntegratesToOneAndHasMeanCosineG)
{
    // Midpoints in angle, which crowd where the lobe of |g| = 0.99 is (half a degree wide).
    constexpr int kAngles = 20000;
    for (const float g : {-0.99f, -0.6f, -0.1f, 0.0f, 0.3f, 0.85f, 0.99f}) {
        std::vector<glm::vec4> inputs;
        for (int i = 0; i < kAngles; ++i)
            inputs.emplace_back(std::cos((i + 0.5) * kPi / kAngles), g, 0, 0);
        const std::vector<double> values = phase(inputs);
        double integral = 0, mean_cosine = 0;
        for (int i = 0; i < kAngles; ++i) {
            const double theta = (i + 0.5) * kPi / kAngles;
            const double solid_angle = 2 * kPi * std::sin(theta) * kPi / kAngles;
            integral += values[i] * solid_angle;
            mean_cosine += values[i] * solid_angle * std::cos(theta);
        }
        // A float cosine near 1 is good to 6e-8, against 1 - cos = 5e-5 of that lobe: 1e-3.
        const double tolerance = std::abs(g) > 0.9 ? 1e-3 : 1e-5;
        EXPECT_NEAR(integral, 1, tolerance) << "g " << g;
        EXPECT_NEAR(mean_cosine, g, tolerance) << "g " << g;
    }
}

TEST_F(Phase, PositiveGScattersForward)
{
    const std::vector<double> values =
        phase({{1, 0.5f, 0, 0}, {-1, 0.5f, 0, 0}, {1, -0.5f, 0, 0}, {-1, -0.5f, 0, 0}});
    EXPECT_GT(values[0], 20 * values[1]);
    EXPECT_GT(values[3], 20 * values[2]);
    EXPECT_NEAR(values[0], values[3], 1e-6 * values[0]);
}

TEST_F(Phase, ZeroGIsIsotropic)
{
    for (const double value : phase({{1, 0, 0, 0}, {0, 0, 0, 0}, {-0.3f, 0, 0, 0}, {-1, 0, 0, 0}}))
        EXPECT_FLOAT_EQ(static_cast<float>(value), static_cast<float>(1 / (4 * kPi)));
}

TEST_F(Phase, AgreesWithDoubleToTheLastG)
{
    std::vector<glm::vec4> inputs;
    for (const float g : {-0.9999f, -0.999f, -0.5f, 0.2f, 0.9f, 0.999f, 0.9999f})
        for (const float cos_theta : {-1.0f, -0.9999f, -0.5f, 0.0f, 0.5f, 0.9999f, 1.0f})
            inputs.emplace_back(cos_theta, g, 0, 0);
    const std::vector<double> values = phase(inputs);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        const double expected = henyey_greenstein(inputs[i].x, inputs[i].y);
        ASSERT_TRUE(std::isfinite(values[i])) << "cos " << inputs[i].x << ", g " << inputs[i].y;
        EXPECT_NEAR(values[i], expected, 2e-6 * expected)
            << "cos " << inputs[i].x << ", g " << inputs[i].y;
    }
}

TEST_F(Phase, BackwardLobeMirrorsTheForwardOne)
{
    // p(cos, g) = p(-cos, -g). At g = 0.999 the peak is 1.6e5 per sr: a formula that loses it
    // backward makes a bright ring there.
    std::vector<glm::vec4> inputs;
    for (const float g : {0.9f, 0.99f, 0.999f})
        for (const float cos_theta : {1.0f, 0.99999f, 0.999f, 0.9f}) {
            inputs.emplace_back(cos_theta, g, 0, 0);
            inputs.emplace_back(-cos_theta, -g, 0, 0);
        }
    const std::vector<double> values = phase(inputs);
    for (std::size_t i = 0; i < inputs.size(); i += 2)
        EXPECT_NEAR(values[i + 1], values[i], 1e-6 * values[i])
            << "cos " << inputs[i].x << ", g " << inputs[i].y;
}

// From two directions: where the lobe is, an angle has digits left that its cosine has lost.
TEST_F(Phase, OfDirectionsHasTheDigitsOfTheirAngle)
{
    const Kernel kernel(gl(), R"(
#include "lib/phase.glsl"
void kernel(int i)
{
    vec3 wi = vec3(0.0, -1.0, 0.0), along = vec3(sin(in_data[i].x), -cos(in_data[i].x), 0.0);
    float g = in_data[i].y;
    vec3 wo = g < 0.0 ? along : -along;
    out_data[i] = vec4(phase_henyey_greenstein(wi, wo, g), phase_henyey_greenstein(dot(-wi, wo), g), 0, 0);
}
)");
    std::vector<glm::vec4> inputs;
    for (const float g : {0.99f, -0.99f, 0.999f, -0.999f})
        for (const float theta : {0.0005f, 0.001f, 0.003f, 0.01f, 0.1f, 1.5f})
            inputs.emplace_back(theta, g, 0, 0);
    const std::vector<glm::vec4> values = kernel(inputs);
    double worst_of_cosine = 0;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        const double theta = inputs[i].x, g = std::abs(double(inputs[i].y));
        const double d = (1 - g) * (1 - g) + 4 * g * std::pow(std::sin(theta / 2), 2);
        const double exact = (1 - g) * (1 + g) / (4 * kPi * d * std::sqrt(d));
        // Sines and cosines of a GPU may be off by 2^-11 of the angle in the shader's own.
        EXPECT_NEAR(values[i].x, exact, 2e-3 * exact) << "g " << g << ", " << theta << " rad";
        worst_of_cosine = std::max(worst_of_cosine, std::abs(double(values[i].y) / exact - 1));
    }
    EXPECT_GT(worst_of_cosine, 0.02) << "or there was nothing to mend";
}

}  // namespace
}  // namespace fumarole::test
