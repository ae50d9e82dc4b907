#pragma once

#include <fumarole/settings.h>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "light/light_set.h"
#include "light/light_volumes.h"
#include "light/probes.h"
#include "medium/media_set.h"
#include "prepared_frame.h"

namespace fumarole {

namespace pass {
class SunShades;  // pass/sun_shades.h
}

/// What all that draws a renderer's frames shares; it outlives them.
struct Toolbox {
    const gl::Device& device;
    gl::ProgramCache& programs;
    gl::PassTimers& timers;
    const medium::MediaSet& media;
    const light::LightSet& lights;
    const light::LightVolumes& volumes;
    light::Probes& probes;
    const SceneSettings& scene_settings;
    const gl::VertexArray& fullscreen;
    const gl::UniformBuffer<shared::FrameParams>& frame_block;
    const gl::Sampler& depth_sampler;  ///< so that the host's filter and comparison don't matter
    const gl::Texture& blue_noise;     ///< pass::make_blue_noise()
    pass::SunShades& sun_shades;       ///< shades of the suns in the frame that is drawn

    /// Binds the frame's block, and with it the scene's depth.
    void bind_block(const PreparedFrame& frame) const;
    void bind(const PreparedFrame& frame) const;

    /// One fragment shader over all of the bound framebuffer.
    void draw_fullscreen(const char* fragment_file, const gl::Defines& defines) const;

    /// A compute shader over that many pixels, in groups of PICTURE_GROUP along both edges.
    void dispatch_over(glm::ivec2 pixels, const char* file, const gl::Defines& defines) const;

    /// The lines that glsl/scene/in_scattering.glsl needs: media, lights, and how light travels.
    [[nodiscard]] gl::Defines scattering_defines(const FrameSettings& settings) const;

    /// One number for transmittance, in the alpha of the scattering.
    [[nodiscard]] bool monochrome(const FrameSettings& settings) const;

    /// Whether march, layer depth, history and resolve are compute shaders (FrameSettings::passes).
    [[nodiscard]] bool computes(const FrameSettings& settings) const;

    /// Makes sure that a shader's loops are not cut off: `steps` points of the media, from each of
    /// which every light is looked at through the media in `shadow_steps`.
    /// @throws Error if this GL would, saying what to lower
    void check_loops(int steps, int shadow_steps) const;
};

}  // namespace fumarole
