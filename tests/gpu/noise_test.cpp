// glsl/lib/noise.glsl against the same noise written again here in double.

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

/// PCG3D of Jarzynski and Olano 2020.
std::uint32_t hash_x(glm::uvec3 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    return v.x + v.y * v.z;
}

double gradient(glm::ivec3 cell, std::uint32_t seed, glm::dvec3 offset)
{
    glm::uvec3 v(cell);
    v.x += seed;
    const std::uint32_t h = hash_x(v) >> 16u;
    std::vector<double> kept;
    for (int axis = 0; axis < 3; ++axis)
        if (axis != static_cast<int>(h % 3))
            kept.push_back(offset[axis]);
    return ((h & 0x1000u) != 0 ? kept[0] : -kept[0]) + ((h & 0x2000u) != 0 ? kept[1] : -kept[1]);
}

double noise(glm::ivec3 cell, std::uint32_t seed, glm::dvec3 f)
{
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double x = f[axis], u = x * x * x * (x * (x * 6 - 15) + 10);
            weight *= step[axis] == 1 ? u : 1 - u;
        }
        sum += weight * gradient(cell + step, seed, f - glm::dvec3(step));
    }
    return sum;
}

class Noise : public GlTest {
protected:
    Kernel kernel{gl(), R"(
#include "lib/noise.glsl"
void kernel(int i)
{
    out_data[i] = vec4(noise_at(floatBitsToInt(in_data[2 * i].xyz), floatBitsToUint(in_data[2 * i].w), in_data[2 * i + 1].xyz));
}
)",
                  2};

    static void add(std::vector<glm::vec4>& inputs, glm::ivec3 cell, std::uint32_t seed,
                    glm::vec3 f)
    {
        inputs.emplace_back(glm::intBitsToFloat(cell), std::bit_cast<float>(seed));
        inputs.emplace_back(f, 0);
    }
};

TEST_F(Noise, AgreesWithDoubleHasMeanZeroAndStaysInRange)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> fraction(0, 1);
    // Bits travel as floats, so no cell may look like a NaN or a denormal: those may be changed on
    // the way. 1.0f .. 2.0f are the integers 0x3f800000 and up.
    std::uniform_int_distribution<int> place(0x3f800000, 0x3fffffff);
    std::vector<glm::vec4> inputs;
    constexpr int kPoints = 100000;
    for (int i = 0; i < kPoints; ++i)
        add(inputs, {place(random), place(random), -place(random)},
            static_cast<std::uint32_t>(place(random)),
            {fraction(random), fraction(random), fraction(random)});
    const std::vector<glm::vec4> values = kernel(inputs);
    double mean = 0, largest = 0, square = 0;
    for (int i = 0; i < kPoints; ++i) {
        const double expected =
            noise(glm::floatBitsToInt(glm::vec3(inputs[2 * i])),
                  std::bit_cast<std::uint32_t>(inputs[2 * i].w), glm::dvec3(inputs[2 * i + 1]));
        ASSERT_NEAR(values[i].x, expected, 2e-6) << "point " << i;
        mean += values[i].x / double(kPoints);
        square += values[i].x * values[i].x / double(kPoints);
        largest = std::max(largest, std::abs(double(values[i].x)));
    }
    EXPECT_LE(largest, 1);
    EXPECT_GT(largest, 0.7);
    EXPECT_NEAR(std::sqrt(square), 0.27, 0.03);
    EXPECT_NEAR(mean, 0, 5 * 0.27 / std::sqrt(kPoints));
}

TEST_F(Noise, IsZeroOnTheLatticeAndContinuousAcrossCells)
{
    std::vector<glm::vec4> inputs;
    const glm::ivec3 cell(0x3f812345, 0x3f854321, 0x3f8abcde);
    for (int i = 0; i < 64; ++i) {
        const glm::ivec3 at = cell + glm::ivec3(i, 2 * i, 3 * i);
        const float y = static_cast<float>(i) / 64, z = 1 - y;
        add(inputs, at, 0x3f800000u, glm::vec3(0));
        add(inputs, at, 0x3f800000u, {1, y, z});
        add(inputs, at + glm::ivec3(1, 0, 0), 0x3f800000u, {0, y, z});
    }
    const std::vector<glm::vec4> values = kernel(inputs);
    for (std::size_t i = 0; i < values.size(); i += 3) {
        EXPECT_EQ(values[i].x, 0);
        EXPECT_NEAR(values[i + 1].x, values[i + 2].x, 1e-6);
    }
}

TEST_F(Noise, SeedsDiffer)
{
    std::vector<glm::vec4> inputs;
    for (std::uint32_t i = 0; i < 256; ++i)
        for (const std::uint32_t seed : {0x3f800000u, 0x3f987654u})
            add(inputs, glm::ivec3(0x3f800000 + static_cast<int>(i)), seed, {0.3f, 0.4f, 0.5f});
    const std::vector<glm::vec4> values = kernel(inputs);
    double product = 0, square = 0;
    for (std::size_t i = 0; i < values.size(); i += 2) {
        product += values[i].x * values[i + 1].x;
        square += values[i].x * values[i].x;
    }
    EXPECT_LT(std::abs(product), 0.3 * square);
}

}  // namespace
}  // namespace fumarole::test
