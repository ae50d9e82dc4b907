#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "overloaded.h"
#include <fumarole/scene.h>

// The table of light types: each one's name and its fields, from which scene files are read and
// written, the window makes its controls, and all learn where a light is and what it sends. A type
// that is not in it fails to compile where it is visited.

namespace fumarole {

/// What is said of a field, to a scene file's author and to a window's user.
struct LightField {
    const char* key;         ///< key in a scene file
    const char* label = "";  ///< label in a window
    const char* help = "";
    const char* unit = "";  ///< unit in messages: "degrees"
    const char* sign = "";  ///< sign of the unit in a window: "deg"
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool open = false;      ///< both ends are not allowed themselves
    bool optional = false;  ///< the default stands where a file has no such key
    int metres = 0;         ///< the power of a length that it grows with as the scene does
};

namespace light_field {

inline constexpr LightField kPosition{"position", "position", "in the world", "metres", "m"};
inline constexpr LightField kCenter{"center", "center", "in the world", "metres", "m"};
inline constexpr LightField kRadiance{"radiance_W_per_m2_sr", "radiance", "to all directions",
                                      "W/m^2/sr", "W/m2/sr"};
inline constexpr LightField kTwoSided{
    .key = "two_sided", .label = "two-sided", .help = "shines from both", .optional = true};

template <typename T, typename... L>
concept All = (std::same_as<std::remove_const_t<L>, T> && ...);

}  // namespace light_field

// visit_fields(visitor, light...): calls the visitor's function for each field's role, with what is
// said of it and the field of each of the lights, all of one type.
//   to_light(field, dvec3&...)   unit direction to a light infinitely far away
//   position(field, dvec3&...)   of a light that has a place [m]
//   axis(field, dvec3&...)       unit direction
//   number(field, double&...)
//   flag(field, bool&...)
//   edges(field, std::array<dvec3, 2>&...)   of a rectangle [m], at right angles
//   power(field, vec3&...)       what it sends: none where it is 0

template <typename V, typename... L>
requires light_field::All<SunLight, L...>
void visit_fields(V&& v, L&... light)
{
    v.to_light({.key = "direction_to_light", .help = "where the sun stands"},
               light.direction_to_light...);
    v.power({.key = "irradiance_W_per_m2",
             .label = "irradiance",
             .help = "on a plane that faces it",
             .unit = "W/m^2",
             .sign = "W/m2"},
            light.irradiance...);
}

template <typename V, typename... L>
requires light_field::All<PointLight, L...>
void visit_fields(V&& v, L&... light)
{
    v.position(light_field::kPosition, light.position...);
    v.power({.key = "radiant_intensity_W_per_sr",
             .label = "intensity",
             .help = "to all sides",
             .unit = "W/sr",
             .sign = "W/sr",
             .metres = 2},
            light.radiant_intensity...);
}

template <typename V, typename... L>
requires light_field::All<SpotLight, L...>
void visit_fields(V&& v, L&... light)
{
    v.position(light_field::kPosition, light.position...);
    v.axis({.key = "direction", .help = "where it shines"}, light.direction...);
    v.number({.key = "cone_deg",
              .label = "cone",
              .help = "full opening angle",
              .unit = "degrees",
              .sign = "deg",
              .min = 0,
              .max = 180,
              .open = true,
              .optional = true},
             light.cone_deg...);
    v.number({.key = "blend",
              .label = "blend",
              .help = "share of the cone that fades",
              .min = 0,
              .max = 1,
              .optional = true},
             light.blend...);
    v.power({.key = "radiant_intensity_W_per_sr",
             .label = "intensity",
             .help = "on the axis",
             .unit = "W/sr",
             .sign = "W/sr",
             .metres = 2},
            light.radiant_intensity...);
}

template <typename V, typename... L>
requires light_field::All<RectLight, L...>
void visit_fields(V&& v, L&... light)
{
    v.position(light_field::kCenter, light.center...);
    v.edges({.key = "edges",
             .label = "edge",
             .help = "along its whole length",
             .unit = "metres",
             .sign = "m",
             .metres = 1},
            light.edges...);
    v.power(light_field::kRadiance, light.radiance...);
    v.flag(light_field::kTwoSided, light.two_sided...);
}

template <typename V, typename... L>
requires light_field::All<DiskLight, L...>
void visit_fields(V&& v, L&... light)
{
    v.position(light_field::kCenter, light.center...);
    v.axis({.key = "normal", .help = "where it shines"}, light.normal...);
    v.number({.key = "radius",
              .label = "radius",
              .help = "of the disk",
              .unit = "metres",
              .sign = "m",
              .min = 0,
              .open = true,
              .metres = 1},
             light.radius...);
    v.power(light_field::kRadiance, light.radiance...);
    v.flag(light_field::kTwoSided, light.two_sided...);
}

/// The type's name in scene files, windows and reports, and in the functions of glsl/.
inline const char* light_name(const Light& light)
{
    return std::visit(
        Overloaded{[](const SunLight&) { return "sun"; }, [](const PointLight&) { return "point"; },
                   [](const SpotLight&) { return "spot"; }, [](const RectLight&) { return "rect"; },
                   [](const DiskLight&) { return "disk"; }},
        light);
}

/// A light of each type, as it is by default, in the order of Light's types.
template <std::size_t... I> std::vector<Light> make_light_types(std::index_sequence<I...>)
{
    return {Light(std::in_place_index<I>)...};
}
inline const std::vector<Light>& light_types()
{
    static const std::vector<Light> all =
        make_light_types(std::make_index_sequence<std::variant_size_v<Light>>{});
    return all;
}

/// A visitor that does nothing: derive from it what looks for some fields alone.
struct NoField {
    template <typename... T> void to_light(const LightField&, T&...) {}
    template <typename... T> void position(const LightField&, T&...) {}
    template <typename... T> void axis(const LightField&, T&...) {}
    template <typename... T> void number(const LightField&, T&...) {}
    template <typename... T> void flag(const LightField&, T&...) {}
    template <typename... T> void edges(const LightField&, T&...) {}
    template <typename... T> void power(const LightField&, T&...) {}
};

template <typename V> void visit_light(V&& visitor, const Light& light)
{
    std::visit([&](const auto& one) { visit_fields(visitor, one); }, light);
}
template <typename V> void visit_light(V&& visitor, Light& light)
{
    std::visit([&](auto& one) { visit_fields(visitor, one); }, light);
}

/// Where a light is: a place [m], or the unit direction to one infinitely far away.
struct LightPosition {
    bool far = false;
    glm::dvec3 at{0};

