#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "study/reference_geometry.h"
#include <fumarole/scene.h>

// What a surface makes of light.

namespace fumarole::study {

/// A glossy surface's layer: GGX with Smith's height-correlated masking and shadowing (Heitz 2014),
/// alpha = max(roughness^2, 0.002). In frames whose z is the normal.
class SurfaceGloss {
public:
    explicit SurfaceGloss(const Gloss& gloss);

    [[nodiscard]] double metallic() const { return metallic_; }
    [[nodiscard]] double alpha() const { return alpha_; }

    /// Of a uniform world the share that the layer reflects towards a cosine where its Fresnel
    /// term is 1 - (1 - wo.h)^5, and where it is (1 - wo.h)^5.
    [[nodiscard]] glm::dvec2 reflected(double cosine) const;

    /// The BRDF times the cosine of wi over the Fresnel term. [1/sr]
    [[nodiscard]] double operator()(glm::dvec3 wo, glm::dvec3 wi) const;
    /// Density of the directions of visible_normal()'s reflections. [1/sr]
    [[nodiscard]] double pdf(glm::dvec3 wo, glm::dvec3 wi) const;
    /// A half vector from two numbers in [0, 1), by how much of it is seen from wo: Heitz 2018,
    /// "Sampling the GGX Distribution of Visible Normals".
    [[nodiscard]] glm::dvec3 visible_normal(glm::dvec3 wo, double u, double v) const;

private:
    [[nodiscard]] double distribution(glm::dvec3 h) const;
    [[nodiscard]] double smith(double cosine) const;  ///< sqrt(a^2 + (1 - a^2) cosine^2)

    double alpha_, metallic_;
    using Shares = std::vector<glm::dvec2>;
    [[nodiscard]] Shares shares() const;

    std::shared_ptr<const Shares> reflected_;  ///< over the cosine's cube root, 0 to 1
};

/// The reflection of a place on a surface towards one direction: Lambert's, or that of a layer of
/// GGX over a Lambertian base by the factors of glTF 2.0's metallic-roughness model. Schlick's
/// Fresnel term, F0 0.04 or, as metallic says, the albedo; light that the layer reflects more than
/// once after Fdez-Aguera 2019, and the base weighed by what the layer leaves of a uniform world,
/// as glsl/lib/ggx.glsl states.
class SurfaceReflection {
public:
    /// @param wo unit vector, towards where the light is reflected to
    SurfaceReflection(const SurfaceHit& hit, glm::dvec3 wo);

    /// Whether it gathers light from few directions, so that lights which have an area are to be
    /// looked for there.
    [[nodiscard]] bool glossy() const { return gloss_ != nullptr; }

    /// The BRDF times the cosine of wi. [1/sr]
    [[nodiscard]] glm::dvec3 operator()(glm::dvec3 wi) const;
    /// Density of sample()'s directions. [1/sr]
    [[nodiscard]] double pdf(glm::dvec3 wi) const;

    struct Direction {
        glm::dvec3 wi{0};
        glm::dvec3 weight{0};  ///< the BRDF times the cosine over the density
        double pdf = 0;
    };
    /// A direction from three numbers in [0, 1); none where nothing is reflected.
    [[nodiscard]] std::optional<Direction> sample(double u, double v, double which) const;

private:
    [[nodiscard]] glm::dvec3 local(glm::dvec3 w) const;
    [[nodiscard]] glm::dvec3 fresnel(double cosine) const;

    const SurfaceGloss* gloss_ = nullptr;
    glm::dvec3 x_{0}, y_{0}, z_{0};  ///< frame; z_ is the normal
    glm::dvec3 wo_{0};               ///< direction to the eye in the frame
    glm::dvec3 base_{0}, f0_{0};
    double layer_share_ = 0;  ///< the layer's share of sample()'s directions
};

}  // namespace fumarole::study
