// Froxels, step 1: the media, one sample a froxel, light into them, and what is kept of the frames before.
//   in   media, or the V-buffer, lights, shadow map; last frame's source and extinction
//   out  source      radiance added per slices.depth metres: sigma_s * in_scattering + emission
//        extinction  of the media, averaged over frames as the source is
// The history is last frame's froxel at the unjittered middle of this one, so samples that are jittered
// from frame to frame average over the froxel. Each froxel is worked out in every frame, seen or hidden by
// a surface: none of them can have been hidden, so a surface that moves away uncovers nothing unknown.
#include "scene/v_buffer.glsl"
#include "scene/in_scattering.glsl"
#include "scene/froxel_history.glsl"

// Variant, besides kCountSamples: write the number of media evaluations of both steps instead
const bool kHistory = false;       // last frame's froxels are there;
const bool kHistoryStill = false;  // they are these, one for one
const bool kMiddleLight = false;   // light is looked up in a froxel's middle: all froxels have one jitter, so a frame
                                   // whose light is to stand for others errs to one side, 10 % in a smoke of a few
                                   // froxels

layout(local_size_x = FROXEL_GROUP_X, local_size_y = FROXEL_GROUP_Y, local_size_z = FROXEL_GROUP_Z) in;

// Over as far as the grid is deep, or to the light; midpoints, as many as the media's own shadows take.
extinction_t grid_depth(vec3 p, LightSample light)
{
    int steps = int(u_frame.shadow_steps);
    float ds = min(light.range, u_froxels.slices.depth) / float(steps);
    extinction_t sum = extinction_t(0.0);
    for (int j = 0; j < steps; ++j) {
        vec3 uvw = froxel_uvw(p + light.wi * ((float(j) + 0.5) * ds), u_froxels.clip_from_world,
                              u_froxels.view_z_from_world, u_froxels.slices);
        if (!is_inside(uvw))
            continue;
        vec3 sigma_t;
        if (has_one_extinction())
            sigma_t = extinction_of_number(textureLod(u_sigma_s_tx, uvw, 0.0).a);
        else
            sigma_t = textureLod(u_sigma_t_tx, uvw, 0.0).rgb;
        sum += extinction_of(vec4(sigma_t, sigma_t.r));
    }
    return sum * (ds / u_froxels.slices.depth);
}

extinction_t light_depth(int i, vec3 p, LightSample light)
{
    return kGridShadows ? u_media.marched_light_dimming * grid_depth(p, light) : dimming_to_light(i, p, light);
}

vec3 source_of(ivec3 froxel, FroxelMedium medium)
{
    if (medium.sigma_s == vec3(0.0))
        return medium.emission;
    FroxelSample at = froxel_sample(froxel, kMiddleLight ? vec3(0.5) : u_froxels.jitter);
    return medium.emission + medium.sigma_s * in_scattering_at(at.p, at.wo, medium.g);
}

// Moves source and extinction towards last frame's, where last frame's grid holds this froxel's middle.
void add_history(ivec3 froxel, FroxelMedium medium, inout vec3 source, inout vec3 extinction)
{
    LitFroxel old;
    if (kHistoryStill) {
        old = history_of(froxel);
    } else {
        HistoryPlace place = history_place(froxel);
        if (!is_inside(place.uvw))
            return;
        old = history_at(place.uvw);
        old.source *= history_turn(place, medium);
    }
    float weight = u_froxels.history_weight;
    source = mix(source, old.source, weight);
    extinction = mix(extinction, old.extinction, weight);
}

void main()
{
    ivec3 froxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(froxel, froxel_count())))
        return;
    FroxelMedium medium = medium_of(froxel);
    vec3 extinction = medium.sigma_t;
    vec3 source = source_of(froxel, medium);
    if (kCountSamples) {
        if (kGridShadows && froxel_sample(froxel).share > 0.0)
            count_sample();  // the V-buffer's own
        imageStore(u_source_img, froxel, vec4(float(g_samples)));
        return;
    }
    if (kHistory)
        add_history(froxel, medium, source, extinction);
    keep(froxel, source, extinction);
}
