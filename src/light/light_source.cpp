#include "light/light_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <string>

namespace fumarole::light {

namespace {

/// Metres that reach the farthest corner of a box from a point.
double range_from(glm::dvec3 p, const Bounds& bounds)
{
    double far = 0;
    for (int i = 0; i < 8 && !bounds.empty(); ++i)
        far = std::max(far, glm::length(bounds.corner(i) - p));
    return 1.01 * far;
}

template <typename Own> void set_own(shared::LightParams& light, const Own& own)
{
    static_assert(sizeof(own) <= sizeof(light.own));
    std::memcpy(&light.own, &own, sizeof(own));
}

// ------------------------------------------------------------------------------------------ suns

LightViews views(const SunLight& sun, const ShadowScene& scene)
{
    const LightAxes axes(sun.direction_to_light);
    const Bounds outer = scene.surfaces.bounds().transformed(axes.light_from_world);
    Bounds inner = scene.media.transformed(axes.light_from_world);
    if (scene.media.empty())
        inner = outer;
    for (const auto& instance : scene.surfaces.instances())
        if (is_detail(instance, scene.media))  // others are in the outer view alone
            inner.add(instance.bounds.transformed(axes.light_from_world));
    return {{parallel_view(axes, inner, outer, scene.map_size),
             parallel_view(axes, outer, outer, scene.map_size)},
            2};
}

std::vector<LightPosition> points(const SunLight& sun)
{
    return {position_of(sun)};
}

void write(const SunLight&, const LightSlot&, std::span<shared::LightParams>) {}

constexpr bool edged(const SunLight&)
{
    return false;
}

// ---------------------------------------------------------------------------------------- points

std::vector<LightPosition> points(const PointLight& point)
{
    return {position_of(point)};
}

LightViews views(const PointLight& point, const ShadowScene& scene)
{
    const double range = range_from(point.position, scene.surfaces.bounds());
    return {point_views(point.position, range, scene.map_size), 6};
}

void write(const PointLight&, const LightSlot& slot, std::span<shared::LightParams> points)
{
    for (shared::LightParams& out : points)
        out.cube_view_scale = 0.5f / static_cast<float>(point_view_tangent(slot.map_size));
}

constexpr bool edged(const PointLight&)
{
    return false;
}

// ----------------------------------------------------------------------------------------- spots

std::vector<LightPosition> points(const SpotLight& spot)
{
    return {position_of(spot)};
}

LightViews views(const SpotLight& spot, const ShadowScene& scene)
{
    const double range = range_from(spot.position, scene.surfaces.bounds());
    return {{spot_view(spot, range, scene.map_size)}, 1};
}

void write(const SpotLight& spot, const LightSlot&, std::span<shared::LightParams> points)
{
    const double edge = std::cos(glm::radians(spot.cone_deg) / 2);
    shared::SpotParams own{};
    own.axis = glm::vec3(glm::normalize(spot.direction));
    own.cos_half_cone = static_cast<float>(edge);
    // Cycles' cone: full from edge + (1 - edge) * blend inwards. 0 would divide by 0.
    own.inverse_edge_width = static_cast<float>(1 / std::max((1 - edge) * spot.blend, 1e-6));
    for (shared::LightParams& out : points)
        set_own(out, own);
}

constexpr bool edged(const SpotLight&)
{
    return true;
}

// ------------------------------------------------------------------------------------------ GLSL

/// Lights in a row that are of one type, by the numbers of their points.
struct Row {
    const char* name;
    std::size_t first, end;
    std::size_t points;  ///< of one of them

    [[nodiscard]] std::size_t lights() const { return (end - first) / points; }
};

std::vector<Row> rows_of(std::span<const Light> lights)
{
    std::vector<Row> rows;
    std::size_t end = 0;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const std::size_t points = points_of(lights[i]).size();
        if (i == 0 || lights[i].index() != lights[i - 1].index())
            rows.push_back({light_name(lights[i]), end, end, points});
        rows.back().end = end += points;
    }
    return rows;
}

/// A function that calls another for each light, of a name that its type is put into.
std::string for_each(const std::vector<Row>& rows, const char* head, const char* call)
{
    std::string text = fmt::format("{}\n{{\n", head);
    for (const Row& row : rows) {
        const bool one = row.lights() == 1;
        const std::string next = row.points == 1 ? "++i" : fmt::format("i += {}", row.points);
        if (!one)
            text += fmt::format("    for (int i = {}; i < {}; {})\n    ", row.first, row.end, next);
        text += fmt::format("    {};\n",
                            fmt::format(fmt::runtime(call), fmt::arg("type", row.name),
                                        fmt::arg("i", one ? fmt::format("{}", row.first) : "i")));
    }
    return text + "}\n";
}

}  // namespace

std::vector<LightPosition> points_of(const Light& light)
{
    return std::visit([](const auto& one) { return points(one); }, light);
}

LightViews views_of(const Light& light, const ShadowScene& scene)
{
    return std::visit([&](const auto& one) { return views(one, scene); }, light);
}

void write_own(const Light& light, const LightSlot& slot, std::span<shared::LightParams> points)
{
    std::visit([&](const auto& one) { write(one, slot, points); }, light);
}

bool has_edge(const Light& light)
{
    return std::visit([](const auto& one) { return edged(one); }, light);
}

gl::Defines write_lights(std::span<const Light> lights)
{
    const std::vector<Row> rows = rows_of(lights);
    gl::Defines defines;
    if (!rows.empty())
        defines.emplace_back("kLightPoints", fmt::format("{}", rows.back().end));
    for (const auto& [constant, name] :
         {std::pair{"kSunCount", "sun"}, {"kPointCount", "point"}, {"kSpotCount", "spot"}})
        for (const Row& row : rows)
            if (std::string_view(row.name) == name)
                defines.emplace_back(constant, fmt::format("{}", row.lights()));
    defines.add_file(
        "written/scattering.glsl",
        for_each(rows, "void add_lights(inout vec3 sum, LightLine line, LightStep step)",
                 "add_{type}(sum, {i}, line, step)") +
            "\n// Were all of it to arrive.\n" +
            for_each(rows, "void add_open_lights(inout vec3 sum, vec3 p, vec3 wo, float g)",
                     "sum += scattered_open({type}_sample({i}, p), wo, g)"));
    defines.add_file("written/irradiance.glsl",
                     for_each(rows, "void add_lights(inout vec3 sum, vec3 p, vec3 n)",
                              "add_{type}_irradiance(sum, {i}, p, n)"));
    defines.add_file("written/field.glsl",
                     for_each(rows, "void add_lights(vec3 p, float weight)",
                              "add_light({i}, p, weight, {type}_sample({i}, p), "
                              "{type}_on_surface({i}, p, vec3(0.0)))"));
    return defines;
}

}  // namespace fumarole::light
