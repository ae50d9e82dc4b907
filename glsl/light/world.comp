// The world's light as it reaches each node of a lattice: radiance from every direction, dimmed by the media
// and hidden by surfaces, as spherical harmonics.
//   in   directions with their share of the world, one view of the surfaces along each, the extinction's
//        volume
//   out  coefficients [W/m^2/sr], one a layer; alpha of the first: 1 if any light gets there
//
#include "lib/spherical_harmonics.glsl"
#include "scene/light_volumes.glsl"
#include "light/trace.glsl"

// Variant
const int kBands = 1;              // to 4: no more than the media's g can tell apart
const bool kWorldShadows = false;  // there are surfaces
const bool kClear = false;         // the media don't dim it
const bool kMarched = false;       // there is an extinction's volume

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(std140, binding = WORLD_BLOCK) uniform World { WorldParams u_world; };
layout(binding = 0) writeonly uniform image3D u_world_img;
layout(binding = SHADOW_MAP_UNIT) uniform sampler2DArrayShadow u_world_shadow_tx;

float visibility_of(int k, vec3 p)
{
    if (!kWorldShadows)
        return 1.0;
    ShadowView view = u_world.views[k];
    vec2 uv = (view.clip_from_world * vec4(p, 1.0)).xy * 0.5 + 0.5;
    // Moved on by the bias: a node on a surface's far side must not see through it.
    float depth = shadow_depth(view.depth, p + view.depth.travel * view.depth.bias);
    return texture(u_world_shadow_tx, vec4(uv, float(k), depth));
}

void main()
{
    const float kStep = 2.0;  // nodes of the extinction's volume: steps of 64 directions average out
    const int kCount = kHarmonics[kBands - 1];
    ivec3 node = ivec3(gl_GlobalInvocationID);
    LatticeParams lattice = u_volumes.world;
    if (any(greaterThan(node, ivec3(lattice.last))))
        return;
    vec3 p = node_position(lattice, node);
    vec3 radiance[kCount];
    for (int i = 0; i < kCount; ++i)
        radiance[i] = vec3(0.0);
    float seen = 0.0;
    int directions = u_volumes.directions;
    for (int k = 0; k < directions; ++k) {
        float visibility = visibility_of(k, p);
        if (visibility == 0.0)
            continue;
        seen = 1.0;
        vec3 wi = u_world.directions[k].wi.xyz;
        vec3 arriving = u_world.directions[k].power.rgb * visibility;
        if (!kClear)
            arriving *= exp(-closed_depth(p, wi, kSunRange));
        if (!kClear && kMarched)
            arriving *= exp(-from_volume(traced_depth(p, wi, kSunRange, kStep)));
        for (int i = 0; i < kCount; ++i)
            radiance[i] += arriving * spherical_harmonic(i, wi);
    }
    for (int i = 0; i < kCount; ++i)
        imageStore(u_world_img, node + ivec3(0, 0, i * (int(lattice.last.z) + 1)),
                   vec4(radiance[i], i == 0 ? seen : 0.0));
}
