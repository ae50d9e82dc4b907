// glsl/lib/ggx.glsl against the formulas in double, and against what a BRDF is: reciprocal in its
// layer, and sending back neither more than it gets nor, where nothing absorbs, less.

#include <random>

#include "support/ggx.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

class Ggx : public GlTest {
protected:
    /// D V F of each run's n = z, wo, wi with alpha, and f0.
    std::vector<glm::vec4> reflection(const std::vector<glm::vec4>& inputs)
    {
        const Kernel kernel(gl(), R"(
#include "lib/ggx.glsl"
void kernel(int i)
{
    vec4 wo = in_data[3 * i], wi = in_data[3 * i + 1];
    out_data[i] = vec4(ggx_reflection(vec3(0, 0, 1), wo.xyz, wi.xyz, wo.w, in_data[3 * i + 2].rgb), 0.0);
}
)",
                            3);
        return kernel(inputs);
    }

    /// Of each run's albedo and metallic, and a and b: the layer's albedo, and the base's share.
    std::vector<glm::vec4> shares(const std::vector<glm::vec4>& inputs)
    {
        const Kernel kernel(gl(), R"(
#include "lib/ggx.glsl"
void kernel(int i)
{
    vec4 albedo = in_data[2 * i];
    vec2 ab = in_data[2 * i + 1].xy;
    vec3 f0 = ggx_f0(albedo.rgb, albedo.a);
    out_data[2 * i] = vec4(ggx_once(f0, ab), 0.0);
    out_data[2 * i + 1] = vec4(ggx_base(albedo.rgb, albedo.a, f0, ab), 0.0);
}
)",
                            2, 2);
        return kernel(inputs);
    }
};

TEST_F(Ggx, TheLayerIsReciprocalAndTheFormulaInDouble)
{
    std::mt19937 random(17);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<glm::vec4> inputs;
    std::vector<glm::dvec3> expected;
    const auto direction = [&] {
        const double z = 0.02 + 0.98 * unit(random), phi = 2 * std::numbers::pi * unit(random);
        const double r = std::sqrt(1 - z * z);
        return glm::dvec3(r * std::cos(phi), r * std::sin(phi), z);
    };
    const glm::dvec3 f0(0.04, 0.5, 1);
    for (int i = 0; i < 2000; ++i) {
        const double alpha = ggx_alpha(unit(random));
        const glm::dvec3 wo = direction();
        glm::dvec3 wi = direction();
        if (i % 2 == 0) {  // near the mirror direction, where the lobe is
            const glm::dvec3 mirrored(-wo.x + alpha * (unit(random) - 0.5),
                                      -wo.y + alpha * (unit(random) - 0.5), wo.z);
            wi = glm::normalize(mirrored);
        }
        inputs.insert(inputs.end(), {glm::vec4(wo, alpha), glm::vec4(wi, 0), glm::vec4(f0, 0)});
        inputs.insert(inputs.end(), {glm::vec4(wi, alpha), glm::vec4(wo, 0), glm::vec4(f0, 0)});
        const glm::dvec3 o(inputs.end()[-6]), in(inputs.end()[-5]);
        expected.push_back(ggx_reflection({0, 0, 1}, o, in, double(inputs.end()[-6].w), f0));
    }
    const std::vector<glm::vec4> values = reflection(inputs);
    for (std::size_t i = 0; i < expected.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double one = values[2 * i][c], other = values[2 * i + 1][c];
            // Directions of floats are half a unit in the last place off unit length, 6e-8, of a
            // lobe that is 2e-3 wide.
            EXPECT_NEAR(one, expected[i][c], 3e-4 * expected[i][c])
                << i << " alpha " << inputs[6 * i].w;
            EXPECT_NEAR(one, other, 1e-5 * one) << i;
        }
}

// A uniform world of radiance 1: the layer returns f0 a + b, the whole no more than 1, and just 1
// where nothing absorbs.
TEST_F(Ggx, AWhiteFurnaceComesBackWhole)
{
    for (const double roughness : {0.0, 0.1, 0.3, 0.6, 1.0})
        for (const double n_wo : {0.05, 0.3, 0.8, 1.0}) {
            const double alpha = static_cast<float>(ggx_alpha(roughness));
            const glm::dvec3 wo = direction_at(n_wo), albedo(1, 0.5, 0.04);
            const glm::dvec2 ab = ggx_albedos(n_wo, alpha);
            for (const float metallic : {0.0f, 0.5f, 1.0f}) {
                const glm::dvec3 f0 = glm::mix(glm::dvec3(0.04), albedo, double(metallic));
                std::vector<glm::vec4> inputs;
                std::vector<double> weights;
                over_ggx_lobe(wo, alpha, 256, 64, [&](glm::dvec3 wi, double weight) {
                    inputs.insert(inputs.end(),
                                  {glm::vec4(wo, alpha), glm::vec4(wi, 0), glm::vec4(f0, 0)});
                    const glm::dvec3 h = glm::normalize(wo + wi);
                    weights.push_back(weight / ggx_d_v(h.z, wo.z, wi.z, alpha));
                });
                glm::dvec3 layer(0);
                const std::vector<glm::vec4> values = reflection(inputs);
                for (std::size_t i = 0; i < values.size(); ++i)
                    layer += glm::dvec3(values[i]) * weights[i];
                const std::vector<glm::vec4> share =
                    shares({glm::vec4(albedo, metallic), glm::vec4(ab, 0, 0)});
                for (int c = 0; c < 3; ++c) {
                    // Floats here, doubles for a and b.
                    EXPECT_NEAR(layer[c], share[0][c], 1e-3)
                        << roughness << ' ' << n_wo << ' ' << metallic;
                    EXPECT_LE(share[0][c] + share[1][c], 1 + 1e-6);
                    EXPECT_GE(share[1][c], -1e-6);
                }
                // What is half a metal absorbs, as in glTF 2.0.
                if (metallic == 0 || metallic == 1) {
                    EXPECT_NEAR(share[0].r + share[1].r, 1, 1e-6) << "albedo 1";
                }
            }
        }
}

TEST_F(Ggx, GrazingAndOppositeDirectionsStayFinite)
{
    std::vector<glm::vec4> inputs;
    for (const float alpha : {0.002f, 1.0f})
        for (const float wo_z : {-0.5f, 0.0f, 1e-6f})
            for (const glm::vec3 wi :
                 {glm::vec3(0, 0, 1), glm::vec3(1, 0, 1e-7f), glm::vec3(-1, 0, 1e-7f)})
                inputs.insert(inputs.end(), {glm::vec4(std::sqrt(1 - wo_z * wo_z), 0, wo_z, alpha),
                                             glm::vec4(wi, 0), glm::vec4(1)});
    for (const glm::vec4& value : reflection(inputs)) {
        EXPECT_TRUE(std::isfinite(value.r));
        EXPECT_GE(value.r, 0);
    }
}

}  // namespace
}  // namespace fumarole::test
