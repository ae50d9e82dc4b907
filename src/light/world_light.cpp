#include "light/world_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <oneapi/tbb/parallel_for.h>

#include "shared/spherical_harmonics.h"

namespace fumarole::light {

namespace {

constexpr double kPi = std::numbers::pi;

/// Direction of the middle of a texel; see Environment.
glm::dvec3 direction(double u, double v)
{
    const double phi = (0.5 - u) * 2 * kPi;
    const double theta = v * kPi;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// Solid angle of a texel of row y [sr]: exact, so the rows add up to 4 pi.
double texel_solid_angle(int y, int width, int height)
{
    return 2 * kPi / width * (std::cos(kPi * y / height) - std::cos(kPi * (y + 1) / height));
}

const glm::vec3& texel(const Environment& map, int x, int y)
{
    return map.radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                        static_cast<std::size_t>(x)];
}

/// Averages over blocks by solid angle, so that the whole keeps its energy.
/// @param centroids if given, of each block the mean direction of its light, shorter than 1: what a
/// surface is lit by of a block above its horizon is the dot of that and its normal, wherever in
/// the block a sun stands
Environment shrink(const Environment& map, int width, int height,
                   std::vector<glm::dvec3>* centroids = nullptr)
{
    std::vector<glm::dvec2> around;  // cosine and sine of each column's angle
    for (int x = 0; x < map.width; ++x) {
        const glm::dvec3 d = direction((x + 0.5) / map.width, 0.5);
        around.emplace_back(d.x, d.y);
    }
    Environment small{width, height, {}};
    small.radiance.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            glm::dvec3 sum(0), course(0);
            double weight = 0, brightness = 0;
            for (int j = y * map.height / height; j < (y + 1) * map.height / height; ++j) {
                const double w = texel_solid_angle(j, map.width, map.height);
                const glm::dvec3 at = direction(0.5, (j + 0.5) / map.height);
                for (int i = x * map.width / width; i < (x + 1) * map.width / width; ++i) {
                    const glm::dvec3 light = w * glm::dvec3(texel(map, i, j));
                    sum += light;
                    weight += w;
                    if (centroids == nullptr)
                        continue;
                    const glm::dvec3 d(at.x * around[static_cast<std::size_t>(i)], at.z);
                    const double bright = light.r + light.g + light.b;
                    course += bright * d;
                    brightness += bright;
                }
            }
            if (centroids != nullptr)
                centroids->push_back(course / std::max(brightness, 1e-300));
            small.radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x)] = glm::vec3(sum / weight);
        }
    }
    return small;
}

/// Three of some directions, and how much each has of what lies between them.
struct Corners {
    std::array<std::size_t, 3> index{};
    glm::dvec3 weight{0};
};

/// Those of the nearest few whose weighted sum points to `wi` with weights above 0, the smallest as
/// large as can be.
Corners corners_around(glm::dvec3 wi, const std::vector<glm::dvec3>& directions)
{
    constexpr std::size_t kNear = 7;
    std::vector<std::size_t> near(directions.size());
    std::iota(near.begin(), near.end(), 0);
    std::partial_sort(near.begin(), near.begin() + kNear, near.end(),
                      [&](std::size_t a, std::size_t b) {
                          return glm::dot(directions[a], wi) > glm::dot(directions[b], wi);
                      });
    Corners best{{near[0], near[1], near[2]}, {1, 0, 0}};
    double most = -1e-9;
    for (std::size_t a = 0; a < kNear; ++a)
        for (std::size_t b = a + 1; b < kNear; ++b)
            for (std::size_t c = b + 1; c < kNear; ++c) {
                const glm::dmat3 corners(directions[near[a]], directions[near[b]],
                                         directions[near[c]]);
                if (std::abs(glm::determinant(corners)) < 1e-6)
                    continue;
                const glm::dvec3 weight = glm::inverse(corners) * wi;
                const double least = std::min({weight.x, weight.y, weight.z});
                if (least <= most)
                    continue;
                most = least;
                best = {{near[a], near[b], near[c]}, weight / (weight.x + weight.y + weight.z)};
            }
    return best;
}

}  // namespace

