// Directions on a square, 0..1: the octahedron |x| + |y| + |z| = 1 seen from +z, the lower half folded out over the corners.
// Engelhardt and Dachsbacher 2008, "Octahedron Environment Maps".
vec2 folded(vec2 p) { return (1.0 - abs(p.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0))); }

vec2 octahedral_uv(vec3 d)
{
    vec2 p = d.xy / (abs(d.x) + abs(d.y) + abs(d.z));
    return 0.5 + 0.5 * (d.z < 0.0 ? folded(p) : p);
}

// Not of unit length: where the octahedron is met.
vec3 on_octahedron(vec2 uv)
{
    vec2 p = 2.0 * uv - 1.0;
    float z = 1.0 - abs(p.x) - abs(p.y);
    return vec3(z < 0.0 ? folded(p) : p, z);
}

vec3 octahedral_direction(vec2 uv) { return normalize(on_octahedron(uv)); }

// Solid angle of a texel of a map of n x n about where the octahedron is met [sr]: its area there over the distance cubed.
float octahedral_solid_angle(vec3 met, float n)
{
    float r2 = dot(met, met);
    return 4.0 / (n * n * r2 * sqrt(r2));
}

// A texel beside the map is the one inside it that lies there on the sphere: an edge is folded in its middle.
ivec2 octahedral_wrap(ivec2 texel, int n)
{
    ivec2 inside = clamp(texel, ivec2(0), ivec2(n - 1));
    bvec2 beside = notEqual(texel, inside);
    return ivec2(beside.y ? n - 1 - inside.x : inside.x, beside.x ? n - 1 - inside.y : inside.y);
}
