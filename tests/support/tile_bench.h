#pragma once

#include <vector>

#include "pass/blue_noise.h"
#include "pass/step_tiles.h"
#include "pass/sun_shades.h"
#include "shared/bindings.h"
#include "support/gl_test.h"

namespace fumarole::test {

/// Whatever the tiles of a scene are worked out with, for tests that ask what they are.
struct TileBench {
    using Texels = std::vector<glm::uvec4>;

    explicit TileBench(const gl::Device& device)
        : programs{device}, timers{device}, surfaces{device}, media{device},
          lights{device, programs}, volumes{device, programs, timers}, probes{device, programs},
          fullscreen{device, "fullscreen"}, frame_block{device, "frame"},
          depth_sampler{device, "scene depth"}, blue_noise{pass::make_blue_noise(device)},
          tools{device,   programs,   timers,      media,         lights,     volumes,   probes,
                settings, fullscreen, frame_block, depth_sampler, blue_noise, sun_shades}
    {
    }
    void set(const Scene& scene)
    {
        media.set(scene, settings);
        surfaces.set(scene.surfaces);
        lights.set(scene, surfaces, media.bounds(), 16, false);
    }

    [[nodiscard]] PreparedFrame prepare(const Scene& scene, const FrameSettings& of,
                                        glm::dvec2 layer_offset = {0, 0}) const
    {
        Frame frame;
        frame.color.size = glm::ivec3(scene.resolution, 1);
        frame.depth.size = frame.color.size;
        frame.depth_convention = {.zero_to_one = true, .reversed = true};
        frame.view_from_world = view_from_world(scene.camera);
        frame.clip_from_view = clip_from_view(scene.camera, scene.resolution, {0, 0});
        frame.layer_offset = layer_offset;
        const medium::MediaDetail detail = media.detail();
        return prepare_frame(
            frame, of, {.media = media.bounds(), .detail = detail.boxes, .voxel = detail.grids});
    }

    [[nodiscard]] Texels read(const gl::Texture& texture) const
    {
        const glm::ivec3 size = texture.size();
        Texels texels(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
        tools.device->GetTextureImage(texture.id(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                                      static_cast<GLsizei>(texels.size() * sizeof(glm::uvec4)),
                                      texels.data());
        return texels;
    }

    gl::ProgramCache programs;
    gl::PassTimers timers;
    surface::SurfaceSet surfaces;
    medium::MediaSet media;
    light::LightSet lights;
    light::LightVolumes volumes;
    light::Probes probes;
    gl::VertexArray fullscreen;
    gl::UniformBuffer<shared::FrameParams> frame_block;
    gl::Sampler depth_sampler;
    gl::Texture blue_noise;
    pass::SunShades sun_shades;
    Settings settings;
    Toolbox tools;
};

}  // namespace fumarole::test
