// Nodes of a lattice as a dispatch over them finds them: ahead of the words of each, in the same
// buffer.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

#define FIELD_NODE_GROUP 64  // nodes that a work group takes: VOLUME_GROUP^3

struct FieldNodesHead {
    uint groups_x, groups_y, groups_z;  // of the dispatch
    uint nodes;
};

// A node's place, in 10 bits each way: a lattice's edges are shorter by far.
FUM_SHARED_FUNCTION uint node_word(ivec3 node)
{
    return uint(node.x) | uint(node.y) << 10u | uint(node.z) << 20u;
}
FUM_SHARED_FUNCTION ivec3 node_of_word(uint word)
{
    return ivec3(int(word & 0x3ffu), int(word >> 10u & 0x3ffu), int(word >> 20u));
}

FUM_SHARED_END
