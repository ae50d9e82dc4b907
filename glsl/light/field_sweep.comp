// Carries light through the lattice along each way of a batch: what came is dimmed and what is scattered or emitted on
// the way added.
//   in   sigma_t and emission; what scatters at each node; what comes in at the lattice's faces; what surfaces cross
//   out  radiance [W/m^2/sr]
#include "light/field.glsl"
#include "light/field_source.glsl"
#include "light/media_ends.glsl"

// Variant
const bool kEmits = false;     // the media emit
const bool kScatters = false;  // and scatter
const bool kComes = false;     // light comes from beyond the lattice
const bool kMeans = false;     // out: the mean over what lies between a node and its neighbours, by what dims there. It
                               // times sigma_t is all that the medium takes in, however thick it is.
const bool kTaken = false;     // as much as a node takes in on either side it sends out there. Were both sides to count
                               // alike, then in the rim of thick smoke it would send out less: of white smoke whose
                               // lumps are no larger than a cell a fifth of the light is lost.
const bool kLooked = false;    // out: for places between nodes. The thicker it is there, the more of that mean.
const bool kEnds = false;      // media end at faces of a box
const bool kSurfaces = false;  // surfaces stand in the way
const bool kNear = false;      // of the near ways

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1) writeonly uniform uimage3D u_ways_img;
layout(binding = FIELD_SOURCE_UNIT) uniform usampler3D u_source_tx;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;
layout(binding = FIELD_EMISSION_UNIT) uniform sampler3D u_emission_tx;
layout(binding = FIELD_LIGHT_UNIT) uniform usampler3D u_comes_tx;

const bool kAround = kMeans || kLooked;  // what lies beyond a node counts too

// What is stored of a node: a sum of light at it and on both sides of it, and of their weights.
struct Stored {
    ivec3 node;
    vec3 light;
    extinction_t weight;
    float within;  // what is left of it beside faces that media end at
};

void add(inout Stored stored, vec3 light, extinction_t weight)
{
    stored.light += weight * light;
    stored.weight += weight;
}

void store(Stored stored, int k)
{
    ivec3 at = stored.node + way_of(k);
    imageStore(u_ways_img, at, pack_light(stored.light * stored.within / max(stored.weight, extinction_t(1e-9)), at));
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
    float gone = 0.0;
    Stored old = Stored(ivec3(0), vec3(0.0), extinction_t(0.0), 1.0);
    bool first = true;
    for (; is_in(chain, way); go_on(chain, way)) {
        ivec3 node = chain.node;
        vec4 medium = texelFetch(u_sigma_t_tx, node, 0);
        extinction_t sigma_t = extinction_t(medium.rgb);
        vec3 emission = kEmits ? texelFetch(u_emission_tx, node, 0).rgb : vec3(0.0);
        vec3 source = kScatters ? unpack_light(texelFetch(u_source_tx, node + way_of(k), 0).rg) : vec3(0.0);
        Stored stored = Stored(node, vec3(0.0), extinction_t(0.0), 1.0);
        if (chain.enters) {
            light = kComes ? unpack_light(texelFetch(u_comes_tx, node + way_of(k), 0).rg) : vec3(0.0);
            gone = 0.0;
        } else {
            gone += way.metres;
            Piece piece = piece_of(0.5 * way.metres * (sigma_t + old_sigma_t));
            vec3 emitted = 0.5 * way.metres * (emission + old_emission);
            vec3 came = light;
            light = came * piece.through + source * piece.of_end + old_source * piece.of_begin + emitted * piece.weight;
            vec3 end = mean_in(piece, came, light, emitted, 0.5 * (source + old_source));
            vec3 begin = end;  // of the mean between both nodes what each of them has
            if (kSurfaces && (kNear ? is_crossed_near(medium.a, k) : crossing_at(node, k).is_crossed)) {
                // Where on the way is not known: half of it lies behind the surface, and has what is there.
                light = 0.5 * source * piece.of_end;
                begin = came;
                end = light;
            }
            if (kAround) {
                const float kNone = 1e-9;
                extinction_t weight = kLooked || kTaken ? piece.tau + kNone : extinction_t(1.0);
                add(old, begin, weight);
                add(stored, end, weight);
            }
        }
        if (kEnds)
            stored.within = beyond_ends(node, way, sigma_t, gone, kAround ? 1.0 : 0.0, vec4(0.0)).within;
        if (!kMeans)
            add(stored, light, extinction_t(kLooked ? kPoint : 1.0));
        if (!kAround)
            store(stored, k);
        else if (!first)
            store(old, k);
        first = false;
        old = stored;
        old_sigma_t = sigma_t;
        old_source = source;
        old_emission = emission;
    }
    if (kAround && !first)
        store(old, k);
}
