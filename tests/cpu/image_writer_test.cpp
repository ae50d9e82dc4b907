// Files hold what the picture held, are whole or not there, and a picture on a screen has the
// brightness that the transform promises.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>
#include <memory>
#include <string>

#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <fumarole/errors.h>

namespace fumarole::write {
namespace {

namespace fs = std::filesystem;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A picture of which no two values are equal.
Image distinct_picture(int width, int height, std::vector<std::string> channels)
{
    Image image{width, height, std::move(channels), {}};
    const std::size_t count = static_cast<std::size_t>(width * height) * image.channels.size();
    for (std::size_t i = 0; i < count; ++i) {
        image.pixels.push_back(static_cast<float>(i) * 0.37f - 5);
    }
    return image;
}

// One pixel of each given colour, in a row.
Image row(std::vector<std::string> channels, std::vector<float> pixels)
{
    const int width = static_cast<int>(pixels.size() / channels.size());
    return {width, 1, std::move(channels), std::move(pixels)};
}

std::string bytes_of(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string error_of(const std::function<void()>& action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

class ImageWriter : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "fumarole_writer_XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] std::vector<std::string> files() const
    {
        std::vector<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
            names.push_back(entry.path().filename().string());
        }
        std::sort(names.begin(), names.end());
        return names;
    }

    fs::path folder_;
};

using Names = std::vector<std::string>;

// The 8-bit values of a PNG as stored: straight alpha, no colour conversion.
struct Png {
    OIIO::ImageSpec spec;
    std::vector<std::uint8_t> bytes;
};

Png read_png(const fs::path& file)
{
    OIIO::ImageSpec ask;
    ask.attribute("oiio:UnassociatedAlpha", 1);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(file.string(), &ask);
    if (!input) {
        ADD_FAILURE() << OIIO::geterror();
        return {};
    }
    Png png{input->spec(), {}};
    png.bytes.resize(png.spec.image_pixels() * static_cast<std::size_t>(png.spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, png.bytes.data()))
        << input->geterror();
    return png;
}

// IEC 61966-2-1, in double: what a screen's 8 bits should be.
int srgb_byte(double linear)
{
    const double x = std::clamp(linear, 0.0, 1.0);
    const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<int>(std::lround(encoded * 255));
}

constexpr Display kSrgb = {.exposure_ev = 0, .transform = Display::Transform::srgb};
constexpr Display kFilmic = {.exposure_ev = 0, .transform = Display::Transform::filmic};

// ---- EXR ----------------------------------------------------------------------------------------

TEST_F(ImageWriter, ExrKeepsEveryChannelToTheBit)
{
    const Image image = distinct_picture(
        7, 5,
        {"R", "G", "B", "A", "scattering.R", "scattering.G", "scattering.B", "transmittance.R",
         "transmittance.G", "transmittance.B", "surface.R", "surface_lit.R", "depth.Z"});
    write_exr(image, folder_ / "x.exr");

    const Image back = read_exr(folder_ / "x.exr", image.channels);
    EXPECT_EQ(back.width, 7);
    EXPECT_EQ(back.height, 5);
    EXPECT_EQ(back.channels, image.channels);
    EXPECT_EQ(back.pixels, image.pixels);

    Names stored = exr_channels(folder_ / "x.exr");
    Names written = image.channels;
    std::sort(stored.begin(), stored.end());
    std::sort(written.begin(), written.end());
    EXPECT_EQ(stored, written);
    EXPECT_EQ(files(), Names{"x.exr"});
}

TEST_F(ImageWriter, ExrKeepsExtremeNumbers)
{
    using Limits = std::numeric_limits<float>;
    const Image image = row({"R"}, {-0.0f, Limits::denorm_min(), Limits::min(), Limits::max(),
                                    Limits::lowest(), 1e-30f, 65505.0f});
    write_exr(image, folder_ / "x.exr");
    const Image back = read_exr(folder_ / "x.exr", {"R"});
    EXPECT_EQ(back.pixels, image.pixels);
    EXPECT_TRUE(std::signbit(back.pixels[0]));
}

TEST_F(ImageWriter, ExrIsReadInTheOrderAsked)
{
    const Image image = distinct_picture(3, 2, {"R", "G", "B", "depth"});
    write_exr(image, folder_ / "x.exr");
    const Image back = read_exr(folder_ / "x.exr", {"depth", "G", "depth"});
    ASSERT_EQ(back.pixels.size(), 18u);
    for (int y = 0; y < 2; ++y) {
        for (int x = 0; x < 3; ++x) {
            EXPECT_EQ(back.at(x, y, 0), image.at(x, y, 3));
            EXPECT_EQ(back.at(x, y, 1), image.at(x, y, 1));
            EXPECT_EQ(back.at(x, y, 2), image.at(x, y, 3));
        }
    }
}

TEST_F(ImageWriter, ExrWithNoChannelNamedIsReadWhole)
{
    const Image image = distinct_picture(3, 2, {"R", "G", "B", "depth"});
    write_exr(image, folder_ / "x.exr");
    const Image back = read_exr(folder_ / "x.exr", {});
    EXPECT_EQ(back.channels, exr_channels(folder_ / "x.exr"));
    EXPECT_EQ(back.pixels.size(), image.pixels.size());
}

TEST_F(ImageWriter, ExrIsLinearFloatZipAndTheSameBytesEachTime)
{
    const Image image = distinct_picture(64, 64, {"R", "G", "B"});  // several zip blocks, threads
    write_exr(image, folder_ / "x.exr");
    const std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::open((folder_ / "x.exr").string());
    ASSERT_TRUE(input) << OIIO::geterror();
    EXPECT_EQ(input->spec().format, OIIO::TypeDesc::FLOAT);
    EXPECT_EQ(input->spec().get_string_attribute("compression"), "zip");
    // A time of day would make every file differ.
    EXPECT_EQ(input->spec().get_string_attribute("DateTime"), "");
    EXPECT_EQ(input->spec().get_string_attribute("Software"), "Fumarole");

    write_exr(image, folder_ / "y.exr");
    EXPECT_EQ(bytes_of(folder_ / "x.exr"), bytes_of(folder_ / "y.exr"));
}

TEST_F(ImageWriter, ExrSaysWhatMadeItAndWhen)
{
    write_exr(
        row({"R"}, {1}), folder_ / "x.exr",
        {.captured = "2026:11:28 02:40:00", .software = "Fumarole 9.8", .command = "a 'b c'"});
    const std::string bytes = bytes_of(folder_ / "x.exr");
    // The header's own names (OpenEXR's standard attributes), as other programs look them up.
    const auto text = [](const std::string& name, const std::string& value) {
        const char size = static_cast<char>(value.size());
        return name + '\0' + "string" + '\0' + size + std::string(3, '\0') + value;
    };
    for (const std::string& entry :
         {text("capDate", "2026:11:28 02:40:00"), text("commandLine", "a 'b c'")}) {
        EXPECT_NE(bytes.find(entry), std::string::npos) << entry;
    }
    EXPECT_NE(bytes.find("Fumarole 9.8"), std::string::npos);
}

TEST_F(ImageWriter, HalfFloatsAreTheNearestOnesAndDepthIsKept)
{
    // Halves have 11 bits: 2049 lies between 2048 and 2050, which is the odd one of the two.
    const Image image = row({"R", "depth.Z"}, {1.0f, 1e10f, 2049.0f, 2049.0f, 0x1p-24f, 0x1p-24f,
                                               65504.0f, 65504.0f, 1e6f, 1e6f, -1e6f, 70000.5f});
    write_exr(image, folder_ / "x.exr", {.half = true});
    const std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::open((folder_ / "x.exr").string());
    ASSERT_TRUE(input) << OIIO::geterror();
    const OIIO::ImageSpec& spec = input->spec();
    EXPECT_EQ(spec.channelformat(spec.channelindex("R")), OIIO::TypeDesc::HALF);
    EXPECT_EQ(spec.channelformat(spec.channelindex("depth.Z")), OIIO::TypeDesc::FLOAT);
    EXPECT_EQ(read_exr(folder_ / "x.exr", {"R"}).pixels,
              (std::vector<float>{1.0f, 2048.0f, 0x1p-24f, 65504.0f, 65504.0f, -65504.0f}));
    EXPECT_EQ(read_exr(folder_ / "x.exr", {"depth.Z"}).pixels,
              (std::vector<float>{1e10f, 2049.0f, 0x1p-24f, 65504.0f, 1e6f, 70000.5f}));
}

TEST_F(ImageWriter, APartKeepsTheDisplayWindowOfTheWhole)
{
    Image part = distinct_picture(4, 3, {"R", "G"});
    part.whole = {20, 10};
    part.origin = {7, 2};
    write_exr(part, folder_ / "x.exr");
    const std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::open((folder_ / "x.exr").string());
    ASSERT_TRUE(input) << OIIO::geterror();
    EXPECT_EQ(input->spec().x, 7);
    EXPECT_EQ(input->spec().y, 2);
    EXPECT_EQ(input->spec().width, 4);
    EXPECT_EQ(input->spec().height, 3);
    EXPECT_EQ(input->spec().full_x, 0);
    EXPECT_EQ(input->spec().full_y, 0);
    EXPECT_EQ(input->spec().full_width, 20);
    EXPECT_EQ(input->spec().full_height, 10);
    const Image back = read_exr(folder_ / "x.exr", {"R", "G"});
    EXPECT_EQ(back.pixels, part.pixels);
    EXPECT_EQ(back.whole, part.whole);
    EXPECT_EQ(back.origin, part.origin);
}

TEST_F(ImageWriter, ExrReplacesTheOldFile)
{
    write_exr(row({"R"}, {1}), folder_ / "x.exr");
    write_exr(row({"R"}, {2}), folder_ / "x.exr");
    EXPECT_EQ(read_exr(folder_ / "x.exr", {"R"}).pixels, std::vector<float>{2});
    EXPECT_EQ(files(), Names{"x.exr"});
}

TEST_F(ImageWriter, FileHasTheRightsOfAnyNewFile)
{
    const mode_t old_mask = ::umask(022);
    write_exr(row({"R"}, {1}), folder_ / "x.exr");
    ::umask(old_mask);
    EXPECT_EQ(fs::status(folder_ / "x.exr").permissions(), fs::perms(0644));
}

// ---- Failing writes -----------------------------------------------------------------------------

TEST_F(ImageWriter, NanIsNamedAndNothingIsWritten)
{
    Image image = distinct_picture(4, 3, {"R", "scattering.G"});
    image.pixels[(2 * 4 + 1) * 2 + 1] = kNan;
    const std::string error = error_of([&] { write_exr(image, folder_ / "x.exr"); });
    EXPECT_NE(error.find((folder_ / "x.exr").string()), std::string::npos) << error;
    EXPECT_NE(error.find("'scattering.G' is NaN at pixel (1, 2)"), std::string::npos) << error;
    EXPECT_TRUE(files().empty());

    image.pixels[(2 * 4 + 1) * 2 + 1] = -kInfinity;
    const std::string infinite = error_of([&] { write_exr(image, folder_ / "x.exr"); });
    EXPECT_NE(infinite.find("is infinite at pixel (1, 2)"), std::string::npos) << infinite;
    EXPECT_TRUE(files().empty());
}

TEST_F(ImageWriter, MissingFolderIsNamedWithItsRemedy)
{
    const fs::path file = folder_ / "out" / "x.exr";
    EXPECT_EQ(error_of([&] { write_exr(row({"R"}, {1}), file); }),
              file.string() + ": no such folder '" + (folder_ / "out").string() +
                  "'; create it first");
}

TEST_F(ImageWriter, FolderThatIsAFileIsNamed)
{
    std::ofstream(folder_ / "plain") << "text";
    const fs::path file = folder_ / "plain" / "x.png";
    EXPECT_EQ(error_of([&] {
                  write_png(row({"R", "G", "B"}, {1, 1, 1}), kSrgb, file);
              }),
              file.string() + ": '" + (folder_ / "plain").string() +
                  "' is not a folder; choose another");
    EXPECT_EQ(bytes_of(folder_ / "plain"), "text");
}

TEST_F(ImageWriter, OnlyRegularFilesAreReplaced)
{
    EXPECT_NE(error_of([&] { write_exr(row({"R"}, {1}), folder_); }).find("is a folder"),
              std::string::npos);
    write_exr(row({"R"}, {1}), "/dev/null");  // takes the bytes, and stays what it is
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_NE(error_of([&] { write_exr(row({"R"}, {1}), "/dev/full"); }).find("disk full"),
              std::string::npos);
    const fs::path pipe = folder_ / "pipe.exr", link = folder_ / "link.exr";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_NE(error_of([&] { write_exr(row({"R"}, {1}), pipe); }).find("nobody reads this pipe"),
              std::string::npos);
    fs::create_symlink("target.exr", link);
    write_exr(row({"R"}, {1}), folder_ / "target.exr");
    write_exr(row({"R", "G"}, {1, 2}), link);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_EQ(read_exr(folder_ / "target.exr", {"R", "G"}).channels.size(), 2u);
    for (const char* name : {"pipe.exr", "link.exr", "target.exr"})
        fs::remove(folder_ / name);
    EXPECT_NE(error_of([&] { write_exr(row({"R"}, {1}), ""); }).find("no file name"),
              std::string::npos);
    EXPECT_NE(error_of([&] {
                  write_exr(row({"R"}, {1}), folder_ / (std::string(300, 'x') + ".exr"));
              }).find("too long"),
              std::string::npos);
    EXPECT_TRUE(files().empty());
}

TEST_F(ImageWriter, LongestLegalNameCanBeWritten)
{
    const std::string name = std::string(251, 'x') + ".exr";  // 255 bytes, NAME_MAX
    write_exr(row({"R"}, {1}), folder_ / name);
    EXPECT_EQ(files(), Names{name});
}

// Lets no file of this process grow over `bytes`: a full disk that needs no disk.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes)
    {
        ::getrlimit(RLIMIT_FSIZE, &old_limit_);
        rlimit limit = old_limit_;
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        old_handler_ = std::signal(SIGXFSZ, SIG_IGN);  // write() then fails with EFBIG
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;
    ~FileSizeLimit()
    {
        ::setrlimit(RLIMIT_FSIZE, &old_limit_);
        std::signal(SIGXFSZ, old_handler_);
    }

private:
    rlimit old_limit_{};
    void (*old_handler_)(int) = SIG_DFL;
};

TEST_F(ImageWriter, FailingWriteLeavesTheOldFileAndNoTemporary)
{
    write_exr(row({"R"}, {1}), folder_ / "x.exr");
    write_png(row({"R", "G", "B"}, {1, 0, 0}), kSrgb, folder_ / "x.png");
    const std::string old_exr = bytes_of(folder_ / "x.exr");
    const std::string old_png = bytes_of(folder_ / "x.png");

    // Noise does not compress: some 40 kB as EXR, 10 kB as PNG.
    Image large = distinct_picture(60, 60, {"R", "G", "B"});
    std::uint32_t state = 1;
    for (float& value : large.pixels) {
        state = state * 1664525u + 1013904223u;
        value = static_cast<float>(state) * 0x1p-32f;
    }
    std::string exr_error;
    std::string png_error;
    {
        const FileSizeLimit limit(4096);
        exr_error = error_of([&] { write_exr(large, folder_ / "x.exr"); });
        png_error = error_of([&] { write_png(large, kSrgb, folder_ / "x.png"); });
    }
    EXPECT_NE(exr_error.find("over the limit for a file"), std::string::npos) << exr_error;
    EXPECT_NE(png_error.find("over the limit for a file"), std::string::npos) << png_error;
    EXPECT_EQ(bytes_of(folder_ / "x.exr"), old_exr);
    EXPECT_EQ(bytes_of(folder_ / "x.png"), old_png);
    EXPECT_EQ(files(), (Names{"x.exr", "x.png"}));
}

// What a child process found out, as its exit code.
enum FullDisk { kNamedAndClean, kNotNamed, kLeftovers, kNoRightToMount };

// A name space of mounts for this process alone, so that what it mounts goes when it does.
bool enter_own_mounts()
{
    if (::unshare(CLONE_NEWNS) != 0) {
        // No root: become one in a name space of users, where a tmpfs needs our ids to exist.
        const std::string user = "0 " + std::to_string(::geteuid()) + " 1";
        const std::string group = "0 " + std::to_string(::getegid()) + " 1";
        if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) {
            return false;
        }
        std::ofstream("/proc/self/setgroups") << "deny";
        std::ofstream("/proc/self/uid_map") << user;
        std::ofstream("/proc/self/gid_map") << group;
    }
    return ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
}

FullDisk fill_a_small_disk(const fs::path& disk)
{
    if (!enter_own_mounts() || ::mount("none", disk.c_str(), "tmpfs", 0, "size=8k") != 0) {
        return kNoRightToMount;
    }
    // PNG, since OpenEXR's threads do not survive a fork; the path to the disk is the same.
    Image noise = distinct_picture(200, 200, {"R", "G", "B"});
    std::uint32_t state = 1;
    for (float& value : noise.pixels) {
        state = state * 1664525u + 1013904223u;
        value = static_cast<float>(state) * 0x1p-32f;
    }
    const std::string error = error_of([&] { write_png(noise, kSrgb, disk / "x.png"); });
    if (error.find("disk full; free 0.1 MB in folder") == std::string::npos) {
        std::cerr << error << '\n';
        return kNotNamed;
    }
    return fs::is_empty(disk) ? kNamedAndClean : kLeftovers;
}

TEST_F(ImageWriter, FullDiskIsNamedAndLeftClean)
{
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        ::_exit(fill_a_small_disk(folder_));
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == kNoRightToMount) {
        GTEST_SKIP() << "needs the right to mount a small tmpfs";
    }
    EXPECT_EQ(WEXITSTATUS(status), kNamedAndClean);
}

