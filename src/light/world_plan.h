#pragma once

#include <optional>
#include <string>

#include "light/flames.h"
#include "light/light_depths.h"
#include "light/light_set.h"
#include "light/world_keys.h"
#include "medium/media_set.h"
#include "surface/surface_set.h"
#include <fumarole/settings.h>

// How light that is not direct is filled for a scene: from what, how often it is followed, and at
// which nodes.

namespace fumarole::light {

constexpr int kSurfaceBands = 3;  ///< bands of light on surfaces

/// Of the light that reaches a surface as far from what glows as that is large, about how much is
/// of that, if all else is of suns and the sky. With less than this it is not seen that a few ways
/// bring a quarter more or less of what smoke scatters of it, which is less than half of it.
constexpr double kGlowIsSeen = 0.1;

/// A part of the media that has a lattice of its own.
struct MediaPart {
    medium::VoxelFrame frame;
    Bounds bounds;       ///< metres, world
    std::size_t of = 1;  ///< number of parts
    /// Wider media are around it, whose light it takes: else it lies apart from others.
    bool is_amid = false;
    bool has_flames = false;  ///< the light of flames is carried through it: they are no points
    Bounds rim = {};          ///< nodes that lie around what is marched, below and above
};

/// What light that is not direct is filled from, and at which nodes.
struct WorldPlan {
    WorldKey world;
    FireKey fire;
    FieldKey field;
    FieldPlaces places;
    Lattice in_media, on_surfaces;
    Bounds media;          ///< metres, world: from where they light surfaces beyond that lattice
    int bands = 1;         ///< number of bands of the light in the media
    bool one_box = false;  ///< a box is all that stands where surfaces are lit
    /// Of the light that reaches surfaces near media, about how much comes from these: of what
    /// glows, or of lamps that stand in them.
    double glow_on_surfaces = 0;
    /// What media scatter onto surfaces is gathered along rays.
    [[nodiscard]] bool along_rays() const
    {
        return field.turns == 0 && field.glows && glow_on_surfaces >= kGlowIsSeen;
    }
    /// What is marched, where wider media around it set the nodes too far apart for it.
    std::optional<MediaPart> amid;
};

/// What a plan is made of.
struct PlannedScene {
    const Scene& scene;
    const SceneSettings& settings;
    medium::MediaSet& media;
    const surface::SurfaceSet& surfaces;
    const LightSet& lights;
    const LightDepths& depths;
    const MediaPart* part = nullptr;  ///< null: of all media
    int turns = 0;                    ///< number of times that surfaces send light on
    int around = 0;                   ///< FieldKey's
};

/// None where there is no such light, or it isn't asked for. The media scatter from then on as the
/// plan has it.
/// @param orders_why light is followed as often as it is; empty: nothing scatters
std::optional<WorldPlan> plan_world(const PlannedScene& from, const gl::Device& device,
                                    std::string& orders_why);

/// How flames compare with the nodes that light would be carried through.
FlameScale flame_scale(const SceneSettings& settings, const medium::MediaSet& media,
                       const surface::SurfaceSet& surfaces);

/// Metres, world: of the media and what stands amid them.
Bounds with_details(const Bounds& media, const surface::SurfaceSet& surfaces);

/// The same field of light, but for where all of it lies.
bool is_same_field(const WorldPlan& then, const WorldPlan& now);
/// Likewise of what surfaces have of what media emit.
bool is_same_fire(const WorldPlan& then, const WorldPlan& now);
/// The same, and nothing has moved.
bool is_same_plan(const WorldPlan& then, const WorldPlan& now);
/// Whether the media's light is so much like what it was that orders may start from that, as from
/// frame to frame of a sequence.
bool is_like(const WorldPlan& then, const WorldPlan& now);
/// What of the orders is followed from there. From the frame before one cycle of all but one of
/// them leaves 0.04 % out of what the sample sequence scatters, of half of them 0.24 %. What
/// surfaces send back changes more of it, and a cycle of all is followed from the round before.
FieldOrders orders_to_go(FieldOrders orders, OrdersStart::From from);
/// Whether the scene has moved as a whole, by more than from a node to the next.
bool is_left_behind(const WorldPlan& then, const WorldPlan& now);

}  // namespace fumarole::light
