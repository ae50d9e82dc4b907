// Pictures in memory to files and back. OpenImageIO encodes into memory and this file alone
// touches the disk: OIIO's own file writer goes through a buffered FILE* whose failing flush at
// close is not reported, so a full disk would leave a torn file and a return value of true.

#include <fumarole/write/image_writer.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

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

fs::path folder_of(const fs::path& file)
{
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

std::string names(const std::vector<std::string>& channels)
{
    return channels.empty() ? "none" : fmt::format("'{}'", fmt::join(channels, "', '"));
}

// What a failed system call on `file` means for the person who asked for it, with what to do.
std::string reason_for(int error, const fs::path& file, std::size_t bytes)
{
    const std::string folder = folder_of(file).string();
    switch (error) {
    case ENOENT: {
        std::error_code unknown;  // of a folder that is there it means that none can be made there
        if (fs::is_directory(folder_of(file), unknown)) {
            return fmt::format("folder '{}' takes no new files; choose another", folder);
        }
        return fmt::format("no such folder '{}'; create it first", folder);
    }
    case ENOTDIR:
        return fmt::format("'{}' is not a folder; choose another", folder);
    case EACCES:
    case EPERM:
        return fmt::format("no right to write in folder '{}'; choose another or change its rights",
                           folder);
    case EROFS:
        return fmt::format("folder '{}' is read-only; choose another", folder);
    case ENOSPC:
    case EDQUOT:
        return fmt::format("disk full; free {:.1f} MB in folder '{}' or choose another",
                           static_cast<double>(bytes) * 1e-6, folder);
    case EFBIG:
        return fmt::format("{} bytes are over the limit for a file; raise it (ulimit -f)", bytes);
    case ENAMETOOLONG:
        return "the name is too long; choose a shorter one";
    default:
        return fmt::format("{}; choose another folder than '{}'",
                           std::generic_category().message(error), folder);
    }
}

// An unfinished file: gone again unless it was renamed to its name.
class TemporaryFile {
public:
    // Beside the destination, since rename is atomic only within one file system. Not named after
    // it: a name of legal length must not become too long.
    explicit TemporaryFile(const fs::path& destination)
    {
        static std::atomic<unsigned> count = 0;
        do {
            path_ =
                folder_of(destination) / fmt::format(".fumarole-{}-{}.tmp", ::getpid(), count++);
            // 0666 less umask, as any program's file; mkstemp's 0600 would survive the rename.
            descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        } while (descriptor_ < 0 && errno == EEXIST);
        error_ = descriptor_ < 0 ? errno : 0;
        created_ = descriptor_ >= 0;
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile()
    {
        if (descriptor_ >= 0) {
            ::close(descriptor_);
        }
        if (created_) {
            ::unlink(path_.c_str());
        }
    }

    // Each returns 0, or the errno of the first step that failed; later steps then do nothing.
    int write(std::span<const unsigned char> bytes)
    {
        while (error_ == 0 && !bytes.empty()) {
            const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
            if (written >= 0) {
                bytes = bytes.subspan(static_cast<std::size_t>(written));
            } else if (errno != EINTR) {
                error_ = errno;
            }
        }
        return error_;
    }

    int become(const fs::path& destination)
    {
        // Network file systems report a full disk only here.
        if (error_ == 0 && ::close(std::exchange(descriptor_, -1)) != 0) {
            error_ = errno;
        }
        if (error_ == 0 && ::rename(path_.c_str(), destination.c_str()) != 0) {
            error_ = errno;
        }
        created_ = created_ && error_ != 0;
        return error_;
    }

private:
    fs::path path_;
    int descriptor_ = -1;
    int error_ = 0;
    bool created_ = false;
};

void write_whole(const fs::path& file, std::span<const unsigned char> bytes)
{
    if (!file.has_filename()) {
        throw Error(fmt::format("'{}': no file name; add one", file.string()));
    }
    std::error_code ignored;  // what cannot be asked about fails below, with its reason
    const fs::file_status status = fs::status(file, ignored);
    if (fs::is_directory(status)) {
        throw Error(fmt::format("{}: is a folder; name a file", file.string()));
    }
    // A rename would replace /dev/null itself.
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        throw Error(fmt::format("{}: is not a regular file; choose another", file.string()));
    }
    // A rename needs no right on the file that it replaces; who protected it does not expect that.
    if (fs::exists(status) && ::access(file.c_str(), W_OK) != 0) {
        throw Error(fmt::format("{}: is write-protected; choose another or change its rights",
                                file.string()));
    }

    TemporaryFile temporary(file);
    int error = temporary.write(bytes);
    if (error == 0) {
        error = temporary.become(file);
    }
    if (error != 0) {
        throw Error(fmt::format("{}: {}", file.string(), reason_for(error, file, bytes.size())));
    }
}

void check_shape(const Image& image, const fs::path& file)
{
    assert(image.width >= 0 && image.height >= 0 &&
           image.pixels.size() == static_cast<std::size_t>(image.width) *
                                      static_cast<std::size_t>(image.height) *
                                      image.channels.size());
    if (image.pixels.empty()) {
        throw Error(fmt::format("{}: the picture is empty ({} x {} pixels, {} channels); give it a "
                                "size and a channel",
                                file.string(), image.width, image.height, image.channels.size()));
    }
    std::set<std::string_view> seen;
    for (const std::string& name : image.channels) {
        // EXR keeps one channel per name and OIIO would invent a name for an empty one.
        if (name.empty() || !seen.insert(name).second) {
            throw Error(fmt::format("{}: channel name '{}' is {}; give each channel its own name",
                                    file.string(), name, name.empty() ? "empty" : "used twice"));
        }
    }
}

// A NaN in a file hides the fault that made it, and compresses into a black pixel in most viewers.
void check_finite(const Image& image, std::span<const int> channels, const fs::path& file)
{
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            for (const int c : channels) {
                const float value = image.at(x, y, c);
                if (!std::isfinite(value)) {
                    throw Error(fmt::format(
                        "{}: channel '{}' is {} at pixel ({}, {}), nothing was written; look "
                        "there for the light or density that is out of range",
                        file.string(), image.channels[static_cast<std::size_t>(c)],
                        std::isnan(value) ? "NaN" : "infinite", x, y));
                }
            }
        }
    }
}

