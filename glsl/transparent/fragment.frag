// A fragment of one of the scene's transparents, into the list of its pixel.
//   in   the host's depth, which hides it; its look
//   out  the lists
#include "lib/depth.glsl"
#include "lib/transparent_source.glsl"
#include "scene/fragment_lists.glsl"
#include "scene/frame.glsl"

// Variant
const bool kImage = false;  // its colour and alpha are a picture's

layout(std140, binding = TRANSPARENT_BLOCK) uniform Transparent { TransparentParams u_transparent; };
layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = TRANSPARENT_IMAGE_UNIT) uniform sampler2D u_image_tx;

in float view_z;
in vec2 uv;

vec4 own_source()
{
    if (!kImage)
        return u_transparent.source;
    return image_source(textureLod(u_image_tx, uv, 0.0), u_transparent.source, u_transparent.is_filter != 0u);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_frame.view_z_from_depth, u_frame.sky_depth);
    if (!(view_z < scene_z))
        return;
    vec4 source = own_source();
    if (u_transparent.inverse_depth_fade > 0.0) {
        float length_per_z = length(camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0).direction);
        float fade = min((scene_z - view_z) * length_per_z * u_transparent.inverse_depth_fade, 1.0);
        source = mix(u_transparent.faded, source, mix(vec4(1.0), vec4(fade), u_transparent.fades));
    }
    uint key = fragment_key_of_triangle(u_transparent.key, uint(gl_PrimitiveID));
    add_fragment(pixel, Fragment(view_z, key, min(source, vec4(u_frame.radiance_limit))));
}
