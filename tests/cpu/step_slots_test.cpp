#include "pass/step_slots.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "prepared_frame.h"

namespace fumarole::pass {
namespace {

/// A texel as glsl/pass/ray_march.glsl reads it.
struct Tile {
    glm::uvec4 texel;

    [[nodiscard]] int slot_of(int split) const
    {
        return (split - static_cast<int>(texel.w & 0xfffu)) >> (texel.w >> 12 & 15);
    }
    [[nodiscard]] bool bit(std::uint32_t bits, int split) const
    {
        const int slot = slot_of(split);
        return slot >= 0 && slot < 31 && (bits >> slot & 1) != 0;
    }
    [[nodiscard]] bool marched(int split) const { return bit(texel.x, split); }
    [[nodiscard]] int stride(int split) const
    {
        return bit(texel.y, split) ? 4 : bit(texel.z, split) ? 2 : 1;
    }
};

class StepTile : public testing::Test {
protected:
    StepTile()
    {
        frame_.color.size = {480, 270, 1};
        frame_.view_from_world = glm::lookAt(glm::dvec3(0), {0, 1, 0}, {0, 0, 1});
        frame_.clip_from_view = glm::perspective(glm::radians(50.0), 480.0 / 270, 0.1, 400.0);
    }
    [[nodiscard]] PreparedFrame frame(int steps)
    {
        settings_.steps = steps;
        return prepare_frame(frame_, settings_, {.media = {{-3, 2, -3}, {3, 60, 3}}});
    }

    Frame frame_;
    Settings settings_;
    std::mt19937_64 random_{7};
};

// What holds something is marched, steps of two and four begin where a ray that walks by them comes
// to lie, and none is longer than it may be.
TEST_F(StepTile, HoldsAllAndJoinsNoMoreThanIsAllowed)
{
    std::uniform_real_distribution<double> unit(0, 1);
    int joined = 0;
    for (const int steps : {1, 6, 48, 50, 65, 100, 257, 4096})
        for (int i = 0; i < 300; ++i) {
            const PreparedFrame pass = frame(steps);
            const StepSlots slots(pass);
            const int width = (steps + slots.count() - 1) / slots.count();
            StepSlots::Held held;
            held.slots = random_() & random_() & slots.all();
            held.shafts = random_() & random_() & slots.all();
            held.longest = 8 * unit(random_) * 58 / steps;
            held.longest_in_shaft = held.longest * unit(random_);
            held.lit = i % 2 == 0;
            if (held.slots == 0)
                continue;
            const Tile tile{slots.tile(held)};
            EXPECT_EQ(StepSlots::is_lit(tile.texel), held.lit);
            for (int split = 0; split < steps; ++split) {
                const int slot = split / std::max(width, 1);
                const bool holds = (held.slots >> slot & 1) != 0;
                ASSERT_TRUE(tile.marched(split) || !holds) << steps << " steps, split " << split;
                const int stride = tile.marched(split) ? tile.stride(split) : 1;
                if (stride == 1)
                    continue;
                ++joined;
                const int first = split & -stride, last = std::min(first + stride, steps);
                EXPECT_EQ(tile.slot_of(first), tile.slot_of(last - 1));
                EXPECT_EQ(tile.stride(first), stride);
                // Splits grow with depth, by little within a slot.
                const double length = (slots.begin(slot + 1) - slots.begin(slot)) / width * stride;
                const bool shaft = (held.shafts >> slot & 1) != 0;
                const double longest = shaft ? held.longest_in_shaft : held.longest;
                EXPECT_TRUE(!holds || length <= 1.5 * longest) << steps << ' ' << split;
            }
        }
    EXPECT_GT(joined, 1000) << "or nothing was looked at";
}

TEST_F(StepTile, JoinsAllWhereNothingIsInTheWayAndNothingUnasked)
{
    const PreparedFrame pass = frame(48);
    const StepSlots slots(pass);
    const Tile plain{slots.tile({.slots = slots.all()})};
    const Tile free{slots.tile({.slots = slots.all(), .longest = 1e9, .longest_in_shaft = 0})};
    const Tile shaded{
        slots.tile({.slots = slots.all(), .shafts = 0xf00, .longest = 1e9, .longest_in_shaft = 0})};
    for (int split = 0; split < 48; ++split) {
        EXPECT_EQ(plain.stride(split), 1);
        EXPECT_EQ(free.stride(split), 4);
        EXPECT_EQ(shaded.stride(split), split >= 8 && split < 12 ? 1 : 4) << split;
    }
}

}  // namespace
}  // namespace fumarole::pass
