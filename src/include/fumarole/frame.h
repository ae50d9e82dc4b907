#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include <fumarole/gl.h>

namespace fumarole {

/// How a host keeps depth.
struct DepthConvention {
    /// True if NDC depth lies in [0, 1] (glClipControl with GL_ZERO_TO_ONE), else in [-1, 1].
    bool zero_to_one = false;
    bool reversed = false;  ///< true if the near plane has depth 1 and the sky 0, else 0 and 1
};

/// The part of a frame that transparents of the host's own are in; all of it unless told.
struct TransparentExtent {
    /// Nearest and farthest view depth [m].
    glm::dvec2 view_z{0, std::numeric_limits<double>::infinity()};
    /// Corners of a rectangle of the picture [pixels], from the lower left.
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
    glm::dmat4 view_from_world{1.0};  ///< rigid, right-handed camera matrix; it looks along -z
    /// Projection, perspective or orthographic, off-axis too; its far plane may be infinite.
    glm::dmat4 clip_from_view{1.0};
    /// A shift of the march's jitter, 0..1, to be varied from frame to frame where frames are
    /// averaged. With FrameSettings::temporal `index` shifts it instead.
    double jitter_offset = 0;
    /// Offset of each sample of a half-size layer from its texel's middle, -0.5..0.5 texels, to be
    /// varied likewise: averaged frames then see what lies between the samples of one.
    glm::dvec2 layer_offset{0};
    /// Number of the frame: each has the froxels' samples elsewhere, and with
    /// FrameSettings::temporal the march's. Frame 0 has those of froxels in their middle.
    std::uint64_t index = 0;
    /// Extents of the host's own transparents that it draws through View::volume_at() or
    /// Renderer::begin_transparents(): a march keeps what it meets before their depths, and the
    /// less the tighter they are. If there are none, View::volume_at() has nothing.
    std::vector<TransparentExtent> transparents;
};

}  // namespace fumarole
