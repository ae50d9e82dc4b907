// Parts of a picture hold each pixel of it once, with the margins that look-ups need, and begin
// where what repeats over the picture does.

#include "picture_parts.h"

#include <gtest/gtest.h>

namespace fumarole {
namespace {

constexpr glm::ivec2 kWhole(1000, 701);
constexpr PictureRegion kAll{0, 0, 1000, 701};

FrameSettings settings_of(FrameSettings::Mode mode, int resolution, int tile)
{
    FrameSettings settings;
    settings.mode = mode;
    settings.resolution = resolution;
    settings.tile = tile;
    return settings;
}

const std::vector<FrameSettings> kKinds{settings_of(FrameSettings::Mode::raymarch, 1, 8),
                                        settings_of(FrameSettings::Mode::raymarch, 2, 8),
                                        settings_of(FrameSettings::Mode::raymarch, 4, 8),
                                        settings_of(FrameSettings::Mode::froxel, 1, 8),
                                        settings_of(FrameSettings::Mode::froxel, 1, 5),
                                        settings_of(FrameSettings::Mode::froxel, 1, 64)};

TEST(PictureParts, ASmallPictureIsOne)
{
    for (const FrameSettings& settings : kKinds) {
        const PicturePart all{{0, 0}, kWhole, {0, 0}, kWhole};
        EXPECT_EQ(picture_parts(kWhole, kAll, 1000, settings), std::vector<PicturePart>{all});
    }
}

TEST(PictureParts, HoldEachPixelOnceAndTheirMargins)
{
    const PictureRegion inner{333, 50, 421, 470};
    for (const FrameSettings& settings : kKinds)
        for (const PictureRegion& region : {kAll, inner}) {
            const bool march = settings.mode == FrameSettings::Mode::raymarch;
            const int repeats = march ? 64 * settings.resolution : settings.tile;
            const int margin = 4 * (march ? settings.resolution : settings.tile);
            std::vector<int> held(static_cast<std::size_t>(kWhole.x * kWhole.y));
            const std::vector<PicturePart> parts = picture_parts(kWhole, region, 512, settings);
            EXPECT_GT(parts.size(), region == kAll ? 2u : 0u);
            for (const PicturePart& part : parts)
                for (int axis = 0; axis < 2; ++axis) {
                    EXPECT_EQ(part.origin[axis] % repeats, 0);
                    EXPECT_LE(part.size[axis], 640);  // or more where a margin would not fit
                    const int before = part.keep_origin[axis];
                    const int after = part.size[axis] - before - part.keep_size[axis];
                    EXPECT_GT(part.keep_size[axis], 0);
                    EXPECT_TRUE(before >= margin || part.origin[axis] == 0) << before;
                    EXPECT_TRUE(after >= margin ||
                                part.origin[axis] + part.size[axis] == kWhole[axis])
                        << after;
                    EXPECT_LE(part.origin[axis] + part.size[axis], kWhole[axis]);
                }
            for (const PicturePart& part : parts)
                for (int y = 0; y < part.keep_size.y; ++y)
                    for (int x = 0; x < part.keep_size.x; ++x) {
                        const glm::ivec2 at = part.origin + part.keep_origin + glm::ivec2(x, y);
                        ++held[static_cast<std::size_t>(at.y * kWhole.x + at.x)];
                    }
            for (int y = 0; y < kWhole.y; ++y)
                for (int x = 0; x < kWhole.x; ++x) {
                    const int from_top = kWhole.y - 1 - y;
                    const bool in = x >= region.x && x < region.x + region.width &&
                                    from_top >= region.y && from_top < region.y + region.height;
                    ASSERT_EQ(held[static_cast<std::size_t>(y * kWhole.x + x)], in ? 1 : 0)
                        << x << ' ' << y;
                }
        }
}

TEST(PictureParts, AProjectionOfAPartPutsPointsWhereTheWholeDoes)
{
    const Camera camera{.position = {0, 0, 0}, .look_at = {0, 0, -1}, .up = {0, 1, 0}};
    const glm::dmat4 whole = clip_from_view(camera, glm::uvec2(kWhole), {0.25, -0.125});
    const PicturePart part{{256, 128}, {300, 200}, {10, 10}, {280, 180}};
    const glm::dmat4 of_part = clip_of_part(whole, kWhole, part);
    const auto pixel = [](const glm::dmat4& clip, glm::dvec4 p, glm::ivec2 size) {
        const glm::dvec4 h = clip * p;
        return (glm::dvec2(h) / h.w * 0.5 + 0.5) * glm::dvec2(size);
    };
    for (const glm::dvec4& p : {glm::dvec4(0, 0, -3, 1), {0.2, -0.4, -1, 1}, {-5, 3, -20, 1}}) {
        const glm::dvec2 difference =
            pixel(whole, p, kWhole) - (pixel(of_part, p, part.size) + glm::dvec2(part.origin));
        EXPECT_LT(glm::length(difference), 1e-9);
    }
}

}  // namespace
}  // namespace fumarole
