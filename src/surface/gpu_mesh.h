#pragma once

#include <string_view>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

namespace fumarole::surface {

/// A mesh's triangles on the GPU: positions at attribute 0, normals at 1.
class GpuMesh {
public:
    GpuMesh() = default;
    /// @throws Error if its triangles and normals don't go with its positions
    GpuMesh(const gl::Device& device, const Mesh& mesh, std::string_view label);

    /// Issues its draw, of so many instances; program and state are the caller's.
    void draw(const gl::Device& device, int instances = 1) const;

    [[nodiscard]] int indices() const { return index_count_; }
    [[nodiscard]] const Bounds& bounds() const { return bounds_; }

private:
    gl::Buffer vertices_, indices_;
    gl::VertexArray vertex_array_;
    GLsizei index_count_ = 0;
    Bounds bounds_;  ///< object space
};

}  // namespace fumarole::surface
