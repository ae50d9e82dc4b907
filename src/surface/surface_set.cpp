#include "surface/surface_set.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>
#include <numbers>
#include <utility>

namespace fumarole::surface {

namespace {

constexpr int kSphereMesh = 0;
constexpr int kCubeMesh = 1;
constexpr int kCoarseSphereMesh = 2;
constexpr int kCoarsestSphereMesh = 3;
constexpr int kOwnMeshes = 4;  ///< those of files come after them

/// Of the unit sphere. A chord of 1/128 of a turn dips 3e-4 of the radius below the sphere: under a
/// tenth of a pixel for a ball that fills a 480-pixel picture; one of 1/32 dips 5e-3, under a
/// tenth of a node of the volumes of light, as one of 1/16 with 2e-2 does of a ball of few nodes.
constexpr int kAroundSphere = 128, kAroundCoarseSphere = 32, kAroundCoarsestSphere = 16;

Mesh unit_sphere(int around)
{
    const int down = around / 2;
    const double turn = 2 * std::numbers::pi / around;
    const double radius = std::sqrt(turn / std::sin(turn));  // throws a ball's shadow
    Mesh mesh;
    for (int j = 0; j <= down; ++j) {
        for (int i = 0; i <= around; ++i) {
            const double theta = std::numbers::pi * j / down;
            const double phi = 2 * std::numbers::pi * i / around;
            mesh.normals.emplace_back(std::sin(theta) * std::cos(phi),
                                      std::sin(theta) * std::sin(phi), std::cos(theta));
        }
    }
    mesh.positions = mesh.normals;
    if (around != kAroundSphere)
        for (auto& position : mesh.positions)
            position *= static_cast<float>(radius);
    const auto a_row = static_cast<std::uint32_t>(around) + 1;
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(down); ++j) {
        for (std::uint32_t i = 0; i + 1 < a_row; ++i) {
            const std::uint32_t a = j * a_row + i;
            const std::uint32_t b = a + a_row;
            mesh.triangles.insert(mesh.triangles.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    }
    return mesh;
}

/// The cube 0..1, its faces counter-clockwise from outside.
Mesh unit_cube()
{
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            const auto first = static_cast<std::uint32_t>(mesh.positions.size());
            for (int i = 0; i < 4; ++i) {
                glm::vec3 p;
                p[axis] = static_cast<float>(side);
                p[(axis + 1) % 3] = static_cast<float>(i & 1);
                p[(axis + 2) % 3] = static_cast<float>(i >> 1);
                mesh.positions.push_back(p);
                glm::vec3 n(0);
                n[axis] = side == 1 ? 1.0f : -1.0f;
                mesh.normals.push_back(n);
            }
            if (side == 1)
                mesh.triangles.insert(mesh.triangles.end(), {first, first + 1, first + 2, first + 2,
                                                             first + 1, first + 3});
            else
                mesh.triangles.insert(mesh.triangles.end(), {first, first + 2, first + 1, first + 1,
                                                             first + 2, first + 3});
        }
    }
    return mesh;
}

/// Of a closed mesh half of what its triangles have along an axis, since as many are seen from the
/// back; of an open one all, whose both sides shine. [m^2]
glm::dvec3 seen_areas(const Mesh& mesh)
{
    glm::dvec3 sum(0), outward(0);
    for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
        const glm::dvec3 a(mesh.positions[mesh.triangles[i]]),
            b(mesh.positions[mesh.triangles[i + 1]]), c(mesh.positions[mesh.triangles[i + 2]]);
        const glm::dvec3 area = glm::cross(b - a, c - a) / 2.0;
        sum += glm::abs(area);
        outward += area;
    }
    const bool is_closed = glm::length(outward) < 1e-3 * glm::length(sum);
    return is_closed ? sum / 2.0 : sum;
}

glm::dvec3 seen_areas(const Surface& surface)
{
    if (const auto* sphere = std::get_if<SphereSurface>(&surface))
        return glm::dvec3(std::numbers::pi * sphere->radius * sphere->radius);
    if (const auto* box = std::get_if<BoxSurface>(&surface)) {
        const glm::dvec3 size = box->max - box->min;
        return {size.y * size.z, size.z * size.x, size.x * size.y};
    }
    const auto& mesh = std::get<MeshSurface>(surface);
    return mesh.scale * mesh.scale * seen_areas(*mesh.mesh);
}

