#include "support/gl_test.h"
namespace fumarole::test {
TEST_F(GlTest, EmptySceneDraws)
{
    EXPECT_EQ(render(empty_scene(), Settings{}).width, 32);
}
}  // namespace fumarole::test
