#pragma once

#include <functional>
#include <string_view>

namespace fumarole {

enum class LogLevel {
    info,     ///< a choice that was made for the host
    warning,  ///< something asked for that could not be had, and what was done instead
};

/// Hears one line at a time, from within a call and on its thread. The library prints nothing.
using Log = std::function<void(LogLevel level, std::string_view line)>;

}  // namespace fumarole