std::optional<int> find_channel(const std::vector<std::string>& channels, std::string_view name)
{
    const auto found = std::find(channels.begin(), channels.end(), name);
    if (found == channels.end()) {
        return std::nullopt;
    }
    return static_cast<int>(found - channels.begin());
}

// One picture of `spec`, from pixels whose values are `of_pixels`, encoded as what `format`
// (".exr", ".png") names.
std::vector<unsigned char> encode(const char* format, const OIIO::ImageSpec& spec,
                                  OIIO::TypeDesc of_pixels, const void* pixels,
                                  const fs::path& file)
{
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const std::string in_memory = std::string("memory") + format;
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(in_memory, &memory);
    if (!output) {
        throw Error(fmt::format("{}: cannot write {} files: {}; install an OpenImageIO that can",
                                file.string(), format, one_line(OIIO::geterror())));
    }
    if (!output->open(in_memory, spec) || !output->write_image(of_pixels, pixels) ||
        !output->close()) {
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
    OIIO::ImageSpec spec;  ///< of the first part
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
        throw Error(fmt::format("{}: not a readable EXR file: {}; write it again", file.string(),
                                one_line(exr.input->geterror())));
    }
    return exr;
}

// The nearest of 0..255 to a display-encoded 0..1.
std::uint8_t to_byte(float encoded)
{
    return static_cast<std::uint8_t>(std::lround(std::clamp(encoded, 0.0f, 1.0f) * 255.0f));
}

struct EncodedPixel {
    glm::vec3 rgb;  ///< display-encoded, not multiplied by alpha
    float alpha;
};

