#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>

#include "study/reference.h"
#include "study/reference_quadrature.h"
#include "study/reference_reflection.h"
#include "study/reference_sampling.h"
#include "study/reference_world.h"
#include "support/reference_scenes.h"

// Glossy surfaces of the reference, against sums over directions of the textbook's formula.

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;

struct Material {
    glm::dvec3 albedo;
    double roughness, metallic;
};

/// GGX as it is written down: Walter and others 2007, Heitz 2014, Schlick 1994. The normal is z.
class Textbook {
public:
    explicit Textbook(const Material& material) : m_{material}
    {
        alpha_ = std::max(m_.roughness * m_.roughness, 0.002);
        f0_ = (1 - m_.metallic) * glm::dvec3(0.04) + m_.metallic * m_.albedo;
    }

    [[nodiscard]] glm::dvec3 layer(glm::dvec3 wo, glm::dvec3 wi) const
    {
        const double wh = wo_h(wo, wi);
        return (f0_ + (1.0 - f0_) * std::pow(1 - wh, 5)) * without_fresnel(wo, wi);
    }

    /// Over pi the BRDF of what is not the layer's first reflection.
    [[nodiscard]] glm::dvec3 base(double cosine) const
    {
        const glm::dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
        const double a = over_half_sphere(wo, [&](glm::dvec3 wi) {
            return (1 - std::pow(1 - wo_h(wo, wi), 5)) * without_fresnel(wo, wi) * wi.z;
        });
        const double b = over_half_sphere(wo, [&](glm::dvec3 wi) {
            return std::pow(1 - wo_h(wo, wi), 5) * without_fresnel(wo, wi) * wi.z;
        });
        const glm::dvec3 once = f0_ * a + b, mean = f0_ + (1.0 - f0_) / 21.0;
        const glm::dvec3 more = (1 - a - b) * once * mean / (1.0 - mean * (1 - a - b));
        return more + (1 - m_.metallic) * m_.albedo * (1.0 - once - more);
    }

    /// Of a uniform world.
    [[nodiscard]] glm::dvec3 reflected(double cosine) const
    {
        const glm::dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
        glm::dvec3 sum = base(cosine);
        for (int c = 0; c < 3; ++c)
            sum[c] += over_half_sphere(wo, [&](glm::dvec3 wi) { return layer(wo, wi)[c] * wi.z; });
        return sum;
    }

private:
    static double wo_h(glm::dvec3 wo, glm::dvec3 wi)
    {
        return glm::dot(wo, glm::normalize(wo + wi));
    }
    [[nodiscard]] double without_fresnel(glm::dvec3 wo, glm::dvec3 wi) const
    {
        const double nh = glm::normalize(wo + wi).z, a2 = alpha_ * alpha_;
        const double d = a2 / (kPi * std::pow(nh * nh * (a2 - 1) + 1, 2));
        const auto lambda = [&](double cosine) {
            const double tangent2 = 1 / (cosine * cosine) - 1;
            return (std::sqrt(1 + a2 * tangent2) - 1) / 2;
        };
        const double g = 1 / (1 + lambda(wo.z) + lambda(wi.z));
        return d * g / (4 * wo.z * wi.z);
    }
    /// Integral over wi, by half vectors around the normal, which are dense where the lobe is.
    [[nodiscard]] double over_half_sphere(glm::dvec3 wo,
                                          const std::function<double(glm::dvec3)>& f) const
    {
        constexpr int kRings = 400, kSpokes = 200;
        double sum = 0;
        for (int i = 0; i < kRings; ++i) {
            // GGX's own distribution of normals, inverted: cosine^2 = (1 - x) / (1 + (a^2 - 1) x),
            // with most rings where x is near 1, the tail.
            const double rest = 1 - (i + 0.5) / kRings, x = 1 - rest * rest * rest;
            const double a2 = alpha_ * alpha_;
            const double cosine = std::sqrt((1 - x) / (1 + (a2 - 1) * x));
            const double sine = std::sqrt(1 - cosine * cosine);
            const double density =
                a2 * cosine / (kPi * std::pow(cosine * cosine * (a2 - 1) + 1, 2));
            for (int j = 0; j < kSpokes; ++j) {
                const double phi = 2 * kPi * (j + 0.5) / kSpokes;
                const glm::dvec3 h(sine * std::cos(phi), sine * std::sin(phi), cosine);
                const double wh = glm::dot(wo, h);
                const glm::dvec3 wi = 2 * wh * h - wo;
                if (wh > 0 && wi.z > 0)
                    sum += 3 * rest * rest * f(wi) * 4 * wh / density;
            }
        }
        return sum / (kRings * kSpokes);
    }

