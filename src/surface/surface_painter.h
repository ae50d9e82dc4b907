#pragma once

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "shared/draw_params.h"
#include "surface/dimmed_part.h"
#include "surface/ltc_table.h"
#include "surface/surface_set.h"
#include "toolbox.h"

namespace fumarole::surface {

/// Draws a scene's surfaces and its world, for hosts that have no renderer of their own:
/// glsl/pass/sky.frag, glsl/pass/surface.frag.
class SurfacePainter {
public:
    explicit SurfacePainter(const gl::Device& device)
        : block_{device, "surface draw"}, framebuffer_{device, "surfaces"}, ltc_{make_ltc_texture(
                                                                                device)}
    {
    }

    /// Draws into the frame's colour and depth, over all that is there. The frame's block, the
    /// lights and the world's light on surfaces are bound.
    /// @param dimmed light comes through the media, which are bound too
    /// @param unseen a flag for each instance that is left out
    void draw(const Toolbox& tools, const SurfaceSet& surfaces, const PreparedFrame& frame,
              bool dimmed, const std::vector<bool>& unseen = {});

private:
    /// Where an instance is drawn; none: all over the picture.
    using Bands = std::optional<std::vector<PictureBand>>;
    /// @param bands of each instance; empty: all are drawn all over the picture
    void draw_instances(const Toolbox& tools, const SurfaceSet& surfaces,
                        const PreparedFrame& frame, const gl::Defines& defines,
                        const std::vector<bool>& unseen, const std::vector<Bands>& bands);
    void detach(const gl::Device& gl);

    gl::UniformBuffer<shared::DrawParams> block_;
    gl::Framebuffer framebuffer_;
    gl::Texture ltc_;
};

/// The settings that surfaces are drawn with where media have `settings`.
FrameSettings surface_settings(const FrameSettings& settings);

}  // namespace fumarole::surface
