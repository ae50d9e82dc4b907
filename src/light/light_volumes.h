#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "light/filled_light.h"
#include "light/island_light.h"
#include "light/last_answer.h"
#include "light/light_depths.h"
#include "light/light_fade.h"
#include "light/light_set.h"
#include "light/marched_extinction.h"
#include "light/radiance_field.h"
#include "light/sky_seen.h"
#include "light/surface_turns.h"
#include "light/volume_tools.h"
#include "light/world_plan.h"
#include "medium/media_set.h"
#include <fumarole/settings.h>

// Light on its way through the media, worked out once for many points and kept while nothing it
// depends on changes.

namespace fumarole::light {

/// What has been filled so far.
struct LightVolumeFills {
    int extinction = 0;    ///< the volume that the others are filled from
    int depth_layers = 0;  ///< optical depth, a layer a light
    int world = 0;         ///< the world's light, in media and on surfaces
    int field = 0;         ///< light that is scattered again or emitted
    int lattices = 0;      ///< that surfaces were drawn into
    int fires = 0;         ///< what media emit, on surfaces
};

/// Volumes in front of what would be marched at each sample:
///
/// the optical depths towards the lights (LightDepths), and
///
/// the world's light that reaches each node, dimmed by all media and hidden by surfaces, as
/// spherical harmonics of bands 0 to 3 at most. Henyey-Greenstein scatters band l times g^l
/// towards the eye, so bands that are cut weigh |g|^4 of the light's own. For surfaces there are
/// two more of the kind, over them and some way around, through the media and without them.
///
/// Their lattices follow the voxels of the largest grid, sheared as those may be (the surfaces':
/// the world's axes). All are filled from a volume of the media's extinction that is freed again.
///
/// Of media whose parts lie far apart one lattice has no node to spare for any of them. Each part
/// then has volumes of the world's light of its own, in which the media's other parts throw shadows
/// of lights but are not seen otherwise. Depths towards lights are marched.
///
/// What is marched amid wider media, as smoke in fog, has volumes of the world's light of its own
/// too (WorldPlan::amid). Depths are those of all media, and what these scatter comes in at its
/// faces.
class LightVolumes {
public:
    LightVolumes(const gl::Device& device, gl::ProgramCache& programs,
                 const gl::PassTimers& timers);
    ~LightVolumes();
    LightVolumes(const LightVolumes&) = delete;
    LightVolumes& operator=(const LightVolumes&) = delete;

    /// Fills what the scene needs and the settings ask for; what is filled and still right stays.
    /// Changes GL state: call it under a StateGuard that knows the media's texture units.
    void set(const Scene& scene, const SceneSettings& settings, medium::MediaSet& media,
             const surface::SurfaceSet& surfaces, LightSet& lights);

    /// Leaves no volume: what is right after set() has thrown.
    void clear();

    /// Binds volumes and block for an eye at `eye` (metres, world) that looks along `forward`, and
    /// turns the world's light to it. The media's block must be bound.
    void bind(glm::dvec3 eye, glm::dvec3 forward, bool perspective, const medium::MediaSet& media);

    /// The lines that glsl/scene/light_volumes.glsl needs.
    [[nodiscard]] gl::Defines defines() const;

    /// What is kept, at what size, and what it took to fill: a line each.
    [[nodiscard]] std::vector<std::string> describe() const;

    /// Fills a part of what a change has left to be filled over several frames: call it once a
    /// frame, as set().
    /// @returns whether what frames look up is another now
    bool go_on(medium::MediaSet& media, const surface::SurfaceSet& surfaces, LightSet& lights);
    [[nodiscard]] bool has_more() const
    {
        return depths_.has_more() || fill_ || fade_in_media_.is_on() || fade_on_surfaces_.is_on() ||
               fade_dimmed_.is_on() || (amid_ && amid_->has_more());
    }

    /// Binds the world's light on surfaces instead of that in the media.
    void bind_for_surfaces(glm::dvec3 eye, bool through_media);
    /// Likewise for glsl/pass/surface.frag.
    [[nodiscard]] gl::Defines surface_defines() const;
    [[nodiscard]] gl::Defines beyond_defines() const;
    /// Of surfaces that lie beyond it beyond_defines() do as well, which ask for less; metres,
    /// world. None: theirs would not, or no light is bound.
    [[nodiscard]] std::optional<Bounds> lit_on_surfaces() const;

