#pragma once

#include <algorithm>
#include <random>

#include "image_test.h"

// Panes in a fog that glows, whose closed form is a line.

namespace fumarole::test {

using Kind = Blend::Kind;

inline constexpr double kNear = 4, kFar = 6;      ///< the slab's faces, metres before the eye
inline const glm::vec3 kSigma(0.3f, 0.8f, 1.5f);  ///< 1/m
inline const glm::vec3 kGlow(0.5f, 1.0f, 0.25f);  ///< W/m^2/sr per metre
inline const glm::vec3 kSky(0.75f, 0.25f, 0.5f);  ///< W/m^2/sr

/// Looks along -y through a fog that glows, before a sky of one colour.
inline Scene fog_scene(int size = 32)
{
    Scene scene = empty_scene(size);
    BoxMedium fog;
    fog.min = {-9, -kFar, -9};
    fog.max = {9, -kNear, 9};
    fog.sigma_a = kSigma;
    fog.emission = kGlow;
    scene.media.emplace_back(fog);
    scene.world.radiance = kSky;
    return scene;
}

/// Wider than the picture, `distance` before the eye.
inline QuadTransparent pane(double distance, Blend::Kind kind)
{
    QuadTransparent quad;
    quad.corner = {9, -distance, -9};
    quad.edges = {glm::dvec3(-18, 0, 0), glm::dvec3(0, 0, 18)};
    quad.look.blend.kind = kind;
    return quad;
}

/// The fog along a ray.
struct FogRay {
    double slant;  ///< metres of ray per metre of depth

    [[nodiscard]] glm::dvec3 passed(double depth) const
    {
        const double metres = (std::clamp(depth, kNear, kFar) - kNear) * slant;
        return glm::exp(-glm::dvec3(kSigma) * metres);
    }
    [[nodiscard]] glm::dvec3 glowed(double depth) const
    {
        return glm::dvec3(kGlow) / glm::dvec3(kSigma) * (1.0 - passed(depth));
    }
    [[nodiscard]] glm::dvec3 behind(double depth) const
    {
        return (glm::dvec3(kSky) * passed(kFar) + glowed(kFar) - glowed(depth)) / passed(depth);
    }
};

/// Ten that cross each other, some of whose factors depend on what is behind.
inline std::vector<Transparent> crossing(bool reads_picture)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<double> depth(3.5, 6.5), tilt(-2, 2);
    std::uniform_real_distribution<float> color(0, 1);
    std::vector<Transparent> all;
    for (int i = 0; i < 10; ++i) {
        QuadTransparent quad = pane(depth(random), static_cast<Kind>(i % 4));
        quad.edges[0].y = tilt(random);
        quad.edges[1].y = tilt(random);
        quad.look.radiance = {color(random), color(random), color(random)};
        quad.look.filter = {color(random), color(random), color(random)};
        quad.look.alpha = color(random);
        if (reads_picture && i % 3 == 0)
            quad.look.blend = {Kind::factors, BlendFactor::dst_color,
                               BlendFactor::one_minus_dst_color};
        all.emplace_back(quad);
    }
    return all;
}

}  // namespace fumarole::test
