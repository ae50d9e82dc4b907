#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "study/reference_geometry.h"
#include <fumarole/scene.h>

// Surfaces that emit, as lights.

namespace fumarole::study {

class SurfaceEmitters {
public:
    /// None.
    SurfaceEmitters() = default;
    /// Keeps references to them.
    explicit SurfaceEmitters(const std::vector<Surface>& surfaces);

    [[nodiscard]] bool empty() const { return emitters_.empty(); }

    struct Sample {
        glm::dvec3 wi{0};
        double range = 0;        ///< metres to the surface
        double pdf = 0;          ///< pdf of wi [1/sr]; 0: nothing is there
        glm::dvec3 radiance{0};  ///< W/m^2/sr, if nothing is in between
    };
    /// A direction to one of them, from three numbers in [0, 1).
    [[nodiscard]] Sample sample(glm::dvec3 p, double u, double v, double which) const;

    /// Density with which sample() at p gives the direction to a place on one of them. [1/sr]
    [[nodiscard]] double pdf(glm::dvec3 p, const SurfaceHit& hit) const;

private:
    struct Emitter {
        int surface = -1;
        const Surface* shape = nullptr;
        glm::dvec3 radiance{0};
        double share = 0;               ///< share of the samples
        std::vector<double> triangles;  ///< running areas of a mesh's triangles [m^2]
    };
    [[nodiscard]] Sample of_sphere(const Emitter& emitter, const SphereSurface& sphere,
                                   glm::dvec3 p, double u, double v) const;
    [[nodiscard]] Sample of_box(const Emitter& emitter, const BoxSurface& box, glm::dvec3 p,
                                double u, double v) const;
    [[nodiscard]] Sample of_mesh(const Emitter& emitter, const MeshSurface& mesh, glm::dvec3 p,
                                 double u, double v) const;

    std::vector<Emitter> emitters_;
    std::vector<double> shares_;  ///< running
};

}  // namespace fumarole::study
