#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "study/reference_geometry.h"

// What a surface makes of light.

namespace fumarole::study {

/// The reflection of a place on a surface towards one direction: Lambert's, or with gloss that of
/// glTF 2.0's metallic-roughness model (appendix B): GGX of alpha = roughness^2, Smith's
/// height-correlated masking and shadowing (Heitz 2014), Schlick's Fresnel term of F0 0.04 or, as
/// metallic says, the albedo, over a Lambertian base that gets what is not reflected.
class SurfaceReflection {
public:
    /// @param wo unit vector, towards where the light is reflected to
    SurfaceReflection(const SurfaceHit& hit, glm::dvec3 wo);

    [[nodiscard]] bool black() const;

    /// Whether it gathers light from few directions, so that lights which have an area are to be
    /// looked for there.
    [[nodiscard]] bool glossy() const { return glossy_; }

    /// The BRDF times the cosine of wi [1/sr]; a mirror's own reflection is not in it.
    [[nodiscard]] glm::dvec3 operator()(glm::dvec3 wi) const;
    /// Density of sample()'s directions [1/sr], but for a mirror's own.
    [[nodiscard]] double pdf(glm::dvec3 wi) const;

    struct Direction {
        glm::dvec3 wi{0};
        glm::dvec3 weight{0};  ///< the BRDF times the cosine over the density
        double pdf = 0;        ///< of all that sample() does; kInfinity where a mirror sends it
    };
    /// A direction from three numbers in [0, 1); none where nothing is reflected.
    [[nodiscard]] std::optional<Direction> sample(double u, double v, double which) const;

private:
    /// GGX's of a half vector, in the frame whose z is the normal.
    [[nodiscard]] double distribution(glm::dvec3 h) const;
    [[nodiscard]] double smith(double cosine) const;  ///< sqrt(a^2 + (1 - a^2) cosine^2)
    [[nodiscard]] glm::dvec3 fresnel(double cosine) const;
    [[nodiscard]] glm::dvec3 local(glm::dvec3 w) const;

    glm::dvec3 x_{0}, y_{0}, z_{0};  ///< frame; z_ is the normal
    glm::dvec3 wo_{0};               ///< in the frame
    glm::dvec3 base_{0}, f0_{0};
    double alpha_ = 1;
    double specular_share_ = 0;  ///< of sample()'s directions
    bool glossy_ = false, mirror_ = false;
};

}  // namespace fumarole::study
