// What surfaces leave of a fire at the nodes of the surfaces' lattice, by points in it.
//   in   surfaces' walls, with the clearance; light on surfaces, whose alpha tells which nodes lie inside of one
//   out  the part that is seen, times the second: 1 outside of surfaces
#include "light/field_listed.glsl"
#include "light/lattice_ray.glsl"
#include "scene/light_volumes_block.glsl"

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_seen_img;
layout(binding = FIELD_LIGHT_UNIT) uniform sampler3D u_light_tx;

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    float outside = texelFetch(u_light_tx, node, 0).a;
    vec3 p = node_position(u_field.nodes, node);
    float seen = 0.0, sum = 0.0;
    int points = min(int(u_volumes.fire.rays), FIRE_POINTS);  // never unrolled, which would take long to compile
    for (int k = 0; k < points && outside > 0.0; ++k) {
        vec3 way = u_volumes.fire.points[k].xyz - p;
        float metres = max(length(way), 0.5 * u_field.nodes.spacing);
        float weight = 1.0 / (metres * metres);
        vec3 wi = way / max(length(way), 1e-6);
        sum += weight;
        if (first_met(node, off_axes(node_way(u_field.nodes, wi)), length(way)).layer < 0)
            seen += weight;
    }
    imageStore(u_seen_img, node, vec4(outside * seen / max(sum, 1e-30), outside, 0.0, 0.0));
}
