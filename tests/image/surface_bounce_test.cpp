// Light that surfaces send on, onto each other and into the media, against what is known of it in
// closed form.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "image_test.h"
#include "study/metrics.h"

namespace fumarole::test {
namespace {

class SurfaceBounces : public ImageTest {
protected:
    static Settings settings_of(int turns)
    {
        Settings settings = plain_settings();
        settings.bounces = 0;
        settings.surface_bounces = turns;
        return settings;
    }
    /// Scatters nothing that is seen, over a box.
    static BoxMedium thin(glm::dvec3 min, glm::dvec3 max, float sigma_s = 1e-4f)
    {
        BoxMedium medium;
        medium.min = min;
        medium.max = max;
        medium.sigma_s = glm::vec3(sigma_s);
        return medium;
    }
    /// Of a place on the picture's middle pixels.
    static glm::dvec3 middle(const Still& still, const std::vector<float>& rgb)
    {
        glm::dvec3 sum(0);
        int count = 0;
        for (int y = still.height / 2 - 2; y < still.height / 2 + 2; ++y)
            for (int x = still.width / 2 - 2; x < still.width / 2 + 2; ++x, ++count)
                for (int c = 0; c < 3; ++c)
                    sum[c] += static_cast<double>(
                        rgb[static_cast<std::size_t>(3 * (y * still.width + x) + c)]);
        return sum / double(count);
    }
    /// A room of walls that shine alike, seen from within.
    static Scene furnace(float albedo)
    {
        Scene scene = empty_scene(24);
        scene.camera.position = {0.3, -0.8, 0.1};
        scene.camera.look_at = {0.2, 1, 0};
        scene.camera.vfov_deg = 50;
        scene.media = {thin({-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6})};
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                BoxSurface wall;
                wall.min = glm::dvec3(-1.2);
                wall.max = glm::dvec3(1.2);
                (side < 0 ? wall.max : wall.min)[axis] = side;
                wall.albedo = albedo * glm::vec3(1, 0.5f, 0.25f);
                wall.emission = glm::vec3(2);
                scene.surfaces.emplace_back(wall);
            }
        return scene;
    }
    /// A black room of 7.4 m by 7.4 by 4, whose floor reflects half, seen from its ceiling.
    static Scene black_room()
    {
        Scene scene = empty_scene(32);
        scene.camera.position = {0, 0, 3.6};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.up = {0, 1, 0};
        scene.camera.vfov_deg = 84;
        scene.media = {thin({-2, -2, 0.5}, {2, 2, 3})};
        const glm::dvec3 low(-3.7, -3.7, 0), high(3.7, 3.7, kCeiling);
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {0.0, 1.0}) {
                BoxSurface wall;
                wall.min = low - 0.4;
                wall.max = high + 0.4;
                (side == 0 ? wall.max : wall.min)[axis] = side == 0 ? low[axis] : high[axis];
                wall.albedo = glm::vec3(axis == 2 && side == 0 ? kFloorAlbedo : 0.0);
                scene.surfaces.emplace_back(wall);
            }
        return scene;
    }
    /// Of what light throws on that floor, over what `irradiance` is at a place on it.
    Image over_closed_form(const Scene& scene,
                           const std::function<double(glm::dvec3)>& irradiance) const
    {
        const Still still = render(scene, settings_of(2));
        const Image expected = ideal(scene, [&](glm::dvec2 at) {
            const PixelRay ray = ray_at(scene, at);
            const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            return glm::dvec3(kFloorAlbedo / std::numbers::pi * irradiance(p));
        });
        Image ratio = picture_of(still, still.surface_lit);
        for (std::size_t i = 0; i < ratio.pixels.size(); ++i)
            ratio.pixels[i] /= expected.pixels[i];
        return ratio;
    }
    static double mean_of(const Image& image)
    {
        return std::accumulate(image.pixels.begin(), image.pixels.end(), 0.0) /
               double(image.pixels.size());
    }
    static constexpr double kCeiling = 4, kFloorAlbedo = 0.5, kRadiance = 3;

