#pragma once

#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/lattice.h"
#include "shared/draw_params.h"
#include "shared/sky_map_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>

// How much of the part of the sky that each way of a lattice stands for its nodes see.

namespace fumarole::light {

/// A way sees all or nothing of a gap in a roof: light through it falls along a few directions from
/// node to node, and no lattice is fine enough for that ("ray effects": Lathrop 1968). So the part
/// of the sphere that a way stands for is looked at along several directions. Of each the surfaces
/// are drawn into a parallel depth map, in which every node looks up whether one hides the sky from
/// it.
class SkyShare {
public:
    SkyShare(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}, block_{device, "sky maps"},
          draw_block_{device, "surfaces in sky maps"}
    {
    }

    /// A texel a node and way, in the ways' layout. Draws and looks up unless the last time was for
    /// the same lattice and shapes: media and lights have no part in it. The field's block is bound
    /// with the lattice.
    /// @param ways to where light comes from, unit length
    /// @param box what the maps cover: metres, world
    /// @param size of the ways' layout
    const gl::Texture& shares(const FieldLattice& lattice, const std::vector<glm::dvec3>& ways,
                              const Bounds& box, const surface::SurfaceSet& surfaces,
                              glm::ivec3 size);

private:
    struct Key {
        int shape = 0;
        std::size_t ways = 0;
        glm::dmat4 node_from_eye{1.0};
        glm::dvec3 eye{0};
        glm::ivec3 size{0};
        glm::dvec3 low{0}, high{0};  ///< of the box
        bool operator==(const Key&) const = default;
    };
    void fill(const FieldLattice& lattice, const std::vector<glm::dvec3>& ways, const Bounds& box,
              const surface::SurfaceSet& surfaces);
    void draw(const FieldLattice& lattice, const surface::SurfaceSet& surfaces, int texels);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::SkyMapParams> block_;
    gl::UniformBuffer<shared::DrawParams> draw_block_;
    gl::Framebuffer framebuffer_;
    gl::Texture shares_;
    Key key_;  ///< of shares_
};

}  // namespace fumarole::light
