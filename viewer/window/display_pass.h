#pragma once

#include <glm/glm.hpp>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "shared/display_params.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::window {

/// A picture and how it is shown. Linear, rows from the bottom; alpha 0 where nothing is yet.
struct Shown {
    const gl::Texture* picture = nullptr;
    Display display;
};

enum class Comparison { none, split, difference };

/// What pictures are laid over the window's own framebuffer, and where.
struct DisplayRequest {
    glm::ivec2 lower_left{0}, size{0};  ///< pixels of the framebuffer
    Shown a, b;                         ///< b only where something is compared
    Comparison comparison = Comparison::none;
    double wipe = 0.5;  ///< where b begins in a split screen, 0..1 of the width
    double scale = 1;   ///< difference at the end of the colours
    double tenth_of_mean_square =
        0;  ///< tenth of b's mean square, which difference_map() adds under its root
};

class DisplayPass {
public:
    explicit DisplayPass(const gl::Device& device);
    void draw(const DisplayRequest& request);

private:
    const gl::Device& device_;
    gl::ProgramCache programs_;
    gl::VertexArray fullscreen_;
    gl::UniformBuffer<shared::DisplayParams> block_;
};

}  // namespace fumarole::window
