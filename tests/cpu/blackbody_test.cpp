// The light of blackbodies in the reference, against the literature and closed forms; and what the
// kelvin of a grid are.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "blackbody.h"
#include "study/reference_blackbody.h"
#include "study/reference_media.h"
#include "study/reference_tracking.h"
#include "study/stability_bench.h"

namespace fumarole {
namespace {

using study::blackbody_color;
using study::blackbody_emission;
using study::planck_xyz;
using study::rec709_from_xyz;

constexpr glm::dvec3 kLuminance(0.2126, 0.7152, 0.0722);  // of linear Rec. 709

// CIE illuminant A is a blackbody of 2856 K. The others: Wyszecki and Stiles 1982, Color Science,
// table 1(3.11), whose second radiation constant differs from today's in the fourth digit.
TEST(Blackbody, ChromaticitiesAreThoseOfTheLiterature)
{
    struct Case {
        double kelvin, x, y;
    };
    for (const Case& c :
         {Case{1000, 0.6528, 0.3445}, Case{1500, 0.5857, 0.3931}, Case{2000, 0.5267, 0.4133},
          Case{2856, 0.4476, 0.4074}, Case{4000, 0.3805, 0.3768}, Case{6500, 0.3135, 0.3237},
          Case{10000, 0.2807, 0.2884}}) {
        const glm::dvec3 xyz = planck_xyz(c.kelvin);
        const double sum = xyz.x + xyz.y + xyz.z;
        EXPECT_NEAR(xyz.x / sum, c.x, 2e-4) << c.kelvin;
        EXPECT_NEAR(xyz.y / sum, c.y, 2e-4) << c.kelvin;
        EXPECT_DOUBLE_EQ(xyz.y, 1);
    }
}

TEST(Blackbody, Rec709HasItsPrimariesAndItsWhite)
{
    const auto rgb = [](double x, double y) {
        return rec709_from_xyz({x / y, 1, (1 - x - y) / y});
    };
    const auto expect = [](glm::dvec3 found, glm::dvec3 expected) {
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], expected[c], 3e-4);  // the luminances have four digits
    };
    expect(rgb(0.3127, 0.3290), glm::dvec3(1));
    expect(rgb(0.64, 0.33) * kLuminance.r, {1, 0, 0});
    expect(rgb(0.30, 0.60) * kLuminance.g, {0, 1, 0});
    expect(rgb(0.15, 0.06) * kLuminance.b, {0, 0, 1});
}

// Where Rec. 709 has the colour; where it is too red for it, red and green stay what they are.
// The ends: what Blender's Cycles holds below 800 K and above 12,000 K.
TEST(Blackbody, ColourHasLuminanceOneAndIsBlendersToo)
{
    for (double kelvin = 2000; kelvin <= 40000; kelvin *= 1.1)
        EXPECT_NEAR(glm::dot(blackbody_color(kelvin), kLuminance), 1, 2e-4) << kelvin;
    const glm::dvec3 cold = blackbody_color(800), hot = blackbody_color(12000);
    EXPECT_NEAR(cold.r, 5.4133, 0.01);
    EXPECT_EQ(cold.g, 0);
    EXPECT_EQ(cold.b, 0);
    EXPECT_NEAR(hot.r, 0.8263, 0.003);
    EXPECT_NEAR(hot.g, 0.9945, 0.003);
    EXPECT_NEAR(hot.b, 1.5663, 0.01);
    EXPECT_EQ(blackbody_color(300), cold);
    EXPECT_EQ(blackbody_color(1e9), blackbody_color(40000));
}

TEST(Blackbody, ColourTableIsTheSumOverTheObserver)
{
    for (double kelvin = 801; kelvin < 40000; kelvin *= 1.0137) {
        const glm::dvec3 sum = glm::max(rec709_from_xyz(planck_xyz(kelvin)), glm::dvec3(0));
        const glm::dvec3 read = blackbody_color(kelvin);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(read[c], sum[c], 1e-8) << kelvin << " K, channel " << c;
    }
}

// sigma T^4 / pi in MW/m^2/sr, in full from the Draper point on, and none of it under 500 K.
TEST(Blackbody, BrightnessIsStefanAndBoltzmanns)
{
    for (const double kelvin : {800.0, 1000.0, 1500.0, 3000.0, 20000.0}) {
        const double expected = 5.670374e-8 * std::pow(kelvin, 4) / std::numbers::pi * 1e-6;
        EXPECT_NEAR(blackbody_luminance(kelvin) / expected, 1, 1e-6) << kelvin;
        const double luminance = glm::dot(blackbody_emission(kelvin), kLuminance);
        if (kelvin > 2000)
            EXPECT_NEAR(luminance / expected, 1, 2e-4) << kelvin;
        else  // red and green of what Rec. 709 has no red for
            EXPECT_NEAR(luminance / expected, 1.06, 0.1) << kelvin;
    }
    EXPECT_NEAR(blackbody_emission(6000).g / blackbody_emission(3000).g,
                16 * blackbody_color(6000).g / blackbody_color(3000).g, 1e-9);
    double before = 0;
    for (const double kelvin : {501.0, 600.0, 700.0, 797.0, 799.0}) {
        EXPECT_NEAR(blackbody_emission(kelvin).r / blackbody_color(800).r,
                    blackbody_luminance(kelvin), 1e-9)
            << kelvin;
        EXPECT_GT(blackbody_luminance(kelvin), before) << kelvin;
        before = blackbody_luminance(kelvin);
    }
    for (const double kelvin : {-1e30, -1.0, 0.0, 293.0, 500.0}) {
        EXPECT_EQ(blackbody_emission(kelvin), glm::dvec3(0)) << kelvin;
        EXPECT_EQ(blackbody_luminance(kelvin), 0) << kelvin;
    }
    EXPECT_EQ(blackbody_emission(1e30), blackbody_emission(40000));
    EXPECT_EQ(blackbody_luminance(1e30), blackbody_luminance(40000));
}