glm::vec3 mean_radiance(const Environment& map)
{
    glm::dvec3 sum(0);
    for (int y = 0; y < map.height; ++y) {
        const double solid_angle = texel_solid_angle(y, map.width, map.height);
        for (int x = 0; x < map.width; ++x)
            sum += solid_angle * glm::dvec3(texel(map, x, y));
    }
    return glm::vec3(sum / (4 * kPi));
}

Environment irradiance_map(const Environment& map)
{
    // Where a normal turns away from a sun its light ends in a kink, which a table of half as many
    // rounds off by 4 % of what a sunny map sends on the mean.
    constexpr int kWidth = 128, kHeight = 64;
    std::vector<glm::dvec3> directions;
    const Environment lit =
        shrink(map, std::min(map.width, 64), std::min(map.height, 32), &directions);
    Environment out{kWidth, kHeight, {}};
    out.radiance.resize(std::size_t{kWidth} * kHeight);
    oneapi::tbb::parallel_for(0, kHeight, [&](int row) {
        for (int column = 0; column < kWidth; ++column) {
            const glm::dvec3 n = direction((column + 0.5) / kWidth, (row + 0.5) / kHeight);
            glm::dvec3 sum(0);
            for (int y = 0; y < lit.height; ++y) {
                const double solid_angle = texel_solid_angle(y, lit.width, lit.height);
                for (int x = 0; x < lit.width; ++x) {
                    const double cosine =
                        glm::dot(n, directions[static_cast<std::size_t>(y) * lit.width + x]);
                    if (cosine > 0)
                        sum += solid_angle * cosine * glm::dvec3(texel(lit, x, y));
                }
            }
            out.radiance[static_cast<std::size_t>(row) * kWidth +
                         static_cast<std::size_t>(column)] = glm::vec3(sum);
        }
    });
    return out;
}

std::vector<glm::vec3> world_radiance(const World& world, const std::vector<glm::dvec3>& directions,
                                      const std::vector<double>& solid_angles)
{
    constexpr int kHarmonics = 16;
    const auto harmonic = [](int i, glm::dvec3 d) {
        return static_cast<double>(shared::spherical_harmonic(i, glm::vec3(d)));
    };
    const Environment& full = *world.environment;
    const Environment map = shrink(full, std::min(full.width, 64), std::min(full.height, 32));
    std::vector<glm::dvec3> radiance(directions.size(), glm::dvec3(0));
    std::array<glm::dvec3, kHarmonics> missing{};
    for (int y = 0; y < map.height; ++y) {
        const double solid_angle = texel_solid_angle(y, map.width, map.height);
        for (int x = 0; x < map.width; ++x) {
            const glm::dvec3 wi = direction((x + 0.5) / map.width, (y + 0.5) / map.height);
            const Corners corners = corners_around(wi, directions);
            const glm::dvec3 light = solid_angle * static_cast<double>(world.environment_scale) *
                                     glm::dvec3(texel(map, x, y));
            for (int i = 0; i < 3; ++i) {
                const std::size_t k = corners.index[static_cast<std::size_t>(i)];
                radiance[k] += corners.weight[i] * light / solid_angles[k];
            }
            for (int i = 0; i < kHarmonics; ++i)
                missing[static_cast<std::size_t>(i)] += light * harmonic(i, wi);
        }
    }
    for (std::size_t k = 0; k < directions.size(); ++k)
        for (int i = 0; i < kHarmonics; ++i)
            missing[static_cast<std::size_t>(i)] -=
                solid_angles[k] * radiance[k] * harmonic(i, directions[k]);
    std::vector<glm::vec3> out;
    for (std::size_t k = 0; k < directions.size(); ++k) {
        for (int i = 0; i < kHarmonics; ++i)
            radiance[k] += missing[static_cast<std::size_t>(i)] * harmonic(i, directions[k]);
        out.emplace_back(glm::max(radiance[k], glm::dvec3(0)));
    }
    return out;
}

}  // namespace fumarole::light