TEST_F(ImageWriter, ChannelNamesAreDistinct)
{
    const std::string error = error_of([&] {
        write_exr(row({"R", "R"}, {1, 2}), folder_ / "x.exr");
    });
    EXPECT_NE(error.find("channel name 'R' is used twice"), std::string::npos) << error;
    EXPECT_NE(error_of([&] { write_exr(row({""}, {1}), folder_ / "x.exr"); }).find("is empty"),
              std::string::npos);
    EXPECT_NE(error_of([&] { write_exr(Image{}, folder_ / "x.exr"); }).find("picture is empty"),
              std::string::npos);
    EXPECT_TRUE(files().empty());
}

// ---- Failing reads ------------------------------------------------------------------------------

TEST_F(ImageWriter, MissingChannelIsNamedWithThoseThere)
{
    const fs::path file = folder_ / "x.exr";
    write_exr(row({"R", "G"}, {1, 2}), file);
    EXPECT_EQ(error_of([&] {
                  read_exr(file, {"R", "depth"});
              }),
              file.string() + ": no channel 'depth' (has: 'R', 'G'); name one that it has");
}

TEST_F(ImageWriter, WhatIsNoExrIsRefusedInOneLine)
{
    EXPECT_NE(error_of([&] { read_exr(folder_ / "none.exr", {"R"}); }).find("no such file"),
              std::string::npos);
    EXPECT_NE(error_of([&] { exr_channels(folder_); }).find("is a folder"), std::string::npos);

    // A PNG by another name must not pass for linear light.
    write_png(row({"R", "G", "B"}, {1, 1, 1}), kSrgb, folder_ / "x.png");
    fs::rename(folder_ / "x.png", folder_ / "png.exr");
    std::ofstream(folder_ / "text.exr") << "not a picture\n";
    std::ofstream(folder_ / "empty.exr") << "";
    for (const char* name : {"png.exr", "text.exr", "empty.exr"}) {
        const std::string error = error_of([&] { read_exr(folder_ / name, {"R"}); });
        EXPECT_NE(error.find("not a readable EXR file"), std::string::npos) << error;
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    }
}

