// Carries light through the lattice along each way of a batch: what came is dimmed and what is scattered or emitted on
// the way added.
//   in   sigma_t and emission; what scatters at each node; what surfaces cross
//   out  radiance [W/m^2/sr]
// The source is linear in optical depth between nodes: Olson and Kunasz 1987, "Short characteristic solution of the
// non-LTE line transfer problem", sec. 3.
#include "light/field.glsl"
#include "lib/slab.glsl"

// Variant. extinction_t: a vec3 where the scene has coloured extinction, else one number.
const bool kEmits = false;     // the media emit
const bool kScatters = false;  // and scatter
const bool kMeans = false;     // out: the mean over what lies between a node and its neighbours, by what dims there. It
                               // times sigma_t is all that the medium takes in, however thick it is.
const bool kSurfaces = false;  // surfaces stand in the way

layout(local_size_x = 8, local_size_y = 8) in;
layout(r32ui, binding = 1) writeonly uniform uimage3D u_ways_img;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;

// `thick`, or `thin` where tau is less than `end`.
float chosen(float thick, float thin, float tau, float end) { return tau < end ? thin : thick; }
vec3 chosen(vec3 thick, vec3 thin, float tau, float end) { return tau < end ? thin : thick; }
vec3 chosen(vec3 thick, vec3 thin, vec3 tau, float end) { return mix(thick, thin, lessThan(tau, vec3(end))); }

// Of a source that grows from 0 to 1 over tau, what gets to its end; mean: slab_weight(tau).
extinction_t share_of_end(extinction_t tau, extinction_t mean)
{
    extinction_t series = tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))));
    return chosen(1.0 - mean, series, tau, 0.1);
}

void main()
{
    int k = int(gl_GlobalInvocationID.z);
    FieldWay way = u_field.ways[k];
    Chain chain = first_of_chain(way, ivec2(gl_GlobalInvocationID.xy));
    vec3 light = vec3(0.0);
    extinction_t old_sigma_t = extinction_t(0.0);
    vec3 old_source = vec3(0.0);
    vec3 old_emission = vec3(0.0);
    vec3 old_mean = vec3(0.0);
    ivec3 old_node = ivec3(0);
    bool first = true, alone = true;
    for (; is_in(chain, way); go_on(chain, way)) {
        ivec3 node = chain.node;
        extinction_t sigma_t = extinction_t(texelFetch(u_sigma_t_tx, node, 0).rgb);
        vec3 emission = kEmits ? texelFetch(u_emission_tx, node, 0).rgb : vec3(0.0);
        vec3 source = kScatters ? unpack_light(texelFetch(u_source_tx, node + way_of(k), 0).r) : vec3(0.0);
        vec3 mean = vec3(0.0);   // between the one before and this one, as this one has it
        vec3 begin = vec3(0.0);  // and as that one has it
        if (chain.enters) {
            light = vec3(0.0);
        } else {
            extinction_t tau = 0.5 * way.metres * (sigma_t + old_sigma_t);
            extinction_t weight = slab_weight(tau);
            extinction_t through = exp(-tau);
            extinction_t of_end = share_of_end(tau, weight);
            vec3 emitted = 0.5 * way.metres * (emission + old_emission);
            vec3 added = source * of_end + old_source * (1.0 - through - of_end) + emitted * weight;
            vec3 came = light;
            light = came * through + added;
            vec3 taken = (came - light + emitted) / max(tau, 1e-6) + 0.5 * (source + old_source);
            mean = chosen(taken, 0.5 * (came + light), tau, 0.05);
            begin = mean;
            if (kSurfaces && is_crossed(node, k)) {
                // Where on the way is not known: half of it lies behind the surface, and has what is there.
                light = 0.5 * source * of_end;
                begin = came;
                mean = light;
            }
        }
        if (kMeans) {
            if (!first)
                imageStore(u_ways_img, old_node + way_of(k),
                           pack_light(chain.enters ? old_mean
                                      : alone      ? begin
                                                   : 0.5 * (begin + old_mean),
                                      old_node + way_of(k)));
            alone = chain.enters;
            old_mean = mean;
        } else {
            imageStore(u_ways_img, node + way_of(k), pack_light(light, node + way_of(k)));
        }
        first = false;
        old_node = node;
        old_sigma_t = sigma_t;
        old_source = source;
        old_emission = emission;
    }
    if (kMeans && !first)
        imageStore(u_ways_img, old_node + way_of(k), pack_light(old_mean, old_node + way_of(k)));
}
