// glsl/lib/blackbody.glsl against the sum over the observer's table, in double.

#include <cmath>
#include <limits>

#include "blackbody.h"
#include "medium/media_set.h"
#include "study/reference_blackbody.h"
#include "study/stability_bench.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

class BlackbodyKernel : public GlTest {
protected:
    std::vector<glm::vec4> run(const char* body, const std::vector<glm::vec4>& kilokelvin)
    {
        const Kernel kernel(gl(), std::string("#include \"lib/blackbody.glsl\"\n"
                                              "void kernel(int i) { out_data[i] = vec4(") +
                                      body + ", 0.0); }\n");
        return kernel(kilokelvin);
    }
};

TEST_F(BlackbodyKernel, ColourIsPlancksToItsStatedError)
{
    std::vector<glm::vec4> at;
    for (double kelvin = 300; kelvin < 60000; kelvin *= 1.002)
        at.emplace_back(kelvin / 1000, 0, 0, 0);
    const std::vector<glm::vec4> found = run("blackbody_color(in_data[i].x)", at);
    for (std::size_t i = 0; i < at.size(); ++i) {
        const double kelvin = 1000 * double(at[i].x);
        const glm::dvec3 expected = study::blackbody_color(kelvin);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(found[i][c], expected[c], 0.0014) << kelvin << " K, channel " << c;
    }
}

TEST_F(BlackbodyKernel, BrightnessIsTheReferences)
{
    std::vector<glm::vec4> at;
    for (double kelvin = 400; kelvin < 60000; kelvin *= 1.01)
        at.emplace_back(kelvin / 1000, 0, 0, 0);
    const std::vector<glm::vec4> found = run("blackbody(in_data[i].x)", at);
    for (std::size_t i = 0; i < at.size(); ++i) {
        const double kelvin = 1000 * double(at[i].x);
        const glm::dvec3 expected = study::blackbody_emission(kelvin);
        const double allowed = 0.0015 * blackbody_luminance(kelvin) + 1e-9;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(kBlackbodyOfKilokelvin * double(found[i][c]), expected[c], allowed)
                << kelvin << " K, channel " << c;
    }
}

TEST_F(BlackbodyKernel, NoTemperatureIsTooOdd)
{
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const std::vector<glm::vec4> found =
        run("blackbody(in_data[i].x)", {{kInfinity, 0, 0, 0},
                                        {3e38f, 0, 0, 0},
                                        {0, 0, 0, 0},
                                        {-5, 0, 0, 0},
                                        {-kInfinity, 0, 0, 0},
                                        {std::numeric_limits<float>::quiet_NaN(), 0, 0, 0}});
    EXPECT_EQ(found[0], found[1]);
    EXPECT_GT(found[0].b, 0);
    EXPECT_LT(found[0].b, 1e7f);
    for (std::size_t i = 2; i < found.size(); ++i)
        EXPECT_EQ(found[i], glm::vec4(0)) << i;
}

class HotMedia : public GlTest {};

// Bricks of 8 voxels of 1 m: a flame in the second along each axis, air in all four.
TEST_F(HotMedia, AirWidensNoBoundsAndTemperaturesAreNoBytes)
{
    GridMedium fire;
    fire.temperature = study::make_grid(glm::ivec3(4), glm::dmat4(1), [](glm::ivec3 at) {
        const double r = glm::length(glm::dvec3(at) - 11.5);
        return std::max(293.0, 2000 - 500 * r);
    });
    Scene scene;
    scene.media = {fire};
    medium::MediaSet media(gl());
    media.set(scene, Settings{});
    EXPECT_TRUE(media.traits().emission);
    EXPECT_TRUE(media.traits().blackbody);
    EXPECT_EQ(media.bounds().min, glm::dvec3(8));
    EXPECT_EQ(media.bounds().max, glm::dvec3(16));
    ASSERT_EQ(media.occupied().size(), 1u);
    EXPECT_EQ(media.occupied()[0].boxes.size(), 1u);
    ASSERT_EQ(media.describe().size(), 1u);
    EXPECT_NE(media.describe()[0].find("R16F (a byte's error"), std::string::npos)
        << media.describe()[0];

    auto cold = std::make_shared<VoxelGrid>(*fire.temperature);
    for (float& value : cold->values)
        value = 293;
    cold->max_value = 293;
    fire.temperature = cold;
    scene.media = {fire};
    media.set(scene, Settings{});
    EXPECT_TRUE(media.empty()) << "air alone is no medium";
}

}  // namespace
}  // namespace fumarole::test
