#include "light/world_plan.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "light/lattice_ways.h"
#include "light/light_filters.h"
#include "light/light_source.h"
#include "light/lit_box.h"

namespace fumarole::light {

namespace {

/// The world's light comes from all around and is smooth. On the same plume it is 0.5 % too bright
/// with 32 nodes and 2.5 times as many cost 2 to 3 times the time.
constexpr int kAutoWorldNodes = 32;
/// Where media are so thick that an optical depth lies between two nodes: of smoke of optical depth
/// 22 and albedo 0.995, all bounces, the relMSE is 1.5e-3 rather than 2.0e-3.
constexpr int kAutoWorldNodesOfThick = 40;
constexpr double kVoxelsPerWorldNode = 3;
/// Of few voxels that are thick, nodes tell more than the grid does: how light falls off in one. By
/// halves, so that parts of a medium that are alike, and frames, have lattices that are.
constexpr double kDepthPerWorldNode = 1.4, kLeastVoxelsPerWorldNode = 0.75;
/// Of media whose parts lie far apart: so many have lattices of the size that one would have.
constexpr double kPartsOfFullSize = 4;
/// The least of the extinction that, scattered straight on, is taken for none: g 0.5 of albedo 0.8.
/// Below it what is scattered is told from light that goes on.
constexpr float kLeastStraightOn = 0.05f;

/// Of the volume for surfaces: how far it goes beyond them and the media, in parts of their size.
/// What smoke or a ball hides of the sky there is a few per cent.
constexpr double kSurfaceMargin = 0.5;
/// What flames throw on surfaces is all that is there at night.
constexpr double kSurfaceMarginOfFire = 1;

double longest_edge(const Bounds& box)
{
    const glm::dvec3 size = box.max - box.min;
    return std::max({size.x, size.y, size.z});
}

/// Nodes along the longest edge of a lattice that is chosen: `least`, and up to twice as many in a
/// flat or a long box, which has as many in all as a plume that is three quarters as wide as high.
int automatic_nodes(const Bounds& box, int least)
{
    constexpr double kPlume = 0.75 * 0.75;  // of the cube around it
    const glm::dvec3 edges = (box.max - box.min) / std::max(longest_edge(box), 1e-300);
    const double share = std::max(edges.x * edges.y * edges.z, 1e-9);
    return static_cast<int>(least * std::clamp(std::cbrt(kPlume / share), 1.0, 2.0));
}

/// Whether a light has a place, in a box.
bool is_within(const Bounds& box, const Light& light)
{
    const LightPosition middle = points_of(light).front();
    return !middle.far && glm::clamp(middle.at, box.min, box.max) == middle.at;
}

bool any_within(const Bounds& box, const LightSet& lights)
{
    return std::any_of(lights.lights().begin(), lights.lights().end(),
                       [&](const Light& light) { return is_within(box, light); });
}

/// Orders that media ask for.
struct AskedOrders {
    double orders = 0;  ///< 0: what scatters a second time is not seen
    std::string why;
};

/// A slab's light is scattered again by what of it does not get out: on the mean over where it
/// starts, 1 - (1 - exp(-tau)) / tau of it meets the medium.
/// From which the best guess at the rest leaves out no more than a part of it, if that falls by
/// `ratio` from order to order (Saad 2003, "Iterative Methods for Sparse Linear Systems",
/// sec. 6.11).
double orders_of_guess(double ratio)
{
    constexpr double kLeftOut = 0.005;
    const double root = std::sqrt(1 - std::min(ratio, 0.9999));
    return std::log(kLeftOut) / std::log((1 - root) / (1 + root));
}

AskedOrders orders_asked_by(const medium::MediaSet::Thickness& media)
{
    constexpr double kUnseen = 0.01;  // of a white picture
    const double albedo = std::max({media.albedo.r, media.albedo.g, media.albedo.b});
    const double tau = std::max(media.optical_depth, 1e-9);
    const double ratio = albedo * (1 + std::expm1(-tau) / tau);
    const double added = albedo * -std::expm1(-tau) * ratio;
    AskedOrders asked;
    asked.why =
        fmt::format("optical depth about {:.2g}, albedo {:.2g}: the second adds {:.1g} of a white "
                    "picture",
                    tau, albedo, added);
    if (added < kUnseen)
        return asked;
    asked.orders = orders_of_guess(ratio);
    return asked;
}

/// Cycles of orders that light from within a thick medium asks for: it leaves by diffusion alone,
/// by as much less from order to order as in a cube of so many mean free paths that ends 0.71 of
/// them beyond its faces. Guesses from FIELD_KEPT_ORDERS at a time take twice as many as one from
/// all.
int cycles_within(const medium::MediaSet::Thickness& media)
{
    constexpr double kMost = 6;
    const double edge = media.optical_depth + 2 * 0.71;
    const double slowest = std::max(1 - std::pow(std::numbers::pi / edge, 2), 0.0);
    const double orders = orders_of_guess(double{media.albedo.g} * slowest);
    return static_cast<int>(std::clamp(std::ceil(2 * orders / FIELD_KEPT_ORDERS), 1.0, kMost));
}

/// How often light that scatters is followed, and why so often: as often as any of the media asks
/// for, or all of them.
/// part: of the media that is asked about, or null.
FieldOrders orders_for(const SceneSettings& settings, const medium::MediaSet& media,
                       const Bounds* part, const LightSet& lights, std::string& why)
{
    why = "as asked";
    if (settings.bounces != kAutomatic)
        return {settings.bounces};
    constexpr int kFewest = 3;
    // What a guess from more orders is out by is seen where little light gets: by 11 % behind a
    // slab of optical depth 6, from 7 of them.
    constexpr double kMostOfOneCycle = 6;
    // Edges of a medium, of those of all, from which on it is there on the coarser lattices too.
    constexpr double kWide = 0.5;
    const std::vector<medium::MediaSet::Thickness> all = media.thicknesses(part);
    AskedOrders most = orders_asked_by(all.front());
    bool wide = true;
    for (std::size_t i = 1; i < all.size(); ++i) {
        AskedOrders asked = orders_asked_by(all[i]);
        if (asked.orders <= most.orders)
            continue;
        most = {asked.orders, "one of the media by itself: " + asked.why};
        wide = longest_edge(all[i].bounds) >= kWide * longest_edge(all.front().bounds);
    }
    why = most.why;
    if (most.orders == 0)
        return {};
    if (most.orders > FIELD_KEPT_ORDERS && wide) {
        const bool from_within = media.carries_glow() || any_within(all.front().bounds, lights);
        return {FIELD_KEPT_ORDERS, from_within ? cycles_within(all.front()) : 1, true};
    }
    return {std::clamp(static_cast<int>(std::ceil(most.orders)), kFewest, FIELD_KEPT_ORDERS),
            most.orders > kMostOfOneCycle ? 2 : 1};
}

/// Whether suns bring media and surfaces so much more light than the sky that what 26 ways are out
/// by of the sky's, 2 % in thick media, is not seen. What panes take of a sun's is not known.
bool suns_outshine_the_sky(const Scene& scene)
{
    const auto casts = [](const Transparent& transparent) { return look_of(transparent).casts; };
    if (std::any_of(scene.transparents.begin(), scene.transparents.end(), casts))
        return false;
    constexpr float kFewTimes = 3;
    glm::vec3 suns(0);
    for (const Light& light : scene.lights)
        if (const auto* sun = std::get_if<SunLight>(&light))
            suns += sun->irradiance;
    const glm::vec3 sky = 4 * std::numbers::pi_v<float> * scene.world.radiance;
    return kFewTimes * (sky.r + sky.g + sky.b) <= suns.r + suns.g + suns.b;
}

/// Of the light that reaches surfaces as far off as what shines is large, about how much comes from
/// media: of flames that are carried, and what they scatter of lamps that stand in them.
double glow_on_surfaces(const PlannedScene& from)
{
    const auto sum = [](glm::dvec3 rgb) { return rgb.r + rgb.g + rgb.b; };
    const auto over = [](double intensity, const Bounds& box) {
        const double edge = std::max(longest_edge(box), 1e-9);
        return intensity / (edge * edge);
    };
    double own = 0, others = std::numbers::pi * sum(glm::dvec3(from.lights.world_radiance()));
    if (from.media.carries_glow()) {
        const medium::MediaSet::CarriedGlow& glow = from.media.carried_glow();
        own = over(sum(glow.glow.power), glow.bounds);
    }
    const medium::MediaSet::Thickness media = from.media.thicknesses().front();
    const double scattered = from.media.traits().scatters
                                 ? double{media.albedo.g} * -std::expm1(-media.optical_depth)
                                 : 0;
    for (const Light& light : from.lights.lights()) {
        if (const auto* sun = std::get_if<SunLight>(&light)) {
            others += sum(glm::dvec3(sun->irradiance));
        } else if (is_within(media.bounds, light)) {
            const double lamp = over(mean_intensity_of(light), media.bounds);
            own += scattered * lamp;
            others += (1 - scattered) * lamp;
        }
    }
    return own > 0 ? own / (own + others) : 0;
}

/// detailed: what comes from a part of the sky alone is to be told from the rest.
int ways_for(const SceneSettings& settings, bool detailed)
{
    if (settings.world_directions != kAutomatic)
        return settings.world_directions;
    return detailed ? kAllWays : kNearWays;
}

/// Whether the media scatter what comes from all around.
bool takes_light(const PlannedScene& from, const FieldKey& field)
{
    return from.media.traits().scatters && (from.settings.world_light || field.filled);
}

/// What the media send on, and how often it is followed.
FieldKey field_key(const PlannedScene& from, std::string& orders_why)
{
    const auto& [scene, settings, media, surfaces, lights, depths, part, turns, around] = from;
    const medium::MediaTraits& traits = media.traits();
    FieldKey field;
    field.turns = turns;
    if (field.turns > 0)
        field.surfaces = scene.surfaces;
    field.casters = casters_of(scene.transparents);
    orders_why.clear();
    const bool glows = media.carries_glow();
    if (settings.ambient_volume_size == 0 || !(traits.scatters || glows))
        return field;
    if (traits.scatters)
        field.orders = orders_for(settings, media, part != nullptr ? &part->bounds : nullptr,
                                  lights, orders_why);
    // Orders that are counted are the media's own.
    const float straight_on = media.straight_on();
    if (field.orders.cycles > 0 && straight_on > kLeastStraightOn)
        field.orders.straight_on = straight_on;
    media.split_forward_peaks(field.orders.straight_on > 0);
    field.glows = glows;
    const bool shines = lights.world_radiance() != glm::vec3(0.0f) || lights.count() > 0;
    field.filled =
        traits.scatters && (field.glows || field.turns > 0 || (field.orders.count > 0 && shines));
    field.on_surfaces = (field.filled || field.glows) && settings.volume_shadows &&
                        !surfaces.empty() && part == nullptr;
    field.media = scene.media;
    field.lights.assign(lights.lights().begin(), lights.lights().end());
    return field;
}

/// What dims the world's light and hides it, but for the lattices.
WorldKey world_key(const PlannedScene& from, const FieldKey& field)
{
    const Scene& scene = from.scene;
    const SceneSettings& settings = from.settings;
    WorldKey key;
    key.dims = settings.volume_shadows;
    key.scatters_again = field.orders.count > 0;
    key.thick = field.orders.coarse_first;
    key.straight_on = field.orders.straight_on;
    if (key.dims)
        key.media = from.media.extinction();
    for (const Surface& surface : scene.surfaces)
        key.surfaces.push_back(obstacle_of(surface));
    key.world = scene.world;
    key.nodes = settings.ambient_volume_size;
    const bool detailed = scene.world.environment || !suns_outshine_the_sky(scene);
    key.ways = ways_for(settings, detailed);
    key.ways_on_surfaces = ways_for(settings, detailed || field.turns > 0);
    if (takes_light(from, field))
        key.bands = from.media.traits().isotropic ? 1 : 4;
    return key;
}

/// Of what two boxes take up, how much both do.
double part_in_common(const Bounds& a, const Bounds& b)
{
    const auto volume = [](const Bounds& box) {
        const glm::dvec3 size = box.max - box.min;
        return size.x * size.y * size.z;
    };
    const double both = a.meets(b) ? volume(a.common(b)) : 0;
    return both / std::max(volume(a) + volume(b) - both, 1e-300);
}

/// The media as all frames of a sequence have them.
std::vector<Medium> but_for_grids(std::vector<Medium> media)
{
    for (Medium& medium : media)
        if (auto* grid = std::get_if<GridMedium>(&medium)) {
            grid->file.clear();
            for (auto* held : {&grid->density, &grid->emission, &grid->color, &grid->temperature})
                held->reset();
        }
    return media;
}

double voxels_per_node(const medium::MediaSet& media, const medium::VoxelFrame& frame,
                       const Bounds* part)
{
    const glm::dvec3 voxels = frame.scattering.max - frame.scattering.min;
    const double depth =
        3 * media.mean_optical_depth(part) / std::max(voxels.x + voxels.y + voxels.z, 1e-9);
    double apart = kVoxelsPerWorldNode;
    while (apart * depth > kDepthPerWorldNode && apart > kLeastVoxelsPerWorldNode)
        apart /= 2;
    return apart;
}

/// What is marched, if by itself it would have nodes that are much closer together. One lattice for
/// smoke of 3 m in 120 m of fog has a node in it, and its lit side is a third too dark.
std::optional<MediaPart> part_amid(const PlannedScene& from)
{
    constexpr double kCloser = 2;  // times
    constexpr double kRim = 2;     // nodes in which the one light becomes the other
    const medium::MediaSet& media = from.media;
    const medium::MediaTraits& traits = media.traits();
    if (from.part != nullptr || traits.islands > 0 || traits.marched == 0 ||
        traits.marched == traits.media)
        return {};
    const bool automatic = from.settings.ambient_volume_size == kAutomatic;
    const auto nodes_along = [&](const Bounds& box) {
        return automatic ? automatic_nodes(box, kAutoWorldNodes)
                         : from.settings.ambient_volume_size;
    };
    MediaPart part{.frame = media.voxel_frame(), .bounds = {}, .is_amid = true};
    medium::VoxelFrame& frame = part.frame;
    const glm::dmat4 world_from_voxel = glm::inverse(frame.voxel_from_world);
    const Bounds marched = frame.marched.transformed(world_from_voxel);
    const double apart = std::max(longest_edge(frame.marched) /
                                      std::max(nodes_along(frame.marched) - 1 - 2 * kRim, 1.0),
                                  voxels_per_node(media, frame, &marched));
    if (longest_edge(frame.scattering) <= kCloser * apart * (nodes_along(frame.scattering) - 1))
        return {};
    const Bounds all = frame.scattering;
    frame.scattering = frame.marched;
    frame.scattering.min -= kRim * apart;
    frame.scattering.max += kRim * apart;
    frame.scattering = frame.scattering.common(all);
    part.rim.min = (frame.marched.min - frame.scattering.min) / apart;
    part.rim.max = (frame.scattering.max - frame.marched.max) / apart;
    part.bounds = frame.scattering.transformed(world_from_voxel);
    const glm::ivec2 flames = from.lights.flame_points();
    part.has_flames = flames.x < flames.y;
    for (int i = flames.x; i < flames.y; ++i) {
        const glm::dvec3 at = from.lights.points()[static_cast<std::size_t>(i)].at;
        part.has_flames &= glm::clamp(at, part.bounds.min, part.bounds.max) == at;
    }
    return part;
}

bool any_beyond(const Bounds& box, const surface::SurfaceSet& surfaces)
{
    return std::any_of(surfaces.instances().begin(), surfaces.instances().end(),
                       [&](const auto& instance) { return !box.contains(instance.bounds); });
}

/// The nodes, and where they lie.
void place_lattices(WorldPlan& plan, const PlannedScene& from, const gl::Device& device)
{
    const medium::MediaSet& media = from.media;
    WorldKey& key = plan.world;
    const bool automatic = key.nodes == kAutomatic;
    const int nodes = automatic ? kAutoWorldNodes : key.nodes;
    if (key.bands > 0) {
        plan.bands = key.bands;
        const medium::VoxelFrame frame =
            from.part != nullptr ? from.part->frame : media.voxel_frame();
        // Of wide media what lies in them takes light from the nodes that are two farther out.
        const int least = key.thick ? kAutoWorldNodesOfThick : kAutoWorldNodes;
        const int chosen = plan.amid ? least : automatic_nodes(frame.scattering, least);
        int in_media = automatic ? chosen : nodes;
        int layers = plan.bands * plan.bands;
        if (from.part != nullptr) {  // as much in all as of a few parts, and in one texture
            const double share = std::cbrt(std::min(1.0, kPartsOfFullSize / double(from.part->of)));
            in_media = std::max(2, static_cast<int>(std::lround(in_media * share)));
            layers = std::max(layers, plan.bands * (static_cast<int>(from.part->of) + 1));
        }
        const Bounds* part = from.part != nullptr ? &from.part->bounds : nullptr;
        plan.in_media = make_cubes(frame.voxel_from_world, frame.scattering,
                                   automatic ? voxels_per_node(media, frame, part) : 1e-9,
                                   clamp_to(in_media, layers, device));
        key.in_media = place_of(plan.in_media);
    }
    if (!from.surfaces.empty() && from.part == nullptr) {
        const bool fire = plan.field.on_surfaces && plan.field.glows;
        Bounds around = with_details(media.bounds(), from.surfaces);
        const glm::dvec3 margin =
            (fire ? kSurfaceMarginOfFire : kSurfaceMargin) * (around.max - around.min);
        around.min -= margin;
        around.max += margin;
        const int most = clamp_to(nodes, kSurfaceBands * kSurfaceBands, device);
        const double spacing = longest_edge(around) / (most - 1);
        plan.one_box = lone_box(around, from.surfaces.instances()) != nullptr;
        if (!fire && plan.field.turns == 0)
            around = lit_box(around, media.bounds(), from.surfaces.instances(), spacing);
        plan.on_surfaces = make_cubes(glm::dmat4(1.0), around, spacing, most);
        // What suns have media throw that far is not seen beside the suns' own light there.
        key.lit_beyond = plan.glow_on_surfaces >= kGlowIsSeen &&
                         any_beyond(bounds_of(plan.on_surfaces), from.surfaces);
        plan.media = media.bounds();
        key.on_surfaces = place_of(plan.on_surfaces);
    }
    plan.places.origin = key.lattice().origin;
}

}  // namespace

std::optional<WorldPlan> plan_world(const PlannedScene& from, const gl::Device& device,
                                    std::string& orders_why)
{
    WorldPlan plan;
    FieldKey& field = plan.field;
    field = field_key(from, orders_why);
    const bool scatters = takes_light(from, field);
    const bool world =
        from.lights.world_radiance() != glm::vec3(0.0f) && (scatters || !from.surfaces.empty());
    if (from.settings.ambient_volume_size == 0 || from.media.traits().media == 0 ||
        !(world || field.has_any()) || (from.part != nullptr && !scatters))
        return std::nullopt;
    plan.world = world_key(from, field);
    if (field.has_any()) {
        field.depth_nodes = from.depths.nodes();
        field.depths = from.depths.refills();
        field.around = from.around;
    } else {
        field = {};
    }
    if (field.on_surfaces)
        plan.glow_on_surfaces = glow_on_surfaces(from);
    if (field.on_surfaces && field.glows)
        plan.fire = fire_key(from.scene, from.media);
    plan.places = take_places(field, from.scene.time);
    if (scatters)
        plan.amid = part_amid(from);
    place_lattices(plan, from, device);
    return plan;
}

FlameScale flame_scale(const SceneSettings& settings, const medium::MediaSet& media,
                       const surface::SurfaceSet& surfaces)
{
    FlameScale scale;
    const int nodes = settings.ambient_volume_size;
    if (nodes == 0 || media.traits().islands > 0)
        return scale;
    const bool automatic = nodes == kAutomatic;
    scale.scatters = media.traits().scatters;
    if (scale.scatters) {
        const medium::VoxelFrame frame = media.voxel_frame();
        const double voxel =
            1 / std::cbrt(std::abs(glm::determinant(glm::dmat3(frame.voxel_from_world))));
        const int most = automatic ? automatic_nodes(frame.scattering, kAutoWorldNodes) : nodes;
        const double voxels = longest_edge(frame.scattering) / (most - 1);
        scale.node =
            voxel * (automatic ? std::max(voxels, voxels_per_node(media, frame, nullptr)) : voxels);
    }
    if (!surfaces.empty()) {
        const Bounds around = with_details(media.bounds(), surfaces);
        const int most = automatic ? kAutoWorldNodes : nodes;
        scale.node = std::max(scale.node,
                              (1 + 2 * kSurfaceMarginOfFire) * longest_edge(around) / (most - 1));
    }
    return scale;
}

Bounds with_details(const Bounds& media, const surface::SurfaceSet& surfaces)
{
    Bounds around = media;
    for (const auto& instance : surfaces.instances())
        if (is_detail(instance, media))
            around.add(instance.bounds);
    return around;
}

bool is_same_field(const WorldPlan& then, const WorldPlan& now)
{
    const LatticePlace& lattice = now.world.lattice();
    const double tolerance = tolerance_of(lattice);
    const glm::dvec3 moved = now.places.origin - then.places.origin;
    return then.field == now.field &&
           are_moved(then.places.of_all, now.places.of_all, moved, tolerance);
}

bool is_same_fire(const WorldPlan& then, const WorldPlan& now)
{
    const LatticePlace &lattice_then = then.world.on_surfaces, &lattice = now.world.on_surfaces;
    if (!is_moved(lattice_then, lattice) || then.fire.media != now.fire.media ||
        then.fire.small != now.fire.small)
        return false;
    const glm::dvec3 moved = lattice.origin - lattice_then.origin;
    const double tolerance = tolerance_of(lattice);
    return medium::are_moved(then.world.media, now.world.media, moved, tolerance) &&
           are_moved(then.world.surfaces, now.world.surfaces, moved, tolerance) &&
           are_moved(then.fire.places, now.fire.places, moved, tolerance);
}

bool is_like(const WorldPlan& then, const WorldPlan& now)
{
    // What of the light before is no more would be left as a ghost: of what has gone out, of a lamp
    // that has left, or behind a shutter that has closed. What glows may go out at any time. In
    // media of eight times the sequence's density 0.3 % is left out of what is scattered, where
    // orders from a coarser lattice's leave 0.03 %.
    constexpr double kLeastInCommon = 0.75;
    const FieldKey &before = then.field, &field = now.field;
    const auto follows = [](const FieldKey& key) {
        return key.filled && !key.glows && key.orders.cycles > 0 && !key.orders.coarse_first;
    };
    if (!follows(before) || !follows(field) || before.orders.cycles != field.orders.cycles ||
        std::abs(before.orders.count - field.orders.count) > 1 ||
        before.orders.straight_on != field.orders.straight_on || then.bands != now.bands ||
        then.world.dims != now.world.dims || then.world.world != now.world.world ||
        before.lights != field.lights || before.turns != field.turns ||
        before.surfaces != field.surfaces || before.casters != field.casters ||
        but_for_grids(before.media) != but_for_grids(field.media))
        return false;
    const double tolerance = tolerance_of(now.world.in_media);
    const glm::dvec3 nowhere(0);
    return are_moved(then.places.of_all, now.places.of_all, nowhere, tolerance) &&
           are_moved(then.world.surfaces, now.world.surfaces, nowhere, tolerance) &&
           part_in_common(bounds_of(then.in_media), bounds_of(now.in_media)) >= kLeastInCommon;
}

FieldOrders orders_to_go(FieldOrders orders, OrdersStart::From from)
{
    constexpr int kFewest = 3;
    if (from == OrdersStart::From::arrived)
        orders.count = std::min(orders.count, std::max(orders.count - 1, kFewest));
    if (from == OrdersStart::From::arrived || from == OrdersStart::From::arrived_here)
        orders.cycles = 1;
    return orders;
}

bool is_same_plan(const WorldPlan& then, const WorldPlan& now)
{
    return then.places.origin == now.places.origin && is_moved(then.world, now.world) &&
           is_same_field(then, now);
}

bool is_left_behind(const WorldPlan& then, const WorldPlan& now)
{
    const LatticePlace& lattice = now.world.lattice();
    return glm::length(now.places.origin - then.places.origin) > spacing_of(lattice) &&
           is_moved(then.world, now.world);
}

}  // namespace fumarole::light
