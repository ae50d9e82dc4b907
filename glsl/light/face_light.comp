// What the surfaces at a lattice's nodes send on, of lights, of the world and of what reached them before: as if they
// were Lambertian.
//   in   the faces along the lattice's axes, what they are made of and what they emit, and light on surfaces
//   out  radiance [W/m^2/sr], a face's nodes after each other
#include "light/field.glsl"
#include "light/faces.glsl"
#include "light/dimmed_lights.glsl"
#define OWN_THROUGH_MEDIA
#include "scene/irradiance.glsl"

const bool kEmits = false;  // variant: some surface emits

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(rgba16f, binding = 0) writeonly uniform image3D u_face_light_img;
layout(binding = FACES_UNIT) uniform usampler3D u_faces_tx;
layout(binding = FACE_LIGHT_UNIT) uniform sampler3D u_face_emission_tx;  // no face is lit yet
layout(binding = FACE_MATERIALS_UNIT) uniform sampler2D u_materials_tx;  // rows: albedo, emission

void main()
{
    ivec3 id = ivec3(gl_GlobalInvocationID);
    int nodes_z = node_count().z;
    int layer = id.z / nodes_z;
    ivec3 node = ivec3(id.xy, id.z - layer * nodes_z);
    if (any(greaterThanEqual(node, node_count())) || layer >= 6)
        return;
    uint word = texelFetch(u_faces_tx, id, 0).r;
    if (word == kNoFace)
        return;
    Face face = unpack_face(word);
    vec3 radiance = vec3(0.0);
    if (face.surface != kNoSurface) {
        vec3 q = vec3(node);
        q[layer >> 1] += (layer & 1) != 0 ? face.before : -face.before;
        vec3 p = (u_field.nodes.world_from_node * vec4(q, 1.0)).xyz;
        vec3 albedo = texelFetch(u_materials_tx, ivec2(face.surface, 0), 0).rgb;
        vec3 emission = kEmits ? texelFetch(u_face_emission_tx, id, 0).rgb : vec3(0.0);
        radiance = emission + albedo / kPi * irradiance_at(p, face.normal);
    }
    imageStore(u_face_light_img, id, vec4(radiance, 1.0));
}