TEST_F(ImageWriter, TornExrIsRefusedWhereverItIsTorn)
{
    write_exr(distinct_picture(33, 21, {"R", "G", "B"}), folder_ / "x.exr");
    const std::string whole = bytes_of(folder_ / "x.exr");
    for (std::size_t length = 1; length < whole.size(); length += whole.size() / 40) {
        std::ofstream(folder_ / "torn.exr", std::ios::binary | std::ios::trunc)
            .write(whole.data(), static_cast<std::streamsize>(length));
        const std::string error = error_of([&] { read_exr(folder_ / "torn.exr", {"R"}); });
        EXPECT_NE(error, "no error") << length << " of " << whole.size() << " bytes";
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    }
}

TEST_F(ImageWriter, OverscanAndIntegerExrAreRefused)
{
    const std::vector<float> pixels(16, 1.0f);
    OIIO::ImageSpec overscan(4, 4, 1, OIIO::TypeDesc::FLOAT);
    overscan.channelnames = {"R"};
    overscan.full_width = 3;
    OIIO::ImageSpec integer(4, 4, 1, OIIO::TypeDesc::UINT);
    integer.channelnames = {"id"};
    for (const OIIO::ImageSpec& spec : {overscan, integer}) {
        const std::string name = (folder_ / (spec.channelnames[0] + ".exr")).string();
        const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(name);
        ASSERT_TRUE(output && output->open(name, spec) &&
                    output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) && output->close());
    }
    EXPECT_NE(error_of([&] { read_exr(folder_ / "R.exr", {"R"}); }).find("data window"),
              std::string::npos);
    EXPECT_NE(error_of([&] { read_exr(folder_ / "id.exr", {"id"}); }).find("holds integers"),
              std::string::npos);
}

