// A fragment of one of the scene's transparents: what goes into lists, or over a picture.
//   in   the host's depth, which hides it; its look
#include "lib/depth.glsl"
#include "lib/transparent_source.glsl"
#include "scene/frame.glsl"
#include "shared/transparent_params.h"

// Variant
const bool kImage = false;  // its colour and alpha are a picture's
const bool kFades = false;  // before a surface

layout(std140, binding = TRANSPARENT_BLOCK) uniform Transparent { TransparentParams u_transparent; };
layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = TRANSPARENT_IMAGE_UNIT) uniform sampler2D u_image_tx;

#ifndef LOOK  // over a picture they come with the vertices
#define LOOK(member) u_transparent.member
#endif

in float view_z;
in vec2 uv;

// view_z [m] of the surface behind it.
float scene_view_z()
{
    return view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r, u_frame.view_z_from_depth,
                     u_frame.sky_depth);
}

vec4 transparent_source(float scene_z)
{
    vec4 source = LOOK(source);
    if (kImage)
        source = image_source(textureLod(u_image_tx, uv, 0.0), source, u_transparent.is_filter != 0u);
    if (kFades) {
        float length_per_z = length(camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0).direction);
        float fade = min((scene_z - view_z) * length_per_z * LOOK(inverse_depth_fade), 1.0);
        source = mix(LOOK(faded), source, mix(vec4(1.0), vec4(fade), LOOK(fades)));
    }
    return min(source, vec4(u_frame.radiance_limit));
}
