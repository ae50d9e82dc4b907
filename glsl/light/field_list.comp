// Lists the nodes that have a medium in their cells or stand beside one that has: light that is scattered elsewhere goes
// nowhere, and where all eight nodes around a place are others, no medium looks light up. kHole: and those around the
// box whose light is told elsewhere, as it takes theirs.
//   in   sigma_t [1/m]; a list with nothing in it
//   out  the list, and the size of the dispatch over it
#include "light/field.glsl"

const bool kHole = false;  // variant: there is such a box

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(std430, binding = FIELD_NODES_BUFFER) buffer Nodes
{
    FieldNodesHead u_list;
    uint u_listed_nodes[];
};

// Of this group's nodes, so that the list's own counters are asked once a group.
shared uint s_nodes;
shared uint s_first;

bool stands_beside_medium(ivec3 node)
{
    bool stands = false;
    for (int k = 0; k < 27; ++k) {
        ivec3 beside = clamp(node + ivec3(k % 3, k / 3 % 3, k / 9) - 1, ivec3(0), node_count() - 1);
        stands = stands || texelFetch(u_sigma_t_tx, beside, 0).rgb != vec3(0.0);
    }
    return stands;
}

bool stands_around_hole(ivec3 node)
{
    const float kAround = float(FIELD_FARTHER + 1);
    return all(greaterThan(vec3(node), u_field.hole_low - kAround)) &&
           all(lessThan(vec3(node), u_field.hole_high + kAround));
}

void main()
{
    if (gl_LocalInvocationIndex == 0u)
        s_nodes = 0u;
    barrier();
    ivec3 node = ivec3(gl_GlobalInvocationID);
    bool listed =
        all(lessThan(node, node_count())) && ((kHole && stands_around_hole(node)) || stands_beside_medium(node));
    uint place = 0u;
    if (listed)
        place = atomicAdd(s_nodes, 1u);
    barrier();
    if (gl_LocalInvocationIndex == 0u && s_nodes > 0u) {
        const uint kGroup = uint(FIELD_NODE_GROUP);
        s_first = atomicAdd(u_list.nodes, s_nodes);
        uint groups = (s_first + s_nodes + kGroup - 1u) / kGroup - (s_first + kGroup - 1u) / kGroup;
        if (groups > 0u)
            atomicAdd(u_list.groups_x, groups);
    }
    barrier();
    if (listed)
        u_listed_nodes[s_first + place] = node_word(node);
}