    /// A window in the ceiling, of that half edge [m].
    void expect_light_of_window(double half)
    {
        Scene scene = black_room();
        BoxSurface window;
        window.min = {-half, -half, kCeiling - 1e-3};
        window.max = {half, half, kCeiling + 0.1};
        window.albedo = glm::vec3(0);
        window.emission = glm::vec3(kRadiance);
        scene.surfaces.emplace_back(window);
        Image ratio = over_closed_form(scene, [&](glm::dvec3 p) {
            return integrate(-half, half, 2, [&](double x) {
                return integrate(-half, half, 2, [&](double y) {
                    const glm::dvec2 off(x - p.x, y - p.y);
                    const double squared = glm::dot(off, off) + kCeiling * kCeiling;
                    return kRadiance * kCeiling * kCeiling / (squared * squared);
                });
            });
        });
        const double mean = mean_of(ratio);
        figure("a window's light on the floor over the closed form, mean", mean);
        EXPECT_NEAR(mean, 1, 0.1) << "edges are known to an eighth of a node; half edge " << half;
        Image one = ratio;
        for (std::size_t i = 0; i < ratio.pixels.size(); ++i) {
            ratio.pixels[i] /= static_cast<float>(mean);
            one.pixels[i] = 1;
        }
        figure("and at most, off that", max_difference(ratio, one));
        EXPECT_TRUE(
            images_near(ratio, one, 0.3, 0.06,
                        "256 ways from a node, of which 3 to 20 meet the window, each a mean "
                        "over as much as it stands for"));
    }
};

// Walls of one colour that shine alike: each turn brings albedo times what the one before brought.
TEST_F(SurfaceBounces, ARoomOfShiningWallsIsAGeometricSeries)
{
    const glm::dvec3 albedo = 0.8 * glm::dvec3(1, 0.5, 0.25);
    for (const int turns : {1, 2, 6}) {
        const Still still = render(furnace(0.8f), settings_of(turns));
        glm::dvec3 expected(2), power(2);
        for (int i = 0; i < turns; ++i)
            expected += power *= albedo;
        const glm::dvec3 seen = middle(still, still.surface_lit);
        for (int c = 0; c < 3; ++c) {
            figure("furnace of walls", seen[c] / expected[c] - 1);
            EXPECT_NEAR(seen[c] / expected[c], 1, 0.02) << turns << " turns, channel " << c;
        }
    }
}

// And the medium amid them scatters that: of what shines, what was reflected once less.
TEST_F(SurfaceBounces, AMediumAmidShiningWallsScattersTheirLight)
{
    Scene scene = furnace(0.8f);
    scene.media = {thin({-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}, 1e-3f)};
    scene.camera.position = {0, -0.9, 0};
    scene.camera.look_at = {0, 1, 0};
    const Still still = render(scene, settings_of(6));
    const glm::dvec3 seen = middle(still, still.scattering);
    glm::dvec3 expected(2), power(2);
    for (int i = 0; i < 5; ++i)
        expected += power *= 0.8 * glm::dvec3(1, 0.5, 0.25);
    expected *= 1e-3 * 1.2;  // sigma_s times the way through it
    for (int c = 0; c < 3; ++c) {
        figure("medium in a furnace of walls", seen[c] / expected[c] - 1);
        EXPECT_NEAR(seen[c] / expected[c], 1, 0.03) << "channel " << c;
    }
}

// Over a plain that a sun lights, half of all directions have the plain's radiance, most of them
// from beyond the lattice.
TEST_F(SurfaceBounces, ALitPlainLightsAMediumOverIt)
{
    Scene scene = empty_scene(24);
    scene.camera.position = {0, -6, 2};
    scene.camera.look_at = {0, 0, 2};
    scene.camera.vfov_deg = 10;
    scene.lights = {SunLight{{0, 0.6, 0.8}, glm::vec3(5)}};
    scene.surfaces = {BoxSurface{{-500, -500, -1}, {500, 500, 0}, {0.6f, 0.3f, 0.1f}}};
    scene.media = {thin({-1, -1, 1}, {1, 1, 3}, 1e-3f)};
    const Still with = render(scene, settings_of(1)), without = render(scene, settings_of(0));
    const glm::dvec3 seen = middle(with, with.scattering) - middle(without, without.scattering);
    for (int c = 0; c < 3; ++c) {
        const double radiance = 5 * 0.8 / std::numbers::pi * std::array{0.6, 0.3, 0.1}[c];
        const double expected = 1e-3 * 2 * radiance / 2;
        figure("plain under a medium", seen[c] / expected - 1);
        EXPECT_NEAR(seen[c] / expected, 1, 0.04) << "channel " << c;
    }
}

// Of a wall on one side only, that side of a thick medium has the colour.
TEST_F(SurfaceBounces, SmokeBesideARedWallIsRedOnThatSide)
{
    Scene scene = empty_scene(24);
    scene.camera.position = {0, -6, 1};
    scene.camera.look_at = {0, 0, 1};
    scene.camera.vfov_deg = 25;
    scene.lights = {SunLight{{0.3, -0.9, 0.3}, glm::vec3(5)}};
    scene.surfaces = {BoxSurface{{-2.2, -3, -1}, {-2, 3, 3}, {0.8f, 0, 0}}};
    BoxMedium smoke = thin({-1, -1, 0}, {1, 1, 2}, 4.0f);
    scene.media = {smoke};
    const Still with = render(scene, settings_of(1)), without = render(scene, settings_of(0));
    const auto red_at = [&](int x) {
        const auto at = static_cast<std::size_t>(3 * (with.height / 2 * with.width + x));
        return with.scattering[at] - without.scattering[at];
    };
    int left = 0, right = with.width - 1;
    while (with.transmittance[static_cast<std::size_t>(3 * (with.height / 2 * with.width + left))] >
           0.5f)
        ++left;
    while (
        with.transmittance[static_cast<std::size_t>(3 * (with.height / 2 * with.width + right))] >
        0.5f)
        --right;
    figure("red on the wall's side over the other", red_at(left) / red_at(right));
    EXPECT_GT(red_at(left), 8 * red_at(right));
    EXPECT_GT(red_at(left), 0.02f);
    for (std::size_t i = 1; i < with.scattering.size(); i += 3)
        ASSERT_NEAR(with.scattering[i], without.scattering[i], 2e-3f) << "green is not the wall's";
}

