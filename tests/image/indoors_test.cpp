// Haze in a room: what light of the world gets through its walls, which are thinner than the nodes
// of light's volumes are apart.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "image_test.h"
#include "study/metrics.h"

namespace fumarole::test {
namespace {

class Indoors : public ImageTest {
protected:
    static BoxSurface box(glm::dvec3 min, glm::dvec3 max)
    {
        BoxSurface one;
        one.min = min;
        one.max = max;
        one.albedo = glm::vec3(0.5f);
        return one;
    }

    /// 12 x 8 x 4 m, of walls of 0.2 m, on a wide ground, in haze that goes on outside. The world
    /// shines from all around.
    static Scene room(bool roof)
    {
        Scene scene;
        scene.resolution = {60, 45};
        scene.camera.position = {-5, -3, 1.6};
        scene.camera.look_at = {3, 2, 2.6};
        scene.camera.up = {0, 0, 1};
        scene.camera.vfov_deg = 70;
        scene.camera.near = 0.05;
        scene.camera.far = 500;
        scene.world.radiance = glm::vec3(0.5f);
        scene.surfaces = {box({-300, -300, -2}, {300, 300, 0}), box({-6.2, -4.2, 0}, {-6, 4.2, 4}),
                          box({6, -4.2, 0}, {6.2, 4.2, 4}), box({-6, 4, 0}, {6, 4.2, 4}),
                          box({-6, -4.2, 0}, {6, -4, 4})};
        if (roof)
            scene.surfaces.emplace_back(box({-6.2, -4.2, 4}, {6.2, 4.2, 4.2}));
        BoxMedium haze;
        haze.min = {-9, -7, 0};
        haze.max = {9, 7, 6};
        haze.sigma_s = glm::vec3(0.05f);
        haze.sigma_a = glm::vec3(0.005f);
        haze.g = 0.4f;
        scene.media = {haze};
        return scene;
    }

    /// The same under a roof with five gaps. @param x of the middle one
    static Scene gapped_room(double x)
    {
        Scene scene = room(false);
        double from = -6.2;
        for (int i = -2; i <= 3; ++i) {
            const double gap = x + 2 * i, to = i == 3 ? 6.2 : gap - 0.2;
            scene.surfaces.emplace_back(box({from, -4.2, 4}, {to, 4.2, 4.2}));
            from = gap + 0.2;
        }
        return scene;
    }

