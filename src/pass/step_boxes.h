#pragma once

#include <cstdint>
#include <optional>

#include "gl/buffer.h"
#include "gl/texture.h"
#include "pass/step_view.h"
#include "shared/step_boxes.h"
#include "toolbox.h"

namespace fumarole::pass {

/// The tiles of a frame by compute shaders: the media's boxes, which stay on the GPU, are projected
/// there, and what tiles see of them stays there too. The same sums as on the CPU, in doubles:
/// glsl/pass/see_boxes.comp, choose_steps.comp, want_depths.comp.
class StepBoxes {
public:
    explicit StepBoxes(const Toolbox& tools) : tools_{tools}, block_{tools.device, "step tiles"} {}

    /// Compiles what fill() needs.
    void prepare() const;

    /// Fills three textures of a texel a tile, as StepTiles has them. What reads them may follow.
    void fill(const StepView& view, const gl::Texture& march, const gl::Texture& depth,
              const gl::Texture& picture);

private:
    void upload_boxes();
    void write_block(const StepView& view, const gl::Texture& march, const gl::Texture& picture);

    const Toolbox& tools_;
    gl::Buffer boxes_;                       ///< shared::StepBox
    std::optional<std::uint64_t> boxes_id_;  ///< MediaSet::occupied_id() that they are of
    gl::Buffer seen_;                        ///< shared::SeenTile, one a tile of the march
    gl::UniformBuffer<shared::StepViewParams> block_;
};

}  // namespace fumarole::pass
