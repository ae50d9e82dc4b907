// What light/field_taken.comp tells of a node: of each pair of opposite near ways by how much it counts more than its
// solid angle has it, times that as a part of the sphere; and of light in the node's own cell, by how much that is more
// than what all that stands for the node takes in.
#include "light/field.glsl"

layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_taken_tx;  // which is of that

float taken_number(float of_all, ivec3 node, int i)
{
    return texelFetch(u_taken_tx, node + layer_of(i >> 2), 0)[i & 3];
}
vec3 taken_number(vec3 of_each, ivec3 node, int i) { return texelFetch(u_taken_tx, node + layer_of(i), 0).rgb; }

extinction_t taken_more(ivec3 node, int k) { return taken_number(extinction_t(0.0), node, k >> 1); }
extinction_t taken_of_cell(ivec3 node) { return taken_number(extinction_t(0.0), node, FIELD_TAKEN_OF_CELL); }
