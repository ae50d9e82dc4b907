// Lights that have an area: against the point light that a small one is, closed forms of their
// irradiance, quadrature of a penumbra, and the reference.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "image_test.h"
#include "light_fields.h"
#include "study/metrics.h"
#include "study/reference.h"

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

class AreaLights : public ImageTest {
protected:
    static constexpr double kWidth = 4;  ///< metres of the ground that a picture shows

    /// A ground at z = 0, seen from above.
    static Scene ground_scene(unsigned size = 32)
    {
        Scene scene;
        scene.resolution = glm::uvec2(size);
        scene.camera.position = {0, 0, 50};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.up = {0, 1, 0};
        scene.camera.projection = Camera::Projection::orthographic;
        scene.camera.ortho_height = kWidth;
        BoxSurface ground;
        ground.min = {-20, -20, -1};
        ground.max = {20, 20, 0};
        ground.albedo = glm::vec3(0.5f);
        scene.surfaces = {ground};
        return scene;
    }
    static glm::dvec2 ground_at(const Scene& scene, int x, int y)
    {
        const double n = scene.resolution.x;
        return kWidth * glm::dvec2((x + 0.5) / n - 0.5, 0.5 - (y + 0.5) / n);
    }

    /// The largest error of the ground's irradiance, relative.
    static double worst_of(const Scene& scene, const std::function<double(glm::dvec2)>& expected)
    {
        const Still still = render(scene, plain_settings());
        const int n = static_cast<int>(scene.resolution.x);
        double worst = 0;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const double found = kPi / 0.5 * double{pixel(still.composite, n, x, y).r};
                worst = std::max(worst, std::abs(found / expected(ground_at(scene, x, y)) - 1));
            }
        return worst;
    }
};

/// Irradiance of a plane, of unit radiance, by a rectangle h above it and parallel to it, one of
/// whose corners is over the point: Lambert's formula.
double corner_over(double x, double y, double h)
{
    const double a = x / h, b = y / h, ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
    return 0.5 * (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb));
}

TEST_F(AreaLights, ARectangleOverAPlaneIsLambertsFormula)
{
    Scene scene = ground_scene();
    RectLight light;
    light.center = {0.3, -0.2, 0.7};
    light.edges = {glm::dvec3(2, 0, 0), glm::dvec3(0, 1.2, 0)};
    light.radiance = glm::vec3(3);
    scene.lights = {light};
    const double worst = worst_of(scene, [&](glm::dvec2 at) {
        const glm::dvec2 p = at - glm::dvec2(light.center);
        double sum = 0;
        for (const double x : {1 - p.x, 1 + p.x})
            for (const double y : {0.6 - p.y, 0.6 + p.y})
                sum += 3 * corner_over(x, y, light.center.z);
        return sum;
    });
    figure("rectangle, relative error", worst);
    EXPECT_LT(worst, 1e-4);
}

// Half of one that stands on the plane is below it. The textbook's formula for a rectangle square
// to the plane, whose lower edge begins at the point's foot.
TEST_F(AreaLights, WhatIsBelowTheHorizonIsCutOff)
{
    Scene scene = ground_scene();
    RectLight light;
    light.center = {0, 2.5, 0};
    light.edges = {glm::dvec3(3, 0, 0), glm::dvec3(0, 0, -2)};  // it shines to -y
    light.radiance = glm::vec3(3);
    scene.lights = {light};
    const auto corner = [](double width, double height, double d) {
        const double r = std::hypot(height, d);
        return 0.5 * (std::atan(width / d) - d / r * std::atan(width / r));
    };
    const double worst = worst_of(scene, [&](glm::dvec2 p) {
        return 3 * (corner(1.5 - p.x, 1, 2.5 - p.y) + corner(1.5 + p.x, 1, 2.5 - p.y));
    });
    figure("rectangle on the plane, relative error", worst);
    EXPECT_LT(worst, 1e-4);
}

TEST_F(AreaLights, ADiskOverAPlaneIsTheClosedForm)
{
    Scene scene = ground_scene();
    DiskLight light;
    light.center = {-0.1, 0.2, 0.8};
    light.radius = 0.9;
    light.radiance = glm::vec3(2);
    scene.lights = {light};
    const double worst = worst_of(scene, [&](glm::dvec2 at) {
        const glm::dvec2 p = at - glm::dvec2(light.center);
        const double d2 = glm::dot(p, p), h2 = 0.8 * 0.8, r2 = 0.9 * 0.9, s = d2 + h2 + r2;
        return kPi * (1 - (d2 + h2 - r2) / std::sqrt(s * s - 4 * r2 * d2));
    });
    figure("disk, relative error", worst);
    EXPECT_LT(worst, 1e-4);
}

