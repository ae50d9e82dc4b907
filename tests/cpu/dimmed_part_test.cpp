#include "surface/dimmed_part.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace fumarole::surface {
namespace {

constexpr int kSize = 64;

/// 90 degrees each way, from the origin along -z.
PreparedFrame looking_ahead(double near)
{
    Frame frame;
    frame.color.size = {kSize, kSize, 1};
    frame.clip_from_view = glm::perspective(glm::radians(90.0), 1.0, near, 1e6);
    return prepare_frame(frame, Settings{}, {});
}

// The media's shadow on a ground that passes close below the eye: of corners that are hardly before
// the near plane a picture's pixels are more than an integer has.
TEST(DimmedPart, GoesOnFarBesideThePicture)
{
    const PreparedFrame frame = looking_ahead(1e-3);
    const std::vector<glm::dvec3> to_suns{{0, 1, 0}};
    const Bounds ground{{-1e6, -2, -10}, {1e6, 2, -1.5e-3}};
    for (const double far : {1.0, 1e3, 1e6}) {
        const Bounds media{{0, -1, -9}, {far, 1, -1.5e-3}};
        const auto bands = dimmed_part(frame, media, ground, to_suns);
        ASSERT_TRUE(bands) << far;
        ASSERT_EQ(bands->size(), 1u) << far;
        EXPECT_LE(bands->front().low.x, kSize / 2) << far;
        EXPECT_EQ(bands->front().low.x + bands->front().size.x, kSize) << far;
    }
    const auto left = dimmed_part(frame, {{-1e6, -1, -9}, {-1e3, 1, -1.5e-3}}, ground, to_suns);
    ASSERT_TRUE(left);
    EXPECT_TRUE(left->empty()) << "all of it lies beside the picture";
}

TEST(PartWithin, IsWhatOfAGroundLiesInABox)
{
    const PreparedFrame frame = looking_ahead(1e-3);
    const Bounds ground{{-1e6, -3, -1e6}, {1e6, -2, 1e6}};
    // 4 to 8 m away on a ground 2 m below: 8 to 16 of the 32 rows below the middle.
    const auto bands = part_within(frame, {{-2, -5, -8}, {1, 5, -4}}, ground);
    ASSERT_TRUE(bands);
    ASSERT_EQ(bands->size(), 1u);
    const auto pixel = [](double x, double z) { return kSize / 2 * (1 + x / z); };
    EXPECT_NEAR(bands->front().low.x, pixel(-2, 4), 5);
    EXPECT_LE(bands->front().low.x, pixel(-2, 4));
    EXPECT_GE(bands->front().low.x + bands->front().size.x, pixel(1, 4));
    const auto beside = part_within(frame, {{50, -5, -8}, {60, 5, -4}}, ground);
    ASSERT_TRUE(beside);
    EXPECT_TRUE(beside->empty());
    EXPECT_FALSE(part_within(frame, {{-2, -5, -8}, {1, 5, 4}}, ground)) << "it goes past the eye";
}

}  // namespace
}  // namespace fumarole::surface