// ---- PNG ----------------------------------------------------------------------------------------

TEST_F(ImageWriter, PngRampIsSrgb)
{
    Image image{256, 1, {"R", "G", "B"}, {}};
    for (int x = 0; x < 256; ++x) {
        const float v = static_cast<float>(x) / 255;
        image.pixels.insert(image.pixels.end(), {v, v * v, 2 * v - 0.5f});  // some out of range
    }
    write_png(image, kSrgb, folder_ / "x.png");
    const Png png = read_png(folder_ / "x.png");
    ASSERT_EQ(png.spec.nchannels, 3);
    ASSERT_EQ(png.spec.width, 256);
    EXPECT_EQ(png.spec.format, OIIO::TypeDesc::UINT8);
    EXPECT_EQ(png.spec.get_string_attribute("oiio:ColorSpace"), "sRGB");
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        // Off by one is float against double at a rounding edge.
        EXPECT_NEAR(png.bytes[i], srgb_byte(static_cast<double>(image.pixels[i])), 1) << i;
    }
    EXPECT_EQ(png.bytes[0], 0);
    EXPECT_EQ(png.bytes[255 * 3], 255);
    EXPECT_EQ(files(), Names{"x.png"});
}

// Rows that each of PNG's filters suits best, and each way in which a filter can go wrong.
TEST_F(ImageWriter, PngKeepsEveryByteOfEveryKindOfRow)
{
    constexpr int kWidth = 37, kHeight = 48;
    std::vector<int> bytes;
    std::uint32_t noise = 1;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            for (int c = 0; c < 3; ++c) {
                noise = noise * 1664525u + 1013904223u;
                const int left = x > 0 ? bytes[bytes.size() - 3] : 0;
                const int above = y > 0 ? bytes[bytes.size() - 3 * kWidth] : 0;
                const int random = static_cast<int>(noise >> 24);
                const int kinds[] = {random,
                                     (left + above) / 2 + (random & 63),
                                     7 * x + 40 * c,
                                     90 * c,
                                     3 * x * c + 5 * y,
                                     x * x + (x / 5) * y};
                bytes.push_back(kinds[y / 8] & 255);
            }
        }
    }
    for (const bool alpha : {false, true}) {
        Image image{kWidth, kHeight, {"R", "G", "B"}, {}};
        if (alpha)
            image.channels.emplace_back("A");
        std::vector<int> expected;
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const bool half = alpha && i / 3 % 2 == 0;
            const double encoded = bytes[i] / 255.0;
            const double linear =
                encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
            image.pixels.push_back(static_cast<float>(linear) * (half ? 0.5f : 1.0f));
            expected.push_back(bytes[i]);
            if (alpha && i % 3 == 2) {
                image.pixels.push_back(half ? 0.5f : 1.0f);
                expected.push_back(half ? 128 : 255);
            }
        }
        write_png(image, kSrgb, folder_ / "x.png");
        const std::vector<std::uint8_t> found = read_png(folder_ / "x.png").bytes;
        EXPECT_EQ(std::vector<int>(found.begin(), found.end()), expected);
    }
}

