// What a probe's light is filtered to, against sums over the light that it was made of, in double:
// GGX's lobes, the cosine's, and no seam where the octahedron is folded.

#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>
#include <random>

#include "gl/state_guard.h"
#include "light/probe_filter.h"
#include "shared/spherical_harmonics.h"
#include "support/gl_test.h"
#include "support/kernel.h"
#include <fumarole/asset/environment_map.h>

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

using Radiance = std::function<glm::dvec3(glm::dvec3)>;

glm::dvec3 direction_of(double u, double v)
{
    const double phi = (0.5 - u) * 2 * kPi, theta = v * kPi;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Environment environment_of(int width, const Radiance& radiance)
{
    Environment map{width, width / 2, {}};
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < width; ++x)
            map.radiance.emplace_back(
                radiance(direction_of((x + 0.5) / width, (y + 0.5) / map.height)));
    return map;
}

std::vector<glm::dvec3> random_directions(int count)
{
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> all;
    for (int i = 0; i < count; ++i)
        all.push_back(glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))));
    return all;
}

/// On both sides of the edges of the square, which fold the lower half: in the planes of x = 0 and
/// y = 0, and below. The other side's is the next but one.
std::vector<glm::dvec3> directions_at_folds(double off)
{
    std::vector<glm::dvec3> all;
    for (int i = 0; i <= 32; ++i) {
        const double a = kPi * (1 + i / 32.0);
        for (const double side : {-off, off}) {
            all.push_back(glm::normalize(glm::dvec3(side, std::cos(a), std::sin(a))));
            all.push_back(glm::normalize(glm::dvec3(std::cos(a), side, std::sin(a))));
        }
    }
    return all;
}

/// The mean of `radiance` over GGX's reflections about n, weighted by their cosine, over the texels
/// of a map.
glm::dvec3 ggx_mean(const Environment& map, glm::dvec3 n, double alpha)
{
    glm::dvec3 sum(0);
    double weights = 0;
    for (int y = 0; y < map.height; ++y) {
        const double solid_angle =
            std::cos(kPi * y / map.height) - std::cos(kPi * (y + 1) / map.height);
        for (int x = 0; x < map.width; ++x) {
            const glm::dvec3 wi = direction_of((x + 0.5) / map.width, (y + 0.5) / map.height);
            const double cosine = glm::dot(n, wi);
            if (cosine <= 0)
                continue;
            const double cos2 = 0.5 + 0.5 * cosine;  // of half the angle
            const double root = cos2 * (alpha * alpha - 1) + 1;
            const double weight = solid_angle * cosine / (root * root);
            weights += weight;
            sum += weight * glm::dvec3(map.radiance[static_cast<std::size_t>(y * map.width + x)]);
        }
    }
    return sum / weights;
}

glm::dvec3 cosine_sum(const Environment& map, glm::dvec3 n)
{
    glm::dvec3 sum(0);
    for (int y = 0; y < map.height; ++y) {
        const double solid_angle =
            2 * kPi / map.width *
            (std::cos(kPi * y / map.height) - std::cos(kPi * (y + 1) / map.height));
        for (int x = 0; x < map.width; ++x) {
            const double cosine =
                glm::dot(n, direction_of((x + 0.5) / map.width, (y + 0.5) / map.height));
            if (cosine > 0)
                sum += solid_angle * cosine *
                       glm::dvec3(map.radiance[static_cast<std::size_t>(y * map.width + x)]);
        }
    }
    return sum;
}

class Probe : public GlTest {
protected:
    struct Filtered {
        light::ProbeLayout layout;
        gl::Texture maps;
    };

    static gl::Texture upload(const Environment& map)
    {
        gl::Texture texture = gl::Texture::make_2d(gl(), "map", {map.width, map.height}, GL_RGBA32F,
                                                   gl::Filter::linear);
        texture.upload(GL_RGB, GL_FLOAT, map.radiance.data());
        gl()->TextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
        return texture;
    }

    Filtered filter(const Environment& map, int size)
    {
        const gl::StateGuard guard(gl(), 8, BLOCK_COUNT, IMAGE_COUNT);
        const light::ProbeFilter filter(gl(), programs_);
        const light::ProbeLayout layout(size);
        Filtered filtered{layout, filter.make_maps("probe", layout, 1)};
        filter.filter_environment(upload(map), filtered.maps, layout, 0);
        return filtered;
    }

    std::vector<glm::dvec3> look(const Filtered& probe, const std::vector<glm::dvec3>& directions,
                                 const char* code, float alpha = 0)
    {
        shared::ProbesParams params{};
        params.world = probe.layout.params();
        const gl::UniformBuffer<shared::ProbesParams> block(gl(), "probes");
        block.write(params);
        const Kernel kernel(gl(), code);
        std::vector<glm::vec4> in;
        for (const glm::dvec3& d : directions)
            in.emplace_back(d, alpha);
        gl()->BindBufferBase(GL_UNIFORM_BUFFER, PROBES_BLOCK, block.id());
        probe.maps.bind(WORLD_PROBE_UNIT);
        std::vector<glm::dvec3> out;
        for (const glm::vec4& value : kernel(in))
            out.emplace_back(value);
        return out;
    }
    std::vector<glm::dvec3> reflections(const Filtered& probe,
                                        const std::vector<glm::dvec3>& directions, double alpha)
    {
        return look(probe, directions, R"(
#include "scene/probes.glsl"
void kernel(int i) { out_data[i] = vec4(world_reflection(in_data[i].xyz, in_data[i].w), 0.0); }
)",
                    static_cast<float>(alpha));
    }
    std::vector<glm::dvec3> irradiances(const Filtered& probe,
                                        const std::vector<glm::dvec3>& directions)
    {
        return look(probe, directions, R"(
#include "scene/probes.glsl"
void kernel(int i)
{
    out_data[i] = probe_irradiance(u_world_probe_tx, u_probes.world.harmonics, 0, in_data[i].xyz);
}
)");
    }

    gl::ProgramCache programs_{gl()};
};

