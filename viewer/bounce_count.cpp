#include "bounce_count.h"

#include <charconv>
#include <fmt/format.h>

#include "command.h"
#include "study/reference.h"

namespace fumarole::command {

int parse_bounces(const std::string& option, const std::string& text)
{
    if (text == "all")
        return study::kAllBounces;
    int bounces = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, bounces);
    if (parsed.ec != std::errc{} || parsed.ptr != end || bounces < 0)
        throw UsageError(fmt::format("{}: '{}' is no number of {}", option, text,
                                     option == "--bounces"
                                         ? "scatterings; give 0, 1, 2, ... or all"
                                         : "reflections; give 0, 1, 2, ..., all or auto"));
    return bounces;
}

int parse_surface_bounces(const std::string& text, const Scene& scene)
{
    return text == "auto" ? study::measured_surface_bounces(scene)
                          : parse_bounces("--surface-bounces", text);
}

std::string bounces_text(int bounces)
{
    return bounces == study::kAllBounces ? "all" : std::to_string(bounces);
}

nlohmann::ordered_json bounces_json(int bounces)
{
    if (bounces == study::kAllBounces)
        return "all";
    return bounces;
}

}  // namespace fumarole::command
