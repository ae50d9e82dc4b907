#pragma once

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/stopwatch.h"
#include "gl/texture.h"
#include "light/light_set.h"
#include "light/probe_filter.h"
#include "light/probe_place.h"
#include "shared/probe_params.h"
#include <fumarole/probe_state.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>

namespace fumarole::light {

/// The cameras of a probe's six pictures, in the order of glsl/lib/cube_faces.glsl: they look along
/// +x, -x, +y, ..., a right angle wide and high. Depth is reversed, infinite, 0 to 1.
glm::dmat4 probe_view_from_world(glm::dvec3 position, int face);
glm::dmat4 probe_clip_from_view(double near);

/// What surfaces have of light from all around: the world's map, filtered by roughness, where some
/// of them are glossy, and what placed probes have seen. Who draws for them calls next(), draws six
/// faces, and gives them back.
class Probes {
public:
    Probes(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}, filter_{device, programs}, block_{device, "probes"}
    {
    }

    /// Filters the world's map if the scene needs it and it is another one, and says which probes
    /// are out of date. Changes GL state: call it under a StateGuard.
    /// @throws Error if the scene has more probes than the block holds
    void set(const Scene& scene, const SceneSettings& settings, const LightSet& lights,
             const medium::MediaSet& media);

    /// Leaves no probe: what is right after set() has thrown.
    void clear();

    /// Binds what surfaces read, for an eye at `eye` (metres, world).
    void bind(glm::dvec3 eye);
    /// The lines that glsl/pass/surface.frag needs.
    [[nodiscard]] gl::Defines defines() const;

    [[nodiscard]] bool has_world() const { return static_cast<bool>(world_); }
    [[nodiscard]] int count() const { return static_cast<int>(placed_.size()); }
    /// Those that have been captured, be it from a scene that was.
    [[nodiscard]] int ready() const;

    /// A probe to be captured, the most urgent one first: one that was never, then those that
    /// another scene was seen from, then all once more, now that surfaces have light from them.
    /// @param anew not only those that never were
    [[nodiscard]] std::optional<int> next(bool anew) const;
    [[nodiscard]] const LightProbe& at(int i) const { return placed_[std::size_t(i)].probe; }
    /// Of its maps, as it was captured last; -1 if it never was.
    [[nodiscard]] int layer_of(int i) const { return placed_[std::size_t(i)].layer; }
    /// A flag for each instance of the scene's surfaces that it had better not see.
    [[nodiscard]] const std::vector<bool>& unseen(int i) const
    {
        return placed_[std::size_t(i)].unseen;
    }

    /// Of one face that was drawn, what it shows.
    void take_face(int face, const gl::Texture& color);
    /// Filters the faces of a probe.
    /// @param ms that capturing took, if that is known
    void finish(int i, const gl::Stopwatch& watch);
    /// Brings a frame's share of what is new of captured probes to be seen, or all of it at once.
    void fade(bool at_once);

    /// What the faces that are drawn show of probes: a first turn after the scene has changed shows
    /// none, since what they saw before is not there any more; a second one all, as if what was
    /// captured first had faded in whole; or all as they were before the last turn.
    enum class Shown { first_turn, later_turn, before_last_turn };
    /// A probe that may see what has changed since it was captured, and, if none is out of date,
    /// one that was not looked from since it was captured.
    [[nodiscard]] std::optional<int> doubted() const;
    [[nodiscard]] std::optional<int> unglimpsed() const;
    /// What small faces of it show, as all probes have faded in: one that is doubted is out of date
    /// if they show anything else than at its last glimpse, or if there was none.
    void take_glimpse(int i, std::vector<float> rgb);
    /// All that are doubted are out of date: there is no time to look from each.
    void believe_none();

    void begin_capture(Shown shown) { capturing_ = shown; }
    void end_capture() { capturing_.reset(); }
    [[nodiscard]] Shown shown_to(int i) const
    {
        return placed_[std::size_t(i)].turns == 0 ? Shown::first_turn : Shown::later_turn;
    }
    /// Whether both of the last two turns of all are there.
    [[nodiscard]] bool have_two_turns() const;

    /// Has defines() name what captured probes need, before there are any: for prepare().
    void set_preparing(bool preparing) { preparing_ = preparing; }
    /// Likewise filters something once, and makes what a capture of the scene's probes needs.
    void prepare();

    [[nodiscard]] std::vector<ProbeState> states() const;
    /// Why probes were placed by themselves or were not; empty: the scene has no surfaces, or names
    /// its own.
    [[nodiscard]] std::string placement() const { return own_place_ ? own_place_->why : ""; }

    /// Captures so far.
    [[nodiscard]] int captures() const { return captures_; }
    [[nodiscard]] std::vector<std::string> describe() const;

private:
    static constexpr int kTurns = 2;  ///< number of turns of all captures after a change
    /// Homogeneous media that a place is in, the mean of the channels.
    struct EvenFog {
        double extinction = 0;  ///< 1/m
        double scattering = 0;  ///< 1/m
    };
    static EvenFog even_fog_at(const std::vector<Medium>& media, glm::dvec3 p);
    struct Placed {
        LightProbe probe;
        int layer = -1, old_layer = -1;
        glm::dvec3 seen_from{0}, old_seen_from{0};  ///< where it was then
        EvenFog fog;                                ///< fog that the probe stood in last
        float newness = 1;                          ///< newness of layer over old_layer
        int turns = 0;                              ///< captures since the scene changed
        int captures = 0;                           ///< number of captures in all
        bool doubted = false;        ///< the scene, or another probe, has changed since
        bool found_same = false;     ///< true if it was found the same when that was looked at
        std::vector<float> glimpse;  ///< what it saw when nothing was out of date; may be empty
        bool two_turns = false;      ///< old_layer is what was captured one turn before
        std::chrono::steady_clock::time_point captured_at;
        std::optional<double> capture_ms;
        std::vector<bool> unseen;
    };
    void set_world(const Scene& scene, const LightSet& lights);
    void set_placed(const Scene& scene, const SceneSettings& settings,
                    const medium::MediaSet& media);
    /// The scene's, or those that are placed by themselves.
    std::vector<LightProbe> wanted(const Scene& scene, const SceneSettings& settings,
                                   const medium::MediaSet& media);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    ProbeFilter filter_;
    gl::UniformBuffer<shared::ProbesParams> block_;
    shared::ProbesParams params_{};
    [[nodiscard]] const gl::Texture& faces(int size);
    void make_room();
    /// The first of two layers that no probe has.
    [[nodiscard]] int free_pair() const;

    gl::Texture world_, maps_;
    std::map<int, gl::Texture> faces_;  ///< textures of faces by the pixels along an edge
    int face_size_ = 0;                 ///< size of faces that was taken last
    std::shared_ptr<const Environment> world_source_;
    float world_scale_ = 0;

    std::vector<Placed> placed_;
    std::optional<ProbeLayout> layout_;
    Scene seen_;  ///< what they see, without the probes
    bool diffuse_ = false;
    std::optional<ProbePlaces>
        own_place_;  ///< places of own probes for seen_'s surfaces, where the scene names none
    std::optional<Shown> capturing_;
    bool preparing_ = false;
    int captures_ = 0;
};

}  // namespace fumarole::light
