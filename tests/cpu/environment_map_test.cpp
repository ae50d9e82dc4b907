#include <fumarole/asset/environment_map.h>

#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

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
        asset::load_environment(file);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(EnvironmentMap, ReadsLinearRowsFromTheZenith)
{
    const TempFolder folder;
    std::vector<float> values;
    for (int i = 0; i < 4 * 2 * 3; ++i)
        values.push_back(static_cast<float>(i) * 0.25f);
    const Environment map = asset::load_environment(write_picture(
        folder.path() / "a.exr", OIIO::ImageSpec(4, 2, 3, OIIO::TypeDesc::FLOAT), values));
    EXPECT_EQ(map.width, 4);
    EXPECT_EQ(map.height, 2);
    ASSERT_EQ(map.radiance.size(), 8u);
    for (std::size_t i = 0; i < 8; ++i)
        EXPECT_EQ(map.radiance[i], glm::vec3(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
}

TEST(EnvironmentMap, ReadsRadianceHdr)
{
    const TempFolder folder;
    // Flat RGBE: (128, 64, 32) * 2^(e - 136)
    const std::string bytes = std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") +
                              std::string("\x80\x40\x20\x81\x80\x80\x80\x8a", 8);
    const Environment map = asset::load_environment(folder.write("a.hdr", bytes));
    ASSERT_EQ(map.radiance.size(), 2u);
    EXPECT_EQ(map.width, 2);
    EXPECT_NEAR(map.radiance[0].r, 1, 0.01);
    EXPECT_NEAR(map.radiance[0].g, 0.5, 0.01);
    EXPECT_NEAR(map.radiance[0].b, 0.25, 0.01);
    EXPECT_NEAR(map.radiance[1].r, 512, 4);
}

TEST(EnvironmentMap, ClearsWhatIsNoLight)
{
    const TempFolder folder;
    const std::vector<float> values = {kNan, 1, 2, 3, kInfinity, 4, 5, 6, -7, -kInfinity, 8, 1e30f};
    const Environment map = asset::load_environment(write_picture(
        folder.path() / "a.exr", OIIO::ImageSpec(4, 1, 3, OIIO::TypeDesc::FLOAT), values));
    ASSERT_EQ(map.radiance.size(), 4u);
    EXPECT_EQ(map.radiance[0], glm::vec3(0, 1, 2));
    EXPECT_EQ(map.radiance[1], glm::vec3(3, 0, 4));
    EXPECT_EQ(map.radiance[2], glm::vec3(5, 6, 0));
    EXPECT_EQ(map.radiance[3], glm::vec3(0, 8, 1e30f));
}

TEST(EnvironmentMap, ReplicatesGreyAndDropsAlpha)
{
    const TempFolder folder;
    const Environment grey = asset::load_environment(
        write_picture(folder.path() / "y.exr", OIIO::ImageSpec(2, 1, 1, OIIO::TypeDesc::FLOAT),
                      std::vector<float>{0.5f, 2}));
    EXPECT_EQ(grey.radiance.at(0), glm::vec3(0.5f));
    EXPECT_EQ(grey.radiance.at(1), glm::vec3(2));
    const Environment grey_alpha = asset::load_environment(
        write_picture(folder.path() / "ya.png", OIIO::ImageSpec(2, 1, 2, OIIO::TypeDesc::UINT8),
                      std::vector<unsigned char>{255, 255, 0, 255}));
    EXPECT_EQ(grey_alpha.radiance.at(0), glm::vec3(1));
    EXPECT_EQ(grey_alpha.radiance.at(1), glm::vec3(0));
    const Environment alpha = asset::load_environment(
        write_picture(folder.path() / "a.exr", OIIO::ImageSpec(1, 1, 4, OIIO::TypeDesc::FLOAT),
                      std::vector<float>{1, 2, 3, 0.5f}));
    EXPECT_EQ(alpha.radiance.at(0), glm::vec3(1, 2, 3));
}

TEST(EnvironmentMap, TakesDisplayPicturesAsSrgb)
{
    const TempFolder folder;
    const OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::UINT8);
    const std::vector<unsigned char> values = {255, 188, 0, 10, 128, 64};
    const Environment map =
        asset::load_environment(write_picture(folder.path() / "a.png", spec, values));
    EXPECT_NEAR(map.radiance.at(0).r, 1, 1e-6);
    EXPECT_NEAR(map.radiance.at(0).g, 0.5028, 1e-3);
    EXPECT_EQ(map.radiance.at(0).b, 0);
    EXPECT_NEAR(map.radiance.at(1).r, 10 / 255.0 / 12.92, 1e-6);
    EXPECT_NEAR(map.radiance.at(1).g, 0.2159, 1e-3);
    const Environment jpeg = asset::load_environment(write_picture(
        folder.path() / "a.jpg", spec, std::vector<unsigned char>{188, 188, 188, 188, 188, 188}));
    EXPECT_NEAR(jpeg.radiance.at(0).g, 0.5028, 0.02);
}

TEST(EnvironmentMap, PutsAStoredPartWhereItBelongs)
{
    const TempFolder folder;
    OIIO::ImageSpec spec(2, 1, 3, OIIO::TypeDesc::FLOAT);
    spec.x = 3;
    spec.y = 1;
    spec.full_x = spec.full_y = 0;
    spec.full_width = 4;
    spec.full_height = 2;
    const Environment map = asset::load_environment(
        write_picture(folder.path() / "a.exr", spec, std::vector<float>{1, 2, 3, 9, 9, 9}));
    EXPECT_EQ(map.width, 4);
    EXPECT_EQ(map.height, 2);
    ASSERT_EQ(map.radiance.size(), 8u);
    EXPECT_EQ(map.radiance[7], glm::vec3(1, 2, 3));  // and its right half lies outside
    for (std::size_t i = 0; i < 7; ++i)
        EXPECT_EQ(map.radiance[i], glm::vec3(0));
}

TEST(EnvironmentMap, RefusesWhatIsTooLarge)
{
    const TempFolder folder;
    const std::string header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
    const std::string wide =
        problem(folder.write("w.hdr", header + "-Y 10 +X 16385\n" + std::string(64, '\1')));
    EXPECT_NE(wide.find("16385 x 10"), std::string::npos) << wide;
    EXPECT_NE(wide.find("16384 x 8192"), std::string::npos) << wide;
    const std::string tall =
        problem(folder.write("t.hdr", header + "-Y 8193 +X 10\n" + std::string(64, '\1')));
    EXPECT_NE(tall.find("8193"), std::string::npos) << tall;
}

TEST(EnvironmentMap, NamesAFileThatCannotBeRead)
{
    const TempFolder folder;
    const auto expect_problem = [](const fs::path& file, const char* expected) {
        const std::string message = problem(file);
        EXPECT_TRUE(message.starts_with(file.string() + ": ")) << message;
        EXPECT_NE(message.find(expected), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    };
    expect_problem(folder.path() / "gone.exr", "no such environment map");
    expect_problem(folder.path(), "not a file");
    expect_problem(folder.write("text.exr", "hello"), "cannot be read as a picture");
    expect_problem(folder.write("empty.hdr", ""), "cannot be read as a picture");
    expect_problem(folder.write("no_extension", "hello"), "cannot be read as a picture");
}

TEST(EnvironmentMap, RefusesPicturesCutShort)
{
    const TempFolder folder;
    std::vector<float> values(64 * 32 * 3);
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = static_cast<float>(i % 97);
    const OIIO::ImageSpec spec(64, 32, 3, OIIO::TypeDesc::FLOAT);
    for (const char* name : {"a.exr", "a.hdr", "a.png"}) {
        const std::string bytes =
            test::read_bytes(write_picture(folder.path() / name, spec, values));
        for (std::size_t eighth = 0; eighth < 8; ++eighth)
            EXPECT_NE(problem(folder.write(std::string("cut_") + name,
                                           bytes.substr(0, bytes.size() * eighth / 8))),
                      "")
                << name << " " << eighth;
    }
}

TEST(EnvironmentMap, ReadsMapsOfOtherPeople)
{
    const fs::path folder = fs::path(FUM_TEST_SHARED) / "vdb" / "external" / "env";
    if (!fs::exists(folder / "studio.exr"))
        GTEST_SKIP() << "no environment maps in " << folder;
    const auto size = [&](const char* name) {
        const Environment map = asset::load_environment(folder / name);
        EXPECT_EQ(map.radiance.size(), static_cast<std::size_t>(map.width * map.height));
        return glm::ivec2(map.width, map.height);
    };
    EXPECT_EQ(size("StinsonBeach.hdr"), glm::ivec2(1024, 512));
    EXPECT_EQ(size("rooftop_small.hdr"), glm::ivec2(300, 150));
    EXPECT_EQ(size("studio.exr"), glm::ivec2(512, 256));
    EXPECT_EQ(size("sunset.exr"), glm::ivec2(512, 256));
    EXPECT_EQ(size("grid-small.exr"), glm::ivec2(256, 256));
}

}  // namespace
}  // namespace fumarole
