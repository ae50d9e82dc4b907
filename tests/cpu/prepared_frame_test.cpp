#include "prepared_frame.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <limits>

namespace fumarole {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// 480 x 270, 50 degrees high, the eye at `position`, looking along y.
Frame street(glm::dvec3 position)
{
    Frame frame;
    frame.color.size = {480, 270, 1};
    frame.view_from_world = glm::lookAt(position, position + glm::dvec3(0, 1, 0), {0, 0, 1});
    frame.clip_from_view = glm::perspective(glm::radians(50.0), 480.0 / 270, 0.1, 400.0);
    return frame;
}

int scale_of(const Frame& frame, const Bounds& media, double detail, double g)
{
    const FrameScene scene{.media = media, .detail = detail, .most_g = g};
    return prepare_frame(frame, Settings{}, scene).settings.resolution;
}

TEST(LayerScale, IsAQuarterWhereNothingChangesWithinATexel)
{
    const Bounds haze{{-60, -10, -0.5}, {60, 190, 60}};
    const Frame inside = street({0, -4, 1.7});
    EXPECT_EQ(scale_of(inside, haze, kNowhere, 0), 4);
    // A texel of four pixels is 0.0138 rad, and 2.7 m at the far end.
    EXPECT_EQ(scale_of(inside, haze, 11, 0), 4);
    EXPECT_EQ(scale_of(inside, haze, 10, 0), 2);
    EXPECT_EQ(scale_of(inside, haze, 0, 0), 2);
    EXPECT_EQ(scale_of(inside, haze, kNowhere, 0.72), 4);
    EXPECT_EQ(scale_of(inside, haze, kNowhere, 0.73), 2);
}

TEST(LayerScale, IsHalfWhereAnOutlineIsInThePicture)
{
    const Bounds block{{-3, 0, -3}, {3, 6, 3}};
    EXPECT_EQ(scale_of(street({0, -2, 0}), block, kNowhere, 0), 4) << "its face fills the picture";
    EXPECT_EQ(scale_of(street({0, -9, 0}), block, kNowhere, 0), 2) << "its outline is in view";
    EXPECT_EQ(scale_of(street({0, 3, 0}), block, kNowhere, 0), 4) << "from within";
    Frame parallel = street({0, -20, 0});
    parallel.clip_from_view = glm::ortho(-2.0, 2.0, -1.0, 1.0, 0.1, 100.0);
    EXPECT_EQ(scale_of(parallel, block, kNowhere, 0.99), 4) << "one direction, one phase";
    parallel.clip_from_view = glm::ortho(-4.0, 4.0, -2.0, 2.0, 0.1, 100.0);
    EXPECT_EQ(scale_of(parallel, block, kNowhere, 0), 2);
}

}  // namespace
}  // namespace fumarole
