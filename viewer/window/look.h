#pragma once

#include <glm/glm.hpp>

#include <fumarole/scene.h>

// What an artist turns first: a few numbers in place of all coefficients. Each is of the media that
// are looked at, which are the grids, or the boxes where there are no grids.

namespace fumarole::window {

/// Extinction over that of the scene as it was read: 1 for a scene as read, and 0 where there is
/// none.
double density_of(const Scene& scene, const Scene& as_read);
/// Gives each medium `times` its extinction as read; albedo stays.
void set_density(Scene& scene, const Scene& as_read, double times);

/// Scattering over extinction, of each channel. 0..1
glm::vec3 albedo_of(const Scene& scene);
/// Extinction stays.
void set_albedo(Scene& scene, glm::vec3 albedo);

/// Mean cosine of the scattering.
float anisotropy_of(const Scene& scene);
void set_anisotropy(Scene& scene, float g);

/// Whether a medium that is looked at glows.
bool has_fire(const Scene& scene);
/// Emission over that of the scene as it was read, or 0 where there is none.
double fire_of(const Scene& scene, const Scene& as_read);
void set_fire(Scene& scene, const Scene& as_read, double times);

/// The first sun, or null.
SunLight* sun_of(Scene& scene);

/// Radiance of the world, or the scale of its map, over that of the scene as it was read; over 1
/// W/m^2/sr where that was black.
double sky_of(const Scene& scene, const Scene& as_read);
void set_sky(Scene& scene, const Scene& as_read, double times);

}  // namespace fumarole::window
