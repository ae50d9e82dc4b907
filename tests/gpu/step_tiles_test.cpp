// The tiles that the march, the layer's depth and the resolve run over: what compute shaders make
// of the media's boxes is what the CPU makes of them, to the bit.

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>

#include "gl/state_guard.h"
#include "pass/step_tiles.h"
#include "study/stability_bench.h"
#include "support/tile_bench.h"

namespace fumarole::test {
namespace {

using namespace fumarole::shared;
using Passes = Settings::Passes;
using Texels = TileBench::Texels;

class StepTilesByCompute : public GlTest {
protected:
    StepTilesByCompute() : guard_{gl(), BLOCK_COUNT, IMAGE_COUNT, STORAGE_COUNT}, bench_{gl()} {}

    PreparedFrame prepare(const Scene& scene, FrameSettings settings, Passes passes,
                          glm::dvec2 layer_offset) const
    {
        settings.passes = passes;
        return bench_.prepare(scene, settings, layer_offset);
    }

    std::array<Texels, 3> tiles(pass::StepTiles& tiles, const PreparedFrame& frame) const
    {
        bench_.tools.bind_block(frame);
        tiles.set(frame);
        std::array<Texels, 3> all;
        for (std::size_t i = 0; i < all.size(); ++i)
            all.at(i) = bench_.read(*tiles.textures().at(i));
        return all;
    }

    const gl::StateGuard guard_;
    TileBench bench_;
};

/// Sparse smoke turned and sheared, a lump elsewhere, a slab of fog, by seed.
Scene random_media(std::mt19937& engine)
{
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&] {
        return glm::dvec3(uniform(engine), uniform(engine), uniform(engine));
    };
    Scene scene = empty_scene();
    for (int i = 0; i < 2; ++i) {
        GridMedium smoke;
        glm::dmat4 world_from_index(1.0);
        for (int axis = 0; axis < 3; ++axis)
            world_from_index[axis] =
                glm::dvec4(0.05 * vector() + 0.1 * glm::dvec3(axis == 0, axis == 1, axis == 2), 0);
        world_from_index[3] = glm::dvec4(3.0 * vector() + glm::dvec3(-1, -8, -1), 1);
        const auto phase = vector();
        smoke.density = study::make_grid({4, 3, 3}, world_from_index, [&](glm::ivec3 at) {
            const glm::dvec3 waves = glm::sin(glm::dvec3(at) * 0.35 + phase * 3.0);
            return std::max(0.0, waves.x * waves.y + waves.z - 0.9);
        });
        smoke.sigma_s_per_density = glm::vec3(1.5f + static_cast<float>(uniform(engine)));
        scene.media.emplace_back(smoke);
    }
    if (uniform(engine) > 0) {
        BoxMedium fog;
        fog.min = 2.0 * vector() + glm::dvec3(-3, -9, -3);
        fog.max = fog.min + glm::dvec3(3, 2, 1);
        fog.sigma_s = glm::vec3(0.01f);
        scene.media.emplace_back(fog);
    }
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 3, 3}}};
    if (uniform(engine) > 0)
        for (int i = 0; i < 3; ++i)
            scene.lights.emplace_back(PointLight{6.0 * vector() + glm::dvec3(0, -6, 0), {1, 1, 1}});
    return scene;
}

struct Look {
    const char* name;
    Camera camera;
};

std::vector<Look> looks(std::mt19937& engine)
{
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto at = [&](glm::dvec3 from, glm::dvec3 to) {
        Camera camera;
        camera.position = from;
        camera.look_at = to + 0.5 * glm::dvec3(uniform(engine), uniform(engine), uniform(engine));
        camera.vfov_deg = 50 + 25 * uniform(engine);
        return camera;
    };
    std::vector<Look> all{{"outside", at({0, 4, 1}, {0, -8, 0})},
                          {"inside", at({0, -8, 0}, {1, -12, 0})},
                          {"turned away", at({0, -4, 0}, {0, 10, 0})},
                          {"parallel", at({2, 3, 1}, {0, -8, 0})},
                          {"far away", at({0, 1e3, 0}, {0, -8, 0})}};
    all[3].camera.projection = Camera::Projection::orthographic;
    all[3].camera.ortho_height = 6;
    all[4].camera.vfov_deg = 1;
    return all;
}

