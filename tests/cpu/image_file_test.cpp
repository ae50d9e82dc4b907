#include <fumarole/asset/image_file.h>

#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>
#include <cstdint>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

template <typename T>
fs::path write_picture(const fs::path& file, const OIIO::ImageSpec& spec,
                       const std::vector<T>& values)
{
    const auto output = OIIO::ImageOutput::create(file.string());
    EXPECT_TRUE(output && output->open(file.string(), spec)) << OIIO::geterror();
    EXPECT_TRUE(output->write_image(OIIO::BaseTypeFromC<T>::value, values.data()));
    EXPECT_TRUE(output->close());
    return file;
}

std::string problem(const fs::path& file)
{
    try {
        asset::load_image(file);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(ImageFile, KeepsWhatAnExrHasMultipliedAlready)
{
    const TempFolder folder;
    const std::vector<float> values{0.25f, 0.5f, 1.0f, 0.5f, 3.0f, 0.0f, 0.0f, 0.0f};
    const TransparentImage image = asset::load_image(write_picture(
        folder.path() / "a.exr", OIIO::ImageSpec(2, 1, 4, OIIO::TypeDesc::FLOAT), values));
    EXPECT_EQ(image.width, 2);
    EXPECT_EQ(image.height, 1);
    ASSERT_EQ(image.texels.size(), 2u);
    EXPECT_EQ(image.texels[0], glm::vec4(0.25f, 0.5f, 1.0f, 0.5f));
    EXPECT_EQ(image.texels[1], glm::vec4(3.0f, 0.0f, 0.0f, 0.0f));  // it glows and hides nothing
}

TEST(ImageFile, MultipliesWhatAPngHasNot)
{
    const TempFolder folder;
    OIIO::ImageSpec spec(1, 2, 4, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    const std::vector<std::uint8_t> values{255, 0, 188, 51, 255, 255, 255, 0};
    const TransparentImage image =
        asset::load_image(write_picture(folder.path() / "a.png", spec, values));
    ASSERT_EQ(image.texels.size(), 2u);
    // 188 of 255 is a linear 0.5029 (IEC 61966-2-1).
    const float alpha = 0.2f;
    EXPECT_FLOAT_EQ(image.texels[0].r, alpha);
    EXPECT_EQ(image.texels[0].g, 0.0f);
    EXPECT_NEAR(image.texels[0].b, 0.50289f * alpha, 1e-5f);
    EXPECT_FLOAT_EQ(image.texels[0].a, alpha);
    EXPECT_EQ(image.texels[1], glm::vec4(0));
}

TEST(ImageFile, IsOpaqueWithoutAnAlpha)
{
    const TempFolder folder;
    const TransparentImage image = asset::load_image(
        write_picture(folder.path() / "a.exr", OIIO::ImageSpec(1, 1, 3, OIIO::TypeDesc::FLOAT),
                      std::vector<float>{1, -2, 3}));
    EXPECT_EQ(image.texels.at(0), glm::vec4(1, 0, 3, 1));
}

TEST(ImageFile, NamesWhatIsWrong)
{
    const TempFolder folder;
    EXPECT_EQ(problem(folder.path() / "no.png"),
              (folder.path() / "no.png").string() + ": no such picture");
    EXPECT_EQ(problem(folder.path()), folder.path().string() + ": is not a file");
    const fs::path text = folder.write("a.png", "not a picture");
    EXPECT_TRUE(problem(text).starts_with(text.string() + ": cannot be read as a picture"))
        << problem(text);
}

}  // namespace
}  // namespace fumarole
