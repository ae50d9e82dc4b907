#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <fumarole/write/image_writer.h>

namespace fumarole::write {

/// A line of text in a PNG's header.
struct PngText {
    std::string key;   ///< 1..79 characters of Latin-1
    std::string text;  ///< UTF-8
};

/// write_png() with texts beside `Software`, before the pixels. @throws Error as write_png
void write_png(const Image& image, const Display& display, const std::filesystem::path& file,
               const std::vector<PngText>& texts);

}  // namespace fumarole::write
