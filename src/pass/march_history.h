#pragma once

#include <array>
#include <map>
#include <optional>

#include "gl/buffer.h"
#include "gl/texture.h"
#include "pass/history.h"
#include "pass/step_tiles.h"
#include "shared/march_history_params.h"

namespace fumarole::pass {

/// The layer that was marched for a view's last frames, reprojected and averaged with the next:
/// Yang et al. 2020, "A Survey of Temporal Antialiasing Techniques"; a ray's media are taken to
/// lie where what it sees of them does in the mean. glsl/pass/march_history.frag.
class MarchHistory {
public:
    /// Two targets, scattering and what march_history.frag keeps beside it; coloured: transmittance
    /// in rgb.
    struct Layer {
        gl::Texture scattering, more;
        gl::Framebuffer framebuffer;
    };

    explicit MarchHistory(const Toolbox& tools);

    /// Averages what was marched for a frame that keeps a history with what is kept of its view.
    /// The layer's depth is bound. @returns the mean, until the next call
    const Layer& add(const PassFrame& frame, const StepTiles& tiles, const gl::Texture& scattering,
                     const gl::Texture& more);
    /// What add() gave for the last frame of a view; none if there was none.
    [[nodiscard]] const Layer* find(int view) const;

    void forget(int view) { views_.erase(view); }
    [[nodiscard]] HistoryUse use() const { return use_; }

private:
    struct Shape {
        glm::ivec2 texels{0}, picture{0};
        GLenum format = 0;
        bool monochrome = false;

        bool operator==(const Shape&) const = default;
    };
    struct View {
        Shape shape;
        std::array<Layer, 2> layers;  ///< one is read while the other is drawn
        int current = 0;              ///< into layers: of the last frame
        std::optional<HistoryView> last;
        glm::dvec2 last_media_range{0};  ///< view_z [m]
        glm::dvec2 last_offset{0};       ///< Frame::layer_offset
        HistoryWeight weight;
    };
    View& view_of(const PassFrame& frame);
    void write_block(const PassFrame& frame, const View& view, float weight) const;

    const Toolbox& tools_;
    gl::UniformBuffer<shared::MarchHistoryParams> block_;
    std::map<int, View> views_;  ///< by Frame::history
    HistoryUse use_ = HistoryUse::off;
};

}  // namespace fumarole::pass
