// What transparents that cast let through of a light: a map of each light's views, in layers. Of each texel a layer has
// one of the transparents, from the nearest on, and the last one all that are left: what they let through, and the
// depth from which on they do. After Dachsbacher and Stamminger 2003, "Translucent Shadow Maps", which keep depth and
// irradiance of a light's view; here layers take the place of a filter behind the surface.
#include "lib/shadow.glsl"
#include "shared/bindings.h"
#include "shared/light_filter_params.h"

const int kFilterLayers = 1;  // variant: of a view
const bool kLightFilters = true;

layout(std140, binding = LIGHT_FILTERS_BLOCK) uniform LightFilters { LightFiltersParams u_filters; };
layout(binding = LIGHT_FILTERS_UNIT) uniform sampler2DArray u_filters_tx;

vec3 filter_of_texel(ivec2 texel, int layer, float depth)
{
    vec3 passed = vec3(1.0);
    for (int k = 0; k < kFilterLayers; ++k) {
        vec4 own = texelFetch(u_filters_tx, ivec3(texel, layer + k), 0);
        passed *= own.a < depth ? own.rgb : vec3(1.0);
    }
    return passed;
}

// uv, 0..1, and depth in a view, whose rim is clear of transparents. Depths are compared before four texels are mixed,
// as in the shadow map. In a medium the nearest texel is enough: a ray sums up many, and four take four times as long.
vec3 filter_in(int layer, vec2 uv, float depth, bool mixes)
{
    ivec2 last = textureSize(u_filters_tx, 0).xy - 1;
    vec2 at = uv * vec2(last + 1) - 0.5;
    if (!mixes)
        return filter_of_texel(clamp(ivec2(floor(at + 0.5)), ivec2(0), last), layer, depth);
    vec2 low = floor(at), f = at - low;
    ivec2 a = clamp(ivec2(low), ivec2(0), last), b = clamp(ivec2(low) + 1, ivec2(0), last);
    return mix(mix(filter_of_texel(a, layer, depth), filter_of_texel(ivec2(b.x, a.y), layer, depth), f.x),
               mix(filter_of_texel(ivec2(a.x, b.y), layer, depth), filter_of_texel(b, layer, depth), f.x), f.y);
}

// Of light i at p. It is no surface, and needs no bias.
vec3 looked_up_filter(int i, vec3 p, bool mixes)
{
    LightFilterParams own = u_filters.points[i];
    float depth = shadow_depth(own.depth, p);
    int layer = int(own.first_layer);
    if (i < kSunCount || (i >= kSunCount + kPointCount && i < kSunCount + kPlacedCount)) {
        vec4 clip = own.clip_from_world * vec4(p, 1.0);
        return filter_in(layer, clip.xy / clip.w * 0.5 + 0.5, depth, mixes);
    }
    int face;
    vec2 on_face = on_cube_face(p - own.depth.origin, face);
    return filter_in(layer + face * kFilterLayers, on_face * own.cube_view_scale + 0.5, depth, mixes);
}

vec3 filter_on_surface(int i, vec3 p) { return looked_up_filter(i, p, true); }
vec3 filter_in_medium(int i, vec3 p) { return looked_up_filter(i, p, false); }
