#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <vector>

#include "study/reference.h"
#include "study/reference_cache.h"
#include "study/reference_quadrature.h"
#include "support/reference_scenes.h"

// Light that surfaces reflect on, and that they emit, against closed forms.

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;

/// The mean of samples across the picture is the truth, and so is each to its error.
void expect_near_truth(const Scene& scene, glm::dvec3 truth, double tolerance, int bounces,
                       int surface_bounces, int points = 8)
{
    const Reference reference(scene, tolerance, bounces, surface_bounces);
    glm::dvec3 mean(0);
    double squares = 0, errors = 0, of_asked = 0;
    for (int i = 0; i < points; ++i) {
        const glm::dvec2 at(scene.resolution.x * (0.4 + 0.2 * std::fmod(0.618 * i, 1.0)),
                            scene.resolution.y * (0.4 + 0.2 * (i + 0.5) / points));
        const ReferenceSample s = reference.sample(at, 0);
        of_asked += s.error / (tolerance * largest(s.composite)) / points;
        mean += s.composite / static_cast<double>(points);
        const double error = std::max(s.error, 1e-5 * largest(truth));
        squares += std::pow(largest(s.composite - truth) / error, 2) / points;
        errors += error * error / 4;
    }
    // Where a point's samples end is told by as many others, so they may say more.
    EXPECT_LT(of_asked, 1.5);
    EXPECT_LT(std::sqrt(squares), 1.5) << mean.x << " not " << truth.x;
    EXPECT_LT(largest(mean - truth), 3.5 * std::sqrt(errors) / points)
        << mean.x << " " << mean.y << " " << mean.z << " not " << truth.x << " " << truth.y << " "
        << truth.z;
}

BoxSurface wall(glm::dvec3 min, glm::dvec3 max, glm::vec3 albedo, glm::vec3 emission)
{
    BoxSurface box;
    box.min = min;
    box.max = max;
    box.albedo = albedo;
    box.emission = emission;
    return box;
}

/// The eye in the middle of a closed room whose walls all reflect and emit alike.
Scene closed_room(glm::vec3 albedo, glm::vec3 emission)
{
    Scene scene = looking();
    scene.camera.vfov_deg = 80;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            glm::dvec3 min(-2), max(2);
            (side < 0 ? max : min)[axis] = side;
            scene.surfaces.emplace_back(wall(min, max, albedo, emission));
        }
    return scene;
}

/// Exponential integral E3, which twice is what a slab lets through of diffuse light.
double e3(double depth)
{
    constexpr int kSteps = 200000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double mu = (i + 0.5) / kSteps;
        sum += mu * std::exp(-depth / mu) / kSteps;
    }
    return sum;
}

const glm::vec3 kAlbedo(0.8f, 0.5f, 0.2f), kGlow(0.5f, 1, 2);

}  // namespace

// ---------------------------------------------------------------------------------- reflections

TEST(ReferenceSurfaces, ClosedRoomIsAsBrightAsAnIntegratingSphere)
{
    const Scene room = closed_room(kAlbedo, kGlow);
    expect_near_truth(room, glm::dvec3(kGlow / (1.0f - kAlbedo)), 0.01, 0, kAllBounces);
}

TEST(ReferenceSurfaces, EachReflectionIsAnOrderOfTheRoomsSeries)
{
    const Scene room = closed_room(kAlbedo, kGlow);
    glm::dvec3 sum(kGlow), order(kGlow);
    for (int n = 0; n < 4; ++n) {  // seen, and with no surface bounces, reflected where it is seen
        order *= glm::dvec3(kAlbedo);
        sum += order;
        expect_near_truth(room, sum, 0.01, 0, n);
    }
}

TEST(ReferenceSurfaces, WhiteSmokeInARoomChangesNothing)
{
    Scene room = closed_room(kAlbedo, kGlow);
    BoxMedium smoke = fog({-0.9, -0.7, -0.9}, {0.9, 0.9, 0.8}, {2, 1, 0.5}, glm::vec3(0));
    smoke.g = 0.3f;
    room.media.emplace_back(smoke);
    expect_near_truth(room, glm::dvec3(kGlow / (1.0f - kAlbedo)), 0.04, kAllBounces, kAllBounces,
                      4);
}

TEST(ReferenceSurfaces, SmokeThatEmitsWhatItAbsorbsChangesNothing)
{
    Scene room = closed_room(kAlbedo, kGlow);
    BoxMedium smoke = fog({-0.9, -0.7, -0.9}, {0.9, 0.9, 0.8}, {2, 1, 0.5}, {0.5f, 1, 2});
    smoke.emission = smoke.sigma_a * kGlow / (1.0f - kAlbedo);
    room.media.emplace_back(smoke);
    expect_near_truth(room, glm::dvec3(kGlow / (1.0f - kAlbedo)), 0.04, kAllBounces, kAllBounces,
                      4);
}