    bool operator==(const LightPosition&) const = default;
};

inline LightPosition position_of(const Light& light)
{
    struct : NoField {
        LightPosition found;
        void to_light(const LightField&, const glm::dvec3& wi)
        {
            found = {true, glm::normalize(wi)};
        }
        void position(const LightField&, const glm::dvec3& p) { found = {false, p}; }
    } look;
    visit_light(look, light);
    return look.found;
}

/// Puts a light elsewhere: as position_of() has it.
inline void move_to(Light& light, glm::dvec3 at)
{
    struct : NoField {
        glm::dvec3 there;
        void to_light(const LightField&, glm::dvec3& wi) { wi = there; }
        void position(const LightField&, glm::dvec3& p) { p = there; }
    } move;
    move.there = at;
    visit_light(move, light);
}

/// Makes what a light is by default fit a scene that is `size` metres large.
inline void scale_to(Light& light, double size)
{
    struct : NoField {
        double size = 1;
        [[nodiscard]] double of(const LightField& field) const
        {
            return std::pow(size, field.metres);
        }
        void number(const LightField& field, double& value) { value *= of(field); }
        void edges(const LightField& field, std::array<glm::dvec3, 2>& edges)
        {
            for (glm::dvec3& edge : edges)
                edge *= of(field);
        }
        void power(const LightField& field, glm::vec3& value)
        {
            value *= static_cast<float>(of(field));
        }
    } scale;
    scale.size = size;
    visit_light(scale, light);
}

/// What it sends, in the unit of its type.
inline glm::vec3 power_of(const Light& light)
{
    struct : NoField {
        glm::vec3 found{0};
        void power(const LightField&, const glm::vec3& value) { found = value; }
    } look;
    visit_light(look, light);
    return look.found;
}

}  // namespace fumarole
