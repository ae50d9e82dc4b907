#include "study/reference.h"

#include <atomic>
#include <cmath>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <oneapi/tbb/global_control.h>
#include <random>

#include "study/reference_media.h"
#include "study/reference_world.h"
#include "support/reference_scenes.h"

// The reference against closed forms, against quadrature and a Monte Carlo estimator that share
// nothing with it, and against itself.

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTight = 1e-8;

ReferenceSample centre(const Scene& scene, double tolerance = kTight)
{
    return Reference(scene, tolerance, 0).sample(glm::dvec2(scene.resolution) / 2.0, 0);
}

void expect_near(glm::dvec3 value, glm::dvec3 expected, double relative)
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(value[c], expected[c], relative * std::max(std::abs(expected[c]), 1e-9))
            << "channel " << c;
}

/// Midpoint rule: plain, so that it can be trusted.
template <class F> auto midpoints(const F& f, double a, double b, int n)
{
    auto sum = 0.0 * f(a);
    for (int i = 0; i < n; ++i)
        sum += f(a + (b - a) * (i + 0.5) / n) * ((b - a) / n);
    return sum;
}

}  // namespace

TEST(Reference, UniformSlabDimsAndGlowsByBeerAndLambert)
{
    // One channel has no extinction: emission alone grows with length.
    Scene scene = looking();
    BoxMedium slab = fog({-5, 2, -5}, {5, 5, 5}, glm::vec3(0), {0.4f, 2, 0});
    slab.emission = {1, 3, 0.5f};
    scene.media.emplace_back(slab);
    const ReferenceSample s = centre(scene);
    const glm::dvec3 sigma(slab.sigma_a);
    expect_near(s.transmittance, glm::exp(-3.0 * sigma), 1e-12);
    expect_near(
        s.scattering,
        {(1 - std::exp(-3 * sigma.x)) / sigma.x, 3 * (1 - std::exp(-3 * sigma.y)) / sigma.y, 1.5},
        1e-6);
}

TEST(Reference, LinearRampOfVoxelsIsIntegratedExactly)
{
    Scene scene = looking();
    scene.camera.position = {3.3, -4, 3.7};
    scene.camera.look_at = {3.3, 1, 3.7};
    GridMedium ramp = grid_medium(8, [](glm::ivec3 at) { return 0.125 * at.y; });
    ramp.sigma_a_per_density = {1, 0.5f, 0.25f};
    ramp.sigma_s_per_density = glm::vec3(0);
    scene.media.emplace_back(ramp);
    // 0.125 y over 0..7, and from 0.875 down to 0 in the voxel past the last.
    const double column = 0.125 * 24.5 + 0.875 / 2;
    expect_near(centre(scene).transmittance, glm::exp(-column * glm::dvec3(1, 0.5, 0.25)), 1e-12);
}

TEST(Reference, HeightFogHasItsClosedForm)
{
    Scene scene = looking();
    scene.camera.look_at = {0, 3, 1};
    BoxMedium box = fog({-50, 1, -20}, {50, 11, 30}, glm::vec3(0), {0.3f, 0.2f, 0.1f});
    box.profile = ExpHeightProfile{2.5, 0.5};
    scene.media.emplace_back(box);
    const double up = 1 / std::sqrt(10.0), across = 3 / std::sqrt(10.0);
    const double t0 = 1 / across, t1 = 11 / across, h = 2.5;
    const double column =
        std::exp(0.5 / h) * h / up * (std::exp(-up * t0 / h) - std::exp(-up * t1 / h));
    expect_near(centre(scene).transmittance, glm::exp(-column * glm::dvec3(box.sigma_a)), 1e-6);
}

