// glsl/lib/slab.glsl, and the closed-form optical depths of glsl/scene/media.glsl, against double.

#include <cmath>

#include "medium/media_set.h"
#include "shared/bindings.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

/// (1 - exp(-tau)) / tau.
double slab_weight(double tau)
{
    return tau == 0 ? 1 : -std::expm1(-tau) / tau;
}

class Slab : public GlTest {};

TEST_F(Slab, WeightAgreesWithExpm1)
{
    const Kernel kernel(gl(), R"(
#include "lib/slab.glsl"
void kernel(int i) { out_data[i] = vec4(slab_weight(in_data[i].x), slab_weight(vec3(0.0, in_data[i].x, 1.0))); }
)");
    std::vector<glm::vec4> taus{glm::vec4(0)};
    for (double exponent = -12; exponent <= 4; exponent += 0.01)
        taus.emplace_back(static_cast<float>(std::pow(10, exponent)));
    for (double exponent = -12; exponent <= 1.9; exponent += 0.01)  // exp(88) is the last float
        taus.emplace_back(static_cast<float>(-std::pow(10, exponent)));
    const std::vector<glm::vec4> weights = kernel(taus);
    for (std::size_t i = 0; i < taus.size(); ++i) {
        const double expected = slab_weight(taus[i].x);
        // Just above 1e-2, 1 - exp(-tau) keeps 6e-8 of 1e-2. Below it the series is right to 1e-7.
        // exp of a large number is right to the last bit of its argument.
        const double tau = std::abs(taus[i].x);
        const double tolerance = tau < 0.0099 ? 3e-7 : 1.5e-5 + (taus[i].x < 0 ? 2.4e-7 * tau : 0);
        ASSERT_NEAR(weights[i].x, expected, tolerance * expected) << "tau " << taus[i].x;
        ASSERT_EQ(weights[i].y, 1.0f);
        ASSERT_EQ(weights[i].z, weights[i].x);
    }
}

/// Runs optical_depth() of one box medium.
class OpticalDepth : public GlTest {
protected:
    /// rays: p, w: range; wi. @returns the grey optical depth of each.
    std::vector<double> depths(const BoxMedium& medium, const std::vector<glm::vec4>& rays)
    {
        Scene scene;
        scene.media = {medium};
        medium::MediaSet media(gl());
        media.set(scene, Settings{});
        media.bind(glm::dvec3(0));
        const Kernel kernel(gl(), R"(
#include "scene/media.glsl"
void kernel(int i)
{
    out_data[i] = vec4(optical_depth(in_data[2 * i].xyz, in_data[2 * i + 1].xyz, in_data[2 * i].w, 16));
}
)",
                            2, 1, media.defines());
        std::vector<double> values;
        for (const glm::vec4& v : kernel(rays))
            values.push_back(v.x);
        gl()->BindBufferBase(GL_UNIFORM_BUFFER, MEDIA_BLOCK, 0);
        return values;
    }
};

TEST_F(OpticalDepth, HomogeneousIsLengthInsideTimesSigmaT)
{
    BoxMedium box;
    box.min = {-1, -2, -3};
    box.max = {1, 2, 3};
    box.sigma_s = glm::vec3(0.25f);
    const auto tau = depths(box, {{0, 0, 0, 100},
                                  {1, 0, 0, 0},  // inside to the face
                                  {-5, 0, 0, 100},
                                  {1, 0, 0, 0},  // through
                                  {-5, 0, 0, 4.5f},
                                  {1, 0, 0, 0},  // to a light inside
                                  {5, 0, 0, 100},
                                  {1, 0, 0, 0},  // away from it
                                  {0, 0, 0, 1e30f},
                                  {0, 0, -1, 0}});  // a sun
    EXPECT_NEAR(tau[0], 0.25, 1e-6);
    EXPECT_NEAR(tau[1], 0.5, 1e-6);
    EXPECT_NEAR(tau[2], 0.125, 1e-6);
    EXPECT_EQ(tau[3], 0);
    EXPECT_NEAR(tau[4], 0.75, 1e-6);
}

TEST_F(OpticalDepth, ExponentialHeightAgreesWithDoubleUpAndDown)
{
    BoxMedium fog;
    fog.min = {-1000, -1000, -10};
    fog.max = {1000, 1000, 400};
    fog.sigma_s = glm::vec3(0.05f);
    // 200 heights down to the eye of a thin fog: exp of the way down alone overflows a float.
    for (const double scale_height : {0.5, 2.0, 12.0, 500.0}) {
        fog.profile = ExpHeightProfile{scale_height, 0.0};
        std::vector<glm::vec4> rays;
        std::vector<double> expected;
        for (const double z : {-5.0, 0.0, 3.0, 50.0, 300.0})
            for (const double dz : {-1.0, -0.5, -1e-3, 0.0, 1e-3, 0.5, 1.0})
                for (const double range : {0.5, 20.0, 350.0}) {
                    const double dx = std::sqrt(1 - dz * dz);
                    rays.emplace_back(0, 0, z, range);
                    rays.emplace_back(dx, 0, dz, 0);
                    double length = range;
                    if (dz != 0)
                        length = std::min(range, ((dz > 0 ? 400.0 : -10.0) - z) / dz);
                    // From the lower end, so nothing overflows.
                    const double low = dz < 0 ? z + dz * length : z;
                    expected.push_back(0.05 * std::exp(-low / scale_height) * length *
                                       slab_weight(std::abs(dz) * length / scale_height));
                }
        const std::vector<double> tau = depths(fog, rays);
        for (std::size_t i = 0; i < tau.size(); ++i) {
            const double z = rays[2 * i].z, dz = rays[2 * i + 1].z;
            ASSERT_TRUE(std::isfinite(tau[i])) << "H " << scale_height << ", z " << z << ", dz "
                                               << dz << ", range " << rays[2 * i].w;
            // A float exponent of size x is right to 6e-8 x, and so is its exp, relatively.
            const double exponent = (std::abs(z) + rays[2 * i].w) / scale_height;
            EXPECT_NEAR(tau[i], expected[i], (2e-5 + 4e-7 * exponent) * expected[i] + 1e-30)
                << "H " << scale_height << ", z " << z << ", dz " << dz << ", range "
                << rays[2 * i].w;
        }
    }
}

TEST_F(OpticalDepth, AnExponentialFarBelowItsZeroHeightIsAWallAndNoInfinity)
{
    Scene scene = empty_scene(16);
    scene.camera.position = {0, 20, 6};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 90;  // down to the box's floor
    scene.lights = {SunLight{{0, 0.3, 1}, {3, 3, 3}}};
    scene.world.radiance = glm::vec3(0.1f);
    BoxMedium fog;
    fog.min = {-50, -50, -60};  // 120 heights down: exp is past any float
    fog.max = {50, 50, 60};
    fog.profile = ExpHeightProfile{0.5, 0.0};
    fog.sigma_s = glm::vec3(0.1f);
    scene.media = {fog};
    const Still still = render(scene, Settings{});
    for (const float s : still.scattering)
        ASSERT_LT(s, 3) << "no more than the sun gives";
    EXPECT_LT(pixel(still.transmittance, 16, 8, 15).r, 1e-3f);
}

}  // namespace
}  // namespace fumarole::test
