// What a surface has of the light that media emit.
#include "lib/fire_nodes.glsl"
#include "scene/light_volumes_block.glsl"

const bool kFireOnSurfaces = false;  // variant: there is some

layout(binding = FIELD_ORDER_UNIT) uniform sampler3D u_fire_tx;       // no field is finished meanwhile
layout(binding = FIELD_WORLD_UNIT) uniform sampler3D u_fire_seen_tx;  // likewise

// The mean over a cone of directions of their cosines to a normal, of those that are above its surface.
//   along  the cosine of its axis
//   sine   of its half angle
float cosine_of_cone(float along, float sine)
{
    if (along >= sine)  // all of it is above the surface: exact
        return along;
    float part = max(1.0 + along / max(sine, 1e-6), 0.0);
    return 0.25 * sine * part * part;
}

// Irradiance of light that comes from a cone of directions alone.
//   way   its integral, each times its direction
//   rest  by how much the integral without is more than the length of that
float irradiance_of_cone(vec3 way, float rest, vec3 n)
{
    float size = length(way);
    if (size <= 0.0)
        return 0.0;
    // Of even light in a cone, size / (size + rest) is (1 + cos) / 2 of its half angle.
    float sine = rest < size ? 2.0 * sqrt(size * rest) / (size + rest) : 1.0;
    return size * cosine_of_cone(dot(way, n) / size, sine);
}

// Of what is seen times `outside`, and of that.
float part_seen(float seen, float outside) { return outside > 1e-3 ? seen / outside : 1.0; }

// [W/m^2]; at: where nodes of the surfaces' lattice count, as far as p lies inside of it
vec3 fire_irradiance(vec3 p, vec3 n, vec3 at, float inside)
{
    FireParams fire = u_volumes.fire;
    if (!kFireOnSurfaces || fire.is_seen == 0.0)
        return vec3(0.0);
    vec2 seen = textureLod(u_fire_seen_tx, (at + 0.5) / (u_volumes.surfaces.last + 1.0), 0.0).rg;
    vec3 node = clamp(fire_node(fire, p), vec3(0.0), fire.last);
    vec3 size = (fire.last + 1.0) * vec3(1.0, 1.0, 4.0);
    vec4 light[4];
    for (int i = 0; i < 4; ++i) {
        vec3 texel = node + 0.5;
        texel.z += float(i) * (fire.last.z + 1.0);
        light[i] = textureLod(u_fire_tx, texel / size, 0.0);
    }
    // Beyond the nodes light goes on as if it came from as far off as the middle is, along the way that it comes from
    // where they end.
    vec3 end = fire_place(fire, node);
    vec3 further = end - p;
    float off = distance(end, fire.middle);
    vec3 sum;
    for (int c = 0; c < 3; ++c) {
        vec3 way = vec3(light[1][c], light[2][c], light[3][c]);
        float power = length(way), rest = light[0][c];
        if (power > 0.0 && dot(further, further) > 1e-6 * off * off) {
            vec3 from = further + way / power * off;
            float less = off * off / dot(from, from);
            way = normalize(from) * power * less;
            rest *= less * less;
        }
        sum[c] = irradiance_of_cone(way, rest, n);
    }
    return sum * mix(part_seen(light[0].a, light[1].a), part_seen(seen.r, seen.g), inside);
}
