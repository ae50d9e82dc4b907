// The tile is what it claims: every rank once, and a spectrum with next to nothing at low
// frequencies, which white noise of the same values would fill evenly.

#include "pass/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace fumarole::pass {
namespace {

constexpr int kCount = kBlueNoiseSize * kBlueNoiseSize;

// Rank at pixel (x, y) of the endlessly repeated tile.
int rank_at(int x, int y)
{
    const auto wrap = [](int v) {
        return ((v % kBlueNoiseSize) + kBlueNoiseSize) % kBlueNoiseSize;
    };
    return kBlueNoise[static_cast<std::size_t>(wrap(y) * kBlueNoiseSize + wrap(x))];
}

// Power at (u, v) cycles a tile of values uniform in 0..1, over what white noise would have there.
double relative_power(const std::vector<double>& values, int u, int v)
{
    std::complex<double> sum = 0;
    for (int y = 0; y < kBlueNoiseSize; ++y) {
        for (int x = 0; x < kBlueNoiseSize; ++x) {
            const double turn = static_cast<double>(u * x + v * y) / kBlueNoiseSize;
            sum += values[static_cast<std::size_t>(y * kBlueNoiseSize + x)] *
                   std::polar(1.0, -2 * std::numbers::pi * turn);
        }
    }
    constexpr double kUniformVariance = 1.0 / 12;
    return std::norm(sum) / kCount / kUniformVariance;
}

// Mean relative power over all frequencies within `radius` cycles a tile, the mean (0, 0) aside.
double low_power(const std::vector<double>& values, int radius)
{
    double sum = 0;
    int count = 0;
    for (int v = -radius; v <= radius; ++v) {
        for (int u = -radius; u <= radius; ++u) {
            if ((u != 0 || v != 0) && u * u + v * v <= radius * radius) {
                sum += relative_power(values, u, v);
                ++count;
            }
        }
    }
    return sum / count;
}

TEST(BlueNoise, HasEveryRankOnce)
{
    std::vector<int> ranks(kBlueNoise.begin(), kBlueNoise.end());
    std::sort(ranks.begin(), ranks.end());
    for (int i = 0; i < kCount; ++i) {
        ASSERT_EQ(ranks[static_cast<std::size_t>(i)], i);
    }
}

TEST(BlueNoise, HasNextToNoLowFrequencies)
{
    std::vector<double> values;
    for (const std::uint16_t rank : kBlueNoise) {
        values.push_back((rank + 0.5) / kCount);
    }
    // Measured 3e-4 within 8 of the 32 cycles a tile; the bound leaves room for another seed.
    EXPECT_LT(low_power(values, 8), 2e-3);

    // The yardstick itself: the same values in an order without a pattern have white noise's power.
    std::vector<double> white(values.size());
    std::uint32_t state = 1;
    for (double& value : white) {
        state = state * 1664525u + 1013904223u;  // Numerical Recipes' generator
        value = static_cast<double>(state) * 0x1p-32;
    }
    EXPECT_NEAR(low_power(white, 8), 1.0,
                0.4);  // about 100 independent powers, each of deviation 1
}

TEST(BlueNoise, NeighboursDifferAlsoAcrossTheEdges)
{
    double sum = 0;
    int least = kCount;
    for (int y = 0; y < kBlueNoiseSize; ++y) {
        for (int x = 0; x < kBlueNoiseSize; ++x) {
            for (const int difference : {std::abs(rank_at(x, y) - rank_at(x - 1, y)),
                                         std::abs(rank_at(x, y) - rank_at(x, y - 1))}) {
                sum += difference;
                least = std::min(least, difference);
            }
        }
    }
    // White noise: a third of the range on average, and somewhere next to nothing.
    EXPECT_GT(sum / (2 * kCount), 0.39 * kCount);
    EXPECT_GT(least, kCount / 40);
}

}  // namespace
}  // namespace fumarole::pass
