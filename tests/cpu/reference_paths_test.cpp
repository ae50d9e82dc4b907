#include "study/reference_paths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <oneapi/tbb/global_control.h>
#include <random>
#include <string>
#include <vector>

#include "study/metrics.h"
#include "study/reference.h"
#include "support/reference_scenes.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/write/image_writer.h>

// Light scattered many times, against what is known of it: equilibrium, the equation of transfer in
// one dimension, the quadrature where light scatters once, and another path tracer's picture.

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;

/// Samples across the picture, and whether they are what the truth is.
struct Trial {
    double mean = 0;       ///< of (value - truth) / truth over samples and channels
    double rms = 0;        ///< of (value - truth) / error, worst channel
    double outside = 0;    ///< share of samples further from the truth than they say
    double deviation = 0;  ///< expected of `mean`
};

/// @param truth of each channel, the same for all points
Trial try_points(const Scene& scene, glm::dvec3 truth, double tolerance, int bounces, int points)
{
    const Reference reference(scene, tolerance, bounces);
    Trial trial;
    double squares = 0, errors = 0, of_asked = 0;
    for (int i = 0; i < points; ++i) {
        const glm::dvec2 at(scene.resolution.x * (0.35 + 0.3 * std::fmod(0.618 * i, 1.0)),
                            scene.resolution.y * (0.35 + 0.3 * (i + 0.5) / points));
        const ReferenceSample sample = reference.sample(at, 0);
        of_asked += sample.error / (tolerance * largest(sample.composite)) / points;
        double worst = 0;
        for (int c = 0; c < 3; ++c) {
            const double off = sample.composite[c] - truth[c];
            worst = std::max(worst, std::abs(off));
            trial.mean += off / truth[c] / (3 * points);
        }
        // What is exact is as exact as the truth is known.
        const double error = std::max(sample.error, 1e-5 * largest(truth));
        squares += std::pow(worst / error, 2) / points;
        trial.outside += (worst > error ? 1.0 : 0.0) / points;
        errors += std::pow(error / 2 / std::min({truth.x, truth.y, truth.z}), 2);
    }
    // Where a point's samples end is told by as many others, so they may say more.
    EXPECT_LT(of_asked, 1.5);
    trial.rms = std::sqrt(squares);
    trial.deviation = std::sqrt(errors) / points;
    return trial;
}

/// Two samples of three may be a whole error off together in one test of many, three never.
void expect_truth(const Scene& scene, glm::dvec3 truth, double tolerance, int bounces = kAllBounces,
                  int points = 6)
{
    const Trial trial = try_points(scene, truth, tolerance, bounces, points);
    EXPECT_LT(std::abs(trial.mean), 3 * trial.deviation + 1e-6);
    EXPECT_LT(trial.rms, 1.5);
}

/// Looks along +y at a box of 2 m whose front is at y = 1.
Scene before_a_box(glm::vec3 sigma_s, glm::vec3 sigma_a, float g)
{
    Scene scene = looking();
    scene.camera.vfov_deg = 50;
    BoxMedium box = fog({-1, 1, -1}, {1, 3, 1}, sigma_s, sigma_a);
    box.g = g;
    scene.media.emplace_back(box);
    scene.world.radiance = glm::vec3(1);
    return scene;
}

GridMedium blob(float density, float g)
{
    GridMedium smoke = grid_medium(12, smooth_blob, 0.2);
    smoke.translate = {-1.1, 1, -1.1};
    smoke.sigma_s_per_density = density * glm::vec3(1.0f, 0.5f, 0.25f);
    smoke.sigma_a_per_density = glm::vec3(0);
    smoke.g = g;
    return smoke;
}

/// Isotropic scattering in a slab, its optical depth 0 at the top, lit by a sun from above: the
/// equation of transfer along Gauss and Legendre's directions of each half, the source being linear
/// between nodes of optical depth.
class Slab {
public:
    Slab(double depth, double albedo, double sun_cosine, double irradiance)
        : albedo_{albedo}, step_{depth / kLayers}
    {
        for (int i = 0; i <= kLayers; ++i)
            first_.push_back(albedo * irradiance / (4 * kPi) * std::exp(-i * step_ / sun_cosine));
    }

