// From a depth buffer to metres along the view axis.
//   view_z_from_depth  see frame_params.h
// A host that clears depth to its far plane means "nothing there": the sky, infinitely far.
const float kSkyViewZ = 1e30;

float view_z_of(float depth, vec4 view_z_from_depth, float sky_depth)
{
    if (depth == sky_depth)
        return kSkyViewZ;
    return (view_z_from_depth.x * depth + view_z_from_depth.y) /
           (view_z_from_depth.z * depth + view_z_from_depth.w);
}
