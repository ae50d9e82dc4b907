#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include <fumarole/gl.h>

namespace fumarole {

/// How a host keeps depth.
struct DepthConvention {
    bool zero_to_one =
        false;  ///< glClipControl(..., GL_ZERO_TO_ONE): NDC depth in [0, 1], else [-1, 1]
    bool reversed = false;  ///< near is 1 and far is 0; the sky is then 0, else 1
};

/// The part of a frame that transparents of the host's own are in; all of it unless told.
struct TransparentExtent {
    /// Nearest and farthest view depth [m].
    glm::dvec2 view_z{0, std::numeric_limits<double>::infinity()};
    /// A rectangle of the picture, pixels from the lower left.
    glm::dvec2 low{0}, high{std::numeric_limits<double>::infinity()};
};

/// A host's picture, borrowed for one call, and the camera that it was drawn with.
struct Frame {
    /// Linear colour, colour-renderable, one level, no multisampling; composited in place unless
    /// there is a `target`. Its alpha stays.
    gl::TextureView color;
    /// Where the composite goes instead, alpha too: of the same size, colour-renderable, and
    /// another texture than `color`, which is then only read.
    gl::TextureView target{};
    /// 2-D depth of the same size; only read, whatever its filter and comparison are set to.
    gl::TextureView depth;
    DepthConvention depth_convention;
    glm::dmat4 view_from_world{1.0};  ///< rigid; right-handed, the eye looks along -z
    glm::dmat4 clip_from_view{
        1.0};  ///< perspective or orthographic, off-axis too; far may be infinite
    /// A shift of the march's jitter, 0..1, to be varied from frame to frame where frames are
    /// averaged. With FrameSettings::temporal `index` shifts it instead.
    double jitter_offset = 0;
    /// Likewise, where in its texel each sample of a half-size layer lies: -0.5..0.5 texels from
    /// the middle. Averaged frames then see what lies between the samples of one.
    glm::dvec2 layer_offset{0};
    /// Counts frames: each has the froxels' samples elsewhere, and with FrameSettings::temporal the
    /// march's. Frame 0 has froxels' in the middle.
    std::uint64_t index = 0;
    /// Where the host's own transparents are that it draws through View::volume_at() or
    /// Renderer::begin_transparents(): a march keeps what it meets before their depths, and the
    /// less the tighter they are. Empty: View::volume_at() has nothing.
    std::vector<TransparentExtent> transparents;
};

}  // namespace fumarole
