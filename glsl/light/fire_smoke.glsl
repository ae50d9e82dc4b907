// What dims a fire, as light/fire_medium.comp stored it. extinction_t: a vec3 unless all media have one colour.
#include "lib/lattice.glsl"
#include "lib/slab.glsl"
#include "scene/light_volumes_block.glsl"

layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_flame_sigma_t_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = FIELD_ALBEDO_UNIT) uniform sampler3D u_sigma_t_tx;

float of_kind(vec4 stored, float kind) { return stored.r; }
vec3 of_kind(vec4 stored, vec3 kind) { return stored.rgb; }
vec3 in_color(float depth) { return depth * u_volumes.fire.extinction_color; }
vec3 in_color(vec3 depth) { return depth; }
float least_of(float depth) { return depth; }
float least_of(vec3 depth) { return min(depth.r, min(depth.g, depth.b)); }

// [1/m], where it glows. uvw: of the lattice's texture
extinction_t flame_sigma_t(vec3 uvw) { return of_kind(textureLod(u_flame_sigma_t_tx, uvw, 0.0), extinction_t(0.0)); }

// Optical depth of all media, from p along wi, `range` metres on.
extinction_t smoke_depth(vec3 p, vec3 wi, float range)
{
    const float kMostSteps = 8.0;
    const float kStep = 3.0;  // nodes
    LatticeParams media = u_volumes.fire.media;
    vec2 smoke = lattice_segment(media, p, wi, range);
    float steps = smoke.x < smoke.y ? clamp(ceil((smoke.y - smoke.x) / (kStep * media.spacing)), 1.0, kMostSteps) : 0.0;
    float ds = (smoke.y - smoke.x) / max(steps, 1.0);
    extinction_t depth = extinction_t(0.0);
    for (float i = 0.5; i < steps; ++i)
        depth += of_kind(textureLod(u_sigma_t_tx, lattice_uvw(media, p + wi * (smoke.x + ds * i), 0), 0.0),
                         extinction_t(0.0));
    return depth * ds;
}