std::shared_ptr<VoxelGrid> temperatures(double most)
{
    return study::make_grid(glm::ivec3(2), glm::dmat4(1), [&](glm::ivec3 at) {
        return most * std::exp(-glm::dot(glm::dvec3(at) - 7.0, glm::dvec3(at) - 7.0) / 25);
    });
}

TEST(Blackbody, KelvinOfAUnitAreFoundFromTheLargestValue)
{
    GridMedium fire;
    EXPECT_EQ(kelvin_per_unit(fire), 1000);
    for (const auto& [most, kelvin] : {std::pair{0.8, 1000.0},
                                       {2.84, 1000.0},
                                       {19.9, 1000.0},
                                       {20.1, 1.0},
                                       {293.0, 1.0},
                                       {2200.0, 1.0}}) {
        fire.temperature = temperatures(most);
        EXPECT_EQ(kelvin_per_unit(fire), kelvin) << most;
    }
    fire.temperature_scale = 750;
    EXPECT_EQ(kelvin_per_unit(fire), 750);
}

TEST(Blackbody, OnlyWhatIsHotEnoughGlows)
{
    GridMedium fire;
    EXPECT_FALSE(glows_hot(fire));
    fire.temperature = std::make_shared<VoxelGrid>();
    EXPECT_FALSE(glows_hot(fire)) << "empty";
    fire.temperature = temperatures(293);
    EXPECT_FALSE(glows_hot(fire)) << "air";
    fire.temperature_scale = 10;
    EXPECT_TRUE(glows_hot(fire));
    fire.blackbody_intensity = 0;
    EXPECT_FALSE(glows_hot(fire)) << "no intensity";
    fire.blackbody_intensity = 1;
    fire.blackbody_tint = glm::vec3(0);
    EXPECT_FALSE(glows_hot(fire)) << "a black tint";
}

// The field between voxels is a temperature, and not what it emits: half way from 0 K to 2000 K
// is 1000 K, a sixteenth.
TEST(Blackbody, ReferenceInterpolatesTemperatures)
{
    Scene scene;
    GridMedium fire;
    fire.temperature = study::make_grid(glm::ivec3(1), glm::dmat4(1),
                                        [](glm::ivec3 at) { return at.x >= 4 ? 2.0 : 0.0; });
    fire.blackbody_intensity = 3;
    fire.blackbody_tint = {1, 0.5f, 0.25f};
    scene.media = {fire};
    const study::ReferenceMedia media(scene, 1e-3);
    EXPECT_TRUE(media.emits());
    EXPECT_FALSE(media.scatters());
    study::MediaAlongRay along(media);
    along.set({{0, 4, 4}, {1, 0, 0}}, 0, 20);
    for (const auto& [x, kelvin] :
         {std::pair{5.0, 2000.0}, {3.5, 1000.0}, {3.75, 1500.0}, {2.0, 0.0}}) {
        const glm::dvec3 expected = 3.0 * glm::dvec3(1, 0.5, 0.25) * blackbody_emission(kelvin);
        for (const glm::dvec3& found : {media.at({x, 4, 4}).emission, along.at(x).emission})
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], expected[c], 1e-9 + 1e-6 * expected[c]) << x;
    }
}

// What paths look up of the emission along a ray is on average what the quadrature sums up.
TEST(Blackbody, TrackingSumsUpWhatTheQuadratureDoes)
{
    Scene scene;
    GridMedium fire;
    fire.temperature = temperatures(2500);
    fire.density = fire.temperature;
    fire.sigma_s_per_density = glm::vec3(0);
    fire.sigma_a_per_density = glm::vec3(1e-4f, 5e-5f, 0);
    scene.media = {fire};
    const study::ReferenceMedia media(scene, 1e-3);
    const study::MediaTracking tracking(media);
    const study::Ray ray{{-3, 6.2, 7.7}, glm::normalize(glm::dvec3(1, 0.03, -0.05))};
    study::MediaAlongRay along(media);
    along.set(ray, 0, 40);
    glm::dvec3 expected(0);
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
        const double t = 25 * (i + 0.5) / kSteps;
        expected +=
            along.at(t).emission * glm::exp(-along.optical_depth(t)) * 25.0 / double(kSteps);
    }
    glm::dvec3 mean(0);
    study::Random random(5);
    constexpr int kTries = 20000;
    for (int i = 0; i < kTries; ++i)
        mean += tracking.emitted(ray, 40, random) / double(kTries);
    ASSERT_GT(expected.r, 0.1);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(mean[c] / expected[c], 1, 0.003) << c;  // 0.1 % of noise
}

}  // namespace
}  // namespace fumarole