// Over a plain that shines, thick smoke has half the plain's radiance times E2 of the optical depth
// down to it (Abramowitz and Stegun 1964, 5.1.4): between two nodes of the surfaces' lattice, an
// optical depth of 1 apart, far less than the mean of both.
TEST_F(SurfaceBounces, ThickSmokeOverAShiningPlainDimsItsLight)
{
    constexpr double kSigmaT = 4, kHeight = 1;
    Scene scene = empty_scene(24);
    scene.camera.position = {0, 0, 6};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 4;
    BoxSurface plain{{-2, -2, -1}, {2, 2, 0}, glm::vec3(0)};
    plain.emission = glm::vec3(kRadiance);
    scene.surfaces = {plain};
    scene.media = {thin({-2, -2, 0}, {2, 2, kHeight}, float{kSigmaT})};
    const Still with = render(scene, settings_of(1)), without = render(scene, settings_of(0));
    const double seen = (middle(with, with.scattering) - middle(without, without.scattering)).x;
    const double expected = integrate(0, kHeight * kSigmaT, 64, [&](double tau) {
        const double e2 = integrate(1e-3, 1, 64, [&](double mu) { return std::exp(-tau / mu); });
        return kRadiance / 2 * e2 * std::exp(tau - kHeight * kSigmaT);
    });
    figure("a shining plain's light in thick smoke", seen / expected - 1);
    EXPECT_NEAR(seen / expected, 1, 0.06);
}

// A window of light in the ceiling of a black room: what few directions carry of it would lie in
// stripes on the floor, and nodes 0.53 m apart would take it for larger or smaller than it is.
TEST_F(SurfaceBounces, AShiningWindowThrowsNoStripesOnTheFloor)
{
    for (const double window : {0.8, 1.2, 1.5, 2.0})
        expect_light_of_window(window);
}

// Of a bulb and a panel that are far smaller than the 0.53 m from node to node few lines of the
// lattice meet any part, or none.
// A white ball in the sun lights the floor at its foot, where most nodes lie inside of it or past
// it. Wherever the ball stands amid them, none is taken up or left out at once from one pixel to
// the next.
TEST_F(SurfaceBounces, TheFloorBesideABallHasNoEdges)
{
    constexpr double kRadius = 0.8, kAlbedo = 0.6, kSun = 9;
    const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, -0.9, 0.55));
    const auto from_line = [](glm::dvec3 place, glm::dvec3 way, glm::dvec3 middle) {
        return glm::length(glm::cross(middle - place, way));
    };
    for (const glm::dvec2 at :
         {glm::dvec2(0, 0), glm::dvec2(0.1, 0.07), glm::dvec2(0.2, 0.15), glm::dvec2(-0.1, -0.1)}) {
        const glm::dvec3 middle(at, kRadius);
        Scene scene = empty_scene(160);
        scene.resolution.y = 120;
        scene.camera.position = {1.2, -4.8, 3.5};
        scene.camera.look_at = {0, -0.7, 0};
        scene.camera.up = {0, 0, 1};
        scene.camera.vfov_deg = 30;
        scene.lights = {SunLight{to_sun, glm::vec3(static_cast<float>(kSun))}};
        scene.media = {thin({-3, -2.4, 0.2}, {3, 2.4, 4}, 1e-6f)};
        scene.surfaces = {
            BoxSurface{{-4.3, -2.4, -0.3}, {4.3, 2.9, 0}, glm::vec3(static_cast<float>(kAlbedo))},
            BoxSurface{{-4.3, 2.6, 0}, {4.3, 2.9, 5.6}, glm::vec3(0.7f)},
            SphereSurface{middle, kRadius, glm::vec3(0.9f)}};
        const Still still = render(scene, settings_of(2));
        // What surfaces send, of the floor that the sun lights, not beside the ball's shadow; else
        // 0.
        const Image sent = ideal(scene, [&](glm::dvec2 pixel) {
            const PixelRay ray = ray_at(scene, pixel);
            if (from_line(ray.origin, ray.direction, middle) < 1.04 * kRadius)
                return glm::dvec3(0);
            const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            const bool near = std::abs(p.x - middle.x) < 1.6 && std::abs(p.y - middle.y) < 1.6;
            const bool lit =
                glm::dot(middle - p, to_sun) < 0 || from_line(p, to_sun, middle) > 1.15 * kRadius;
            return glm::dvec3(near && lit ? 1 : 0);
        });
        const auto at_pixel = [&](int x, int y) {
            const auto i = static_cast<std::size_t>(3 * (y * still.width + x));
            return sent.pixels[i] == 0 ? 0
                                       : double{still.surface_lit[i]} -
                                             kAlbedo / std::numbers::pi * kSun * to_sun.z;
        };
        std::vector<double> bends;
        for (int y = 1; y + 1 < still.height; ++y)
            for (int x = 1; x + 1 < still.width; ++x) {
                const double here = at_pixel(x, y);
                double bend = 0;
                bool whole = here > 0;
                for (const glm::ivec2 d : {glm::ivec2(1, 0), glm::ivec2(0, 1)}) {
                    const double before = at_pixel(x - d.x, y - d.y),
                                 after = at_pixel(x + d.x, y + d.y);
                    whole = whole && before > 0 && after > 0;
                    bend = std::max(bend, std::abs(before - 2 * here + after) / here);
                }
                if (whole)
                    bends.push_back(bend);
            }
        ASSERT_GT(bends.size(), 4000);
        const auto most = bends.begin() + static_cast<std::ptrdiff_t>(0.99 * double(bends.size()));
        std::nth_element(bends.begin(), most, bends.end());
        figure("floor beside a ball: second difference of 99 % of the pixels", *most);
        // Nodes that were told apart along axes, at once, had 0.29 to 0.36.
        EXPECT_LT(*most, 0.15) << "ball at " << at.x << ", " << at.y;
    }
}

