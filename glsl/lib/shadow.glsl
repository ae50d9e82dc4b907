// The depth that a shadow view keeps: linear in metres, so one bias means the same near and far.
//   origin  xyz: where depth is 0; w: 1 / range
//   axis    xyz: a sun's direction of travel, or 0 where depth is the distance from origin;
//           w: bias [m], or metres per metre of distance
bool is_sun_view(vec4 axis) { return dot(axis.xyz, axis.xyz) > 0.0; }

float shadow_depth(vec4 origin, vec4 axis, vec3 p)
{
    vec3 from = p - origin.xyz;
    return clamp((is_sun_view(axis) ? dot(from, axis.xyz) : length(from)) * origin.w, 0.0, 1.0);
}

// How far a lit surface is moved before it looks itself up: about a texel of the view. [m]
float shadow_bias(vec4 origin, vec4 axis, vec3 p)
{
    return is_sun_view(axis) ? axis.w : axis.w * length(p - origin.xyz);
}

// Which of six views of a point light holds direction d, +x -x +y -y +z -z, and where in it d is, -1..1 over a
// right angle: the axes of a view as src/light/shadow_views.cpp sets them, without a matrix that each point would
// look up for itself, or a branch, both ways of which would be run.
vec2 on_cube_face(vec3 d, out int face)
{
    vec3 a = abs(d);
    bool x = a.x >= a.y && a.x >= a.z;
    bool y = !x && a.y >= a.z;
    float along = x ? d.x : y ? d.y : d.z;
    face = (x ? 0 : y ? 2 : 4) + (along >= 0.0 ? 0 : 1);
    return vec2(x ? -d.y : y ? d.x : d.y, x || y ? d.z : d.x) * vec2(sign(along), 1.0) / abs(along);
}

int cube_face(vec3 d)
{
    int face;
    on_cube_face(d, face);
    return face;
}