    static double mean(const std::vector<float>& picture)
    {
        double sum = 0;
        for (const float value : picture)
            sum += double{value};
        return sum / static_cast<double>(picture.size());
    }
};

TEST_F(Indoors, AClosedRoomIsDark)
{
    const Settings settings = plain_settings();
    const Still open = render(room(false), settings), closed = render(room(true), settings);
    ASSERT_GT(mean(open.surface_lit), 0.02);
    ASSERT_GT(mean(open.scattering), 0.002);
    // Light that came through the walls was 2 % of what an open room has on surfaces, and in the
    // haze 1.5 %: nodes in the dark counted as if they were inside of surfaces, which are left out
    // of a mean of eight, and those beyond a wall were taken for its other side.
    const double surfaces = mean(closed.surface_lit) / mean(open.surface_lit);
    const double haze = mean(closed.scattering) / mean(open.scattering);
    figure("on surfaces, of the open room's", surfaces);
    figure("in haze, of the open room's", haze);
    EXPECT_LT(surfaces, 0.001);
    EXPECT_LT(haze, 0.002);
}

TEST_F(Indoors, TheWallsOfAnOpenCourtAreLitAsFarFromItsNodes)
{
    // Of a wall that is half sunk in the lattice both sides are lit alike: its own side counts.
    Scene scene;
    scene.resolution = {48, 48};
    scene.camera.position = {0, -12, 3};
    scene.camera.look_at = {0, 0, 3};
    scene.camera.up = {0, 0, 1};
    scene.camera.vfov_deg = 20;
    scene.world.radiance = glm::vec3(0.5f);
    scene.surfaces = {box({-300, -300, -2}, {300, 300, 0}), box({-6, 0, 0}, {6, 0.2, 6})};
    BoxMedium clear;
    clear.min = {-9, -7, 0};
    clear.max = {9, 7, 6};
    clear.sigma_s = glm::vec3(1e-6f);
    scene.media = {clear};
    std::get<BoxSurface>(scene.surfaces[0]).albedo = glm::vec3(0);
    const Still still = render(scene, plain_settings());
    // Half of its hemisphere is the ground, which is black.
    const double expected = 0.5 * 0.5 * 0.5;
    double sum = 0;
    for (int y = 12; y < 36; ++y)
        for (int x = 12; x < 36; ++x)
            sum += double{still.surface_lit[static_cast<std::size_t>(3 * (y * 48 + x))]};
    figure("wall, of its closed form", sum / (24 * 24) / expected);
    EXPECT_NEAR(sum / (24 * 24), expected, 0.08 * expected);
}

// Haze that dims nothing under a roof of slabs, the sun above: a ray has light where it is under a
// gap, so its picture is known, and what else is seen is the grain of steps longer than gaps.
TEST_F(Indoors, LightThroughGapsHasLittleGrain)
{
    constexpr double kSlab = 1.2, kGap = 0.4, kPitch = kSlab + kGap, kEnd = 4.5 * kPitch;
    constexpr float kScatters = 1e-4f;
    Scene scene;
    scene.resolution = {48, 48};
    scene.camera.position = {-kEnd - 2, -12, 1};
    scene.camera.look_at = {0, 0, 1};
    scene.camera.up = {0, 0, 1};
    scene.camera.vfov_deg = 8;
    for (int i = -4; i <= 4; ++i)
        scene.surfaces.emplace_back(
            box({i * kPitch - kSlab / 2, -40, 4}, {i * kPitch + kSlab / 2, 40, 4.2}));
    BoxMedium haze;
    haze.min = {-kEnd + kGap / 2, -8, -3};
    haze.max = {kEnd - kGap / 2, 8, 3.9};
    haze.sigma_s = glm::vec3(kScatters);
    scene.media = {haze};
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(1)}};
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        double lit = 0;
        const auto t_at = [&](int axis, double x) {
            return (x - ray.origin[axis]) / ray.direction[axis];
        };
        const double begin = t_at(1, -8), end = t_at(1, 8);
        for (int i = -4; i < 4; ++i) {
            const double middle = (i + 0.5) * kPitch;
            lit += std::max(0.0, std::min(t_at(0, middle + kGap / 2), end) -
                                     std::max(t_at(0, middle - kGap / 2), begin));
        }
        return glm::dvec3(lit * glm::length(ray.direction) * double{kScatters} /
                          (4 * std::numbers::pi));
    });
    Settings settings = plain_settings();
    settings.steps = 24;
    settings.jitter = Settings::Jitter::blue;
    settings.shadow_map = 1024;
    settings.shadow_volume_size = 0;
    const study::Metrics m = study::compare(render(scene, settings).scattering, truth.pixels);
    figure("light through gaps: relMSE", m.relmse);
    figure("light through gaps: bias", m.bias);
    EXPECT_LT(m.relmse, 3e-3);
    EXPECT_LT(std::abs(m.bias), 0.01);
}