TEST_F(StepTilesByCompute, AreTheTilesOfTheCpu)
{
    constexpr int kSeeds = 10;
    // A GPU's division of doubles may be off in the last places, as OpenGL promises no more.
    const double may_differ = is_software() ? 0 : 1e-3;
    pass::StepTiles on_cpu(bench_.tools), on_gpu(bench_.tools);
    std::size_t marched = 0, empty = 0, joined = 0, lit = 0, far = 0, asked = 0, unasked = 0;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
        std::mt19937 engine(seed);
        Scene scene = random_media(engine);
        // In the light, and out of anything's shadow.
        if (seed % 3 == 0)
            scene.surfaces = {BoxSurface{{-9, -20, -90}, {9, 0, -80}, {0.5f, 0.4f, 0.3f}},
                              BoxSurface{{-9, -20, -85}, {9, 0, -75}, {0.5f, 0.4f, 0.3f}}};
        bench_.set(scene);
        ASSERT_EQ(bench_.lights.shaded_media(), false);
        for (const Look& look : looks(engine))
            for (const int resolution : {1, 2, 4}) {
                scene.camera = look.camera;
                scene.resolution = {157 + 31 * seed, 93};
                Settings settings;
                settings.resolution = resolution;
                settings.steps = std::array{16, 48, 200}.at((seed + resolution) % 3);
                settings.upsample =
                    seed % 2 == 0 ? Settings::Upsample::bilinear2x2 : Settings::Upsample::tent4x4;
                settings.spacing =
                    seed % 5 == 4 ? Settings::Spacing::fixed : Settings::Spacing::medium;
                const glm::dvec2 offset(0.1 * seed - 0.5, 0.3);
                const PreparedFrame frame = prepare(scene, settings, Passes::fragment, offset);
                const PreparedFrame computed = prepare(scene, settings, Passes::compute, offset);
                if (!frame.sees_media)
                    continue;
                const auto wanted = tiles(on_cpu, frame), found = tiles(on_gpu, computed);
                EXPECT_FALSE(on_cpu.on_gpu());
                EXPECT_TRUE(on_gpu.on_gpu());
                for (std::size_t k = 0; k < wanted.size(); ++k) {
                    ASSERT_EQ(found.at(k).size(), wanted.at(k).size());
                    std::size_t differ = 0;
                    for (std::size_t i = 0; i < wanted.at(k).size(); ++i)
                        differ += found.at(k)[i] == wanted.at(k)[i] ? 0 : 1;
                    EXPECT_LE(static_cast<double>(differ),
                              may_differ * static_cast<double>(wanted.at(k).size()))
                        << std::array{"march", "depth", "picture"}.at(k) << ", seed " << seed
                        << ", " << look.name << ", resolution " << resolution << ": " << differ
                        << " of " << wanted.at(k).size();
                }
                for (const glm::uvec4& tile : found[0]) {
                    (tile.x != 0 ? marched : empty) += 1;
                    joined += (tile.y | tile.z) != 0 ? 1 : 0;
                    lit += tile.x != 0 && tile_is_lit(tile.w) ? 1 : 0;
                    far += tile_is_far(tile.w) ? 1 : 0;
                }
                for (const glm::uvec4& tile : found[1])
                    (tile.x != 0 ? asked : unasked) += 1;
            }
    }
    // Or all of it would say little.
    for (const std::size_t count : {marched, empty, joined, lit, far, asked, unasked})
        EXPECT_GT(count, 1000u);
    EXPECT_LT(lit, marched);
    EXPECT_LT(far, marched);
}

TEST_F(StepTilesByCompute, AreTheCpusWhereItAloneKnows)
{
    std::mt19937 engine(2);
    Scene scene = random_media(engine);
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 3, 3}}};
    bench_.set(scene);
    pass::StepTiles tiles(bench_.tools);
    Settings settings;
    settings.resolution = 2;
    scene.camera = looks(engine)[0].camera;
    PreparedFrame frame = prepare(scene, settings, Passes::compute, {0, 0});
    bench_.tools.bind_block(frame);
    tiles.set(frame);
    EXPECT_TRUE(tiles.on_gpu());
    frame.depths_asked = {{10.0f}, {{{0, 0}, {20, 20}}}};
    tiles.set(frame);
    EXPECT_FALSE(tiles.on_gpu()) << "which tiles keep depths";
    frame.depths_asked = {};
    scene.surfaces = {BoxSurface{{-30, -40, 8}, {30, 30, 9}, {0.5f, 0.4f, 0.3f}}};
    bench_.set(scene);
    ASSERT_TRUE(bench_.lights.shaded_media());
    tiles.set(frame);
    EXPECT_FALSE(tiles.on_gpu()) << "where shadows end";
}

}  // namespace
}  // namespace fumarole::test
