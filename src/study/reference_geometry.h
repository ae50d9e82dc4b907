#pragma once

#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// The surfaces of a scene, met exactly: spheres and boxes in closed form, meshes through a tree of
// boxes.

namespace fumarole::study {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Ray {
    glm::dvec3 origin{0};
    glm::dvec3 direction{0, 0, 1};  ///< unit length

    [[nodiscard]] glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// Where p + t d is inside a box; empty: x >= y.
glm::dvec2 box_range(const Ray& ray, const Bounds& box);

/// Where a light is, seen from anywhere: a direction to a sun, or a place.
struct LightPlace {
    bool far = false;
    glm::dvec3 at{0};  ///< unit direction to it, or its position

    [[nodiscard]] glm::dvec3 wi(glm::dvec3 p) const { return far ? at : glm::normalize(at - p); }
    [[nodiscard]] double range(glm::dvec3 p) const { return far ? kInfinity : glm::length(at - p); }
};

/// Appends the places on a ray from which the light's way just grazes an edge of the box: there,
/// and nowhere else, what lies behind it in the light's direction changes its course.
void add_box_breaks(const Ray& ray, const Bounds& box, const LightPlace& light,
                    std::vector<double>& breaks);

class SurfaceGloss;

struct SurfaceHit {
    double t = kInfinity;  ///< metres along the ray
    int surface = -1;      ///< index into Scene::surfaces
    int triangle = -1;     ///< triangle of a mesh
    glm::dvec3 p{0};
    glm::dvec3 normal{0};   ///< geometric, unit length, on the ray's side
    glm::dvec3 shading{0};  ///< interpolated where the mesh has normals, on the ray's side
    glm::vec3 albedo{0};
    const SurfaceGloss* gloss = nullptr;  ///< none: Lambertian
    glm::vec3 emission{0};                ///< W/m^2/sr
};

/// A point on a surface, or in space. Rays from it don't meet the surface under it.
struct Origin {
    glm::dvec3 p{0};
    int surface = -1;      ///< a sphere or a box that p lies on, which is convex: never in its way
    glm::dvec3 normal{0};  ///< normal of the mesh that p lies on; p was moved along it already
};

class ReferenceSurfaces {
public:
    explicit ReferenceSurfaces(const std::vector<Surface>& surfaces);
    ~ReferenceSurfaces();
    ReferenceSurfaces(ReferenceSurfaces&&) noexcept;
    ReferenceSurfaces& operator=(ReferenceSurfaces&&) noexcept;

    [[nodiscard]] bool empty() const { return shapes_.empty(); }

    /// The first surface met between `begin` and `end` metres.
    [[nodiscard]] std::optional<SurfaceHit> intersect(const Ray& ray, double begin,
                                                      double end) const;

    /// Whether anything is met within `range` metres of an origin. A point inside a sphere or a box
    /// is hidden from everything outside it.
    [[nodiscard]] bool hidden(const Origin& from, glm::dvec3 wi, double range) const;

    /// Metres from an origin to what hides all that is behind it, as `hidden` sees it; kInfinity if
    /// nothing does.
    [[nodiscard]] double distance(const Origin& from, glm::dvec3 wi) const;

    /// What is there, at the distance that `distance` gives; none at kInfinity. Of a point inside a
    /// sphere or a box it has no normal: nothing comes from there.
    [[nodiscard]] std::optional<SurfaceHit> meet(const Origin& from, glm::dvec3 wi) const;

    [[nodiscard]] Origin leave(const SurfaceHit& hit) const;

    /// Where along a ray, t in [begin, end], a light comes into sight or goes out of it.
    void add_shadow_breaks(const Ray& ray, double begin, double end, const LightPlace& light,
                           std::vector<double>& breaks) const;

private:
    class MeshTree;
    struct Shape {
        int surface = -1;
        Bounds bounds;
        std::shared_ptr<const MeshTree> mesh;
        std::shared_ptr<const SurfaceGloss> gloss;
    };

    /// Fills in what a surface is like where a ray meets it.
    void describe(const Shape& shape, const Ray& ray, glm::dvec2 uv, SurfaceHit& hit) const;

    /// distance(), telling what is there: found(shape, triangle, uv), the last call's being
    /// nearest; no shape where p is inside of one.
    template <class Found>
    [[nodiscard]] double nearest(const Origin& from, glm::dvec3 wi, const Found& found) const;

    const std::vector<Surface>* surfaces_;
    std::vector<Shape> shapes_;
};

}  // namespace fumarole::study
