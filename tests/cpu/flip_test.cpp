// What the paper says of FLIP, what follows from its formulas by hand, and what must not change it.
// Pictures are display-encoded unless said.

#include "study/flip.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

struct Picture {
    int width, height;
    std::vector<float> rgb;
};

Picture draw(int width, int height, const std::function<glm::vec3(int x, int y)>& color)
{
    Picture picture{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const glm::vec3 c = color(x, y);
            for (int i = 0; i < 3; ++i) {
                picture.rgb.push_back(c[i]);
            }
        }
    }
    return picture;
}

Picture constant(glm::vec3 color, int width = 32, int height = 32)
{
    return draw(width, height, [color](int, int) { return color; });
}

Picture noise(unsigned seed, int width = 40, int height = 28)
{
    std::mt19937 random(seed);
    return draw(width, height, [&random](int, int) {
        const auto next = [&random] { return static_cast<float>(random() % 1025) / 1024; };
        return glm::vec3(next(), next(), next());
    });
}

Flip compare(const Picture& test, const Picture& reference,
             float pixels_per_degree = kFlipPixelsPerDegree)
{
    return flip(test.rgb, reference.rgb, test.width, test.height, pixels_per_degree);
}

// Waves of colour over 24 x 16 pixels, the phase moving with the channel.
Picture waves(float along_x, float along_y, float by_channel)
{
    return draw(24, 16, [=](int x, int y) {
        glm::vec3 color;
        for (int c = 0; c < 3; ++c) {
            color[c] = 0.5f + 0.4f * std::sin(along_x * static_cast<float>(x) +
                                              along_y * static_cast<float>(y) +
                                              by_channel * static_cast<float>(c));
        }
        return color;
    });
}

TEST(Flip, OfAPictureWithItselfIsZero)
{
    const Flip result = compare(noise(1), noise(1));
    EXPECT_EQ(result.mean, 0);
    EXPECT_EQ(*std::max_element(result.map.begin(), result.map.end()), 0);
}

TEST(Flip, IsTheSameBothWays)
{
    const Flip one = compare(noise(1), noise(2));
    const Flip other = compare(noise(2), noise(1));
    EXPECT_EQ(one.map, other.map);
    EXPECT_EQ(one.mean, other.mean);
    EXPECT_GT(one.mean, 0);
}

TEST(Flip, LiesBetweenZeroAndOne)
{
    for (const float ppd : {4.0f, 20.0f, 67.0f, 400.0f}) {
        for (const Picture& reference :
             {noise(4), constant({0, 0, 1}, 40, 28), constant({1, 1, 1}, 40, 28)}) {
            for (const float value : compare(noise(3), reference, ppd).map) {
                ASSERT_GE(value, 0.0f);
                ASSERT_LE(value, 1.0f);
            }
        }
    }
}

TEST(Flip, MeanIsTheMapsMean)
{
    const Flip result = compare(noise(1), noise(2));
    ASSERT_EQ(result.map.size(), 40u * 28u);
    double sum = 0;
    for (const float value : result.map) {
        sum += static_cast<double>(value);
    }
    EXPECT_NEAR(result.mean, sum / (40 * 28), 1e-12);
}

TEST(Flip, ReachesOneFromGreenToBlue)
{
    // The paper scales by this pair, the farthest apart that a screen shows.
    EXPECT_NEAR(compare(constant({0, 1, 0}), constant({0, 0, 1})).mean, 1, 1e-5);
}

TEST(Flip, OfConstantColorsIsWorkedByHand)
{
    // CIELAB of sRGB's green and blue under D65; the Hunt effect scales a*, b* by L* / 100.
    const glm::dvec3 green(87.7347, -86.1827 * 0.877347, 83.1793 * 0.877347);
    const glm::dvec3 blue(32.2970, 79.1875 * 0.322970, -107.8602 * 0.322970);
    const double largest =
        std::pow(green.x - blue.x + std::hypot(green.y - blue.y, green.z - blue.z), 0.7);
    // White against black: 100 of lightness and nothing else, over the knee at 0.4 of the largest.
    const double knee = 0.4 * largest;
    const double white = 0.95 + 0.05 * (std::pow(100.0, 0.7) - knee) / (largest - knee);
    EXPECT_NEAR(compare(constant({1, 1, 1}), constant({0, 0, 0})).mean, white, 2e-4);
    // Encoded 0.5 is L* 53.389, 0.6 is 63.223: under the knee.
    const double greys = 0.95 * std::pow(63.223 - 53.389, 0.7) / knee;
    EXPECT_NEAR(compare(constant({0.5f, 0.5f, 0.5f}), constant({0.6f, 0.6f, 0.6f})).mean, greys,
                2e-4);
}

