#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "study/reference_emitters.h"
#include "study/reference_geometry.h"
#include "study/reference_lights.h"
#include "study/reference_media.h"
#include "study/reference_reflection.h"
#include "study/reference_sampling.h"
#include "study/reference_tracking.h"
#include "study/reference_transparents.h"
#include "study/reference_world.h"

// Light that comes to the eye by more than one scattering or reflection, by path tracing: unbiased,
// with an error estimate.

namespace fumarole::study {

/// Which paths count.
struct PathOrders {
    int first = 1;  ///< vertices after vertex 0, least; a glossy vertex 0 has all from 0 on
    int last = std::numeric_limits<int>::max();  ///< scatterings in the media after vertex 0, most
    int surfaces = 0;                            ///< reflections by surfaces after vertex 0, most
    bool media_light = true;                     ///< whether what media emit is a light
};

/// A path goes from the eye to vertex 0, which is a point of the media on the eye's ray or a point
/// of a surface, from there through further scatterings in the media and reflections by surfaces,
/// and ends at a light, at the world or where media or surfaces emit. With no vertex after vertex
/// 0, it counts only where a surface emits, or where vertex 0 is a glossy surface: all others are
/// found by quadrature (reference.h), or by ReferenceWorld.
///
/// Distances by spectral tracking (Kutz et al. 2017, "Spectral and Decomposition Tracking for
/// Rendering Heterogeneous Volumes", sec. 5): one flight serves all channels, real and null
/// collisions being chosen by what they bring to the mean of the path's weights, which therefore
/// never grows. At every scattering each light is asked for (next-event estimation) with the exact
/// optical depth to it; the world is found by paths that escape and, where it is a map, by its own
/// samples too (multiple importance sampling, Veach 1997), surfaces that emit always in both ways,
/// and likewise lights with an area from glossy surfaces.
class ReferencePaths {
public:
    /// Keeps references to all of them.
    ReferencePaths(const ReferenceSurfaces& surfaces, const ReferenceTransparents& transparents,
                   const ReferenceMedia& media, const MediaTracking& tracking,
                   const WorldRadiance& world, const std::vector<ReferenceLight>& lights,
                   const SurfaceEmitters& emitters, PathOrders orders,
                   const std::atomic<bool>* cancel);

    /// Radiance that comes to the eye along a ray from media on it.
    /// @param places on the same ray @param splits metres along it, ascending
    /// @returns what comes from before, between and beyond the splits
    [[nodiscard]] std::vector<Integral> scattered(const Ray& ray, const ScatteringPlaces& places,
                                                  const std::vector<double>& splits,
                                                  std::uint32_t seed,
                                                  const SamplingAccuracy& accuracy) const;

    /// Irradiance of a place on a Lambertian surface [W/m^2].
    [[nodiscard]] Integral irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                      const SamplingAccuracy& accuracy) const;

    /// Radiance that a place on a glossy surface reflects towards wo, but for light that comes
    /// straight from lights without an area.
    [[nodiscard]] Integral reflected(const SurfaceHit& hit, glm::dvec3 wo, std::uint32_t seed,
                                     const SamplingAccuracy& accuracy) const;

private:
    struct Walker;
    struct Vertex;
    /// How a path left its last vertex.
    struct Leg {
        Origin from;
        glm::dvec3 direction{0};
        double pdf = 0;       ///< pdf of the direction [1/sr]
        bool glossy = false;  ///< whether lights with an area are found along it
    };
    /// What a path brings that leaves vertex 0 along a leg, times `weight`.
    /// @param first vertices after vertex 0 from which on light and world count
    [[nodiscard]] glm::dvec3 walk(Walker& walker, const SobolPoint& point, Leg leg,
                                  glm::dvec3 weight, int first) const;
    /// Light that comes to a vertex straight from the lights, from surfaces that emit and, if it is
    /// a map, from the world, and is sent on by it.
    [[nodiscard]] glm::dvec3 direct(const Vertex& vertex, Random& random) const;
    [[nodiscard]] glm::dvec3 from_light(const ReferenceLight& light, const Vertex& vertex,
                                        Random& random) const;
    [[nodiscard]] glm::dvec3 from_area(const ReferenceLight& light, const Vertex& vertex,
                                       Random& random) const;
    [[nodiscard]] glm::dvec3 from_map(const Vertex& vertex, Random& random) const;
    [[nodiscard]] glm::dvec3 from_emitters(const Vertex& vertex, Random& random) const;
    /// Of lights with an area on a ray, what was not found by from_area at its origin.
    [[nodiscard]] glm::dvec3 met_lights(const Leg& leg, double range, Random& random) const;
    /// What media and transparents let through.
    [[nodiscard]] glm::dvec3 transmittance(const Ray& ray, double range, Random& random) const;
    void check_cancel() const;

    const ReferenceSurfaces& surfaces_;
    const ReferenceTransparents& transparents_;
    const ReferenceMedia& media_;
    const MediaTracking& tracking_;
    const WorldRadiance& world_;
    const std::vector<ReferenceLight>& lights_;
    const SurfaceEmitters& emitters_;
    PathOrders orders_;
    bool emits_, world_lights_;
    const std::atomic<bool>* cancel_;
};

}  // namespace fumarole::study
