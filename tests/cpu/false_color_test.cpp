// A difference picture is read back to its numbers: by its colours, in colour and in grey.

#include "study/false_color.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "study/label_font.h"
#include "study/metrics.h"
#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

glm::vec3 color_at(const Image& image, int x, int y)
{
    return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// CIE 1976 lightness of linear Rec. 709, 0..100: what a grey print keeps.
double lightness(glm::vec3 rgb)
{
    const double y = 0.2126 * static_cast<double>(rgb.r) + 0.7152 * static_cast<double>(rgb.g) +
                     0.0722 * static_cast<double>(rgb.b);
    return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389 / 27;
}

/// Ink at or under a row.
int count_dark(const Image& image, int from_y)
{
    int dark = 0;
    for (int y = from_y; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            dark += color_at(image, x, y) == glm::vec3(0) ? 1 : 0;
        }
    }
    return dark;
}

// -------------------------------------------------------------------------------- difference

TEST(DifferenceMap, MeanSquareOfMagnitudeIsRelmse)
{
    const std::vector<float> x = {1.0f, 2.5f, 0.0f, 4.5f, 7.0f, 0.25f};
    const std::vector<float> r = {1.5f, 2.0f, 0.0f, 5.0f, 6.0f, 0.5f};
    const std::vector<float> map = difference_map(x, r, 3, Difference::magnitude);
    ASSERT_EQ(map.size(), 2u);
    const double mean_square = static_cast<double>(map[0] * map[0] + map[1] * map[1]) / 2;
    EXPECT_NEAR(mean_square, compare(x, r).relmse, 1e-7);
}

TEST(DifferenceMap, SignIsOfTestLessReference)
{
    const std::vector<float> r = {1, 1, 1, 1, 1, 1};
    const std::vector<float> x = {2, 2, 2, 0, 0, 0};
    const std::vector<float> map = difference_map(x, r, 3, Difference::sign);
    EXPECT_NEAR(map[0], 1 / std::sqrt(1.1), 1e-6);
    EXPECT_NEAR(map[1], -1 / std::sqrt(1.1), 1e-6);
}

TEST(DifferenceMap, MarksWhatIsNotFinite)
{
    const std::vector<float> r(6, 1.0f);
    std::vector<float> x = r;
    x[1] = std::numeric_limits<float>::infinity();
    for (const Difference difference : {Difference::magnitude, Difference::sign}) {
        const std::vector<float> map = difference_map(x, r, 3, difference);
        EXPECT_TRUE(std::isnan(map[0]));
        EXPECT_EQ(map[1], 0);
    }
}

TEST(DifferenceMap, SizesMustFit)
{
    const std::vector<float> six(6), five(5);
    EXPECT_THROW(difference_map(six, five, 1, Difference::sign), Error);
    EXPECT_THROW(difference_map(five, five, 3, Difference::sign), Error);
    EXPECT_THROW(difference_map(six, six, 0, Difference::sign), Error);
}

TEST(DifferenceScale, IsRoundAndHoldsAllButAHundredth)
{
    EXPECT_DOUBLE_EQ(difference_scale(std::vector<float>(10, 0.03f)), 0.04);
    EXPECT_DOUBLE_EQ(difference_scale(std::vector<float>(10, -0.7f)), 1);
    EXPECT_DOUBLE_EQ(difference_scale(std::vector<float>(10, 12.0f)), 20);
    std::vector<float> outlier(1000, 0.015f);
    outlier[3] = 1e6f;
    outlier[4] = kNan;
    EXPECT_DOUBLE_EQ(difference_scale(outlier), 0.02);
}

TEST(DifferenceScale, IsThereForPicturesWithoutDifference)
{
    EXPECT_DOUBLE_EQ(difference_scale(std::vector<float>(4, 0.0f)), 1e-6);
    EXPECT_DOUBLE_EQ(difference_scale(std::vector<float>(4, kNan)), 1e-6);
}

// ------------------------------------------------------------------------------------ colours

class ColorMap : public testing::TestWithParam<Difference> {};