TEST_F(Probe, AConstantStaysWhatItIs)
{
    const glm::dvec3 light(3.7, 0.2, 91000);
    for (const int size : {64, 256}) {
        const Filtered probe = filter(environment_of(64, [&](glm::dvec3) { return light; }), size);
        std::vector<glm::dvec3> directions = random_directions(500);
        for (const glm::dvec3& d : directions_at_folds(1e-4))
            directions.push_back(d);
        for (const double alpha : {0.0, 0.001, 0.02, 0.1, 0.3, 0.77, 1.0})
            for (const glm::dvec3& seen : reflections(probe, directions, alpha))
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(seen[c] / light[c], 1, 1e-6)
                        << "size " << size << ", alpha " << alpha;
        for (const glm::dvec3& seen : irradiances(probe, directions))
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(seen[c] / (kPi * light[c]), 1, 2e-3) << "size " << size;
    }
}

TEST_F(Probe, AGradientRunsAcrossTheFolds)
{
    // GGX leaves of light that grows evenly along an axis a part, the same for all normals.
    const glm::dvec3 slope(0.3, -0.5, 0.4);
    const Radiance radiance = [&](glm::dvec3 d) { return glm::dvec3(1 + glm::dot(slope, d)); };
    const Filtered probe = filter(environment_of(512, radiance), 128);
    const Environment coarse = environment_of(128, radiance);
    // Half of what changes over a texel of the roughest map.
    const double near =
        0.5 * glm::length(slope) * std::sqrt(4 * kPi) / probe.layout.maps().back().size;
    for (const double off : {1e-5, 0.004, 0.01}) {
        const std::vector<glm::dvec3> directions = directions_at_folds(off);
        for (const double alpha : {0.0, 1.0 / 32, 1.0 / 8, 0.5, 1.0}) {
            const double part =
                alpha == 0
                    ? 1
                    : (ggx_mean(coarse, glm::normalize(slope), alpha).x - 1) / glm::length(slope);
            const std::vector<glm::dvec3> seen = reflections(probe, directions, alpha);
            for (std::size_t i = 0; off < 1e-4 && i + 2 < directions.size();
                 i += i % 2 == 0 ? 1 : 3)
                ASSERT_NEAR(seen[i].x, seen[i + 2].x, 1e-4) << "alpha " << alpha;
            for (std::size_t i = 0; i < directions.size(); ++i)
                ASSERT_NEAR(seen[i].x, 1 + part * glm::dot(slope, directions[i]), near)
                    << "alpha " << alpha << ", " << directions[i].x << " " << directions[i].y;
        }
    }
}

/// A sky with a sun of 1e5 a few texels wide, whose share of the light is some nine tenths.
glm::dvec3 sunny(glm::dvec3 d)
{
    static const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.5, -0.6, 0.4));
    const bool in_sun = glm::dot(d, to_sun) > std::cos(0.015);
    const glm::dvec3 sky = glm::dvec3(0.3, 0.5, 1.0) * (1.2 + d.z) +
                           glm::dvec3(0.5) * std::exp(-8 * glm::dot(d - to_sun, d - to_sun));
    return in_sun ? glm::dvec3(1e5) : sky;
}

/// Mean of ((a - b) / b)^2.
double relative_mse(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (int c = 0; c < 3; ++c)
            sum += std::pow((a[i][c] - b[i][c]) / b[i][c], 2) / 3;
    return sum / static_cast<double>(a.size());
}

TEST_F(Probe, RoughnessIsThatOfGgx)
{
    const std::vector<glm::dvec3> directions = random_directions(40);
    for (const bool sun : {false, true}) {
        const Environment map = environment_of(512, [&](glm::dvec3 d) {
            return sun ? sunny(d) : glm::dvec3(1.5 + d.x + std::sin(5 * d.y) * d.z);
        });
        const Filtered probe = filter(map, 256);
        for (const double roughness : {0.2, 0.25, 0.3, 0.354, 0.45, 0.5, 0.6, 0.707, 0.85, 1.0}) {
            const double alpha = roughness * roughness;
            std::vector<glm::dvec3> expected;
            for (const glm::dvec3& n : directions)
                expected.push_back(ggx_mean(map, n, alpha));
            const double error = relative_mse(reflections(probe, directions, alpha), expected);
            // Where a surface turns from a sun its light ends in an edge as sharp as a map's texel.
            EXPECT_LT(error, sun ? 1e-2 : 1e-3) << "roughness " << roughness << ", sun " << sun;
        }
    }
}

TEST_F(Probe, HarmonicsAreTheCosinesSum)
{
    // Bands 0 to 2 alone: they leave nothing out.
    const Environment map = environment_of(256, [](glm::dvec3 d) {
        return glm::dvec3(1 + 0.4 * d.x + 0.2 * d.y - 0.3 * d.z + 0.5 * d.x * d.y +
                          0.3 * d.z * d.z);
    });
    const std::vector<glm::dvec3> directions = random_directions(100);
    const std::vector<glm::dvec3> seen = irradiances(filter(map, 128), directions);
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const double expected = cosine_sum(map, directions[i]).x;
        EXPECT_NEAR(seen[i].x, expected, 0.002 * expected);
    }
}

}  // namespace
}  // namespace fumarole::test
