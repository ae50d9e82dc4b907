#include "light/world_keys.h"

#include <algorithm>
#include <utility>

#include "light_fields.h"
#include "overloaded.h"

namespace fumarole::light {

namespace {

void take_places(Medium& medium, double time, std::vector<glm::dvec3>& places)
{
    const auto take = [&](glm::dvec3& place) {
        places.push_back(std::exchange(place, glm::dvec3(0)));
    };
    std::visit(Overloaded{[&](GridMedium& grid) { take(grid.translate); },
                          [&](BoxMedium& box) {
                              take(box.min);
                              take(box.max);
                              if (auto* height = std::get_if<ExpHeightProfile>(&box.profile))
                                  places.emplace_back(0, 0, std::exchange(height->z0, 0.0));
                              if (auto* noise = std::get_if<NoiseProfile>(&box.profile))
                                  places.push_back(time *
                                                   std::exchange(noise->drift, glm::dvec3(0)));
                          }},
               medium);
}

}  // namespace

Obstacle obstacle_of(const Surface& surface)
{
    Obstacle obstacle;
    obstacle.kind = surface.index();
    std::visit(Overloaded{[&](const SphereSurface& sphere) {
                              obstacle.place = {sphere.center, sphere.center + sphere.radius};
                          },
                          [&](const BoxSurface& box) {
                              obstacle.place = {box.min, box.max};
                          },
                          [&](const MeshSurface& mesh) {
                              obstacle.mesh = mesh.mesh;
                              obstacle.place = {mesh.translate, mesh.translate + mesh.scale};
                          }},
               surface);
    return obstacle;
}

FieldPlaces take_places(FieldKey& key, double time)
{
    struct OfLights {
        std::vector<glm::dvec3>& to;
        void position(const LightField&, glm::dvec3& place) const
        {
            to.push_back(std::exchange(place, glm::dvec3(0)));
        }
        void to_light(const LightField&, const glm::dvec3&) const {}
        void axis(const LightField&, const glm::dvec3&) const {}
        void number(const LightField&, const double&) const {}
        void flag(const LightField&, const bool&) const {}
        void edges(const LightField&, const std::array<glm::dvec3, 2>&) const {}
        void power(const LightField&, const glm::vec3&) const {}
    };
    FieldPlaces places;
    for (Light& light : key.lights)
        std::visit([&](auto& one) { visit_fields(OfLights{places.of_all}, one); }, light);
    for (Medium& medium : key.media)
        take_places(medium, time, places.of_all);
    if (!key.surfaces.empty() || !key.casters.empty())
        places.of_all.emplace_back(0);  // which stay where they are
    return places;
}

FireKey fire_key(const Scene& scene, const medium::MediaSet& media)
{
    FireKey key{scene.media, {}, media.split_off()};
    for (Medium& medium : key.media) {
        take_places(medium, scene.time, key.places);
        std::visit([](auto& one) { one.g = 0; }, medium);
        std::visit(Overloaded{[](GridMedium& grid) {  // WorldKey has what these add up to
                                  grid.sigma_s_per_density = glm::vec3(0);
                                  grid.sigma_a_per_density = glm::vec3(0);
                                  grid.color_grid.clear();
                                  grid.color.reset();
                              },
                              [](BoxMedium& box) {
                                  box.sigma_s = glm::vec3(0);
                                  box.sigma_a = glm::vec3(0);
                              }},
                   medium);
    }
    return key;
}

bool is_moved(const WorldKey& then, const WorldKey& now)
{
    if (then.world != now.world || then.nodes != now.nodes || then.ways != now.ways ||
        then.ways_on_surfaces != now.ways_on_surfaces || then.bands != now.bands ||
        then.dims != now.dims || then.scatters_again != now.scatters_again ||
        then.straight_on != now.straight_on || then.sky_in_parts != now.sky_in_parts ||
        then.lit_beyond != now.lit_beyond || !is_moved(then.in_media, now.in_media) ||
        !is_moved(then.on_surfaces, now.on_surfaces))
        return false;
    const glm::dvec3 moved = now.lattice().origin - then.lattice().origin;
    const double tolerance = tolerance_of(now.lattice());
    return (now.on_surfaces.count == glm::ivec3(0) ||
            medium::is_same_place(then.on_surfaces.origin + moved, now.on_surfaces.origin,
                                  tolerance)) &&
           medium::are_moved(then.media, now.media, moved, tolerance) &&
           are_moved(then.surfaces, now.surfaces, moved, tolerance);
}

bool are_moved(const std::vector<Obstacle>& then, const std::vector<Obstacle>& now,
               glm::dvec3 moved, double tolerance)
{
    const auto is_there = [&](glm::dvec3 before, glm::dvec3 after) {
        return medium::is_same_place(before + moved, after, tolerance);
    };
    return std::equal(then.begin(), then.end(), now.begin(), now.end(),
                      [&](const Obstacle& a, const Obstacle& b) {
                          return a.kind == b.kind && a.mesh == b.mesh &&
                                 is_there(a.place[0], b.place[0]) &&
                                 is_there(a.place[1], b.place[1]);
                      });
}

bool are_moved(const std::vector<glm::dvec3>& then, const std::vector<glm::dvec3>& now,
               glm::dvec3 moved, double tolerance)
{
    return std::equal(then.begin(), then.end(), now.begin(), now.end(),
                      [&](glm::dvec3 before, glm::dvec3 after) {
                          return medium::is_same_place(before + moved, after, tolerance);
                      });
}

}  // namespace fumarole::light
