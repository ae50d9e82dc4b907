// The size that a march's layer takes by itself: where a quarter is chosen it is as good as half,
// and where something would be lost it is not chosen.

#include <cmath>
#include <fmt/format.h>

#include "image/image_test.h"
#include "study/metrics.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

class LayerSize : public ImageTest {
protected:
    /// Smoke and a sphere in it in a sun, `zoom` times as large as in a picture of 480 x 270: at 4
    /// the middle of one of 1920 x 1080.
    static Scene smoke(double zoom)
    {
        Scene scene = asset::load_scene(std::string(FUM_TEST_DATA) + "/smoke_plume_sun.json").scene;
        scene.resolution = {320, 240};
        const double half = std::tan(glm::radians(scene.camera.vfov_deg) / 2) * 240 / 270;
        scene.camera.vfov_deg = 2 * glm::degrees(std::atan(half / zoom));
        return scene;
    }

    static Settings settings_of(int resolution)
    {
        Settings settings;
        settings.bounces = 0;
        settings.resolution = resolution;
        return settings;
    }

    static int chosen(const Scene& scene)
    {
        return scene_renderer().settled(scene, settings_of(Settings::kAutomatic)).resolution;
    }

    /// The composite's relMSE to what a ray for each pixel and many steps make of it.
    static double error(const Scene& scene, int resolution)
    {
        Settings fine = settings_of(1);
        fine.steps = 256;
        fine.spacing = Settings::Spacing::fixed;
        fine.jitter = Settings::Jitter::none;
        const Still exact = render(scene, fine);
        const Still still = render(scene, settings_of(resolution));
        return study::compare(still.composite, exact.composite).relmse;
    }

    static GridMedium& grid_of(Scene& scene) { return std::get<GridMedium>(scene.media[0]); }
};

// Smoke fills the picture here. Of the whole one, which is mostly sky, both errors are a third.
TEST_F(LayerSize, IsAQuarterWhereThatErrsLittleMoreThanHalf)
{
    const Scene scene = smoke(4);
    ASSERT_EQ(chosen(scene), 4);
    const double quarter = error(scene, Settings::kAutomatic), half = error(scene, 2);
    figure("a quarter", quarter);
    figure("half", half);
    EXPECT_EQ(quarter, error(scene, 4));
    EXPECT_LT(quarter, 4e-4);
    EXPECT_LT(quarter, 2.5 * half);

    StillReport few, many;
    scene_renderer().render(scene, settings_of(Settings::kAutomatic), {}, &few);
    scene_renderer().render(scene, settings_of(2), {}, &many);
    EXPECT_LT(few.samples, 0.3 * many.samples);
}

TEST_F(LayerSize, IsHalfWhereAQuarterWouldLoseWhatTheGridHolds)
{
    const Scene scene = smoke(2);
    EXPECT_EQ(chosen(scene), 2) << "a texel is 1.5 voxels wide";
    const double quarter = error(scene, 4), half = error(scene, 2);
    figure("a quarter", quarter);
    figure("half", half);
    EXPECT_GT(quarter, 5 * half) << "the limit may be wider";
}

TEST_F(LayerSize, IsHalfWhereAVoxelHidesWhatIsBehind)
{
    Scene scene = smoke(4);
    grid_of(scene).sigma_s_per_density *= 10.0f;
    EXPECT_EQ(chosen(scene), 2);
    scene = smoke(30);
    grid_of(scene).sigma_s_per_density *= 10.0f;
    EXPECT_EQ(chosen(scene), 4) << "a texel is a tenth of a voxel";
}

TEST_F(LayerSize, IsHalfWhereWhatGlowsIsFiner)
{
    Scene scene = asset::load_scene(std::string(FUM_TEST_DATA) + "/fire_plume.json").scene;
    std::erase_if(scene.lights, [](const Light& light) { return !std::get_if<SunLight>(&light); });
    scene.resolution = {1920, 1080};
    EXPECT_EQ(chosen(scene), 2) << "flames end within half a voxel";
    grid_of(scene).emission = nullptr;
    EXPECT_EQ(chosen(scene), 4) << "smoke alone";
}

TEST_F(LayerSize, IsHalfWhereABeamHasAnEdge)
{
    const auto lit = [](double cone_deg, double blend, glm::dvec3 position) {
        Scene scene = smoke(4);
        SpotLight spot;
        spot.position = position;
        spot.direction = glm::normalize(glm::dvec3(0, 0, 2.5) - position);
        spot.cone_deg = cone_deg;
        spot.blend = blend;
        spot.radiant_intensity = glm::vec3(50);
        scene.lights = {spot};
        return chosen(scene);
    };
    EXPECT_EQ(lit(50, 0.5, {8, -6, 7}), 4) << "it fades over 0.7 m";
    EXPECT_EQ(lit(4, 0.5, {8, -6, 7}), 2) << "a thin beam";
    EXPECT_EQ(lit(50, 0.02, {8, -6, 7}), 2) << "a hard edge";
    EXPECT_EQ(lit(50, 0.5, {0, 0, 4}), 2) << "from amid the smoke";
}

TEST_F(LayerSize, IsHalfWhereAnAreaShinesAmidAGrid)
{
    Scene scene = smoke(4);
    DiskLight disk;
    disk.radius = 0.1;
    disk.center = {1, -0.8, 3.5};
    scene.lights = {disk};
    EXPECT_EQ(chosen(scene), 2);
    disk.center = {1, -6, 6};
    scene.lights = {disk};
    EXPECT_EQ(chosen(scene), 4) << "from without";
}

TEST_F(LayerSize, IsHalfWhereABoxEndsBesideAGrid)
{
    Scene scene = smoke(4);
    BoxMedium haze;
    haze.min = {-8, -3, 0};
    haze.max = {8, 3, 4};
    haze.sigma_s = glm::vec3(0.01f);
    scene.media.emplace_back(haze);
    EXPECT_EQ(chosen(scene), 2);
}

}  // namespace
}  // namespace fumarole::test
