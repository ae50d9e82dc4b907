// An inspection: extinction, the mean of its channels [1/m], on a plane across the media's bounds, as far as it
// lies before the scene.
//   in   the host's depth, the scene's media
#include "lib/channels.glsl"
#include "lib/depth.glsl"
#include "lib/false_color.glsl"
#include "scene/inspect.glsl"
#include "scene/media.glsl"

layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(location = 0) out float out_value;

bool is_inside(vec3 p)
{
    // On the plane rounding must not decide.
    vec3 across = 1.0 - u_inspect.plane_axis;
    return all(greaterThanEqual((p - u_inspect.bounds_min) * across, vec3(0.0))) &&
           all(lessThanEqual((p - u_inspect.bounds_max) * across, vec3(0.0)));
}

void main()
{
    Ray ray = camera_ray(gl_FragCoord.xy * u_frame.inverse_full_size * 2.0 - 1.0);
    float scene_z = view_z_of(texelFetch(u_scene_depth_tx, ivec2(gl_FragCoord.xy), 0).r, u_frame.view_z_from_depth,
                              u_frame.sky_depth);
    float steepness = dot(ray.direction, u_inspect.plane_axis);
    float z = (u_inspect.plane_place - dot(ray.origin, u_inspect.plane_axis)) / steepness;
    vec3 p = ray.origin + ray.direction * z;
    // A ray along the plane has no z: its comparisons are false.
    if (!(z >= u_frame.media_range.x && z <= scene_z) || !is_inside(p)) {
        out_value = kNothing;
        return;
    }
    out_value = mean(sample_media(p).sigma_t);
}
