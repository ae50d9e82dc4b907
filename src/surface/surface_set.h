#pragma once

#include <optional>
#include <span>
#include <vector>

#include "surface/gpu_mesh.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// The scene's surfaces as triangles on the GPU, to be drawn into a picture or a shadow map.

namespace fumarole::surface {

class SurfaceSet {
public:
    struct Instance {
        int mesh = 0;
        glm::dmat4 world_from_object{1.0};
        glm::vec3 albedo{0};
        std::optional<Gloss> gloss;  ///< none: Lambertian
        glm::vec3 emission{0};       ///< W/m^2/sr
        Bounds bounds;               ///< world
        /// m^2, as it is seen along each axis of the world; 0 if it does not shine.
        glm::vec3 seen_areas{0};
        bool is_box = false;
        bool closed = true;  ///< its back faces close it: a mesh from a file may be open
    };

    explicit SurfaceSet(const gl::Device& device) : device_{device} {}

    /// Uploads what `surfaces` needs and is not there yet.
    void set(const std::vector<Surface>& surfaces);

    [[nodiscard]] std::span<const Instance> instances() const { return instances_; }
    [[nodiscard]] bool empty() const { return instances_.empty(); }
    [[nodiscard]] Bounds bounds() const;
    /// Another number whenever another shape stands somewhere than before.
    [[nodiscard]] int shape() const { return shape_; }
    /// Meshes sent to the GPU so far.
    [[nodiscard]] int uploads() const { return uploads_; }

    /// Vertices that a draw of one instance works out.
    [[nodiscard]] int vertices_drawn(const Instance& instance) const;
    /// Issues the draw of one instance, so many times over; program and state are the caller's.
    enum class Detail { full, coarse, coarsest };
    void draw(const Instance& instance, Detail detail = Detail::full, int times = 1) const;

private:
    struct HeldMesh {
        std::shared_ptr<const Mesh> source;  ///< null for those that come from no file
        GpuMesh gpu;
    };
    HeldMesh upload(const Mesh& mesh, std::string_view label);
    int mesh_index(const std::shared_ptr<const Mesh>& mesh);

    const gl::Device& device_;
    std::vector<HeldMesh> meshes_;
    std::vector<HeldMesh> old_meshes_;  ///< old meshes of the scene before, while set() runs
    std::vector<Instance> instances_;
    /// What stands where: a mesh of a file or the index of another one, and world from object.
    struct Shape {
        std::shared_ptr<const Mesh> source;
        int mesh = 0;
        glm::dmat4 world_from_object{1.0};
        bool operator==(const Shape&) const = default;
    };
    std::vector<Shape> shapes_;
    int shape_ = 0;
    int uploads_ = 0;
};

}  // namespace fumarole::surface
