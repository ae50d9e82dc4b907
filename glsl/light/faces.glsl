// Of each node, the surface that is met first along each of the lattice's axes, before the next node: how far away,
// in which direction it faces, and which it is, in 8, 12 and 12 bits.
#include "lib/octahedral.glsl"
#include "light/field.glsl"

const uint kNoFace = 0xffffffffu;
const int kNoSurface = 0xfff;  // the inside of one
const float kFaceSteps = 254.0;
const float kFacings = 31.0;  // either way from the middle: an axis is one of them

// before: how far it lies before the node, 0..1
uint pack_face(float before, vec3 normal, int surface)
{
    uvec2 facing = uvec2(round((2.0 * octahedral_uv(normalize(normal)) - 1.0) * kFacings) + 32.0);
    return uint(before * kFaceSteps) << 24 | facing.x << 18 | facing.y << 12 | uint(min(surface, kNoSurface));
}

struct Face {
    float before;
    vec3 normal;
    int surface;
};

Face unpack_face(uint word)
{
    vec2 facing = (vec2(word >> 18 & 63u, word >> 12 & 63u) - 32.0) / kFacings;
    return Face(float(word >> 24) / kFaceSteps, octahedral_direction(0.5 + 0.5 * facing), int(word & 0xfffu));
}

// Where the image of the parts of faces has that which a line among finer ones falls in.
ivec3 part_of_face(ivec2 line)
{
    ivec2 part = line % FACE_PARTS;
    return ivec3((part.y * FACE_PARTS + part.x) * node_count().x, 0, 0);
}
