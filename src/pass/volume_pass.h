#pragma once

#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "light/light_set.h"
#include "light/light_volumes.h"
#include "medium/media_set.h"
#include "pass/frame_setup.h"
#include <fumarole/bounds.h>
#include <fumarole/settings.h>

namespace fumarole::pass {

/// What a renderer's passes share; it outlives them.
struct Toolbox {
    const gl::Device& device;
    gl::ProgramCache& programs;
    gl::PassTimers& timers;
    const medium::MediaSet& media;
    const light::LightSet& lights;
    const light::LightVolumes& volumes;
    const gl::VertexArray& fullscreen;

    /// One fragment shader over all of the bound framebuffer.
    void draw_fullscreen(const char* fragment_file, const gl::Defines& defines) const;

    /// The lines that glsl/scene/in_scattering.glsl needs: media, lights, and how light travels.
    [[nodiscard]] gl::Defines scattering_defines(const Settings& settings) const;

    /// One number for transmittance, in the alpha of the scattering.
    [[nodiscard]] bool monochrome(const Settings& settings) const;

    /// Makes sure that a shader's loops are not cut off: `steps` points of the media, from each of
    /// which every light is looked at through the media in `shadow_steps`.
    /// @throws Error if this GL would, saying what to lower
    void check_loops(int steps, int shadow_steps, const Settings& settings) const;
};

/// One frame as the passes see it. Its block, the media, the lights and the scene's depth are bound
/// while a pass works on it.
struct PassFrame {
    const Frame& host;
    const Settings& settings;
    Eye eye;
    Bounds media;                ///< world bounds of all media [m], not empty
    std::uint64_t scene_id = 0;  ///< another after every set_scene()
    bool prepares = false;       ///< drawn so that each variant of the shaders has been drawn with
};

/// What the media do to each pixel between the eye and the scene's depth. The composite is
/// `scene * transmittance + scattering`, in linear Rec. 709.
enum class Layer {
    scattering,     ///< radiance towards the eye [W/m^2/sr]; monochrome: alpha is the mean
                    ///< transmittance
    transmittance,  ///< per channel, 0..1; not if monochrome
    both,           ///< those two at once, transmittance as the second source of blending
};

/// From a frame to its two layers. The ray march and the froxels are siblings behind this face:
/// they share glsl/lib and glsl/scene and differ in where they sample and where they store.
class VolumePass {
public:
    explicit VolumePass(const Toolbox& tools) : tools_{tools} {}
    virtual ~VolumePass() = default;
    VolumePass(const VolumePass&) = delete;
    VolumePass& operator=(const VolumePass&) = delete;

    /// Works the layers out, in textures of the pass's own.
    virtual void draw(const PassFrame& frame) = 0;

    /// Draws one layer of the last draw() at every pixel of the bound framebuffer, which is as
    /// large as the frame. Blending is the caller's.
    virtual void resolve(const PassFrame& frame, Layer layer) = 0;
    /// What resolve() is called in a table of times.
    [[nodiscard]] virtual const char* resolve_name() const = 0;

    /// Evaluations of the media that draw() takes, shadows included: r32f, of each ray or froxel.
    virtual gl::Texture sample_counts(const PassFrame& frame) = 0;

    /// Draws, at every pixel of the bound framebuffer, which is as large as the frame, what
    /// sample_counts() gave for the ray, or the sum for the column of froxels, that it is in.
    virtual void show_samples(const PassFrame& frame, const gl::Texture& counts) = 0;

    /// Draws, likewise, the radiance that a slice of the last draw() adds along a metre of ray
    /// [W/m^2/sr/m], the mean of its channels; nothing where a pass has no slices. INSPECT_BLOCK,
    /// which is bound, says which slice.
    virtual void show_slice(const PassFrame& /*frame*/) {}

    /// Drops what is kept of a view from frame to frame.
    virtual void forget(int /*view*/) {}
    /// What the last draw() did with what was kept, in words; "" if nothing ever is.
    [[nodiscard]] virtual std::string history_use() const { return ""; }

protected:
    const Toolbox& tools_;
};

}  // namespace fumarole::pass
