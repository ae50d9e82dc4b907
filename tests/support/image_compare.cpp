#include "support/image_compare.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

constexpr int kMapWidth = 64;   // characters
constexpr int kMapHeight = 24;  // characters: one is twice as high as wide

fs::path failure_folder()
{
    const char* chosen = std::getenv("FUM_TEST_OUT");
    return chosen != nullptr && *chosen != '\0' ? fs::path(chosen) : fs::path("test_failures");
}

// `Suite_Case_0`, and `Suite_Case_0_2` for the second failure of the same test.
std::string next_file_stem()
{
    std::string stem = "image";
    if (const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info()) {
        stem = fmt::format("{}_{}", info->test_suite_name(), info->name());
    }
    std::replace(stem.begin(), stem.end(), '/', '_');  // of parametrised tests
    static std::multiset<std::string> used;
    used.insert(stem);
    const std::size_t uses = used.count(stem);
    return uses == 1 ? stem : fmt::format("{}_{}", stem, uses);
}

// Not write::write_exr: that is under test itself, and rightly refuses the NaN that we want to see.
// Returns what to print: the file, or why it is not there.
std::string save(const Image& image, const fs::path& file)
{
    if (image.pixels.empty()) {
        return fmt::format("{} (not written: the picture is empty)", file.string());
    }
    std::error_code failed;
    fs::create_directories(file.parent_path(), failed);
    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames = image.channels;
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(file.string());
    if (!output) {
        return fmt::format("{} (not written: {})", file.string(), OIIO::geterror());
    }
    if (!output->open(file.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data()) || !output->close()) {
        return fmt::format("{} (not written: {})", file.string(), output->geterror());
    }
    return file.string();
}

bool has_shape_of_its_own(const Image& image)
{
    return image.width >= 0 && image.height >= 0 &&
           image.pixels.size() == static_cast<std::size_t>(image.width) *
                                      static_cast<std::size_t>(image.height) *
                                      image.channels.size();
}

std::string shape(const Image& image)
{
    return fmt::format("{} x {} pixels of ({}), {} values", image.width, image.height,
                       fmt::join(image.channels, ", "), image.pixels.size());
}

// |actual - expected|; NaN where either is not finite, although equal infinities would give 0 /
// NaN.
std::vector<double> differences(const Image& actual, const Image& expected)
{
    std::vector<double> result(actual.pixels.size());
    for (std::size_t i = 0; i < result.size(); ++i) {
        const auto a = static_cast<double>(actual.pixels[i]);
        const auto e = static_cast<double>(expected.pixels[i]);
        result[i] = std::isfinite(a) && std::isfinite(e) ? std::abs(a - e) : std::nan("");
    }
    return result;
}

// How far over the tolerance, as one character.
char mark(double difference, double tolerance)
{
    if (std::isnan(difference)) {
        return 'N';
    }
    if (difference <= tolerance) {
        return ' ';
    }
    if (difference <= 2 * tolerance) {
        return '.';
    }
    return difference <= 10 * tolerance ? 'o' : '#';
}

// The picture as at most kMapWidth x kMapHeight characters, each the worst value of its pixels.
std::string map_of(const Image& image, const std::vector<double>& difference, double tolerance)
{
    const int columns = std::min(image.width, kMapWidth);
    const int rows = std::min(image.height, kMapHeight);
    const auto column_count = static_cast<std::size_t>(columns);
    std::vector<double> worst(column_count * static_cast<std::size_t>(rows), 0.0);
    for (std::size_t i = 0; i < difference.size(); ++i) {
        const std::size_t pixel = i / image.channels.size();
        const std::size_t x = pixel % static_cast<std::size_t>(image.width);
        const std::size_t y = pixel / static_cast<std::size_t>(image.width);
        const std::size_t column = x * column_count / static_cast<std::size_t>(image.width);
        const std::size_t row =
            y * static_cast<std::size_t>(rows) / static_cast<std::size_t>(image.height);
        double& cell = worst[row * column_count + column];
        if (!std::isnan(cell) && !(difference[i] <= cell)) {  // a NaN stays
            cell = difference[i];
        }
    }

    const std::string border = "  +" + std::string(column_count, '-') + "+\n";
    std::string map = border;
    for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
        map += "  |";
        for (std::size_t column = 0; column < column_count; ++column) {
            map += mark(worst[row * column_count + column], tolerance);
        }
        map += "|\n";
    }
    return map + border;
}

}  // namespace

