#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace fumarole::command {

/// How many bounces of the reference an option asks for: N, or `all`, study::kAllBounces.
/// @throws UsageError naming the option
int parse_bounces(const std::string& option, const std::string& text);

/// The number, or `all`.
std::string bounces_text(int bounces);
nlohmann::ordered_json bounces_json(int bounces);

/// What stands in the help of `--surface-bounces`.
inline constexpr const char* kSurfaceBouncesHelp =
    "of the reference: times that surfaces reflect light on, after the place that is seen: 0, 1, "
    "2, ... or all [0]";

}  // namespace fumarole::command
