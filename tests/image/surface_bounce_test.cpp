// Light that surfaces send on, onto each other and into the media, against what is known of it in
// closed form.

#include <cmath>
#include <numbers>

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
    /// A window in the ceiling, of that half edge [m], on the floor of a black room.
    void expect_light_of_window(double half)
    {
        constexpr double kHeight = 4, kAlbedo = 0.5, kRadiance = 3;
        Scene scene = empty_scene(32);
        scene.camera.position = {0, 0, 3.6};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.up = {0, 1, 0};
        scene.camera.vfov_deg = 84;
        scene.media = {thin({-2, -2, 0.5}, {2, 2, 3})};
        const glm::dvec3 low(-3.7, -3.7, 0), high(3.7, 3.7, kHeight);
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {0.0, 1.0}) {
                BoxSurface wall;
                wall.min = low - 0.4;
                wall.max = high + 0.4;
                (side == 0 ? wall.max : wall.min)[axis] = side == 0 ? low[axis] : high[axis];
                wall.albedo = glm::vec3(axis == 2 && side == 0 ? kAlbedo : 0.0);
                scene.surfaces.emplace_back(wall);
            }
        BoxSurface window;
        window.min = {-half, -half, kHeight - 1e-3};
        window.max = {half, half, kHeight + 0.1};
        window.albedo = glm::vec3(0);
        window.emission = glm::vec3(kRadiance);
        scene.surfaces.emplace_back(window);
        const Still still = render(scene, settings_of(2));
        const Image expected = ideal(scene, [&](glm::dvec2 at) {
            const PixelRay ray = ray_at(scene, at);
            const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            const double irradiance = integrate(-half, half, 2, [&](double x) {
                return integrate(-half, half, 2, [&](double y) {
                    const glm::dvec2 off(x - p.x, y - p.y);
                    const double squared = glm::dot(off, off) + kHeight * kHeight;
                    return kRadiance * kHeight * kHeight / (squared * squared);
                });
            });
            return glm::dvec3(kAlbedo / std::numbers::pi * irradiance);
        });
        Image ratio = picture_of(still, still.surface_lit), one = expected;
        double mean = 0;
        for (std::size_t i = 0; i < ratio.pixels.size(); ++i) {
            ratio.pixels[i] /= expected.pixels[i];
            mean += double(ratio.pixels[i]) / double(ratio.pixels.size());
            one.pixels[i] = 1;
        }
        figure("a window's light on the floor over the closed form, mean", mean);
        EXPECT_NEAR(mean, 1, 0.1) << "edges are known to an eighth of a node; half edge " << half;
        for (float& pixel : ratio.pixels)
            pixel /= static_cast<float>(mean);
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
    constexpr double kSigmaT = 4, kHeight = 1, kRadiance = 3;
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
