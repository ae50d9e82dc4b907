#include "window/thumbnail_files.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <fmt/format.h>
#include <md5.h>
#include <png.h>
#include <stdexcept>
#include <sys/stat.h>

#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

constexpr const char* kPictures = "large";
constexpr const char* kErrors = "fail/fumarole";
constexpr const char* kErrorKey = "Description";

/// A PNG that is read from memory; libpng's errors are thrown.
class PngReader {
public:
    explicit PngReader(std::string_view bytes)
        : bytes_{bytes}, png_{png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignore)},
          info_{png_ != nullptr ? png_create_info_struct(png_) : nullptr}
    {
        if (info_ == nullptr) {
            png_destroy_read_struct(&png_, nullptr, nullptr);
            throw std::bad_alloc();
        }
        png_set_read_fn(png_, this, take);
    }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

    [[nodiscard]] ThumbnailPicture read()
    {
        constexpr png_uint_32 kMostSide = 1024;
        png_set_user_limits(png_, kMostSide, kMostSide);
        png_read_info(png_, info_);
        png_set_expand(png_);
        png_set_scale_16(png_);
        png_set_gray_to_rgb(png_);
        png_set_add_alpha(png_, 255, PNG_FILLER_AFTER);
        png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        ThumbnailPicture picture;
        picture.width = static_cast<int>(png_get_image_width(png_, info_));
        picture.height = static_cast<int>(png_get_image_height(png_, info_));
        const std::size_t row = png_get_rowbytes(png_, info_);
        picture.rgba.resize(row * static_cast<std::size_t>(picture.height));
        std::vector<png_bytep> rows;
        rows.reserve(static_cast<std::size_t>(picture.height));
        for (int y = 0; y < picture.height; ++y)
            rows.push_back(&picture.rgba[row * static_cast<std::size_t>(y)]);
        png_read_image(png_, rows.data());
        png_read_end(png_, info_);
        png_textp texts = nullptr;
        int count = 0;
        png_get_text(png_, info_, &texts, &count);
        for (int i = 0; i < count; ++i)
            if (texts[i].text != nullptr)
                picture.texts[texts[i].key] = texts[i].text;
        return picture;
    }

private:
    [[noreturn]] static void fail(png_structp, png_const_charp why)
    {
        throw std::runtime_error(why);
    }
    static void ignore(png_structp, png_const_charp) {}
    static void take(png_structp png, png_bytep to, std::size_t size)
    {
        auto& self = *static_cast<PngReader*>(png_get_io_ptr(png));
        if (size > self.bytes_.size())
            throw std::runtime_error("cut short");
        self.bytes_.copy(reinterpret_cast<char*>(to), size);
        self.bytes_.remove_prefix(size);
    }

    std::string_view bytes_;
    png_structp png_;
    png_infop info_;
};

/// Whether a thumbnail is of the file as it is now.
bool is_of(const ThumbnailPicture& picture, const fs::path& file)
{
    const auto has = [&](const write::PngText& text) {
        const auto there = picture.texts.find(text.key);
        // Others need not write the size.
        return there == picture.texts.end() ? text.key == "Thumb::Size"
                                            : there->second == text.text;
    };
    const std::vector<write::PngText> wanted = thumbnail_texts(file);
    return !wanted.empty() && std::all_of(wanted.begin(), wanted.end(), has);
}

/// Each folder of `inner` within `outer`, for its owner alone where it is new.
void make_private_folders(const fs::path& outer, const fs::path& inner)
{
    std::error_code error;
    fs::create_directories(outer.parent_path(), error);
    const auto make = [&](const fs::path& folder) {
        if (!error && fs::create_directory(folder, error))
            fs::permissions(folder, fs::perms::owner_all, error);
    };
    make(outer);
    fs::path folder = outer;
    for (const fs::path& part : inner)
        make(folder /= part);
    if (error)
        throw Error(
            fmt::format("{}: {}; no small pictures are kept", folder.string(), error.message()));
}

}  // namespace

fs::path thumbnail_folder()
{
    // The specification has relative paths ignored.
    if (const char* named = std::getenv("XDG_CACHE_HOME");
        named != nullptr && fs::path(named).is_absolute())
        return fs::path(named) / "thumbnails";
    const char* home = std::getenv("HOME");
    return home == nullptr ? fs::path() : fs::path(home) / ".cache/thumbnails";
}

std::string file_uri(const fs::path& file)
{
    constexpr std::string_view kPlain = "-._~!$&'()*+,;=:@/";  // as GLib writes them
    std::error_code error;
    std::string uri = "file://";
    for (const char c : fs::absolute(file, error).lexically_normal().string()) {
        const bool letter =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        if (letter || kPlain.find(c) != std::string_view::npos)
            uri += c;
        else
            uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return uri;
}

std::string md5(std::string_view bytes)
{
    std::array<char, MD5_DIGEST_STRING_LENGTH> digits{};
    MD5Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), digits.data());
    return digits.data();
}

std::vector<write::PngText> thumbnail_texts(const fs::path& file)
{
    struct stat about {};
    if (stat(file.c_str(), &about) != 0 || !S_ISREG(about.st_mode))
        return {};
    return {{"Thumb::URI", file_uri(file)},
            {"Thumb::MTime", fmt::format("{}", about.st_mtime)},
            {"Thumb::Size", fmt::format("{}", about.st_size)}};
}

std::optional<ThumbnailPicture> read_thumbnail(const fs::path& png)
{
    constexpr std::uintmax_t kMostBytes = 8U << 20U;
    std::error_code error;
    const std::uintmax_t size = fs::file_size(png, error);
    if (error || size > kMostBytes)
        return std::nullopt;
    try {
        const std::string bytes = write::read_whole(png);
        return PngReader(bytes).read();
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

ThumbnailCache::ThumbnailCache(fs::path folder) : folder_{std::move(folder)} {}

fs::path ThumbnailCache::file_in(const char* size, const fs::path& file) const
{
    return folder_ / size / (md5(file_uri(file)) + ".png");
}

Thumbnail ThumbnailCache::find(const fs::path& file) const
{
    if (folder_.empty())
        return {};
    for (const char* size : {kPictures, "x-large", "normal"})
        if (auto picture = read_thumbnail(file_in(size, file)); picture && is_of(*picture, file))
            return {std::move(*picture), ""};
    if (auto failed = read_thumbnail(file_in(kErrors, file)); failed && is_of(*failed, file))
        return {{}, failed->texts[kErrorKey]};
    return {};
}

fs::path ThumbnailCache::place_for(const fs::path& file) const
{
    if (folder_.empty())
        throw Error("no folder for small pictures: neither XDG_CACHE_HOME nor HOME is set");
    make_private_folders(folder_, kPictures);
    return file_in(kPictures, file);
}

void ThumbnailCache::keep_error(const fs::path& file, const std::string& error) const
{
    std::vector<write::PngText> texts = thumbnail_texts(file);
    if (folder_.empty() || texts.empty() || error.empty())
        return;
    texts.push_back({kErrorKey, error});
    Image pixel;
    pixel.width = pixel.height = 1;
    pixel.channels = {"R", "G", "B"};
    pixel.pixels = {0, 0, 0};
    try {
        make_private_folders(folder_, kErrors);
        write::write_png(pixel, {}, file_in(kErrors, file), texts);
    } catch (const Error&) {
        // It is tried again the next time.
    }
}

}  // namespace fumarole::window
