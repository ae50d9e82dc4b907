#pragma once

#include "gl/texture.h"
#include "prepared_frame.h"
#include "toolbox.h"

namespace fumarole::pass {

/// What the media do to light on its way to the eye, worked out for a frame in textures of the
/// pass's own; src/resolve brings it to the picture's pixels. The ray march and the froxels are
/// siblings behind this face: they share glsl/lib and glsl/scene and differ in where they sample
/// and where they store. The frame's block, the media, the lights and the scene's depth are bound
/// while a pass works on it.
class VolumePass {
public:
    explicit VolumePass(const Toolbox& tools) : tools_{tools} {}
    virtual ~VolumePass() = default;
    VolumePass(const VolumePass&) = delete;
    VolumePass& operator=(const VolumePass&) = delete;

    virtual void draw(const PreparedFrame& frame) = 0;

    /// Evaluations of the media that draw() takes, shadows included: r32f, of each ray or froxel.
    virtual gl::Texture sample_counts(const PreparedFrame& frame) = 0;

    /// Draws, at every pixel of the bound framebuffer, which is as large as the frame, what
    /// sample_counts() gave for the ray, or the sum for the column of froxels, that it is in.
    virtual void show_samples(const PreparedFrame& frame, const gl::Texture& counts) = 0;

    /// Draws, likewise, the radiance that a slice of the last draw() adds along a metre of ray
    /// [W/m^2/sr/m], the mean of its channels; nothing where a pass has no slices. INSPECT_BLOCK,
    /// which is bound, says which slice.
    virtual void show_slice(const PreparedFrame& /*frame*/) {}

protected:
    const Toolbox& tools_;
};

}  // namespace fumarole::pass
