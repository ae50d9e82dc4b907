// Irradiance of a surface: of all lights, hidden by surfaces and, THROUGH_MEDIA, dimmed by the media on their way,
// and of the world. GLOSSY: what its layer reflects of them is summed up beside it.
#include "lib/lat_long.glsl"
#include "lib/lattice.glsl"
#include "lib/phase.glsl"
#include "scene/frame.glsl"
#include "scene/light_volumes_block.glsl"
#include "scene/lights.glsl"
#include "scene/probes.glsl"
#include "scene/world_irradiance.glsl"

// Variant. THROUGH_MEDIA: the scene's media are there, and pass/surface.vert tells of the first sun.
const bool kEnvironment = false;      // the world is a map: irradiance by normal from a table, else pi * its one colour
const bool kWorldIrradiance = false;  // what of it is hidden and dimmed is in a volume

layout(binding = IRRADIANCE_UNIT) uniform sampler2D u_irradiance_tx;

#ifdef GLOSSY
#include "scene/gloss.glsl"
#else
void add_reflection(vec3 irradiance, vec3 n, vec3 wi) {}
void add_world_reflection(vec3 p, vec3 n, vec3 irradiance, vec3 open) {}
#endif

// What the media let through of light i.
#if defined(OWN_THROUGH_MEDIA)  // the includer has it
#elif defined(THROUGH_MEDIA)
#include "scene/light_volumes.glsl"
#define SUN_VARYING in
#include "scene/sun_varying.glsl"
vec3 through_media(int i, vec3 p, LightSample light)
{
    if (!kDepthVolume || !light.is_sun || i > 0)
        return vec3(exp(-depth_to_light(i, p, light)));
    SunWay way = SunWay(way_column, way_enters, way_across, way_towards, SunLayer(way_first, way_period));
    return vec3(exp(-closed_depth(p, light.wi, light.range) - from_volume(stored_on_way(way), way_color)));
}
#else
vec3 through_media(int i, vec3 p, LightSample light) { return vec3(1.0); }
#endif

bool is_lit(LightSample light, vec3 n) { return dot(n, light.wi) > 0.0 && light.irradiance != vec3(0.0); }

// visibility: of the light, from p
void add_irradiance(inout vec3 sum, int i, LightSample light, vec3 p, vec3 n, float visibility)
{
    if (visibility > 0.0) {
        vec3 arriving = light.irradiance * (visibility * dot(n, light.wi)) * through_media(i, p, light);
        if (kLightFilters)
            arriving *= filter_on_surface(i, p);
        sum += arriving;
        add_reflection(arriving, n, light.wi);
    }
}

void add_sun_irradiance(inout vec3 sum, int i, vec3 p, vec3 n)
{
    LightSample light = sun_sample(i, p);
    if (is_lit(light, n))
        add_irradiance(sum, i, light, p, n, sun_on_surface(i, p, n));
}

void add_point_irradiance(inout vec3 sum, int i, vec3 p, vec3 n)
{
    LightSample light = point_sample(i, p);
    if (is_lit(light, n))
        add_irradiance(sum, i, light, p, n, point_on_surface(i, p, n));
}

void add_spot_irradiance(inout vec3 sum, int i, vec3 p, vec3 n)
{
    LightSample light = spot_sample(i, p);
    if (is_lit(light, n))
        add_irradiance(sum, i, light, p, n, spot_on_surface(i, p, n));
}

#include "written/irradiance.glsl"

// [W/m^2]; p: eye-centred metres, n: the side that is lit
vec3 irradiance_at(vec3 p, vec3 n)
{
    vec3 irradiance = kPi * u_lights.world_radiance.rgb;
    if (kEnvironment)
        irradiance = textureLod(u_irradiance_tx, lat_long_uv(n), 0.0).rgb;
    vec3 open = irradiance;
    if (kWorldIrradiance)
        irradiance = world_irradiance(p, n, open);
    add_world_reflection(p, n, irradiance, open);
    if (kProbeIrradiance)
        irradiance = probes_irradiance(p, n, open);
    add_lights(irradiance, p, n);
    return irradiance;
}
