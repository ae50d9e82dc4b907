// What fills a probe's maps: a thread a texel, the border's too, which repeat what lies across the edge.
#include "lib/octahedral.glsl"
#include "shared/probe_params.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = PROBE_FILTER_BLOCK) uniform ProbeFilter { ProbeFilterParams u_filter; };
layout(rgba32f, binding = 0) writeonly uniform image2DArray u_maps_img;

bool is_in_map() { return all(lessThan(ivec2(gl_GlobalInvocationID.xy), ivec2(u_filter.to.size + 2))); }
ivec2 texel_in_border() { return ivec2(gl_GlobalInvocationID.xy) - 1; }
ivec2 texel_of_map() { return octahedral_wrap(texel_in_border(), u_filter.to.size); }

void store(vec4 value)
{
    // A sum about a mean rounds to a little less than none beside what is bright.
    imageStore(u_maps_img, ivec3(u_filter.to.first + texel_in_border(), u_filter.to.layer), max(value, vec4(0.0)));
}
