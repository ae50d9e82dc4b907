#pragma once

#include <algorithm>
#include <cmath>
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

/// What people have most: dust, smoke cards and sparks. Billboards of every blend, with an image, a
/// depth fade or both, at depths of their own before a tilted card; of more than eight one
/// lies on the ground and goes on behind the eye. None crosses another.
inline std::vector<Transparent> sprites(int count, bool seen = true)
{
    auto image = std::make_shared<TransparentImage>();
    image->width = image->height = 4;
    for (int i = 0; i < 16; ++i) {
        const float alpha = seen ? float(i % 4) / 4 : 0.0f;
        image->texels.emplace_back(glm::vec3(0.5f, 0.25f * float(i / 4), 0.5f) * alpha, alpha);
    }
    const auto dress = [&](TransparentLook& look, int i) {
        constexpr std::array kKinds{Kind::alpha, Kind::premultiplied, Kind::add, Kind::multiply,
                                    Kind::factors};
        constexpr std::array kFactors{
            std::pair{BlendFactor::one_minus_dst_color, BlendFactor::one},
            std::pair{BlendFactor::dst_color, BlendFactor::one},
            std::pair{BlendFactor::one_minus_src_alpha, BlendFactor::one_minus_src_color}};
        const auto nth = static_cast<std::size_t>(i);
        const auto& [source, destination] = kFactors.at(nth / kKinds.size() % kFactors.size());
        look.blend = {kKinds.at(nth % kKinds.size()), source, destination};
        look.alpha = 0.75f;
        if (i % 3 != 2)
            look.image = image;
        if (i % 3 != 0)
            look.depth_fade = 0.6f;
        look.radiance = {0.3f, 0.2f, 0.6f};
        look.filter = {0.5f, 1, 0.25f};
        if (!seen) {
            look.alpha = 0;
            look.filter = glm::vec3(1);
            if (look.blend.kind != Kind::alpha)  // which hides it
                look.radiance = glm::vec3(0);
        }
    };
    std::mt19937 random(5);
    std::uniform_real_distribution<double> aside(-1.2, 1.2), up(-0.4, 1.2), size(0.6, 1.2);
    std::vector<Transparent> all;
    const bool has_ground = count > 8;
    for (int i = 0; i < count - (has_ground ? 2 : 1); ++i) {
        BillboardTransparent board;
        board.center = {aside(random), -3.3 - 3.5 * (i * 7 % count) / count, up(random)};
        board.size = {size(random), 0.8};
        dress(board.look, i);
        all.emplace_back(board);
    }
    QuadTransparent card, ground;
    card.corner = {1.5, -7.2, -0.8};
    card.edges = {glm::dvec3(-3, -0.8, 0), glm::dvec3(0, 0.2, 2.5)};
    dress(card.look, 1);
    ground.corner = {4, 3, -0.95};
    ground.edges = {glm::dvec3(-8, 0, 0), glm::dvec3(0, -11, 0)};
    dress(ground.look, 0);
    if (has_ground)
        all.emplace_back(ground);
    all.emplace_back(card);
    return all;
}

inline Scene sprite_scene(int count, int size = 33)
{
    Scene scene = fog_scene(size);
    scene.surfaces = {BoxSurface{{-0.5, -5.4, -9}, {0.7, -4.6, -0.3}, glm::vec3(0.5f)}};
    scene.transparents = sprites(count);
    return scene;
}

/// Two triangles in one mesh that add nothing, one behind the other: a scene that has it needs
/// lists.
inline MeshTransparent two_deep(double distance)
{
    auto mesh = std::make_shared<Mesh>();
    for (const float y : {0.0f, -0.1f})
        mesh->positions.insert(mesh->positions.end(), {{0, y, 0}, {0.3f, y, 0}, {0, y, 0.3f}});
    mesh->normals.assign(6, glm::vec3(0, 1, 0));
    mesh->triangles = {0, 1, 2, 3, 4, 5};
    MeshTransparent one;
    one.mesh = mesh;
    one.translate = {0, -distance, 0};
    one.look.blend.kind = Kind::add;
    return one;
}

/// Cards of every blend, with an image, a depth fade or both, that go through each other, through a
/// billboard and through the ground, which goes on behind the eye.
inline std::vector<Transparent> crossing_cards(bool seen = true)
{
    std::vector<Transparent> looks = sprites(10, seen), all;
    const auto look = [&](int i) { return look_of(looks.at(static_cast<std::size_t>(i))); };
    for (int i = 0; i < 5; ++i) {
        QuadTransparent card;
        const double turn = 0.37 + 1.1 * i;
        const glm::dvec3 across(std::cos(turn), 1.4 * std::sin(turn), 0.13 * i);
        const glm::dvec3 up(0.21, 0.3 * std::sin(2.3 * i), 1.3);
        card.edges = {1.7 * across, up};
        card.corner =
            glm::dvec3(0.11 * i - 0.17, -5.03 + 0.09 * i, 0.1) - (card.edges[0] + up) / 2.0;
        card.look = look(i);
        all.emplace_back(card);
    }
    BillboardTransparent board;
    board.center = {0.13, -4.9, 0.4};
    board.size = {1.5, 1.1};
    board.look = look(5);
    all.emplace_back(board);
    QuadTransparent ground;
    ground.corner = {4, 3, -0.25};
    ground.edges = {glm::dvec3(-8, 0, 0.1), glm::dvec3(0, -11, 0)};
    ground.look = look(6);
    all.emplace_back(ground);
    return all;
}

/// With one more that nobody sees, and that asks for what is behind it: all go to lists. At the
/// distance of the nearest it changes no depth that a march keeps.
inline Scene in_lists(Scene scene, double distance = 3.1)
{
    QuadTransparent asks = pane(distance, Kind::factors);
    asks.look.blend = {Kind::factors, BlendFactor::dst_alpha, BlendFactor::one};
    asks.look.radiance = glm::vec3(0);
    scene.transparents.emplace_back(asks);
    return scene;
}

}  // namespace fumarole::test
