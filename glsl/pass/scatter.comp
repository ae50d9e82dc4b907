// Froxels, step 2: light into the V-buffer's media, and what is kept of the frames before.
//   in   the V-buffer, lights, shadow map; last frame's source and extinction
//   out  source      radiance added per slices.depth metres: sigma_s * in_scattering + emission
//        extinction  of the V-buffer, averaged over frames as the source is
// The history is last frame's froxel at the unjittered middle of this one, so samples that are jittered
// from frame to frame average over the froxel. Each froxel is worked out in every frame, seen or hidden by
// a surface: none of them can have been hidden, so a surface that moves away uncovers nothing unknown.
//
// Variant, besides those of scene/froxel_sample.glsl and scene/in_scattering.glsl:
//   GRID_SHADOWS    light is dimmed by the V-buffer, marched in the view's frustum, as in 2017: what lies
//                   outside of the view throws no shadow; else by the media themselves
//   HISTORY         last frame's froxels are there; HISTORY_STILL: they are these, one for one
//   COUNT_SAMPLES   write the number of media evaluations of both steps instead
#include "scene/froxel_sample.glsl"
#include "scene/lights.glsl"

layout(local_size_x = FROXEL_GROUP_X, local_size_y = FROXEL_GROUP_Y, local_size_z = FROXEL_GROUP_Z) in;
layout(binding = FROXEL_SOURCE_IMAGE) writeonly uniform image3D u_source_img;
layout(binding = V_BUFFER_SIGMA_S_UNIT) uniform sampler3D u_sigma_s_tx;
#ifndef EXTINCTION_IN_ALPHA
layout(binding = FROXEL_EXTINCTION_IMAGE) writeonly uniform image3D u_extinction_img;
layout(binding = V_BUFFER_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
#endif
#ifdef FOR_EACH_EMISSION
layout(binding = V_BUFFER_EMISSION_UNIT) uniform sampler3D u_emission_tx;
#endif
#ifdef MIXED_G
layout(binding = V_BUFFER_PHASE_UNIT) uniform sampler3D u_phase_tx;
#endif
#ifdef HISTORY
layout(binding = FROXEL_HISTORY_UNIT) uniform sampler3D u_history_tx;
#ifndef EXTINCTION_IN_ALPHA
layout(binding = FROXEL_HISTORY_EXTINCTION_UNIT) uniform sampler3D u_history_extinction_tx;
#endif
#endif

#ifdef GRID_SHADOWS
// Over as far as the grid is deep, or to the light; midpoints, as many as the media's own shadows take.
extinction_t light_depth(int i, vec3 p, LightSample light)
{
    int steps = int(u_frame.shadow_steps);
    float ds = min(light.range, u_froxels.slices.depth) / float(steps);
    extinction_t sum = extinction_t(0.0);
    for (int j = 0; j < steps; ++j) {
        vec3 uvw = froxel_uvw(p + light.wi * ((float(j) + 0.5) * ds), u_froxels.clip_from_world,
                              u_froxels.view_z_from_world, u_froxels.slices);
        if (!is_inside(uvw))
            continue;
#ifdef EXTINCTION_IN_ALPHA
        sum += extinction_t(textureLod(u_sigma_s_tx, uvw, 0.0).a);
#elif defined(COLORED_EXTINCTION)
        sum += textureLod(u_sigma_t_tx, uvw, 0.0).rgb;
#else
        sum += textureLod(u_sigma_t_tx, uvw, 0.0).r;
#endif
    }
    return sum * (ds / u_froxels.slices.depth);
}
#define LIGHT_DEPTH light_depth
#endif
#include "scene/in_scattering.glsl"
#if defined(HISTORY) && !defined(HISTORY_STILL)
#include "scene/turned_to_eye.glsl"
#endif

vec4 extinction_of(ivec3 froxel)
{
#ifdef EXTINCTION_IN_ALPHA
    return vec4(texelFetch(u_sigma_s_tx, froxel, 0).a);
#else
    return texelFetch(u_sigma_t_tx, froxel, 0);
#endif
}

// What a froxel holds of media.
struct Medium {
    vec3 sigma_s, emission;
    float g;
};

Medium medium_of(ivec3 froxel)
{
    Medium medium = Medium(texelFetch(u_sigma_s_tx, froxel, 0).rgb, vec3(0.0), u_media.media[0].g);
#ifdef FOR_EACH_EMISSION
    medium.emission = texelFetch(u_emission_tx, froxel, 0).rgb;
#endif
#ifdef MIXED_G
    vec2 phase = texelFetch(u_phase_tx, froxel, 0).xy;
    medium.g = phase.y > 0.0 ? phase.x / phase.y : 0.0;
#endif
    return medium;
}

vec3 source_of(ivec3 froxel, Medium medium)
{
    if (medium.sigma_s == vec3(0.0))
        return medium.emission;
    FroxelSample at = froxel_sample(froxel);
    return medium.emission + medium.sigma_s * in_scattering_at(at.p, at.wo, medium.g);
}

#ifdef HISTORY
// Moves source and extinction towards last frame's, where last frame's grid holds this froxel's middle.
void add_history(ivec3 froxel, Medium medium, inout vec3 source, inout vec4 extinction)
{
    float weight = u_froxels.history_weight;
#ifdef HISTORY_STILL
    vec4 old_source = texelFetch(u_history_tx, froxel, 0);
#ifndef EXTINCTION_IN_ALPHA
    vec4 old_extinction = texelFetch(u_history_extinction_tx, froxel, 0);
#endif
#else
    Ray ray = column_ray(froxel.xy, vec2(0.5));
    float s = (float(froxel.z) + 0.5) / u_froxels.slices.count;
    vec3 middle = ray.origin + ray.direction * slice_view_z(s, u_froxels.slices);
    vec3 uvw = froxel_uvw(middle, u_froxels.history_clip_from_world, u_froxels.history_view_z_from_world,
                          u_froxels.history_slices);
    if (!is_inside(uvw))
        return;
    vec4 old_source = textureLod(u_history_tx, uvw, 0.0) * u_froxels.history_slices.rescale;
    old_source.rgb *= turned_to_eye(middle, -normalize(ray.direction), u_froxels.history_eye, medium.sigma_s,
                                    medium.emission, medium.g);
#ifndef EXTINCTION_IN_ALPHA
    vec4 old_extinction = textureLod(u_history_extinction_tx, uvw, 0.0) * u_froxels.history_slices.rescale;
#endif
#endif
    source = mix(source, old_source.rgb, weight);
#ifdef EXTINCTION_IN_ALPHA
    extinction = mix(extinction, old_source.aaaa, weight);
#else
    extinction = mix(extinction, old_extinction, weight);
#endif
}
#endif

void main()
{
    ivec3 froxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(froxel, froxel_count())))
        return;
    vec4 extinction = extinction_of(froxel);
    Medium medium = medium_of(froxel);
    vec3 source = source_of(froxel, medium);
#ifdef COUNT_SAMPLES
    if (froxel_sample(froxel).share > 0.0)
        ++g_samples;  // the V-buffer's own
    imageStore(u_source_img, froxel, vec4(float(g_samples)));
#else
#ifdef HISTORY
    add_history(froxel, medium, source, extinction);
#endif
#ifdef EXTINCTION_IN_ALPHA
    imageStore(u_source_img, froxel, vec4(source, extinction.a));
#else
    imageStore(u_source_img, froxel, vec4(source, 0.0));
    imageStore(u_extinction_img, froxel, extinction);
#endif
#endif
}
