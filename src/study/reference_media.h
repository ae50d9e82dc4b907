#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "asset/vdb_sampler.h"
#include "study/reference_geometry.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// The media of a scene: coefficients at a point, optical depth along a ray.

namespace fumarole::study {

/// Henyey and Greenstein 1941 [1/sr]; cos_theta = dot(-wi, wo).
double phase_henyey_greenstein(double cos_theta, double g);

struct MediumPoint {
    glm::dvec3 sigma_s{0};   ///< 1/m
    glm::dvec3 emission{0};  ///< W/m^2/sr per metre
    double g = 0;            ///< mean over the media, weighted by sigma_s
};

class ReferenceMedia {
public:
    /// @param tolerance of optical depths that have no closed form (noise), absolute
    ReferenceMedia(const Scene& scene, double tolerance);

    /// Between a point and one `range` metres along wi. Exact to rounding but for noise. Beyond
    /// `most` in every channel it may stop counting.
    [[nodiscard]] glm::dvec3 optical_depth(const Ray& ray, double range,
                                           double most = kOpaque) const;

    /// exp(-kOpaque) is 1e-15.
    static constexpr double kOpaque = 35;

    [[nodiscard]] MediumPoint at(glm::dvec3 p) const;

    [[nodiscard]] bool empty() const { return entries_.empty(); }
    [[nodiscard]] bool scatters() const;
    [[nodiscard]] bool emits() const;

    /// Where the length of a light's way through a box of medium changes its course.
    void add_light_breaks(const Ray& ray, const LightPlace& light,
                          std::vector<double>& breaks) const;

private:
    friend class MediaAlongRay;
    friend class MediaTracking;
    friend class FreeFlight;
    using Span = asset::VdbSampler::Span;

    /// A grid in its place.
    struct Field {
        const VoxelGrid* grid = nullptr;
        std::shared_ptr<const asset::VdbSampler> sampler;
        glm::dmat4 index_from_world{1.0};
        Bounds index_bounds, world_bounds;
        double voxel = 1;  ///< least side, metres

        [[nodiscard]] glm::dvec3 sample(glm::dvec3 p) const;
        [[nodiscard]] glm::dvec3 value(glm::dvec3 p) const;  ///< the same, faster
        void spans(const Ray& ray, double begin, double end, double most,
                   std::vector<Span>& out) const;
    };
    struct Entry {
        Bounds bounds;    ///< world
        Profile profile;  ///< profile of a box
        std::optional<Field> density, emission_field, tint, temperature;
        glm::dvec3 sigma_s{0}, sigma_t{0}, emission{0};
        glm::dvec3 blackbody{0};     ///< over a blackbody's emission
        double kelvin_per_unit = 1;  ///< kelvin per unit of `temperature`
        double g = 0;
        double noise_scale = 1, noise_error = 0;

        [[nodiscard]] bool dims() const { return sigma_t != glm::dvec3(0); }
        [[nodiscard]] bool glows() const { return emission != glm::dvec3(0) || temperature; }
        /// Whether it has no profile.
        [[nodiscard]] bool is_grid() const { return density || emission_field || temperature; }
        /// What it emits where its temperature grid holds `value`. [W/m^2/sr per metre]
        [[nodiscard]] glm::dvec3 emission_at(double value) const;
    };

    template <class OfGrid, class OfNoise>
    [[nodiscard]] glm::dvec3 sum_depths(const Ray& ray, double range, const OfGrid& of_grid,
                                        const OfNoise& of_noise) const;
    /// Of a box whose profile has a closed form.
    [[nodiscard]] glm::dvec3 depth_of(const Entry& entry, const Ray& ray, double range) const;
    void add(const GridMedium& medium);
    void add(const BoxMedium& medium, double tolerance);
    Field place(const VoxelGrid& grid, const GridMedium& medium);
    [[nodiscard]] double noise(const Entry& entry, const NoiseProfile& profile, glm::dvec3 p) const;
    [[nodiscard]] glm::dvec3 profile_at(const Entry& entry, glm::dvec3 p) const;
    void noise_spans(const Entry& entry, const Ray& ray, double begin, double end,
                     std::vector<Span>& out) const;

    std::vector<Entry> entries_;
    std::vector<std::pair<const VoxelGrid*, std::shared_ptr<const asset::VdbSampler>>> samplers_;
    double time_ = 0;
};

/// The media on one ray, ready to be asked for any place on it.
class MediaAlongRay {
public:
    explicit MediaAlongRay(const ReferenceMedia& media) : media_{media} {}

    /// Looks at t in [begin, end]; end may be infinite.
    void set(const Ray& ray, double begin, double end);

    [[nodiscard]] glm::dvec3 optical_depth(double t) const;  ///< optical depth from begin to t
    [[nodiscard]] MediumPoint at(double t) const;

    /// From where on there is no medium, or nothing is seen through it any more.
    [[nodiscard]] double end() const { return end_; }
    [[nodiscard]] glm::dvec3 whole_depth() const { return whole_; }

    /// Where coefficients change their course: bounds, and every few voxels; ascending, from the
    /// first medium to end().
    [[nodiscard]] const std::vector<double>& breaks() const { return breaks_; }
    /// Those of them between two places, which are breaks too; empty where no medium is.
    [[nodiscard]] std::vector<double> breaks_between(double a, double b) const;

private:
    using Span = ReferenceMedia::Span;
    struct Spans {
        std::vector<Span> list;
        std::vector<glm::dvec3> before;  ///< integral up to the span's begin
        [[nodiscard]] glm::dvec3 at(double t) const;
        [[nodiscard]] glm::dvec3 integral(double t) const;
        [[nodiscard]] const Span* find(double t) const;
        void sum();
    };
    struct Part {
        const ReferenceMedia::Entry* entry = nullptr;
        double begin = 0, end = 0;
        Spans density, emission, tint, temperature;
    };
    [[nodiscard]] glm::dvec3 profile_integral(const Part& part, double t) const;
    void add_span_breaks(const Spans& spans);
    void add_depth_breaks();

    const ReferenceMedia& media_;
    Ray ray_;
    double begin_ = 0, end_ = 0;
    glm::dvec3 whole_{0};
    std::vector<Part> parts_;
    std::vector<double> breaks_;
};

/// Places on a ray where media scatter, chosen by chance where that is seen.
class ScatteringPlaces {
public:
    /// Keeps a reference to `along`.
    explicit ScatteringPlaces(const MediaAlongRay& along);

    [[nodiscard]] bool empty() const { return shares_.empty(); }
    /// What the places' weights are, more or less: of a path all of which scatters [1].
    [[nodiscard]] double weight() const { return weight_; }

    struct Place {
        double t = 0;          ///< metres along the ray
        glm::dvec3 weight{0};  ///< sigma_s times transmittance over the place's density [1]
        double g = 0;
    };
    /// @param u in [0, 1)
    [[nodiscard]] Place choose(double u) const;

private:
    const MediaAlongRay& along_;
    std::vector<double> shares_;  ///< running, one for each interval between breaks
    double weight_ = 0;
};

}  // namespace fumarole::study
