// Grain of a known deviation has its figure, and edges have none.

#include "study/grain.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace fumarole::study {
namespace {

constexpr int kWidth = 160, kHeight = 96;  // 240 squares: two of them exceed what is told

std::vector<float> noisy(float mean, float deviation, unsigned seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(mean, deviation);
    std::vector<float> rgb;
    for (int i = 0; i < kWidth * kHeight; ++i)
        rgb.insert(rgb.end(), 3, normal(random));  // grey, as what light scatters is
    return rgb;
}

glm::vec3 in_tenths(glm::vec3 rgb)
{
    return rgb * 10.0f;
}

TEST(Grain, IsTheDeviationOfTheMeanInSteps)
{
    // Two means with a deviation of 0.04 each: that of their mean is 0.04 / sqrt(2), 0.28 tenths.
    // The median of 64 pixels tells a deviation to some 15 %, and the third largest of 240 such
    // squares is high by up to half.
    const double found = grain(noisy(1, 0.04f, 1), noisy(1, 0.04f, 2), kWidth, in_tenths);
    EXPECT_GT(found, 0.28);
    EXPECT_LT(found, 0.28 * 1.6);
    EXPECT_NEAR(grain(noisy(1, 0.08f, 1), noisy(1, 0.08f, 2), kWidth, in_tenths), 2 * found, 1e-4);
    EXPECT_EQ(grain(noisy(1, 0.04f, 1), noisy(1, 0.04f, 1), kWidth, in_tenths), 0);
}

TEST(Grain, IsSeenInOnePartOfThePictureButNotOnAnEdge)
{
    const std::vector<float> first = noisy(1, 0, 1);
    std::vector<float> edge = first, part = first;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c) {
                const auto at = static_cast<std::size_t>(3 * (y * kWidth + x) + c);
                if (x % 8 < 2)  // a quarter of every square
                    edge[at] += 5;
                if (x < 16 && y < 16)  // four squares of 240
                    part[at] += 0.2f;
            }
    EXPECT_EQ(grain(first, edge, kWidth, in_tenths), 0);
    // Half of what the second half is off by, over a normal distribution's median.
    EXPECT_NEAR(grain(first, part, kWidth, in_tenths), 1 / 0.67449, 1e-4);
}

TEST(Grain, SquaresAtTheEdgesCount)
{
    // 9 x 9 pixels: four squares, the largest of which counts, here that of one pixel.
    std::vector<float> first(3 * 81, 1.0f), second = first;
    for (std::size_t c = 3 * 80; c < 3 * 81; ++c)
        second[c] = 1.2f;
    EXPECT_NEAR(grain(first, second, 9, in_tenths), 1 / 0.67449, 1e-4);
}

TEST(Grain, AStepOfLinearFloatsIsAHundredth)
{
    const std::vector<float> picture{8, 8, 8, 0, 0, 0};
    const InSteps steps = relative_steps(picture);
    EXPECT_NEAR(steps(glm::vec3(8.08f)).r - steps(glm::vec3(8)).r, 1, 0.1);
    // In the dark, of the root of a tenth of the mean square: sqrt(0.1 * 32) = 1.79.
    EXPECT_NEAR(steps(glm::vec3(0.0179f)).r - steps(glm::vec3(0)).r, 1, 0.01);
    EXPECT_EQ(relative_steps(std::vector<float>{0, 0, 0})(glm::vec3(1)), glm::vec3(0));
}

}  // namespace
}  // namespace fumarole::study
