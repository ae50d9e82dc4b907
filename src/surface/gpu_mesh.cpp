#include "surface/gpu_mesh.h"

#include <algorithm>
#include <fmt/format.h>
#include <vector>

#include <fumarole/errors.h>

namespace fumarole::surface {

namespace {

/// A host may make meshes of its own, which the CPU reads as well.
void check_mesh(const Mesh& mesh)
{
    if (mesh.normals.size() != mesh.positions.size())
        throw Error(fmt::format("Mesh::normals: {} for {} positions; give one for each",
                                mesh.normals.size(), mesh.positions.size()));
    if (mesh.triangles.size() % 3 != 0)
        throw Error(fmt::format("Mesh::triangles: {} indices; give three for each triangle",
                                mesh.triangles.size()));
    const auto beyond =
        std::find_if(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](std::uint32_t index) { return index >= mesh.positions.size(); });
    if (beyond != mesh.triangles.end())
        throw Error(fmt::format("Mesh::triangles[{}]: {} is none of the {} positions; count them "
                                "from 0",
                                beyond - mesh.triangles.begin(), *beyond, mesh.positions.size()));
}

}  // namespace

GpuMesh::GpuMesh(const gl::Device& device, const Mesh& mesh, std::string_view label)
    : vertex_array_{device, label}, index_count_{static_cast<GLsizei>(mesh.triangles.size())}
{
    check_mesh(mesh);
    std::vector<glm::vec3> vertices;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        vertices.push_back(mesh.positions[i]);
        vertices.push_back(mesh.normals[i]);
        bounds_.add(glm::dvec3(mesh.positions[i]));
    }
    vertices_ = {device, label, vertices.size() * sizeof(glm::vec3), vertices.data()};
    indices_ = {device, label, mesh.triangles.size() * sizeof(std::uint32_t),
                mesh.triangles.data()};

    const GLuint id = vertex_array_.id();
    device->VertexArrayVertexBuffer(id, 0, vertices_.id(), 0, 2 * sizeof(glm::vec3));
    device->VertexArrayElementBuffer(id, indices_.id());
    for (GLuint attribute = 0; attribute < 2; ++attribute) {
        device->EnableVertexArrayAttrib(id, attribute);
        device->VertexArrayAttribFormat(id, attribute, 3, GL_FLOAT, GL_FALSE,
                                        attribute * static_cast<GLuint>(sizeof(glm::vec3)));
        device->VertexArrayAttribBinding(id, attribute, 0);
    }
}

void GpuMesh::draw(const gl::Device& device, int instances) const
{
    device->BindVertexArray(vertex_array_.id());
    device->DrawElementsInstanced(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr, instances);
}

}  // namespace fumarole::surface