TEST_F(ImageWriter, PngExposureIsInStops)
{
    write_png(row({"R", "G", "B"}, {0.1f, 0.2f, 0.05f}), {2, Display::Transform::srgb},
              folder_ / "x.png");
    const Png png = read_png(folder_ / "x.png");
    EXPECT_EQ(png.bytes[0], srgb_byte(0.4));
    EXPECT_EQ(png.bytes[1], srgb_byte(0.8));
    EXPECT_EQ(png.bytes[2], srgb_byte(0.2));
}

TEST_F(ImageWriter, PngAlphaIsStraight)
{
    const Image image = row({"A", "B", "G", "R", "depth"},       // any order, any other channels
                            {1.0f,  0.1f,  0.2f, 0.5f,  kNan,    // opaque
                             0.5f,  0.1f,  0.2f, 0.25f, kNan,    // half covered
                             0.25f, 0.25f, 0.0f, 0.5f,  kNan,    // R brighter than its cover
                             0.0f,  0.0f,  0.0f, 0.5f,  kNan,    // light that covers nothing
                             1.5f,  0.0f,  0.0f, 0.5f,  kNan});  // cover out of range
    write_png(image, kSrgb, folder_ / "x.png");
    const Png png = read_png(folder_ / "x.png");
    ASSERT_EQ(png.spec.nchannels, 4);
    const std::vector<std::vector<int>> expected = {
        {srgb_byte(0.5), srgb_byte(0.2), srgb_byte(0.1), 255},
        {srgb_byte(0.5), srgb_byte(0.4), srgb_byte(0.2), 128},
        {255, 0, 255, 64},
        {srgb_byte(0.5), 0, 0, 0},
        {srgb_byte(0.5), 0, 0, 255},
    };
    for (std::size_t pixel = 0; pixel < expected.size(); ++pixel) {
        for (std::size_t c = 0; c < 4; ++c) {
            EXPECT_EQ(png.bytes[pixel * 4 + c], expected[pixel][c]) << pixel << " " << c;
        }
    }
}

