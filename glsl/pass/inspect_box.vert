// The edges of boxes as lines, two vertices each, a box an instance.
//   in   min, max  corners, in the space of the boxes
//        value     that the box is coloured by; less than 0: an outline
#include "lib/false_color.glsl"
#include "scene/inspect.glsl"

layout(location = 0) in vec4 in_min;  // w: value
layout(location = 1) in vec4 in_max;
flat out vec3 color;

void main()
{
    const vec3 kOutline = vec3(0.6);
    // Four edges along each axis: which of the four, and which end.
    int axis = gl_VertexID / 8;
    int edge = gl_VertexID / 2 % 4;
    vec3 side;
    side[axis] = float(gl_VertexID % 2);
    side[(axis + 1) % 3] = float(edge % 2);
    side[(axis + 2) % 3] = float(edge / 2);
    gl_Position = u_inspect.clip_from_boxes * vec4(mix(in_min.xyz, in_max.xyz, side), 1.0);
    color = in_min.w < 0.0 ? kOutline : magma((in_min.w - u_inspect.scale_begin) * u_inspect.inverse_scale_width);
}