TEST(Flip, IsThePapersFormulaUnseparated)
{
    // The paper's two-dimensional filters, applied tap by tap in double precision by a script of
    // its own; here they are separated and single precision.
    const Flip result = compare(waves(0.7f, 0.3f, 1), waves(0.5f, -0.4f, 2));
    const auto at = [&result](int x, int y) {
        return result.map[static_cast<std::size_t>(y * 24 + x)];
    };
    EXPECT_NEAR(at(0, 0), 0.74407113, 1e-4);
    EXPECT_NEAR(at(5, 3), 0.83077817, 1e-4);
    EXPECT_NEAR(at(12, 8), 0.65782334, 1e-4);
    EXPECT_NEAR(at(23, 15), 0.86293096, 1e-4);
    EXPECT_NEAR(at(20, 2), 0.90485879, 1e-4);
    EXPECT_NEAR(result.mean, 0.78914171, 1e-5);
}

TEST(Flip, RisesWithContrast)
{
    const Picture grey = constant({0.5f, 0.5f, 0.5f}, 64, 32);
    double last = 0;
    for (const float amplitude : {0.01f, 0.02f, 0.05f, 0.1f, 0.2f, 0.4f}) {
        // 16 pixels a period: 4 cycles per degree, where the eye is keen.
        const Picture grating = draw(64, 32, [amplitude](int x, int) {
            return glm::vec3(0.5f + amplitude * std::sin(6.2831853f * static_cast<float>(x) / 16));
        });
        const double mean = compare(grating, grey).mean;
        EXPECT_GT(mean, last) << "amplitude " << amplitude;
        last = mean;
    }
}

/// Black and white squares, whose light is half of white's on average: encoded 0.7354.
Picture checkers(int square)
{
    return draw(96, 96, [square](int x, int y) {
        return glm::vec3(static_cast<float>((x / square + y / square) % 2));
    });
}
constexpr float kHalfLight = 0.735357f;

TEST(Flip, DoesNotSeeWhatTheEyeDoesNotResolve)
{
    const Picture flat = constant(glm::vec3(kHalfLight), 96, 96);
    // 33 cycles per degree: the contrast sensitivity filter leaves 3e-5 of it. The pictures differ
    // by half of all light at every pixel.
    const Flip fine = compare(checkers(1), flat);
    double inside = 0;  // at the frame half a square is missing
    for (int y = 16; y < 80; ++y) {
        for (int x = 16; x < 80; ++x) {
            inside = std::max(inside,
                              static_cast<double>(fine.map[static_cast<std::size_t>(y * 96 + x)]));
        }
    }
    EXPECT_LT(inside, 0.01);
    EXPECT_GT(compare(checkers(16), flat).mean, 0.5);
}

TEST(Flip, FallsAsTheViewerStepsBack)
{
    const Picture flat = constant(glm::vec3(kHalfLight), 96, 96);
    double last = 1;
    for (const float ppd : {16.0f, 32.0f, 64.0f, 128.0f}) {
        const double mean = compare(checkers(2), flat, ppd).mean;
        EXPECT_LT(mean, last) << ppd << " pixels per degree";
        last = mean;
    }
}

TEST(Flip, AnEdgeTooManyIsWorseThanItsColor)
{
    // Right half brighter than in the flat reference: the same colour difference there throughout,
    // but an edge at its left end.
    const Picture flat = constant({0.4f, 0.4f, 0.4f}, 96, 32);
    const Picture step = draw(96, 32, [](int x, int) { return glm::vec3(x < 48 ? 0.4f : 0.6f); });
    const Flip result = compare(step, flat);
    const auto at = [&result](int x) { return result.map[static_cast<std::size_t>(16 * 96 + x)]; };
    EXPECT_EQ(at(10), 0);
    EXPECT_GT(at(51), 1.1f * at(90));
    EXPECT_FLOAT_EQ(at(90), at(80));  // neither the edge nor the frame reaches here
}

TEST(Flip, FrameIsNoEdge)
{
    const Flip result = compare(constant({0.2f, 0.5f, 0.7f}), constant({0.3f, 0.5f, 0.6f}));
    const auto [low, high] = std::minmax_element(result.map.begin(), result.map.end());
    EXPECT_GT(*low, 0.0f);
    EXPECT_NEAR(*low, *high, 1e-3f * *high);  // rounding, under the square root of q_f
}

