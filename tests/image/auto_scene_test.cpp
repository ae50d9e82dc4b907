// The picture of a bare .vdb that is wide and low: its ground ends at the horizon, in a straight
// line from side to side, and nothing shows of the box that the medium fills.

#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "image_test.h"
#include <fumarole/asset/auto_scene.h>

namespace fumarole::test {
namespace {

class AutoScene : public ImageTest {};

TEST_F(AutoScene, GroundOfAWideMediumEndsOutOfSight)
{
    for (const glm::ivec3 bricks : {glm::ivec3(40, 2, 40), glm::ivec3(60, 2, 4)}) {
        const auto grid =
            make_grid(bricks, glm::scale(glm::dmat4(1.0), glm::dvec3(40)), [](glm::ivec3 v) {
                return 1 + 0.5 * std::sin(v.x * 0.2) * std::cos(v.z * 0.3);
            });
        const Scene scene = asset::frame_grids(grid, nullptr, 'y', {240, 135}).scene;
        Settings settings;
        settings.bounces = 0;
        settings.format = Settings::Format::rgba32f;
        const Still still = render(scene, settings);
        const auto at = [&](const std::vector<float>& picture, int x, int y, int channels) {
            return double{picture[static_cast<std::size_t>((y * 240 + x) * channels)]};
        };
        int horizon = 0;
        while (horizon < 135 && at(still.depth, 0, horizon, 1) == double{Still::kSkyDepth})
            ++horizon;
        ASSERT_GT(horizon, 5);
        ASSERT_LT(horizon, 60);
        const double ground = at(still.surface_lit, 0, 134, 3);
        ASSERT_GT(ground, 0);
        for (int y = 0; y < 135; ++y)
            for (int x = 0; x < 240; ++x) {
                ASSERT_EQ(at(still.depth, x, y, 1) == double{Still::kSkyDepth}, y < horizon)
                    << x << ", " << y << ": ground from row " << horizon << " on";
                // In the medium's shadow the sky alone lights the ground.
                ASSERT_GT(at(still.composite, x, y, 3), 0.02 * ground) << x << ", " << y;
                // Far from the medium the ground is as it is anywhere.
                if (y == horizon || y == 134) {
                    ASSERT_NEAR(at(still.composite, x, y, 3), at(still.composite, 0, y, 3),
                                0.02 * ground)
                        << x << ", " << y;
                }
            }
    }
}

}  // namespace
}  // namespace fumarole::test
