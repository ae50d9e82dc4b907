#include "light/surface_turns.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "light/surface_rays.h"
#include "overloaded.h"

namespace fumarole::light {

namespace {

/// What is less of a white picture is left out.
constexpr double kUnseenTurn = 0.01;

Bounds bounds_of_media(const Scene& scene)
{
    Bounds all;
    for (const Medium& medium : scene.media)
        std::visit(Overloaded{[&](const GridMedium& grid) {
                                  if (grid.density == nullptr)
                                      return;
                                  Bounds own;
                                  own.min = glm::dvec3(grid.density->index_min) - 0.5;
                                  own.max = glm::dvec3(grid.density->index_max) + 0.5;
                                  own = own.transformed(grid.density->world_from_index);
                                  all.add(grid.translate + grid.scale * own.min);
                                  all.add(grid.translate + grid.scale * own.max);
                              },
                              [&](const BoxMedium& box) {
                                  all.add(box.min);
                                  all.add(box.max);
                              }},
                   medium);
    return all;
}

glm::dvec3 albedo_of(const Surface& surface)
{
    return std::visit([](const auto& one) { return glm::dvec3(one.albedo); }, surface);
}

/// What surfaces send onto each other in one turn, of a white picture all around, were all of them
/// lit as a white one: the mean, as it is seen from places amid the media, of a surface's albedo
/// times that of what it sees, of the colour that has most of it.
double seen_of_a_turn(const Scene& scene)
{
    const Bounds media = bounds_of_media(scene);
    if (media.empty())
        return 0;
    // So many tests of a ray and a triangle take some tenth of a second.
    constexpr double kTests = 2e7;
    constexpr int kPlaces = 16, kLooks = 32, kMostFurther = 12;
    double shapes = 0;
    for (const Surface& surface : scene.surfaces) {
        const auto* mesh = std::get_if<MeshSurface>(&surface);
        shapes += mesh == nullptr || mesh->mesh == nullptr
                      ? 1.0
                      : static_cast<double>(mesh->mesh->triangles.size()) / 3;
    }
    const int further =
        std::clamp(static_cast<int>(kTests / (shapes * kPlaces * kLooks)) - 1, 1, kMostFurther);
    const SurfaceRays rays(scene.surfaces);
    const std::vector<glm::dvec3> looks = even_directions(kLooks);
    // A Fibonacci lattice's, taken a few at a time in an order that leaves each few spread.
    constexpr int kTurns = 61, kStep = 23;
    const std::vector<glm::dvec3> around = even_directions(kTurns);
    glm::dvec3 sum(0);
    int places = 0, turned = 0;
    for (int i = 0; i < kPlaces; ++i) {
        const glm::dvec3 place = spread_place(media, i);
        if (rays.is_near(place, 0))
            continue;
        ++places;
        for (const glm::dvec3& look : looks) {
            const auto hit = rays.first(place, look);
            if (!hit)
                continue;
            glm::dvec3 normal = rays.normal_of(*hit, place + hit->range * look);
            if (glm::dot(normal, look) > 0)
                normal = -normal;
            const glm::dvec3 from = place + hit->range * (1 - 1e-6) * look;
            glm::dvec3 sent(0);
            for (int k = 0; k < further; ++k) {
                // By the cosine to the normal.
                const auto way = static_cast<std::size_t>(turned++ * kStep % kTurns);
                const glm::dvec3 on = normal + around[way];
                if (glm::length(on) < 1e-6)
                    continue;
                if (const auto met = rays.first(from, glm::normalize(on)))
                    sent += albedo_of(scene.surfaces[static_cast<std::size_t>(met->surface)]);
            }
            sum += albedo_of(scene.surfaces[static_cast<std::size_t>(hit->surface)]) * sent /
                   static_cast<double>(further * kLooks);
        }
    }
    return places == 0 ? 0 : std::max({sum.r, sum.g, sum.b}) / places;
}

}  // namespace

SurfaceTurnsKey surface_turns_key(const Scene& scene, const SceneSettings& settings)
{
    return {scene.surfaces, scene.media.size(), scene.probes.empty(),
            settings.ambient_volume_size == 0, settings.surface_bounces};
}

SurfaceTurns surface_turns(const Scene& scene, const SceneSettings& settings)
{
    if (scene.surfaces.empty() || settings.ambient_volume_size == 0)
        return {};
    if (settings.surface_bounces != kAutomatic)
        return {settings.surface_bounces, "as asked"};
    // What is left out is a few per cent of what they send in a closed room, and less in an open
    // one.
    constexpr double kLeftOut = 0.05;
    constexpr int kFewest = 2, kMost = 8;
    std::string why;
    if (!scene.probes.empty())
        why = "the scene has probes";
    float albedo = 0;
    for (const Surface& surface : scene.surfaces)
        std::visit(
            [&](const auto& s) {
                if (why.empty() && (s.gloss.has_value() || s.emission != glm::vec3(0)))
                    why = s.gloss ? "a surface is glossy" : "a surface shines";
                albedo = std::max(albedo, (s.albedo.r + s.albedo.g + s.albedo.b) / 3);
            },
            surface);
    if (why.empty()) {
        const double seen = seen_of_a_turn(scene);
        why = fmt::format("from amid the media one adds {:.2g} of a white picture", seen);
        if (seen < kUnseenTurn)
            return {0, fmt::format("{}, less than {:.2g}", why, kUnseenTurn)};
    }
    const double turns =
        std::log(kLeftOut) / std::log(std::clamp(0.9 * double(albedo), 0.01, 0.99));
    return {std::clamp(static_cast<int>(std::ceil(turns)), kFewest, kMost), why};
}

TurnPlan plan_turns(int turns, int rounds)
{
    constexpr int kAgain = 2;  // of the last turns, once it is known what media throw on surfaces
    const int again = std::min(turns, kAgain);
    if (rounds < 2)
        return {turns, again, std::vector<int>(static_cast<std::size_t>(rounds), again)};
    const int first = std::max(turns - again, std::min(turns, kNotedTurns));
    return {first, again, {first + again - turns, again}};
}

}  // namespace fumarole::light
