// Optical depth of the marched media through the volume of their extinction.
#include "scene/light_volumes.glsl"

layout(binding = EXTINCTION_VOLUME_UNIT) uniform sampler3D u_extinction_volume_tx;

// From p along wi over `range` metres, in midpoint steps of at most `step` nodes.
volume_t traced_depth(vec3 p, vec3 wi, float range, float step)
{
    LatticeParams lattice = u_volumes.extinction;
    vec2 t = lattice_segment(lattice, p, wi, range);
    volume_t sum = volume_t(0.0);
    if (t.x >= t.y)
        return sum;
    vec3 from = lattice_uvw(lattice, p + wi * t.x, 0);
    vec3 way = lattice_uvw(lattice, p + wi * t.y, 0) - from;
    int steps = int(ceil(length(way / lattice.inverse_size) / step));
    for (int i = 0; i < steps; ++i) {
        vec3 uvw = from + way * ((float(i) + 0.5) / float(steps));
        sum += volume_value(textureLod(u_extinction_volume_tx, uvw, 0.0));
    }
    return sum * ((t.y - t.x) / float(max(steps, 1)));
}
