// OpenGL's blending of one colour over another: a factor of what is behind, or of the source.
#include "shared/transparent_params.h"

// A factor of the source's own color and alpha.
//   weights  of a constant, of the color and of the alpha
vec3 own_factor(vec3 weights, vec4 source) { return weights.x + weights.y * source.rgb + weights.z * source.a; }

vec4 blend_factor(uint factor, vec4 source, vec4 behind)
{
    switch (factor) {
    case BLEND_ZERO:
        return vec4(0.0);
    case BLEND_ONE:
        return vec4(1.0);
    case BLEND_SRC_COLOR:
        return source;
    case BLEND_ONE_MINUS_SRC_COLOR:
        return 1.0 - source;
    case BLEND_DST_COLOR:
        return behind;
    case BLEND_ONE_MINUS_DST_COLOR:
        return 1.0 - behind;
    case BLEND_SRC_ALPHA:
        return vec4(source.a);
    case BLEND_ONE_MINUS_SRC_ALPHA:
        return vec4(1.0 - source.a);
    case BLEND_DST_ALPHA:
        return vec4(behind.a);
    case BLEND_ONE_MINUS_DST_ALPHA:
        return vec4(1.0 - behind.a);
    }
    return vec4(vec3(min(source.a, 1.0 - behind.a)), 1.0);  // saturate
}
