// Lights that have an area, rectangles and disks. How much of one arrives is worked out in closed form; what hides and
// dims it is asked of kAreaPoints points, spread evenly over it, each of which has a number, a layer of optical depth
// and six layers of the shadow map. Their positions are in lights[], the rest in the `own` of each of them.

// Variant
const int kAreaPoints = 4;  // each light's, a multiple of four

struct AreaParams {
    vec3 center;        // [m]
    float area;         // [m^2]
    vec3 u;             // a rectangle's half edge, a disk's radius [m]
    float first_layer;  // of the shadow map, of this point
    vec3 v;             // the other, square to u [m]
    float two_sided;    // 1, or 0
    vec3 normal;        // where it shines, unit length
};

AreaParams area_params(int first)
{
    vec4 own[4] = u_lights.lights[first].own;
    return AreaParams(own[0].xyz, own[0].w, own[1].xyz, own[1].w, own[2].xyz, own[2].w, own[3].xyz);
}

bool shines_on(AreaParams area, vec3 p) { return area.two_sided > 0.0 || dot(p - area.center, area.normal) > 0.0; }

// All of it, as if from its middle.
LightSample area_middle(int first, vec3 p)
{
    AreaParams area = area_params(first);
    vec3 to_light = area.center - p;
    float range2 = max(dot(to_light, to_light), 0.1 * area.area);
    vec3 wi = to_light * inversesqrt(range2);
    float cosine = shines_on(area, p) ? abs(dot(wi, area.normal)) : 0.0;
    return LightSample(wi, sqrt(range2), u_lights.lights[first].intensity * (area.area * cosine / range2), false);
}

LightSample rect_sample(int i, vec3 p) { return area_middle(i, p); }
LightSample disk_sample(int i, vec3 p) { return area_middle(i, p); }

// Solid angle of a square metre at a point of the light, seen from light.range metres away [1/m^2].
float area_weight(AreaParams area, LightSample light)
{
    return abs(dot(light.wi, area.normal)) / (light.range * light.range);
}

// Whether surfaces leave one of its points in sight of p in a medium, light.range metres along light.wi from it.
float area_visibility(AreaParams area, int first, int point, LightSample light)
{
    float depth = light.range * u_lights.views[int(u_lights.lights[first].first_view)].depth.inverse_range;
    int face;
    vec2 on_face = on_cube_face(-light.wi, face);
    return visibility_in(int(area.first_layer) + 6 * point + face,
                         on_face * u_lights.lights[first].cube_view_scale + 0.5, depth);
}

// One point of any, with its share of the area.
LightSample area_sample(int i, vec3 p)
{
    AreaParams area = area_params(i);
    LightSample light = point_sample(i, p);
    float cosine = shines_on(area, p) ? abs(dot(light.wi, area.normal)) : 0.0;
    light.irradiance *= area.area / float(kAreaPoints) * cosine;
    return light;
}

float area_on_surface(int i, vec3 p, vec3 n)
{
    vec3 along = n * u_lights.views[int(u_lights.lights[i].first_view)].depth.bias;
    return area_visibility(area_params(i), i, 0, point_sample(i, p + along * length(p - u_lights.lights[i].position)));
}

// The cone about a disk that p sees is an elliptic one: its axis, the tangents of half its opening angles, and the unit
// vectors along which those are. Guillen et al. 2017, "Area-Preserving Parameterizations for Spherical Ellipses".
struct DiskCone {
    vec3 axis, toward, across;
    float tan_toward, tan_across;
};

DiskCone disk_cone(AreaParams area, vec3 p)
{
    vec3 to_center = area.center - p;
    float radius = length(area.u);
    float height = dot(to_center, area.normal);
    vec3 up = height < 0.0 ? -area.normal : area.normal;
    height = max(abs(height), 1e-4 * radius);
    vec3 along = to_center - up * dot(to_center, up);
    float offset = length(along);
    vec3 toward = offset > 1e-6 * radius ? along / offset : area.u / radius;
    // Through the disk's nearest and its farthest point.
    float angle_far = atan(offset + radius, height), angle_near = atan(offset - radius, height);
    float middle = 0.5 * (angle_far + angle_near);
    // Where the axis meets the disk, and half of the chord there.
    float at = height * tan(middle);
    float chord = sqrt(max(radius * radius - (at - offset) * (at - offset), 0.0));
    float c = cos(middle), s = sin(middle);
    return DiskCone(s * toward + c * up, c * toward - s * up, cross(up, toward), tan(0.5 * (angle_far - angle_near)),
                    chord * c / height);
}
