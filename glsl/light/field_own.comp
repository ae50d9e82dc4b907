// How much of the light that a node scatters it gets back itself: of its mean radiance the part that is its own
// source's, by the steps of field_sweep.comp to it and away from it.
//   in   sigma_t; what surfaces cross
//   out  that part, 0..1
#include "light/field_listed.glsl"
#include "light/field_source.glsl"

const bool kSurfaces = false;  // variant: surfaces stand in the way

layout(local_size_x = VOLUME_GROUP, local_size_y = VOLUME_GROUP, local_size_z = VOLUME_GROUP) in;
layout(binding = 0) writeonly uniform image3D u_own_img;
layout(binding = FIELD_SIGMA_T_UNIT) uniform sampler3D u_sigma_t_tx;

bool is_node(ivec3 node) { return all(greaterThanEqual(node, ivec3(0))) && all(lessThan(node, node_count())); }

extinction_t sigma_t_at(ivec3 node) { return extinction_t(texelFetch(u_sigma_t_tx, node, 0).rgb); }

void main()
{
    ivec3 node = own_node();
    if (any(greaterThanEqual(node, node_count())))
        return;
    extinction_t sigma_t = sigma_t_at(node);
    vec3 own = vec3(0.0);
    for (int k = 0; k < u_field.count; ++k) {
        FieldWay way = u_field.ways[k];
        ivec3 step = from_axes(way.axis, ivec3(way.forward, floor(way.slope + 0.5)));
        float parts = 0.0;
        vec3 part = vec3(0.0);
        vec3 came = vec3(0.0);
        if (is_node(node - step)) {
            Piece piece = piece_of(0.5 * way.metres * (sigma_t + sigma_t_at(node - step)));
            bool is_cut = kSurfaces && crossing_at(node, k).is_crossed;
            came = vec3(is_cut ? 0.5 * piece.of_end : piece.of_end);
            part += is_cut ? came : mean_in(piece, vec3(0.0), came, vec3(0.0), vec3(0.5));
            parts += 1.0;
        }
        if (is_node(node + step)) {
            Piece piece = piece_of(0.5 * way.metres * (sigma_t + sigma_t_at(node + step)));
            vec3 left = came * piece.through + vec3(piece.of_begin);
            bool is_cut = kSurfaces && crossing_at(node + step, k).is_crossed;
            part += is_cut ? came : mean_in(piece, came, left, vec3(0.0), vec3(0.5));
            parts += 1.0;
        }
        own += part * (way.solid_angle / (4.0 * 3.14159265) / max(parts, 1.0));
    }
    imageStore(u_own_img, node, vec4(own, 0.0));
}
