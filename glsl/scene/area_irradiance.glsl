// Light of an area on surfaces: in closed form, cut off at the surface's horizon, times how much of it is seen.
#include "scene/area_lights.glsl"

// Distance squared over area from which on the sum over its points is as good, and of the closed form the digits that
// are left are fewer.
const float kFarAreas = 1024.0;

vec3 edge_flux(vec3 a, vec3 b)
{
    vec3 across = cross(a, b);
    float sine = length(across);
    return sine > 0.0 ? across * (atan(sine, dot(a, b)) / sine) : vec3(0.0);
}

// A light's outline as a polygon, seen from p; a disk's has as large an area.
const int kDiskCorners = 24;

vec3 corner_of(AreaParams area, bool is_disk, int k, vec3 p)
{
    const float kTurn = 2.0 * kPi / float(kDiskCorners);
    const float kOut = sqrt(kTurn / sin(kTurn));
    vec2 at = vec2(k == 1 || k == 2 ? 1.0 : -1.0, k >= 2 ? 1.0 : -1.0);
    if (is_disk)
        at = kOut * vec2(cos(kTurn * float(k)), sin(kTurn * float(k)));
    return area.center + at.x * area.u + at.y * area.v - p;
}

// Of unit radiance at p, what lies above the horizon of n, along the mean direction that it comes from or its opposite
// [sr]: half the sum over the outline's edges of the angle that each is seen under, along its normal. Lambert 1760.
vec3 polygon_flux(AreaParams area, bool is_disk, vec3 p, vec3 n)
{
    int count = is_disk ? kDiskCorners : 4;
    vec3 sum = vec3(0.0), leaves = vec3(0.0), enters = vec3(0.0);
    vec3 b = corner_of(area, is_disk, 0, p);
    for (int k = 0; k < count; ++k) {
        vec3 a = b;
        b = corner_of(area, is_disk, k + 1 < count ? k + 1 : 0, p);
        float above_a = dot(a, n), above_b = dot(b, n);
        if (above_a <= 0.0 && above_b <= 0.0)
            continue;
        vec3 from = a, to = b;
        if (above_b <= 0.0)
            leaves = to = mix(a, b, above_a / (above_a - above_b));
        if (above_a <= 0.0)
            enters = from = mix(a, b, above_a / (above_a - above_b));
        sum += edge_flux(from, to);
    }
    return 0.5 * (sum + edge_flux(leaves, enters));
}

// The same on a surface of normal n.
float polygon_irradiance(AreaParams area, bool is_disk, vec3 p, vec3 n)
{
    return abs(dot(polygon_flux(area, is_disk, p, n), n));
}

// A disk wholly over the horizon: what arrives comes along the axis of its cone.
float disk_irradiance(AreaParams area, vec3 p, vec3 n)
{
    float lowest = dot(area.center - p, n) - length(vec2(dot(area.u, n), dot(area.v, n)));
    if (lowest < 0.0)
        return polygon_irradiance(area, true, p, n);
    DiskCone cone = disk_cone(area, p);
    float a = cone.tan_toward, b = cone.tan_across;
    return kPi * a * b * inversesqrt((1.0 + a * a) * (1.0 + b * b)) * max(dot(cone.axis, n), 0.0);
}

#ifdef GLOSSY
// What a light's points say of its reflection beside its closed form.
struct AreaReflection {
    vec3 lobe;      // the lobe at the points, over the light's radiance
    float fit;      // and its fit, which is the closed form's
    vec3 arriving;  // what of the points is seen and let through, times their weights
    float weights;
};

// A lobe that is fitted errs in its flanks, by a tenth and more of what a light there sends. The points add what the
// lobe itself differs by, where it varies little from one point to the next: away from a narrow lobe's middle, or
// everywhere in a wide one.
void add_point(inout AreaReflection sum, AreaParams area, LightSample light, float seen, vec3 through, vec3 n)
{
    float solid_angle = area_weight(area, light) * area.area / float(kAreaPoints);
    float between = 0.5 * sqrt(solid_angle);  // of half vectors, half of what lies between two points [rad]
    vec3 sum_of_two = gloss.wo + light.wi;
    vec3 h = sum_of_two / max(length(sum_of_two), 1e-6);
    float off = max(gloss.alpha, length(cross(n, h)));
    float n_wi = dot(n, light.wi);
    float varies_little = smoothstep(0.5, 1.5, off / between) * solid_angle;
    if (n_wi > 0.0)
        sum.lobe += varies_little * n_wi * ggx_reflection(n, gloss.wo, light.wi, gloss.alpha, gloss.f0);
    sum.fit += varies_little * cosine_density(light.wi);
    // Of a narrow lobe, widened so that it meets some of the points.
    float weight = solid_angle * max(n_wi, 0.0) * ggx_distribution(n, h, gloss.alpha + between);
    sum.arriving += weight * seen * through;
    sum.weights += weight;
}