// Under a wide roof in the sun it is dark. At a slant a texel of a reduced layer has pixels near
// and far: a ray amid them that went as far as the farthest saw the haze above the roof, every
// other texel.
TEST_F(Indoors, NoRayOfAReducedLayerPassesACeiling)
{
    Scene scene;
    scene.resolution = {96, 64};
    scene.camera.position = {0, -10, 1};
    scene.camera.look_at = {2, 0, 3};
    scene.camera.up = {0, 0, 1};
    scene.camera.vfov_deg = 30;
    scene.surfaces = {box({-300, -300, 4}, {300, 300, 4.05}), box({-300, -300, -2}, {300, 300, 0})};
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(1)}};
    BoxMedium haze;
    haze.min = {-20, -9, 0.5};
    haze.max = {20, 30, 8};
    haze.sigma_s = glm::vec3(0.05f);
    scene.media = {haze};
    Settings settings = plain_settings(1);
    settings.shadow_map = 1024;
    scene.camera.position.z = 6;
    scene.camera.look_at.z = 6;
    const double above = mean(render(scene, settings).scattering);
    ASSERT_GT(above, 1e-3);
    scene.camera.position.z = 1;
    scene.camera.look_at.z = 3;
    for (const int resolution : {1, 2, 4}) {
        const Still still = render(scene, [&] {
            Settings reduced = settings;
            reduced.resolution = resolution;
            return reduced;
        }());
        const double seen = mean(still.scattering) / above;
        figure(fmt::format("through a ceiling, of the light above it, resolution 1/{}", resolution),
               seen);
        EXPECT_LT(seen, 1e-3) << resolution;
    }
}

// The sky through five gaps of a roof, on a floor and in haze. A node saw all of a gap or nothing
// of it along each way: strips of light lay under the gaps, and the closer the nodes the sharper.
TEST_F(Indoors, TheSkyThroughGapsIsSpreadOverTheFloor)
{
    constexpr double kLow = 4, kHigh = 4.2, kPitch = 2, kHalfGap = 0.2, kHalfWidth = 4;
    Scene scene = room(false);
    scene.resolution = {60, 40};
    scene.camera.position = {0, 0, 3.9};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 80;
    constexpr double kEnd = 6.2;
    double from = -kEnd;
    for (int i = -2; i <= 3; ++i) {
        const double to = i == 3 ? kEnd : kPitch * i - kHalfGap;
        scene.surfaces.emplace_back(box({from, -4.2, kLow}, {to, 4.2, kHigh}));
        from = kPitch * i + kHalfGap;
    }
    auto& clear = std::get<BoxMedium>(scene.media[0]);
    clear.sigma_s = clear.sigma_a = glm::vec3(1e-6f);
    // The part of a cosine's weight that gets through both ends of a gap.
    const auto sky_at = [&](glm::dvec2 p) {
        constexpr int kRings = 64, kAround = 128;
        int seen = 0;
        for (int ring = 0; ring < kRings; ++ring)
            for (int k = 0; k < kAround; ++k) {
                const double u = (ring + 0.5) / kRings,
                             angle = 2 * std::numbers::pi * (k + 0.5 * (ring % 2)) / kAround,
                             slope = std::sqrt(u / (1 - u));
                const glm::dvec2 way = slope * glm::dvec2(std::cos(angle), std::sin(angle));
                const glm::dvec2 low = p + kLow * way, high = p + kHigh * way;
                for (int gap = -2; gap <= 2; ++gap)
                    seen += std::abs(low.y) < kHalfWidth &&
                                    std::abs(low.x - kPitch * gap) < kHalfGap &&
                                    std::abs(high.x - kPitch * gap) < kHalfGap
                                ? 1
                                : 0;
            }
        return static_cast<double>(seen) / (kRings * kAround);
    };
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
        return glm::dvec3(0.5 * 0.5 * sky_at(glm::dvec2(p)));
    });
    Settings settings = plain_settings();
    settings.surface_bounces = 0;
    const study::Metrics m = study::compare(render(scene, settings).surface_lit, truth.pixels);
    figure("the sky through gaps: relMSE", m.relmse);
    figure("the sky through gaps: bias", m.bias);
    // A gap is as wide as the directions are apart. Without them it was 4.0 and +38 %.
    EXPECT_LT(m.relmse, 0.05);
    EXPECT_LT(std::abs(m.bias), 0.08);
}

