// Froxels, step 1b, once the scene of a view has changed: what this frame's froxels scatter, and what is kept of
// the frames before. scatter.comp's mean takes both for pictures of one scene.
//   in   this frame's source and extinction; last frame's, and its counts
//   out  source, extinction  as scatter.comp's
//        counts              x: frames that the source is worth, y: that the extinction is
// What light does and where media are is kept apart: source = source function * extinction. Jitter finds another
// extinction in each frame, by far the most of the noise, and the same source function but for shadows. So after
// a light has changed the extinction's mean stays, and the source function is learned anew: a mean weighted by
// each frame's extinction, which is the plain mean of sources where both are worth as many frames.
#include "lib/channels.glsl"
#include "scene/v_buffer.glsl"
#include "scene/in_scattering.glsl"
#include "scene/froxel_history.glsl"

// Variant
const bool kCounted = false;  // last frame has counts; else both are worth the frames that the weight of history says
const bool kLightChanged = false;  // the scene is not last frame's;
const bool kMediaChanged = false;  // its extinction is not either

layout(local_size_x = FROXEL_GROUP_X, local_size_y = FROXEL_GROUP_Y, local_size_z = FROXEL_GROUP_Z) in;
layout(binding = FROXEL_COUNTS_IMAGE) writeonly uniform image3D u_counts_img;
layout(binding = FROXEL_SOURCE_UNIT) uniform sampler3D u_frame_source_tx;
layout(binding = FROXEL_EXTINCTION_UNIT) uniform sampler3D u_frame_extinction_tx;
layout(binding = FROXEL_COUNTS_UNIT) uniform sampler3D u_counts_tx;

extinction_t light_depth(int i, vec3 p, LightSample light) { return extinction_t(0.0); }

// Of this frame alone.
LitFroxel frame_of(ivec3 froxel)
{
    vec4 source = texelFetch(u_frame_source_tx, froxel, 0);
    vec4 apart = vec4(0.0);
    if (!has_one_extinction())
        apart = texelFetch(u_frame_extinction_tx, froxel, 0);
    return LitFroxel(source.rgb, extinction_of_kept(source, apart));
}

// Source and extinction of a froxel, and how many frames each is worth.
struct Kept {
    vec3 source, extinction;
    vec2 frames;
};

// Frames that what was gathered before a change is worth behind it, at most.
const float kMostSource = 1.0, kMostExtinction = 3.0;
const float kLeastSource = 0.25;  // of the neighborhood's source function: where a froxel's own sample met nothing
// Of the frame of a change: its light, looked up in the froxels' middles, has no noise of jitter.
const float kMiddleSource = 3.0;

// How little `now` differs from `before`, of any channel that counts: 1 alike, 0 not at all. kept, none: natural
// logarithms of a change up to which all counts as alike, and from which on nothing does.
float likeness(vec3 now, vec3 before, float kept, float none)
{
    float dim = 1e-2 * max(max(max(now.r, before.r), max(now.g, before.g)), max(max(now.b, before.b), 1e-30));
    vec3 change = abs(log((now + dim) / (before + dim)));
    return 1.0 - smoothstep(kept, none, most(change));
}

