#include "prepared_frame.h"

#include <gtest/gtest.h>

#include <cmath>
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

FrameScene grid_scene(double voxel)
{
    return {.media = {{-2, -2, -2}, {2, 2, 2}}, .voxel = voxel, .has_outline = false};
}

/// 50 degrees high from 10 m: 2.9 mm a pixel and metre in a picture of 270 lines.
LayerChoice choice_of(const FrameScene& scene, glm::uvec2 size = {480, 270}, double distance = 10)
{
    Frame frame = street({0, -distance, 0});
    frame.color.size = {size, 1};
    return prepare_frame(frame, Settings{}, scene).layer_choice;
}

TEST(LayerScale, IsAQuarterWhereATexelIsFinerThanAGridsVoxels)
{
    // At the far end, 12 m, a texel of four pixels is 0.166 m wide.
    const double texel = 12 * 4 * 2 * std::tan(glm::radians(25.0)) / 270;
    const LayerChoice coarse = choice_of(grid_scene(texel / 0.79));
    EXPECT_EQ(coarse.scale, 4);
    EXPECT_EQ(coarse.reason, LayerReason::smooth);
    EXPECT_NEAR(coarse.of_voxel, 0.79, 1e-9);
    const LayerChoice fine = choice_of(grid_scene(texel / 0.81));
    EXPECT_EQ(fine.scale, 2);
    EXPECT_EQ(fine.reason, LayerReason::voxels);
    EXPECT_EQ(choice_of(grid_scene(texel / 0.81), {1920, 1080}).scale, 4) << "a larger picture";
    EXPECT_EQ(choice_of(grid_scene(texel / 0.79), {480, 270}, 12).scale, 2) << "from farther off";
}

TEST(LayerScale, StaysHalfUntilAQuarterIsATenthWithin)
{
    const double texel = 12 * 4 * 2 * std::tan(glm::radians(25.0)) / 270;
    const auto after = [&](int before, double of_voxel) {
        Frame frame = street({0, -10, 0});
        frame.color.size = {480, 270, 1};
        return prepare_frame(frame, Settings{}, grid_scene(texel / of_voxel), {.scale = before})
            .layer_choice;
    };
    EXPECT_EQ(after(2, 0.79).scale, 2);
    EXPECT_EQ(after(2, 0.79).reason, LayerReason::held);
    EXPECT_EQ(after(2, 0.73).scale, 2);
    EXPECT_EQ(after(2, 0.71).scale, 4);
    EXPECT_EQ(after(2, 0.71).reason, LayerReason::smooth);
    EXPECT_EQ(after(4, 0.79).scale, 4);
    EXPECT_EQ(after(4, 0.81).reason, LayerReason::voxels) << "it loses no more than without";
    EXPECT_EQ(after(0, 0.79).scale, 4) << "a first frame";
}

TEST(LayerScale, IsHalfBesideAGridWhereSomethingElseIsFine)
{
    FrameScene scene = grid_scene(1);
    ASSERT_EQ(choice_of(scene).scale, 4);
    const auto reason = [&](FrameScene changed) {
        const LayerChoice choice = choice_of(changed);
        EXPECT_EQ(choice.scale, choice.reason == LayerReason::smooth ? 4 : 2);
        return choice.reason;
    };
    FrameScene beam = scene;
    beam.beam_edge = 1.6;  // of ten texels
    EXPECT_EQ(reason(beam), LayerReason::beam);
    beam.beam_edge = 1.7;
    EXPECT_EQ(reason(beam), LayerReason::smooth);
    beam.beam_edge = 0;
    EXPECT_EQ(reason(beam), LayerReason::beam);
    FrameScene noise = scene;
    noise.detail = 0.6;  // four texels are 0.66 m
    EXPECT_EQ(reason(noise), LayerReason::profile);
    FrameScene box = scene;
    box.has_outline = true;
    EXPECT_EQ(reason(box), LayerReason::outline);
    FrameScene forward = scene;
    forward.most_g = 0.9;
    EXPECT_EQ(reason(forward), LayerReason::lobe);

    Settings settings;
    settings.temporal = true;
    const Frame frame = street({0, -10, 0});
    EXPECT_EQ(prepare_frame(frame, settings, scene, {.keeps_history = true}).layer_choice.reason,
              LayerReason::history);
    settings = {};
    settings.resolution = 4;
    EXPECT_EQ(prepare_frame(frame, settings, scene).layer_choice.scale, 0) << "it was asked for";
}

}  // namespace
}  // namespace fumarole
