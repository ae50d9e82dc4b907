#pragma once

#include <vector>

#include "gl/program.h"
#include "gl/texture.h"
#include "pass/volume_pass.h"

namespace fumarole::pass {

/// What of the picture and of the view's depth can hold a medium, tile by tile: the bricks that are
/// not empty, projected. Worked out on the CPU for each frame, so that no ray looks for them; a
/// tile that none of them reaches costs no fragment.
class StepTiles {
public:
    /// Texels of the layer, and pixels of the picture, along a tile's edge.
    static constexpr int kLayerTile = 8, kPictureTile = 16;

    explicit StepTiles(const Toolbox& tools) : tools_{tools} {}

    /// For the frame's camera; all tiles and all depths where bricks are not to be skipped.
    void set(const PassFrame& frame);

    /// Draws a fragment shader over the texels that march, over those whose depth is asked for, or
    /// over the pixels that see a medium. The framebuffer is bound; its viewport is changed.
    void draw_march(const char* fragment_file, gl::Defines defines) const;
    void draw_depth(const char* fragment_file, gl::Defines defines) const;
    void draw_picture(const char* fragment_file, gl::Defines defines) const;

private:
    /// One texel a tile: view_z of the first and the last medium [m], stride of steps, 1 if drawn.
    /// While they are worked out: the longest step [m] for the stride.
    struct Tiles {
        glm::ivec2 count{0};
        std::vector<glm::vec4> texels;
        gl::Texture texture;
    };
    void project(const PassFrame& frame);
    [[nodiscard]] int stride(const PassFrame& frame, const glm::vec4& tile) const;
    void upload(const char* label, Tiles& tiles) const;
    void draw(const Tiles& tiles, int pixels, const char* fragment_file, gl::Defines defines) const;

    const Toolbox& tools_;
    Tiles march_, depth_, picture_;
};

}  // namespace fumarole::pass
