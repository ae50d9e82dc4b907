// Lays a pixel's transparent fragments over the picture, which has the media and the surfaces already.
//
// All is kept as the eye sees it: a fragment's light times the transmittance before it, T; what is behind it with
// the light scattered in before it taken off, and put back unblended, S. So for a source s with factors fs and fd
//     seen = seen + T s fs + (seen - S)(fd - 1)
// Nothing is divided by T, which may be 0, and a fragment that changes nothing leaves every bit as it was, wherever
// it lies. The sum is affine in the picture: seen = kept * picture + added, and blending works it out.
//   in   the lists; the host's depth; what the media do before any depth (volume_at)
//   out  what the picture is multiplied with, the second source of blending, and what is added to it
#include "lib/blend.glsl"
#include "lib/depth.glsl"
#include "scene/fragment_order.glsl"
#include "written/volume_at.glsl"

// Variant
const bool kReadsPicture = false;  // a factor depends on what is behind
const bool kTakesPicture = false;  // it did, and the picture has it: nothing else of the pixel is told apart
// Two ways that are wrong, kept as measures: as of one accumulator, whose scattered light the media dim anew before each
// fragment; as of two, each of which is given the source.
const bool kSingle = false;
const bool kDoubled = false;

layout(early_fragment_tests) in;  // what src/transparent/media_mask.h leaves out puts no list in order
layout(binding = SCENE_DEPTH_UNIT) uniform sampler2D u_scene_depth_tx;
layout(binding = PICTURE_UNIT) uniform sampler2D u_picture_tx;
layout(location = 0, index = 0) out vec4 out_added;
layout(location = 0, index = 1) out vec4 out_kept;

struct Seen {
    vec3 kept, added;
    float alpha;  // of what is behind, as OpenGL blends it
};

void blend_split(inout Seen seen, Fragment fragment, VolumeAt at, vec3 picture)
{
    vec4 behind = vec4(0.0);
    if (kReadsPicture)
        behind = vec4(at_depth(seen.kept * picture + seen.added - at.scattering, at.transmittance), seen.alpha);
    vec4 of_source = blend_factor(fragment_source_factor(fragment.key), fragment.source, behind);
    vec4 of_behind = blend_factor(fragment_destination_factor(fragment.key), fragment.source, behind);
    seen.added = seen.added * of_behind.rgb + added_in_volume(at, (fragment.source * of_source).rgb, of_behind.rgb);
    seen.kept *= of_behind.rgb;
    seen.alpha = fragment.source.a * of_source.a + seen.alpha * of_behind.a;
}

// What the two wrong ways have: light of surfaces where it is, and light scattered in as the eye sees it.
struct Accumulators {
    vec3 surfaces, scattered;
    float alpha;
};

void blend_wrong(inout Accumulators sums, Fragment fragment, VolumeAt near, VolumeAt far)
{
    vec3 passed = clamp(at_depth(far.transmittance, near.transmittance), 0.0, 1.0);
    vec3 range = far.scattering - near.scattering;
    sums.surfaces *= passed;
    if (kSingle)
        sums.surfaces += range;
    else
        sums.scattered += range;
    vec4 behind = vec4(sums.surfaces + sums.scattered, sums.alpha);
    vec4 of_source = blend_factor(fragment_source_factor(fragment.key), fragment.source, behind);
    vec4 of_behind = blend_factor(fragment_destination_factor(fragment.key), fragment.source, behind);
    vec4 source = fragment.source * of_source;
    sums.surfaces = source.rgb + sums.surfaces * of_behind.rgb;
    if (kDoubled)
        sums.scattered = source.rgb + sums.scattered * of_behind.rgb;
    sums.alpha = source.a + sums.alpha * of_behind.a;
}

vec3 resolve_wrong(uint number, VolumeRay ray, vec4 picture, float scene_z)
{
    VolumeAt far = volume_at(ray, scene_z);
    Accumulators sums = Accumulators(at_depth(picture.rgb - far.scattering, far.transmittance), vec3(0.0), picture.a);
    if (number != 0u)
        do {
            Fragment fragment = Fragment(fragment_view_z(number), fragment_key_at(number), fragment_source(number));
            VolumeAt near = volume_at(ray, fragment.view_z);
            blend_wrong(sums, fragment, near, far);
            far = near;
            number = next_fragment(number);
        } while (number != 0u);
    return sums.surfaces * far.transmittance + sums.scattered + far.scattering;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (first_fragment(pixel) == 0u)
        discard;
    if (kTakesPicture) {
        out_added = vec4(texelFetch(u_picture_tx, pixel, 0).rgb, 1.0);
        out_kept = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    uint number = sort_fragments(pixel);
    VolumeRay ray = volume_ray(gl_FragCoord.xy);
    vec4 picture = vec4(0.0, 0.0, 0.0, 1.0);
    if (kReadsPicture)
        picture = texelFetch(u_picture_tx, pixel, 0);
    if (kSingle || kDoubled) {
        float scene_z =
            view_z_of(texelFetch(u_scene_depth_tx, pixel, 0).r, u_frame.view_z_from_depth, u_frame.sky_depth);
        out_added = vec4(resolve_wrong(number, ray, picture, scene_z), 1.0);
        out_kept = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    Seen seen = Seen(vec3(1.0), vec3(0.0), picture.a);
    do {
        Fragment fragment = Fragment(fragment_view_z(number), fragment_key_at(number), fragment_source(number));
        blend_split(seen, fragment, volume_at(ray, fragment.view_z), picture.rgb);
        number = next_fragment(number);
    } while (number != 0u);
    out_added = vec4(seen.added, 1.0);
    out_kept = vec4(seen.kept, 1.0);
}
