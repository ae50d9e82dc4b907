#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "write/png_text.h"

// Small pictures of files as desktops share them: freedesktop.org, Thumbnail Managing Standard 0.9.

namespace fumarole::window {

/// $XDG_CACHE_HOME/thumbnails, or ~/.cache's. "" if there is neither.
std::filesystem::path thumbnail_folder();

/// `file:///...` of a file, whose path is made absolute.
std::string file_uri(const std::filesystem::path& file);

/// RFC 1321, as 32 hexadecimal digits in lower case.
std::string md5(std::string_view bytes);

/// What a thumbnail says of the file that it is of, which is how it is known to be out of date:
/// Thumb::URI, Thumb::MTime and Thumb::Size. Nothing for what is no file.
std::vector<write::PngText> thumbnail_texts(const std::filesystem::path& file);

/// 8 bits a channel, RGBA, rows from the top.
struct ThumbnailPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
    std::map<std::string, std::string> texts;
};

/// A PNG of no more than 1024 pixels a side, or nothing if it is none, or damaged.
std::optional<ThumbnailPicture> read_thumbnail(const std::filesystem::path& png);

/// What is known of a file's picture.
struct Thumbnail {
    ThumbnailPicture picture;  ///< width 0: there is none
    std::string error;         ///< why there is none, or ""

    [[nodiscard]] bool known() const { return picture.width > 0 || !error.empty(); }
};

/// The folder of thumbnails that desktops share. A file that was changed since has none.
class ThumbnailCache {
public:
    /// @param folder as thumbnail_folder() finds it; "" keeps nothing
    explicit ThumbnailCache(std::filesystem::path folder);

    /// What other programs or we have made of a file, or why it could not be.
    [[nodiscard]] Thumbnail find(const std::filesystem::path& file) const;
    /// Where its picture of 256 pixels is to be written. Makes the folder, for its owner alone.
    /// @throws Error if that can't be made
    [[nodiscard]] std::filesystem::path place_for(const std::filesystem::path& file) const;
    /// Keeps why there is none, until the file is changed.
    void keep_error(const std::filesystem::path& file, const std::string& error) const;

private:
    [[nodiscard]] std::filesystem::path file_in(const char* size,
                                                const std::filesystem::path& file) const;

    std::filesystem::path folder_;
};

}  // namespace fumarole::window
