#include "study/texel_rate.h"

#include <gtest/gtest.h>

#include "support/gl_test.h"

namespace fumarole::test {
namespace {

class TexelRateTest : public GlTest {};

TEST_F(TexelRateTest, IsAboutTheSameTwiceAndLeavesNothingBound)
{
    for (const bool computes : {false, true}) {
        study::TexelRate rate(gl(), computes);
        const double first = rate.measure(), second = rate.measure();
        // From a busy core to a large GPU.
        EXPECT_GT(first, 1e6);
        EXPECT_LT(first, 1e14);
        EXPECT_LT(std::max(first, second) / std::min(first, second), 20);
        GLint framebuffer = -1, program = -1;
        gl()->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
        gl()->GetIntegerv(GL_CURRENT_PROGRAM, &program);
        EXPECT_EQ(framebuffer, 0);
        EXPECT_EQ(program, 0);
    }
}

}  // namespace
}  // namespace fumarole::test
