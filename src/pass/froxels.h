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

/// Which volumes a scene and its settings need: no more than that is made.
struct FroxelPlan {
    glm::ivec3 count{0};  ///< columns, guard included, and slices
    /// Pixels: of another size, as many columns lie elsewhere in the view.
    glm::ivec2 picture{0};
    GLenum format = 0;  ///< format of the V-buffer and of what is integrated
    GLenum source_format = 0;
    bool extinction_in_alpha =
        false;               ///< one extinction for all channels, in the alpha of a colour
    bool one_color = false;  ///< likewise, but of what is integrated: it has one colour
    /// The V-buffer is looked up between its froxels, so it has a volume of its own size.
    bool looked_through = false;
    bool emission = false;
    bool mixed_g = false;
    bool history = false;
    /// The history's volumes round by a dither, since they have 16 bits.
    bool dithered = false;
    /// What is integrated has its transmittance where last frame's source was.
    [[nodiscard]] bool transmittance_in_source() const { return one_color && history; }

    bool operator==(const FroxelPlan&) const = default;
};

/// What the froxels of a frame add up to, front to back.
struct IntegratedFroxels {
    const gl::Texture* scattering =
        nullptr;  ///< scattering; where there is one extinction, with transmittance in alpha
    const gl::Texture* transmittance = nullptr;  ///< empty where it is in that alpha
    gl::Defines storage;                         ///< which of the two it is, for the shaders
};

/// Froxels: media and light sampled in the cells of a grid in the view's frustum, kept from frame
/// to frame, integrated front to back. Wronski 2014, "Volumetric
/// Fog"; Hillaire 2015; Eevee's design of October 2017. One file a step: glsl/pass/v_buffer.comp,
/// scatter.comp, integrate.comp.
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
        gl::Texture own_sigma_s, own_sigma_t, emission, phase;
        /// Two of each where there is a history: one is read while the other is written.
        std::array<gl::Texture, 2> source, extinction;
        /// Once the scene has changed under a history: this frame's source alone, and how many
        /// frames what is kept of each froxel is worth.
        gl::Texture frame_source;
        std::array<gl::Texture, 2> counts;
        bool counted = false;                       ///< last frame's counts are there
        gl::Texture scattering, own_transmittance;  ///< integrated
        // The V-buffer's, which have had their use before anything is integrated.
        [[nodiscard]] const gl::Texture& sigma_s() const
        {
            return plan.looked_through ? own_sigma_s : scattering;
        }
        [[nodiscard]] const gl::Texture& sigma_t() const
        {
            return plan.looked_through ? own_sigma_t : own_transmittance;
        }
        /// As last frame's source has had.
        [[nodiscard]] const gl::Texture& transmittance() const
        {
            return plan.transmittance_in_source() ? source.at(1 - current) : own_transmittance;
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