    /// Radiance that leaves the top at a cosine, of light scattered `orders` times at most.
    [[nodiscard]] double leaving(double cosine, int orders) const
    {
        std::vector<double> source = first_;
        for (int order = 1; order < orders; ++order) {
            const std::vector<double> next = gather(source);
            double change = 0;
            for (std::size_t i = 0; i < source.size(); ++i) {
                const double now = first_[i] + next[i];
                change = std::max(change, std::abs(now - source[i]));
                source[i] = now;
            }
            if (change < 1e-12 * first_[0])
                break;
        }
        return sweep(source, cosine, true)[0];
    }

private:
    static constexpr int kLayers = 800;

    /// Radiance at the nodes in a direction that goes up, or down.
    [[nodiscard]] std::vector<double> sweep(const std::vector<double>& source, double cosine,
                                            bool up) const
    {
        const double x = step_ / cosine, through = std::exp(-x);
        // Integrals of the two ends' shares of the source, dimmed on their way.
        const double far = (1 - through) / x - through, near = 1 - (1 - through) / x;
        std::vector<double> radiance(source.size(), 0.0);
        for (std::size_t n = 1; n < source.size(); ++n) {
            const std::size_t to = up ? source.size() - 1 - n : n, from = up ? to + 1 : to - 1;
            radiance[to] = radiance[from] * through + far * source[from] + near * source[to];
        }
        return radiance;
    }

    /// The source of light scattered once more.
    [[nodiscard]] std::vector<double> gather(const std::vector<double>& source) const
    {
        // 8 points of a half, from the roots of P8 by Newton's method.
        static const auto kRule = [] {
            std::array<std::array<double, 2>, 8> rule{};
            for (std::size_t i = 0; i < 8; ++i) {
                double z = std::cos(kPi * (static_cast<double>(i) + 0.75) / 8.5), slope = 1;
                for (int k = 0; k < 20; ++k) {
                    double p = 1, before = 0;
                    for (int j = 1; j <= 8; ++j) {
                        const double two_before = before;
                        before = p;
                        p = ((2 * j - 1) * z * before - (j - 1) * two_before) / j;
                    }
                    slope = 8 * (z * p - before) / (z * z - 1);
                    z -= p / slope;
                }
                rule[i] = {(1 + z) / 2, 1 / ((1 - z * z) * slope * slope)};
            }
            return rule;
        }();
        std::vector<double> next(source.size(), 0.0);
        for (const auto& [cosine, weight] : kRule)
            for (const bool up : {false, true}) {
                const std::vector<double> radiance = sweep(source, cosine, up);
                for (std::size_t i = 0; i < next.size(); ++i)
                    next[i] += albedo_ / 2 * weight * radiance[i];
            }
        return next;
    }

    double albedo_, step_;
    std::vector<double> first_;
};

/// The slab from above, through an orthographic camera at a cosine of 0.8, under a sun at one of
/// 0.6 from another side.
Scene slab_scene(double depth, double albedo)
{
    Scene scene = looking();
    scene.camera.position = {0, -6, 9};
    scene.camera.look_at = {0, 0, 1};
    scene.camera.projection = Camera::Projection::orthographic;
    scene.camera.ortho_height = 1;
    const auto sigma = [&](double share) { return glm::vec3(static_cast<float>(depth * share)); };
    scene.media.emplace_back(
        fog({-1000, -1000, 0}, {1000, 1000, 1}, sigma(albedo), sigma(1 - albedo)));
    scene.lights.emplace_back(SunLight{{0.8, 0, 0.6}, glm::vec3(3)});
    return scene;
}

}  // namespace

// -------------------------------------------------------------------------------------- furnace
// In a world of one radiance all around, a medium that absorbs nothing is not to be seen.

TEST(ReferencePaths, FurnaceIsWhiteWhateverTheDensityAndG)
{
    for (const float density : {0.1f, 1.0f, 10.0f, 50.0f})
        for (const float g : {0.0f, 0.7f, -0.5f}) {
            SCOPED_TRACE(fmt::format("density {}, g {}", density, g));
            expect_truth(before_a_box(glm::vec3(density), glm::vec3(0), g), glm::dvec3(1), 0.02);
        }
}

TEST(ReferencePaths, FurnaceIsWhiteInColouredExtinction)
{
    expect_truth(before_a_box({0.3f, 2, 8}, glm::vec3(0), 0.4f), glm::dvec3(1), 0.02);
}