TEST_F(ImageWriter, PngAlphaIsRaisedWhereItGlows)
{
    const Image image =
        row({"R", "G", "B", "A", "cover.R", "cover.G", "cover.B"},
            {0.5f,  0.1f, 0.0f, 0.0f, 0.0f,  0.0f, 0.0f,    // a flame alone
             0.25f, 0.2f, 0.1f, 0.5f, 0.25f, 0.2f, 0.1f,    // smoke alone
             0.45f, 0.3f, 0.1f, 0.5f, 0.25f, 0.2f, 0.1f,    // a flame in smoke
             0.26f, 0.2f, 0.1f, 0.9f, 0.25f, 0.2f, 0.1f});  // a spark in thick smoke
    write_png(image, kSrgb, folder_ / "x.png");
    const Png png = read_png(folder_ / "x.png");
    ASSERT_EQ(png.spec.nchannels, 4);
    const auto encoded = [](double linear) { return srgb_byte(linear) / 255.0; };
    const auto pixel = [&](std::size_t i, std::size_t c) {
        return double{png.bytes[4 * i + c] / 255.0};
    };
    constexpr double kByte = 1 / 255.0;
    EXPECT_NEAR(pixel(0, 3), encoded(0.5), kByte) << "the brightest channel";
    for (std::size_t c = 0; c < 3; ++c) {
        const double light[] = {0.5, 0.1, 0}, smoke[] = {0.25, 0.2, 0.1}, both[] = {0.45, 0.3, 0.1};
        EXPECT_NEAR(pixel(0, c) * pixel(0, 3), encoded(light[c]), kByte) << "over black";
        EXPECT_NEAR(pixel(1, c), encoded(smoke[c] / 0.5), kByte);
        EXPECT_NEAR(pixel(2, c) * pixel(2, 3),
                    0.5 * encoded(smoke[c] / 0.5) + encoded(both[c]) - encoded(smoke[c]),
                    2 * kByte);
    }
    EXPECT_NEAR(pixel(1, 3), 0.5, kByte) << "smoke stays as it is";
    EXPECT_GT(pixel(2, 3), 0.5);
    EXPECT_NEAR(pixel(3, 3), 0.9, kByte) << "enough already";
}