glm::dmat4 place(glm::dvec3 translate, glm::dvec3 scale)
{
    return glm::scale(glm::translate(glm::dmat4(1.0), translate), scale);
}

}  // namespace

SurfaceSet::HeldMesh SurfaceSet::upload(const Mesh& mesh, std::string_view label)
{
    ++uploads_;
    return {nullptr, GpuMesh(device_, mesh, label)};
}

int SurfaceSet::mesh_index(const std::shared_ptr<const Mesh>& mesh)
{
    for (std::size_t i = kOwnMeshes; i < meshes_.size(); ++i)
        if (meshes_[i].source == mesh)
            return static_cast<int>(i);
    const auto old = std::find_if(old_meshes_.begin(), old_meshes_.end(),
                                  [&](const HeldMesh& m) { return m.source == mesh; });
    if (old != old_meshes_.end()) {
        meshes_.push_back(std::move(*old));
        old_meshes_.erase(old);
    } else {
        meshes_.push_back(upload(*mesh, "mesh"));
        meshes_.back().source = mesh;
    }
    return static_cast<int>(meshes_.size()) - 1;
}

void SurfaceSet::set(const std::vector<Surface>& surfaces)
{
    instances_.clear();
    const std::vector<Shape> old_shapes = std::exchange(shapes_, {});
    if (surfaces.empty()) {
        meshes_.clear();
        return;
    }
    if (meshes_.empty()) {
        meshes_.push_back(upload(unit_sphere(kAroundSphere), "unit sphere"));
        meshes_.push_back(upload(unit_cube(), "unit cube"));
        meshes_.push_back(upload(unit_sphere(kAroundCoarseSphere), "coarse unit sphere"));
        meshes_.push_back(upload(unit_sphere(kAroundCoarsestSphere), "coarsest unit sphere"));
    }
    // Meshes that no surface names any more go with old_meshes_.
    old_meshes_.assign(std::make_move_iterator(meshes_.begin() + kOwnMeshes),
                       std::make_move_iterator(meshes_.end()));
    meshes_.resize(kOwnMeshes);
    for (const Surface& surface : surfaces) {
        Instance instance;
        if (const auto* sphere = std::get_if<SphereSurface>(&surface)) {
            instance.mesh = kSphereMesh;
            instance.world_from_object = place(sphere->center, glm::dvec3(sphere->radius));
        } else if (const auto* box = std::get_if<BoxSurface>(&surface)) {
            instance.mesh = kCubeMesh;
            instance.is_box = true;
            instance.world_from_object = place(box->min, box->max - box->min);
        } else if (const auto* mesh = std::get_if<MeshSurface>(&surface); mesh->mesh != nullptr) {
            instance.mesh = mesh_index(mesh->mesh);
            instance.world_from_object = place(mesh->translate, glm::dvec3(mesh->scale));
            instance.closed = false;
        } else {
            continue;
        }
        std::visit(
            [&](const auto& one) {
                instance.albedo = one.albedo;
                instance.gloss = one.gloss;
                instance.emission = one.emission;
            },
            surface);
        instance.bounds = meshes_[static_cast<std::size_t>(instance.mesh)].gpu.bounds().transformed(
            instance.world_from_object);
        if (instance.emission != glm::vec3(0))
            instance.seen_areas = glm::vec3(seen_areas(surface));
        instances_.push_back(instance);
        const HeldMesh& held = meshes_[static_cast<std::size_t>(instance.mesh)];
        shapes_.push_back(
            {held.source, held.source ? 0 : instance.mesh, instance.world_from_object});
    }
    old_meshes_.clear();
    if (shapes_ != old_shapes)
        ++shape_;
}

Bounds SurfaceSet::bounds() const
{
    Bounds all;
    for (const Instance& instance : instances_)
        all.add(instance.bounds);
    return all;
}

int SurfaceSet::vertices_drawn(const Instance& instance) const
{
    return meshes_[static_cast<std::size_t>(instance.mesh)].gpu.indices();
}

void SurfaceSet::draw(const Instance& instance, Detail detail, int times) const
{
    int mesh = instance.mesh;
    if (mesh == kSphereMesh && detail != Detail::full)
        mesh = detail == Detail::coarse ? kCoarseSphereMesh : kCoarsestSphereMesh;
    meshes_[static_cast<std::size_t>(mesh)].gpu.draw(device_, times);
}

}  // namespace fumarole::surface