    Material m_;
    double alpha_ = 1;
    glm::dvec3 f0_{0};
};

Gloss gloss_of(const Material& material)
{
    return {static_cast<float>(material.roughness), static_cast<float>(material.metallic)};
}

SphereSurface ball(const Material& material)
{
    SphereSurface sphere;
    sphere.center = {0, 5, 0};
    sphere.radius = 1;
    sphere.albedo = glm::vec3(material.albedo);
    sphere.gloss = gloss_of(material);
    return sphere;
}

/// A wide box whose upper side is z = -1.
BoxSurface floor_of(const Material& material)
{
    BoxSurface box;
    box.min = {-1e4, -1e4, -2};
    box.max = {1e4, 1e4, -1};
    box.albedo = glm::vec3(material.albedo);
    box.gloss = gloss_of(material);
    return box;
}

/// Looks from the origin at the floor, down by an angle whose sine is `cosine`.
Scene at_floor(const Material& material, double cosine)
{
    Scene scene = looking();
    scene.camera.vfov_deg = 0.01;
    scene.camera.look_at = {0, std::sqrt(1 - cosine * cosine), -cosine};
    scene.surfaces = {floor_of(material)};
    return scene;
}

glm::dvec3 seen(const Scene& scene, double tolerance, int bounces = 0, int surface_bounces = 0)
{
    return Reference(scene, tolerance, bounces, surface_bounces).sample({0.5, 0.5}, 0).composite;
}

void expect_close(glm::dvec3 value, glm::dvec3 truth, double relative, const std::string& what)
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(value[c], truth[c], relative * largest(truth)) << what << ", channel " << c;
}

const std::array kMaterials{Material{{0.9, 0.6, 0.3}, 0.2, 1}, Material{{0.9, 0.6, 0.3}, 0.7, 1},
                            Material{{0.9, 0.6, 0.3}, 0.3, 0}, Material{{0.9, 0.6, 0.3}, 1, 0.5}};

std::string name_of(const Material& material)
{
    return fmt::format("roughness {} metallic {}", material.roughness, material.metallic);
}

}  // namespace

TEST(ReferenceGloss, ReflectionIsTheTextbooks)
{
    for (const Material& material : kMaterials) {
        const Textbook textbook(material);
        SurfaceHit hit;
        hit.albedo = glm::vec3(material.albedo);
        hit.normal = hit.shading = glm::normalize(glm::dvec3(1, 2, -1));
        const SurfaceGloss gloss(gloss_of(material));
        hit.gloss = &gloss;
        const glm::dvec3 z = hit.normal, x = glm::normalize(glm::cross(z, glm::dvec3(1, 0, 0))),
                         y = glm::cross(z, x);
        for (const double cosine : {0.95, 0.5, 0.1}) {
            const glm::dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
            const auto world = [&](glm::dvec3 w) { return w.x * x + w.y * y + w.z * z; };
            const SurfaceReflection reflection(hit, world(wo));
            const glm::dvec3 base = textbook.base(cosine) / kPi;
            glm::dvec3 sum(0);
            double chosen = 0;
            constexpr std::uint32_t kPoints = 1 << 14;
            for (std::uint32_t i = 0; i < kPoints; ++i) {
                const SobolPoint u(1, i);
                // The density, over all directions.
                const double up = 1 - u(0), r = std::sqrt(1 - up * up);
                chosen += 2 * kPi / kPoints *
                          reflection.pdf(world(
                              {r * std::cos(2 * kPi * u(1)), r * std::sin(2 * kPi * u(1)), up}));
                if (const auto sent = reflection.sample(u(0), u(1), u(2))) {
                    sum += sent->weight / static_cast<double>(kPoints);
                    if (i % 512 != 0)
                        continue;
                    const glm::dvec3 wi(glm::dot(sent->wi, x), glm::dot(sent->wi, y),
                                        glm::dot(sent->wi, z));
                    expect_close(reflection(sent->wi), (textbook.layer(wo, wi) + base) * wi.z, 2e-3,
                                 name_of(material));
                    expect_close(sent->weight * reflection.pdf(sent->wi), reflection(sent->wi),
                                 1e-9, "weight");
                }
            }
            expect_close(sum, textbook.reflected(cosine), 3e-3, name_of(material));
            EXPECT_LT(chosen, 1.01);
            EXPECT_GT(chosen, 0.5);
        }
    }
}