TEST_F(ImageWriter, PngNeedsRgbWithoutNan)
{
    const std::string error = error_of([&] {
        write_png(row({"R", "G"}, {1, 2}), kSrgb, folder_ / "x.png");
    });
    EXPECT_NE(error.find("no channel 'B' (has: 'R', 'G')"), std::string::npos) << error;
    const std::string nan = error_of([&] {
        write_png(row({"R", "G", "B"}, {1, kNan, 2}), kSrgb, folder_ / "x.png");
    });
    EXPECT_NE(nan.find("'G' is NaN at pixel (0, 0)"), std::string::npos) << nan;
    EXPECT_TRUE(files().empty());
}

TEST_F(ImageWriter, PngHasTheSameBytesEachTime)
{
    const Image image = distinct_picture(50, 40, {"R", "G", "B", "A"});
    write_png(image, kFilmic, folder_ / "x.png");
    write_png(image, kFilmic, folder_ / "y.png");
    EXPECT_EQ(bytes_of(folder_ / "x.png"), bytes_of(folder_ / "y.png"));
}

// ---- Display transform --------------------------------------------------------------------------

TEST(DisplayTransform, ShowsMiddleGreyAsMiddleGrey)
{
    for (const Display& display : {kSrgb, kFilmic}) {
        const glm::vec3 grey = display_transform(glm::vec3(0.18f), display);
        EXPECT_NEAR(grey.r, 0.4614f, 5e-4f);  // sRGB encoding of 0.18
        EXPECT_EQ(grey.r, grey.g);
        EXPECT_EQ(grey.r, grey.b);
    }
}

TEST(DisplayTransform, StaysInRangeFromBlackToWhite)
{
    constexpr float kHuge = std::numeric_limits<float>::max();
    for (const Display& display : {kSrgb, kFilmic}) {
        EXPECT_EQ(display_transform(glm::vec3(0), display), glm::vec3(0));
        EXPECT_EQ(display_transform(glm::vec3(-1, -kHuge, -0.0f), display), glm::vec3(0));
        for (const float bright : {kHuge, kInfinity}) {
            const glm::vec3 white = display_transform(glm::vec3(bright), display);
            EXPECT_LE(white.r, 1);
            EXPECT_NEAR(white.r, 1, 1e-6f);
        }
    }
    // An exposure that overflows makes light white and leaves black black.
    const glm::vec3 blown = display_transform({0, 1, 1e-3f}, {200, Display::Transform::srgb});
    EXPECT_EQ(blown.r, 0);
    EXPECT_NEAR(blown.g, 1, 1e-6f);
    EXPECT_NEAR(blown.b, 1, 1e-6f);
}

TEST(DisplayTransform, FilmicNeverFallsWhenLightRises)
{
    // Every channel of the output in every channel of the input, and in the exposure.
    std::vector<float> levels = {0};
    for (float level = 1e-4f; level < 1e4f; level *= 1.2f) {
        levels.push_back(level);
    }
    constexpr float kRounding = 1e-6f;
    for (int channel = 0; channel < 3; ++channel) {
        for (const glm::vec3 base : {glm::vec3(0), glm::vec3(0.3f, 0.02f, 0), glm::vec3(5, 1, 0.2f),
                                     glm::vec3(0.1f, 0.2f, 9)}) {
            glm::vec3 previous(0);
            for (const float level : levels) {
                glm::vec3 radiance = base;
                radiance[channel] = level;
                const glm::vec3 shown = display_transform(radiance, kFilmic);
                for (int c = 0; c < 3; ++c) {
                    ASSERT_GE(shown[c], previous[c] - kRounding) << channel << " at " << level;
                }
                previous = shown;
            }
        }
    }
    glm::vec3 previous(0);
    for (float ev = -12; ev <= 12; ev += 0.125f) {
        const glm::vec3 shown =
            display_transform({1, 0.3f, 0.02f}, {ev, Display::Transform::filmic});
        for (int c = 0; c < 3; ++c) {
            ASSERT_GE(shown[c], previous[c] - kRounding) << ev;
        }
        previous = shown;
    }
}

