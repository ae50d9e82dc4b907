// The preset eevee2017 keeps the faults of 2017, which are documented, so they are pinned too.

#include <cmath>
#include <fmt/format.h>

#include "image_test.h"

namespace fumarole::test {
namespace {

class Eevee2017 : public ImageTest {
protected:
    static Settings preset(Settings::Format format = Settings::Format::rgba32f)
    {
        Settings settings = find_preset("eevee2017");
        settings.format = format;
        settings.shadow_map = 256;
        return settings;
    }
    static double split(double progress, double near, double far)
    {
        return 0.8 * near * std::pow(far / near, progress) + 0.2 * (near + (far - near) * progress);
    }
};

// A floor under the extinction, everywhere from the near to the far plane: empty air dims the sky.
TEST_F(Eevee2017, EmptySpaceHasAFloorOfExtinction)
{
    Scene scene = empty_scene(16);
    scene.camera.near = 0.1;
    scene.camera.far = 500;
    scene.world.radiance = glm::vec3(1);
    BoxMedium behind;  // with no medium at all nothing is drawn
    behind.min = {-1, 5, -1};
    behind.max = {1, 6, 1};
    behind.sigma_a = glm::vec3(1);
    scene.media = {behind};
    const Still still = render(scene, preset());
    for (const int at : {1, 8, 14}) {
        const double slant = ray_of(scene, at, at).length_per_z;
        // 64 steps that end at (i + 1/2 + jitter) / 64: the last one somewhere in 63.5 / 64 to
        // 64.5 / 64, which for the sky lies up to half a step past the far plane.
        const float t = pixel(still.transmittance, 16, at, at).g;
        EXPECT_LE(t, std::exp(-1e-4 * (split(63.5 / 64, 0.1, 500) - 0.1) * 0.99 * slant));
        EXPECT_GE(t, std::exp(-1e-4 * (split(64.5 / 64, 0.1, 500) - 0.1) * 1.01 * slant));
    }
    for (const float s : still.scattering)
        ASSERT_EQ(s, 0.0f) << "and what it takes it does not give back";

    const Still now = render(scene, Settings{});
    EXPECT_EQ(now.composite, now.surface) << "the default preset leaves empty space alone";
}

// It marches past the scene's depth to the end of that step: up to one step too much fog.
TEST_F(Eevee2017, OvershootsTheScenesDepthByAStepAtMost)
{
    Scene scene = empty_scene(16);
    scene.camera.near = 0.1;
    scene.camera.far = 100;
    BoxMedium fog;
    fog.min = {-60, -60, -60};
    fog.max = {60, 2, 60};
    fog.sigma_a = glm::vec3(0.1f);
    scene.media = {fog};
    scene.surfaces = {BoxSurface{{-40, -12, -40}, {40, -10, 40}, glm::vec3(1)}};
    const Still still = render(scene, preset());
    Settings exact = plain_settings();
    const Still now = render(scene, exact);
    double step = 0;  // the longest that may hold 10 m: two of the lattice, by the half-step jitter
    for (int i = 0; i < 63; ++i)
        if (split(i / 64.0, 0.1, 100) < 10)
            step = split((i + 1.5) / 64.0, 0.1, 100) - split((i - 0.5) / 64.0, 0.1, 100);
    double mean = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const double slant = ray_of(scene, x, y).length_per_z;
            const double extra = -std::log(pixel(still.transmittance, 16, x, y).r /
                                           pixel(now.transmittance, 16, x, y).r) /
                                 (0.1 * slant);
            EXPECT_GT(extra, -0.02) << "metres too short at " << x << ", " << y;
            EXPECT_LT(extra, step) << "metres too far at " << x << ", " << y;
            mean += extra / 256;
        }
    figure("mean overshoot at 10 m [m]", mean);
    EXPECT_GT(mean, 0.1 * step) << "the fault of 2017 is to be there";
}

TEST_F(Eevee2017, StaysNearTheTruthInUniformFog)
{
    Scene scene = empty_scene(16);
    scene.camera.vfov_deg = 40;
    scene.camera.near = 0.1;
    scene.camera.far = 30;
    scene.world.radiance = glm::vec3(1);
    BoxMedium fog;
    fog.min = {-60, -6, -60};
    fog.max = {60, -4, 60};
    fog.sigma_s = {0.2f, 0.4f, 0.8f};
    scene.media = {fog};
    const Still still = render(scene, preset(Settings::Format::r11g11b10f));
    double error = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x)
            for (int c = 0; c < 3; ++c) {
                const PixelRay ray = ray_of(scene, x, y);
                const double truth =
                    std::exp(-double(fog.sigma_s[c]) * box_segment(ray, fog.min, fog.max).length());
                const double t = pixel(still.transmittance, 16, x, y)[c];
                error += (t - truth) / 768;
                EXPECT_NEAR(t, truth, 0.1) << "steps of 0.4 m that are in or out of 2 m as a whole";
            }
    figure("bias of transmittance", error);
    EXPECT_LT(std::abs(error), 0.03);
}

TEST_F(Eevee2017, IsWhatItsDocumentSays)
{
    const Settings s = find_preset("eevee2017");
    EXPECT_EQ(s.steps, 64);
    EXPECT_EQ(s.distribution, 0.8f);
    EXPECT_EQ(s.shadow_steps, 16);
    EXPECT_EQ(s.resolution, 2);
    EXPECT_EQ(s.bounces, 0);
    EXPECT_EQ(s.min_extinction, 1e-4f);
    EXPECT_EQ(s.format, Settings::Format::r11g11b10f);
    EXPECT_EQ(s.targets, Settings::Targets::two);
    EXPECT_EQ(find_preset("default"), Settings{});
    const Settings f = find_preset("eevee2017-froxel");
    EXPECT_EQ(f.mode, Settings::Mode::froxel);
    EXPECT_EQ(f.tile, 8);
    EXPECT_EQ(f.slices, 64);
    EXPECT_EQ(f.distribution, 0.8f);
    EXPECT_EQ(f.slice_spacing, Settings::SliceSpacing::exponential);
    EXPECT_EQ(f.history, 0.95f);
    EXPECT_EQ(f.range, Settings::Range::camera);
    EXPECT_EQ(f.format, Settings::Format::r11g11b10f);
    EXPECT_EQ(f.froxel_shadows, Settings::FroxelShadows::grid);
}

}  // namespace
}  // namespace fumarole::test
