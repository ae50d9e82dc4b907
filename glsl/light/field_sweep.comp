// Carries light through the lattice along each way of a batch: what came is dimmed and what is scattered or emitted on
// the way added.
//   in   sigma_t and emission; what scatters at each node; what surfaces cross
//   out  radiance [W/m^2/sr]
#include "light/field.glsl"
#include "light/field_source.glsl"

// Variant
const bool kEmits = false;     // the media emit
const bool kScatters = false;  // and scatter
const bool kMeans = false;     // out: the mean over what lies between a node and its neighbours, by what dims there. It
                               // times sigma_t is all that the medium takes in, however thick it is.
const bool kSurfaces = false;  // surfaces stand in the way
const bool kNear = false;      // of the near ways

const bool kTaken = false;  // as much as a node takes in on either side it sends out there

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) writeonly uniform uimage3D u_ways_img;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;

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
    extinction_t old_tau = extinction_t(0.0);
    ivec3 old_node = ivec3(0);
    bool first = true, alone = true;
    for (; is_in(chain, way); go_on(chain, way)) {
        ivec3 node = chain.node;
        vec4 medium = texelFetch(u_sigma_t_tx, node, 0);
        extinction_t sigma_t = extinction_t(medium.rgb);
        vec3 emission = kEmits ? texelFetch(u_emission_tx, node, 0).rgb : vec3(0.0);
        vec3 source = kScatters ? unpack_light(texelFetch(u_source_tx, node + way_of(k), 0).rg) : vec3(0.0);
        vec3 mean = vec3(0.0);   // between the one before and this one, as this one has it
        vec3 begin = vec3(0.0);  // and as that one has it
        extinction_t tau = extinction_t(0.0);
        if (chain.enters) {
            light = vec3(0.0);
        } else {
            tau = 0.5 * way.metres * (sigma_t + old_sigma_t);
            Piece piece = piece_of(tau);
            vec3 emitted = 0.5 * way.metres * (emission + old_emission);
            vec3 came = light;
            light = came * piece.through + source * piece.of_end + old_source * piece.of_begin + emitted * piece.weight;
            mean = mean_in(piece, came, light, emitted, 0.5 * (source + old_source));
            begin = mean;
            if (kSurfaces && (kNear ? is_crossed_near(medium.a, k) : crossing_at(node, k).is_crossed)) {
                // Where on the way is not known: half of it lies behind the surface, and has what is there.
                light = 0.5 * source * piece.of_end;
                begin = came;
                mean = light;
            }
        }
        if (kMeans) {
            if (!first)
                imageStore(
                    u_ways_img, old_node + way_of(k),
                    pack_light(chain.enters ? old_mean
                               : alone      ? begin
                                       : mix(old_mean, begin, kTaken ? part_of_side(tau, old_tau) : extinction_t(0.5)),
                               old_node + way_of(k)));
            alone = chain.enters;
            old_mean = mean;
            old_tau = tau;
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