// Against plain quadrature: the disk's lower half is below the plane, where a polygon of 24 corners
// stands for it.
TEST_F(AreaLights, ADiskIsCutOffAtTheHorizon)
{
    Scene scene = ground_scene(16);
    DiskLight light;
    light.center = {0.2, 3, 0.1};
    light.normal = {0, -1, 0.2};
    light.radius = 0.8;
    light.radiance = glm::vec3(2);
    scene.lights = {light};
    const glm::dvec3 n = glm::normalize(light.normal), u(1, 0, 0), v = glm::cross(n, u);
    const double worst = worst_of(scene, [&](glm::dvec2 at) {
        constexpr int kPoints = 300;
        double sum = 0;
        for (int i = 0; i < kPoints; ++i)
            for (int j = 0; j < kPoints; ++j) {
                const double r = light.radius * std::sqrt((i + 0.5) / kPoints);
                const double angle = 2 * kPi * (j + 0.5) / kPoints;
                const glm::dvec3 to = light.center + r * std::cos(angle) * u +
                                      r * std::sin(angle) * v - glm::dvec3(at, 0);
                const double d2 = glm::dot(to, to);
                sum += std::max(to.z, 0.0) * std::max(-glm::dot(to, n), 0.0) / (d2 * d2);
            }
        return 2 * kPi * light.radius * light.radius * sum / (kPoints * kPoints);
    });
    figure("disk at the horizon, relative error", worst);
    EXPECT_LT(worst, 5e-3);
}

TEST_F(AreaLights, OneSideIsDarkUnlessThereAreTwo)
{
    for (const bool two_sided : {false, true}) {
        RectLight rect;
        rect.center = {0, 0, 1};
        rect.edges = {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0)};  // it shines upwards
        rect.two_sided = two_sided;
        DiskLight disk;
        disk.center = {0, 0, 1};
        disk.normal = {0, 0, 1};
        disk.two_sided = two_sided;
        for (const Light& light : {Light(rect), Light(disk)}) {
            Scene scene = ground_scene();
            scene.lights = {light};
            BoxMedium fog;
            fog.min = {-1, -1, 0.2};
            fog.max = {1, 1, 0.8};
            fog.sigma_s = glm::vec3(0.2f);
            scene.media = {fog};
            for (const Settings& settings : plain_siblings()) {
                const Still still = render(scene, settings);
                EXPECT_EQ(pixel(still.composite, 32, 2, 2).r > 1e-3f, two_sided);
                EXPECT_EQ(pixel(still.scattering, 32, 16, 16).r > 1e-3f, two_sided);
            }
        }
    }
}

// On the axis of a small one the cosine at the light is 1.
TEST_F(AreaLights, ASmallOneIsThePointLight)
{
    constexpr double kSide = 5e-3;
    for (const Settings& settings : plain_siblings()) {
        Scene scene = empty_scene(16);
        scene.camera.vfov_deg = 1.5;
        BoxMedium box;
        box.min = {-0.05, -5.05, -0.05};
        box.max = {0.05, -4.95, 0.05};
        box.sigma_s = glm::vec3(4, 5, 6);
        box.g = 0.4f;
        scene.media = {box};
        BoxSurface wall;
        wall.min = {-3, -5.5, -1};
        wall.max = {3, -5.06, -0.04};
        scene.surfaces = {wall};
        PointLight point;
        point.position = {0, -5, 100};  // from the wall, too, nearly on the axis
        point.radiant_intensity = glm::vec3(7500, 6000, 4500);
        scene.lights = {point};
        const Still of_point = render(scene, settings);
        RectLight rect;
        rect.center = point.position;
        rect.edges = {glm::dvec3(kSide, 0, 0), glm::dvec3(0, kSide, 0)};
        rect.radiance = point.radiant_intensity / static_cast<float>(kSide * kSide);
        DiskLight disk;
        disk.center = point.position;
        disk.radius = kSide / std::sqrt(kPi);
        disk.radiance = rect.radiance;
        for (const Light& light : {Light(rect), Light(disk)}) {
            scene.lights = {light};
            const Still still = render(scene, settings);
            for (const auto part : {&Still::scattering, &Still::surface_lit}) {
                const std::vector<float>& expected = of_point.*part;
                const double brightest = *std::max_element(expected.begin(), expected.end());
                const double miss =
                    max_difference(picture_of(still, still.*part), picture_of(of_point, expected));
                figure(fmt::format("{}, from the point light", mode_name(settings.mode)),
                       miss / brightest);
                EXPECT_GT(brightest, 0);
                EXPECT_LT(miss, 1e-4 * brightest) << mode_name(settings.mode);
            }
        }
    }
}

