// A surface of the scene: positions and normals of its mesh to eye-centred world and to clip space.
#include "shared/bindings.h"
#include "shared/draw_params.h"

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
invariant gl_Position;  // drawn by two programs, one of which skips what the other has drawn
out vec3 p_world;
out vec3 normal;  // scaled evenly or along its axes alone, so it needs no other matrix

// Variant. THROUGH_MEDIA: media dim the first sun, if there is one, whose depths may be in a volume.
#ifdef THROUGH_MEDIA
#include "scene/light_volumes_block.glsl"
#define SUN_VARYING out
#include "scene/sun_varying.glsl"
void find_sun()
{
    SunLookup sun = u_volumes.suns[0];
    way_column = sun.column_from_world * vec4(p_world, 1.0);
    way_enters = way_column.xyz * sun.per_period + sun.enters;
    way_across = sun.across;
    way_towards = sun.towards;
    way_first = sun.first;
    way_period = u_volumes.period_size;
    way_color = u_volumes.extinction_color;
}
#else
void find_sun() {}
#endif

void main()
{
    p_world = (u_draw.world_from_object * vec4(in_position, 1.0)).xyz;
    normal = in_normal;
    find_sun();
    gl_Position = u_draw.clip_from_object * vec4(in_position, 1.0);
}