TEST(ReferencePaths, FurnaceIsWhiteInAGridAndWhereMediaOverlap)
{
    Scene scene = before_a_box({1, 2, 0.5f}, glm::vec3(0), -0.3f);
    const Medium box = scene.media.front();
    scene.media = {blob(8, 0.6f)};
    expect_truth(scene, glm::dvec3(1), 0.02);
    scene.media.push_back(box);
    expect_truth(scene, glm::dvec3(1), 0.02);
}

TEST(ReferencePaths, FurnaceIsWhiteInHeightFogAndInNoise)
{
    Scene scene = before_a_box({3, 2, 1}, glm::vec3(0), 0.5f);
    std::get<BoxMedium>(scene.media[0]).profile = ExpHeightProfile{.scale_height = 0.6, .z0 = 0};
    expect_truth(scene, glm::dvec3(1), 0.02);
    NoiseProfile noise;
    noise.feature_size = 0.7;
    noise.threshold = 0.3;
    std::get<BoxMedium>(scene.media[0]).profile = noise;
    expect_truth(scene, glm::dvec3(1), 0.02);
}

TEST(ReferencePaths, FurnaceIsWhiteUnderAMapOfOneColour)
{
    auto map = std::make_shared<Environment>();
    map->width = 8;
    map->height = 4;
    map->radiance.assign(32, glm::vec3(1));
    Scene scene = before_a_box({1, 2, 4}, glm::vec3(0), 0.5f);
    scene.world = {};
    scene.world.environment = map;
    expect_truth(scene, glm::dvec3(1), 0.02);
}

// By Kirchhoff's law: what emits as much as it absorbs at the world's radiance is not to be seen
// either. Emission at every order.
TEST(ReferencePaths, FurnaceIsWhiteWhereMediaEmitWhatTheyAbsorb)
{
    Scene scene = before_a_box({2, 1, 3}, {1, 2, 0.5f}, 0.4f);
    std::get<BoxMedium>(scene.media[0]).emission = {1, 2, 0.5f};
    expect_truth(scene, glm::dvec3(1), 0.01);
    GridMedium smoke = blob(6, 0.3f);
    smoke.sigma_a_per_density = {2, 3, 4};
    smoke.emission = smoke.density;
    smoke.emission_per_unit = {2, 3, 4};
    scene.media = {smoke};
    expect_truth(scene, glm::dvec3(1), 0.01);
}

// ----------------------------------------------------------------------------------------- slab

TEST(ReferencePaths, SlabReflectsWhatTheEquationOfTransferSays)
{
    for (const double albedo : {0.5, 0.9, 0.99}) {
        SCOPED_TRACE(fmt::format("albedo {}", albedo));
        const double truth = Slab(4, albedo, 0.6, 3).leaving(0.8, 10000);
        expect_truth(slab_scene(4, albedo), glm::dvec3(truth), 0.01);
    }
}

TEST(ReferencePaths, EachBounceOfASlabIsAnOrderOfScattering)
{
    const Slab slab(4, 0.9, 0.6, 3);
    for (const int bounces : {0, 1, 2, 5}) {
        SCOPED_TRACE(fmt::format("{} bounces", bounces));
        expect_truth(slab_scene(4, 0.9), glm::dvec3(slab.leaving(0.8, bounces + 1)), 0.01, bounces);
    }
}

TEST(ReferencePaths, ErrorEstimateIsHonest)
{
    const double truth = Slab(4, 0.9, 0.6, 3).leaving(0.8, 10000);
    const Trial trial = try_points(slab_scene(4, 0.9), glm::dvec3(truth), 0.05, kAllBounces, 200);
    EXPECT_LT(trial.outside, 0.12);  // two standard errors, from eight scrambles: 0.085
    EXPECT_GT(trial.rms, 0.3);       // 0.5 were it exact: no more work than asked for
    EXPECT_LT(trial.rms, 0.75);
    EXPECT_LT(std::abs(trial.mean), 3 * trial.deviation);
}

// ------------------------------------------------------------------------------ against quadrature

