// How much of the part of the sky that a way stands for surfaces leave free, as each node sees it: of the directions
// amid that part, those along which no surface is met.
//   in   depth maps along directions amid it, tiles of one texture: the surface that is nearest to the light
//   out  parts of SKY_SHARES, or SKY_UNKNOWN, in the ways' layout
#include "light/field.glsl"
#include "shared/sky_map_params.h"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(std140, binding = SKY_MAPS_BLOCK) uniform SkyMaps { SkyMapParams u_sky; };
layout(binding = FACE_LIGHT_UNIT) uniform sampler2D u_maps_tx;  // no face is lit yet
layout(r8ui, binding = 0) writeonly uniform uimage3D u_shares_img;

// 1 where nothing lies between p and the light.
float seen_of_map(int i, vec3 p)
{
    SkyMap map = u_sky.maps[i];
    vec3 at = vec3(dot(map.across.xyz, p), dot(map.up.xyz, p), dot(map.toward.xyz, p)) +
              vec3(map.across.w, map.up.w, map.toward.w);
    ivec2 texel = clamp(ivec2(at.xy * float(u_sky.texels)), ivec2(0), ivec2(u_sky.texels - 1));
    texel += u_sky.texels * ivec2(i % SKY_MAPS_A_ROW, i / SKY_MAPS_A_ROW);
    return texelFetch(u_maps_tx, texel, 0).r > at.z ? 0.0 : 1.0;
}

// llvmpipe gathers a uniform whose index is a loop's, for each lane and number; of a literal index it loads it once.
#define FOUR(i) (seen_of_map(i, p) + seen_of_map(i + 1, p) + seen_of_map(i + 2, p) + seen_of_map(i + 3, p))

void main()
{
    ivec3 node = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(node, node_count())))
        return;
    uint share = uint(SKY_UNKNOWN);
    if (all(greaterThanEqual(vec3(node), u_sky.low)) && all(lessThanEqual(vec3(node), u_sky.high))) {
        vec3 p = node_position(u_field.nodes, node);
        float seen = FOUR(0) + FOUR(4) + FOUR(8) + FOUR(12);
        share = uint(seen / float(SKY_MAPS) * float(SKY_SHARES) + 0.5);
    }
    imageStore(u_shares_img, node + way_of(u_sky.way), uvec4(share));
}
