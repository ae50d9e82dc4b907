#pragma once

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "toolbox.h"

namespace fumarole::pass {

/// Some of the tiles of a picture, as the GPU lists them for compute passes, which it dispatches by
/// their number without the CPU's knowing it: glsl/pass/list_tiles.comp,
/// glsl/pass/listed_texel.glsl.
class TileList {
public:
    /// Lists those of a texture of tiles that hold something. What reads it needs let_read() first.
    /// @param variant which of them, and their size
    void fill(const Toolbox& tools, const gl::Texture& tiles, const gl::Defines& variant);
    /// For all lists that were filled since.
    static void let_read(const Toolbox& tools);

    /// Dispatches the compute program that is in use: a work group for TILE_GROUP texels.
    void dispatch(const Toolbox& tools) const;

private:
    gl::Buffer buffer_;  ///< shared::TileListHead, then the tiles of each class
};

}  // namespace fumarole::pass
