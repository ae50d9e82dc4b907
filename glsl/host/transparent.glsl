// A host's own fragments, into the lists of their pixels: for its fragment shaders, drawn between
// Renderer::begin_transparents() and end_transparents().
//   in   the host's depth, which hides them
//   out  the lists
#include "shared/bindings.h"
#include "shared/host_transparent_params.h"

layout(std140, binding = TRANSPARENT_BLOCK) uniform TransparentBlock { HostTransparentParams u_transparent; };
#include "lib/depth.glsl"
#include "scene/fragment_lists.glsl"

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;

// What a blend's two factors, BLEND_* of OpenGL's, are together.
uint blend_factors(uint of_source, uint of_behind) { return of_source << 4u | of_behind; }

// view_z [m] of the fragment that is drawn.
float transparent_view_z()
{
    if (u_transparent.view_z_per_w != 0.0)
        return u_transparent.view_z_per_w / gl_FragCoord.w + u_transparent.view_z_at_w;
    return view_z_of(gl_FragCoord.z, u_transparent.view_z_from_depth, -1.0);
}

// color: radiance [W/m^2/sr], or what a filter lets through, and alpha. blend: BLEND_ALPHA, BLEND_PREMULTIPLIED,
// BLEND_ADD, BLEND_MULTIPLY, or blend_factors(). draw: of two fragments at one depth that of the larger is in front, and
// within a draw that of the later triangle.
void transparent(vec4 color, uint blend, uint draw, float view_z)
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float scene_z =
        view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_transparent.view_z_from_depth, u_transparent.sky_depth);
    if (!(view_z < scene_z))
        return;
    uint key = min(u_transparent.first_draw + draw, uint(kMostDraws) - 1u) << 20u | blend;
    add_fragment(pixel, Fragment(view_z, fragment_key_of_triangle(key, uint(gl_PrimitiveID)),
                                 min(color, vec4(u_transparent.radiance_limit))));
}

void transparent(vec4 color, uint blend, uint draw) { transparent(color, blend, draw, transparent_view_z()); }
void transparent(vec4 color, uint blend) { transparent(color, blend, 0u); }
