// A comparison that could not fail, or whose report misleads, would make every image test
// worthless.

#include "support/image_compare.h"

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include <unistd.h>

#include <gtest/gtest.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

Image flat(int width, int height, float value)
{
    Image image{width, height, {"R", "G", "B"}, {}};
    image.pixels.assign(static_cast<std::size_t>(width * height) * 3, value);
    return image;
}

class ImagesNear : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "fumarole_compare_XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
        if (const char* old = std::getenv("FUM_TEST_OUT")) {
            old_ = old;
        }
        ::setenv("FUM_TEST_OUT", folder_.c_str(), 1);
    }
    void TearDown() override
    {
        if (old_) {
            ::setenv("FUM_TEST_OUT", old_->c_str(), 1);
        } else {
            ::unsetenv("FUM_TEST_OUT");
        }
        fs::remove_all(folder_);
    }

    fs::path folder_;
    std::optional<std::string> old_;
};

TEST_F(ImagesNear, PassesUpToItsTolerancesAndWritesNothing)
{
    Image actual = flat(8, 4, 1.0f);
    EXPECT_TRUE(images_near(actual, actual, 0, 0, "the same"));
    actual.pixels[5] = 1.5f;  // of 96 values
    EXPECT_TRUE(images_near(actual, flat(8, 4, 1.0f), 0.5, 0.5 / 96, "just inside"));
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(ImagesNear, NamesTheWorstPixelDrawsItAndSavesThePictures)
{
    Image actual = flat(100, 50, 1.0f);
    actual.pixels[(40 * 100 + 99) * 3 + 1] = 0.75f;
    actual.pixels[(2 * 100 + 3) * 3] = 1.05f;
    const testing::AssertionResult result =
        images_near(actual, flat(100, 50, 1.0f), 0.01, 1.0, "eight bits");
    ASSERT_FALSE(result);
    const std::string text = result.message();
    EXPECT_NE(text.find("worst at pixel (99, 40), channel G: actual 0.75, expected 1\n"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("max |difference| 0.25, allowed 0.01  <- broken"), std::string::npos);
    EXPECT_NE(text.find("allowed because: eight bits"), std::string::npos);
    EXPECT_NE(text.find(std::string(63, ' ').append("#|")), std::string::npos) << text;
    EXPECT_NE(text.find("  | o "), std::string::npos) << text;

    const std::string stem =
        (folder_ / "ImagesNear_NamesTheWorstPixelDrawsItAndSavesThePictures").string();
    EXPECT_EQ(write::read_exr(stem + "_actual.exr", {"R", "G", "B"}).pixels, actual.pixels);
    EXPECT_EQ(write::read_exr(stem + "_expected.exr", {"R"}).at(0, 0, 0), 1.0f);
    EXPECT_EQ(write::read_exr(stem + "_difference_x10.exr", {"G"}).at(99, 40, 0), 2.5f);

    // A second failure of the same test keeps the first one's pictures.
    EXPECT_FALSE(images_near(flat(2, 2, 0), flat(2, 2, 1), 0, 0, "none"));
    EXPECT_TRUE(fs::exists(stem + "_2_actual.exr"));
}

TEST_F(ImagesNear, TheMeanAloneCanFail)
{
    const testing::AssertionResult result =
        images_near(flat(8, 4, 1.25f), flat(8, 4, 1.0f), 0.5, 0.125, "no bias");
    ASSERT_FALSE(result);
    EXPECT_NE(
        std::string(result.message()).find("mean |difference| 0.25, allowed 0.125  <- broken"),
        std::string::npos)
        << result.message();
    EXPECT_NE(std::string(result.message()).find("|........|"), std::string::npos)
        << result.message();
}

TEST_F(ImagesNear, NanNeverPasses)
{
    constexpr double kAnything = std::numeric_limits<double>::infinity();
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        Image broken = flat(8, 4, 1.0f);
        broken.pixels[(3 * 8 + 2) * 3 + 2] = bad;
        const testing::AssertionResult result =
            images_near(broken, flat(8, 4, 1.0f), kAnything, kAnything, "none");
        ASSERT_FALSE(result);
        EXPECT_NE(std::string(result.message()).find("first at pixel (2, 3), channel B"),
                  std::string::npos)
            << result.message();
        EXPECT_NE(std::string(result.message()).find("|  N     |"), std::string::npos);
        EXPECT_FALSE(images_near(flat(8, 4, 1.0f), broken, kAnything, kAnything, "none"));
        EXPECT_FALSE(images_near(broken, broken, kAnything, kAnything, "none"));
    }
}

TEST_F(ImagesNear, ShapesMustAgree)
{
    const testing::AssertionResult size = images_near(flat(8, 4, 1), flat(4, 8, 1), 1, 1, "none");
    ASSERT_FALSE(size);
    EXPECT_NE(std::string(size.message()).find("8 x 4 pixels of (R, G, B), 96 values"),
              std::string::npos)
        << size.message();
    Image renamed = flat(8, 4, 1);
    renamed.channels = {"B", "G", "R"};
    EXPECT_FALSE(images_near(renamed, flat(8, 4, 1), 1, 1, "none"));
    Image torn = flat(8, 4, 1);
    torn.pixels.pop_back();
    EXPECT_FALSE(images_near(torn, torn, 1, 1, "none"));
    EXPECT_FALSE(images_near(Image{}, Image{}, 1, 1, "none"));
}

}  // namespace
}  // namespace fumarole::test