// Schlick's fifth power for light from d, of any length.
float fifth_power_at(vec3 d)
{
    vec3 h = gloss.wo + normalize(d);
    return schlick_fresnel(vec3(0.0), dot(gloss.wo, h) / max(length(h), 1e-6)).x;
}

// Below this part of the lobe's width fewer digits are left of the closed form, and a light is as good as its middle.
const float kPointOfLobe = 1e-3;

void add_area_reflection(int first, AreaParams area, bool is_disk, vec3 p, vec3 n, AreaReflection points)
{
    vec3 through = points.arriving / max(points.weights, 1e-30);
    vec3 to_center = area.center - p;
    if (area.area < kPointOfLobe * kPointOfLobe * gloss.alpha * gloss.alpha * dot(to_center, to_center)) {
        LightSample middle = area_middle(first, p);
        float cosine = dot(n, middle.wi);
        if (cosine > 0.0)
            add_reflection(through * middle.irradiance * cosine, n, middle.wi);
        return;
    }
    mat3 turn = gloss.cosine_from_world;
    AreaParams turned = area;
    turned.center = turn * to_center;
    turned.u = turn * area.u;
    turned.v = turn * area.v;
    vec3 flux = polygon_flux(turned, is_disk, vec3(0.0), vec3(0.0, 0.0, 1.0)) / kPi;
    flux *= sign(flux.z);
    float share = flux.z;
    // Fresnel's part of what the light covers of the lobe is that at its mean direction, and of the whole lobe the
    // table's. A wall that stands at the lobe's end has most of it. The flux is not weighed by the fit's cosine, and
    // leans too far from the axis the more it covers: by this much less it errs least.
    mat3 back = inverse(turn);
    float whole = gloss.ab.x + gloss.ab.y;
    float fifth =
        fifth_power_at(share > 0.0 ? back * vec3(flux.xy * mix(1.0, 0.3, min(1.4 * length(flux), 1.0)), flux.z)
                                   : back[2]) +
        share * (gloss.ab.y / whole - fifth_power_at(back[2]));
    vec3 of_share = whole * (gloss.f0 + (1.0 - gloss.f0) * clamp(fifth, 0.0, 1.0));
    vec3 open = max(of_share * (share - points.fit) + points.lobe, 0.0);
    reflected += u_lights.lights[first].intensity * open * through;
}
#else
struct AreaReflection {
    vec3 lobe;
    float fit;
    vec3 arriving;
    float weights;
};
void add_point(AreaReflection sum, AreaParams area, LightSample light, float seen, vec3 through, vec3 n) {}
void add_area_reflection(int first, AreaParams area, bool is_disk, vec3 p, vec3 n, AreaReflection points) {}
#endif

void add_area_irradiance(inout vec3 sum, int first, bool is_disk, vec3 p, vec3 n)
{
    AreaParams area = area_params(first);
    if (!shines_on(area, p))
        return;
    vec3 to_center = area.center - p;
    bool far = dot(to_center, to_center) > kFarAreas * area.area;
    float open = 0.0;
    if (!far) {
        open = is_disk ? disk_irradiance(area, p, n) : polygon_irradiance(area, false, p, n);
        if (open <= 0.0)
            return;
    }
    ShadowDepth depth = u_lights.views[int(u_lights.lights[first].first_view)].depth;
    vec3 arriving = vec3(0.0);
    float weights = 0.0;
    AreaReflection reflection = AreaReflection(vec3(0.0), 0.0, vec3(0.0), 0.0);
    for (int point = 0; point < kAreaPoints; ++point) {
        int i = first + point;
        LightSample light = point_sample(i, p);
        float weight = area_weight(area, light) * max(dot(light.wi, n), 0.0);
        weights += weight;
        float seen = weight;
        if (kSurfaceShadows && weight > 0.0)
            seen *= area_visibility(area, first, point, point_sample(i, p + n * (depth.bias * light.range)));
        vec3 through = seen > 0.0 ? through_media(i, p, light) * filter_on_surface(i, p) : vec3(0.0);
        arriving += seen * through;
        add_point(reflection, area, light, weight > 0.0 ? seen / weight : 0.0, through, n);
    }
    float share = far ? area.area / float(kAreaPoints) : open / max(weights, 1e-30);
    sum += u_lights.lights[first].intensity * share * arriving;
    add_area_reflection(first, area, is_disk, p, n, reflection);
}

void add_rect_irradiance(inout vec3 sum, int i, vec3 p, vec3 n) { add_area_irradiance(sum, i, false, p, n); }
void add_disk_irradiance(inout vec3 sum, int i, vec3 p, vec3 n) { add_area_irradiance(sum, i, true, p, n); }
