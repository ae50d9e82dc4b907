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

}  // namespace
}  // namespace fumarole::surface
