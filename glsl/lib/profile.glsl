// Coefficients of the procedural media at a point p of eye-centred world [m].
#include "lib/noise.glsl"
#include "shared/medium_params.h"

bool inside_bounds(MediumParams medium, vec3 p)
{
    vec3 q = (medium.bounds_from_world * vec4(p, 1.0)).xyz;
    return all(greaterThanEqual(q, medium.bounds_min.xyz)) &&
           all(lessThanEqual(q, medium.bounds_max.xyz));
}

float profile_homogeneous(MediumParams medium, vec3 p) { return inside_bounds(medium, p) ? 1.0 : 0.0; }

// exp(-(z - z0) / scale_height)
float profile_exp_height(MediumParams medium, vec3 p)
{
    return inside_bounds(medium, p) ? exp((medium.profile.y - p.z) * medium.profile.x) : 0.0;
}
