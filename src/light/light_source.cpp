#include "light/light_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <limits>
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

double sum_of(glm::vec3 rgb)
{
    return static_cast<double>(rgb.r + rgb.g + rgb.b);
}

constexpr double kNoEdge = std::numeric_limits<double>::infinity();

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
    const LightPosition light = position_of(sun);
    const double large = scene.media.diagonal();
    Bounds seen = scene.media;  // what shadows fall on that are to be sharp
    for (const auto& instance : scene.surfaces.instances())
        if (instance.bounds.diagonal() <= large)
            seen.add(instance.bounds);
    Bounds details;
    bool is_shaded_by_others = false;
    for (const auto& instance : scene.surfaces.instances())
        // Others, and ground that shades nothing, are in the outer view alone.
        if (is_detail(instance, scene.media) &&
            (instance.bounds.diagonal() <= large || can_shade(light, instance.bounds, seen)))
            details.add(instance.bounds.transformed(axes.light_from_world));
        else
            is_shaded_by_others |= can_shade(light, instance.bounds, scene.media);
    inner.add(details);
    // Where nothing else shades the media, what is not in the details' own shadow is lit. The outer
    // view, in which they are coarse, ends their shadows within a texel or two.
    constexpr double kRim = 2;  // texels
    const double rim =
        kRim / scene.map_size * std::max(outer.max.x - outer.min.x, outer.max.y - outer.min.y);
    if (!details.empty() && !is_shaded_by_others) {
        details.min -= glm::dvec3(rim, rim, 0);
        details.max += glm::dvec3(rim, rim, 0);
        const glm::dvec3 size = details.max - details.min, whole = inner.max - inner.min;
        if (std::max(size.x, size.y) < std::max(whole.x, whole.y))
            inner = details;
    }
    return {{parallel_view(axes, inner, outer, scene.map_size),
             parallel_view(axes, outer, outer, scene.map_size)},
            2};
}

std::vector<LightPosition> points(const SunLight& sun)
{
    return {position_of(sun)};
}

void write(const SunLight&, const LightSlot&, std::span<shared::LightParams>) {}

constexpr double edge_angle(const SunLight&)
{
    return kNoEdge;
}

