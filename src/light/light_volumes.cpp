#include "light/light_volumes.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "gl/stopwatch.h"
#include "light/lattice_ways.h"
#include "light/light_source.h"

namespace fumarole::light {

namespace {

/// Where the orders of thick media start: on a lattice of so many nodes along its longest edge,
/// then on one of twice as many.
constexpr int kCoarsestNodes = 4;
/// Of orders, on the coarsest lattice and on those between it and the last.
constexpr int kMostCycles = 6, kFewerCycles = 3;
/// What a plume leaves of the light on surfaces is smooth: with 2 pictures have a relMSE of 2e-6
/// against those with 4. What is cut off by a box, as of haze in a hall, is 0.5 % less with them.
constexpr int kMostSamplesOnSurfaces = 2;

constexpr float kLeastRim = 1e-3f;  ///< nodes: where a lattice's face is one of all media

constexpr int kWallLayers = 2;  ///< layers of a texture of walls between nodes

/// While it lives no medium's glow is left out because flames stand for it, if they are not to.
class CarriedFlames {
public:
    CarriedFlames(medium::MediaSet& media, bool carried)
        : media_{media}, before_{carried ? media.split_off() : std::vector<bool>()}
    {
        if (!before_.empty())
            media_.split_off({});
    }
    ~CarriedFlames()
    {
        if (!before_.empty())
            media_.split_off(before_);
    }
    CarriedFlames(const CarriedFlames&) = delete;
    CarriedFlames& operator=(const CarriedFlames&) = delete;

private:
    medium::MediaSet& media_;
    std::vector<bool> before_;
};

/// A field that was filled by one plan, as another's takes it.
OtherLight field_at(const gl::Texture& field, const WorldPlan& of, const WorldPlan& from)
{
    return {&field, nullptr, to_shared(of.in_media, of.bands * of.bands, centre_of(from.in_media)),
            of.bands};
}

}  // namespace

/// One filling of light that is not direct, and what its steps give each other.
struct LightVolumes::WorldFill {
    FieldScene scene;
    WorldLight to = {};        ///< by its plan
    gl::Defines variant = {};  ///< of the scene that it goes on by
    bool is_spread = false;    ///< over frames
    bool anew = false;         ///< nothing of what was there stays
    bool world = false;        ///< the world's light in the media is filled
    bool of_media = false;     ///< what the media scatter or emit is
    bool on_surfaces = false;  ///< what they and the surfaces throw on surfaces is, or is no more
    bool shines = false;       ///< the world does
    TurnPlan turns = {};
    OrdersStart start = {};         ///< of the orders in the media
    gl::Texture started_from = {};  ///< its light, if that is kept nowhere else
    gl::Texture scattered = {};     ///< what they scatter, as RadianceField::fill() gives it
    const gl::Texture* of_world = nullptr;  ///< WorldLight::coefficients, of this or of before
    bool outdated = false;                  ///< the scene has changed meanwhile
    int frames = 0;                         ///< that it was filled over
    Steps steps = {};
};

LightVolumes::LightVolumes(const gl::Device& device, gl::ProgramCache& programs,
                           const gl::PassTimers& timers)
    : device_{device}, programs_{programs}, timers_{timers}, tools_{device, programs, timers},
      extinction_{tools_}, depths_{tools_, extinction_}, field_{device, programs},
      field_on_surfaces_{device, programs}, fade_in_media_{device, programs},
      fade_on_surfaces_{device, programs}, fade_dimmed_{device, programs}, island_light_{device}
{
}

LightVolumes::~LightVolumes() = default;

void LightVolumes::clear()
{
    extinction_.drop();
    depths_.clear();
    drop_world();
    islands_.clear();
    island_light_.drop();
    amid_.reset();
}

void LightVolumes::drop_world()
{
    stop_filling();
    light_ = {};
    for (LightFade* fade : {&fade_in_media_, &fade_on_surfaces_, &fade_dimmed_})
        fade->end();
    world_ = {};
    keeps_world_ = false;
    field_.forget();
    field_on_surfaces_.forget();
}

medium::VoxelFrame LightVolumes::frame_of(const medium::MediaSet& media) const
{
    return part_ ? part_->frame : media.voxel_frame();
}

void LightVolumes::set(const Scene& scene, const SceneSettings& settings, medium::MediaSet& media,
                       const surface::SurfaceSet& surfaces, LightSet& lights)
{
    set_volumes(scene, settings, media, surfaces, lights);
    set_islands(scene, settings, media, surfaces, lights);
    set_amid(scene, settings, media, surfaces, lights);
    scatter_as_shown(media);
}

void LightVolumes::set_amid(const Scene& scene, const SceneSettings& settings,
                            medium::MediaSet& media, const surface::SurfaceSet& surfaces,
                            LightSet& lights)
{
    const WorldPlan& plan = !fill_ ? light_.plan : fill_->outdated ? wanted_ : fill_->to.plan;
    const std::optional<MediaPart>& part = plan.amid;
    if (!part || !world_) {
        turned_ &= amid_ == nullptr;
        amid_.reset();
        return;
    }
    if (!amid_) {
        amid_ = std::make_unique<LightVolumes>(device_, programs_, timers_);
        turned_ = false;
    }
    amid_->part_ = part;
    amid_->whole_ = this;
    const CarriedFlames carried(media, part->has_flames);
    amid_->set_volumes(scene, settings, media, surfaces, lights);
    if (!amid_->world_)
        amid_.reset();
}

void LightVolumes::set_islands(const Scene& scene, const SceneSettings& settings,
                               medium::MediaSet& media, const surface::SurfaceSet& surfaces,
                               LightSet& lights)
{
    std::vector<medium::VoxelFrame> frames;
    if (media.traits().islands > 0)
        frames = media.island_frames();
    islands_.resize(frames.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (!islands_[i])
            islands_[i] = std::make_unique<LightVolumes>(device_, programs_, timers_);
        LightVolumes& island = *islands_[i];
        const Bounds bounds =
            frames[i].marched.transformed(glm::inverse(frames[i].voxel_from_world));
        island.part_ = {frames[i], bounds, frames.size()};
        island.whole_ = this;
        island.set_volumes(scene, settings, media, surfaces, lights);
    }
    const bool has_light = std::any_of(islands_.begin(), islands_.end(), [](const auto& island) {
        return static_cast<bool>(island->world_);
    });
    if (has_light)
        island_light_.set(parts_with_light());
    else
        island_light_.drop();
}

std::vector<IslandLight::Part> LightVolumes::parts_with_light() const
{
    std::vector<IslandLight::Part> parts;
    const auto add = [&](const LightVolumes& volumes) {
        parts.push_back({volumes.world_, volumes.light_.plan.in_media, volumes.turns_to_eye_});
    };
    for (const auto& island : islands_)
        add(*island);
    add(*this);
    return parts;
}

void LightVolumes::set_volumes(const Scene& scene, const SceneSettings& settings,
                               medium::MediaSet& media, const surface::SurfaceSet& surfaces,
                               LightSet& lights)
{
    const medium::MediaTraits& traits = media.traits();
    extinction_.set_color(media);
    flames_ = lights.flame_points();
    const bool depth = settings.volume_shadows && settings.shadow_volume_size != 0 &&
                       settings.shadow_range == SceneSettings::ShadowRange::media &&
                       traits.marched > 0 && traits.islands == 0 && !part_ && lights.count() > 0;
    if (depth) {
        depths_.set(settings, frame_of(media), media, lights);
    } else {
        extinction_.drop();
        depths_.clear();
    }
    field_frames_ = settings.field_fill;
    field_from_before_ = settings.field_from_before;
    const SurfaceTurns& turns = turns_.of(surface_turns_key(scene, settings),
                                          [&] { return surface_turns(scene, settings); });
    std::optional<WorldPlan> plan =
        plan_world({scene, settings, media, surfaces, lights, depths_of_all(),
                    part_ ? &*part_ : nullptr, turns.turns, fills_around()},
                   device_, orders_why_);
    if (plan) {
        plan->world.sky_in_parts = lights.world_radiance() != glm::vec3(0.0f) && !part_ &&
                                   is_sky_in_parts(scene, media.bounds());
        set_plan(std::move(*plan), {media, surfaces, lights});
    } else {
        drop_world();
    }
    if (!depths_.has_more())
        extinction_.drop();
}

bool LightVolumes::is_sky_in_parts(const Scene& scene, const Bounds& media)
{
    const auto ask = [&] { return sky_seen(scene.surfaces, media); };
    return sky_.of({scene.surfaces, scene.media.size()}, ask).in_parts;
}

bool LightVolumes::go_on(medium::MediaSet& media, const surface::SurfaceSet& surfaces,
                         LightSet& lights)
{
    const FieldScene scene{media, surfaces, lights};
    const int shown = fields_shown_;
    const bool has_depths = depths_.go_on(media);
    if (has_depths)
        fill_again(scene);
    if (fill_)
        go_on_filling(scene);
    bool changes = go_on_fading() || has_depths;
    if (!amid_)
        return changes;
    const CarriedFlames carried(media, amid_->part_->has_flames);
    if (has_depths || shown != fields_shown_)
        amid_->fill_again(scene);
    if (amid_->has_more())
        changes |= amid_->go_on(media, surfaces, lights);
    return changes;
}

void LightVolumes::fill_again(const FieldScene& scene)
{
    const WorldPlan& last = fill_ ? fill_->to.plan : light_.plan;
    if (last.field == FieldKey())
        return;
    WorldPlan plan = fill_ && fill_->outdated ? wanted_ : last;
    plan.field.depths = depths_of_all().refills();
    plan.field.around = fills_around();
    set_plan(std::move(plan), scene);
}

gl::Texture LightVolumes::make_coefficients(const char* label, const WorldPlan& plan) const
{
    return make_volume(device_, label, plan.in_media, plan.bands * plan.bands, GL_RGBA16F);
}

bool LightVolumes::may_spread(const medium::MediaSet& media) const
{
    const medium::MediaTraits& traits = media.traits();
    // The extinction that lights are marched through is not kept from frame to frame.
    const bool has_depths = depths_of_all() || traits.marched == 0;
    return field_frames_ > 1 && (!part_ || part_->is_amid) && traits.islands == 0 && has_depths;
}

void LightVolumes::set_plan(WorldPlan plan, const FieldScene& scene)
{
    if (fill_)
        follow(plan);
    bool spreads = may_spread(scene.media);
    // What changes meanwhile is filled after, if the same shaders go on with what was begun, and
    // its nodes are not left behind. Else it is filled at once: it might be for ever begun anew.
    if (fill_ && (!spreads || fill_->variant != field_defines(scene) ||
                  is_left_behind(fill_->to.plan, plan))) {
        stop_filling();
        spreads = false;
    }
    if (!fill_) {
        begin_world(std::move(plan), scene, spreads);
        return;
    }
    fill_->outdated |= !is_same_plan(fill_->to.plan, plan);
    wanted_ = std::move(plan);
}

void LightVolumes::follow(const WorldPlan& now)
{
    WorldPlan& plan = light_.plan;
    const glm::dvec3 by = now.places.origin - plan.places.origin;
    if (!(light_.in_media() || light_.on_surfaces) || by == glm::dvec3(0) ||
        !is_moved(plan.world, now.world))
        return;
    plan.world = now.world;
    plan.in_media = now.in_media;
    plan.on_surfaces = now.on_surfaces;
    plan.places.origin = now.places.origin;
    for (std::vector<glm::dvec3>* places : {&plan.places.of_all, &plan.fire.places})
        for (glm::dvec3& place : *places)
            place += by;
    if (light_.fire)
        light_.fire->move_to(bounds_of(plan.on_surfaces).min);
    for (LightFade* fade : {&fade_in_media_, &fade_on_surfaces_, &fade_dimmed_})
        if (fade->is_on())
            fade->move(by);
    turned_ = false;
}

void LightVolumes::begin_world(WorldPlan plan, const FieldScene& scene, bool spreads)
{
    follow(plan);
    auto fill = std::make_unique<WorldFill>(WorldFill{.scene = scene});
    fill->variant = field_defines(scene);
    fill->is_spread = spreads && (light_.in_media() || light_.on_surfaces);
    fill->to.plan = std::move(plan);
    const gl::Stopwatch watch(device_, timers_);
    plan_fill(*fill);
    fill->steps = fill_all(*fill);
    const bool fills = fill->anew || fill->world || fill->of_media || fill->on_surfaces;
    if (fill->is_spread && fills) {
        fill_ = std::move(fill);
        return;
    }
    if (spreads && fills)  // before there is something to fade from
        prepare_fades(*fill);
    fill->steps.finish();
    if (fills) {
        fill->to.ms = watch.ms();
        parts_ = fill->steps.pauses() + 1;
    }
    show(*fill);
}

void LightVolumes::go_on_filling(const FieldScene& scene)
{
    scene.media.split_forward_peaks(fill_->to.plan.field.orders.straight_on > 0);
    bool more = true;
    ++fill_->frames;
    try {
        for (int left = (parts_ + field_frames_ - 1) / field_frames_; more && left > 0; --left)
            more = fill_->steps.resume();
        if (!more) {
            parts_ = fill_->steps.pauses() + 1;
            const std::unique_ptr<WorldFill> done = std::move(fill_);
            show(*done);
            if (done->outdated)
                begin_world(std::move(wanted_), scene, true);
        }
    } catch (...) {  // what was shown before is shown still
        stop_filling();
        scatter_as_shown(scene.media);
        throw;
    }
    scatter_as_shown(scene.media);
}

void LightVolumes::stop_filling()
{
    fill_.reset();
    field_.end();
    field_on_surfaces_.end();
}

void LightVolumes::plan_fill(WorldFill& fill)
{
    const WorldPlan& plan = fill.to.plan;
    const FieldKey& field = plan.field;
    const bool has_media = plan.world.bands > 0;
    const bool same_field = is_same_field(light_.plan, plan);
    fill.shines = fill.scene.lights.world_radiance() != glm::vec3(0.0f);
    // The world's light is dimmed by what albedo and g leave of the extinction.
    fill.anew = !(light_.in_media() || light_.on_surfaces) ||
                !is_moved(light_.plan.world, plan.world) ||
                (plan.world.straight_on > 0 && !same_field);
    fill.of_media =
        has_media && field.filled && (fill.anew || !light_.field_coefficients || !same_field);
    const FieldKey& before = light_.plan.field;
    const bool lights_surfaces = field.on_surfaces || field.turns > 0;
    const bool lit_surfaces = before.on_surfaces || before.turns > 0;
    fill.on_surfaces = fill.anew || ((lights_surfaces || lit_surfaces) && !same_field);
    fill.world =
        has_media && (fill.anew || (!light_.coefficients && (fill.of_media || !field.filled)));
    if (fill.anew || fill.world)
        ++fills_.world;
    const bool has_surfaces =
        fill.anew ? !fill.scene.surfaces.empty() && !part_ && (fill.shines || lights_surfaces)
                  : static_cast<bool>(light_.on_surfaces);
    const bool has_dimmed =
        fill.anew ? has_surfaces && plan.world.dims : static_cast<bool>(light_.on_surfaces_dimmed);
    // A fire that has moved with its scene is looked up where it was while that is being filled.
    const bool keeps_fire =
        light_.fire && field.on_surfaces && field.glows && is_same_fire(light_.plan, plan) &&
        (!fill.is_spread || plan.world.on_surfaces.origin == light_.plan.world.on_surfaces.origin);
    std::shared_ptr<FireLight> fire = light_.fire;
    // What is filled over frames has them to follow all orders.
    if (field_from_before_ && !fill.is_spread && fill.of_media && light_.field_coefficients &&
        is_like(light_.plan, plan)) {
        fill.started_from = std::move(light_.field_coefficients);
        fill.start = {OrdersStart::From::arrived, field_at(fill.started_from, light_.plan, plan)};
    }
    const bool goes_on =
        fill.of_media ? fill.start.from == OrdersStart::From::arrived : light_.goes_on;
    if (!fill.is_spread) {  // in the place of what was there
        WorldPlan own = std::move(fill.to.plan);
        fill.to = fill.anew ? WorldLight() : std::move(light_);
        fill.to.plan = std::move(own);
        light_ = {};
    }
    WorldLight& to = fill.to;
    to.goes_on = goes_on;
    if (fill.on_surfaces)
        to.fire = keeps_fire ? std::move(fire) : nullptr;
    if (to.fire)
        to.fire->move_to(bounds_of(plan.on_surfaces).min);
    if (fill.world && !to.coefficients)
        to.coefficients = make_coefficients("world's light", plan);
    if (fill.world && !fill.anew)  // of which only the sum with the field was kept
        keeps_world_ = true;
    if (!field.filled)
        to.field_coefficients = {};
    if (!field.filled || !plan.amid)
        to.of_media = {};
    else if (fill.of_media && !to.of_media)
        to.of_media = make_coefficients("light of the media", plan);
    if (fill.of_media && !to.field_coefficients)
        to.field_coefficients = make_coefficients("light that is not direct", plan);
    if (fill.on_surfaces) {
        const auto make = [&](gl::Texture& texture, const char* label) {
            if (!texture)
                texture = make_volume(device_, label, plan.on_surfaces,
                                      kSurfaceBands * kSurfaceBands, GL_RGBA16F);
        };
        if (has_surfaces)
            make(to.on_surfaces, "world's light on surfaces");
        if (has_dimmed)
            make(to.on_surfaces_dimmed, "world's light on surfaces, dimmed");
        to.bounced = {};
        if (field.turns > 0 && !part_)
            make(to.bounced, "light of surfaces");
    }
    if (field.turns == 0 || part_)
        to.bounced = {};
    fill.of_world = to.coefficients ? &to.coefficients : &light_.coefficients;
    const bool lights_up = field.turns > 0 && field.on_surfaces && has_dimmed;
    // The media's light is sent back if they are filled now, and what they emit in any case.
    const bool fills_twice = fill.of_media && field.orders.count > 0;
    fill.turns = plan_turns(field.turns, !lights_up ? 0 : fills_twice ? 2 : field.glows ? 1 : 0);
}

Steps LightVolumes::fill_all(WorldFill& fill)
{
    WorldLight& to = fill.to;
    const int turns = to.plan.field.turns;
    if (turns > 0 && !part_ && fill.on_surfaces) {
        co_await begin_surfaces(fill, nullptr);
        co_await turn_surfaces(fill, fill.turns.first, true);
        to.turns_after_noted = turns - fill.turns.first;
    }
    if (fill.world || fill.of_media)
        co_await fill_media(fill);
    if (fill.on_surfaces && to.on_surfaces)
        co_await fill_surfaces(fill);
    if (field_.is_open()) {
        to.world_walls = turns > 0 && !part_ && field_.has_walls(fill.scene.surfaces)
                             ? field_.take_walls()
                             : gl::Texture();
        field_.end();
    }
}

void LightVolumes::show(WorldFill& fill)
{
    WorldLight& to = fill.to;
    const FieldKey& field = to.plan.field;
    const bool dropped = light_.field_coefficients && !field.filled;
    if (fill.is_spread && !fill.anew) {  // what was not filled stays
        if (!to.coefficients)
            to.coefficients = std::move(light_.coefficients);
        if (!fill.of_media && field.filled) {
            to.field_coefficients = std::move(light_.field_coefficients);
            to.of_media = std::move(light_.of_media);
        }
        if (!fill.of_media && !fill.world)
            to.world_walls = std::move(light_.world_walls);
        if (!fill.on_surfaces) {
            to.on_surfaces = std::move(light_.on_surfaces);
            to.on_surfaces_dimmed = std::move(light_.on_surfaces_dimmed);
            to.bounced = std::move(light_.bounced);
            to.bounced_means = std::move(light_.bounced_means);
            to.turns_after_noted = light_.turns_after_noted;
            to.walls = std::move(light_.walls);
            to.sights = std::move(light_.sights);
            to.fire = std::move(light_.fire);
        }
    }
    if (fill.of_media)
        ++fields_shown_;
    begin_fades(fill);
    light_ = std::move(to);
    if (light_.fire)
        light_.fire->move_to(bounds_of(light_.plan.on_surfaces).min);
    if (fill.anew || fill.of_media || fill.world || dropped)
        turned_ = false;
    if (fill.anew || fill.of_media || fill.world)
        copied_walls_ = false;
    if (light_.field_coefficients && !keeps_world_)
        light_.coefficients = {};
    if (light_.in_media())
        make_view(fill.scene.media.traits());
    else
        world_ = {};
}

void LightVolumes::begin_fades(const WorldFill& fill)
{
    const auto begin = [&](LightFade& fade, gl::Texture& before, const Lattice& lattice) {
        if (fill.is_spread && before)
            fade.begin(std::move(before), lattice, fill.frames);
        else
            fade.end();
    };
    const WorldPlan& plan = light_.plan;
    if (plan.bands != fill.to.plan.bands)
        fade_in_media_.end();
    else if (fill.anew || fill.world || fill.of_media)
        begin(fade_in_media_,
              light_.field_coefficients ? light_.field_coefficients : light_.coefficients,
              plan.in_media);
    if (fill.on_surfaces) {
        begin(fade_on_surfaces_, light_.on_surfaces, plan.on_surfaces);
        begin(fade_dimmed_, light_.on_surfaces_dimmed, plan.on_surfaces);
    }
}

bool LightVolumes::go_on_fading()
{
    const bool in_media = fade_in_media_.is_on();
    const bool on_surfaces = fade_on_surfaces_.is_on() || fade_dimmed_.is_on();
    for (LightFade* fade : {&fade_in_media_, &fade_on_surfaces_, &fade_dimmed_})
        if (fade->is_on())
            fade->go_on();
    turned_ &= !in_media;
    return in_media || on_surfaces;
}

Steps LightVolumes::begin_surfaces(WorldFill& fill, const FieldLight* light)
{
    const WorldLight& to = fill.to;
    const WorldKey& key = to.plan.world;
    const FieldKey& field = to.plan.field;
    begin_fill(centre_of(to.plan.on_surfaces), fill);
    begin_field(field_on_surfaces_, to.plan.on_surfaces, fill,
                {.scatters = field.on_surfaces,
                 .world = fill.shines,
                 .bounces = field.turns > 0,
                 .ways = light == nullptr && field.glows ? kAllWays : key.ways_on_surfaces,
                 .sky_box = with_details(fill.scene.media.bounds(), fill.scene.surfaces)});
    if (co_await Pause{})
        field_on_surfaces_.bind_again();
    co_await field_on_surfaces_.fill_world(key.ways_on_surfaces, kSurfaceBands, &to.on_surfaces,
                                           to.on_surfaces_dimmed ? &to.on_surfaces_dimmed : nullptr,
                                           light);
    field_on_surfaces_.find_sights(to.on_surfaces);
    if (co_await Pause{})
        field_on_surfaces_.bind_again();
    if (fill.to.fire || !field.glows || !field.on_surfaces)
        co_return;
    fill_fire(fill);
    if (co_await Pause{})
        field_on_surfaces_.bind_again();
}

void LightVolumes::fill_fire(WorldFill& fill)
{
    WorldLight& to = fill.to;
    medium::MediaSet& media = fill.scene.media;
    const medium::MediaSet::CarriedGlow& glow = media.carried_glow();
    if (glow.bounds.empty())
        return;
    const Lattice& lattice = to.plan.on_surfaces;
    const glm::dmat3 voxels(frame_of(media).voxel_from_world);
    ++fills_.fires;
    to.fire = std::make_shared<FireLight>(device_, programs_);
    to.fire->place(glow, media.bounds(), bounds_of(lattice),
                   1 / std::cbrt(std::abs(glm::determinant(voxels))), media.extinction_color());
    tools_.params.samples = to.fire->samples();
    write_block(centre_of(lattice), to);
    to.fire->fill(extinction_.fill_defines(media, write_lights({})), fill.scene.surfaces);
    field_on_surfaces_.see_fire(to.on_surfaces, to.fire->make_seen(lattice.count));
}

OtherLight LightVolumes::light_of_surfaces(const WorldFill& fill) const
{
    const WorldLight& from = part_ ? whole_->light_ : fill.on_surfaces ? fill.to : light_;
    const RadianceField& field = field_on_surfaces_;
    return {&from.bounced, field.is_open() ? &field.walls() : &from.walls,
            to_shared(from.plan.on_surfaces, kSurfaceBands * kSurfaceBands,
                      centre_of(fill.to.plan.in_media)),
            kSurfaceBands};
}

std::optional<OtherLight> LightVolumes::light_from_beyond(const WorldFill& fill) const
{
    if (!part_ || !part_->is_amid || !whole_->light_.of_media)
        return {};
    // Near what is marched the wider lattice's nodes have that within their cells: what comes to it
    // is taken where they have none of it.
    const WorldPlan& from = whole_->light_.plan;
    const Lattice& own = fill.to.plan.in_media;
    const LatticePlace place = place_of(own);
    glm::dmat3 axes(1.0);
    glm::dvec3 farther(1);
    for (int i = 0; i < 3; ++i) {
        const double edge = glm::length(place.edges[i]);
        axes[i] = place.edges[i] / edge;
        farther[i] += FIELD_FARTHER * spacing_of(place_of(from.in_media)) /
                      (0.5 * edge * static_cast<double>(place.count[i] - 1));
    }
    OtherLight light{&whole_->light_.of_media, nullptr,
                     to_shared(from.in_media, from.bands * from.bands, centre_of(own)), from.bands};
    const glm::dmat3 out =
        axes * glm::dmat3(glm::scale(glm::dmat4(1.0), farther)) * glm::inverse(axes);
    light.at.node_from_world *= glm::mat4(glm::dmat4(out));
    return light;
}

Steps LightVolumes::fill_lattice(WorldFill& fill, int ways, FieldOrders orders,
                                 const gl::Texture* world, const gl::Texture& to,
                                 gl::Texture* scattered, const gl::Texture* of_media)
{
    const OtherLight bounced = light_of_surfaces(fill);
    const std::optional<OtherLight> beyond = light_from_beyond(fill);
    co_await field_.fill(ways, fill.to.plan.bands, orders,
                         {.world = world,
                          .bounced = fill.to.plan.field.turns > 0 ? &bounced : nullptr,
                          .beyond = beyond ? &*beyond : nullptr,
                          .start = fill.start},
                         {.field = to, .scattered = scattered, .of_media = of_media});
}

Steps LightVolumes::guess_coarsely(WorldFill& fill)
{
    const WorldPlan& plan = fill.to.plan;
    const glm::ivec3 count = plan.in_media.count;
    const int most = std::max({count.x, count.y, count.z}), layers = plan.bands * plan.bands;
    for (int nodes = kCoarsestNodes; 3 * nodes / 2 < most; nodes *= 2) {
        const Lattice coarse = coarser(plan.in_media, nodes);
        const int cycles = nodes == kCoarsestNodes ? kMostCycles : kFewerCycles;
        const gl::Texture light =
            make_volume(device_, "light that is not direct, coarsely", coarse, layers, GL_RGBA16F);
        begin_fill(centre_of(plan.in_media), fill);
        begin_field(field_, coarse, fill,
                    {.scatters = true,
                     .world = fill.shines,
                     .ways = kNearWays,
                     .orders = plan.field.orders});
        gl::Texture finer;
        co_await fill_lattice(fill, kNearWays, {FIELD_KEPT_ORDERS, cycles, true}, nullptr, light,
                              &finer, nullptr);
        field_.end();
        fill.started_from = std::move(finer);
        fill.start = {OrdersStart::From::scattered,
                      {&fill.started_from, nullptr,
                       to_shared(coarse, layers, centre_of(plan.in_media)), plan.bands}};
    }
}

Steps LightVolumes::fill_media(WorldFill& fill)
{
    const FieldScene& scene = fill.scene;
    const WorldPlan& plan = fill.to.plan;
    const medium::MediaTraits& traits = scene.media.traits();
    if (fill.of_media && traits.marched > 0 && plan.world.dims && !depths_of_all() && !extinction_)
        extinction_.fill(frame_of(scene.media), scene.media, scene.lights);
    if (fill.of_media && plan.field.orders.coarse_first)
        co_await guess_coarsely(fill);
    begin_fill(centre_of(plan.in_media), fill);
    begin_field(field_, plan.in_media, fill,
                {.scatters = fill.of_media,
                 .world = fill.shines,
                 .ways = plan.world.ways,
                 .orders = plan.field.orders,
                 .sky_box = bounds_of(plan.in_media)});
    if (co_await Pause{})
        field_.bind_again();
    if (fill.world && fill.shines)
        co_await field_.fill_world(plan.world.ways, plan.bands, nullptr, &fill.to.coefficients);
    if (!fill.of_media)
        co_return;
    co_await fill_field(fill);
    ++fills_.field;
}

Steps LightVolumes::fill_field(WorldFill& fill)
{
    const WorldPlan& plan = fill.to.plan;
    begin_fill(centre_of(plan.in_media), fill);
    fill.scattered = {};
    const FieldOrders orders = orders_to_go(plan.field.orders, fill.start.from);
    co_await fill_lattice(fill, fill.shines ? plan.world.ways : kNearWays, orders,
                          fill.shines ? fill.of_world : nullptr, fill.to.field_coefficients,
                          plan.field.on_surfaces ? &fill.scattered : nullptr,
                          fill.to.of_media ? &fill.to.of_media : nullptr);
    fill.started_from = {};
    if (fill.scattered)
        field_.make_whole(plan.bands, fill.scattered);
}

Steps LightVolumes::fill_surfaces(WorldFill& fill)
{
    WorldLight& to = fill.to;
    const WorldPlan& plan = to.plan;
    const FieldKey& field = plan.field;
    const glm::dvec3 eye = centre_of(plan.on_surfaces);
    const gl::Texture* dimmed = to.on_surfaces_dimmed ? &to.on_surfaces_dimmed : nullptr;
    const auto light = [&] {
        FieldLight of_media;
        // Smoke is bright where a fire is in it: along few ways it would throw a star.
        // What surfaces send on is gathered along many in the end.
        of_media.along_rays = plan.along_rays();
        of_media.ways = field.turns > 0 && field.glows ? kAllWays : kNearWays;
        of_media.at = to_shared(plan.in_media, plan.bands * plan.bands, eye);
        of_media.bands = plan.bands;
        if (fill.scattered)
            of_media.scattered = &fill.scattered;
        return of_media;
    };
    if (field.turns == 0) {
        const FieldLight of_media = light();
        co_await begin_surfaces(fill, field.on_surfaces ? &of_media : nullptr);
    } else {
        begin_fill(eye, fill);
        const std::vector<int>& rounds = fill.turns.taken_back;
        for (std::size_t i = 0; i < rounds.size(); ++i) {
            if (i > 0) {  // what surfaces send back of the media's own light
                if (field.orders.cycles > 0)
                    fill.start = {OrdersStart::From::arrived_here,
                                  field_at(to.field_coefficients, plan, plan)};
                co_await fill_field(fill);
                begin_fill(eye, fill);
            }
            const FieldLight of_media = light();
            co_await field_on_surfaces_.add_light(kSurfaceBands, of_media, to.on_surfaces_dimmed,
                                                  rounds[i]);
            co_await turn_surfaces(fill, fill.turns.again, false);
        }
        const FieldLight of_media = light();
        co_await field_on_surfaces_.smooth(
            plan.world.ways_on_surfaces, kSurfaceBands,
            field.on_surfaces && dimmed != nullptr ? &of_media : nullptr, to.on_surfaces, dimmed);
    }
    to.walls = field.turns > 0 ? field_on_surfaces_.take_walls() : gl::Texture();
    to.sights = field_on_surfaces_.take_sights();
    field_on_surfaces_.end();
}

void LightVolumes::make_view(const medium::MediaTraits& traits)
{
    const WorldPlan& plan = light_.plan;
    const glm::dvec3 origin = plan.world.in_media.origin;
    // Another g takes the same light another way.
    const int layers_of_light = traits.mixed_g ? plan.bands : 1;
    const int layers = layers_of_light + (light_.world_walls ? kWallLayers : 0);
    if (!world_ || world_.size() != plan.in_media.count * glm::ivec3(1, 1, layers)) {
        world_ = make_volume(device_, "world's light towards the eye", plan.in_media, layers,
                             GL_RGBA16F);
        turned_ = false;
        copied_walls_ = false;
    }
    if (light_.world_walls && !copied_walls_)
        for (int layer = 0; layer < kWallLayers; ++layer)
            copy_layer(device_, light_.world_walls, layer, world_, layers_of_light + layer,
                       plan.in_media.count);
    copied_walls_ = true;
    turned_ &= (traits.mixed_g || turned_g_ == traits.g) && turned_at_ == origin;
    turned_g_ = traits.g;
    turned_at_ = origin;
}

Steps LightVolumes::turn_surfaces(WorldFill& fill, int turns, bool noted)
{
    WorldLight& to = fill.to;
    const LightSet& lights = fill.scene.lights;
    const glm::ivec3 count = to.plan.on_surfaces.count;
    if (noted)
        to.bounced_means.clear();
    gl::Defines shading{{"kWorldIrradiance", ""}};
    if (to.fire)
        shading.emplace_back("kFireOnSurfaces", "");
    if (lights.has_environment())
        shading.emplace_back("kEnvironment", "");
    const bool has_dimmed = static_cast<bool>(to.on_surfaces_dimmed);
    const gl::Texture& dimmed = has_dimmed ? to.on_surfaces_dimmed : to.on_surfaces;
    for (int i = 0; i < turns; ++i) {
        depths_.bind();
        dimmed.bind(WORLD_ON_SURFACES_UNIT);
        if (to.fire)
            to.fire->bind();
        field_on_surfaces_.sights().bind(WALLS_UNIT);
        if (lights.has_environment())
            lights.bind_irradiance();
        field_on_surfaces_.light_surfaces(shading, fill.scene.surfaces);
        if (co_await Pause{})
            field_on_surfaces_.bind_again();
        // The next turn is lit by what is dimmed alone.
        const bool last = i + 1 == turns, is_noted = noted && i + kNotedTurns >= turns;
        co_await field_on_surfaces_.bounce(to.plan.world.ways_on_surfaces, kSurfaceBands,
                                           last || is_noted ? &to.bounced : nullptr,
                                           last || !has_dimmed ? &to.on_surfaces : nullptr,
                                           has_dimmed ? &to.on_surfaces_dimmed : nullptr);
        if (!is_noted)
            continue;
        gl::Texture& mean = to.bounced_means.emplace_back(gl::Texture::make_3d(
            device_, "mean light of surfaces", count, GL_RGBA16F, gl::Filter::nearest));
        device_->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        device_->CopyImageSubData(to.bounced.id(), GL_TEXTURE_3D, 0, 0, 0, 0, mean.id(),
                                  GL_TEXTURE_3D, 0, 0, 0, 0, count.x, count.y, count.z);
    }
}

void LightVolumes::begin_fill(glm::dvec3 eye, const WorldFill& fill)
{
    fill.scene.media.bind(eye, true);
    fill.scene.lights.bind(eye);
    write_block(eye, fill.to);
}

void LightVolumes::write_block(glm::dvec3 eye, const WorldLight& surfaces)
{
    if (extinction_)
        extinction_.write_params(eye);
    if (depths_of_all())
        depths_of_all().write_params(tools_.params, eye);
    if (world_ && light_.in_media())
        tools_.params.world =
            to_shared(light_.plan.in_media, world_.size().z / light_.plan.in_media.count.z, eye);
    if (amid_) {
        const Lattice& lattice = amid_->light_.plan.in_media;
        const glm::ivec2 flames = amid_->part_->has_flames ? flames_ : glm::ivec2(0);
        tools_.params.amid = to_shared(lattice, amid_->world_.size().z / lattice.count.z, eye);
        const Bounds& rim = amid_->part_->rim;
        tools_.params.amid_per_low_rim = 1.0F / glm::max(glm::vec3(rim.min), kLeastRim);
        tools_.params.amid_per_high_rim = 1.0F / glm::max(glm::vec3(rim.max), kLeastRim);
        tools_.params.first_flame = flames.x;
        tools_.params.beyond_flame = flames.y;
    }
    if (surfaces.on_surfaces) {
        const Bounds& media = surfaces.plan.media;
        const glm::dvec3 edges = media.max - media.min;
        tools_.params.surfaces =
            to_shared(surfaces.plan.on_surfaces, kSurfaceBands * kSurfaceBands, eye);
        tools_.params.media_middle = glm::vec3(0.5 * (media.min + media.max) - eye);
        tools_.params.media_radius =
            static_cast<float>(0.5 * std::cbrt(edges.x * edges.y * edges.z));
    }
    if (surfaces.fire)
        tools_.params.fire = surfaces.fire->params(eye);
    tools_.bind_block();
}

gl::Defines LightVolumes::field_defines(const FieldScene& scene) const
{
    gl::Defines defines = extinction_.fill_defines(scene.media, scene.lights.defines());
    defines += depths_of_all().defines();
    return defines;
}

void LightVolumes::begin_field(RadianceField& field, const Lattice& lattice, const WorldFill& fill,
                               const FieldTask& task)
{
    const medium::MediaSet& media = fill.scene.media;
    const WorldKey& key = fill.to.plan.world;
    const medium::MediaTraits& traits = media.traits();
    const glm::dvec3 eye = centre_of(lattice);
    // Half a cell's voxels: samples are filtered over two of them.
    const glm::dmat4 voxel_from_node =
        frame_of(media).voxel_from_world * glm::inverse(lattice.node_from_world);
    const double voxels = glm::length(glm::dvec3(voxel_from_node[0]));
    const bool in_voxels = traits.media == traits.marched;
    const int most =
        &field == &field_on_surfaces_ && in_voxels ? kMostSamplesOnSurfaces : kMostSamples;
    tools_.params.samples = std::clamp(static_cast<int>(std::round(voxels / 2)), 2, most);
    write_block(eye, fill.to);
    depths_of_all().bind();
    const bool marches = task.scatters && key.dims && extinction_ && !depths_of_all();
    field.begin(
        {to_shared(lattice, 1, eye), eye,
         lattice.node_from_world * glm::translate(glm::dmat4(1.0), eye), lattice.count},
        {.defines = field_defines(fill.scene),
         .colored = traits.colored_extinction,
         .ways = task.ways,
         .albedo = media.mean_albedo(),
         .mixed_g = traits.mixed_g,
         .scatters = task.scatters,
         .glows = task.scatters && &field == &field_ && media.carries_glow(),
         .dims = key.dims,
         .marched = traits.marched > 0,
         .closed = traits.media > traits.marched,
         .amid = part_ && part_->is_amid,
         .scatters_again = task.scatters && task.orders.count > 0,
         .straight_on = task.scatters ? task.orders.straight_on : 0,
         .sights = &field == &field_on_surfaces_,
         .rim = &field == &field_on_surfaces_ && key.lit_beyond,
         .thick = task.orders.coarse_first,
         .left_out = part_ && part_->has_flames ? flames_ : glm::ivec2(0),
         .hole = &field == &field_ && fill.to.plan.amid ? fill.to.plan.amid->bounds : Bounds(),
         .bounds = media.bounds(),
         .ends = media.ends(),
         .world = task.world ? &key.world : nullptr,
         .extinction = marches ? &extinction_.volume() : nullptr,
         .sky_box = key.sky_in_parts ? task.sky_box : Bounds(),
         .bind_again =
             [this, eye, &fill] {
                 begin_fill(eye, fill);
                 depths_of_all().bind();
             }},
        fill.scene.surfaces, task.bounces);
}

gl::Defines LightVolumes::view_defines(const medium::MediaSet& media, int bands) const
{
    gl::Defines defines = extinction_.fill_defines(media, write_lights({}));
    defines.emplace_back("kBands", fmt::format("{}", bands));
    return defines;
}

void LightVolumes::prepare_fades(const WorldFill& fill)
{
    LightFade::prepare(programs_);
    gl::Defines view = view_defines(fill.scene.media, fill.to.plan.bands);
    if (fill.to.plan.world.bands == 0)
        return;
    for (const char* variant : {"kFades", "kStays"}) {
        view.emplace_back(variant, "");
        programs_.get({"light/world_view.comp"}, view);
    }
}

void LightVolumes::project_to_view(const medium::MediaSet& media)
{
    gl::Defines defines = view_defines(media, light_.plan.bands);
    light_.in_media().bind(WORLD_COEFFICIENTS_UNIT);
    if (amid_)
        defines.emplace_back("kAmidVolume", "");
    if (fade_in_media_.is_on()) {
        defines.emplace_back("kFades", "");
        defines += fade_in_media_.bind({light_.in_media(), light_.plan.in_media});
    }
    tools_.dispatch("light/world_view.comp", defines, world_, GL_RGBA16F, VOLUME_GROUP,
                    light_.plan.in_media.count);
}

void LightVolumes::bind(glm::dvec3 eye, glm::dvec3 forward, bool perspective,
                        const medium::MediaSet& media)
{
    if (!depths_ && !has_world())
        return;
    if (amid_) {
        const int turns = amid_->turns_to_eye_;
        amid_->bind(eye, forward, perspective, media);
        turned_ &= turns == amid_->turns_to_eye_;  // of its nodes' light ours is without
    }
    tools_.params.view_axis = perspective ? glm::vec3(0) : glm::vec3(forward);
    tools_.params.orthographic = perspective ? 0.0f : 1.0f;
    write_block(eye);
    const glm::dvec4 view = perspective ? glm::dvec4(eye, 0) : glm::dvec4(forward, 1);
    if (world_ && (!turned_ || (light_.plan.bands > 1 && view != turned_to_))) {
        project_to_view(media);
        turned_ = true;
        turned_to_ = view;
        ++turns_to_eye_;
    }
    depths_.pack(eye);
    depths_.bind();
    world_.bind(WORLD_VOLUME_UNIT);
    if (amid_)
        amid_->world_.bind(AMID_VOLUME_UNIT);
    if (!island_light_)
        return;
    for (const auto& island : islands_)
        island->bind(eye, forward, perspective, media);
    write_block(eye);
    island_light_.bind(parts_with_light(), eye);
}

void LightVolumes::bind_for_surfaces(glm::dvec3 eye, bool through_media)
{
    if (!light_.on_surfaces)
        return;
    write_block(eye);
    const bool dimmed = through_media && light_.on_surfaces_dimmed;
    const Lattice& lattice = light_.plan.on_surfaces;
    const gl::Texture& light = dimmed ? fade_dimmed_.mixed({light_.on_surfaces_dimmed, lattice})
                                      : fade_on_surfaces_.mixed({light_.on_surfaces, lattice});
    light.bind(WORLD_ON_SURFACES_UNIT);
    light_.sights.bind(WALLS_UNIT);
    if (light_.fire)
        light_.fire->bind();
    if (light_.fire && !dimmed) {
        tools_.params.fire.is_seen = 0;
        tools_.bind_block();
    }
}

gl::Defines LightVolumes::surface_defines() const
{
    gl::Defines defines;
    if (light_.on_surfaces)
        defines.emplace_back("kWorldIrradiance", "");
    if (light_.on_surfaces && light_.plan.one_box)
        defines.emplace_back("kOneBox", "");
    if (light_.on_surfaces && light_.plan.world.lit_beyond)
        defines.emplace_back("kLitBeyond", "");
    if (light_.on_surfaces && light_.fire)
        defines.emplace_back("kFireOnSurfaces", "");
    return defines;
}

gl::Defines LightVolumes::beyond_defines() const
{
    if (!light_.on_surfaces || !light_.plan.world.lit_beyond)
        return {};
    return {{"kWorldIrradiance", ""}, {"kLitBeyond", ""}, {"kAllBeyond", ""}};
}

gl::Defines LightVolumes::defines() const
{
    gl::Defines defines = depths_.defines();
    if (has_world())
        defines.emplace_back("kWorldVolume", "");
    if (island_light_)
        defines.emplace_back("ISLAND_VOLUMES", "");
    if (world_ && light_.world_walls)
        defines.emplace_back("kWorldWalls", "");
    if (amid_)
        defines.emplace_back("kAmidVolume", "");
    if (amid_ && amid_->part_->has_flames)
        defines.emplace_back("kAmidFlames", "");
    return defines;
}

std::optional<Bounds> LightVolumes::lit_on_surfaces() const
{
    if (!light_.on_surfaces || light_.fire)
        return {};
    return bounds_of(light_.plan.on_surfaces);
}

bool LightVolumes::splits_forward_peaks() const
{
    return (light_.field_coefficients && light_.plan.field.orders.straight_on > 0) ||
           (amid_ && amid_->splits_forward_peaks()) ||
           std::any_of(islands_.begin(), islands_.end(),
                       [](const auto& island) { return island->splits_forward_peaks(); });
}

LightVolumeFills LightVolumes::fills() const
{
    LightVolumeFills sum = fills_;
    sum.extinction = extinction_.fills();
    sum.depth_layers = depths_.layers_filled();
    sum.lattices = field_.drawings() + field_on_surfaces_.drawings();
    const auto add = [&](const LightVolumes& part) {
        const LightVolumeFills own = part.fills();
        sum.extinction += own.extinction;
        sum.depth_layers += own.depth_layers;
        sum.world += own.world;
        sum.field += own.field;
        sum.lattices += own.lattices;
        sum.fires += own.fires;
    };
    for (const auto& island : islands_)
        add(*island);
    if (amid_)
        add(*amid_);
    return sum;
}

std::vector<std::string> LightVolumes::describe() const
{
    std::vector<std::string> lines;
    if (island_light_) {
        double ms = 0;
        for (const auto& island : islands_)
            ms += island->light_.ms.value_or(0);
        lines.push_back(fmt::format(
            "world's light and what scatters again in {} parts that lie far apart: {}{}",
            islands_.size(), size_of(island_light_.light(), 1, 8),
            filled_in(ms > 0 ? std::optional(ms) : std::nullopt)));
    }
    if (depths_)
        lines.push_back(depths_.describe());
    for (std::string& line : light_.describe({sky_.last().why, turns_.last().why, orders_why_}))
        lines.push_back(std::move(line));
    if (amid_)
        lines.push_back(fmt::format("world's light in what lies amid wider media: {}{}",
                                    size_of(amid_->light_.in_media(),
                                            amid_->light_.plan.bands * amid_->light_.plan.bands, 8),
                                    filled_in(amid_->light_.ms)));
    if (light_.field_coefficients && !fill_)
        lines.push_back(
            describe_orders(field_, light_.goes_on || light_.plan.field.orders.coarse_first));
    return lines;
}

}  // namespace fumarole::light
