#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "study/reference_geometry.h"
#include <fumarole/scene.h>

// The transparents of a scene, as a ray from the eye meets them, and as they filter light.

namespace fumarole::study {

/// Where a ray meets a transparent.
struct TransparentHit {
    double t = 0;           ///< metres along the ray
    std::size_t index = 0;  ///< index of the transparent in its scene
    glm::dvec4 source{0};   ///< radiance [W/m^2/sr], or what a filter lets through, and alpha
    BlendFactor source_factor = BlendFactor::one;
    BlendFactor destination_factor = BlendFactor::zero;

    /// What of radiance and alpha behind it remains, as factors.
    [[nodiscard]] glm::dvec4 kept(glm::dvec4 behind) const;
    /// Radiance and alpha with it in front of `behind`.
    [[nodiscard]] glm::dvec4 over(glm::dvec4 behind) const;
};

class ReferenceTransparents {
public:
    /// Keeps a reference to `scene`.
    explicit ReferenceTransparents(const Scene& scene);
    ~ReferenceTransparents();
    ReferenceTransparents(const ReferenceTransparents&) = delete;
    ReferenceTransparents& operator=(const ReferenceTransparents&) = delete;

    [[nodiscard]] bool empty() const { return shapes_.empty(); }

    /// From the nearest to the farthest between the camera's near and far plane; of those at one
    /// distance the one that is drawn later is nearer.
    /// @param begin, far metres to the planes @param surface metres to the surface that is seen
    [[nodiscard]] std::vector<TransparentHit> along(const Ray& ray, double begin, double far,
                                                    double surface) const;

    /// Whether any filters light on its way.
    [[nodiscard]] bool casts() const { return casts_; }
    /// What those that cast let through of light that goes `range` metres along a ray, or against
    /// it.
    [[nodiscard]] glm::dvec3 filter(const Ray& ray, double range) const;
    /// The same as a function of the range; none where nothing casts.
    [[nodiscard]] std::function<glm::dvec3(double)> along_way(const Ray& ray) const;
    /// Appends where along a ray, t in [begin, end], other ones lie between there and a light.
    void add_filter_breaks(const Ray& ray, double begin, double end, const LightPlace& light,
                           std::vector<double>& breaks) const;

private:
    /// A parallelogram, or a mesh.
    struct Shape {
        const TransparentLook* look = nullptr;
        glm::dvec3 corner{0}, across{0}, up{0};
        std::unique_ptr<const std::vector<Surface>> mesh;  ///< one; null for a parallelogram
        std::unique_ptr<ReferenceSurfaces> surfaces;
    };

    std::vector<Shape> shapes_;
    bool casts_ = false;
};

}  // namespace fumarole::study
