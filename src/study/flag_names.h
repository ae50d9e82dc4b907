#pragma once

#include <string>
#include <string_view>

namespace fumarole::study {

/// The library's messages name what its API has, `FrameSettings::steps`: the same message in the
/// words of the command line, `--steps`.
std::string with_flags(std::string_view message);

}  // namespace fumarole::study
