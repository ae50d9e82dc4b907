// What the surfaces at a lattice's nodes emit: a face stands for as much of a surface as lies between the middles of its
// neighbours, and where one that shines ends amid that it shines by its part.
//   in   the faces of finer lines
//   out  mean of the parts that can be seen [W/m^2/sr], a face's nodes after each other
#include "light/field.glsl"
#include "light/faces.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba16f, binding = 0) writeonly uniform image3D u_face_emission_img;
layout(binding = FACES_UNIT) uniform usampler3D u_faces_tx;
layout(binding = FACE_MATERIALS_UNIT) uniform sampler2D u_materials_tx;  // rows: albedo, emission

void main()
{
    ivec3 id = ivec3(gl_GlobalInvocationID);
    ivec3 count = node_count();
    if (any(greaterThanEqual(id, ivec3(count.xy, 6 * count.z))))
        return;
    vec3 emission = vec3(0.0);
    float parts = 0.0;
    for (int i = 0; i < FACE_PARTS * FACE_PARTS; ++i) {
        uint word = texelFetch(u_faces_tx, id + ivec3(i * count.x, 0, 0), 0).r;
        int surface = int(word & 0xfffu);
        if (word == kNoFace || surface == kNoSurface)
            continue;
        emission += texelFetch(u_materials_tx, ivec2(surface, 1), 0).rgb;
        parts += 1.0;
    }
    imageStore(u_face_emission_img, id, vec4(emission / max(parts, 1.0), 0.0));
}
