// How far a node of a lattice sees in one of the eight octants around it: along the axes at its edges, the diagonals
// between two of them, and the one amid all three.

struct Sight {
    vec3 axes;      // to the nearest surface, in steps to the next node that way; more than 1: none before it
    vec3 faces;     // along the diagonal between the other two axes than each
    float middle;   // and between all
    vec3 behind;    // 1: none before the next node the other way along an axis; else 0
    float through;  // of light, over two nodes, by media
    float outside;  // 1; 0: the node lies inside of a surface
};

const float kSightSteps = 254.0;  // to the next node; 255: none. Rounded up: a place on a wall is not behind it
const float kSightThrough = 30.0;
const uint kSightInside = 31u;  // instead of what is let through

uvec2 pack_sight(Sight sight)
{
    uvec4 near = uvec4(min(ceil(vec4(sight.axes, sight.faces.x) * kSightSteps), 255.0));
    uvec3 more = uvec3(min(ceil(vec3(sight.faces.yz, sight.middle) * kSightSteps), 255.0));
    uvec3 behind = uvec3(sight.behind);
    uint through = sight.outside > 0.0 ? uint(round(sight.through * kSightThrough)) : kSightInside;
    uint rest = behind.x | behind.y << 1 | behind.z << 2 | through << 3;
    return uvec2(near.x | near.y << 8 | near.z << 16 | near.w << 24, more.x | more.y << 8 | more.z << 16 | rest << 24);
}

Sight unpack_sight(uvec2 word)
{
    vec4 near = unpackUnorm4x8(word.x) * (255.0 / kSightSteps);
    vec3 more = unpackUnorm4x8(word.y).xyz * (255.0 / kSightSteps);
    uint rest = word.y >> 24;
    return Sight(near.xyz, vec3(near.w, more.xy), more.z, vec3(rest & 1u, rest >> 1 & 1u, rest >> 2 & 1u),
                 float(rest >> 3) / kSightThrough, rest >> 3 == kSightInside ? 0.0 : 1.0);
}

// way: from the node to what it may see
Sight sight_of(usampler3D sights, ivec3 node, int nodes_z, vec3 way)
{
    ivec3 up = ivec3(greaterThanEqual(way, vec3(0.0)));
    int octant = up.x + 2 * up.y + 4 * up.z;
    return unpack_sight(texelFetch(sights, node + ivec3(0, 0, octant * nodes_z), 0).xy);
}
