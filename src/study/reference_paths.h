#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "study/reference_geometry.h"
#include "study/reference_lights.h"
#include "study/reference_media.h"
#include "study/reference_sampling.h"
#include "study/reference_tracking.h"
#include "study/reference_world.h"

// Light that the media scatter more than once, by path tracing: unbiased, with an error estimate.

namespace fumarole::study {

/// Which paths count: those with this many scatterings in the media after vertex 0.
struct PathOrders {
    int first = 1;
    int last = std::numeric_limits<int>::max();
};

/// A path goes from the eye to vertex 0, which is a point of the media on the eye's ray or a point
/// of a surface, from there through further scatterings in the media, and ends at a light, at the
/// world or where media emit. Surfaces end a path: what they reflect into the media is not part.
///
/// Distances by spectral tracking (Kutz et al. 2017, "Spectral and Decomposition Tracking for
/// Rendering Heterogeneous Volumes", sec. 5): one flight serves all channels, real and null
/// collisions being chosen by what they bring to the mean of the path's weights, which therefore
/// never grows. At every scattering each light is asked for (next-event estimation) with the exact
/// optical depth to it; the world is found by paths that escape and, where it is a map, by its own
/// samples too (multiple importance sampling, Veach 1997).
class ReferencePaths {
public:
    /// Keeps references to all of them.
    ReferencePaths(const ReferenceSurfaces& surfaces, const ReferenceMedia& media,
                   const MediaTracking& tracking, const WorldRadiance& world,
                   const std::vector<ReferenceLight>& lights, PathOrders orders,
                   const std::atomic<bool>* cancel);

    /// Radiance that comes to the eye along a ray from media on it.
    /// @param places on the same ray @param splits metres along it, ascending
    /// @returns what comes from before, between and beyond the splits
    [[nodiscard]] std::vector<Integral> scattered(const Ray& ray, const ScatteringPlaces& places,
                                                  const std::vector<double>& splits,
                                                  std::uint32_t seed,
                                                  const SamplingAccuracy& accuracy) const;

    /// Irradiance of a place on a surface [W/m^2].
    [[nodiscard]] Integral irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                      const SamplingAccuracy& accuracy) const;

private:
    struct Walker;
    /// What a path brings that leaves vertex 0 in a direction, times `weight`.
    /// @param phase with which the direction was chosen, or below 0 if the world's map was not
    /// asked for by samples of its own at vertex 0
    [[nodiscard]] glm::dvec3 walk(Walker& walker, const SobolPoint& point, Origin from,
                                  glm::dvec3 direction, double phase, glm::dvec3 weight) const;
    /// Light that comes straight from the lights, and from the world if it is a map, and is
    /// scattered at p.
    [[nodiscard]] glm::dvec3 direct(glm::dvec3 p, glm::dvec3 wo, double g, Random& random) const;
    /// A light's irradiance times the phase at p.
    [[nodiscard]] glm::dvec3 from_light(const ReferenceLight& light, glm::dvec3 p, glm::dvec3 wo,
                                        double g, Random& random) const;
    void check_cancel() const;

    const ReferenceSurfaces& surfaces_;
    const ReferenceMedia& media_;
    const MediaTracking& tracking_;
    const WorldRadiance& world_;
    const std::vector<ReferenceLight>& lights_;
    PathOrders orders_;
    bool emits_, world_lights_;
    const std::atomic<bool>* cancel_;
};

}  // namespace fumarole::study
