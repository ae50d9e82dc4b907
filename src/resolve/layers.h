#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include <fumarole/view.h>

#include "gl/framebuffer.h"
#include "gl/image_format.h"
#include "pass/volume_pass.h"
#include "prepared_frame.h"
#include "shared/volume_at_params.h"
#include "toolbox.h"

namespace fumarole::pass {
class StepTiles;  // pass/step_tiles.h
}

namespace fumarole::resolve {

/// What the media do to each pixel between the eye and the scene's depth. The composite is
/// `scene * transmittance + scattering`, in linear Rec. 709.
enum class Layer {
    scattering,     ///< radiance towards the eye [W/m^2/sr]; monochrome: alpha is the mean
                    ///< transmittance
    transmittance,  ///< per channel, 0..1; not if monochrome
    both,           ///< those two at once, transmittance as the second source of blending
};

/// How a layer is laid over a picture: picture * factor, + the layer where it adds.
struct LayerBlend {
    Layer layer;
    bool adds;
    int factor;  ///< FACTOR_ZERO, ... of shared/bindings.h
};

/// Where a layer is resolved to, as large as the frame.
struct Canvas {
    const gl::Framebuffer& framebuffer;  ///< framebuffer with the texture attached
    gl::TextureView texture;
    /// Where the resolve is a compute shader, which blends by itself; else it is drawn, and the
    /// blending stage blends.
    std::optional<gl::ImageFormat> image;
};

/// What a host's shader reads of the media before any depth: glsl/host/volume_at.glsl.
struct HostVolume {
    shared::VolumeAtParams params{};
    /// The froxels' scattering and transmittance, the march's depth, and its split layers' two.
    std::array<const gl::Texture*, kVolumeAtUnits> textures{};
};

/// From a frame to its two layers at the picture's size: a pass, what is kept of it from frame to
/// frame, and the filter that looks it up at a pixel's depth. Of one view in one mode.
class Layers {
public:
    virtual ~Layers() = default;

    /// Works the layers out, in textures of their own.
    virtual void draw(const PreparedFrame& frame) = 0;

    /// One layer of the last draw() at every pixel of a canvas that sees a medium: drawn to its
    /// framebuffer, which is bound with the state of blending set, or by a compute shader into its
    /// image, which is bound, with the blend in `variant`.
    virtual void resolve(const PreparedFrame& frame, Layer layer, const Canvas& canvas,
                         const gl::Defines& variant) = 0;
    /// What resolve() is called in a table of times.
    [[nodiscard]] virtual const char* resolve_name() const = 0;

    /// Binds what the last draw() knows of the media before any depth, where the frame asked for
    /// it (PreparedFrame::depths_asked).
    /// @returns the variant of a shader that includes written/volume_at.glsl
    [[nodiscard]] virtual gl::Defines bind_volume_at(const PreparedFrame& frame) = 0;

    /// Where the last draw() has seen media: before any depth there are none elsewhere. Null: it
    /// doesn't know.
    [[nodiscard]] virtual const pass::StepTiles* media_tiles() const { return nullptr; }

    /// The same for a host's shaders: all that their one text asks for.
    [[nodiscard]] virtual HostVolume host_volume(const PreparedFrame& frame) = 0;

    /// What the last draw() kept for it alone.
    [[nodiscard]] virtual std::uint64_t volume_at_bytes() const { return 0; }

    [[nodiscard]] virtual pass::VolumePass& pass() = 0;

    /// What resolve() looks up.
    [[nodiscard]] virtual OwnLayers own() const = 0;

    /// Lets the next frame be a first one.
    virtual void reset_history() = 0;
    /// What the last draw() did with what was kept, in words; "" if nothing ever is.
    [[nodiscard]] virtual const char* history_use() const = 0;
};

std::unique_ptr<Layers> make_layers(Settings::Mode mode, const Toolbox& tools);

}  // namespace fumarole::resolve