// A sheet half way between a light and the ground, whose edge is along y: its penumbra is as wide
// as the light.
TEST_F(AreaLights, ThePenumbraOfASheetIsTheQuadratures)
{
    constexpr int kSize = 64;
    Scene scene = ground_scene(kSize);
    BoxSurface sheet;
    sheet.min = {-10, -10, 1.999};
    sheet.max = {0, 10, 2.001};
    scene.surfaces.emplace_back(sheet);
    scene.camera.position.z = 1.5;  // below the sheet
    RectLight light;
    light.center = {0, 0, 4};
    light.edges = {glm::dvec3(2, 0, 0), glm::dvec3(0, 2, 0)};
    light.radiance = glm::vec3(5);
    scene.lights = {light};
    const Still still = render(scene, plain_settings());
    double worst = 0, sum2 = 0, sum = 0, open = 0;
    for (int x = 0; x < kSize; ++x) {
        const glm::dvec2 p = ground_at(scene, x, kSize / 2);
        constexpr int kPoints = 400;
        double expected = 0;
        for (int i = 0; i < kPoints; ++i)
            for (int j = 0; j < kPoints; ++j) {
                const glm::dvec3 at((i + 0.5) / kPoints * 2 - 1, (j + 0.5) / kPoints * 2 - 1, 4);
                if (p.x + at.x < 0)
                    continue;  // through the sheet
                const glm::dvec3 to = at - glm::dvec3(p, 0);
                const double d2 = glm::dot(to, to);
                expected += 5 * 16 / (d2 * d2) * 4 / (kPoints * kPoints);
            }
        const double found = kPi / 0.5 * double{pixel(still.composite, kSize, x, kSize / 2).r};
        worst = std::max(worst, std::abs(found - expected));
        sum += (found - expected) / kSize;
        sum2 += (found - expected) * (found - expected) / kSize;
        open = std::max(open, expected);
    }
    figure("penumbra, largest error over the open light", worst / open);
    figure("penumbra, RMS", std::sqrt(sum2) / open);
    figure("penumbra, mean", sum / open);
    // It goes down in 16 steps: half of one at most, and 1 / sqrt(12) of one in the RMS of a
    // penumbra, which is half of the picture; and what the texels of the shadow map blur.
    EXPECT_LT(worst, 0.5 / 16 * 1.1 * open);
    EXPECT_LT(std::sqrt(sum2), 1 / std::sqrt(12.0) / 16 * open);
    EXPECT_LT(std::abs(sum), 2e-3 * open);
}

class AreaLightsAgree : public AreaLights {
protected:
    /// A rectangle over a ball and the ground, in the medium, and a disk beside it, out of it.
    static Scene lit(const Medium& medium)
    {
        Scene scene = empty_scene(24);
        scene.camera.vfov_deg = 40;
        scene.media = {medium};
        SphereSurface ball;
        ball.center = {0.2, -5, 0.2};
        ball.radius = 0.5;
        BoxSurface ground;
        ground.min = {-6, -12, -1.6};
        ground.max = {6, 1, -1.5};
        scene.surfaces = {ball, ground};
        RectLight rect;  // from one side its light would have an edge in the picture
        rect.center = {0, -5, 1.3};
        rect.edges = {glm::dvec3(1.2, 0, 0), glm::dvec3(0, 0.8, 0)};
        rect.radiance = glm::vec3(4, 3, 2);
        rect.two_sided = true;
        DiskLight disk;
        disk.center = {-1.6, -4.6, 0};
        disk.normal = {1, -0.3, 0.2};
        disk.radius = 0.4;
        disk.radiance = glm::vec3(2, 3, 4);
        scene.lights = {rect, disk};
        return scene;
    }