TEST(Reference, PointLightInUniformFogAgreesWithPlainQuadrature)
{
    Scene scene = looking();
    const glm::dvec3 light(0.05, 6, 0.1);
    BoxMedium box = fog({-20, 0.5, -20}, {20, 14, 20}, {0.1f, 0.2f, 0.05f}, glm::vec3(0.02f));
    box.g = 0.5f;
    scene.media.emplace_back(box);
    scene.lights.emplace_back(PointLight{light, {3, 2, 1}});
    const glm::dvec3 sigma_s(box.sigma_s), sigma_t = sigma_s + glm::dvec3(box.sigma_a);
    const auto source = [&](double t) {
        const glm::dvec3 to = light - glm::dvec3(0, t, 0);
        const double d = glm::length(to), g = 0.5;
        const double cosine = glm::dot(-to / d, glm::dvec3(0, -1, 0));
        const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
        return sigma_s * glm::dvec3(3, 2, 1) * phase / (d * d) * glm::exp(-sigma_t * (t - 0.5 + d));
    };
    expect_near(centre(scene).scattering, midpoints(source, 0.5, 14, 400000), 1e-6);
}

TEST(Reference, SlabShadesItselfFromTheSun)
{
    // Sun straight above, the ray level: every point is under the same depth of fog.
    Scene scene = looking();
    scene.media.emplace_back(
        fog({-1000, 1, -5}, {1000, 4, 2}, {0.3f, 0.1f, 0.6f}, {0.1f, 0.2f, 0}));
    scene.lights.emplace_back(SunLight{{0, 0, 1}, {2, 3, 4}});
    const glm::dvec3 sigma_s(0.3f, 0.1f, 0.6f), sigma_t = sigma_s + glm::dvec3(0.1f, 0.2f, 0);
    const glm::dvec3 expected = sigma_s * glm::dvec3(2, 3, 4) / (4 * kPi) *
                                glm::exp(-2.0 * sigma_t) * (1.0 - glm::exp(-3.0 * sigma_t)) /
                                sigma_t;
    expect_near(centre(scene).scattering, expected, 1e-6);
}

TEST(Reference, BallCutsItsShadowOutOfTheSunsLight)
{
    // Thin fog, lit over 10 m but for the ball's shadow: 2 m of it, at the shadow's middle.
    Scene scene = looking();
    constexpr float kSigma = 1e-9f;
    scene.media.emplace_back(fog({-50, 1, -50}, {50, 11, 50}, glm::vec3(kSigma), glm::vec3(0)));
    scene.lights.emplace_back(SunLight{{0, 0, 1}, glm::vec3(1)});
    scene.surfaces.emplace_back(SphereSurface{{0, 6, 5}, 1, glm::vec3(0.5f)});
    expect_near(centre(scene).scattering, glm::dvec3(8 * double(kSigma) / (4 * kPi)), 1e-6);
}

TEST(Reference, PositiveGScattersForward)
{
    const auto towards_sun = [](float g, double side) {
        Scene scene = looking();
        BoxMedium box = fog({-5, 2, -5}, {5, 3, 5}, glm::vec3(1e-6f), glm::vec3(0));
        box.g = g;
        scene.media.emplace_back(box);
        scene.lights.emplace_back(SunLight{{0, side, 0}, glm::vec3(1)});
        return centre(scene).scattering.x;
    };
    EXPECT_GT(towards_sun(0.6f, 1), 10 * towards_sun(0.6f, -1));
    EXPECT_NEAR(towards_sun(0.6f, 1), towards_sun(-0.6f, -1), 1e-12);
}

TEST(Reference, WorldIsDimmedOnItsWayIntoTheMiddleOfASlab)
{
    // In an endless slab, a place z below the top and d - z above the bottom gets
    // (E2(sigma z) + E2(sigma (d - z))) / 2 of a constant world: single scattering is no furnace.
    Scene scene = looking();
    scene.world.radiance = glm::vec3(1);
    constexpr double kSigma = 1;
    scene.media.emplace_back(fog({-500, -500, -1}, {500, 500, 1}, glm::vec3(kSigma), glm::vec3(0)));
    const auto e2 = [](double x) {
        return midpoints([&](double u) { return std::exp(-x / u); }, 0, 1, 200000);
    };
    const Reference reference(scene, 1e-4, 0);
    for (const double z : {0.0, 0.5, 0.9}) {
        const double expected = (e2(kSigma * (1 - z)) + e2(kSigma * (1 + z))) / 2;
        const glm::dvec3 got = reference.world_in_scattering({0.3, 0.2, z}, {0, -1, 0}, 0);
        EXPECT_NEAR(got.x, expected, 2e-4 * expected) << z;
    }
}

