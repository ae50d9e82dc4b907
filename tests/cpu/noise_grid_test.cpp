// The grid that is made of a noise, against the noise itself as the reference has it.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <ostream>
#include <random>

#include "medium/noise_grid.h"
#include "study/reference_media.h"

namespace fumarole::test {
namespace {

constexpr int kLongest = 1 << 20;
const Bounds kBox{{-2.5, 0.3, -1}, {1.7, 3.1, 1.5}};

struct NoiseCase {
    const char* name;
    NoiseProfile noise;
    double left_out = 0;  ///< of octaves too small for the nodes, in units of the coefficient
};
std::ostream& operator<<(std::ostream& out, const NoiseCase& c)
{
    return out << c.name;
}

/// A medium whose sigma_s is the coefficient.
Scene scene_of(const NoiseProfile& noise, const Bounds& bounds)
{
    BoxMedium medium{.min = bounds.min, .max = bounds.max, .profile = noise};
    medium.sigma_s = glm::vec3(1);
    Scene scene;
    scene.media = {medium};
    return scene;
}

class NoiseGrid : public testing::TestWithParam<NoiseCase> {};

TEST_P(NoiseGrid, IsTheNoiseAtItsNodesAndWithinItsErrorBetweenThem)
{
    const NoiseProfile& noise = GetParam().noise;
    const study::ReferenceMedia media(scene_of(noise, kBox), 1e-3);
    const auto grid = medium::make_noise_grid(noise, kBox, kLongest);
    ASSERT_NE(grid, nullptr);
    const VoxelLookup lookup(*grid);
    const glm::dmat4 index_from_world = glm::inverse(grid->world_from_index);
    const auto to_index = [&](glm::dvec3 p) {
        return glm::dvec3(index_from_world * glm::dvec4(p, 1));
    };
    for (const glm::dvec3 corner : {kBox.min, kBox.max}) {
        const glm::dvec3 index = to_index(corner);
        EXPECT_LT(glm::length(index - glm::round(index)), 1e-6) << "a node is at each corner";
    }

    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(0, 1);
    double square = 0, error = 0, bias = 0, mean = 0;
    constexpr int kPlaces = 20000;
    for (int i = 0; i < kPlaces; ++i) {
        const glm::dvec3 p =
            glm::mix(kBox.min, kBox.max, glm::dvec3(place(random), place(random), place(random)));
        // On the faces themselves the reference may see the box or not.
        const glm::dvec3 node = glm::round(to_index(p)), last = glm::round(to_index(kBox.max));
        if (glm::all(glm::greaterThan(node, glm::dvec3(0))) &&
            glm::all(glm::lessThan(node, last))) {
            const double at_node =
                media.at(glm::dvec3(grid->world_from_index * glm::dvec4(node, 1))).sigma_s.x;
            ASSERT_NEAR(lookup.sample(node).x, at_node,
                        3e-6 / (1 - noise.threshold) + GetParam().left_out)
                << "single precision; node " << node.x << ", " << node.y << ", " << node.z;
        }
        const double value = media.at(p).sigma_s.x, kept = lookup.sample(to_index(p)).x;
        mean += value / kPlaces;
        square += value * value / kPlaces;
        error += (kept - value) * (kept - value) / kPlaces;
        bias += (kept - value) / kPlaces;
    }
    // Of the octaves' sum, which has an RMS of 0.27 an octave; half of it is the coefficient's.
    double amplitudes = 0, squares = 0;
    for (int i = 0; i < noise.octaves; ++i) {
        amplitudes += std::pow(noise.gain, i);
        squares += std::pow(noise.gain, 2 * i);
    }
    const double spread = 0.5 * 0.27 * std::sqrt(squares) / amplitudes / (1 - noise.threshold);
    EXPECT_LT(std::sqrt(error), 1.1 * medium::kNoiseGridError * spread);
    EXPECT_LT(std::abs(bias), 0.002 * mean + 0.1 * medium::kNoiseGridError * spread);
    if (noise.threshold < 0.5) {
        EXPECT_GT(std::sqrt(square), spread / 2) << "there was something to err in";
    }
}

INSTANTIATE_TEST_SUITE_P(
    Profiles, NoiseGrid,
    testing::Values(
        NoiseCase{"usual", {.feature_size = 1.5, .octaves = 4}},
        NoiseCase{"threshold 0", {.feature_size = 0.7, .octaves = 3, .threshold = 0}},
        NoiseCase{"half", {.feature_size = 1, .octaves = 4, .threshold = 0.5, .seed = 3}},
        NoiseCase{"little", {.feature_size = 1.5, .octaves = 4, .threshold = 0.62}},
        NoiseCase{"one octave", {.feature_size = 0.9, .octaves = 1, .threshold = 0.6, .seed = 9}},
        NoiseCase{"one octave, wide", {.feature_size = 40, .octaves = 1, .threshold = 0.45}},
        NoiseCase{"slow octaves",
                  {.feature_size = 1, .octaves = 6, .lacunarity = 1.3, .threshold = 0.55}},
        NoiseCase{"one frequency",
                  {.feature_size = 0.8, .octaves = 5, .lacunarity = 1, .threshold = 0.55}},
        NoiseCase{"octaves alike",
                  {.feature_size = 1.2, .octaves = 3, .gain = 1, .threshold = 0.55, .seed = 77}},
        NoiseCase{"uneven octaves",
                  {.feature_size = 1.2,
                   .octaves = 4,
                   .gain = 0.35,
                   .lacunarity = 2.7,
                   .threshold = 0.4,
                   .seed = 1u << 31}},
        NoiseCase{"many octaves that fade",
                  {.feature_size = 2, .octaves = 16, .gain = 0.1, .threshold = 0.4},
                  0.01}),
    [](const testing::TestParamInfo<NoiseCase>& one) {
        std::string name = one.param.name;
        std::erase_if(name, [](char c) { return c == ' ' || c == ','; });
        return name;
    });

TEST(NoiseGrids, KeepNoBrickThatIsEmpty)
{
    const Bounds bounds{{-4, -3, 0.5}, {4, 3, 3.5}};
    const auto part = [&](double threshold) {
        const auto grid = medium::make_noise_grid(
            {.feature_size = 1.5, .octaves = 4, .threshold = threshold}, bounds, kLongest);
        double nodes = 1;
        for (int a = 0; a < 3; ++a)
            nodes *= (bounds.max[a] - bounds.min[a]) / grid->world_from_index[a][a];
        return static_cast<double>(grid->values.size()) / nodes;
    };
    EXPECT_GT(part(0.0), 1.0);
    EXPECT_LT(part(0.6), 0.5);
    EXPECT_LT(part(0.7), 0.1);
    const auto none = medium::make_noise_grid({.feature_size = 3, .octaves = 2, .threshold = 0.97},
                                              bounds, kLongest);
    ASSERT_NE(none, nullptr);
    EXPECT_TRUE(none->empty());
}

TEST(NoiseGrids, AreNotMadeWhereTheyWouldBeTooLarge)
{
    EXPECT_EQ(medium::make_noise_grid({.feature_size = 0.003, .octaves = 5}, kBox, kLongest),
              nullptr);
    EXPECT_EQ(
        medium::make_noise_grid({.feature_size = 0.5, .octaves = 16, .gain = 1}, kBox, kLongest),
        nullptr);
    const NoiseProfile noise{.feature_size = 1, .octaves = 3, .threshold = 0.4};
    EXPECT_NE(medium::make_noise_grid(noise, kBox, 100), nullptr);
    EXPECT_EQ(medium::make_noise_grid(noise, kBox, 10), nullptr);
    for (const glm::dvec3 size : {glm::dvec3(1e4, 1e4, 1e-3), glm::dvec3(1e6)})
        EXPECT_EQ(
            medium::make_noise_grid(noise, {glm::dvec3(5e5), glm::dvec3(5e5) + size}, kLongest),
            nullptr);
    for (const glm::dvec3 size : {glm::dvec3(1e-6), glm::dvec3(1e-3, 300, 1e-3)}) {
        const auto grid =
            medium::make_noise_grid(noise, {glm::dvec3(5e5), glm::dvec3(5e5) + size}, kLongest);
        ASSERT_NE(grid, nullptr);
        EXPECT_LT(grid->values.size(), 500000u) << "no more of them than the noise asks for";
    }
}

}  // namespace
}  // namespace fumarole::test