TEST(ReferenceGloss, WhiteFurnaceIsWhiteAtEveryRoughness)
{
    for (const double metallic : {0.0, 1.0})
        for (const double roughness : {0.0, 0.1, 0.3, 0.6, 1.0}) {
            Scene scene = looking();
            scene.world.radiance = glm::vec3(1);
            scene.surfaces = {ball({glm::dvec3(1), roughness, metallic})};
            for (const double x : {0.0, 0.5, 0.9, 0.99}) {
                scene.camera.look_at = {x / 5, std::sqrt(25 - x * x) / 5, 0};
                scene.camera.vfov_deg = 0.01;
                expect_close(seen(scene, 2e-3), glm::dvec3(1), 5e-3,
                             fmt::format("metallic {} roughness {} at {}", metallic, roughness, x));
            }
        }
}

TEST(ReferenceGloss, UniformWorldIsReflectedByTheDirectionalAlbedo)
{
    for (const Material& material : kMaterials)
        for (const double cosine : {0.9, 0.3}) {
            Scene scene = at_floor(material, cosine);
            scene.world.radiance = {1, 2, 3};
            expect_close(seen(scene, 2e-3),
                         glm::dvec3(1, 2, 3) * Textbook(material).reflected(cosine), 5e-3,
                         name_of(material));
        }
}

TEST(ReferenceGloss, SunIsReflectedAsTheTextbookSays)
{
    const glm::dvec3 to_sun = glm::normalize(glm::dvec3(0.3, 0.8, 0.6)), sun(3, 2, 1);
    for (const Material& material : kMaterials) {
        const double cosine = 0.55;
        Scene scene = at_floor(material, cosine);
        scene.lights.emplace_back(SunLight{to_sun, sun});
        const Textbook textbook(material);
        const glm::dvec3 wo(0, -std::sqrt(1 - cosine * cosine), cosine);
        expect_close(seen(scene, 1e-3),
                     (textbook.layer(wo, to_sun) + textbook.base(cosine) / kPi) * sun * to_sun.z,
                     2e-3, name_of(material));
    }
}

TEST(ReferenceGloss, AreaLightIsReflectedAsTheTextbookSays)
{
    RectLight rect;
    rect.center = {0.2, 3.5, 1};  // at roughness 0 the eye's ray is reflected into it
    rect.edges = {glm::dvec3(1, 0, 0), glm::dvec3(0, 0.5, 0.2)};
    rect.radiance = {1, 2, 3};
    rect.two_sided = true;
    for (const double roughness : {0.0, 0.15, 0.6}) {
        const Material material{{0.8, 0.7, 0.5}, roughness, 1};
        const double cosine = 0.64;
        Scene scene = at_floor(material, cosine);
        scene.lights.emplace_back(rect);
        const Textbook textbook(material);
        const glm::dvec3 wo(0, -std::sqrt(1 - cosine * cosine), cosine);
        const glm::dvec3 p = -wo / cosine, base = textbook.base(cosine) / kPi;
        const glm::dvec3 across = glm::cross(rect.edges[0], rect.edges[1]);
        glm::dvec3 sum(0);
        constexpr int kSide = 1500;
        for (int i = 0; i < kSide; ++i)
            for (int j = 0; j < kSide; ++j) {
                const glm::dvec3 to = rect.center + ((i + 0.5) / kSide - 0.5) * rect.edges[0] +
                                      ((j + 0.5) / kSide - 0.5) * rect.edges[1] - p;
                const double d2 = glm::dot(to, to);
                const glm::dvec3 wi = to / std::sqrt(d2);
                sum += (textbook.layer(wo, wi) + base) * wi.z *
                       (std::abs(glm::dot(across, wi)) / d2 / (kSide * kSide));
            }
        expect_close(seen(scene, 3e-3), sum * glm::dvec3(rect.radiance), 0.01, name_of(material));
    }
}

TEST(ReferenceGloss, MirrorShowsTheWorld)
{
    auto map = std::make_shared<Environment>();
    map->width = 64;
    map->height = 32;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            map->radiance.emplace_back(1 + 0.5 * std::sin(2 * kPi * (x + 0.5) / 64),
                                       1.5 + 0.5 * std::cos(2 * kPi * (x + 0.5) / 64),
                                       0.5 + (y + 0.5) / 32);
    Scene scene = looking();
    scene.camera.vfov_deg = 0.01;
    scene.world.environment = map;
    const WorldRadiance world(scene.world);
    scene.surfaces = {ball({glm::dvec3(1), 0, 1})};
    for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(0.5, 0.3), glm::dvec2(-0.6, -0.4)}) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(at.x / 4.5, 1, at.y / 4.5));
        scene.camera.look_at = d;
        const double b = 5 * d.y, t = b - std::sqrt(b * b - 24);
        const glm::dvec3 n = d * t - glm::dvec3(0, 5, 0);
        expect_close(seen(scene, 2e-3), world(d - 2 * glm::dot(d, n) * n), 0.01, "the world");
    }
}

