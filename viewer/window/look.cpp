#include "window/look.h"

#include <algorithm>

#include "overloaded.h"

namespace fumarole::window {

namespace {

/// What of a medium an artist turns.
struct Handles {
    glm::vec3 *scattering, *absorption;
    float* g;
    glm::vec3* emission;
    float* blackbody;  ///< null: it has none
};

bool is_looked_at(const Scene& scene, const Medium& medium)
{
    const bool grids = std::any_of(scene.media.begin(), scene.media.end(), [](const Medium& other) {
        return std::holds_alternative<GridMedium>(other);
    });
    return !grids || std::holds_alternative<GridMedium>(medium);
}

Handles handles_of(Medium& medium)
{
    return std::visit(
        Overloaded{[](GridMedium& grid) {
                       return Handles{&grid.sigma_s_per_density, &grid.sigma_a_per_density, &grid.g,
                                      &grid.emission_per_unit,
                                      grid.temperature_grid.empty() ? nullptr
                                                                    : &grid.blackbody_intensity};
                   },
                   [](BoxMedium& box) {
                       return Handles{&box.sigma_s, &box.sigma_a, &box.g, &box.emission, nullptr};
                   }},
        medium);
}

/// Calls f(handles, handles as read) for each medium that is looked at; one that was not read is
/// as it is.
template <class F> void for_each(Scene& scene, const Scene& as_read, F f)
{
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        if (!is_looked_at(scene, scene.media[i]))
            continue;
        const bool same =
            i < as_read.media.size() && as_read.media[i].index() == scene.media[i].index();
        Medium first = same ? as_read.media[i] : scene.media[i];
        f(handles_of(scene.media[i]), handles_of(first));
    }
}

/// The same of a scene that stays as it is.
template <class F> void for_each(const Scene& scene, const Scene& as_read, F f)
{
    Scene media;  // alone: the rest is not looked at
    media.media = scene.media;
    for_each(media, as_read, f);
}

float sum(glm::vec3 v)
{
    return v.x + v.y + v.z;
}

double emitted(const Handles& of)
{
    return double{sum(*of.emission)} + (of.blackbody != nullptr ? double{*of.blackbody} : 0);
}

/// Of b, of which there may be none.
double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

}  // namespace

double density_of(const Scene& scene, const Scene& as_read)
{
    double now = 0, first = 0;
    for_each(scene, as_read, [&](const Handles& of, const Handles& was) {
        now += double{sum(*of.scattering + *of.absorption)};
        first += double{sum(*was.scattering + *was.absorption)};
    });
    return ratio(now, first);
}

void set_density(Scene& scene, const Scene& as_read, double times)
{
    for_each(scene, as_read, [&](const Handles& of, const Handles& was) {
        for (int c = 0; c < 3; ++c) {
            const float now = (*of.scattering)[c] + (*of.absorption)[c];
            const float extinction =
                static_cast<float>(times) * ((*was.scattering)[c] + (*was.absorption)[c]);
            const float albedo = now > 0 ? (*of.scattering)[c] / now : 1;
            (*of.scattering)[c] = albedo * extinction;
            (*of.absorption)[c] = (1 - albedo) * extinction;
        }
    });
}

glm::vec3 albedo_of(const Scene& scene)
{
    glm::vec3 scattering(0), extinction(0);
    for_each(scene, scene, [&](const Handles& of, const Handles&) {
        scattering += *of.scattering;
        extinction += *of.scattering + *of.absorption;
    });
    glm::vec3 albedo(0);
    for (int c = 0; c < 3; ++c)
        albedo[c] = extinction[c] > 0 ? scattering[c] / extinction[c] : 0;
    return albedo;
}

void set_albedo(Scene& scene, glm::vec3 albedo)
{
    for_each(scene, scene, [&](const Handles& of, const Handles&) {
        const glm::vec3 extinction = *of.scattering + *of.absorption;
        *of.scattering = glm::clamp(albedo, 0.0f, 1.0f) * extinction;
        *of.absorption = extinction - *of.scattering;
    });
}

float anisotropy_of(const Scene& scene)
{
    float weighted = 0, weight = 0, plain = 0;
    for_each(scene, scene, [&](const Handles& of, const Handles&) {
        weighted += *of.g * sum(*of.scattering);
        weight += sum(*of.scattering);
        plain = *of.g;
    });
    return weight > 0 ? weighted / weight : plain;
}

void set_anisotropy(Scene& scene, float g)
{
    for_each(scene, scene, [&](const Handles& of, const Handles&) { *of.g = g; });
}

bool has_fire(const Scene& scene)
{
    bool fire = false;
    for (const Medium& medium : scene.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium))
            fire |= grid->emission != nullptr || grid->temperature != nullptr;
        else
            fire |=
                is_looked_at(scene, medium) && std::get<BoxMedium>(medium).emission != glm::vec3(0);
    return fire;
}

double fire_of(const Scene& scene, const Scene& as_read)
{
    double now = 0, first = 0;
    for_each(scene, as_read, [&](const Handles& of, const Handles& was) {
        now += emitted(of);
        first += emitted(was);
    });
    return ratio(now, first);
}

void set_fire(Scene& scene, const Scene& as_read, double times)
{
    for_each(scene, as_read, [&](const Handles& of, const Handles& was) {
        *of.emission = static_cast<float>(times) * *was.emission;
        if (of.blackbody != nullptr)
            *of.blackbody = static_cast<float>(times) * *was.blackbody;
    });
}

SunLight* sun_of(Scene& scene)
{
    for (Light& light : scene.lights)
        if (auto* sun = std::get_if<SunLight>(&light))
            return sun;
    return nullptr;
}

double sky_of(const Scene& scene, const Scene& as_read)
{
    if (scene.world.environment != nullptr)
        return ratio(double{scene.world.environment_scale},
                     double{as_read.world.environment_scale});
    const double first = double{sum(as_read.world.radiance)};
    return double{sum(scene.world.radiance)} / (first > 0 ? first : 3);
}

void set_sky(Scene& scene, const Scene& as_read, double times)
{
    const auto by = static_cast<float>(times);
    if (scene.world.environment != nullptr)
        scene.world.environment_scale = by * as_read.world.environment_scale;
    else if (as_read.world.radiance != glm::vec3(0))
        scene.world.radiance = by * as_read.world.radiance;
    else
        scene.world.radiance = glm::vec3(by);
}

}  // namespace fumarole::window
