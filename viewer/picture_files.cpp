#include "picture_files.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fmt/format.h>
#include <unistd.h>

#include "command.h"
#include "scene_input.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;

constexpr const char* kComposite = "composite";

/// What both kinds of still have.
template <class AnyStill> Picture common_targets(const AnyStill& still)
{
    Picture picture{.width = still.width, .height = still.height, .targets = {}};
    picture.targets.push_back({kComposite, {"R", "G", "B"}, &still.composite});
    const auto add = [&](const std::string& name, const std::vector<float>& pixels) {
        picture.targets.push_back({name, {name + ".R", name + ".G", name + ".B"}, &pixels});
    };
    add("scattering", still.scattering);
    add("transmittance", still.transmittance);
    add("surface", still.surface);
    add("surface_lit", still.surface_lit);
    picture.targets.push_back({"depth", {"depth.Z"}, &still.depth});
    return picture;
}

Image empty_image(const Picture& picture)
{
    Image image;
    image.width = picture.width;
    image.height = picture.height;
    image.whole = picture.whole;
    image.origin = picture.origin;
    return image;
}

/// One target as R, G, B and its alpha if it has one; a single channel thrice.
Image image_of(const Picture& picture, const std::string& name)
{
    const auto target = std::find_if(picture.targets.begin(), picture.targets.end(),
                                     [&](const Target& t) { return t.name == name; });
    Image image = empty_image(picture);
    image.channels = {"R", "G", "B"};
    if (target->channels.size() == 1) {
        for (const float value : *target->pixels)
            image.pixels.insert(image.pixels.end(), 3, value);
        return image;
    }
    if (target->channels.size() == 4)
        image.channels = target->channels;
    image.pixels = *target->pixels;
    return image;
}

/// What a .png with alpha is made of, with the light of what alpha counts beside all light.
Image image_with_cover(const Picture& picture)
{
    Image image = empty_image(picture);
    image.channels = {"R", "G", "B", "A", "cover.R", "cover.G", "cover.B"};
    const std::vector<float>& all = *picture.targets.front().pixels;
    image.pixels.reserve(all.size() / 4 * image.channels.size());
    for (std::size_t i = 0; i < all.size(); i += 4) {
        image.pixels.insert(image.pixels.end(), all.begin() + static_cast<std::ptrdiff_t>(i),
                            all.begin() + static_cast<std::ptrdiff_t>(i + 4));
        image.pixels.insert(image.pixels.end(),
                            picture.cover->begin() + static_cast<std::ptrdiff_t>(i),
                            picture.cover->begin() + static_cast<std::ptrdiff_t>(i + 3));
    }
    return image;
}

Image image_of_all(const Picture& picture)
{
    Image image = empty_image(picture);
    for (const Target& target : picture.targets)
        image.channels.insert(image.channels.end(), target.channels.begin(), target.channels.end());
    const auto pixels =
        static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    image.pixels.reserve(pixels * image.channels.size());
    for (std::size_t i = 0; i < pixels; ++i)
        for (const Target& target : picture.targets)
            for (std::size_t c = 0; c < target.channels.size(); ++c)
                image.pixels.push_back((*target.pixels)[i * target.channels.size() + c]);
    return image;
}

/// Before the work, so that it is not done for nothing.
void check_folder(const std::string& output)
{
    fs::path folder = fs::path(output).parent_path();
    if (folder.empty())
        folder = ".";
    std::error_code error;
    const fs::file_status status = fs::status(folder, error);
    std::string why;
    if (!fs::exists(status))
        why = status.type() == fs::file_type::not_found && error != std::errc::not_a_directory
                  ? fmt::format("no such folder '{}'; create it first", folder.string())
                  : fmt::format("'{}': {}", folder.string(), error.message());
    else if (!fs::is_directory(status))
        why = fmt::format("'{}' is not a folder; choose another", folder.string());
    else if (::access(folder.c_str(), W_OK | X_OK) != 0)
        why = errno == EROFS
                  ? fmt::format("folder '{}' is read-only; choose another", folder.string())
                  : fmt::format("no right to write in folder '{}'; choose another or change its "
                                "rights",
                                folder.string());
    if (!why.empty())
        throw Error(fmt::format("{}: {}", output, why));
}

