// Carries light along the columns of each direction, from slice to slice: what came is dimmed and what is scattered or
// emitted on the way added. A column is met by nothing but itself, so light is not smeared on its way as it is where
// it is handed from node to node.
//   in   sigma_t, what scatters and emits at the nodes, the ways between slices that surfaces cross
//   out  radiance at each column's places, a direction's slices after each other
// The source is linear in optical depth between slices: Olson and Kunasz 1987, "Short characteristic solution of the
// non-LTE line transfer problem", sec. 3.
#include "light/field.glsl"
#include "lib/slab.glsl"

// Variant
const bool kEnters = false;    // the world's light comes in
const bool kEmits = false;     // the media emit
const bool kScatters = false;  // and scatter
const bool kMeans = false;     // out: the mean over what lies between a place and its neighbours, by what dims there.
                               // It times sigma_t is all that the medium takes in, however thick it is.
const bool kSurfaces = false;  // surfaces stand in the way

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) writeonly uniform image3D u_columns_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_SOURCE_UNIT) uniform sampler3D u_source_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = FIELD_CROSSED_UNIT) uniform usampler3D u_crossed_tx;

// Of a source that grows from 0 to 1 over tau, what gets to its end; mean: slab_weight(tau).
vec3 share_of_end(vec3 tau, vec3 mean)
{
    vec3 series = tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))));
    return mix(1.0 - mean, series, lessThan(tau, vec3(0.1)));
}

bool is_crossed(ivec2 column, int first_word, int to)
{
    uint word = texelFetch(u_crossed_tx, ivec3(column, first_word + (to >> 5)), 0).x;
    return (word >> uint(to & 31) & 1u) != 0u;
}

void main()
{
    ivec2 column = ivec2(gl_GlobalInvocationID.xy);
    int k = int(gl_GlobalInvocationID.z);
    if (max(column.x, column.y) >= u_field.columns)
        return;
    FieldDirection d = u_field.directions[k];
    vec3 last = to_axes(d.axis, u_field.nodes.last);
    vec2 across = vec2(column) + d.first;
    int slices = int(last.x) + 1;
    // Columns that never come near the lattice.
    vec2 end = across + d.slope * last.x;
    if (any(greaterThan(min(across, end), last.yz + 1.0)) || any(lessThan(max(across, end), vec2(-1.0))))
        return;
    float along = d.forward > 0.0 ? 0.0 : last.x;
    vec3 nodes_last = u_field.nodes.last;
    float layer = nodes_last.z + 1.0;
    vec3 texel = 1.0 / (nodes_last + 1.0);
    vec3 to_source = vec3(texel.xy, texel.z / float(u_field.count));
    bool hidden = kSurfaces && is_crossed(column, d.first_word, 0);
    vec3 light = kEnters && !hidden ? d.entry : vec3(0.0);
    vec3 old_sigma_t = vec3(0.0);
    vec3 old_source = vec3(0.0);
    vec3 old_emission = vec3(0.0);
    vec3 old_mean = vec3(0.0);
    for (int i = 0; i < slices; ++i) {
        vec3 q = from_axes(d.axis, along, across);
        vec3 held = clamp(q, vec3(0.0), nodes_last);
        vec3 uvw = (held + 0.5) * texel;
        const float kRounding = 1e-3;
        bool inside = all(lessThan(abs(q - held), vec3(kRounding)));
        vec3 sigma_t = inside ? textureLod(u_sigma_t_tx, uvw, 0.0).rgb : vec3(0.0);
        vec3 emission = kEmits && inside ? textureLod(u_emission_tx, uvw, 0.0).rgb : vec3(0.0);
        vec3 source = vec3(0.0);
        if (kScatters)
            source = textureLod(u_source_tx, (held + 0.5 + vec3(0.0, 0.0, layer * float(k))) * to_source, 0.0).rgb;
        source *= source; source *= source;
        ivec3 at = ivec3(column, i + u_field.slices * k);
        if (i > 0) {
            vec3 tau = 0.5 * d.metres * (sigma_t + old_sigma_t);
            vec3 weight = slab_weight(tau);
            vec3 through = exp(-tau);
            vec3 of_end = share_of_end(tau, weight);
            vec3 emitted = 0.5 * d.metres * (emission + old_emission);
            vec3 added = source * of_end + old_source * (1.0 - through - of_end) + emitted * weight;
            vec3 came = light;
            light = came * through + added;
            vec3 taken = (came - light + emitted) / max(tau, 1e-6) + 0.5 * (source + old_source);
            vec3 mean = mix(taken, 0.5 * (came + light), lessThan(tau, vec3(0.05)));
            if (kSurfaces && is_crossed(column, d.first_word, i)) {
                // Where on the way is not known: half of it lies behind the surface.
                light = 0.5 * added;
                mean *= 0.5;
            }
            if (kMeans)
                imageStore(u_columns_img, at - ivec3(0, 0, 1), vec4(i == 1 ? mean : 0.5 * (mean + old_mean), 0.0));
            old_mean = mean;
        }
        if (!kMeans || i == slices - 1)
            imageStore(u_columns_img, at, vec4(kMeans ? old_mean : light, 0.0));
        old_sigma_t = sigma_t;
        old_source = source;
        old_emission = emission;
        across += d.slope;
        along += d.forward;
    }
}