::testing::AssertionResult images_near(const Image& actual, const Image& expected, double max_abs,
                                       double mean_abs, std::string_view reason)
{
    if (!has_shape_of_its_own(actual) || !has_shape_of_its_own(expected) ||
        actual.width != expected.width || actual.height != expected.height ||
        actual.channels != expected.channels) {
        return ::testing::AssertionFailure() << fmt::format(
                   "the pictures have not the same shape:\n  actual    {}\n  expected  {}",
                   shape(actual), shape(expected));
    }
    if (actual.pixels.empty()) {
        return ::testing::AssertionFailure()
               << "the pictures are empty (" << shape(actual) << "), which proves nothing";
    }

    const std::vector<double> difference = differences(actual, expected);
    std::size_t worst = 0;
    std::size_t broken = 0;
    double sum = 0;
    for (std::size_t i = 0; i < difference.size(); ++i) {
        if (std::isnan(difference[i])) {
            worst = broken == 0 ? i : worst;
            ++broken;
        } else {
            sum += difference[i];
            worst = broken == 0 && difference[i] > difference[worst] ? i : worst;
        }
    }
    const double mean =
        sum / static_cast<double>(difference.size() - std::min(broken, difference.size() - 1));
    if (broken == 0 && difference[worst] <= max_abs && mean <= mean_abs) {
        return ::testing::AssertionSuccess();
    }

    const std::size_t channel = worst % actual.channels.size();
    const std::size_t pixel = worst / actual.channels.size();
    const std::size_t width = static_cast<std::size_t>(actual.width);
    const bool only_mean = broken == 0 && difference[worst] <= max_abs;
    const double tolerance = only_mean ? mean_abs : max_abs;

    Image magnified = actual;
    for (std::size_t i = 0; i < difference.size(); ++i) {
        magnified.pixels[i] = static_cast<float>(10 * difference[i]);
    }
    const fs::path stem = failure_folder() / next_file_stem();

    std::string text = "the pictures differ:\n";
    if (broken > 0) {
        text += fmt::format("  {} values are not finite\n", broken);
    }
    text += fmt::format("  {} at pixel ({}, {}), channel {}: actual {}, expected {}\n",
                        broken > 0 ? "first" : "worst", pixel % width, pixel / width,
                        actual.channels[channel], actual.pixels[worst], expected.pixels[worst]);
    if (broken == 0) {
        text += fmt::format("  max |difference| {:.6g}, allowed {:.6g}{}\n", difference[worst],
                            max_abs, difference[worst] > max_abs ? "  <- broken" : "");
    }
    text += fmt::format("  mean |difference| {:.6g}{}, allowed {:.6g}{}\n", mean,
                        broken > 0 ? " of the finite ones" : "", mean_abs,
                        mean > mean_abs ? "  <- broken" : "");
    text += fmt::format("  allowed because: {}\n", reason);
    text += fmt::format("  over the {} allowed ('.' to twice, 'o' to ten times, '#' more, 'N' not "
                        "finite):\n",
                        only_mean ? "mean" : "max");
    text += map_of(actual, difference, tolerance);
    text += fmt::format("  {}\n", save(actual, stem.string() + "_actual.exr"));
    text += fmt::format("  {}\n", save(expected, stem.string() + "_expected.exr"));
    text += fmt::format("  {}", save(magnified, stem.string() + "_difference_x10.exr"));
    return ::testing::AssertionFailure() << text;
}

}  // namespace fumarole::test
