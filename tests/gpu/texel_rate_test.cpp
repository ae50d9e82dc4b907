#include "study/texel_rate.h"

#include <cmath>
#include <gtest/gtest.h>

#include "support/gl_test.h"

namespace fumarole::test {
namespace {

class TexelRateTest : public GlTest {};

TEST_F(TexelRateTest, IsARateAndLeavesNothingBound)
{
    for (const bool computes : {false, true}) {
        study::TexelRate rate(gl(), computes);
        for (int i = 0; i < 2; ++i) {
            const double texels_a_second = rate.measure();
            EXPECT_GT(texels_a_second, 0);
            EXPECT_TRUE(std::isfinite(texels_a_second));
        }
        GLint framebuffer = -1, program = -1;
        gl()->GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
        gl()->GetIntegerv(GL_CURRENT_PROGRAM, &program);
        EXPECT_EQ(framebuffer, 0);
        EXPECT_EQ(program, 0);
    }
}

}  // namespace
}  // namespace fumarole::test
