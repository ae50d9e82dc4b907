// A transparent: positions of its mesh to clip space, with their view depth.
#include "shared/bindings.h"
#include "shared/transparent_params.h"

// Variant
const bool kOver = false;  // over a picture in order: it lies where src/transparent/media_mask.h has what is drawn

layout(std140, binding = TRANSPARENT_BLOCK) uniform Transparent { TransparentParams u_transparent; };
layout(location = 0) in vec3 in_position;  // of a quad or a billboard 0..1, its lower left at 0
out float view_z;                          // metres
out vec2 uv;

void main()
{
    vec4 p = vec4(in_position, 1.0);
    view_z = dot(u_transparent.view_z_from_object, p);
    uv = in_position.xy;
    gl_Position = u_transparent.clip_from_object * p;
    if (kOver)
        gl_Position.z = 0.0;
}