TEST(ReferencePaths, OfNoBounceAgreeWithTheQuadrature)
{
    for (const bool map : {false, true}) {
        Scene scene = blob_scene();
        if (map)
            scene.world = lamp_world();
        const ReferenceSurfaces surfaces(scene.surfaces);
        const ReferenceMedia media(scene, 1e-4);
        const MediaTracking tracking(media);
        const ReferenceTransparents transparents(scene);
        const WorldRadiance world(scene.world);
        std::vector<ReferenceLight> lights;
        for (const Light& light : scene.lights)
            lights.emplace_back(light);
        const SurfaceEmitters none;
        const ReferencePaths paths(surfaces, transparents, media, tracking, world, lights, none,
                                   {0, 0}, nullptr);
        // Rays through the picture's middle, which an image of one pixel looks along.
        for (const double x : {2.0, 2.75, 3.4}) {
            scene.camera.look_at.x = x;
            const Reference turned(scene, 2e-3, 0);
            const ReferenceSample expected = turned.sample(glm::dvec2(scene.resolution) / 2.0, 0);
            const Ray ray{scene.camera.position,
                          glm::normalize(scene.camera.look_at - scene.camera.position)};
            MediaAlongRay along(media);
            const auto hit = surfaces.intersect(ray, 0.001, 1e6);
            along.set(ray, 0.001, hit ? hit->t : kInfinity);
            const Integral got =
                paths.scattered(ray, ScatteringPlaces(along), {}, 1, {.relative = 0.005}).front();
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(got.value[c], expected.scattering[c], 1.5 * got.error + expected.error)
                    << "x " << x << ", channel " << c;
        }
    }
}

/// The plainest path tracer of one grid: analogue collisions against one majorant, a channel at a
/// time, lights and the way to them by chance of getting there. Shares the surfaces alone.
class PlainPaths {
public:
    explicit PlainPaths(const Scene& scene)
        : scene_{scene}, smoke_{std::get<GridMedium>(scene.media[0])}, density_{*smoke_.density},
          surfaces_{scene.surfaces}
    {
        to_index_ = glm::inverse(smoke_.density->world_from_index);
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {0, 1}) {
                glm::dvec3 corner(smoke_.density->index_min - 1);
                corner[axis] = side == 0 ? corner[axis] : smoke_.density->index_max[axis] + 1;
                box_.add(place(corner));
                corner = glm::dvec3(smoke_.density->index_max + 1);
                corner[axis] = side == 0 ? smoke_.density->index_min[axis] - 1 : corner[axis];
                box_.add(place(corner));
            }
    }

    /// Light of one channel that is scattered once or more on its way to a ray's origin.
    double operator()(Ray ray, int c)
    {
        const double sigma_s = static_cast<double>(smoke_.sigma_s_per_density[c]);
        const double sigma_t = sigma_s + static_cast<double>(smoke_.sigma_a_per_density[c]);
        double sum = 0;
        for (bool seen = false;; seen = true) {
            const double range = surfaces_.distance({ray.origin, -1, glm::dvec3(0)}, ray.direction);
            const double t = fly(ray, range, sigma_t);
            if (t == kInfinity)
                return sum + (seen && range == kInfinity
                                  ? static_cast<double>(scene_.world.radiance[c])
                                  : 0.0);
            if (uniform_(random_) >= sigma_s / sigma_t)
                return sum;
            const glm::dvec3 p = ray.at(t);
            for (const Light& light : scene_.lights) {
                glm::dvec3 wi(0);
                double irradiance = 0, distance = kInfinity;
                if (const auto* sun = std::get_if<SunLight>(&light)) {
                    wi = glm::normalize(sun->direction_to_light);
                    irradiance = static_cast<double>(sun->irradiance[c]);
                } else {
                    const auto& point = std::get<PointLight>(light);
                    distance = glm::length(point.position - p);
                    wi = (point.position - p) / distance;
                    irradiance =
                        static_cast<double>(point.radiant_intensity[c]) / (distance * distance);
                }
                if (!surfaces_.hidden({p, -1, glm::dvec3(0)}, wi, distance) &&
                    fly({p, wi}, distance, sigma_t) == kInfinity)
                    sum += irradiance * phase(glm::dot(wi, ray.direction));
            }
            // A direction by rejection.
            glm::dvec3 to;
            do {
                const double z = 2 * uniform_(random_) - 1, r = std::sqrt(1 - z * z);
                const double phi = 2 * kPi * uniform_(random_);
                to = {r * std::cos(phi), r * std::sin(phi), z};
            } while (uniform_(random_) * phase(smoke_.g > 0 ? 1 : -1) >
                     phase(glm::dot(to, ray.direction)));
            ray = {p, to};
        }
    }