TEST_F(SurfaceBounces, ALampSmallerThanANodeLightsTheFloor)
{
    constexpr double kRadius = 0.1, kHalf = 0.2, kHeight = 2.5;
    const glm::dvec3 place(0.1, 0.05, kHeight);
    const auto cubed = [&](glm::dvec3 p) { return std::pow(glm::length(place - p), 3); };
    SphereSurface bulb{place, kRadius, glm::vec3(0)};
    BoxSurface panel{place - glm::dvec3(kHalf, kHalf, 0.01), place + glm::dvec3(kHalf, kHalf, 0.01),
                     glm::vec3(0)};
    bulb.emission = panel.emission = glm::vec3(kRadiance);
    for (const bool round : {true, false}) {
        Scene scene = black_room();
        scene.camera.position.z = 1.2;  // or they would stand before it
        scene.surfaces.emplace_back(round ? Surface(bulb) : Surface(panel));
        const Image ratio = over_closed_form(scene, [&](glm::dvec3 p) {
            const double area = round ? std::numbers::pi * kRadius * kRadius
                                      : 4 * kHalf * kHalf * kHeight / glm::length(place - p);
            return kRadiance * area * kHeight / cubed(p);
        });
        figure(round ? "a bulb's light on the floor over the closed form, mean"
                     : "a panel's light on the floor over the closed form, mean",
               mean_of(ratio));
        EXPECT_NEAR(mean_of(ratio), 1, 0.06) << "9 harmonics of a lamp, and nodes above the floor";
        EXPECT_LT(*std::max_element(ratio.pixels.begin(), ratio.pixels.end()), 1.15f);
        EXPECT_GT(*std::min_element(ratio.pixels.begin(), ratio.pixels.end()), 0.9f);
        // What lies under a table has none of it, and more of its shadow is as dark as it is.
        scene.surfaces.emplace_back(BoxSurface{{-1, -1, 1.4}, {1, 1, 1.6}, glm::vec3(0)});
        const Still still = render(scene, settings_of(2));
        EXPECT_LT(middle(still, still.surface_lit).x, 0.02 * kFloorAlbedo / std::numbers::pi *
                                                          kRadiance * (4 * kHalf * kHalf) /
                                                          (kHeight * kHeight));
    }
}

// What is not asked for costs nothing and changes nothing.
TEST_F(SurfaceBounces, AutoLeavesDarkSurfacesAlone)
{
    Scene scene = furnace(0.05f);
    for (Surface& surface : scene.surfaces)
        std::get<BoxSurface>(surface).emission = glm::vec3(0);
    scene.lights = {PointLight{{0.2, 0.1, 0.7}, glm::vec3(2)}};
    EXPECT_EQ(render(scene, settings_of(Settings::kAutomatic)).composite,
              render(scene, settings_of(0)).composite);
}

}  // namespace
}  // namespace fumarole::test