// Shadows have edges all over the picture where light comes through gaps.
TEST_F(Indoors, ThroughGapsASunsShadowsAreFiner)
{
    const auto with_map = [](Scene scene, int texels) {
        scene.lights = {SunLight{{0.35, -0.25, 0.9}, glm::vec3(20)}};
        Settings settings = plain_settings();
        settings.world_directions = 26;
        settings.shadow_map = texels;
        return render(scene, settings).composite;
    };
    const Scene gaps = gapped_room(0), open = room(false);
    EXPECT_EQ(with_map(gaps, kAutomatic), with_map(gaps, 3072));
    EXPECT_NE(with_map(gaps, kAutomatic), with_map(gaps, 2048));
    EXPECT_EQ(with_map(open, kAutomatic), with_map(open, 2048));
    EXPECT_NE(with_map(open, kAutomatic), with_map(open, 3072));
}

// What surfaces hide of the sky is kept while none of them changes: one that moves is looked at
// anew.
TEST_F(Indoors, TheSkyThroughGapsMovesWithThem)
{
    const auto gaps_at = [](double x) {
        Scene scene = gapped_room(x);
        auto& clear = std::get<BoxMedium>(scene.media[0]);
        clear.sigma_s = clear.sigma_a = glm::vec3(1e-6f);
        return scene;
    };
    const Settings settings = plain_settings();
    const auto before = render(gaps_at(0), settings).composite;
    const auto moved = render(gaps_at(0.7), settings).composite;
    EXPECT_NE(before, moved);
    Scene elsewhere = gaps_at(0);
    elsewhere.lights.clear();
    render(elsewhere, settings);  // not the shapes, which are kept
    EXPECT_EQ(render(gaps_at(0), settings).composite, before);
    SceneRenderer fresh(get_proc());
    EXPECT_EQ(fresh.render(gaps_at(0.7), settings, {}).composite, moved);
}

// A map of shadows has a surface a texel thick or so: light got in along the lines where walls and
// ceilings meet, in dots, as edges are drawn to a part of a pixel.
TEST_F(Indoors, NoSunGetsInWhereWallsMeet)
{
    Scene scene = room(true);
    scene.resolution = {160, 90};
    auto& clear = std::get<BoxMedium>(scene.media[0]);  // where the map has its detail
    clear.sigma_s = clear.sigma_a = glm::vec3(1e-6f);
    scene.world.radiance = glm::vec3(0);
    Settings settings = plain_settings();
    settings.shadow_map = 1024;
    settings.surface_bounces = 0;  // what the sunlit outside sends on is not asked for
    for (const glm::dvec3 to_light : {glm::dvec3(0.5, -0.9, 0.55), glm::dvec3(-0.5, 0.3, 0.9)}) {
        scene.lights = {SunLight{glm::normalize(to_light), glm::vec3(1)}};
        for (const glm::dvec3 look_at : {glm::dvec3(3, 2, 2.6), glm::dvec3(3, 2, 0)}) {
            scene.camera.look_at = look_at;
            const Still still = render(scene, settings);
            const auto lit = std::count_if(still.surface.begin(), still.surface.end(),
                                           [](float value) { return value > 1e-3f; });
            EXPECT_EQ(lit, 0) << to_light.x << ", looking to " << look_at.z;
        }
    }
}

// Light that the sunlit outside sends on: nodes beyond a wall count on no surface within. Where
// three walls meet a few pixels still see some of it.
TEST_F(Indoors, LittleOfWhatIsSentOnOutsideGetsIn)
{
    Scene scene = room(true);
    scene.resolution = {160, 90};
    auto& clear = std::get<BoxMedium>(scene.media[0]);
    clear.sigma_s = clear.sigma_a = glm::vec3(1e-6f);
    scene.world.radiance = glm::vec3(0);
    scene.camera.look_at = {3, 2, 0};
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.5, -0.9, 0.55)), glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.shadow_map = 1024;
    settings.surface_bounces = 4;
    const Still still = render(scene, settings);
    const auto lit = std::count_if(still.surface.begin(), still.surface.end(),
                                   [](float value) { return value > 1e-3f; });
    figure("numbers above 1e-3", static_cast<double>(lit));
    EXPECT_LE(lit, 3 * 8);
}

