#include "light/light_source.h"

#include <fmt/format.h>
#include <string>
#include <vector>

#include "light_fields.h"

namespace fumarole::light {

namespace {

/// Lights in a row that are of one kind.
struct Row {
    const char* name;
    std::size_t first, end;
};

std::vector<Row> rows_of(std::span<const Light> lights)
{
    std::vector<Row> rows;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (i == 0 || lights[i].index() != lights[i - 1].index())
            rows.push_back({light_name(lights[i]), i, i});
        rows.back().end = i + 1;
    }
    return rows;
}

/// A function that calls another for each light, of a name that its kind is put into.
std::string for_each(const std::vector<Row>& rows, const char* head, const char* call)
{
    std::string text = fmt::format("{}\n{{\n", head);
    for (const Row& row : rows) {
        const bool one = row.end == row.first + 1;
        if (!one)
            text += fmt::format("    for (int i = {}; i < {}; ++i)\n    ", row.first, row.end);
        text += fmt::format("    {};\n",
                            fmt::format(fmt::runtime(call), fmt::arg("kind", row.name),
                                        fmt::arg("i", one ? fmt::format("{}", row.first) : "i")));
    }
    return text + "}\n";
}

std::string one_direction(const std::vector<Row>& rows)
{
    std::string text =
        "// Light i, as one direction from p.\nLightSample light_sample(int i, vec3 p)\n{\n";
    for (const Row& row : rows)
        text +=
            fmt::format("    if (i < {})\n        return {}_sample(i, p);\n", row.end, row.name);
    return text + "    return LightSample(vec3(0.0), 0.0, vec3(0.0));\n}\n";
}

}  // namespace

gl::Defines write_lights(std::span<const Light> lights)
{
    const std::vector<Row> rows = rows_of(lights);
    gl::Defines defines;
    for (const auto& [constant, name] :
         {std::pair{"kSunCount", "sun"}, {"kPointCount", "point"}, {"kSpotCount", "spot"}})
        for (const Row& row : rows)
            if (std::string_view(row.name) == name)
                defines.emplace_back(constant, fmt::format("{}", row.end - row.first));
    defines.add_file("written/lights.glsl", one_direction(rows));
    defines.add_file("written/scattering.glsl",
                     for_each(rows,
                              "void add_lights(inout vec3 sum, LightLine line, LightStep step)",
                              "add_{kind}(sum, {i}, line, step)"));
    defines.add_file("written/irradiance.glsl",
                     for_each(rows, "void add_lights(inout vec3 sum, vec3 p, vec3 n)",
                              "add_{kind}_irradiance(sum, {i}, p, n)"));
    return defines;
}

}  // namespace fumarole::light
