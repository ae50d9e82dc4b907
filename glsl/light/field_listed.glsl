// The node that an invocation is about: one of all, or of those that are listed (light/field_list.comp).
#include "light/field.glsl"

const bool kListed = false;  // variant

layout(std430, binding = FIELD_NODES_BUFFER) readonly buffer Nodes
{
    FieldNodesHead u_list;
    uint u_listed_nodes[];
};

// None: beyond the lattice.
ivec3 own_node()
{
    if (!kListed)
        return ivec3(gl_GlobalInvocationID);
    uint place = gl_WorkGroupID.x * uint(FIELD_NODE_GROUP) + gl_LocalInvocationIndex;
    return place < u_list.nodes ? node_of_word(u_listed_nodes[place]) : node_count();
}