TEST(DisplayTransform, FilmicFireTurnsFromOrangeOverYellowToWhite)
{
    const glm::vec3 fire(1, 0.25f, 0.02f);  // Rec. 709 of a body at about 1500 K
    const auto shown = [&](float ev) {
        return display_transform(fire, {ev, Display::Transform::filmic});
    };
    const glm::vec3 dim = shown(-2);
    const glm::vec3 bright = shown(3);
    const glm::vec3 blinding = shown(10);
    // It never turns pink or green: red is most, blue least.
    for (float ev = -6; ev <= 12; ev += 0.5f) {
        const glm::vec3 c = shown(ev);
        EXPECT_GE(c.r, c.g - 1e-6f) << ev;
        EXPECT_GE(c.g, c.b - 1e-6f) << ev;
    }
    EXPECT_LT(dim.g / dim.r, 0.6f);        // orange
    EXPECT_GT(bright.g / bright.r, 0.8f);  // yellow: green has come up
    EXPECT_LT(bright.b / bright.r, 0.8f);  // and blue has not yet
    EXPECT_GT(blinding.b, 0.97f);          // white
    // A pure primary gets there too.
    EXPECT_GT(display_transform({1000, 0, 0}, kFilmic).b, 0.97f);
}

// ---- Auto exposure ------------------------------------------------------------------------------

Image grey(const std::vector<float>& values)
{
    Image image{static_cast<int>(values.size()), 1, {"R", "G", "B"}, {}};
    for (const float value : values) {
        image.pixels.insert(image.pixels.end(), {value, value, value});
    }
    return image;
}

// Smoke on a tenth of a black picture, of some luminances under 1.
std::vector<float> smoke_in_the_dark()
{
    std::vector<float> values(2000, 0.0f);
    for (std::size_t i = 0; i < 200; ++i) {
        values[i * 10] = 0.005f * static_cast<float>(i + 1);
    }
    return values;
}

TEST(AutoExposure, LeavesABlackPictureAlone)
{
    EXPECT_EQ(auto_exposure(grey({0, 0, 0})), 0);
    EXPECT_EQ(auto_exposure(grey({-1, kNan, 0})), 0);
    EXPECT_EQ(auto_exposure(Image{0, 0, {"R", "G", "B"}, {}}), 0);
}

TEST(AutoExposure, BringsAnEvenPictureToMiddleGrey)
{
    const float ev = auto_exposure(grey(std::vector<float>(100, 3.0f)));
    EXPECT_NEAR(3.0f * std::exp2(ev), 0.18f, 1e-5f);
}

TEST(AutoExposure, BringsBrightPartsInTheDarkToWhite)
{
    const float ev = auto_exposure(grey(smoke_in_the_dark()));
    EXPECT_NEAR(0.95f * std::exp2(ev), 1.0f, 0.03f);  // 0.5 % of the picture is brighter than 0.95

    // More black around the same smoke is not more exposure.
    std::vector<float> darker = smoke_in_the_dark();
    darker.insert(darker.end(), 2000, 0.0f);
    EXPECT_NEAR(auto_exposure(grey(darker)), ev, 0.2f);

    // Nor does it fail on a spark of one pixel.
    std::vector<float> spark(5000, 0.0f);
    spark[77] = 4;
    EXPECT_NEAR(4 * std::exp2(auto_exposure(grey(spark))), 1.0f, 1e-5f);
}

TEST(AutoExposure, IgnoresAFewHugePixels)
{
    std::vector<float> values = smoke_in_the_dark();
    const float ev = auto_exposure(grey(values));
    values[1] = 1e5f;
    values[2] = 1e30f;
    values[3] = kInfinity;
    values[4] = kNan;
    EXPECT_NEAR(auto_exposure(grey(values)), ev, 0.05f);
}

TEST(AutoExposure, IgnoresAFewHugeOrTinyPixelsWhereTheAverageDecides)
{
    for (const float stray : {1e30f, 1e-30f}) {
        std::vector<float> values(1000, 3.0f);
        const float ev = auto_exposure(grey(values));
        std::fill_n(values.begin(), 4, stray);
        EXPECT_NEAR(auto_exposure(grey(values)), ev, 0.03f) << stray;  // 6 stops on 0.4 %
    }
}

TEST(AutoExposure, FallsByAStopAsLightDoubles)
{
    std::vector<float> values = smoke_in_the_dark();
    const float ev = auto_exposure(grey(values));
    for (float& value : values) {
        value *= 8;
    }
    EXPECT_NEAR(auto_exposure(grey(values)), ev - 3, 1e-4f);
}

TEST(AutoExposure, NeverRisesWhenAPixelGetsBrighter)
{
    std::vector<float> values = smoke_in_the_dark();
    float previous = auto_exposure(grey(values));
    std::uint32_t state = 7;
    for (int step = 0; step < 400; ++step) {
        state = state * 1664525u + 1013904223u;
        float& value = values[(state >> 8) % values.size()];
        value = value * 2 + static_cast<float>(state >> 28) * 0.01f;
        const float ev = auto_exposure(grey(values));
        ASSERT_LE(ev, previous + 1e-5f) << step;
        previous = ev;
    }
}

TEST(AutoExposure, NeedsRgb)
{
    EXPECT_THROW(auto_exposure(row({"R", "G"}, {1, 2})), Error);
}

}  // namespace
}  // namespace fumarole::write
