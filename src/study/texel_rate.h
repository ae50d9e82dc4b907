#pragma once

#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"

namespace fumarole::study {

/// The machine's own rate of trilinear fetches from a volume of 128^3 half floats, neighbours side
/// by side, in fragments or in a compute shader: what a pass of that kind that reads volumes can
/// reach at best. glsl/study/texel_rate.glsl.
class TexelRate {
public:
    TexelRate(const gl::Device& device, bool computes);

    /// Fetches a second, now. Takes about 50 ms where a CPU fetches, less on a GPU.
    double measure();

private:
    /// Milliseconds that so many draws take.
    double time(int draws);

    const gl::Device& device_;
    bool computes_;
    gl::PassTimers timers_;
    gl::Texture volume_, picture_;
    gl::Framebuffer framebuffer_;
    gl::VertexArray fullscreen_;
    gl::Program program_;
    int draws_ = 1;  ///< number of draws that take long enough for the clock
};

}  // namespace fumarole::study
