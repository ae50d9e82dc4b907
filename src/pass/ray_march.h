#pragma once

#include "gl/texture.h"
#include "pass/march_history.h"
#include "pass/step_tiles.h"
#include "pass/volume_pass.h"

namespace fumarole::pass {

/// The format of the march's targets: the small one has no alpha, in which a monochrome one keeps
/// transmittance, and one with a history the media's depth.
Settings::Format march_format(const Toolbox& tools, const Settings& settings);

/// Marches a ray through the media for each texel of a layer that may be smaller than the picture,
/// then brings the layer to the picture's size with an eye to its depth. Eevee's design of July
/// 2017; glsl/pass/ray_march.frag, glsl/resolve/upsample.frag.
class RayMarch : public VolumePass {
public:
    explicit RayMarch(const Toolbox& tools);
    void draw(const PassFrame& frame) override;
    void resolve(const PassFrame& frame, Layer layer) override;
    [[nodiscard]] const char* resolve_name() const override { return "upsample"; }
    gl::Texture sample_counts(const PassFrame& frame) override;
    void show_samples(const PassFrame& frame, const gl::Texture& counts) override;
    void forget(int view) override;
    [[nodiscard]] std::string history_use() const override;

private:
    void resize(const PassFrame& frame);
    void march(const PassFrame& frame);
    void draw_layer_depth(const PassFrame& frame);
    [[nodiscard]] gl::Defines march_defines(const Settings& settings) const;

    glm::ivec2 size_{0};  ///< texels of the layer
    Settings::Format format_ = Settings::Format::rgba16f;
    bool monochrome_ = false;
    bool has_media_depth_ = false;
    StepTiles tiles_;
    gl::Texture blue_noise_;
    gl::Texture depth_;  ///< r32f: view_z of the scene [m] as each texel took it
    /// transmittance_: of a monochrome layer that has a history, the media's depth.
    gl::Texture scattering_, transmittance_;
    gl::Framebuffer depth_framebuffer_, framebuffer_;
    std::optional<MarchHistory> history_;  ///< while the settings ask for it
};

}  // namespace fumarole::pass
