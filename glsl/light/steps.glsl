// From each node to the nearest surface, as light/crossed.frag keeps it: along the lattice's axes, down and up each, the
// diagonals between two of them, and those between all three.
#include "light/field.glsl"

const int kSteps = 26;

// Twice as many parts of a step as it is away; odd: it is seen from within.
uint word_to(ivec3 node, int way) { return texelFetch(u_crossed_tx, node + way_of(way), 0).r; }

// Whether it lies before the next node that way.
bool is_near(uint word) { return word >> 1 <= uint(WALL_STEPS); }

// In steps to the next node that way; 2: there is none before it.
float steps_of(uint word) { return is_near(word) ? float(word >> 1) / float(WALL_STEPS) : 2.0; }
float steps_to(ivec3 node, int way) { return steps_of(word_to(node, way)); }
