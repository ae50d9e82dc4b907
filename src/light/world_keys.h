#pragma once

#include <array>
#include <memory>
#include <vector>

#include "light/lattice.h"
#include "light/radiance_field.h"
#include "medium/media_set.h"
#include <fumarole/scene.h>

// What light that is not direct was filled from: by it is told whether a scene asks for another.

namespace fumarole::light {

/// A surface without its albedo.
struct Obstacle {
    std::size_t kind = 0;  ///< into Surface
    std::shared_ptr<const Mesh> mesh;
    std::array<glm::dvec3, 2> place{};  ///< points that pin where it lies, metres, world
};

/// What the world's light was filled from. All of it may be moved as a whole with its lattice,
/// and it stays.
struct WorldKey {
    std::vector<medium::Extinction> media;  ///< media that dim it
    std::vector<Obstacle> surfaces;
    World world;
    int nodes = 0, bands = 0;            ///< bands: 0 where no medium scatters
    int ways = 0, ways_on_surfaces = 0;  ///< directions that the world's light comes along
    bool dims = true;                    ///< the media do
    bool scatters_again = false;         ///< what they scatter is followed
    float straight_on = 0;               ///< FieldMedium's
    bool thick = false;                  ///< light hardly gets from node to node
    bool lit_beyond = false;             ///< surfaces beyond their lattice have light of the media
    bool sky_in_parts = false;           ///< each way sees a part of what of the sky it stands for
    LatticePlace in_media, on_surfaces;  ///< their lattices

    /// That which the places of all else are seen from.
    [[nodiscard]] const LatticePlace& lattice() const { return bands > 0 ? in_media : on_surfaces; }
};

/// What the field of light was filled from besides the world's light, as if all of it lay at
/// the origin, and the places of it, which may be moved as a whole with the lattice.
struct FieldKey {
    bool filled = false;       ///< light in the media
    bool on_surfaces = false;  ///< what they emit and scatter onto surfaces
    FieldOrders orders;
    bool glows = false;
    int turns = 0;                  ///< number of times that surfaces send light on
    std::vector<Surface> surfaces;  ///< which, if they do
    std::vector<Medium> media;
    std::vector<Light> lights;
    std::vector<Transparent> casters;  ///< transparents that filter the lights
    glm::ivec3 depth_nodes{0};         ///< of the depths to lights, if there are any
    int depths = 0;  ///< number of times that depths to moved lights came over several frames
    int around = 0;  ///< and of times that light of wider media came
    bool operator==(const FieldKey&) const = default;
    /// Whether there is any such light.
    [[nodiscard]] bool has_any() const { return filled || on_surfaces || turns > 0; }
};

struct FieldPlaces {
    std::vector<glm::dvec3> of_all;  ///< metres, world
    glm::dvec3 origin{0};            ///< origin of the lattice's first node
};

/// What surfaces have of what media emit was filled from, besides WorldKey's media and
/// surfaces.
struct FireKey {
    std::vector<Medium> media;       ///< without what doesn't matter, as FieldKey's
    std::vector<glm::dvec3> places;  ///< metres, world
    std::vector<bool> small;         ///< those whose glow is that of lights
};

Obstacle obstacle_of(const Surface& surface);

/// Takes the places out of a key, whose media are as at `time` [s].
FieldPlaces take_places(FieldKey& key, double time);

FireKey fire_key(const Scene& scene, const medium::MediaSet& media);

/// Whether the one is the other, but for where all of it lies.
bool is_moved(const WorldKey& then, const WorldKey& now);
/// Whether `now` is `then` moved by `moved` [m] as a whole, to within `tolerance` [m].
bool are_moved(const std::vector<Obstacle>& then, const std::vector<Obstacle>& now,
               glm::dvec3 moved, double tolerance);
bool are_moved(const std::vector<glm::dvec3>& then, const std::vector<glm::dvec3>& now,
               glm::dvec3 moved, double tolerance);

}  // namespace fumarole::light
