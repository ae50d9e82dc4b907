// How far along each axis a node's surfaces are, and how many nodes it is to one that has some, by the axis along which it
// is most: what a ray asks at each step, in one texel.

const float kWallSteps = 1000.0;  // to the next node
const uint kNoWall = 1023u;

struct Clearance {
    vec3 wall;  // ahead along each axis, in nodes; more than 1: none before the next node
    int nodes;  // 0: the node has a surface
};

uint pack_walls(vec3 walls, uint more)
{
    uvec3 steps = mix(uvec3(round(walls * kWallSteps)), uvec3(kNoWall), greaterThan(walls, vec3(1.0)));
    return steps.x | steps.y << 10 | steps.z << 20 | more << 30;
}

uvec2 pack_clearance(Walls walls, int nodes)
{
    return uvec2(pack_walls(walls.down, uint(nodes) & 3u), pack_walls(walls.up, uint(nodes) >> 2));
}

vec3 unpack_walls(uint word) { return vec3(word & 1023u, word >> 10 & 1023u, word >> 20 & 1023u) / kWallSteps; }

// ahead: of each axis whether it is up
Clearance unpack_clearance(uvec2 texel, bvec3 ahead)
{
    return Clearance(mix(unpack_walls(texel.x), unpack_walls(texel.y), ahead), int(texel.x >> 30 | texel.y >> 30 << 2));
}
