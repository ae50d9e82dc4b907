// From a depth buffer to metres along the view axis.
//   view_z_from_depth  see frame_params.h
// A host that clears depth to its far plane means "nothing there": the sky, infinitely far.
const float kSkyViewZ = 1e30;

float view_z_of(float depth, vec4 view_z_from_depth, float sky_depth)
{
    if (depth == sky_depth)
        return kSkyViewZ;
    return (view_z_from_depth.x * depth + view_z_from_depth.y) / (view_z_from_depth.z * depth + view_z_from_depth.w);
}

// Whether two depths are of one surface: falls with the fourth power of their difference, 1 well inside the
// tolerance. Held to where that power has a 32-bit value: it is never 0, so that of several depths that are
// all far off the nearest outweighs the rest.
float same_depth(float a, float b, float tolerance)
{
    float miss = min(abs(a - b) / tolerance, 1e8);
    return 1.0 / (1.0 + miss * miss * miss * miss);
}

vec4 same_depth(vec4 a, float b, float tolerance)
{
    vec4 miss = min(abs(a - b) / tolerance, vec4(1e8));
    return 1.0 / (1.0 + miss * miss * miss * miss);
}