private:
    [[nodiscard]] glm::dvec3 place(glm::dvec3 index) const
    {
        return smoke_.scale * glm::dvec3(smoke_.density->world_from_index * glm::dvec4(index, 1)) +
               smoke_.translate;
    }
    /// Henyey and Greenstein's, anew.
    [[nodiscard]] double phase(double cosine) const
    {
        const double g = static_cast<double>(smoke_.g);
        return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
    }
    /// Where it collides, or infinity.
    double fly(const Ray& ray, double range, double sigma_t)
    {
        const double majorant = sigma_t * static_cast<double>(smoke_.density->max_value);
        const glm::dvec2 in = box_range(ray, box_);
        const double end = std::min(in.y, range);
        for (double t = std::max(in.x, 0.0);;) {
            t -= std::log(1 - uniform_(random_)) / majorant;
            if (!(t < end))
                return kInfinity;
            const glm::dvec3 index = glm::dvec3(
                to_index_ * glm::dvec4((ray.at(t) - smoke_.translate) / double(smoke_.scale), 1));
            if (uniform_(random_) * majorant < sigma_t * density_.sample(index).x)
                return t;
        }
    }

    const Scene& scene_;
    const GridMedium& smoke_;
    VoxelLookup density_;
    ReferenceSurfaces surfaces_;
    glm::dmat4 to_index_{1.0};
    Bounds box_;
    std::mt19937 random_{1};
    std::uniform_real_distribution<double> uniform_{0, 1};
};

TEST(ReferencePaths, AgreeWithThePlainestPathTracer)
{
    Scene scene = blob_scene();
    auto& smoke = std::get<GridMedium>(scene.media[0]);
    smoke.sigma_s_per_density *= 1.5f;
    PlainPaths plain(scene);
    const Reference reference(scene, 0.02, kAllBounces);
    const glm::dvec3 f = glm::normalize(scene.camera.look_at - scene.camera.position);
    const glm::dvec3 r = glm::normalize(glm::cross(f, glm::dvec3(0, 0, 1)));
    const glm::dvec2 size(scene.resolution);
    const double half = std::tan(glm::radians(scene.camera.vfov_deg) / 2);
    for (const glm::dvec2 share : {glm::dvec2(0.54, 0.45), glm::dvec2(0.45, 0.6)}) {
        const glm::dvec2 ndc(2 * share.x - 1, 1 - 2 * share.y);
        const Ray ray{scene.camera.position, glm::normalize(f + half * size.x / size.y * ndc.x * r +
                                                            half * ndc.y * glm::cross(r, f))};
        const ReferenceSample sample = reference.sample(share * size, 0);
        constexpr int kPaths = 20000;
        for (int c = 0; c < 3; ++c) {
            double sum = 0, squares = 0;
            for (int i = 0; i < kPaths; ++i) {
                const double v = plain(ray, c);
                sum += v / kPaths;
                squares += v * v / kPaths;
            }
            const double error = 2 * std::sqrt((squares - sum * sum) / kPaths);
            EXPECT_NEAR(sample.scattering[c], sum, 1.5 * std::hypot(error, sample.error))
                << "channel " << c;
        }
    }
}

// -------------------------------------------------------------------------------------- emission

TEST(Reference, GlowingLayerLightsTheGroundWithoutABounce)
{
    // Radiance e/s (1 - exp(-s d / mu)) from every direction above: irradiance by plain midpoints.
    constexpr double kEmission = 0.7, kSigma = 0.8, kDepth = 2;
    double irradiance = 0;
    for (int i = 0; i < 100000; ++i) {
        const double mu = (i + 0.5) / 100000;
        irradiance +=
            2 * kPi * mu * kEmission / kSigma * (1 - std::exp(-kSigma * kDepth / mu)) / 100000;
    }
    Scene scene = looking();
    scene.camera.position = {0, 0, 0.5};
    scene.camera.look_at = {0, 1, 0};
    scene.surfaces.emplace_back(
        BoxSurface{{-1e5, -1e5, -1}, {1e5, 1e5, 0}, glm::vec3(0.5f, 0.25f, 1)});
    BoxMedium layer = fog({-1e5, -1e5, 1}, {1e5, 1e5, 1 + kDepth}, glm::vec3(0),
                          glm::vec3(static_cast<float>(kSigma)));
    layer.emission = glm::vec3(static_cast<float>(kEmission));
    scene.media.emplace_back(layer);
    const Reference reference(scene, 0.005, 0);
    const ReferenceSample sample = reference.sample({0.5, 0.5}, 0);
    ASSERT_LT(sample.view_z, 2);
    const glm::dvec3 expected = glm::dvec3(0.5, 0.25, 1) / kPi * irradiance;
    EXPECT_LE(sample.error, 0.005 * expected.z);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(sample.surface_lit[c], expected[c], 0.0075 * expected[c]);
    EXPECT_EQ(sample.surface, glm::dvec3(0));
}

