// Where a ray o + t d is inside a box: the interval of t, in units of |d|. Empty: x > y.
// The slab test; a direction of 0 along an axis is inside or outside there for all t (Williams et al.
// 2005, "An Efficient and Robust Ray-Box Intersection Algorithm"; the 0 * inf of their test avoided).
vec2 ray_box(vec3 o, vec3 d, vec3 box_min, vec3 box_max)
{
    const float kFar = 1e30;
    vec2 t = vec2(-kFar, kFar);
    for (int axis = 0; axis < 3; ++axis) {
        if (abs(d[axis]) > 1e-20) {
            float inverse = 1.0 / d[axis];
            float a = (box_min[axis] - o[axis]) * inverse;
            float b = (box_max[axis] - o[axis]) * inverse;
            t = vec2(max(t.x, min(a, b)), min(t.y, max(a, b)));
        } else if (o[axis] < box_min[axis] || o[axis] > box_max[axis]) {
            t = vec2(kFar, -kFar);
        }
    }
    return t;
}
