#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "gl/program.h"
#include "gl/texture.h"
#include "medium/media_set.h"
#include "shared/light_volume_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>

// What surfaces have of the light that media emit: of fires that are too large to be lights.

namespace fumarole::light {

/// Light that media emit, at nodes near surfaces. Each node has the integral of all that arrives,
/// as if no surface stood in the way, and that of the way that it comes along: a surface before
/// which all of the fire lies has just what the latter tells, whatever the fire's form. The nodes
/// stand the farther apart the farther they are from what glows. What surfaces hide is kept apart,
/// at the nodes of their lattice.
class FireLight {
public:
    FireLight(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}
    {
    }

    /// Takes up what glows.
    /// @param around metres, world: where nodes are to be
    /// @param voxel edge of the voxels of what glows [m]
    /// @param color of what dims, if all of it has one
    void place(const medium::MediaSet::CarriedGlow& glow, const Bounds& media, const Bounds& around,
               double voxel, const std::optional<glm::vec3>& color);
    /// Works it out. The media are bound for `eye`, as is the block with params() for it.
    /// @param media_defines theirs
    void fill(const gl::Defines& media_defines, const surface::SurfaceSet& surfaces);
    /// What surfaces hide is to be drawn here: two numbers a node of their lattice.
    [[nodiscard]] const gl::Texture& make_seen(glm::ivec3 nodes);
    void clear();
    /// All of it, with media and surfaces.
    /// @param corner metres, world: of where nodes were placed around, as it lies now
    void move_to(glm::dvec3 corner);

    [[nodiscard]] bool is_filled() const { return static_cast<bool>(light_); }
    /// For an eye at `eye` [m, world].
    [[nodiscard]] shared::FireParams params(glm::dvec3 eye) const;
    /// Samples of the media along an edge of a cell.
    [[nodiscard]] int samples() const { return samples_; }
    void bind() const;

private:
    [[nodiscard]] glm::dvec3 node_of(glm::dvec3 p) const;
    [[nodiscard]] gl::Texture nodes_near(const surface::SurfaceSet& surfaces) const;
    [[nodiscard]] glm::dvec3 place_of(glm::dvec3 node) const;
    /// What is seen of the fire from there, 0 to 1; nothing inside of a surface.
    [[nodiscard]] std::optional<double> seen_from(glm::dvec3 p,
                                                  const surface::SurfaceSet& surfaces) const;
    void dispatch(const char* file, const gl::Defines& defines, glm::ivec3 groups) const;

    /// A box of nodes along the world's axes.
    struct Box {
        Bounds bounds;
        glm::ivec3 count{2};
    };
    [[nodiscard]] int most_cells() const;
    static Box make_box(const Bounds& bounds, int most);
    static shared::LatticeParams to_shared(const Box& box, glm::dvec3 eye);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    Box flame_, media_;
    glm::dvec3 corner_{0}, middle_{0}, core_{1}, first_{0};
    double node_ = 1, growth_ = 1;
    glm::ivec3 count_{2};
    Bounds known_;  ///< where the surfaces' lattice tells what is seen [m, world]
    int samples_ = 2;
    std::optional<glm::vec3> color_;
    std::vector<glm::dvec3> points_;
    gl::Texture light_, seen_;
};

}  // namespace fumarole::light
