#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include <fumarole/scene.h>

namespace fumarole::command {

/// How many bounces of the reference an option asks for: N, or `all`, study::kAllBounces.
/// @throws UsageError naming the option
int parse_bounces(const std::string& option, const std::string& text);

/// Likewise of surfaces; `auto` is study::measured_surface_bounces() of the scene.
int parse_surface_bounces(const std::string& text, const Scene& scene);

/// The number, or `all`.
std::string bounces_text(int bounces);
nlohmann::ordered_json bounces_json(int bounces);

/// What stands in the help of `--surface-bounces`.
inline constexpr const char* kSurfaceBouncesHelp =
    "of the reference: times that surfaces reflect light on, after the place that is seen; auto: "
    "all where pictures have such light by themselves, else 0 [auto]";
inline constexpr const char* kSurfaceBouncesValue = "auto|all|N";

}  // namespace fumarole::command
