#include "study/reference_sampling.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "study/reference_world.h"

namespace fumarole::study {
namespace {

// Of the first 2^k points each dimension has one in every interval of 2^-k, and the first two have
// one in every elementary rectangle of that area: scrambling must not spoil it.
TEST(Sobol, PointsAreAsEvenAsTheSequencePromises)
{
    for (const std::uint32_t seed : {0u, 1u, 12345u}) {
        const Sobol sobol(seed);
        constexpr int kBits = 8;
        for (std::size_t d = 0; d < Sobol::kDimensions; ++d) {
            std::set<int> intervals;
            for (std::uint32_t i = 0; i < 1u << kBits; ++i) {
                const double x = sobol(i, d);
                ASSERT_TRUE(x >= 0 && x < 1);
                intervals.insert(static_cast<int>(x * (1 << kBits)));
            }
            EXPECT_EQ(intervals.size(), 1u << kBits) << "dimension " << d << ", seed " << seed;
        }
        for (int bits_x = 0; bits_x <= kBits; ++bits_x) {
            std::set<std::pair<int, int>> rectangles;
            for (std::uint32_t i = 0; i < 1u << kBits; ++i)
                rectangles.emplace(static_cast<int>(sobol(i, 0) * (1 << bits_x)),
                                   static_cast<int>(sobol(i, 1) * (1 << (kBits - bits_x))));
            EXPECT_EQ(rectangles.size(), 1u << kBits) << bits_x << ", seed " << seed;
        }
    }
}

TEST(Sobol, SeedsAreIndependent)
{
    double correlation = 0;
    constexpr std::uint32_t kSeeds = 4096;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
        correlation += (Sobol(hash(7, seed))(3, 0) - 0.5) * (Sobol(hash(8, seed))(3, 0) - 0.5);
    EXPECT_NEAR(12 * correlation / kSeeds, 0, 4 / std::sqrt(double(kSeeds)));
}

// A product with a kink in each factor, whose integral is known: the estimate must hold, and the
// points must do much better than chance (whose error at 2^14 points is 1.2 %).
TEST(SampledMean, FindsAnIntegralAndSaysHowWell)
{
    const auto f = [](const auto& u) {
        double product = 1;
        for (std::size_t d = 0; d < 4; ++d)
            product *= std::abs(4 * u(d) - 2);
        return std::array{product, 3 * product};
    };
    int outside = 0;
    double of_asked = 0;
    constexpr int kSeeds = 40;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        const auto mean = sampled_mean<2>(f, seed, {.relative = 2e-3});
        EXPECT_NEAR(mean.value[1], 3 * mean.value[0], 1e-12);
        of_asked += mean.error / (2e-3 * mean.value[1]) / kSeeds;
        outside += std::abs(mean.value[1] - 3) > mean.error ? 1 : 0;
    }
    // Where a half's samples end is told by the other's, so they may say more.
    EXPECT_LT(of_asked, 1.5);
    EXPECT_LE(outside, 6) << "two standard errors hold 19 times of 20";
    const auto most = sampled_mean<2>(f, 1, {.relative = 0, .most = 1u << 14u});
    EXPECT_LT(std::abs(most.value[0] - 1), 3e-3);
    EXPECT_GT(most.error, 0) << "where it ends early it says so";
}

/// A gap of a hundredth of all that there is, as a slot in a roof: found by one sample of a
/// hundred.
struct Gap {
    static constexpr double kMean = 0.01;
    std::array<double, 1> operator()(const SobolPoint& u) const
    {
        return {std::abs(u(0) - 0.61) < 0.05 && std::abs(u(1) - 0.23) < 0.05 ? 1.0 : 0.0};
    }
};

TEST(SampledMean, OfWhatIsSeldomFoundIsRightOnTheMean)
{
    // If samples that find nothing end by that, means are too low: by three quarters, here.
    constexpr int kSeeds = 4000;
    double mean = 0, squares = 0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        const double one = sampled_mean<1>(Gap(), seed, {.relative = 0.5, .first = 4}).value[0];
        mean += one / kSeeds;
        squares += one * one / kSeeds;
    }
    EXPECT_NEAR(mean, Gap::kMean, 3.5 * std::sqrt((squares - mean * mean) / kSeeds));
}

TEST(SampledMean, OfWhatIsSeldomFoundIsNotDoneBeforeItCouldBeFound)
{
    // To a tenth of the mean, of a bound that is a hundred times as much.
    constexpr double kTolerance = 0.1 * Gap::kMean;
    constexpr int kSeeds = 100;
    double squares = 0;
    for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
        const auto one = sampled_mean<1>(
            Gap(), seed, {.relative = 0, .absolute = kTolerance, .first = 4, .bound = 1});
        squares += std::pow(one.value[0] - Gap::kMean, 2) / kSeeds;
    }
    EXPECT_LT(std::sqrt(squares), 0.75 * kTolerance) << "half of it is one standard error";
}

/// Dark but for a few texels, some at a pole and across the seam.
World lamp_world()
{
    auto map = std::make_shared<Environment>();
    map->width = 16;
    map->height = 8;
    map->radiance.assign(16 * 8, glm::vec3(0.02f, 0.01f, 0.03f));
    map->radiance[3] = {5, 2, 1};
    map->radiance[3 * 16 + 15] = {40, 30, 20};
    map->radiance[6 * 16 + 7] = {0, 9, 0};
    World world;
    world.environment = map;
    world.environment_scale = 1.5f;
    return world;
}

TEST(WorldRadiance, DirectionsComeWithTheDensityThatPdfSays)
{
    const World lamps = lamp_world();
    const WorldRadiance world(lamps);
    // The mean over directions of what is seen, once by a fine grid of directions, once by
    // sampling; and pdf adds up to 1.
    glm::dvec3 whole(0);
    double total = 0;
    constexpr int kRows = 1200, kColumns = 2400;
    const double area = 4 * M_PI / kRows / kColumns;
    for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kColumns; ++j) {
            const double z = -1 + 2 * (i + 0.5) / kRows, phi = 2 * M_PI * (j + 0.5) / kColumns;
            const double r = std::sqrt(1 - z * z);
            const glm::dvec3 d(r * std::cos(phi), r * std::sin(phi), z);
            whole += area * world(d);
            total += area * world.pdf(d);
        }
    EXPECT_NEAR(total, 1, 2e-3);
    const auto sampled = sampled_mean<3>(
        [&](const auto& u) {
            const glm::dvec3 d = world.sample(u(0), u(1));
            EXPECT_NEAR(glm::length(d), 1, 1e-12);
            const glm::dvec3 v = world(d) / world.pdf(d);
            return std::array{v.x, v.y, v.z};
        },
        3, {.relative = 1e-3});
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(sampled.value[c], whole[static_cast<int>(c)],
                    2e-3 * whole[static_cast<int>(c)]);
}

}  // namespace
}  // namespace fumarole::study
