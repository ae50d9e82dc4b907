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

    /// Compiles what draw() needs where a frame sees surfaces beyond the nodes that light them, in
    /// parts: one from amid the media doesn't.
    static void prepare(const Toolbox& tools, const SurfaceSet& surfaces);

private:
    /// Where an instance is drawn; none: all over the picture.
    using Bands = std::optional<std::vector<PictureBand>>;
    /// What one variant of the shader draws.
    struct Share {
        gl::Defines variant;
        std::vector<Bands> bands;  ///< of each instance; empty: all are drawn all over the picture
    };
    /// What surfaces take to shade, as one share; or, for a rasteriser without branches, a share
    /// for each that asks for less: what is drawn by the first is not shaded a second time.
    static std::vector<Share> shares_of(const Toolbox& tools, const SurfaceSet& surfaces,
                                        const PreparedFrame& frame, const gl::Defines& plain,
                                        bool dimmed);
    void draw_share(const Toolbox& tools, const SurfaceSet& surfaces, const PreparedFrame& frame,
                    const Share& share, const std::vector<bool>& unseen);

    gl::UniformBuffer<shared::DrawParams> block_;
    gl::Framebuffer framebuffer_;
    gl::Texture ltc_;
};

/// The settings that surfaces are drawn with where media have `settings`.
FrameSettings surface_settings(const FrameSettings& settings);

}  // namespace fumarole::surface
