// Light of an area that media scatter. A quarter of its points is asked at a time, each place its own quarter.
#include "scene/area_lights.glsl"

const int kAsked = kAreaPoints / 4;
const float kFarAreas = 16.0;  // distance squared over area from which on its points stand for it well enough

// Two numbers below 1 for a place, like random ones: the second of them also says which quarter.
vec2 numbers_at(vec3 p)
{
    uvec3 bits = floatBitsToUint(p);
    uint x = bits.x * 0x9e3779b1u ^ bits.y * 0x85ebca77u ^ bits.z * 0xc2b2ae3du;
    x = (x ^ (x >> 15u)) * 0x2c1b3c6du;
    x = (x ^ (x >> 12u)) * 0x297a2d39u;
    x ^= x >> 15u;
    return vec2(x >> 16u, x & 0xffffu) / 65536.0;
}

// The n-th of kAsked numbers like `number`, each in a part of its own.
float part_of(int n, float number) { return (float(n) + number) / float(kAsked); }

// Of the triangle of three places seen from the origin [sr]: Van Oosterom and Strackee 1983.
float solid_angle(vec3 a, vec3 b, vec3 c)
{
    float la = length(a), lb = length(b), lc = length(c);
    return 2.0 * atan(abs(dot(a, cross(b, c))), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
}

float angle_between(vec3 a, vec3 b) { return acos(clamp(dot(a, b), -1.0, 1.0)); }

// The phase over all directions to a rectangle, from points spread evenly over its solid angle: Urena et al. 2013, "An
// Area-Preserving Parametrization for Spherical Rectangles".
float phase_of_rect(AreaParams area, vec3 p, vec3 wo, float g, vec2 numbers)
{
    vec3 to = area.center - p;
    float half_u = length(area.u), half_v = length(area.v);
    vec3 x = area.u / half_u, y = area.v / half_v;
    vec3 z = area.normal * (dot(to, area.normal) > 0.0 ? -1.0 : 1.0);
    vec2 from = vec2(dot(to, x) - half_u, dot(to, y) - half_v), end = from + 2.0 * vec2(half_u, half_v);
    float z0 = min(dot(to, z), -1e-4 * sqrt(area.area));
    vec3 v00 = vec3(from, z0), v10 = vec3(end.x, from.y, z0), v11 = vec3(end, z0), v01 = vec3(from.x, end.y, z0);
    float omega = solid_angle(v00, v10, v11) + solid_angle(v00, v11, v01);
    vec3 n0 = normalize(cross(v00, v10)), n1 = normalize(cross(v10, v11));
    vec3 n2 = normalize(cross(v11, v01)), n3 = normalize(cross(v01, v00));
    float k = 2.0 * kPi - angle_between(-n2, n3) - angle_between(-n3, n0);
    float s = angle_between(-n0, n1) + angle_between(-n1, n2) - k;
    float sum = 0.0;
    for (int j = 0; j < kAsked; ++j) {
        float angle = part_of(j, numbers.x) * s + k;
        float f = (cos(angle) * n0.z - n2.z) / sin(angle);
        float c = clamp((f > 0.0 ? 1.0 : -1.0) * inversesqrt(f * f + n0.z * n0.z), -1.0, 1.0);
        float xu = clamp(-c * z0 * inversesqrt(max(1.0 - c * c, 1e-12)), from.x, end.x);
        float d2 = xu * xu + z0 * z0;
        float h0 = from.y * inversesqrt(d2 + from.y * from.y), h1 = end.y * inversesqrt(d2 + end.y * end.y);
        float h = mix(h0, h1, fract(numbers.y + 0.618034 * float(j)));
        float yv = clamp(h * sqrt(d2 / max(1.0 - h * h, 1e-12)), from.y, end.y);
        sum += phase_at(dot(-normalize(xu * x + yv * y + z0 * z), wo), g);
    }
    return omega / float(kAsked) * sum;
}

// And to a disk: of the sectors of its cone, each a part of the solid angle.
float phase_of_disk(AreaParams area, vec3 p, vec3 wo, float g, vec2 numbers)
{
    DiskCone cone = disk_cone(area, p);
    vec2 tangents = vec2(cone.tan_toward, cone.tan_across);
    float omega = 0.0;
    for (int j = 0; j < 4; ++j) {  // of a quarter, which all are like
        float angle = (float(j) + 0.5) * kPi / 8.0;
        vec2 rim = tangents * vec2(cos(angle), sin(angle));
        float r2 = 1.0 + dot(rim, rim);
        omega += 0.5 * kPi / (r2 + sqrt(r2));
    }
    float sum = 0.0, weights = 0.0;
    for (int j = 0; j < kAsked; ++j) {
        float angle = 2.0 * kPi * part_of(j, numbers.x);
        vec2 rim = tangents * vec2(cos(angle), sin(angle));
        float r2 = dot(rim, rim);
        float weight = 1.0 / (1.0 + r2 + sqrt(1.0 + r2));
        float c = mix(inversesqrt(1.0 + r2), 1.0, fract(numbers.y + 0.618034 * float(j)));
        vec2 side = rim * (sqrt(max(1.0 - c * c, 0.0)) * inversesqrt(max(r2, 1e-20)));
        vec3 wi = c * cone.axis + side.x * cone.toward + side.y * cone.across;
        sum += weight * phase_at(dot(-wi, wo), g);
        weights += weight;
    }
    return omega * tangents.x * tangents.y * sum / weights;
}

void add_area(inout vec3 sum, int first, bool is_disk, LightLine line, LightStep step)
{
    AreaParams area = area_params(first);
    float t = step.t;
    vec3 share = vec3(1.0);
    if (kExactFalloff) {
        // Sampled as a point's light in its middle is, which has no pole where it is as far as it is large.
        vec3 to_light = area.center - line.ray.origin;
        float metres = length(line.ray.direction);
        float nearest = dot(to_light, line.ray.direction) / (metres * metres);
        vec3 from_line = to_light - line.ray.direction * nearest;
        float d2 = dot(from_line, from_line) + 0.1 * area.area;
        Falloff over = falloff_over((step.ends - nearest) * metres, sqrt(d2), step.share);
        t = nearest + over.place / metres;
        share = over.mean * (d2 + over.place * over.place) * vec3(exp(-step.sigma_t * over.ahead));
    }
    vec3 p = line.ray.origin + line.ray.direction * t;
    if (!shines_on(area, p))
        return;
    vec2 numbers = numbers_at(p);
    int quarter = int(numbers.y * 4.0);
    numbers.y = fract(numbers.y * 4.0);
    vec3 to_center = area.center - p;
    bool far = dot(to_center, to_center) > kFarAreas * area.area;
    vec3 arriving = vec3(0.0);
    float open = 0.0;
    const bool kFetchesFour = kPackedDepths && kVolumeShadows && kDepthAtPoint;
    vec4 stored = vec4(0.0);
    if (kFetchesFour)
        stored = packed_depths(first + quarter * kAsked, line.depth + line.ddepth * t);
    for (int j = 0; j < kAsked; ++j) {
        int point = quarter * kAsked + j;
        LightSample light = point_sample(first + point, p);
        float weight = area_weight(area, light) * phase_of(light, line.wo, step.g);
        float seen = kSurfaceShadows ? weight * area_visibility(area, first, point, light) : weight;
        if (seen > 0.0) {
            vec3 shadow;
            if (kFetchesFour)
                shadow = vec3(exp(-depth_of(p, line, light, volume_t(stored[j]))));
            else
                shadow = volume_shadow(first + point, line, t, light);
            arriving += seen * shadow * filter_in_medium(first + point, p);
        }
        open += weight;
    }
    float scattered = area.area / float(kAsked);
    if (!far)
        scattered = (is_disk ? phase_of_disk(area, p, line.wo, step.g, numbers)
                             : phase_of_rect(area, p, line.wo, step.g, numbers)) /
                    max(open, 1e-30);
    sum += share * u_lights.lights[first].intensity * scattered * arriving;
}

void add_rect(inout vec3 sum, int i, LightLine line, LightStep step) { add_area(sum, i, false, line, step); }
void add_disk(inout vec3 sum, int i, LightLine line, LightStep step) { add_area(sum, i, true, line, step); }
