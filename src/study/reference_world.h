#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "study/reference_geometry.h"
#include "study/reference_media.h"
#include "study/reference_sampling.h"
#include "study/reference_tracking.h"
#include "study/reference_transparents.h"
#include <fumarole/scene.h>

// The world's light and that which media emit: from all directions, dimmed by the media, hidden by
// surfaces, filtered by transparents that cast.

namespace fumarole::study {

/// The world as the eye would see it.
class WorldRadiance {
public:
    explicit WorldRadiance(const World& world);

    [[nodiscard]] glm::dvec3 operator()(glm::dvec3 direction) const;
    [[nodiscard]] bool black() const { return mean_ == glm::dvec3(0); }
    [[nodiscard]] glm::dvec3 mean() const { return mean_; }
    /// About the most that one of its samples finds, over the mean of phase or cosine: they go by
    /// sample() and by a phase or a cosine in equal parts, without a map by the latter alone.
    [[nodiscard]] double bound() const;

    /// Whether some directions are better looked at than others.
    [[nodiscard]] bool is_map() const { return map_ != nullptr; }
    /// A direction, from two numbers in [0, 1), where a map has its light; pdf() in 1/sr.
    [[nodiscard]] glm::dvec3 sample(double u, double v) const;
    [[nodiscard]] double pdf(glm::dvec3 direction) const;

private:
    [[nodiscard]] glm::dvec3 texel(int x, int y) const;  ///< x comes round, y is held
    [[nodiscard]] double solid_angle(int y) const;       ///< solid angle of a texel of row y
    /// A direction's place in the map, in texels.
    [[nodiscard]] glm::dvec2 place(glm::dvec3 direction) const;

    glm::dvec3 constant_{0}, mean_{0};
    const Environment* map_ = nullptr;
    double scale_ = 1;
    std::vector<double> rows_, columns_;  ///< running shares of the light: of rows, and in each
};

/// Irradiance of a place on a surface from the world [W/m^2].
struct WorldIrradiance {
    glm::dvec3 clear{0};  ///< as if there were no media
    glm::dvec3 lit{0};    ///< through the media
    double error = 0;     ///< estimated, of the largest channel
    glm::dvec3 noise{0};  ///< noise of `lit`, as Integral's
};

class ReferenceWorld {
public:
    /// @param opaque optical depth through which nothing counts
    /// @param emission_lights whether what media emit is a light too
    ReferenceWorld(const Scene& scene, const ReferenceSurfaces& surfaces,
                   const ReferenceTransparents& transparents, const ReferenceMedia& media,
                   const MediaTracking& tracking, double opaque, bool emission_lights,
                   const std::atomic<bool>* cancel);

    [[nodiscard]] const WorldRadiance& radiance() const { return radiance_; }

    /// Whether neither the world nor a medium sends any light.
    [[nodiscard]] bool black() const { return radiance_.black() && !emits_; }

    /// @param seed the same one asks the same directions
    [[nodiscard]] WorldIrradiance irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                             const SamplingAccuracy& accuracy) const;

    /// What a ray brings to the eye of the world's light, scattered once on its way through media.
    /// @param places on the same ray @param splits metres along it, ascending
    /// @returns what comes from before, between and beyond the splits
    [[nodiscard]] std::vector<Integral> scattered(const Ray& ray, const ScatteringPlaces& places,
                                                  const std::vector<double>& splits,
                                                  std::uint32_t seed,
                                                  const SamplingAccuracy& accuracy) const;

    /// Integral over wi of phase(wi, wo, g) * radiance arriving at p from wi.
    [[nodiscard]] Integral in_scattering(glm::dvec3 p, glm::dvec3 wo, double g, std::uint32_t seed,
                                         const SamplingAccuracy& accuracy) const;

private:
    /// Radiance at a place from wi, of the world and of what media emit on the way; `clear` as if
    /// there were no media.
    [[nodiscard]] glm::dvec3 arriving(const Origin& from, glm::dvec3 wi, const SobolPoint& u,
                                      glm::dvec3& clear) const;
    /// @param scale the most that a direction's radiance is multiplied by, chosen by phase or
    /// cosine
    [[nodiscard]] SamplingAccuracy bounded(SamplingAccuracy accuracy, double scale) const;
    /// phase * arriving / pdf for one direction, chosen by the point's first three numbers.
    [[nodiscard]] glm::dvec3 one_direction(glm::dvec3 p, glm::dvec3 wo, double g,
                                           const SobolPoint& u) const;
    void check_cancel() const;

    const ReferenceSurfaces& surfaces_;
    const ReferenceTransparents& transparents_;
    const ReferenceMedia& media_;
    const MediaTracking& tracking_;
    const std::atomic<bool>* cancel_;
    WorldRadiance radiance_;
    double bound_;
    double opaque_;
    bool emits_;
};

}  // namespace fumarole::study
