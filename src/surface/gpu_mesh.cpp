#include "surface/gpu_mesh.h"

#include <vector>

namespace fumarole::surface {

GpuMesh::GpuMesh(const gl::Device& device, const Mesh& mesh, std::string_view label)
    : vertex_array_{device, label}, index_count_{static_cast<GLsizei>(mesh.triangles.size())}
{
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
