#include "light/lattice.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

#include "medium/media_set.h"

namespace fumarole::light {

Lattice make_lattice(const glm::dmat4& unit_from_world, const Bounds& bounds, double spacing,
                     int most)
{
    const glm::dvec3 extent = glm::max(bounds.max - bounds.min, glm::dvec3(1e-12));
    const double longest = std::max({extent.x, extent.y, extent.z});
    spacing = std::max(spacing, longest / (most - 1));
    Lattice lattice;
    lattice.count = glm::max(glm::ivec3(glm::ceil(extent / spacing - 1e-6)) + 1, glm::ivec3(2));
    lattice.node_from_world = glm::scale(glm::dmat4(1.0), glm::dvec3(lattice.count - 1) / extent) *
                              glm::translate(glm::dmat4(1.0), -bounds.min) * unit_from_world;
    return lattice;
}

Lattice make_cubes(const glm::dmat4& unit_from_world, const Bounds& bounds, double spacing,
                   int most)
{
    constexpr double kNearly = 1.2;
    const Lattice lattice = make_lattice(unit_from_world, bounds, spacing, most);
    const glm::dmat4 world_from_node = glm::inverse(lattice.node_from_world);
    glm::dvec3 edges(0);
    for (int i = 0; i < 3; ++i)
        edges[i] = glm::length(glm::dvec3(world_from_node[i]));
    const double edge = std::max({edges.x, edges.y, edges.z});
    if (edge > kNearly * std::min({edges.x, edges.y, edges.z}))
        return lattice;
    const glm::dvec3 middle = glm::dvec3(lattice.count - 1) / 2.0;
    Lattice cubes = lattice;
    cubes.node_from_world = glm::translate(glm::dmat4(1.0), middle) *
                            glm::scale(glm::dmat4(1.0), edges / edge) *
                            glm::translate(glm::dmat4(1.0), -middle) * lattice.node_from_world;
    return cubes;
}

Lattice coarser(const Lattice& fine, int most)
{
    const glm::dvec3 last(fine.count - 1);
    const double step = std::max({last.x, last.y, last.z}) / (most - 1);
    Lattice lattice;
    lattice.count = glm::max(glm::ivec3(glm::ceil(last / step - 1e-6)) + 1, glm::ivec3(2));
    lattice.node_from_world = glm::translate(glm::dmat4(1.0), glm::dvec3(lattice.count - 1) / 2.0) *
                              glm::scale(glm::dmat4(1.0), glm::dvec3(1 / step)) *
                              glm::translate(glm::dmat4(1.0), -last / 2.0) * fine.node_from_world;
    return lattice;
}

Bounds bounds_of(const Lattice& lattice)
{
    Bounds nodes;
    nodes.add(glm::dvec3(0));
    nodes.add(glm::dvec3(lattice.count - 1));
    return nodes.transformed(glm::inverse(lattice.node_from_world));
}

glm::dvec3 centre_of(const Lattice& lattice)
{
    return glm::dvec3(glm::inverse(lattice.node_from_world) *
                      glm::dvec4(glm::dvec3(lattice.count - 1) / 2.0, 1.0));
}

shared::LatticeParams to_shared(const Lattice& lattice, int layers, glm::dvec3 eye)
{
    const glm::dmat4 node_from_eye = lattice.node_from_world * glm::translate(glm::dmat4(1.0), eye);
    shared::LatticeParams out{};
    out.node_from_world = glm::mat4(node_from_eye);
    out.world_from_node = glm::mat4(glm::inverse(node_from_eye));
    out.last = glm::vec3(lattice.count - 1);
    out.layers = static_cast<float>(layers);
    out.inverse_size = 1.0f / glm::vec3(lattice.count * glm::ivec3(1, 1, layers));
    out.spacing = static_cast<float>(1 / glm::length(glm::dvec3(node_from_eye[0])));
    return out;
}

int clamp_to(int nodes, int layers, const gl::Device& gl)
{
    return std::max(2, std::min(nodes, gl.capabilities().max_texture_3d / layers));
}

gl::Texture make_volume(const gl::Device& gl, const char* label, const Lattice& lattice, int layers,
                        GLenum format)
{
    return gl::Texture::make_3d(gl, label, lattice.count * glm::ivec3(1, 1, layers), format,
                                gl::Filter::linear);
}

void copy_layer(const gl::Device& gl, const gl::Texture& from, int from_layer,
                const gl::Texture& to, int to_layer, glm::ivec3 nodes)
{
    gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);  // after the stores that filled it
    gl->CopyImageSubData(from.id(), GL_TEXTURE_3D, 0, 0, 0, from_layer * nodes.z, to.id(),
                         GL_TEXTURE_3D, 0, 0, 0, to_layer * nodes.z, nodes.x, nodes.y, nodes.z);
}

LatticePlace place_of(const Lattice& lattice)
{
    const glm::dmat4 world_from_node = glm::inverse(lattice.node_from_world);
    return {glm::dvec3(world_from_node[3]), glm::dmat3(world_from_node), lattice.count};
}

double spacing_of(const LatticePlace& place)
{
    return std::min(
        {glm::length(place.edges[0]), glm::length(place.edges[1]), glm::length(place.edges[2])});
}

bool is_moved(const LatticePlace& then, const LatticePlace& now)
{
    const double tolerance = tolerance_of(now) + 1e-14 * glm::length(now.origin);
    for (int axis = 0; axis < 3; ++axis)
        if (!medium::is_same_place(then.edges[axis] * double(then.count[axis]),
                                   now.edges[axis] * double(now.count[axis]), tolerance))
            return false;
    return then.count == now.count;
}

}  // namespace fumarole::light