TEST(ReferenceSurfaces, PlatesLightEachOtherThroughWhatIsBetween)
{
    // A floor that glows under a ceiling, both without end; between them a slab that absorbs.
    const glm::dvec3 floor_albedo(0.6, 0.3, 0.9), ceiling_albedo(0.7, 0.5, 0.2), glow(1, 2, 0.5);
    Scene scene = looking();
    scene.camera.look_at = {0, 1, 0.5};  // at the ceiling
    constexpr double kFar = 1e5;
    scene.surfaces = {wall({-kFar, -kFar, -2}, {kFar, kFar, -1}, floor_albedo, glow),
                      wall({-kFar, -kFar, 1}, {kFar, kFar, 2}, ceiling_albedo, glm::vec3(0))};
    const auto ceiling = [&](glm::dvec3 through) {
        return ceiling_albedo * through * glow /
               (1.0 - floor_albedo * ceiling_albedo * through * through);
    };
    expect_near_truth(scene, ceiling(glm::dvec3(1)), 0.01, 0, kAllBounces);
    // By one reflection after the ceiling's own nothing comes: the ceiling is dark itself.
    for (const int n : {0, 1})
        expect_near_truth(scene, ceiling_albedo * glow, 0.01, 0, n);
    const glm::dvec3 sigma(0.1, 0.5, 1.5);
    const double thickness = 0.4;
    scene.media = {fog({-kFar, -kFar, -0.9}, {kFar, kFar, -0.9 + thickness}, glm::vec3(0), sigma)};
    glm::dvec3 through;
    for (int c = 0; c < 3; ++c)
        through[c] = 2 * e3(sigma[c] * thickness);
    expect_near_truth(scene, ceiling(through), 0.01, 0, kAllBounces);
    const ReferenceSample s = Reference(scene, 0.01, 0, kAllBounces).sample({0.5, 0.5}, 0);
    EXPECT_LT(largest(s.surface - ceiling(glm::dvec3(1))), 0.01) << "without the medium";
}

TEST(ReferenceSurfaces, LitFloorLightsTheMediumAboveIt)
{
    // A sun from above; the eye looks level through thin fog. Half of all directions are the
    // floor's, whatever g, since a level ray has as much of the phase above as below it.
    const glm::dvec3 albedo(0.9, 0.4, 0.1), sun(2, 3, 4), sigma_s(1e-3, 2e-3, 3e-3);
    Scene scene = looking();
    scene.lights.emplace_back(SunLight{{0, 0, 1}, sun});
    constexpr double kFar = 1e5;
    scene.surfaces = {wall({-kFar, -kFar, -3}, {kFar, kFar, -2}, albedo, glm::vec3(0))};
    scene.camera.far = 100;
    for (const float g : {0.0f, 0.6f}) {
        BoxMedium box = fog({-0.5, 1, -0.5}, {0.5, 2, 0.5}, sigma_s, glm::vec3(0));
        box.g = g;
        scene.media = {box};
        const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g, 1.5));
        const Reference straight(scene, 1e-3, 0), bounced(scene, 0.01, 0, 1);
        const glm::dvec3 direct = sigma_s * sun * phase;
        const ReferenceSample a = straight.sample({0.5, 0.5}, 0), b = bounced.sample({0.5, 0.5}, 0);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(a.scattering[c], direct[c], 0.005 * direct[c]);
            const double floor = sigma_s[c] * albedo[c] * sun[c] / kPi / 2;
            EXPECT_NEAR(b.scattering[c] - direct[c], floor, 0.02 * (direct[c] + floor));
        }
    }
}

// ------------------------------------------------------------------------------------- emission

TEST(ReferenceSurfaces, GlowingBallLightsTheFloorAsItsSolidAngleSays)
{
    Scene scene = looking();
    scene.camera.look_at = {0, 1e-4, -1};  // at the floor under it
    SphereSurface ball;
    ball.center = {0, 0, 2};
    ball.radius = 0.1;
    ball.albedo = glm::vec3(0);
    ball.emission = {30, 20, 10};
    scene.surfaces = {wall({-9, -9, -2}, {9, 9, -1}, kAlbedo, glm::vec3(0)), ball};
    const double share = std::pow(ball.radius / 3, 2);
    scene.camera.vfov_deg = 0.1;
    expect_near_truth(scene, glm::dvec3(kAlbedo * ball.emission) * share, 0.01, 0, 0);
    // The eye sees it.
    scene.camera.look_at = {0, 1e-4, 1};
    expect_near_truth(scene, ball.emission, 0.01, 0, 0, 1);
    // Without a field of light it is seen, and lights nothing.
    EXPECT_EQ(Reference(scene, 0.01, kLampsAndWorldOnce).sample({0.5, 0.5}, 0).surface_lit,
              glm::dvec3(ball.emission));
    scene.camera.look_at = {0, 1e-4, -1};
    EXPECT_EQ(Reference(scene, 0.01, kLampsAndWorldOnce).sample({0.5, 0.5}, 0).surface_lit,
              glm::dvec3(0));
}

