// What the steps that fill the field of light have in common.
#include "shared/bindings.h"
#include "shared/field_params.h"
#include "lib/lattice.glsl"

layout(std140, binding = FIELD_BLOCK) uniform Field { FieldParams u_field; };

// A place from its coordinate along an axis and those along the next two, and back.
vec3 from_axes(int axis, float along, vec2 across)
{
    vec3 q = vec3(along, across);
    return axis == 0 ? q.xyz : axis == 1 ? q.zxy : q.yzx;
}

vec3 to_axes(int axis, vec3 q) { return axis == 0 ? q.xyz : axis == 1 ? q.yzx : q.zxy; }
