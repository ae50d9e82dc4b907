// Coefficients of the procedural media at a point p of eye-centred world [m].
#include "lib/noise.glsl"
#include "shared/medium_params.h"

// A box's bounds are in metres already.
bool inside_bounds(MediumParams medium, vec3 p)
{
    return all(greaterThanEqual(p, medium.bounds_min)) && all(lessThanEqual(p, medium.bounds_max));
}

float profile_homogeneous(MediumParams medium, vec3 p) { return inside_bounds(medium, p) ? 1.0 : 0.0; }

// exp(-(z - z0) / scale_height), held at 40 heights below z0: 1e17 times as thick is a wall, and 88 would
// be an infinity.
float exp_height_at(MediumParams medium, float z)
{
    return exp(min((medium.base_height - z) * medium.inverse_scale_height, 40.0));
}

float profile_exp_height(MediumParams medium, vec3 p)
{
    return inside_bounds(medium, p) ? exp_height_at(medium, p.z) : 0.0;
}
