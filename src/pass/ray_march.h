#pragma once

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "pass/step_tiles.h"
#include "pass/volume_pass.h"
#include "shared/split_params.h"

namespace fumarole::pass {

/// The format of the march's targets: the small one has no alpha, in which a monochrome one keeps
/// transmittance, and one with a history the media's depth.
Settings::Format march_format(const Toolbox& tools, const FrameSettings& settings);

/// What was marched for a frame: a texel a ray.
struct MarchedLayer {
    const StepTiles* tiles = nullptr;    ///< tiles that were marched, and whose pixels see a medium
    const gl::Texture* depth = nullptr;  ///< view_z of the scene [m] as each texel took it
    const gl::Texture* scattering = nullptr;  ///< monochrome: transmittance in its alpha
    /// Monochrome: empty, or, of a frame that keeps a history, the media's depth.
    const gl::Texture* transmittance = nullptr;
    bool grey = false;  ///< monochrome
    int guard = 0;      ///< texels beyond the picture on each side
    int scale = 1;      ///< pixels along a texel's edge
};

/// What a march kept at a frame's depths, to be looked up.
struct SplitLayers {
    const gl::Texture* scattering = nullptr;     ///< empty if the frame asked for no depth
    const gl::Texture* transmittance = nullptr;  ///< monochrome: empty
    const shared::SplitParams* depths = nullptr;
};

/// Marches a ray through the media for each texel of a layer that may be smaller than the picture.
/// Eevee's design of July 2017; glsl/pass/ray_march.glsl.
class RayMarch : public VolumePass {
public:
    explicit RayMarch(const Toolbox& tools)
        : VolumePass{tools}, tiles_{tools}, split_block_{tools.device, "split depths"}
    {
    }
    void draw(const PreparedFrame& frame) override;
    gl::Texture sample_counts(const PreparedFrame& frame) override;
    void show_samples(const PreparedFrame& frame, const gl::Texture& counts) override;

    /// What the last draw() marched.
    [[nodiscard]] MarchedLayer layer() const;

    /// Binds what it kept at the frame's depths (PreparedFrame::depths_asked), to be looked up:
    /// glsl/scene/volume_at_splits.glsl, which written/volume_at.glsl of the variant names.
    [[nodiscard]] gl::Defines bind_split_layers(const FrameSettings& settings) const;
    [[nodiscard]] SplitLayers splits() const;
    [[nodiscard]] std::uint64_t split_bytes() const;

private:
    void resize(const PreparedFrame& frame);
    void resize_splits(const PreparedFrame& frame);
    /// What no ray writes is as where there is no medium.
    void clear_splits(bool made_anew);
    void draw_layer_depth(const PreparedFrame& frame);
    /// Into one target, or two: the framebuffer's, or these images, as the frame's passes have it.
    void march(const gl::Framebuffer& framebuffer, const gl::Texture& first,
               const gl::Texture& second, gl::Defines defines) const;
    [[nodiscard]] gl::Defines march_defines(const PreparedFrame& frame) const;
    /// Whether the media widen what is around suns, and whether the frame sees it.
    [[nodiscard]] bool has_aureoles() const;
    [[nodiscard]] bool sees_aureole(const PreparedFrame& frame) const;

    glm::ivec2 size_{0};  ///< texels of the layer
    Settings::Format format_ = Settings::Format::rgba16f;
    bool monochrome_ = false;
    int guard_ = 0, scale_ = 1;  ///< as MarchedLayer has them
    bool has_media_depth_ = false;
    StepTiles tiles_;
    gl::Texture depth_, scattering_, transmittance_;  ///< as MarchedLayer has them
    gl::Framebuffer depth_framebuffer_, framebuffer_;
    gl::Texture split_scattering_, split_transmittance_;  ///< a layer a depth; monochrome: one
    bool fine_splits_ = false;                            ///< true if splits have 32 bits
    std::vector<bool> split_tiles_;  ///< written since they were cleared, one a tile of the march
    gl::UniformBuffer<shared::SplitParams> split_block_;
    shared::SplitParams split_params_{};  ///< what is in it
};

}  // namespace fumarole::pass
