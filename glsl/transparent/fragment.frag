// A fragment of one of the scene's transparents, into the list of its pixel.
//   in   scene/transparent_fragment.glsl
//   out  the lists
#include "scene/fragment_lists.glsl"
#include "scene/transparent_fragment.glsl"

void main()
{
    float scene_z = scene_view_z();
    if (!(view_z < scene_z))
        return;
    uint key = fragment_key_of_triangle(u_transparent.key, uint(gl_PrimitiveID));
    add_fragment(ivec2(gl_FragCoord.xy), Fragment(view_z, key, transparent_source(scene_z)));
}
