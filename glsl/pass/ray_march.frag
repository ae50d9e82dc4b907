// The ray march by fragments, a texel each: pass/ray_march.glsl.
#include "pass/ray_march.glsl"

flat in uvec4 tile;  // pass/tiles.vert
layout(location = 0) out vec4 out_scattering;
layout(location = 1) out vec4 out_transmittance;

void main()
{
    Marched marched = march_texel(ivec2(gl_FragCoord.xy), tile);
    out_scattering = marched.scattering;
    out_transmittance = marched.transmittance;
}