// What lies on a surface was looked up where a texel's width lifts it to: a shadow's edge moved by
// that, times the light's slope.
TEST_F(Indoors, ASunsShadowEndsWhereItsSlabDoes)
{
    constexpr double kHeight = 4;
    Scene scene;
    scene.resolution = {96, 96};
    scene.camera.position = {-1.8, 0, 3.5};
    scene.camera.look_at = {-1.8, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 40;
    scene.surfaces = {box({-6, -6, -1}, {6, 6, 0}), box({-6, -6, kHeight}, {0, 6, kHeight + 0.2})};
    const glm::dvec3 to_light = glm::normalize(glm::dvec3(0.5, 0.35, 0.9));
    scene.lights = {SunLight{to_light, glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.shadow_map = 256;  // of 5 cm
    const std::vector<float> surface = render(scene, settings).surface;
    const double width = 2 * scene.camera.position.z * std::tan(glm::radians(20.0));
    const double lit = mean(surface) / (0.5 / std::numbers::pi * to_light.z);
    const double edge = scene.camera.position.x + width * (0.5 - lit);
    figure("a shadow's edge, off [m]", edge - -kHeight * to_light.x / to_light.z);
    EXPECT_NEAR(edge, -kHeight * to_light.x / to_light.z, 0.006);
}

// Of the sun's detailed view of the surfaces every texel lay over the media, of which few are in a
// shadow: in wide haze a board's had steps.
TEST_F(Indoors, ABoardsShadowInWideHazeHasNoSteps)
{
    constexpr double kHeight = 1, kHalf = 0.5;
    Scene scene;
    scene.resolution = {64, 64};
    const glm::dvec3 to_light = glm::normalize(glm::dvec3(0.5, 0.35, 0.9));
    const glm::dvec2 shift = -kHeight / to_light.z * glm::dvec2(to_light);
    scene.camera.position = {shift, 0.9};
    scene.camera.look_at = {shift, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 80;
    BoxMedium haze;
    haze.min = {-30, -30, 0};
    haze.max = {30, 30, 3};
    haze.sigma_s = glm::vec3(1e-4f);
    scene.media = {haze};
    scene.surfaces = {box({-90, -90, -1}, {90, 90, 0}),
                      box({-kHalf, -kHalf, kHeight}, {kHalf, kHalf, kHeight + 1e-3})};
    scene.lights = {SunLight{to_light, glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.shadow_map = 512;
    const std::vector<float> surface = render(scene, settings).surface;
    const Image expected = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
        const glm::dvec2 off = glm::abs(glm::dvec2(p) - shift);
        return glm::dvec3(std::max(off.x, off.y) < kHalf ? 0 : 1);
    });
    double wrong = 0;
    for (std::size_t i = 0; i < surface.size(); ++i) {
        const double lit = double{surface[i]} / (0.5 / std::numbers::pi * to_light.z);
        wrong += std::abs(lit - double{expected.pixels[i]}) / double(surface.size());
    }
    figure("part of the picture that a board's shadow is wrong in", wrong);
    EXPECT_LT(wrong, 0.01);
}

// A plate thinner than a texel, in a sun from high to low.
TEST_F(Indoors, ALitSideHasNoFalseShadow)
{
    Scene scene;
    scene.resolution = {64, 64};
    scene.camera.position = {0, 0, 6};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 40;
    scene.surfaces = {box({-4, -4, -0.02}, {4, 4, 0})};
    Settings settings = plain_settings();
    settings.shadow_map = 128;
    for (const double elevation_deg : {80.0, 45.0, 20.0, 8.0, 3.0}) {
        const double elevation = glm::radians(elevation_deg);
        const glm::dvec3 to_light(0.8 * std::cos(elevation), 0.6 * std::cos(elevation),
                                  std::sin(elevation));
        scene.lights = {SunLight{to_light, glm::vec3(1)}};
        const std::vector<float> surface = render(scene, settings).surface;
        const float darkest = *std::min_element(surface.begin(), surface.end());
        EXPECT_NEAR(double{darkest}, 0.5 / std::numbers::pi * to_light.z, 1e-4 * to_light.z)
            << elevation_deg;
    }
}

}  // namespace
}  // namespace fumarole::test