TEST(ReferenceSurfaces, GlowingPanelLightsAsItsAreaSays)
{
    const glm::dvec3 low(0.5, -0.3, 1), high(1.5, 0.6, 1.05), glow(4, 5, 6);
    const auto box = wall(low, high, glm::vec3(0), glow);
    auto mesh = std::make_shared<Mesh>();
    for (const auto& [x, y] : {std::pair(low.x, low.y), std::pair(high.x, low.y),
                               std::pair(high.x, high.y), std::pair(low.x, high.y)})
        mesh->positions.emplace_back(x, y, low.z);
    mesh->triangles = {0, 1, 2, 0, 2, 3};
    MeshSurface panel;
    panel.mesh = mesh;
    panel.albedo = glm::vec3(0);
    panel.emission = glow;
    // The floor is at z = -1, two metres under the panel's lower face; the box's sides aren't seen
    // but for one, at x = 0.5.
    const auto received = [](glm::dvec3 corner, glm::dvec3 u, glm::dvec3 v) {
        constexpr int kSteps = 400;
        const glm::dvec3 p(0, 0, -1), normal = glm::normalize(glm::cross(u, v));
        double sum = 0;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j) {
                const glm::dvec3 to = corner + (i + 0.5) / kSteps * u + (j + 0.5) / kSteps * v - p;
                sum += to.z * std::abs(glm::dot(to, normal)) / std::pow(glm::dot(to, to), 2);
            }
        return sum * glm::length(glm::cross(u, v)) / (kSteps * kSteps);
    };
    const glm::dvec3 x(high.x - low.x, 0, 0), y(0, high.y - low.y, 0), z(0, 0, high.z - low.z);
    const double under = received(low, x, y), beside = received(low, y, z);
    Scene scene = looking();
    scene.camera.look_at = {0, 1e-4, -1};
    scene.camera.vfov_deg = 0.1;
    for (const bool as_box : {true, false}) {
        scene.surfaces = {wall({-9, -9, -2}, {9, 9, -1}, kAlbedo, glm::vec3(0))};
        if (as_box)
            scene.surfaces.emplace_back(box);
        else
            scene.surfaces.emplace_back(panel);
        expect_near_truth(scene, glm::dvec3(kAlbedo) * glow / kPi * (under + (as_box ? beside : 0)),
                          0.01, 0, 0);
    }
}

TEST(ReferenceSurfaces, GlowingBallLightsAMediumAsItsSolidAngleSays)
{
    SphereSurface ball;
    ball.center = {0, 1.5, 2};
    ball.radius = 0.5;
    ball.albedo = glm::vec3(0);
    ball.emission = {3, 2, 1};
    Scene scene = looking();
    scene.surfaces = {ball};
    const double sigma = 1e-3, radius2 = ball.radius * ball.radius;
    scene.media = {fog({-0.1, 1, -0.1}, {0.1, 2, 0.1}, glm::vec3(1e-3f), glm::vec3(0))};
    double share = 0;  // of all directions, along the ray
    constexpr int kSteps = 1000;
    for (int i = 0; i < kSteps; ++i) {
        const double y = (i + 0.5) / kSteps - 0.5, sine2 = radius2 / (4 + y * y);
        share += (1 - std::sqrt(1 - sine2)) / 2 / kSteps;
    }
    const ReferenceSample s = Reference(scene, 0.005, 0).sample({0.5, 0.5}, 0);
    for (int c = 0; c < 3; ++c) {
        const double truth = sigma * share * static_cast<double>(ball.emission[c]);
        EXPECT_NEAR(s.scattering[c], truth, 0.01 * truth);
    }
}

// ------------------------------------------------------------------------------------- as a whole

TEST(ReferenceSurfaces, KeepNoReferenceForAnother)
{
    const Scene room = closed_room(kAlbedo, kGlow);
    ReferenceOptions none, one, all;
    one.surface_bounces = 1;
    all.surface_bounces = kAllBounces;
    const auto key = [&](const ReferenceOptions& options) {
        return reference_key(room, options, "1.0");
    };
    EXPECT_EQ(key(none), key(ReferenceOptions()));
    EXPECT_NE(key(none), key(one));
    EXPECT_NE(key(one), key(all));
}

TEST(ReferenceSurfaces, PictureIsWithinItsTolerance)
{
    Scene room = closed_room(kAlbedo, kGlow);
    room.resolution = {6, 4};
    ReferenceOptions options;
    options.tolerance = 0.02;
    options.surface_bounces = kAllBounces;
    const ReferenceStill still = render_reference(room, options);
    const glm::vec3 truth = kGlow / (1.0f - kAlbedo);
    double noise = 0, off = 0;
    for (std::size_t i = 0; i < still.composite.size(); ++i) {
        const double error =
            (still.composite[i] - truth[static_cast<int>(i % 3)]) / truth[static_cast<int>(i % 3)];
        EXPECT_LT(std::abs(error), 0.04);
        off += error * error;
        noise += std::pow(still.noise[i] / truth[static_cast<int>(i % 3)], 2);
    }
    // Of 72 numbers, each known by one difference.
    EXPECT_GT(noise, 0.4 * off);
    EXPECT_LT(noise, 2.5 * off);
}

}  // namespace fumarole::study
