// EXRs: pictures in memory to files and back. OpenImageIO encodes into memory and write_whole alone
// touches the disk: OIIO's own file writer goes through a buffered FILE* whose failing flush at
// close is not reported, so a full disk would leave a torn file and a return value of true.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "write/picture_checks.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>
#include <fumarole/write/deep_image.h>

namespace fumarole::write {
namespace {

namespace fs = std::filesystem;

// A library's message may span lines; ours is one line.
std::string one_line(std::string_view text)
{
    std::string line;
    for (const char c : text) {
        const bool space = c == '\n' || c == '\r' || c == '\t' || c == ' ';
        if (!space) {
            line += c;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
    }
    while (!line.empty() && line.back() == ' ') {
        line.pop_back();
    }
    return line.empty() ? "no reason given" : line;
}

std::vector<unsigned char> encode(const OIIO::ImageSpec& spec, const std::vector<float>& pixels,
                                  const fs::path& file)
{
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const std::string in_memory = "memory.exr";
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(in_memory, &memory);
    if (!output) {
        throw Error(fmt::format("{}: cannot write EXR files: {}; install an OpenImageIO that can",
                                file.string(), one_line(OIIO::geterror())));
    }
    if (!output->open(in_memory, spec) ||
        !output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) || !output->close()) {
        throw Error(fmt::format("{}: cannot encode {} x {} pixels: {}; try a smaller picture",
                                file.string(), spec.width, spec.height,
                                one_line(output->geterror())));
    }
    return bytes;
}

// What is brighter would be stored as infinite.
constexpr float kLargestHalf = 65504;

void describe(OIIO::ImageSpec& spec, const ExrOptions& options)
{
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("Software", options.software);
    // OIIO calls capDate so, and puts the time of day there where nothing is said: the same picture
    // would not give the same bytes.
    spec.attribute("DateTime", options.captured);
    if (!options.command.empty()) {
        spec.attribute("commandLine", options.command);
    }
}

// The data window of a part of a picture, and the display window of all of it.
void place_in_whole(OIIO::ImageSpec& spec, glm::ivec2 origin, glm::ivec2 whole)
{
    if (whole.x > 0) {
        spec.x = origin.x;
        spec.y = origin.y;
        spec.full_width = whole.x;
        spec.full_height = whole.y;
    }
}

// A file that has a path and no place on a disk: OIIO (2.4) writes deep pixels into no memory of
// ours, but into a file called memory.exr.
class MemoryFile {
public:
    MemoryFile() : descriptor_{::memfd_create("fumarole", MFD_CLOEXEC)} {}
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile()
    {
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
    }

    [[nodiscard]] std::string path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

    // All of it; nothing if it can't be read.
    [[nodiscard]] std::vector<unsigned char> read() const
    {
        struct stat status {};
        if (::fstat(descriptor_, &status) != 0) {
            return {};
        }
        std::vector<unsigned char> bytes(static_cast<std::size_t>(status.st_size));
        for (std::size_t done = 0; done < bytes.size();) {
            const ssize_t read =
                ::pread(descriptor_, &bytes[done], bytes.size() - done, static_cast<off_t>(done));
            if (read <= 0 && errno != EINTR) {
                return {};
            }
            done += static_cast<std::size_t>(std::max<ssize_t>(read, 0));
        }
        return bytes;
    }

private:
    int descriptor_;
};

struct OpenedExr {
    std::unique_ptr<OIIO::ImageInput> input;
    OIIO::ImageSpec spec;  ///< spec of the first part
};

OpenedExr open_exr(const fs::path& file)
{
    std::error_code ignored;  // what cannot be asked about fails at open, with its reason
    const fs::file_status status = fs::status(file, ignored);
    if (status.type() == fs::file_type::not_found) {
        throw Error(fmt::format("{}: no such file; check the name", file.string()));
    }
    if (fs::is_directory(status)) {
        throw Error(fmt::format("{}: is a folder; name a file", file.string()));
    }

    // Asked for by format: by file name alone a PNG named .exr would be read as linear light.
    OpenedExr exr;
    exr.input = OIIO::ImageInput::create("openexr");
    if (!exr.input) {
        throw Error(fmt::format("{}: cannot read EXR files: {}; install an OpenImageIO that can",
                                file.string(), one_line(OIIO::geterror())));
    }
    if (!exr.input->open(file.string(), exr.spec)) {
        const bool named = file.extension() == ".exr";
        throw Error(fmt::format("{}: not a readable EXR file: {}; {}", file.string(),
                                one_line(exr.input->geterror()),
                                named ? "write it again" : "name an .exr"));
    }
    return exr;
}

}  // namespace

void write_exr(const Image& image, const fs::path& file, const ExrOptions& options)
{
    check_shape(image, file);
    std::vector<int> all(image.channels.size());
    for (std::size_t c = 0; c < all.size(); ++c) {
        all[c] = static_cast<int>(c);
    }
    check_finite(image, all, file);

    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames = image.channels;
    place_in_whole(spec, image.origin, image.whole);
    spec.attribute("compression", "zip");
    describe(spec, options);
    if (!options.half) {
        write_whole(file, encode(spec, image.pixels, file));
        return;
    }
    for (const std::string& name : image.channels) {
        spec.channelformats.emplace_back(name.starts_with("depth") ? OIIO::TypeDesc::FLOAT
                                                                   : OIIO::TypeDesc::HALF);
    }
    std::vector<float> pixels = image.pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (spec.channelformats[i % image.channels.size()] == OIIO::TypeDesc::HALF) {
            pixels[i] = std::clamp(pixels[i], -kLargestHalf, kLargestHalf);
        }
    }
    write_whole(file, encode(spec, pixels, file));
}