// PNG's alpha is straight, ours premultiplied; and light is divided before the display's curve, not
// after. Light that covers nothing has no straight form: it keeps its colour, for viewers that drop
// alpha.
EncodedPixel straight(glm::vec3 radiance, float alpha, const Display& display)
{
    return {display_transform(alpha > 0 ? radiance / alpha : radiance, display), alpha};
}

// Over black the pixel is to look as what covers would, with what glows added as a screen shows it.
// Alpha is then as large as it must be for that: the brightest channel.
EncodedPixel with_glow(glm::vec3 radiance, glm::vec3 cover, float alpha, const Display& display)
{
    cover = glm::min(cover, radiance);
    const EncodedPixel covering = straight(cover, alpha, display);
    const glm::vec3 glow = display_transform(radiance, display) - display_transform(cover, display);
    const glm::vec3 over_black = alpha * covering.rgb + glm::max(glow, glm::vec3(0));
    const float brightest = std::max({over_black.r, over_black.g, over_black.b});
    const float raised = std::min(1.0f, std::max(alpha, brightest));
    return {raised > 0 ? over_black / raised : over_black, raised};
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
    if (image.whole.x > 0) {
        spec.x = image.origin.x;
        spec.y = image.origin.y;
        spec.full_width = image.whole.x;
        spec.full_height = image.whole.y;
    }
    spec.attribute("compression", "zip");
    describe(spec, options);
    if (!options.half) {
        write_whole(file, encode(".exr", spec, OIIO::TypeDesc::FLOAT, image.pixels.data(), file));
        return;
    }
    for (const std::string& name : image.channels) {
        spec.channelformats.push_back(name.starts_with("depth") ? OIIO::TypeDesc::FLOAT
                                                                : OIIO::TypeDesc::HALF);
    }
    std::vector<float> pixels = image.pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        if (spec.channelformats[i % image.channels.size()] == OIIO::TypeDesc::HALF) {
            pixels[i] = std::clamp(pixels[i], -kLargestHalf, kLargestHalf);
        }
    }
    write_whole(file, encode(".exr", spec, OIIO::TypeDesc::FLOAT, pixels.data(), file));
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

void write_png(const Image& image, const Display& display, const fs::path& file)
{
    check_shape(image, file);
    std::vector<int> used;
    for (const char* name : {"R", "G", "B"}) {
        const std::optional<int> channel = find_channel(image.channels, name);
        if (!channel) {
            throw Error(fmt::format("{}: the picture has no channel '{}' (has: {}); a PNG needs "
                                    "R, G and B",
                                    file.string(), name, names(image.channels)));
        }
        used.push_back(*channel);
    }
    const std::optional<int> alpha_channel = find_channel(image.channels, "A");
    if (alpha_channel) {
        used.push_back(*alpha_channel);
    }
    const std::optional<int> cover =
        alpha_channel ? find_channel(image.channels, "cover.R") : std::nullopt;
    const std::size_t stored = used.size();
    if (cover) {
        for (int c = 0; c < 3; ++c)
            used.push_back(*cover + c);
    }
    check_finite(image, used, file);

    std::vector<std::uint8_t> pixels;
    pixels.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                   stored);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto rgb = [&](std::size_t first) {
                return glm::vec3(image.at(x, y, used[first]), image.at(x, y, used[first + 1]),
                                 image.at(x, y, used[first + 2]));
            };
            EncodedPixel pixel{display_transform(rgb(0), display), 1};
            if (alpha_channel) {
                const float alpha = std::clamp(image.at(x, y, *alpha_channel), 0.0f, 1.0f);
                pixel = cover ? with_glow(rgb(0), rgb(stored), alpha, display)
                              : straight(rgb(0), alpha, display);
            }
            for (int c = 0; c < 3; ++c)
                pixels.push_back(to_byte(pixel.rgb[c]));
            if (alpha_channel)
                pixels.push_back(to_byte(pixel.alpha));
        }
    }

    OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(stored),
                         OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    // The division is done above; OIIO would do it again, on encoded values.
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("Software", "Fumarole");
    write_whole(file, encode(".png", spec, spec.format, pixels.data(), file));
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
                                    file.string(), name, names(spec.channelnames)));
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
