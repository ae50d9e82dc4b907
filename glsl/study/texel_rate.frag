// The rate of fetches by fragments: study/texel_rate.glsl.
#include "study/texel_rate.glsl"

layout(location = 0) out vec4 out_sum;

void main() { out_sum = vec4(sum_of_fetches(ivec2(gl_FragCoord.xy))); }
