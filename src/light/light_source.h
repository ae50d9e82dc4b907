#pragma once

#include <span>
#include <vector>

#include "gl/program.h"
#include "light/shadow_views.h"
#include "light_fields.h"
#include "shared/light_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// What each type of light is to the GPU: the points that stand for it, its views of the surfaces,
// its parameters, and its functions, which glsl/scene has by its name. light_fields.h says what it
// is to all others.

namespace fumarole::light {

/// The points that stand for a light, one or more. Each has a number, which lights[] and the layers
/// of optical depth are counted by.
std::vector<LightPosition> points_of(const Light& light);

/// What a light looks at.
struct ShadowScene {
    const surface::SurfaceSet& surfaces;
    Bounds media;      ///< bounds of the media whose shadows get detail
    int map_size = 0;  ///< texels along an edge of each view
};

struct LightViews {
    std::vector<View> layers;  ///< layers of the shadow map, for all its points
    int in_block = 0;          ///< the first so many of them are in the block too
};

/// A light's views of the surfaces.
LightViews views_of(const Light& light, const ShadowScene& scene);

/// What a light is seen from, and where its views are.
struct LightSlot {
    glm::dvec3 eye{0};    ///< metres, world
    int map_size = 0;     ///< texels along an edge of each view
    int first_layer = 0;  ///< first layer of its views, in the shadow map
};

/// What a light's type has of its own, into the parameters of its points, which have the rest.
void write_own(const Light& light, const LightSlot& slot, std::span<shared::LightParams> points);

/// The angle over which the edge of its beam fades [rad], seen from the light; infinite if it has
/// none.
double edge_angle_of(const Light& light);

/// The mean over all directions, summed over the channels [W/sr]; none of a sun.
double mean_intensity_of(const Light& light);

/// What glsl/scene/lights.glsl needs: written/scattering.glsl and written/irradiance.glsl, which
/// call the functions of each light's type.
/// @param lights each type's in a row, in the order of Light's types
gl::Defines write_lights(std::span<const Light> lights);

}  // namespace fumarole::light
