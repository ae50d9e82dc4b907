// A surface in depth maps along directions to the sky: each instance is of one map, a tile of the texture. What lies
// nearer to the light than the nodes do is held at the far end (GL_DEPTH_CLAMP).
#include "shared/bindings.h"
#include "shared/draw_params.h"
#include "shared/sky_map_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(std140, binding = SKY_MAPS_BLOCK) uniform SkyMaps { SkyMapParams u_sky; };
layout(location = 0) in vec3 in_position;
out float gl_ClipDistance[4];

void main()
{
    int k = gl_InstanceID;
    SkyMap map = u_sky.maps[k];
    vec4 p = u_draw.world_from_object * vec4(in_position, 1.0);
    vec3 at = vec3(dot(map.across, p), dot(map.up, p), dot(map.toward, p));
    gl_ClipDistance[0] = at.x;
    gl_ClipDistance[1] = 1.0 - at.x;
    gl_ClipDistance[2] = at.y;
    gl_ClipDistance[3] = 1.0 - at.y;
    vec2 tile = vec2(k % SKY_MAPS_A_ROW, k / SKY_MAPS_A_ROW);
    gl_Position = vec4(2.0 * (tile + at.xy) / float(SKY_MAPS_A_ROW) - 1.0, 2.0 * at.z - 1.0, 1.0);
}
