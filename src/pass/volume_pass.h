#pragma once

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "settings.h"

namespace fumarole::pass {

/// What the media do to each pixel between the eye and the scene's depth, at the layer's
/// resolution. The composite is `scene * transmittance + scattering`, in linear Rec. 709.
struct VolumeLayer {
    gl::TextureView depth;          ///< r32f: view_z of the scene [m] as each texel took it
    gl::TextureView scattering;     ///< radiance towards the eye [W/m^2/sr]; monochrome: alpha is
                                    ///< the mean transmittance
    gl::TextureView transmittance;  ///< per channel, 0..1; nothing if monochrome
};

/// Targets that are remade when the size or the format changes.
class LayerTargets {
public:
    explicit LayerTargets(const gl::Device& device) : device_{device} {}
    void resize(glm::ivec2 texels, Settings::Format format, bool monochrome);
    [[nodiscard]] VolumeLayer layer() const
    {
        return {depth_.view(), scattering_.view(), transmittance_.view()};
    }
    [[nodiscard]] glm::ivec2 size() const { return size_; }
    [[nodiscard]] const gl::Framebuffer& depth_framebuffer() const { return depth_framebuffer_; }
    [[nodiscard]] const gl::Framebuffer& framebuffer() const { return framebuffer_; }

private:
    const gl::Device& device_;
    glm::ivec2 size_{0};
    Settings::Format format_ = Settings::Format::rgba16f;
    bool monochrome_ = false;
    gl::Texture depth_, scattering_, transmittance_;
    gl::Framebuffer depth_framebuffer_, framebuffer_;
};

}  // namespace fumarole::pass
