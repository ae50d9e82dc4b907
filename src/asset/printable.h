#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fumarole::asset {

/// A name or message from a file, made fit for one line of ours: control characters escaped, long
/// text cut at a whole UTF-8 character.
std::string printable(std::string_view text, std::size_t max_bytes = 80);

}  // namespace fumarole::asset
