#include "light/world_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <oneapi/tbb/parallel_for.h>

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
Environment shrink(const Environment& map, int width, int height)
{
    Environment small{width, height, {}};
    small.radiance.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            glm::dvec3 sum(0);
            double weight = 0;
            for (int j = y * map.height / height; j < (y + 1) * map.height / height; ++j) {
                const double w = texel_solid_angle(j, map.width, map.height);
                for (int i = x * map.width / width; i < (x + 1) * map.width / width; ++i) {
                    sum += w * glm::dvec3(texel(map, i, j));
                    weight += w;
                }
            }
            small.radiance[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x)] = glm::vec3(sum / weight);
        }
    }
    return small;
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

Environment irradiance_map(const Environment& map, int width, int height)
{
    const Environment lit = shrink(map, std::min(map.width, 128), std::min(map.height, 64));
    Environment out{width, height, {}};
    out.radiance.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::vector<glm::dvec3> directions;
    for (int y = 0; y < lit.height; ++y)
        for (int x = 0; x < lit.width; ++x)
            directions.push_back(direction((x + 0.5) / lit.width, (y + 0.5) / lit.height));
    oneapi::tbb::parallel_for(0, height, [&](int row) {
        for (int column = 0; column < width; ++column) {
            const glm::dvec3 n = direction((column + 0.5) / width, (row + 0.5) / height);
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
            out.radiance[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(column)] = glm::vec3(sum);
        }
    });
    return out;
}

std::vector<WorldCell> world_cells(const World& world, int count)
{
    // A spherical Fibonacci lattice: even in z, so a horizon cuts it as it should. Keinert et al.
    // 2015, "Spherical Fibonacci Mapping".
    std::vector<glm::dvec3> points;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2 * i + 1.0) / count;
        const double phi = 2 * kPi * i / std::numbers::phi;
        points.emplace_back(std::sqrt(1 - z * z) * std::cos(phi),
                            std::sqrt(1 - z * z) * std::sin(phi), z);
    }
    std::vector<WorldCell> cells;
    if (world.environment == nullptr) {
        for (const glm::dvec3& wi : points)
            cells.push_back({wi, glm::dvec3(world.radiance) * (4 * kPi / count)});
        return cells;
    }
    const Environment& full = *world.environment;
    const Environment map = shrink(full, std::min(full.width, 256), std::min(full.height, 128));
    std::vector<glm::dvec3> middle(points.size(), glm::dvec3(0));
    std::vector<glm::dvec3> power(points.size(), glm::dvec3(0));
    for (int y = 0; y < map.height; ++y) {
        const double solid_angle = texel_solid_angle(y, map.width, map.height);
        for (int x = 0; x < map.width; ++x) {
            const glm::dvec3 wi = direction((x + 0.5) / map.width, (y + 0.5) / map.height);
            const auto nearest =
                std::max_element(points.begin(), points.end(), [&](glm::dvec3 a, glm::dvec3 b) {
                    return glm::dot(a, wi) < glm::dot(b, wi);
                });
            const auto k = static_cast<std::size_t>(nearest - points.begin());
            const glm::dvec3 light = solid_angle * static_cast<double>(world.environment_scale) *
                                     glm::dvec3(texel(map, x, y));
            power[k] += light;
            middle[k] += wi * (light.r + light.g + light.b);
        }
    }
    for (std::size_t k = 0; k < points.size(); ++k)
        if (power[k] != glm::dvec3(0))
            cells.push_back({glm::normalize(middle[k]), power[k]});
    return cells;
}

}  // namespace fumarole::light