    /// Of frames whose jitter differs, all of pixels' centres.
    static Still averaged(const Scene& scene, const Settings& settings)
    {
        constexpr int kFrames = 16;
        Still sum;
        for (unsigned seed = 0; seed < kFrames; ++seed) {
            StillOptions options;
            options.seed = seed;
            const Still still = scene_renderer().render(scene, settings, options);
            if (seed == 0) {
                sum = still;
                continue;
            }
            for (std::size_t i = 0; i < sum.scattering.size(); ++i)
                sum.scattering[i] += still.scattering[i];
        }
        for (float& value : sum.scattering)
            value /= kFrames;
        return sum;
    }

    /// Where both see the same: at the edge of the ball, which is one of triangles here, they
    /// don't.
    static std::vector<float> where_alike(const std::vector<float>& rgb, const Still& still,
                                          const study::ReferenceStill& truth)
    {
        std::vector<float> alike;
        for (std::size_t i = 0; i < truth.depth.size(); ++i)
            if (std::abs(still.depth[i] / truth.depth[i] - 1) < 0.01f)
                alike.insert(alike.end(), &rgb[3 * i], &rgb[3 * i] + 3);
        return alike;
    }

    struct Agreement {
        study::Metrics scattering, surfaces;
    };
    static Agreement agreement(const Scene& scene, const Settings& settings,
                               const study::ReferenceStill& truth)
    {
        const Still still = averaged(scene, settings);
        const auto compare = [&](const std::vector<float>& found,
                                 const std::vector<float>& expected) {
            return study::compare(where_alike(found, still, truth),
                                  where_alike(expected, still, truth));
        };
        return {compare(still.scattering, truth.scattering),
                compare(still.surface_lit, truth.surface_lit)};
    }

    /// In both modes, the surfaces too.
    /// @param relmse more than with point lights in their middle, which tell what the mode itself
    /// errs by on this medium
    static void expect_agreement(const char* name, const Scene& scene, double relmse, double bias)
    {
        Scene points = scene;
        for (Light& light : points.lights)
            light = PointLight{position_of(light).at, 0.6f * power_of(light)};
        study::ReferenceOptions options;
        options.tolerance = 0.02;
        const study::ReferenceStill truth = study::render_reference(scene, options);
        const study::ReferenceStill truth_of_points = study::render_reference(points, options);
        Settings march;
        march.resolution = 1;
        march.bounces = 0;
        Settings froxels;
        froxels.bounces = 0;
        froxels.mode = Settings::Mode::froxel;
        froxels.tile = 1;
        froxels.slices = 128;
        for (const Settings& settings : {march, froxels}) {
            const Agreement found = agreement(scene, settings, truth);
            const Agreement with_points = agreement(points, settings, truth_of_points);
            const auto expect = [&](const char* part, const study::Metrics& metrics,
                                    const study::Metrics& of_points) {
                const std::string place =
                    fmt::format("{}, {}, {}", name, mode_name(settings.mode), part);
                figure(place + ": relMSE", metrics.relmse);
                figure(place + ": relMSE of points", of_points.relmse);
                figure(place + ": bias", metrics.bias);
                figure(place + ": bias of points", of_points.bias);
                EXPECT_LT(metrics.relmse, relmse + of_points.relmse) << place;
                EXPECT_LT(std::abs(metrics.bias), bias) << place;
            };
            expect("scattering", found.scattering, with_points.scattering);
            expect("surfaces lit through the media", found.surfaces, with_points.surfaces);
        }
    }
};

TEST_F(AreaLightsAgree, InFog)
{
    BoxMedium fog;
    fog.min = {-2, -7, -1.5};
    fog.max = {2, -3, 2};
    fog.sigma_s = glm::vec3(0.15f, 0.2f, 0.25f);
    fog.sigma_a = glm::vec3(0.02f);
    fog.g = 0.5f;
    expect_agreement("fog", lit(fog), 1.5e-3, 0.01);
}

TEST_F(AreaLightsAgree, InSmoke)
{
    const glm::dmat4 world_from_lump =
        glm::scale(glm::translate(glm::dmat4(1.0), {-0.9, -5.7, -1.0}), glm::dvec3(0.11));
    GridMedium smoke;
    smoke.density = lump(world_from_lump);
    smoke.sigma_s_per_density = glm::vec3(2, 3, 4);
    smoke.sigma_a_per_density = glm::vec3(0.3f);
    smoke.g = 0.3f;
    Scene scene = lit(smoke);
    scene.resolution = {16, 16};
    expect_agreement("smoke", scene, 1.5e-3, 0.01);
}

}  // namespace
}  // namespace fumarole::test
