// The depth that a shadow view keeps: linear in metres, so one bias means the same near and far.
#include "shared/light_params.h"

bool is_sun_view(ShadowDepth view) { return dot(view.travel, view.travel) > 0.0; }

float shadow_depth(ShadowDepth view, vec3 p)
{
    vec3 from = p - view.origin;
    return clamp((is_sun_view(view) ? dot(from, view.travel) : length(from)) * view.inverse_range, 0.0, 1.0);
}

// As far as what a view keeps of a surface lies from a place on it, across: about a texel of the view. [m]
float shadow_bias(ShadowDepth view, vec3 p)
{
    return is_sun_view(view) ? view.bias : view.bias * length(p - view.origin);
}

// What is left between a lit surface and what a view keeps of it.
struct ShadowSlack {
    float nearer;  // taken off its depth [m]
    float lift;    // that it is moved off along its normal [m]
};

// A place that is moved sees its shadow's edge elsewhere. So depth alone makes up for how steep the surface is to the
// light, but where that would be too much for what stands on it.
//   n  its normal, or 0: no surface
ShadowSlack shadow_slack(ShadowDepth view, vec3 p, vec3 n)
{
    const float kSteepest = 4.0;
    vec3 wi = is_sun_view(view) ? -view.travel : normalize(view.origin - p);
    float cosine = dot(n, wi);
    float slope = length(n - cosine * wi) / max(cosine, 1e-3);
    float bias = shadow_bias(view, p);
    return ShadowSlack(bias * min(slope, kSteepest), bias * max(1.0 - kSteepest / max(slope, 1e-3), 0.0));
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
