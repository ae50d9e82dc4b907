// The march's history by fragments: pass/march_history.glsl.
#include "pass/march_history.glsl"

layout(location = 0) out vec4 out_kept;
layout(location = 1) out vec4 out_kept_more;

void main()
{
    KeptTexel texel = gather_history(ivec2(gl_FragCoord.xy));
    out_kept = texel.kept;
    out_kept_more = texel.more;
}
