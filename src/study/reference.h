#pragma once

#include <algorithm>
#include <atomic>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

#include <fumarole/scene.h>
#include <fumarole/scene_renderer.h>

// The reference: what a scene looks like, as exactly as asked. Direct light of every light, of the
// world and of what media emit, dimmed by the media and hidden by surfaces on its way, scattered
// once by the media or by the surface that is seen; emission; transmittance; and, with bounces,
// light that the media scatter and the surfaces reflect further. On the CPU, in double precision,
// sharing nothing with the passes on the GPU but the scene.
//
// A path goes from the eye to vertex 0, a point of the media on the eye's ray or the first surface
// seen, and from there through further vertices to a light, to the world, or to a medium or a
// surface that emits. Each further vertex is a scattering in the media, of which there may be up to
// `bounces`, or a reflection by a surface, of which there may be up to `surface_bounces`, in any
// order: a path counts if neither number is exceeded, and where both are kAllBounces, all do. So
// with no surface bounces a surface blocks paths, and a mirror shows the world, and dimmed by the
// media what lights it; other surfaces are seen in it from 1 surface bounce on, smoke from 1 bounce
// on. Lights and emission that come straight to vertex 0 are there whatever the numbers.
//
// With vertex 0 alone: lights by adaptive quadrature along the ray, the world and what media emit
// by quasi-Monte Carlo over directions. All other paths, and all but lights without an area from a
// glossy vertex 0, come from a path tracer (reference_paths.h).

namespace fumarole::study {

using ReferenceRegion = PictureRegion;

struct ReferenceStill;
struct PartialReference;

/// Bounces without a limit.
constexpr int kAllBounces = std::numeric_limits<int>::max();

/// As 0 bounces, and what media emit lights nothing: what a renderer does that has no field of
/// light.
constexpr int kLampsAndWorldOnce = -1;
/// The bounces of the truth that the chart, the plan, `compare` and the bench measure against, and
/// that the window shows, where a user does not ask for light that scatters once: 0.
constexpr int kMeasuredBounces = kAllBounces;
/// Likewise of surfaces: all where a picture of the scene has light that they send on if its
/// settings say nothing of it, else 0.
int measured_surface_bounces(const Scene& scene);

/// A truth that pictures are measured against for as long as a person waits: light that scatters
/// once is integrated, light that scatters on is sampled, and what noise is left is known and taken
/// off (noise_relmse in metrics.h).
/// @param bounces of either kind, whichever are more
constexpr double usual_tolerance(int bounces)
{
    return bounces > 0 ? 0.2 : 0.01;
}

struct ReferenceOptions {
    int bounces = 0;          ///< scatterings in the media after the first one, 0 to kAllBounces,
                              ///< or kLampsAndWorldOnce
    int surface_bounces = 0;  ///< reflections by surfaces after vertex 0, 0 to kAllBounces
    [[nodiscard]] int most_bounces() const { return std::max(bounces, surface_bounces); }
    double tolerance = 1e-3;  ///< tolerance of each pixel, relative; as relMSE counts it where dark
    int aa = 1;               ///< samples of a pixel's square, at subpixel_offset(i)
    std::optional<ReferenceRegion> region;
    std::function<void(double)> progress;  ///< share of pixels done, 0..1; one call at a time
    /// What is there so far, and which part of it is new; one call at a time.
    std::function<void(const ReferenceRegion&, const ReferenceStill&)> on_tile;
    /// Pixels that an earlier run finished, of the same scene, options and region: they are taken
    /// as they are. Null: none.
    const PartialReference* begun = nullptr;
    /// Is told after every pixel, and with `last` once more if an error or `cancel` ends the work;
    /// one call at a time, while other pixels are worked on. `finished` tells of each pixel
    /// whether it is: no others may be read.
    std::function<void(const ReferenceStill&, const std::function<std::vector<char>()>& finished,
                       bool last)>
        keep;
    const std::atomic<bool>* cancel = nullptr;
};

struct ReferenceCancelled : std::runtime_error {
    ReferenceCancelled() : std::runtime_error("the reference was cancelled") {}

    double kept = 0;  ///< share of the pixels that are in a file to go on from, 0..1
};

/// RGB floats, rows from the top, linear, as in Still; of the region alone if one was asked for.
struct ReferenceStill {
    int width = 0, height = 0;
    /// surface_lit * transmittance + scattering, by sample, with the transparents in between.
    std::vector<float> composite;
    std::vector<float> scattering;     ///< scattered and emitted towards the eye [W/m^2/sr]
    std::vector<float> transmittance;  ///< 0..1
    std::vector<float> surface;        ///< the picture with no medium, to the same bounces
    std::vector<float> surface_lit;    ///< surfaces lit through the media, not seen through them
    std::vector<float> depth;          ///< one channel: view_z [m] at pixel centres
    std::vector<float>
        error;  ///< one channel: estimated absolute error of composite's worst channel
    /// Half of what two pictures differ by, each of one half of the samples, whose mean is the
    /// composite, or the scattering: its square is on the mean the picture's variance.
    std::vector<float> noise, scattering_noise;
};

/// A reference that is not whole.
struct PartialReference {
    ReferenceStill still;
    std::vector<char> finished;  ///< of each pixel: 1 if it is, else 0
};

/// One sample of the picture.
struct ReferenceSample {
    glm::dvec3 scattering{0}, transmittance{1}, surface{0}, surface_lit{0};
    double view_z = 1e10;  ///< metres; Still::kSkyDepth in the sky
    double error = 0;      ///< estimated, absolute, of composite
    glm::dvec3 noise{0},
        surface_noise{0};  ///< noise of scattering and of surface_lit, as Integral's

    /// Of media and surfaces, with the transparents between them.
    glm::dvec3 composite{0}, composite_noise{0};
};

/// A scene made ready. Const members may be called from any thread; answers don't depend on what
/// was asked before.
class Reference {
public:
    /// Keeps a reference to `scene`. @param bounces, surface_bounces as in ReferenceOptions
    Reference(const Scene& scene, double tolerance, int bounces, int surface_bounces = 0,
              const std::atomic<bool>* cancel = nullptr);
    ~Reference();
    Reference(const Reference&) = delete;
    Reference& operator=(const Reference&) = delete;

    /// The sample at a point of the picture, pixels from the top left; pixel centres are at .5.
    /// @param floor absolute error that is good enough of what media scatter, whatever the value
    /// @param surface_floor likewise of what surfaces send
    /// @param relax how many times the tolerance the world's light may be off, for samples that are
    /// averaged: their errors are independent
    [[nodiscard]] ReferenceSample sample(glm::dvec2 point, double floor, double surface_floor,
                                         double relax = 1) const;
    [[nodiscard]] ReferenceSample sample(glm::dvec2 point, double floor) const
    {
        return sample(point, floor, floor);
    }

    /// exp(-optical depth) from p along the unit vector wi.
    [[nodiscard]] glm::dvec3 transmittance(glm::dvec3 p, glm::dvec3 wi, double range) const;

    /// The world's light scattered towards wo per unit of sigma_s at p, for a phase of this g: the
    /// integral over all directions, to the tolerance.
    [[nodiscard]] glm::dvec3 world_in_scattering(glm::dvec3 p, glm::dvec3 wo, double g) const;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

/// Renders a scene. The same bits whatever the number of threads.
/// @throws ReferenceCancelled soon after options.cancel becomes true; Error if the region lies
/// outside of the picture or the tolerance is not above 0.
ReferenceStill render_reference(const Scene& scene, const ReferenceOptions& options);

}  // namespace fumarole::study
