// Last frame's froxels, looked up where this frame's lie, and how this frame's are kept for the next. Needs
// scene/in_scattering.glsl, scene/v_buffer.glsl.
#include "lib/dithered_half.glsl"
#include "lib/noise.glsl"
#include "scene/turned_to_eye.glsl"

// Variant
const bool kDithered = false;  // what is kept has 16 bits

layout(binding = FROXEL_SOURCE_IMAGE) writeonly uniform image3D u_source_img;
layout(binding = FROXEL_EXTINCTION_IMAGE) writeonly uniform image3D u_extinction_img;
layout(binding = FROXEL_HISTORY_UNIT) uniform sampler3D u_history_tx;
layout(binding = FROXEL_HISTORY_EXTINCTION_UNIT) uniform sampler3D u_history_extinction_tx;

// A froxel's unjittered middle.
struct HistoryPlace {
    vec3 p;    // eye-centred world [m]
    vec3 wo;   // to the eye, unit length
    vec3 uvw;  // in last frame's grid; outside of 0..1 it is not there
};

HistoryPlace history_place(ivec3 froxel)
{
    Ray ray = column_ray(froxel.xy, vec2(0.5));
    float s = (float(froxel.z) + 0.5) / u_froxels.slices.count;
    vec3 p = ray.origin + ray.direction * slice_view_z(s, u_froxels.slices);
    vec3 uvw =
        froxel_uvw(p, u_froxels.history_clip_from_world, u_froxels.history_view_z_from_world, u_froxels.history_slices);
    return HistoryPlace(p, -normalize(ray.direction), uvw);
}

struct LitFroxel {
    vec3 source, extinction;
};

LitFroxel history_at(vec3 uvw)
{
    // The volumes may have slices behind the froxels' last, for what is integrated.
    float count = u_froxels.slices.count;
    uvw.z = min(uvw.z * count, count - 0.5) / float(textureSize(u_history_tx, 0).z);
    vec4 source = textureLod(u_history_tx, uvw, 0.0) * u_froxels.history_slices.rescale;
    vec4 apart = vec4(0.0);
    if (!has_one_extinction())
        apart = textureLod(u_history_extinction_tx, uvw, 0.0) * u_froxels.history_slices.rescale;
    return LitFroxel(source.rgb, extinction_of_kept(source, apart));
}

LitFroxel history_of(ivec3 froxel)
{
    vec4 source = texelFetch(u_history_tx, froxel, 0);
    vec4 apart = vec4(0.0);
    if (!has_one_extinction())
        apart = texelFetch(u_history_extinction_tx, froxel, 0);
    return LitFroxel(source.rgb, extinction_of_kept(source, apart));
}

// The dithers of a froxel in this frame: of its source, and of its extinction.
uvec2 froxel_dither(ivec3 froxel) { return dither_of_frame(hash_pcg3d(uvec3(froxel)).xy, u_froxels.dithered_frame); }

// What is kept of a value. Its channels share a dither, so that what is grey stays grey.
vec4 kept_value(vec4 value, uint color_dither, uint alpha_dither)
{
    if (!kDithered)
        return value;
    return vec4(dithered_half(value.r, color_dither), dithered_half(value.g, color_dither),
                dithered_half(value.b, color_dither), dithered_half(value.a, alpha_dither));
}

void keep(ivec3 froxel, vec3 source, vec3 extinction)
{
    uvec2 dither = froxel_dither(froxel);
    imageStore(u_source_img, froxel, kept_value(vec4(source, extinction_in_source(extinction)), dither.x, dither.y));
    if (!has_one_extinction())
        imageStore(u_extinction_img, froxel, kept_value(extinction_apart(extinction), dither.y, dither.y));
}

// How much brighter a medium at a place is from here than from where the eye was.
vec3 history_turn(HistoryPlace place, FroxelMedium medium)
{
    return turned_to_eye(place.p, place.wo, u_froxels.history_eye, medium.sigma_s, medium.emission, medium.g);
}