/// Depth with the sky, which would rule any exposure, made 0.
Image without_sky(Image depth)
{
    for (float& value : depth.pixels)
        value = value >= Still::kSkyDepth ? 0.0f : value;
    return depth;
}

/// A depth alone is R, G and B and has no name to be known by.
void write_linear(const Image& image, const std::string& output, const PictureFiles& files)
{
    ExrOptions exr = files.exr;
    exr.half = exr.half && files.target != "depth";
    write::write_exr(image, output, exr);
}

}  // namespace

std::string capture_date()
{
    std::time_t now = std::time(nullptr);
    const char* fixed = std::getenv("SOURCE_DATE_EPOCH");
    if (fixed != nullptr)
        now = static_cast<std::time_t>(std::strtoll(fixed, nullptr, 10));
    std::tm parts{};
    if ((fixed != nullptr ? gmtime_r(&now, &parts) : localtime_r(&now, &parts)) == nullptr)
        return "";
    char text[sizeof "2026:11:28 02:40:00" + 8];
    return {text, std::strftime(text, sizeof text, "%Y:%m:%d %H:%M:%S", &parts)};
}

bool is_png(const std::string& output)
{
    return has_extension(output, ".png");
}

bool is_deep(const std::string& output)
{
    return has_extension(output, ".exr") &&
           has_extension(fs::path(output).stem().string(), ".deep");
}

Picture picture_of(const Still& still)
{
    Picture picture = common_targets(still);
    const auto add = [&](const std::string& name, const std::vector<float>& pixels) {
        if (!pixels.empty())
            picture.targets.push_back({name, {name + ".R", name + ".G", name + ".B"}, &pixels});
    };
    add("transparents", still.transparents);
    add("transparents_kept", still.transparents_kept);
    if (!still.foreground.empty())
        picture.targets.front() = {kComposite, {"R", "G", "B", "A"}, &still.foreground};
    return picture;
}

Picture picture_of(const study::ReferenceStill& still)
{
    Picture picture = common_targets(still);
    picture.targets.push_back({"error", {"error.Y"}, &still.error});
    return picture;
}

void check_png(std::string_view option, const std::string& file)
{
    if (!is_png(file))
        throw UsageError(fmt::format("{}: '{}' does not end in .png, the one form of this picture",
                                     option, file));
}

void check_outputs(const std::vector<std::string>& outputs)
{
    for (const std::string& output : outputs)
        if (!has_extension(output, ".exr") && !is_png(output))
            throw UsageError(fmt::format("-o: '{}' ends in neither .exr (linear, all targets), "
                                         ".deep.exr (samples in depth) nor .png (for a screen)",
                                         output));
    for (const std::string& output : outputs)
        check_folder(output);
}

float write_picture(const Picture& picture, const PictureFiles& files)
{
    const std::string shown = files.target.empty() ? kComposite : files.target;
    const Image image = image_of(picture, shown);
    const Display display{.exposure_ev = exposure_of(shown, image, files.exposure),
                          .transform = files.transform};
    for (const std::string& output : files.outputs) {
        if (is_png(output))
            write::write_png(picture.cover != nullptr ? image_with_cover(picture) : image, display,
                             output);
        else if (!is_deep(output))
            write_linear(files.target.empty() ? image_of_all(picture) : image, output, files);
    }
    return display.exposure_ev;
}

void print_written(const std::vector<std::string>& outputs, std::optional<float> exposure_ev)
{
    for (const std::string& output : outputs)
        fmt::print("wrote {}{}\n", output,
                   exposure_ev && is_png(output)
                       ? fmt::format(" (exposure {:+.2f} stops)", *exposure_ev)
                       : "");
}

std::optional<float> parse_exposure(const std::string& text)
{
    if (text == "auto")
        return std::nullopt;
    float stops = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, stops);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(std::abs(stops) <= 60.0f))
        throw UsageError(
            fmt::format("--exposure: '{}' is neither 'auto' nor stops in -60..60", text));
    return stops;
}

float exposure_of(const std::string& target, const Image& image, std::optional<float> asked)
{
    if (asked)
        return *asked;
    if (target == "transmittance" || target == "transparents_kept")
        return 0;
    return write::auto_exposure(target == "depth" ? without_sky(image) : image);
}

}  // namespace fumarole::command
