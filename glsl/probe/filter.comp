// A probe's light as GGX reflects it to an eye above the surface (Karis 2013, "Real Shading in Unreal Engine 4"), weighted by
// the cosine. The sum goes over all of the light, in means as wide as the lobe is smooth where they lie: a sun of 1e5 counts
// for as much as the lobe has of it, where 64 samples of the lobe's normals (Krivanek and Colbert 2008) miss it by half.
//   in   the pyramid of the probe's light, largest first: u_filter.from
//   out  radiance
#include "probe/map.glsl"

layout(binding = PROBE_SOURCE_UNIT) uniform sampler2DArray u_source_tx;

// Of the pyramid's levels all but the first stand above each other beside that.
ivec2 first_of_level(int level, int size)
{
    int n = u_filter.from.size;
    return level == 0 ? ivec2(1) : ivec2(n + 3, 1 + n - 2 * size + 2 * (level - 1));
}

vec4 mean_at(int level, int size, ivec2 texel)
{
    return texelFetch(u_source_tx, ivec3(first_of_level(level, size) + texel, 0), 0);
}

float brightness(vec4 light) { return light.r + light.g + light.b; }

void main()
{
    if (!is_in_map())
        return;
    const float kSmooth = 0.45;  // a mean's edge, over its distance to the lobe's axis and the lobe's width
    const int kCoarsest = 3;     // octaves of the fewest texels that stand for the sphere
    vec3 n = octahedral_direction((vec2(texel_of_map()) + 0.5) / float(u_filter.to.size));
    float a2 = u_filter.alpha * u_filter.alpha;
    int top = findMSB(u_filter.from.size);
    // About the mean of all: what does not differ from it is not rounded.
    vec4 all = mean_at(top, 1, ivec2(0));
    float per_brightness = 1.0 / max(brightness(all), 1e-20);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    int level = top;
    ivec2 texel = ivec2(0);
    while (true) {
        int size = u_filter.from.size >> level;
        vec3 met = on_octahedron((vec2(texel) + 0.5) / float(size));
        float solid_angle = octahedral_solid_angle(met, float(size));
        vec3 wi = normalize(met);
        float cosine = dot(n, wi);
        float edge = sqrt(solid_angle);
        float smooth_over = kSmooth * (distance(n, wi) + 2.0 * u_filter.alpha);
        vec4 mean = mean_at(level, size, texel);
        float bright = max(1.0, brightness(mean) * per_brightness);
        if (level > top - kCoarsest || (level > 0 && cosine > -edge && edge * sqrt(bright) > smooth_over)) {
            --level;
            texel *= 2;
            continue;
        }
        if (cosine > 0.0) {
            float root = (0.5 + 0.5 * cosine) * (a2 - 1.0) + 1.0;  // of the cosine of half the angle, squared
            float weight = solid_angle * cosine / (root * root);
            sum += weight * (mean - all);
            weights += weight;
        }
        // The next of four, or of those that these four are in.
        int up = findLSB(~(texel.x & texel.y));
        level += up;
        texel >>= up;
        if (level == top)
            break;
        texel = (texel.x & 1) == 0 ? texel + ivec2(1, 0) : texel + ivec2(-1, 1);
    }
    store(all + sum / weights);
}
