// The froxel grid of this frame: its block, the rays of its columns, and where a world point lies in it.
#include "lib/froxel.glsl"
#include "scene/frame.glsl"
#include "shared/froxel_params.h"

#ifndef u_froxels  // as u_frame
layout(std140, binding = FROXEL_BLOCK) uniform Froxels { FroxelParams u_froxels; };
#endif

// Variant. EXTINCTION_IN_ALPHA: one extinction for all channels, in the alpha of a volume's colour; else it has a
// volume of its own, for green and blue alone if that alpha has its red. A host's shader is told which when it runs.
const bool kRedInAlpha = false;
#ifdef EXTINCTION_IN_ALPHA
#define volume_depth_t float
const bool kExtinctionInAlpha = true;
float volume_depth(vec4 color, vec4 extinction) { return color.a; }
#else
#define volume_depth_t vec3
const bool kExtinctionInAlpha = false;
vec3 volume_depth(vec4 color, vec4 extinction)
{
    if (kExtinctionInAlpha)
        return color.aaa;
    return kRedInAlpha ? vec3(color.a, extinction.rg) : extinction.rgb;
}
#endif

// Variant: what is integrated is looked up by a B-spline over 4^3 texels, which smooths along depth as well; else bilinear
// between columns and, within a slice, exact where it is uniform
const bool kTricubic = false;

// Texels of what is integrated before the one of the grid's front: a B-spline reaches one beyond both ends.
int texels_before_front() { return kTricubic ? 1 : 0; }

ivec3 froxel_count() { return ivec3(u_froxels.columns, u_froxels.slices.count); }

// Where slice k begins [m of view depth].
float slice_begin(int k) { return slice_view_z(float(k) / u_froxels.slices.count, u_froxels.slices); }

// The ray through a point of a column; place: 0..1 across its tile.
Ray column_ray(ivec2 column, vec2 place)
{
    vec2 pixel = (vec2(column) + place - u_froxels.guard_columns) * u_froxels.tile_pixels;
    return camera_ray(pixel * u_frame.inverse_full_size * 2.0 - 1.0);
}

// Columns, from the grid's edge, of a point of the picture in pixels.
vec2 columns_at(vec2 pixel) { return pixel / u_froxels.tile_pixels + u_froxels.guard_columns; }

// Where in a grid's textures, 0..1, a world point lies; outside: beyond 0..1.
vec3 froxel_uvw(vec3 p, mat4 clip_from_world, vec4 view_z_from_world, SliceParams slices)
{
    vec4 clip = clip_from_world * vec4(p, 1.0);
    float view_z = dot(vec4(p, 1.0), view_z_from_world);
    if (clip.w <= 0.0 || view_z < slices.begin || view_z > slices.end)
        return vec3(-1.0);
    vec2 pixel = (clip.xy / clip.w * 0.5 + 0.5) * u_frame.full_size;
    return vec3(columns_at(pixel) / u_froxels.columns, slice_at(view_z, slices));
}

bool is_inside(vec3 uvw) { return all(greaterThanEqual(uvw, vec3(0.0))) && all(lessThanEqual(uvw, vec3(1.0))); }