TEST(Reference, ThinMediumInAConstantWorldIsAFurnace)
{
    // With nothing to dim it the phase integrates to 1, whatever g, and 1 - T + T = 1 to the first
    // order of sigma.
    Scene scene = looking();
    scene.world.radiance = glm::vec3(1);
    BoxMedium box = fog({-2, 2, -2}, {2, 4, 2}, glm::vec3(1e-6f), glm::vec3(0));
    box.g = 0.6f;
    scene.media.emplace_back(box);
    expect_near(centre(scene, 1e-3).composite, glm::dvec3(1), 1e-9);
}

// The world's light from a map, in place and by a plain sum over a fine grid of directions.
TEST(Reference, MapOfTheWorldLightsMediaAndSurfaces)
{
    Scene scene = blob_scene();
    scene.lights.clear();
    scene.world = lamp_world();
    const Reference reference(scene, 2e-3, 0);
    const ReferenceMedia media(scene, 1e-4);
    const ReferenceSurfaces surfaces(scene.surfaces);
    const WorldRadiance world(scene.world);
    constexpr int kRows = 300, kColumns = 600;
    const auto over_all = [&](const auto& f) {
        glm::dvec3 sum(0);
        for (int i = 0; i < kRows; ++i)
            for (int j = 0; j < kColumns; ++j) {
                const double z = -1 + 2 * (i + 0.5) / kRows, phi = 2 * kPi * (j + 0.5) / kColumns;
                const double r = std::sqrt(1 - z * z);
                sum += 4 * kPi / kRows / kColumns *
                       f(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
            }
        return sum;
    };
    const auto seen = [&](const Origin& from, glm::dvec3 wi) {
        if (surfaces.hidden(from, wi, kInfinity))
            return glm::dvec3(0);
        return world(wi) * glm::exp(-media.optical_depth({from.p, wi}, kInfinity));
    };
    for (const double g : {-0.3, 0.0, 0.9}) {
        const glm::dvec3 p(2.5, 2, 3), wo = glm::normalize(glm::dvec3(0.2, -1, -0.4));
        const glm::dvec3 plain = over_all([&](glm::dvec3 wi) {
            return phase_henyey_greenstein(glm::dot(-wi, wo), g) * seen({p, -1, glm::dvec3(0)}, wi);
        });
        expect_near(reference.world_in_scattering(p, wo, g), plain, 6e-3);
    }
    // The ground in a corner of the picture, through whatever medium is before it.
    const ReferenceSample s = reference.sample({1.5, 7.5}, 0);
    const glm::dvec3 f = glm::normalize(scene.camera.look_at - scene.camera.position);
    const glm::dvec3 r = glm::normalize(glm::cross(f, glm::dvec3(0, 0, 1)));
    const double half = std::tan(glm::radians(35.0) / 2);
    const Ray ray{scene.camera.position, glm::normalize(f + half * 1.5 * (1.5 / 6 - 1) * r +
                                                        half * (1 - 7.5 / 4) * glm::cross(r, f))};
    const auto hit = surfaces.intersect(ray, 0.001, 1e6);
    ASSERT_TRUE(hit);
    const glm::dvec3 plain = over_all([&](glm::dvec3 wi) {
        const double cosine = glm::dot(wi, hit->normal);
        return cosine > 0 ? cosine * seen(surfaces.leave(*hit), wi) : glm::dvec3(0);
    });
    expect_near(s.surface_lit, glm::dvec3(hit->albedo) / kPi * plain, 6e-3);
}

TEST(Reference, SurfaceUnderABallSeesLessOfTheWorld)
{
    // A small plane's irradiance beneath a ball straight above: pi (1 - (r / d)^2).
    Scene scene = looking();
    scene.world.radiance = glm::vec3(1);
    scene.camera.look_at = {0, 2, -1};
    scene.surfaces.emplace_back(BoxSurface{{-30, -30, -2}, {30, 30, -1}, glm::vec3(0.5f)});
    scene.surfaces.emplace_back(SphereSurface{{0, 2, 2}, 1.5, glm::vec3(0.5f)});
    const ReferenceSample s = centre(scene, 1e-3);
    expect_near(s.surface, glm::dvec3(0.5 * (1 - 0.25)), 1e-3);
    expect_near(s.surface_lit, s.surface, 1e-12);
}

TEST(Reference, HalvingTheToleranceMovesThePictureLessThanItSays)
{
    const Scene scene = blob_scene();
    const Reference coarse(scene, 0.1, 0), fine(scene, 0.05, 0);
    for (int i = 0; i < 6; ++i) {
        const glm::dvec2 point(2.5 + 1.3 * i, 3.5 + 0.4 * i);
        const ReferenceSample a = coarse.sample(point, 0), b = fine.sample(point, 0);
        EXPECT_LE(glm::length(a.composite - b.composite), a.error + b.error) << i;
        EXPECT_LE(a.error, 0.15 * std::max(glm::length(a.composite), 0.1)) << i;
    }
}

TEST(Reference, RatioTrackingAgreesWithinItsOwnError)
{
    // Unbiased: distances from a majorant, transmittance as a product of null-collision weights
    // (Novak et al. 2014), the world by its phase, lights by one shadow ray each.
    const Scene scene = blob_scene();
    const ReferenceMedia media(scene, 1e-4);
    const ReferenceSurfaces surfaces(scene.surfaces);
    const auto& smoke = std::get<GridMedium>(scene.media[0]);
    const VoxelLookup density(*smoke.density);
    const glm::dvec3 sigma_s(smoke.sigma_s_per_density);
    const glm::dvec3 sigma_t = sigma_s + glm::dvec3(smoke.sigma_a_per_density);
    const double majorant = 1.5 * 1.2;  // largest density times largest sigma_t
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto step = [&] { return -std::log(1 - uniform(random)) / majorant; };
    const auto value = [&](glm::dvec3 p) { return density.sample(p / 0.5).x; };
    const Bounds box{glm::dvec3(-0.5), glm::dvec3(6)};
    const auto through = [&](const Ray& ray, double range) {
        const glm::dvec2 in = box_range(ray, box);
        glm::dvec3 t(1);
        for (double at = std::max(in.x, 0.0) + step(); at < std::min(in.y, range); at += step())
            t *= 1.0 - sigma_t * value(ray.at(at)) / majorant;
        return t;
    };
    const Reference reference(scene, 0.02, 0);
    for (const glm::dvec2 point : {glm::dvec2(6.5, 3.5), glm::dvec2(5.5, 5.5)}) {
        // The ray through a point, from the camera's definition.
        const glm::dvec3 f = glm::normalize(scene.camera.look_at - scene.camera.position);
        const glm::dvec3 r = glm::normalize(glm::cross(f, glm::dvec3(0, 0, 1)));
        const double half = std::tan(glm::radians(35.0) / 2);
        const Ray ray{scene.camera.position,
                      glm::normalize(f + half * 1.5 * (point.x / 6 - 1) * r +
                                     half * (1 - point.y / 4) * glm::cross(r, f))};
        const auto hit = surfaces.intersect(ray, 0.001, 1e6);
        const glm::dvec2 in = box_range(ray, box);
        const double end = std::min(in.y, hit ? hit->t : kInfinity);
        constexpr int kPaths = 20000;
        glm::dvec3 sum(0), squares(0);
        for (int i = 0; i < kPaths; ++i) {
            const double at = in.x + (end - in.x) * uniform(random);
            const glm::dvec3 p = ray.at(at);
            glm::dvec3 light(0);
            const double z = 2 * uniform(random) - 1, phi = 2 * kPi * uniform(random);
            const glm::dvec3 any(std::sqrt(1 - z * z) * std::cos(phi),
                                 std::sqrt(1 - z * z) * std::sin(phi), z);
            const auto phase = [&](glm::dvec3 wi) {
                return phase_henyey_greenstein(glm::dot(wi, ray.direction), double(smoke.g));
            };
            const Origin from{p, -1, glm::dvec3(0)};
            if (!surfaces.hidden(from, any, kInfinity))
                light += 4 * kPi * phase(any) * glm::dvec3(scene.world.radiance) *
                         through({p, any}, kInfinity);
            const auto& sun = std::get<SunLight>(scene.lights[0]);
            if (!surfaces.hidden(from, sun.direction_to_light, kInfinity))
                light += phase(sun.direction_to_light) * glm::dvec3(sun.irradiance) *
                         through({p, sun.direction_to_light}, kInfinity);
            const auto& lamp = std::get<PointLight>(scene.lights[1]);
            const double d = glm::length(lamp.position - p);
            const glm::dvec3 wi = (lamp.position - p) / d;
            if (!surfaces.hidden(from, wi, d))
                light +=
                    phase(wi) * glm::dvec3(lamp.radiant_intensity) / (d * d) * through({p, wi}, d);
            const glm::dvec3 path = (end - in.x) * sigma_s * value(p) * light * through(ray, at);
            sum += path;
            squares += path * path;
        }
        const glm::dvec3 mean = sum / double(kPaths);
        const glm::dvec3 error =
            glm::sqrt((squares / double(kPaths) - mean * mean) / double(kPaths));
        const ReferenceSample s = reference.sample(point, 0);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(s.scattering[c], mean[c], 3.5 * error[c] + s.error) << "channel " << c;
    }
}

TEST(Reference, RegionIsAPartOfTheWholeAndThreadsChangeNothing)
{
    const Scene scene = blob_scene();
    ReferenceOptions options;
    options.tolerance = 0.1;
    const ReferenceStill whole = render_reference(scene, options);
    {
        const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism,
                                              1);
        const ReferenceStill alone = render_reference(scene, options);
        EXPECT_EQ(whole.composite, alone.composite);
        EXPECT_EQ(whole.error, alone.error);
    }
    options.region = ReferenceRegion{4, 2, 5, 3};
    const ReferenceStill part = render_reference(scene, options);
    ASSERT_EQ(part.composite.size(), 45u);
    for (std::size_t y = 0; y < 3; ++y)
        for (std::size_t x = 0; x < 15; ++x)
            EXPECT_EQ(part.composite[y * 15 + x], whole.composite[((y + 2) * 12 + 4) * 3 + x]);
}

TEST(Reference, SceneFarFromTheOriginLooksTheSame)
{
    const auto picture = [](glm::dvec3 shift) {
        Scene scene = blob_scene();
        scene.world.radiance = glm::vec3(0);
        scene.camera.position += shift;
        scene.camera.look_at += shift;
        std::get<GridMedium>(scene.media[0]).translate += shift;
        std::get<SphereSurface>(scene.surfaces[0]).center += shift;
        std::get<BoxSurface>(scene.surfaces[1]).min += shift;
        std::get<BoxSurface>(scene.surfaces[1]).max += shift;
        std::get<PointLight>(scene.lights[1]).position += shift;
        return Reference(scene, 1e-6, 0).sample({6.3, 4.2}, 0).composite;
    };
    expect_near(picture({1e6, -1e6, 1e6}), picture(glm::dvec3(0)), 1e-6);
}

TEST(Reference, CancelEndsIt)
{
    const Scene scene = blob_scene();
    const std::atomic<bool> cancel{true};
    ReferenceOptions options;
    options.cancel = &cancel;
    EXPECT_THROW(render_reference(scene, options), ReferenceCancelled);
}

}  // namespace fumarole::study
