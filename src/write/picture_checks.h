#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fumarole/write/image_writer.h>

namespace fumarole::write {

/// @throws Error naming the file where the picture is empty, or a channel's name is or is used
/// twice
void check_shape(const Image& image, const std::filesystem::path& file);

/// A NaN in a file hides the fault that made it, and compresses into a black pixel in most viewers.
/// @throws Error naming file, channel and pixel
void check_finite(const Image& image, std::span<const int> channels,
                  const std::filesystem::path& file);

std::optional<int> find_channel(const std::vector<std::string>& channels, std::string_view name);

/// For messages: each in quotes, or "none".
std::string channel_names(const std::vector<std::string>& channels);

}  // namespace fumarole::write
