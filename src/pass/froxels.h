#pragma once

#include <array>
#include <optional>
#include <string>

#include "gl/buffer.h"
#include "gl/texture.h"
#include "pass/history.h"
#include "pass/volume_pass.h"
#include "shared/froxel_params.h"

namespace fumarole::pass {

/// How the extinction of a froxel is kept, and the transmittance of what is integrated.
enum class FroxelExtinction {
    grey,          ///< as one number, in the alpha of a colour
    one_color,     ///< likewise; of what is integrated as red_in_alpha
    red_in_alpha,  ///< green and blue in a volume of two channels
    apart          ///< in a colour of its own: formats without alpha
};

/// Which volumes a scene and its settings need: no more than that is made.
struct FroxelPlan {
    glm::ivec3 count{0};  ///< columns, guard included, and slices
    /// Pixels: of another size, as many columns lie elsewhere in the view.
    glm::ivec2 picture{0};
    int integrated_slices = 0;  ///< of what is integrated
    GLenum format = 0;          ///< format of the V-buffer and of what is integrated
    GLenum source_format = 0;   ///< format of source and extinction
    FroxelExtinction extinction = FroxelExtinction::grey;
    bool v_buffer = false;  ///< what dims light is looked up between froxels
    bool emission = false;
    bool mixed_g = false;
    bool history = false;
    /// The history's volumes round by a dither, since they have 16 bits.
    bool dithered = false;
    [[nodiscard]] bool one_number() const
    {
        return extinction == FroxelExtinction::grey || extinction == FroxelExtinction::one_color;
    }
    /// What is integrated takes the place of last frame's source, which is read no more by then.
    [[nodiscard]] bool shares() const { return format == source_format; }
    /// There is transmittance that has no place there.
    [[nodiscard]] bool transmittance_apart() const
    {
        return extinction == FroxelExtinction::one_color ||
               (!shares() && extinction != FroxelExtinction::grey);
    }

    bool operator==(const FroxelPlan&) const = default;
};

/// What the froxels of a frame add up to, front to back.
struct IntegratedFroxels {
    const gl::Texture* scattering = nullptr;
    const gl::Texture* transmittance = nullptr;  ///< empty where it is in the scattering's alpha
    FroxelExtinction storage = FroxelExtinction::grey;  ///< never one_color
    gl::Defines defines;                                ///< that say so to shaders
};

/// Froxels: media and light sampled in the cells of a grid in the view's frustum, kept from frame
/// to frame, integrated front to back. Wronski 2014, "Volumetric
/// Fog"; Hillaire 2015; Eevee's design of October 2017. One file a step: glsl/pass/scatter.comp,
/// integrate.comp, and before them v_buffer.comp where light is dimmed by the grid.
class Froxels : public VolumePass {
public:
    explicit Froxels(const Toolbox& tools);
    void draw(const PreparedFrame& frame) override;
    gl::Texture sample_counts(const PreparedFrame& frame) override;
    void show_samples(const PreparedFrame& frame, const gl::Texture& counts) override;
    void show_slice(const PreparedFrame& frame) override;

    /// What the last draw() integrated.
    [[nodiscard]] IntegratedFroxels integrated() const;
    /// Writes and binds the block that a lookup at a depth of the last draw()'s frame needs.
    void write_block(const PreparedFrame& frame) { write_block(frame, view_of(frame), 0); }
    /// That block.
    [[nodiscard]] shared::FroxelParams block(const PreparedFrame& frame)
    {
        return params(frame, view_of(frame), 0);
    }

    /// Lets the next frame be a first one.
    void drop_history() { view_.last.reset(); }
    [[nodiscard]] const char* history_use() const { return to_string(use_, change_); }

private:
    struct View {
        FroxelPlan plan;
        gl::Texture sigma_s, sigma_t, emission, phase;  ///< the V-buffer
        /// Two of each: this frame's, and those that last frame's are read from and that are
        /// integrated into then. Extinction where it is more than one number.
        std::array<gl::Texture, 2> source, extinction;
        /// What is integrated, where it is of another format or has other channels than those.
        gl::Texture own_scattering, own_transmittance;
        /// Once the scene has changed under a history: this frame's alone, and how many frames
        /// what is kept of each froxel is worth.
        gl::Texture frame_source, frame_extinction;
        std::array<gl::Texture, 2> counts;
        bool counted = false;  ///< last frame's counts are there
        [[nodiscard]] const gl::Texture& scattering() const
        {
            return own_scattering ? own_scattering : source.at(1 - current);
        }
        /// Empty where it is in the scattering's alpha.
        [[nodiscard]] const gl::Texture& transmittance() const
        {
            return own_transmittance ? own_transmittance : extinction.at(1 - current);
        }
        int current = 0;                   ///< into those pairs: of the last frame
        std::uint32_t dithered_frame = 0;  ///< FroxelParams'
        std::optional<HistoryView> last;
        HistoryWeight weight;
    };
    /// The view, its volumes those that the frame needs.
    View& view_of(const PreparedFrame& frame);
    [[nodiscard]] shared::FroxelParams params(const PreparedFrame& frame, const View& view,
                                              float history_weight) const;
    void write_block(const PreparedFrame& frame, const View& view, float history_weight) const;
    void draw_v_buffer(const PreparedFrame& frame, const View& view) const;
    void bind_v_buffer(const View& view) const;
    /// To be written.
    void bind_kept(const View& view, const gl::Texture& source,
                   const gl::Texture& extinction) const;
    void scatter(const PreparedFrame& frame, View& view, HistoryUse use) const;
    void bind_history(const View& view) const;
    void make_counts(View& view) const;
    void add_history(const PreparedFrame& frame, View& view, SceneChange change) const;
    void integrate(const PreparedFrame& frame, const View& view) const;
    void dispatch(const char* file, const gl::Defines& defines, glm::ivec3 invocations,
                  glm::ivec3 group) const;

    gl::UniformBuffer<shared::FroxelParams> block_;
    View view_;
    HistoryUse use_ = HistoryUse::off;
    SceneChange change_ = SceneChange::none;
};

/// What of the scene the froxels keep and why: a line each.
std::vector<std::string> explain_froxels(const Toolbox& tools, const FrameSettings& settings);

}  // namespace fumarole::pass
