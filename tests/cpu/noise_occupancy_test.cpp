// The boxes of noise against the noise itself, as the reference has it.

#include <algorithm>
#include <gtest/gtest.h>
#include <ostream>
#include <random>

#include "medium/noise_occupancy.h"
#include "study/reference_media.h"

namespace fumarole::test {
namespace {

using medium::OccupiedBox;

constexpr std::size_t kMostBoxes = 2048;
const Bounds kBox{{-2.5, 0.3, -1}, {1.7, 3.1, 1.5}};

struct NoiseCase {
    const char* name;
    NoiseProfile noise;
};
std::ostream& operator<<(std::ostream& out, const NoiseCase& c)
{
    return out << c.name;
}

double volume(const std::vector<OccupiedBox>& boxes)
{
    double sum = 0;
    for (const OccupiedBox& box : boxes) {
        const glm::dvec3 edge = box.bounds.max - box.bounds.min;
        sum += edge.x * edge.y * edge.z;
    }
    return sum;
}

double part_of_box(const NoiseProfile& noise, const Bounds& bounds = kBox)
{
    return volume(medium::occupied_boxes(noise, bounds, kMostBoxes)) / volume({{bounds, 0}});
}

class NoiseOccupancy : public testing::TestWithParam<NoiseCase> {};

TEST_P(NoiseOccupancy, NothingIsOutsideOfTheBoxesOrThickerThanTheySay)
{
    const NoiseProfile& noise = GetParam().noise;
    BoxMedium medium{.min = kBox.min, .max = kBox.max, .profile = noise};
    medium.sigma_s = glm::vec3(1);
    Scene scene;
    scene.media = {medium};
    const study::ReferenceMedia media(scene, 1e-3);
    const std::vector<OccupiedBox> boxes = medium::occupied_boxes(noise, kBox, kMostBoxes);
    EXPECT_LE(boxes.size(), kMostBoxes);
    const auto held = [&](glm::dvec3 p, double value) {
        return std::any_of(boxes.begin(), boxes.end(), [&](const OccupiedBox& box) {
            return glm::all(glm::greaterThanEqual(p, box.bounds.min)) &&
                   glm::all(glm::lessThanEqual(p, box.bounds.max)) &&
                   value <= static_cast<double>(box.most);
        });
    };
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(0, 1);
    for (int i = 0; i < 60000; ++i) {
        const glm::dvec3 p =
            glm::mix(kBox.min, kBox.max, glm::dvec3(place(random), place(random), place(random)));
        const double value = media.at(p).sigma_s.x;
        ASSERT_TRUE(value == 0 || held(p, value))
            << "of " << value << " at " << p.x << ", " << p.y << ", " << p.z;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Profiles, NoiseOccupancy,
    testing::Values(
        NoiseCase{"usual", {.feature_size = 1.5, .octaves = 4}},
        NoiseCase{"threshold 0", {.feature_size = 0.7, .octaves = 3, .threshold = 0}},
        NoiseCase{"half", {.feature_size = 1, .octaves = 4, .threshold = 0.5, .seed = 3}},
        NoiseCase{"little", {.feature_size = 1.5, .octaves = 4, .threshold = 0.62}},
        NoiseCase{"one octave", {.feature_size = 0.9, .octaves = 1, .threshold = 0.6, .seed = 9}},
        NoiseCase{"one octave, wide", {.feature_size = 40, .octaves = 1, .threshold = 0.5}},
        NoiseCase{"slow octaves",
                  {.feature_size = 1, .octaves = 6, .lacunarity = 1.3, .threshold = 0.55}},
        NoiseCase{"one frequency",
                  {.feature_size = 0.8, .octaves = 5, .lacunarity = 1, .threshold = 0.55}},
        NoiseCase{"octaves alike",
                  {.feature_size = 1.2, .octaves = 3, .gain = 1, .threshold = 0.55, .seed = 77}},
        NoiseCase{"uneven octaves",
                  {.feature_size = 1.2,
                   .octaves = 5,
                   .gain = 0.35,
                   .lacunarity = 2.7,
                   .threshold = 0.6,
                   .seed = 1u << 31}},
        NoiseCase{"too many octaves to sample",
                  {.feature_size = 0.5, .octaves = 16, .gain = 0.3, .threshold = 0.6}},
        NoiseCase{"too small to sample", {.feature_size = 0.003, .octaves = 5}},
        NoiseCase{"next to 1", {.feature_size = 0.4, .octaves = 2, .threshold = 0.95}}),
    [](const testing::TestParamInfo<NoiseCase>& one) {
        std::string name = one.param.name;
        std::erase_if(name, [](char c) { return c == ' ' || c == ','; });
        return name;
    });

TEST(NoiseBoxes, LeaveOutMostOfWhatIsEmpty)
{
    // Of blocks as large 0.79 are empty in truth, of points 0.89.
    NoiseProfile noise{.feature_size = 1.5, .octaves = 4, .threshold = 0.6};
    const Bounds bounds{{-4, -3, 0.5}, {4, 3, 3.5}};
    EXPECT_LT(part_of_box(noise, bounds), 0.4);
    noise.threshold = 0.7;
    EXPECT_LT(part_of_box(noise, bounds), 0.05);
}

TEST(NoiseBoxes, AreTheWholeBoxWhereNothingCanBeProven)
{
    for (const NoiseProfile& noise :
         {NoiseProfile{.threshold = 0}, NoiseProfile{.feature_size = 1e-6, .threshold = 0.6}}) {
        const std::vector<OccupiedBox> boxes = medium::occupied_boxes(noise, kBox, kMostBoxes);
        ASSERT_EQ(boxes.size(), 1u);
        EXPECT_EQ(boxes[0].bounds.min, kBox.min);
        EXPECT_EQ(boxes[0].bounds.max, kBox.max);
    }
}

TEST(NoiseBoxes, OfBoxesOfAllShapes)
{
    const NoiseProfile noise{.feature_size = 1, .octaves = 3, .threshold = 0.6};
    for (const glm::dvec3 size : {glm::dvec3(1e4, 1e4, 1e-3), glm::dvec3(1e6), glm::dvec3(1e-6),
                                  glm::dvec3(1e-3, 300, 1e-3)}) {
        const Bounds bounds{glm::dvec3(5e5), glm::dvec3(5e5) + size};
        EXPECT_LE(part_of_box(noise, bounds), 1 + 1e-9);
    }
}

}  // namespace
}  // namespace fumarole::test