constexpr double mean_intensity(const SunLight&)
{
    return 0;
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

constexpr double edge_angle(const PointLight&)
{
    return kNoEdge;
}

double mean_intensity(const PointLight& point)
{
    return sum_of(point.radiant_intensity);
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

double edge_angle(const SpotLight& spot)
{
    const double half = glm::radians(spot.cone_deg) / 2;
    return (1 - std::cos(half)) * spot.blend / std::sin(half);  // across a cosine's blend
}

double mean_intensity(const SpotLight& spot)
{
    return sum_of(spot.radiant_intensity) * (1 - std::cos(glm::radians(spot.cone_deg) / 2)) / 2;
}

// -------------------------------------------------------------------------- rectangles and disks

/// That stand for one in shadows. A penumbra goes down in as many steps.
constexpr int kAreaPoints = 16;

/// What both are to glsl/scene/area_lights.glsl.
struct Area {
    glm::dvec3 center, u, v;  ///< half edges, or radii square to each other [m]
    glm::dvec3 normal;
    double size;  ///< [m^2]
    bool two_sided;
    bool is_disk;
};

Area area_of(const RectLight& rect)
{
    // Should the edges not be at right angles, it is a rectangle of their area.
    const glm::dvec3 u = 0.5 * rect.edges[0], across = glm::cross(u, 0.5 * rect.edges[1]);
    const double size = glm::length(across);
    if (!(size > 0)) {
        const LightAxes down({0, 0, 1});
        return {rect.center, 1e-9 * down.right, 1e-9 * down.up, down.travel, 0, false, false};
    }
    const glm::dvec3 v = glm::cross(across, u) / glm::dot(u, u);
    return {rect.center, u, v, -across / size, 4 * size, rect.two_sided, false};
}

Area area_of(const DiskLight& disk)
{
    const LightAxes axes(-disk.normal);
    const double r = disk.radius;
    return {disk.center,
            r * axes.right,
            r * axes.up,
            axes.travel,
            glm::pi<double>() * r * r,
            disk.two_sided,
            true};
}

/// Each side sends it by the cosine.
double mean_intensity(const Area& area, glm::vec3 radiance)
{
    return sum_of(radiance) * area.size / (area.two_sided ? 2 : 4);
}

/// Where a point of the square from -1 to 1 is put in the unit disk, areas kept: Shirley and Chiu
/// 1997, "A Low Distortion Map Between Disk and Square".
glm::dvec2 on_disk(glm::dvec2 at)
{
    const bool wide = std::abs(at.x) > std::abs(at.y);
    const double r = wide ? at.x : at.y, other = wide ? at.y : at.x;
    const double angle = glm::quarter_pi<double>() * other / r;
    return r * (wide ? glm::dvec2(std::cos(angle), std::sin(angle))
                     : glm::dvec2(std::sin(angle), std::cos(angle)));
}

/// Sobol's first: any four that begin at a multiple of four are spread evenly, too, and no two are
/// as far along an edge.
std::vector<LightPosition> points_on(const Area& area)
{
    constexpr std::array<unsigned, 4> kFirst{8, 4, 2, 1}, kSecond{8, 12, 10, 15};
    std::vector<LightPosition> points;
    for (unsigned n = 0; n < kAreaPoints; ++n) {
        glm::uvec2 place(0);
        for (unsigned bit = 0; bit < kFirst.size(); ++bit)
            if ((n >> bit & 1U) != 0)
                place = {place.x ^ kFirst.at(bit), place.y ^ kSecond.at(bit)};
        const glm::dvec2 square = (glm::dvec2(place) + 0.5) / 8.0 - 1.0;
        const glm::dvec2 at = area.is_disk ? on_disk(square) : square;
        points.push_back({false, area.center + at.x * area.u + at.y * area.v});
    }
    return points;
}

/// Six a point. What depths are scaled by is the same for all points, so one view is enough of
/// those in the block.
LightViews views_on(const Area& area, const ShadowScene& scene)
{
    const std::vector<LightPosition> points = points_on(area);
    LightViews views{{}, 1};
    double range = 0;
    for (const LightPosition& point : points)
        range = std::max(range, range_from(point.at, scene.surfaces.bounds()));
    for (const LightPosition& point : points)
        for (const View& view : point_views(point.at, range, scene.map_size))
            views.layers.push_back(view);
    return views;
}

void write_area(const Area& area, const LightSlot& slot, std::span<shared::LightParams> points)
{
    for (shared::LightParams& out : points) {
        out.cube_view_scale = 0.5f / static_cast<float>(point_view_tangent(slot.map_size));
        out.own[0] = glm::dvec4(area.center - slot.eye, area.size);
        out.own[1] = glm::dvec4(area.u, slot.first_layer + 6 * (&out - points.data()));
        out.own[2] = glm::dvec4(area.v, area.two_sided ? 1 : 0);
        out.own[3] = glm::dvec4(area.normal, 0);
    }
}

std::vector<LightPosition> points(const RectLight& rect)
{
    return points_on(area_of(rect));
}

LightViews views(const RectLight& rect, const ShadowScene& scene)
{
    return views_on(area_of(rect), scene);
}

void write(const RectLight& rect, const LightSlot& slot, std::span<shared::LightParams> points)
{
    write_area(area_of(rect), slot, points);
}

constexpr double edge_angle(const RectLight&)
{
    return kNoEdge;
}

double mean_intensity(const RectLight& rect)
{
    return mean_intensity(area_of(rect), rect.radiance);
}

std::vector<LightPosition> points(const DiskLight& disk)
{
    return points_on(area_of(disk));
}

LightViews views(const DiskLight& disk, const ShadowScene& scene)
{
    return views_on(area_of(disk), scene);
}

void write(const DiskLight& disk, const LightSlot& slot, std::span<shared::LightParams> points)
{
    write_area(area_of(disk), slot, points);
}

constexpr double edge_angle(const DiskLight&)
{
    return kNoEdge;
}

double mean_intensity(const DiskLight& disk)
{
    return mean_intensity(area_of(disk), disk.radiance);
}

// ------------------------------------------------------------------------------------------ GLSL

/// Lights in a row that are of one type, by the numbers of their points.
struct Row {
    const char* name;
    std::size_t first, end;
    std::size_t points;  ///< number of points of one of them

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
/// @param together what it calls instead for all points, if they are several
std::string for_each(const std::vector<Row>& rows, const char* head, const char* call,
                     const char* together = nullptr)
{
    std::string text = fmt::format("{}\n{{\n", head);
    for (const Row& row : rows) {
        const bool one = row.lights() == 1;
        const std::string next = row.points == 1 ? "++i" : fmt::format("i += {}", row.points);
        if (!one && together != nullptr && row.name == std::string_view("point")) {
            text += fmt::format("    {};\n",
                                fmt::format(fmt::runtime(together), fmt::arg("first", row.first),
                                            fmt::arg("end", row.end)));
            continue;
        }
        if (!one)
            text += fmt::format("    for (int i = {}; i < {}; {})\n    ", row.first, row.end, next);
        text += fmt::format("    {};\n",
                            fmt::format(fmt::runtime(call), fmt::arg("type", row.name),
                                        fmt::arg("i", one ? fmt::format("{}", row.first) : "i")));
    }
    return text + "}\n";
}

/// The functions of lights that have an area, where there are any.
std::string area_functions(const std::vector<Row>& rows, const char* file)
{
    const auto has_area = [](const Row& row) { return row.points == kAreaPoints; };
    const bool any = std::any_of(rows.begin(), rows.end(), has_area);
    return any ? fmt::format("#include \"{}\"\n", file) : "";
}

/// Each point of such a light as a light of its own.
std::vector<Row> points_of_areas(std::vector<Row> rows)
{
    for (Row& row : rows)
        if (row.points == kAreaPoints)
            row = {"area", row.first, row.end, 1};
    return rows;
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

double edge_angle_of(const Light& light)
{
    return std::visit([](const auto& one) { return edge_angle(one); }, light);
}

double mean_intensity_of(const Light& light)
{
    return std::visit([](const auto& one) { return mean_intensity(one); }, light);
}

gl::Defines write_lights(std::span<const Light> lights)
{
    const std::vector<Row> rows = rows_of(lights);
    gl::Defines defines;
    if (!rows.empty())
        defines.emplace_back("kLightPoints", fmt::format("{}", rows.back().end));
    if (rows.size() > 0 && rows.back().points == kAreaPoints)
        defines.emplace_back("kAreaPoints", fmt::format("{}", kAreaPoints));
    for (const auto& [constant, name] :
         {std::pair{"kSunCount", "sun"}, {"kPointCount", "point"}, {"kSpotCount", "spot"}})
        for (const Row& row : rows)
            if (std::string_view(row.name) == name)
                defines.emplace_back(constant, fmt::format("{}", row.lights()));
    defines.add_file(
        "written/scattering.glsl",
        area_functions(rows, "scene/area_scattering.glsl") +
            for_each(rows, "void add_lights(inout vec3 sum, LightLine line, LightStep step)",
                     "add_{type}(sum, {i}, line, step)",
                     "add_points(sum, {first}, {end}, line, step)") +
            "\n// Were all of it to arrive.\n" +
            for_each(rows, "void add_open_lights(inout vec3 sum, vec3 p, vec3 wo, float g)",
                     "sum += scattered_open({type}_sample({i}, p), wo, g)"));
    defines.add_file("written/irradiance.glsl",
                     area_functions(rows, "scene/area_irradiance.glsl") +
                         for_each(rows, "void add_lights(inout vec3 sum, vec3 p, vec3 n)",
                                  "add_{type}_irradiance(sum, {i}, p, n)"));
    defines.add_file("written/field.glsl",
                     area_functions(rows, "scene/area_lights.glsl") +
                         for_each(points_of_areas(rows), "void add_lights(vec3 p, float weight)",
                                  "add_light({i}, p, weight, {type}_sample({i}, p), "
                                  "{type}_on_surface({i}, p, vec3(0.0)))"));
    return defines;
}

}  // namespace fumarole::light
