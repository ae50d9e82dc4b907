#pragma once

#include <atomic>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "scene.h"
#include "study/reference_geometry.h"
#include "study/reference_media.h"

// The world's light: dimmed by the media, hidden by surfaces, gathered from all directions. What
// arrives is a smooth field of place, so it is gathered at nodes and interpolated: in media on
// regular lattices, made before the first answer, and on surfaces on lattices that refine where
// they must. Nodes are known by their place and each is worked out from itself alone: who asks
// first, and in what order, changes nothing.

namespace fumarole::study {

/// The world as the eye would see it.
class WorldRadiance {
public:
    explicit WorldRadiance(const World& world);

    [[nodiscard]] glm::dvec3 operator()(glm::dvec3 direction) const;
    [[nodiscard]] bool black() const { return mean_ == glm::dvec3(0); }
    [[nodiscard]] glm::dvec3 mean() const { return mean_; }

    /// A part of all directions: z and phi between bounds. Equal areas, equal solid angles.
    struct Patch {
        double z0, z1, phi0, phi1;
    };
    /// Directions cut so that no patch holds much of the light.
    [[nodiscard]] const std::vector<Patch>& patches() const { return patches_; }
    /// All directions cut into rows and columns, then further until none holds more than that share
    /// of the light.
    [[nodiscard]] std::vector<Patch> cut(int rows, int columns, double most_light) const;

    [[nodiscard]] bool is_map() const { return map_ != nullptr; }
    /// Calls use(direction, radiance times solid angle) for the map's texels, by their centres.
    void for_each_texel(const Patch& patch,
                        const std::function<void(glm::dvec3, glm::dvec3)>& use) const;

private:
    void cut(const Patch& patch, double most_light, int depth, std::vector<Patch>& patches) const;
    [[nodiscard]] double light_in(const Patch& patch) const;

    glm::dvec3 constant_{0}, mean_{0};
    const Environment* map_ = nullptr;
    double scale_ = 1;
    double total_ = 0;
    std::vector<Patch> patches_;
};

/// Irradiance of a place on a surface from the world [W/m^2].
struct WorldIrradiance {
    glm::dvec3 clear{0};  ///< as if there were no media
    glm::dvec3 lit{0};    ///< through the media
    double error = 0;     ///< estimated, of the largest channel
};

class ReferenceWorld {
public:
    ReferenceWorld(const Scene& scene, const ReferenceSurfaces& surfaces,
                   const ReferenceMedia& media, double tolerance, const std::atomic<bool>* cancel);
    ~ReferenceWorld();
    ReferenceWorld(const ReferenceWorld&) = delete;
    ReferenceWorld& operator=(const ReferenceWorld&) = delete;

    [[nodiscard]] const WorldRadiance& radiance() const { return radiance_; }

    /// Estimated error of what Towards answers, when that is `value`: as measured at places of the
    /// lattices. Ask once a Towards was made.
    [[nodiscard]] double error_of(double value) const;

    [[nodiscard]] WorldIrradiance irradiance(const SurfaceHit& hit) const;

    /// Asks for the light scattered towards one direction at many places.
    class Towards {
    public:
        Towards(const ReferenceWorld& world, glm::dvec3 wo);
        ~Towards();
        Towards(const Towards&) = delete;
        Towards& operator=(const Towards&) = delete;

        /// Integral over wi of phase(wi, wo, g) * radiance arriving at p from wi.
        glm::dvec3 operator()(glm::dvec3 p, double g);

    private:
        struct Memory;
        const ReferenceWorld& world_;
        std::unique_ptr<Memory> memory_;
    };

    /// The same at one place, gathered there.
    [[nodiscard]] glm::dvec3 in_scattering(glm::dvec3 p, glm::dvec3 wo, double g) const;

private:
    struct Lattice;
    struct Beam;
    struct MediumLattice;
    struct Face;

    [[nodiscard]] std::vector<Beam> beams() const;
    /// Finds the nodes, `coarse` times as far apart as the medium asks; false: too many of them.
    static bool lay_out(const ReferenceMedia::Scatterer& medium, double coarse,
                        MediumLattice& lattice);
    void light_up(const std::vector<Beam>& beams, MediumLattice& lattice) const;
    /// The lattice against gathering in place: relative, over places that scatter much.
    [[nodiscard]] double measure(const MediumLattice& lattice) const;
    void make_lattices() const;

    /// Coefficients of spherical harmonics of what arrives at p, to the tolerance.
    [[nodiscard]] std::vector<glm::dvec3> gather(glm::dvec3 p, int bands) const;
    /// The same by a fixed set of directions.
    [[nodiscard]] std::vector<glm::dvec3> gather(glm::dvec3 p,
                                                 const std::vector<Beam>& beams) const;
    [[nodiscard]] WorldIrradiance gather_irradiance(const Origin& from, glm::dvec3 normal) const;
    [[nodiscard]] bool must_split(const Bounds& cell, double size, int self) const;
    [[nodiscard]] WorldIrradiance on_face(const SurfaceHit& hit, const Face& face) const;

    const ReferenceSurfaces& surfaces_;
    const ReferenceMedia& media_;
    const std::atomic<bool>* cancel_;
    WorldRadiance radiance_;
    double tolerance_;
    double floor_ = 0;   ///< radiance below which errors are not relative any more
    double opaque_ = 0;  ///< optical depth through which nothing counts
    double g_ = 0;       ///< largest
    int bands_ = 1;      ///< of spherical harmonics in the lattices of media
    std::vector<std::pair<int, Bounds>> occluders_;  ///< surface, or -1 for a medium
    std::unique_ptr<Lattice> lattice_;
};

}  // namespace fumarole::study
