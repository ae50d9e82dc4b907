#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/light_set.h"
#include "light/probe_filter.h"
#include "shared/probe_params.h"
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
    void set(const Scene& scene, const SceneSettings& settings, const LightSet& lights);

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

    /// Of one face that was drawn, what it shows; sky where depth is 0.
    void take_face(int face, const gl::Texture& color, const gl::Texture& depth);
    /// Filters the faces of a probe.
    void finish(int i);
    /// Brings a frame's share of what is new of captured probes to be seen, or all of it at once.
    void fade(bool at_once);

    /// Surfaces are drawn as if there were none, while the first capture of each is going on.
    [[nodiscard]] bool are_hidden() const { return ready() < count() && capturing_; }
    void set_capturing(bool capturing) { capturing_ = capturing; }

    /// Captures so far.
    [[nodiscard]] int captures() const { return captures_; }
    [[nodiscard]] std::vector<std::string> describe() const;

private:
    static constexpr int kTurns = 2;  ///< of all captures after a change
    struct Placed {
        LightProbe probe;
        int layer = -1, old_layer = -1;
        float newness = 1;  ///< of layer over old_layer
        int turns = 0;      ///< captures since the scene changed
    };
    void set_world(const Scene& scene, const LightSet& lights);
    void set_placed(const Scene& scene, const SceneSettings& settings);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    ProbeFilter filter_;
    gl::UniformBuffer<shared::ProbesParams> block_;
    shared::ProbesParams params_{};
    gl::Texture world_, maps_, faces_;
    std::shared_ptr<const Environment> world_source_;
    float world_scale_ = 0;

    std::vector<Placed> placed_;
    std::optional<ProbeLayout> layout_;
    Scene seen_;  ///< what they see, without the probes
    bool diffuse_ = false;
    bool capturing_ = false;
    int captures_ = 0;
};

}  // namespace fumarole::light