TEST(Flip, TurnsAndMirrorsWithThePictures)
{
    const Picture test = noise(5, 24, 36), reference = noise(6, 24, 36);
    const auto turned = [](const Picture& picture) {  // transposed, then mirrored
        return draw(picture.height, picture.width, [&picture](int x, int y) {
            const int at = (x * picture.width + (picture.width - 1 - y)) * 3;
            const float* rgb = picture.rgb.data() + at;
            return glm::vec3(rgb[0], rgb[1], rgb[2]);
        });
    };
    const Flip straight = compare(test, reference);
    const Flip after = compare(turned(test), turned(reference));
    for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 36; ++x) {
            ASSERT_NEAR(after.map[static_cast<std::size_t>(y * 36 + x)],
                        straight.map[static_cast<std::size_t>(x * 24 + (23 - y))], 1e-4);
        }
    }
    EXPECT_NEAR(after.mean, straight.mean, 1e-5);
}

TEST(Flip, CutsWhatNoScreenShows)
{
    const Flip result = compare(constant({2, 1, 1}), constant({1, 7, 1}));
    EXPECT_EQ(result.mean, 0);
}

TEST(Flip, WorksOnASinglePixel)
{
    EXPECT_NEAR(compare(constant({0, 1, 0}, 1, 1), constant({0, 0, 1}, 1, 1)).mean, 1, 1e-5);
}

TEST(Flip, RefusesWhatItCannotJudge)
{
    const Picture picture = constant({0, 0, 0}, 4, 4);
    Picture broken = picture;
    broken.rgb[5] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(flip(picture.rgb, picture.rgb, 4, 5), Error);
    EXPECT_THROW(flip(picture.rgb, picture.rgb, 0, 0), Error);
    EXPECT_THROW(flip({}, {}, 0, 4), Error);
    EXPECT_THROW(flip(picture.rgb, broken.rgb, 4, 4), Error);
    EXPECT_THROW(flip(broken.rgb, picture.rgb, 4, 4), Error);
    EXPECT_THROW(flip(picture.rgb, picture.rgb, 4, 4, 0), Error);
    EXPECT_THROW(flip(picture.rgb, picture.rgb, 4, 4, std::numeric_limits<float>::quiet_NaN()),
                 Error);
}

// ---------------------------------------------------------------------------- linear radiance

TEST(FlipOfRadiance, SeesTheDisplayedPictures)
{
    // 18 % and 30 % grey without a curve are encoded 0.46136 and 0.58383 (IEC 61966-2-1).
    const Display srgb{.exposure_ev = 0, .transform = Display::Transform::srgb};
    const Picture dark = constant(glm::vec3(0.18f)), bright = constant(glm::vec3(0.3f));
    EXPECT_NEAR(flip_of_radiance(dark.rgb, bright.rgb, 32, 32, srgb).mean,
                compare(constant(glm::vec3(0.46136f)), constant(glm::vec3(0.58383f))).mean, 1e-4);
}

TEST(FlipOfRadiance, DependsOnRadianceTimesExposureAlone)
{
    const Picture test = noise(7), reference = noise(8);
    Picture test_x8 = test, reference_x8 = reference;
    for (float& value : test_x8.rgb) {
        value *= 8;
    }
    for (float& value : reference_x8.rgb) {
        value *= 8;
    }
    EXPECT_EQ(flip_of_radiance(test.rgb, reference.rgb, 40, 28, {.exposure_ev = 1}).map,
              flip_of_radiance(test_x8.rgb, reference_x8.rgb, 40, 28, {.exposure_ev = -2}).map);
}

TEST(FlipOfRadiance, SeesNothingAboveWhite)
{
    const Picture bright = constant(glm::vec3(2)), brighter = constant(glm::vec3(3));
    const Display srgb{.exposure_ev = 0, .transform = Display::Transform::srgb};
    EXPECT_EQ(flip_of_radiance(bright.rgb, brighter.rgb, 32, 32, srgb).mean, 0);
    const Display darker{.exposure_ev = -3, .transform = Display::Transform::srgb};
    EXPECT_GT(flip_of_radiance(bright.rgb, brighter.rgb, 32, 32, darker).mean, 0.1);
}

TEST(FlipOfRadiance, RefusesNan)
{
    const Picture good = constant(glm::vec3(1));
    Picture bad = good;
    bad.rgb[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(flip_of_radiance(bad.rgb, good.rgb, 32, 32, {}), Error);
}

}  // namespace
}  // namespace fumarole::study
