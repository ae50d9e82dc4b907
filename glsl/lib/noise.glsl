// Gradient noise on an integer lattice: the same cells on every machine, since only integers are
// hashed. Perlin 2002, "Improving Noise" (quintic fade); the hash is PCG3D of Jarzynski and Olano
// 2020, "Hash Functions for GPU Rendering".

uvec3 hash_pcg3d(uvec3 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Dot of an offset with one of the 12 directions to a cube's edges, of length sqrt(2).
float noise_gradient(ivec3 cell, uint seed, vec3 offset)
{
    uint h = hash_pcg3d(uvec3(cell) + uvec3(seed, 0u, 0u)).x;
    // The upper 16 bits modulo 3 are the coordinate that the gradient leaves out. Times 43691, the inverse of 3
    // modulo 65536, what leaves 0 comes to lie in the first third of them, 2 in the second, and 1 in the last.
    uint third = (h & 0xffff0000u) * 43691u;
    float a = third < 0x55560000u ? offset.y : offset.x;
    float b = third - 0x55560000u < 0x55550000u ? offset.y : offset.z;
    return ((h & 0x10000000u) != 0u ? a : -a) + ((h & 0x20000000u) != 0u ? b : -b);
}

// Gradient noise at cell + f, f in [0, 1): in -1..1, mean 0.
float noise_at(ivec3 cell, uint seed, vec3 f)
{
    vec3 u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    float corner[8];
    for (int i = 0; i < 8; ++i) {
        ivec3 step = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        corner[i] = noise_gradient(cell + step, seed, f - vec3(step));
    }
    vec4 x =
        mix(vec4(corner[0], corner[2], corner[4], corner[6]), vec4(corner[1], corner[3], corner[5], corner[7]), u.x);
    vec2 y = mix(x.xz, x.yw, u.y);
    return mix(y.x, y.y, u.z);
}