void write_deep_exr(const DeepImage& image, const fs::path& file, const ExrOptions& options)
{
    const auto pixels =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (pixels == 0) {
        throw Error(fmt::format("{}: the picture is empty ({} x {} pixels); give it a size",
                                file.string(), image.width, image.height));
    }
    assert(image.first.size() == pixels + 1 && image.first.back() == image.samples.size());
    const OIIO::TypeDesc color = options.half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
    OIIO::ImageSpec spec(image.width, image.height, 6, color);
    spec.channelnames = {"R", "G", "B", "A", "Z", "ZBack"};
    spec.channelformats = {
        color, color, color, color, OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::FLOAT};
    spec.deep = true;
    place_in_whole(spec, image.origin, image.whole);
    spec.alpha_channel = 3;
    spec.z_channel = 4;
    spec.attribute("compression", "zips");  // the one zip that deep scanlines have
    describe(spec, options);

    OIIO::DeepData data(spec);
    for (std::size_t i = 0; i < pixels; ++i) {
        data.set_samples(static_cast<std::int64_t>(i),
                         static_cast<int>(image.first[i + 1] - image.first[i]));
    }
    const float most = options.half ? kLargestHalf : std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t s = image.first[i]; s < image.first[i + 1]; ++s) {
            const DeepSample& sample = image.samples[s];
            const std::array<float, 6> values{sample.color.r, sample.color.g, sample.color.b,
                                              sample.alpha,   sample.front,   sample.back};
            for (int c = 0; c < 6; ++c) {
                const float value = values.at(static_cast<std::size_t>(c));
                if (!std::isfinite(value)) {
                    const auto width = static_cast<std::size_t>(image.width);
                    throw Error(fmt::format(
                        "{}: channel '{}' is {} at pixel ({}, {}), nothing was written; look "
                        "there for the light or density that is out of range",
                        file.string(), spec.channelnames[static_cast<std::size_t>(c)],
                        std::isnan(value) ? "NaN" : "infinite", i % width, i / width));
                }
                data.set_deep_value(static_cast<std::int64_t>(i), c,
                                    static_cast<int>(s - image.first[i]),
                                    c < 4 ? std::clamp(value, -most, most) : value);
            }
        }
    }

    const MemoryFile memory;
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("openexr");
    if (!output || !output->open(memory.path(), spec) || !output->write_deep_image(data) ||
        !output->close()) {
        throw Error(fmt::format("{}: cannot encode {} x {} deep pixels: {}; try a smaller picture",
                                file.string(), spec.width, spec.height,
                                one_line(output ? output->geterror() : OIIO::geterror())));
    }
    const std::vector<unsigned char> bytes = memory.read();
    if (bytes.empty()) {
        throw Error(fmt::format("{}: cannot encode {} x {} deep pixels; try a smaller picture",
                                file.string(), spec.width, spec.height));
    }
    write_whole(file, bytes);
}

Image read_exr(const fs::path& file, const std::vector<std::string>& channels)
{
    const OpenedExr exr = open_exr(file);
    const OIIO::ImageSpec& spec = exr.spec;
    if (spec.deep) {
        throw Error(fmt::format("{}: is a deep picture; flatten it first", file.string()));
    }
    // What lies outside of the display window is no part of the picture.
    if (spec.x < spec.full_x || spec.y < spec.full_y ||
        spec.x + spec.width > spec.full_x + spec.full_width ||
        spec.y + spec.height > spec.full_y + spec.full_height) {
        throw Error(
            fmt::format("{}: its data window ({} x {} at {}, {}) reaches out of its display "
                        "window ({} x {} at {}, {}); crop it",
                        file.string(), spec.width, spec.height, spec.x, spec.y, spec.full_width,
                        spec.full_height, spec.full_x, spec.full_y));
    }

    Image image;
    image.width = spec.width;
    image.height = spec.height;
    if (spec.width != spec.full_width || spec.height != spec.full_height) {
        image.whole = {spec.full_width, spec.full_height};
        image.origin = {spec.x - spec.full_x, spec.y - spec.full_y};
    }
    image.channels = channels.empty() ? spec.channelnames : channels;
    std::vector<std::size_t> sources;
    int first = spec.nchannels;
    int last = 0;
    for (const std::string& name : image.channels) {
        const std::optional<int> source = find_channel(spec.channelnames, name);
        if (!source) {
            throw Error(fmt::format("{}: no channel '{}' (has: {}); name one that it has",
                                    file.string(), name, channel_names(spec.channelnames)));
        }
        if (!spec.channelformat(*source).is_floating_point()) {
            // OIIO would scale integers to 0..1.
            throw Error(fmt::format("{}: channel '{}' holds integers; write it as float or half",
                                    file.string(), name));
        }
        sources.push_back(static_cast<std::size_t>(*source));
        first = std::min(first, *source);
        last = std::max(last, *source);
    }

    // Only the span of channels that holds the asked ones is read: AOV files have dozens.
    const auto stride = static_cast<std::size_t>(last - first + 1);
    const std::size_t count =
        static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
    std::vector<float> read(count * stride);
    if (!exr.input->read_image(0, 0, first, last + 1, OIIO::TypeDesc::FLOAT, read.data())) {
        throw Error(fmt::format("{}: cannot read its pixels: {}; write it again", file.string(),
                                one_line(exr.input->geterror())));
    }
    image.pixels.reserve(count * sources.size());
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
        for (const std::size_t source : sources) {
            image.pixels.push_back(read[pixel * stride + source - static_cast<std::size_t>(first)]);
        }
    }
    return image;
}

std::vector<std::string> exr_channels(const fs::path& file)
{
    return open_exr(file).spec.channelnames;
}

}  // namespace fumarole::write
