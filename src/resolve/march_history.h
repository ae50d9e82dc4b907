#pragma once

#include <array>
#include <optional>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "pass/history.h"
#include "pass/ray_march.h"
#include "shared/march_history_params.h"

namespace fumarole::resolve {

/// The layer that was marched for one view's last frames, reprojected and averaged with the next:
/// Yang et al. 2020, "A Survey of Temporal Antialiasing Techniques"; a ray's media are taken to
/// lie where what it sees of them does in the mean. glsl/pass/march_history.glsl.
class MarchHistory {
public:
    explicit MarchHistory(const Toolbox& tools);

    /// Averages what was marched for a frame that keeps a history with what is kept of its view.
    /// The layer's depth is bound.
    void add(const PreparedFrame& frame, const pass::MarchedLayer& marched);
    /// Puts the mean of the view's frames in the place of what was marched for the last of them.
    void replace(pass::MarchedLayer& marched) const;

    /// Lets the next frame be a first one.
    void drop_history() { view_.last.reset(); }
    /// What add() did with what was kept, in words.
    [[nodiscard]] const char* use() const { return to_string(use_, change_); }

private:
    /// Two targets, scattering and what march_history.glsl keeps beside it; coloured: transmittance
    /// in rgb.
    struct Kept {
        gl::Texture scattering, more;
        gl::Framebuffer framebuffer;
    };
    struct Shape {
        glm::ivec2 texels{0}, picture{0};
        GLenum format = 0;
        bool monochrome = false;

        bool operator==(const Shape&) const = default;
    };
    struct View {
        Shape shape;
        std::array<Kept, 2> layers;  ///< one is read while the other is drawn
        int current = 0;             ///< into layers: of the last frame
        std::optional<pass::HistoryView> last;
        glm::dvec2 last_media_range{0};  ///< view_z [m]
        glm::dvec2 last_offset{0};       ///< Frame::layer_offset
        pass::HistoryWeight weight;
    };
    void fit(const PreparedFrame& frame);
    void write_block(const PreparedFrame& frame, const View& view, float weight) const;

    const Toolbox& tools_;
    gl::UniformBuffer<shared::MarchHistoryParams> block_;
    View view_;
    pass::HistoryUse use_ = pass::HistoryUse::off;
    pass::SceneChange change_ = pass::SceneChange::none;
};

}  // namespace fumarole::resolve
