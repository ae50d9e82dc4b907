// Where a froxel is sampled in this frame.
#include "scene/froxels.glsl"
#include "scene/media.glsl"

// Variant: the slice is taken whole as in 2017; else only the part of it that can hold media
const bool kCameraRange = false;

struct FroxelSample {
    vec3 p;       // eye-centred world [m]
    vec3 wo;      // to the eye, unit length
    float share;  // of the slice's thickness that the sample stands for, 0..1: nothing to sample at 0
};

// place: 0..1 across the froxel.
FroxelSample froxel_sample(ivec3 froxel, vec3 place)
{
    Ray ray = column_ray(froxel.xy, place.xy);
    vec2 slice = vec2(slice_begin(froxel.z), slice_begin(froxel.z + 1));
    vec2 inside = slice;
    if (!kCameraRange)
        inside = media_segment(ray.origin, ray.direction, slice.x, slice.y);
    FroxelSample s;
    s.p = ray.origin + ray.direction * mix(inside.x, inside.y, place.z);
    s.wo = -normalize(ray.direction);
    s.share = max(inside.y - inside.x, 0.0) / max(slice.y - slice.x, 1e-30);
    return s;
}

FroxelSample froxel_sample(ivec3 froxel) { return froxel_sample(froxel, u_froxels.jitter.xyz); }