TEST_P(ColorMap, BrightensInEvenSteps)
{
    const float first = GetParam() == Difference::magnitude ? 0 : -1;
    constexpr int kSteps = 16;
    std::vector<double> steps;
    double last = lightness(difference_color(first, GetParam()));
    for (int i = 1; i <= kSteps; ++i) {
        const float t = first + (1 - first) * static_cast<float>(i) / kSteps;
        const double now = lightness(difference_color(t, GetParam()));
        steps.push_back(now - last);
        last = now;
    }
    const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / kSteps;
    EXPECT_GT(mean, 4.5);  // 72 of the 100 there are, or more
    // Magma is even in CAM02-UCS, which counts the dark end of L* for more.
    EXPECT_GT(*std::min_element(steps.begin(), steps.end()), 0.5 * mean);
    EXPECT_LT(*std::max_element(steps.begin(), steps.end()), 1.6 * mean);
}

TEST_P(ColorMap, HoldsItsEndsBeyondThem)
{
    EXPECT_EQ(difference_color(7, GetParam()), difference_color(1, GetParam()));
    const float first = GetParam() == Difference::magnitude ? 0 : -1;
    EXPECT_EQ(difference_color(-9, GetParam()), difference_color(first, GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Maps, ColorMap, testing::Values(Difference::magnitude, Difference::sign),
                         [](const auto& test) {
                             return test.param == Difference::magnitude ? "magnitude" : "sign";
                         });

TEST(ColorMaps, ZeroIsBlackOrNeutralGrey)
{
    EXPECT_LT(lightness(difference_color(0, Difference::magnitude)), 1);
    const glm::vec3 zero = difference_color(0, Difference::sign);
    EXPECT_EQ(zero.r, zero.g);
    EXPECT_EQ(zero.g, zero.b);
    EXPECT_NEAR(lightness(zero), 50, 1);
    EXPECT_GT(difference_color(-0.5f, Difference::sign).b,
              difference_color(-0.5f, Difference::sign).r);
    EXPECT_GT(difference_color(0.5f, Difference::sign).r,
              difference_color(0.5f, Difference::sign).b);
}

// ------------------------------------------------------------------------------------ picture

TEST(FalseColor, ShowsEachValueInItsColor)
{
    std::vector<float> map(400 * 8, 0.0f);
    map[0] = 0.1f;
    map[1] = 0.2f;
    map[400 * 7 + 399] = 5.0f;
    map[2] = kNan;
    const Image image = false_color(map, 400, 8, {.scale = 0.2});
    ASSERT_EQ(image.width, 400);
    EXPECT_GT(image.height, 8);
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(image.pixels.size(), 3u * 400u * static_cast<std::size_t>(image.height));
    EXPECT_EQ(color_at(image, 0, 0), difference_color(0.5f, Difference::magnitude));
    EXPECT_EQ(color_at(image, 1, 0), difference_color(1, Difference::magnitude));
    EXPECT_EQ(color_at(image, 399, 7), difference_color(1, Difference::magnitude));
    EXPECT_EQ(color_at(image, 2, 0), glm::vec3(0, 1, 0));
    EXPECT_EQ(color_at(image, 5, 5), difference_color(0, Difference::magnitude));
}

TEST(FalseColor, BarRunsThroughAllColors)
{
    for (const Difference difference : {Difference::magnitude, Difference::sign}) {
        const Image image =
            false_color(std::vector<float>(400 * 8, 0.0f), 400, 8, {.difference = difference});
        const int y = 8 + 4 + 6;  // picture, gap, half the bar
        double last = -1;
        int colors = 0;
        for (int x = 0; x < image.width; ++x) {
            const glm::vec3 color = color_at(image, x, y);
            if (color == glm::vec3(1) || color == glm::vec3(0)) {
                continue;  // paper and outline
            }
            const double now = lightness(color);
            EXPECT_GE(now, last);
            last = now;
            ++colors;
        }
        EXPECT_GT(colors, 300);
        EXPECT_NEAR(last, lightness(difference_color(1, difference)), 1);
    }
}

TEST(FalseColor, SaysItsScaleAndCaption)
{
    const std::vector<float> map(300 * 4, 0.05f);
    const Image image = false_color(map, 300, 4, {.scale = 0.1});
    const Image other_scale = false_color(map, 300, 4, {.scale = 0.2});
    const Image captioned = false_color(map, 300, 4, {.scale = 0.1, .caption = "scattering"});
    const int text = 4 + 4 + 12 + 3;
    EXPECT_GT(count_dark(image, text), 100);
    EXPECT_NE(count_dark(image, text), count_dark(other_scale, text));
    EXPECT_GT(count_dark(captioned, text), count_dark(image, text) + 50);
}

TEST(FalseColor, MakesRoomForItsTextBesideASmallPicture)
{
    const Image image = false_color(std::vector<float>(4, 0.0f), 2, 2, {.scale = 0.1});
    EXPECT_GT(image.width, 100);
    const int middle = image.width / 2 - 1;
    EXPECT_EQ(color_at(image, middle, 0), difference_color(0, Difference::magnitude));
    EXPECT_EQ(color_at(image, 0, 0), glm::vec3(1));
    for (int y = 0; y < image.height; ++y) {  // and none of it is cut
        EXPECT_EQ(color_at(image, 0, y), glm::vec3(1));
        EXPECT_EQ(color_at(image, image.width - 1, y), glm::vec3(1));
    }
}

TEST(FalseColor, TextGrowsWithThePicture)
{
    const Image small = false_color(std::vector<float>(480 * 2, 0.0f), 480, 2, {});
    const Image large = false_color(std::vector<float>(1920 * 2, 0.0f), 1920, 2, {});
    EXPECT_EQ(large.height - 2, 4 * (small.height - 2));
}

TEST(FalseColor, RefusesWhatHasNoColors)
{
    const std::vector<float> map(6, 0.0f);
    EXPECT_THROW(false_color(map, 2, 2, {}), Error);
    EXPECT_THROW(false_color({}, 0, 0, {}), Error);
    EXPECT_THROW(false_color(map, 2, 3, {.scale = 0}), Error);
    EXPECT_THROW(false_color(map, 2, 3, {.scale = static_cast<double>(kNan)}), Error);
}

// --------------------------------------------------------------------------------------- font

Image canvas(int width, int height)
{
    Image image;
    image.width = width;
    image.height = height;
    image.channels = {"R", "G", "B"};
    image.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3,
                        1.0f);
    return image;
}

TEST(LabelFont, EveryLetterIsItsOwn)
{
    const std::string letters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ.,:-_+%/()<>=^ \x7f";
    std::set<std::vector<float>> drawn;
    for (const char letter : letters) {
        Image image = canvas(5, 7);
        draw_label(image, 0, 0, std::string(1, letter), glm::vec3(0), 1);
        drawn.insert(image.pixels);
    }
    EXPECT_EQ(drawn.size(), letters.size());
}

TEST(LabelFont, SmallLettersAreCapitals)
{
    Image small = canvas(40, 7), large = canvas(40, 7);
    draw_label(small, 0, 0, "relmse", glm::vec3(0), 1);
    draw_label(large, 0, 0, "RELMSE", glm::vec3(0), 1);
    EXPECT_EQ(small.pixels, large.pixels);
}

TEST(LabelFont, FillsItsBoxAndNoMore)
{
    for (const int scale : {1, 3}) {
        Image image = canvas(60, 30);
        draw_label(image, 2, 3, "HH", glm::vec3(0), scale);
        int right = 0, bottom = 0;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) {
                if (color_at(image, x, y) == glm::vec3(0)) {
                    right = std::max(right, x);
                    bottom = std::max(bottom, y);
                }
            }
        }
        EXPECT_EQ(right, 2 + label_width("HH", scale) - 1);
        EXPECT_EQ(bottom, 3 + label_height(scale) - 1);
    }
    EXPECT_EQ(label_width("", 2), 0);
}

TEST(LabelFont, LeavesOutWhatIsOutside)
{
    Image image = canvas(6, 4);
    draw_label(image, -3, -2, "888", glm::vec3(0), 1);
    draw_label(image, 5, 3, "8", glm::vec3(0), 2);
    EXPECT_EQ(image.pixels.size(), 6u * 4u * 3u);
    EXPECT_EQ(label_width("888", 1), 17);
}

}  // namespace
}  // namespace fumarole::study
