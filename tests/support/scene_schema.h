#pragma once

#include <algorithm>
#include <array>
#include <string>

#include "support/json_schema.h"

namespace fumarole::test {

/// What docs/scene.schema.json says of a scene that the reader has accepted: "" if it does, too.
inline std::string problem_of_accepted(const std::string& text)
{
    return JsonSchema::of_scenes().problem(nlohmann::json::parse(text));
}

/// Whether a schema can't say what the reader complains of: two values that do not go together, or
/// a text that is no JSON.
inline bool is_beyond_a_schema(const std::string& complaint)
{
    constexpr std::array parts{
        "expected more than",  "expected another point", "expected a direction",
        "expected two edges",  "expected the same",      " needs ",
        "say the same thing",  "is of no use",           "not valid JSON",
        "occurs twice",        "nested deeper",          "'casts' is for quads",
        "the name of a file, "};
    return std::any_of(parts.begin(), parts.end(),
                       [&](const char* part) { return complaint.find(part) != std::string::npos; });
}

}  // namespace fumarole::test