    [[nodiscard]] LightVolumeFills fills() const;
    [[nodiscard]] const LightDepths& depths() const { return depths_; }
    [[nodiscard]] bool has_world() const { return world_ || island_light_; }

    /// Whether sky_seen() says so. It is asked once for the same surfaces.
    bool is_sky_in_parts(const Scene& scene, const Bounds& media);

private:
    struct FieldScene {
        medium::MediaSet& media;
        const surface::SurfaceSet& surfaces;
        LightSet& lights;
    };
    struct WorldFill;
    /// Of all media, or of our part.
    [[nodiscard]] medium::VoxelFrame frame_of(const medium::MediaSet& media) const;
    /// Whether the field, or that of a part, is without what is scattered straight on.
    [[nodiscard]] bool splits_forward_peaks() const;
    /// Has media scatter as what frames look up was filled.
    void scatter_as_shown(medium::MediaSet& media) const
    {
        media.split_forward_peaks((part_ ? whole_ : this)->splits_forward_peaks());
    }
    void set_volumes(const Scene& scene, const SceneSettings& settings, medium::MediaSet& media,
                     const surface::SurfaceSet& surfaces, LightSet& lights);
    void set_amid(const Scene& scene, const SceneSettings& settings, medium::MediaSet& media,
                  const surface::SurfaceSet& surfaces, LightSet& lights);
    /// Of wider media's light that comes to our part; 0: none does.
    [[nodiscard]] int fills_around() const
    {
        return part_ && part_->is_amid ? whole_->fields_shown_ : 0;
    }
    /// Depths have come since, or wider media's light: what is filled from them is filled anew.
    void fill_again(const FieldScene& scene);
    /// Of all media.
    [[nodiscard]] const LightDepths& depths_of_all() const
    {
        return part_ ? whole_->depths_ : depths_;
    }
    /// What media beyond our part send into it. Null: nothing.
    [[nodiscard]] std::optional<OtherLight> light_from_beyond(const WorldFill& fill) const;
    void set_islands(const Scene& scene, const SceneSettings& settings, medium::MediaSet& media,
                     const surface::SurfaceSet& surfaces, LightSet& lights);
    /// Of each island, and ours last.
    [[nodiscard]] std::vector<IslandLight::Part> parts_with_light() const;
    /// Fills it by the plan, at once or over frames, or has what is being filled be filled again.
    void set_plan(WorldPlan plan, const FieldScene& scene);
    /// Has what is shown be where the scene has moved to as a whole, if that is all that its
    /// lattices tell of.
    void follow(const WorldPlan& now);
    /// Fills what is not there yet, or begins to.
    void begin_world(WorldPlan plan, const FieldScene& scene, bool spreads);
    void go_on_filling(const FieldScene& scene);
    void stop_filling();
    /// Whether it may be filled over frames, while the scene changes.
    [[nodiscard]] bool may_spread(const medium::MediaSet& media) const;
    /// What is to be filled of it, and room for that.
    void plan_fill(WorldFill& fill);
    Steps fill_all(WorldFill& fill);
    /// Shows what was filled.
    void show(WorldFill& fill);
    /// What is shown fades to what takes its place.
    void begin_fades(const WorldFill& fill);
    /// @returns whether any light fades
    bool go_on_fading();
    /// Takes up the surfaces' lattice, with the world's light and, not null, the media's.
    Steps begin_surfaces(WorldFill& fill, const FieldLight* light);
    /// Works out what surfaces have of what media emit, while their lattice is open.
    void fill_fire(WorldFill& fill);
    /// What surfaces send on, for the media's lattice.
    [[nodiscard]] OtherLight light_of_surfaces(const WorldFill& fill) const;
    Steps fill_lattice(WorldFill& fill, int ways, FieldOrders orders, const gl::Texture* world,
                       const gl::Texture& to, gl::Texture* scattered, const gl::Texture* of_media);
    Steps guess_coarsely(WorldFill& fill);
    /// Fills the media's lattice with the world's light, and with theirs. It is open then.
    Steps fill_media(WorldFill& fill);
    /// Fills it with theirs, of all that reaches them now.
    Steps fill_field(WorldFill& fill);
    /// Lights surfaces by the media, which they light in turn; and for good.
    Steps fill_surfaces(WorldFill& fill);
    /// Makes room for what is turned to the eye.
    void make_view(const medium::MediaTraits& traits);
    void drop_world();
    [[nodiscard]] gl::Texture make_coefficients(const char* label, const WorldPlan& plan) const;
    /// What a lattice is filled for.
    struct FieldTask {
        bool scatters = false;  ///< light that the media scatter or emit is asked for
        bool world = false;     ///< the world's is
        bool bounces = false;   ///< surfaces send light on
        int ways = 0;           ///< kNearWays or kAllWays
        FieldOrders orders = {};
        Bounds sky_box = {};  ///< where it is told how much of the sky each way sees [m]
    };
    [[nodiscard]] gl::Defines field_defines(const FieldScene& scene) const;
    void begin_field(RadianceField& field, const Lattice& lattice, const WorldFill& fill,
                     const FieldTask& task);
    /// @param noted what each of the last turns brought is kept, to tell what a further one would
    Steps turn_surfaces(WorldFill& fill, int turns, bool noted);
    [[nodiscard]] gl::Defines view_defines(const medium::MediaSet& media, int bands) const;
    /// Compiles what fades need.
    void prepare_fades(const WorldFill& fill);
    void project_to_view(const medium::MediaSet& media);
    void begin_fill(glm::dvec3 eye, const WorldFill& fill);
    /// @param surfaces the light of theirs that is looked up
    void write_block(glm::dvec3 eye, const WorldLight& surfaces);
    void write_block(glm::dvec3 eye) { write_block(eye, light_); }

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    const gl::PassTimers& timers_;
    VolumeTools tools_;
    MarchedExtinction extinction_;
    LightDepths depths_;
    RadianceField field_, field_on_surfaces_;
    WorldLight light_;                 ///< as frames look it up
    bool keeps_world_ = false;         ///< WorldLight::coefficients stays
    std::unique_ptr<WorldFill> fill_;  ///< what takes its place once it is filled
    WorldPlan wanted_;                 ///< as the scene has it now, while that is filled
    int field_frames_ = 1;             ///< SceneSettings::field_fill
    bool field_from_before_ = false;   ///< SceneSettings'
    int parts_ = 1;                    ///< number of parts, from pause to pause, of the last fill
    /// From the light before to light_: WorldLight::in_media(), on_surfaces, on_surfaces_dimmed.
    LightFade fade_in_media_, fade_on_surfaces_, fade_dimmed_;
    /// light_ in the media, turned to the eye. Where surfaces send light on its last layers are
    /// walls between the nodes.
    gl::Texture world_;
    bool copied_walls_ = false;  ///< they are by now
    glm::dvec4 turned_to_{0};    ///< eye, or direction and 1, that world_ was worked out for
    bool turned_ = false;
    float turned_g_ = 0;       ///< g that world_ was worked out with
    glm::dvec3 turned_at_{0};  ///< where its first node was then, metres, world
    LastAnswer<SkySeenKey, SkySeen> sky_;
    LastAnswer<SurfaceTurnsKey, SurfaceTurns> turns_;
    std::string orders_why_;  ///< light is followed as often as it is; empty: nothing scatters
    std::optional<MediaPart> part_;        ///< the one that these are of; none: all media
    const LightVolumes* whole_ = nullptr;  ///< those of all media, which have the surfaces' light
    std::vector<std::unique_ptr<LightVolumes>> islands_;
    IslandLight island_light_;
    std::unique_ptr<LightVolumes> amid_;  ///< by WorldPlan::amid; null: there is none
    glm::ivec2 flames_{0};                ///< LightSet's
    int fields_shown_ = 0;                ///< number of times that light of the media came
    int turns_to_eye_ = 0;                ///< number of times that world_ was turned to the eye
    LightVolumeFills fills_;
};

}  // namespace fumarole::light