TEST(ReferenceGloss, MirrorShowsWhatIsLitAndWhatGlows)
{
    // The eye's ray meets a mirror a metre below at y = 0.75, and a ceiling above it at y = 2.25,
    // which a lamp lights from 1.5 m.
    Scene scene = at_floor({glm::dvec3(1), 0, 1}, 0.8);
    BoxSurface ceiling;
    ceiling.min = {-50, 1, 1};
    ceiling.max = {50, 50, 1.5};
    ceiling.albedo = {0.2f, 0.4f, 0.6f};
    scene.surfaces.emplace_back(ceiling);
    scene.lights = {PointLight{{0, 2.25, -0.5}, {9, 6, 3}}};
    const glm::dvec3 lit = glm::dvec3(0.2, 0.4, 0.6) / kPi * glm::dvec3(9, 6, 3) / 2.25;
    const auto mirrored = [&](int surface_bounces) {
        return seen(scene, 2e-3, 0, surface_bounces);
    };
    EXPECT_LT(largest(mirrored(0)), 1e-3);
    expect_close(mirrored(1), lit, 0.01, "lit");
    std::get<BoxSurface>(scene.surfaces[1]).emission = {1, 0.5f, 2};
    expect_close(mirrored(0), {1, 0.5, 2}, 0.01, "glowing");
    // Through a medium that only absorbs.
    BoxMedium dim = fog({-50, -50, -0.9}, {50, 50, 0.9}, glm::vec3(0), {0.2f, 0.1f, 0.4f});
    scene.media = {dim};
    const glm::dvec3 way = glm::exp(-glm::dvec3(0.2, 0.1, 0.4) * (1.8 + 0.9) / 0.8);
    expect_close(mirrored(0), glm::dvec3(1, 0.5, 2) * way, 0.01, "dimmed");
}

TEST(ReferenceGloss, GlossyCeilingLightsTheFloorByItsMeanAlbedo)
{
    // The floor glows under a glossy ceiling without end, and is lit by what that reflects.
    const glm::dvec3 glow(1, 2, 0.5), albedo(0.5, 0.9, 0.7);
    for (const Material& material : kMaterials) {
        Scene scene = looking();
        scene.camera.vfov_deg = 0.01;
        scene.camera.look_at = {0, 1, -1};
        BoxSurface floor = floor_of({albedo, 1, 0}), ceiling = floor_of(material);
        floor.gloss.reset();
        floor.emission = glm::vec3(glow);
        ceiling.min.z = 1;
        ceiling.max.z = 2;
        scene.surfaces = {floor, ceiling};
        const Textbook textbook(material);
        glm::dvec3 mean(0);
        constexpr int kCosines = 32;
        for (int i = 0; i < kCosines; ++i) {
            const double cosine = (i + 0.5) / kCosines;
            mean += 2 * cosine / kCosines * textbook.reflected(cosine);
        }
        expect_close(seen(scene, 5e-3, 0, 1), glow * (1.0 + albedo * mean), 0.01,
                     name_of(material));
    }
}

TEST(ReferenceGloss, SmokeInAMirrorIsTheSmoke)
{
    // Thin fog under a sun, seen straight and in a mirror: from a bounce on it is there.
    Scene scene = at_floor({glm::dvec3(1), 0, 1}, 0.6);
    scene.lights.emplace_back(SunLight{{1, 0, 0.02}, {5, 4, 3}});
    // Beyond the mirror's place, y = 4 / 3.
    scene.media = {fog({-1, 3, -0.5}, {1, 4, 2}, {0.01f, 0.02f, 0.03f}, glm::vec3(0))};
    EXPECT_LT(largest(seen(scene, 2e-3)), 1e-3);
    const double length = 1 / 0.8;
    expect_close(seen(scene, 5e-3, 1),
                 glm::dvec3(0.01, 0.02, 0.03) * glm::dvec3(5, 4, 3) * length / (4 * kPi), 0.03,
                 "in the mirror");
}

}  // namespace fumarole::study