// Clips what is kept to this frame's neighborhood of 3 x 3 x 3 froxels, and has it be worth the fewer frames the
// less it looks like it. The source function is brought to the neighborhood's mean.
void adapt(ivec3 froxel, HistoryPlace place, vec3 turn, inout Kept kept)
{
    vec3 now_source = vec3(0.0), now_extinction = vec3(0.0), source = vec3(0.0), extinction = vec3(0.0);
    vec3 least = vec3(1e38), most = vec3(0.0);
    ivec3 last = froxel_count() - 1;
    for (int i = 0; i < 27; ++i) {
        ivec3 offset = ivec3(i % 3, i / 3 % 3, i / 9) - 1;
        float weight = 1.0 / float(1 << (abs(offset.x) + abs(offset.y) + abs(offset.z)));
        ivec3 at = clamp(froxel + offset, ivec3(0), last);
        LitFroxel frame = frame_of(at);
        now_source += weight * frame.source;
        now_extinction += weight * frame.extinction;
        least = min(least, frame.extinction);
        most = max(most, frame.extinction);
        LitFroxel old = history_at(place.uvw + vec3(offset) / vec3(last + 1));
        source += weight * old.source * turn;
        extinction += weight * old.extinction;
    }
    const float kMost = 4.0;
    if (kMediaChanged) {
        vec3 old_extinction = kept.extinction;
        kept.extinction = clamp(kept.extinction, least, most);
        kept.source *= kept.extinction / max(old_extinction, 1e-30);
        kept.frames.y = min(kept.frames.y, kMostExtinction) * likeness(now_extinction, extinction, 0.3, 1.2);
    }
    // Where nothing dims, as in a flame without smoke, the source stands for itself.
    bvec3 dims = greaterThan(now_extinction + extinction, vec3(0.0));
    vec3 per = mix(vec3(1.0), kept.extinction, dims);
    vec3 now = now_source / mix(vec3(8.0), max(now_extinction, 1e-30), dims);
    vec3 before = source / mix(vec3(8.0), max(extinction, 1e-30), dims);
    vec3 own = kept.source / max(per, 1e-30);
    float alike = likeness(now, before, 0.1, 0.5);
    vec3 function = mix(now, own * clamp(now / max(before, 1e-30), 1.0 / kMost, kMost), alike);
    bvec3 met = bvec3(now_extinction * vec3(dims) + vec3(not(dims)));
    kept.source = mix(own, function, met) * per;
    kept.frames.x = max(min(kept.frames.x, kMostSource) * alike, kLeastSource);
}

// The mean of what is kept and this frame.
Kept mean_of(Kept kept, vec3 source, vec3 sigma_t)
{
    Kept mean;
    mean.extinction = (kept.frames.y * kept.extinction + sigma_t) / (kept.frames.y + 1.0);
    vec3 amount = kept.frames.x * kept.extinction + sigma_t;
    bvec3 dims = greaterThan(amount, vec3(0.0));
    vec3 share = mix(vec3(1.0 / (kept.frames.x + 1.0)), mean.extinction / max(amount, 1e-30), dims);
    mean.source = (kept.frames.x * kept.source + source) * share;
    vec3 frames = mix(vec3(kept.frames.x + 1.0), amount / max(mean.extinction, 1e-30), dims);
    mean.frames = vec2((frames.r + frames.g + frames.b) / 3.0, kept.frames.y + 1.0);
    return mean;
}

void main()
{
    const float kMostCounted = 1024.0;  // 16 bits count no further
    ivec3 froxel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(froxel, froxel_count())))
        return;
    LitFroxel frame = frame_of(froxel);
    Kept mean = Kept(frame.source, frame.extinction, vec2(1.0));
    HistoryPlace place = history_place(froxel);
    if (is_inside(place.uvw)) {
        vec3 turn = history_turn(place, medium_of(froxel));
        float weight = u_froxels.history_weight;
        LitFroxel old = history_at(place.uvw);
        Kept kept = Kept(old.source * turn, old.extinction, vec2(weight / max(1.0 - weight, 1e-6)));
        if (kCounted)
            kept.frames = min(kept.frames, textureLod(u_counts_tx, place.uvw, 0.0).xy);
        if (kLightChanged)
            adapt(froxel, place, turn, kept);
        mean = mean_of(kept, frame.source, frame.extinction);
        if (kLightChanged)
            mean.frames.x = max(mean.frames.x, kMiddleSource);
    }
    imageStore(u_counts_img, froxel, vec4(min(mean.frames, kMostCounted), 0.0, 0.0));
    keep(froxel, mean.source, mean.extinction);
}