// ------------------------------------------------------------------------------------- as a whole

TEST(ReferencePaths, ThreadsChangeNothing)
{
    Scene scene = blob_scene();
    auto& smoke = std::get<GridMedium>(scene.media[0]);
    smoke.emission = smoke.density;
    smoke.emission_per_unit = {0.1f, 0.05f, 0.02f};
    ReferenceOptions options;
    options.tolerance = 0.3;
    options.bounces = kAllBounces;
    const auto with = [&](std::size_t threads) {
        const oneapi::tbb::global_control held(oneapi::tbb::global_control::max_allowed_parallelism,
                                               threads);
        return render_reference(scene, options);
    };
    const ReferenceStill one = with(1), four = with(4);
    EXPECT_EQ(one.composite, four.composite);
    EXPECT_EQ(one.error, four.error);
}

TEST(ReferencePaths, CancelEndsThem)
{
    std::atomic<bool> cancel = true;
    ReferenceOptions options;
    options.bounces = kAllBounces;
    options.cancel = &cancel;
    EXPECT_THROW(render_reference(before_a_box(glm::vec3(100), glm::vec3(0), 0), options),
                 ReferenceCancelled);
}

// A part of the picture that Cycles drew with up to 64 scatterings, surfaces black. Its noise after
// a mean over 4x4 pixels is 8e-5. It steps through the grid: its single scattering is 1 % darker
// here than the quadrature's, and its multiple scattering, being of three or four orders, 4 %. The
// plainest path tracer above agrees with ours on this scene: by 0.2 % of 0.5 % noise.
TEST(ReferencePaths, SmokeAgreesWithAnotherPathTracer)
{
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference";
    const fs::path file = folder / "S2.json", picture = folder / "S2_scattering_multiple.exr";
    if (!fs::exists(file) || !fs::exists(picture))
        GTEST_SKIP() << "no reference pictures: " << picture << " is not there";
    asset::LoadedScene loaded{asset::parse_scene(file), {}};
    for (const Medium& medium : loaded.scene.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium); grid && !fs::exists(grid->file))
            GTEST_SKIP() << "the reference's grid " << grid->file << " is not there";
    asset::load_scene_files(loaded);
    for (Surface& surface : loaded.scene.surfaces)
        std::visit([](auto& any) { any.albedo = glm::vec3(0); }, surface);
    constexpr int kX = 212, kY = 124, kWidth = 40, kHeight = 20;
    ReferenceOptions options;
    options.tolerance = 0.3;
    options.bounces = kAllBounces;
    options.region = ReferenceRegion{kX, kY, kWidth, kHeight};
    const ReferenceStill still = render_reference(loaded.scene, options);
    const Image theirs = write::read_exr(picture, {"R", "G", "B"});
    std::vector<float> ours(kWidth / 4 * kHeight / 4 * 3), expected(ours.size());
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c) {
                const auto to = static_cast<std::size_t>(((y / 4) * (kWidth / 4) + x / 4) * 3 + c);
                ours[to] +=
                    still.scattering[static_cast<std::size_t>((y * kWidth + x) * 3 + c)] / 16;
                expected[to] += theirs.pixels[static_cast<std::size_t>(
                                    ((y + kY) * theirs.width + x + kX) * 3 + c)] /
                                16;
            }
    const Metrics metrics = compare(ours, expected);
    EXPECT_LT(metrics.relmse, 2.2e-3);
    EXPECT_GT(metrics.bias, 0);
    EXPECT_LT(metrics.bias, 0.05);
}

}  // namespace fumarole::study
