// What is kept of light on its way through the media: optical depth towards each light, and the world's
// light from all around. Filled by glsl/light.
#include "lib/lattice.glsl"
#include "lib/walls.glsl"
#include "scene/light_volumes_block.glsl"
#include "scene/lights.glsl"
#include "scene/media.glsl"

// Variant. VOLUME_RGB: marched media differ in the colour of their extinction, so three numbers are stored;
// else one, and extinction_color makes a colour of it.
const bool kDepthVolume = false;   // the marched media's optical depth towards each light is in a volume
const bool kPackedDepths = false;  // which has those of four lights in a texel
const bool kWorldVolume = false;   // what the media scatter of the world's light is in a volume
const bool kWorldWalls = false;    // whose last two layers are the walls between its nodes
const bool kAmidVolume = false;    // what is marched lies amid wider media, and has such a volume of its own
const bool kAmidFlames = false;    // which has the light of flames too, in the place of points that stand for them

layout(binding = DEPTH_VOLUME_UNIT) uniform sampler3D u_depth_volume_tx;
layout(binding = WORLD_VOLUME_UNIT) uniform sampler3D u_world_volume_tx;
layout(binding = AMID_VOLUME_UNIT) uniform sampler3D u_amid_volume_tx;

#ifdef VOLUME_RGB
#define volume_t vec3
vec3 volume_value(vec4 texel) { return texel.rgb; }
vec3 from_volume(vec3 stored, vec4 color) { return stored; }
#else
#define volume_t float
float volume_value(vec4 texel) { return texel.r; }
extinction_t from_volume(float stored, vec4 color) { return extinction_of(color) * stored; }
#endif
extinction_t from_volume(volume_t stored) { return extinction_t(from_volume(stored, u_volumes.extinction_color)); }

// What a layer of the volume of depths holds at a point of its lattice, given in nodes.
vec4 depth_texel(int layer, vec3 node)
{
    if (kLightPoints > 1)
        node.z += float(layer) * (u_volumes.depth_period.z + 1.0);
    vec3 scale = u_volumes.depth.inverse_size;
    if (kPackedDepths)
        scale.z = u_volumes.packed_scale;
    return textureLod(u_depth_volume_tx, (node + 0.5) * scale, 0.0);
}

// kPackedDepths: suns have a layer each, then come points and spots in fours, then the points of areas.
int packed_layer(int i)
{
    int placed = i - kSunCount;
    if (placed < kPlacedCount)
        return i < kSunCount ? i : kSunCount + placed / 4;
    return kSunCount + (kPlacedCount + 3) / 4 + (placed - kPlacedCount) / 4;
}

int packed_channel(int i)
{
    int placed = i - kSunCount;
    return i < kSunCount ? 0 : (placed < kPlacedCount ? placed : placed - kPlacedCount) & 3;
}

// kPackedDepths: of the four lights whose first is i.
vec4 packed_depths(int i, vec3 node)
{
    return depth_texel(packed_layer(i), clamp(node, vec3(0.0), u_volumes.depth.last));
}

// Where a point is in the columns of sun i, and a way, which add up along a line. One matrix and a fract() find the texel.
vec4 sun_column(int i, vec3 p) { return u_volumes.suns[i].column_from_world * vec4(p, 1.0); }
vec4 sun_column_way(int i, vec3 d) { return u_volumes.suns[i].column_from_world * vec4(d, 0.0); }

// Of its layer: the texture coordinates of its columns' first, and of their period.
struct SunLayer {
    vec3 first, period;
};

SunLayer sun_layer(int i)
{
    SunLayer layer = SunLayer(u_volumes.suns[i].first, u_volumes.period_size);
    if (kPackedDepths) {
        layer.first.z = u_volumes.suns[i].first_z;
        layer.period.z = u_volumes.packed_period_z;
    }
    return layer;
}

// What is stored of the marched media between a sun and a point of the lattice, given by its columns.
volume_t stored_of_sun(SunLayer layer, vec3 column)
{
    vec4 texel = textureLod(u_depth_volume_tx, fract(column) * layer.period + layer.first, 0.0);
    return kPackedDepths ? volume_t(texel.r) : volume_value(texel);
}

// The way of a point, which may be outside of the lattice, to a sun.
struct SunWay {
    vec4 column;
    vec3 enters, across;  // planes where it comes into the lattice's range along each axis, and from there to its end
    vec3 towards;         // what a plane adds to the column
    SunLayer layer;
};

SunWay sun_way(int i, vec3 p)
{
    SunLookup sun = u_volumes.suns[i];
    vec4 column = sun_column(i, p);
    return SunWay(column, column.xyz * sun.per_period + sun.enters, sun.across, sun.towards, sun_layer(i));
}

// What is stored of it: outside nothing is marched, so a point has the optical depth of where its way comes in.
volume_t stored_on_way(SunWay way)
{
    vec3 leaves = way.enters + way.across;
    float plane = max(max(way.column.w, way.enters.x), max(way.enters.y, way.enters.z));
    bool crosses = plane < min(leaves.x, min(leaves.y, leaves.z));
    volume_t stored = stored_of_sun(way.layer, way.column.xyz + way.towards * (plane - way.column.w));
    return crosses ? stored : volume_t(0.0);
}

// The same of light i, which has a place. The point is given in nodes.
volume_t stored_of_placed(int i, vec3 node)
{
    node = clamp(node, vec3(0.0), u_volumes.depth.last);
    if (kPackedDepths)
        return volume_t(depth_texel(packed_layer(i), node)[packed_channel(i)]);
    return volume_value(depth_texel(i, node));
}

// The marched media's optical depth between p and light i.
extinction_t marched_to_light(int i, vec3 p, LightSample light)
{
    if (!kDepthVolume)
        return marched_depth(p, light.wi, light.range, int(u_frame.shadow_steps));
    if (light.is_sun)
        return from_volume(stored_on_way(sun_way(i, p)));
    // As of a sun: where its way comes in.
    vec2 t = lattice_segment(u_volumes.depth, p, light.wi, light.range);
    volume_t stored = volume_t(0.0);
    if (t.x < t.y)
        stored = stored_of_placed(i, node_at(u_volumes.depth, p + light.wi * t.x));
    return from_volume(stored);
}

// All media's.
extinction_t depth_to_light(int i, vec3 p, LightSample light)
{
    return closed_depth(p, light.wi, light.range) + marched_to_light(i, p, light);
}

// What of it dims a light that the media scatter at p.
extinction_t dimming_to_light(int i, vec3 p, LightSample light)
{
    return closed_dimming(p, light.wi, light.range) + u_media.marched_light_dimming * marched_to_light(i, p, light);
}

// The world's light towards the eye is kept by its fourth root: of light that falls off by e within a node a straight
// line has 8 % too much, of its fourth root 2 %.
vec3 root_of_light(vec3 radiance) { return sqrt(sqrt(radiance)); }
vec3 light_of_root(vec3 root)
{
    root *= root;
    return root * root;
}

// The world's light scattered towards the eye at `uvw` of the first layer, per metre and unit of sigma_s. Alpha is 0 in
// nodes that no light reaches, inside of surfaces: they are left out of the mean of eight.
//   layer  from one layer to the next, along z
vec3 light_towards_eye(sampler3D volume_tx, vec3 uvw, float layer, float g)
{
    vec4 light = textureLod(volume_tx, uvw, 0.0);
    if (!kMixedG)
        return light_of_root(light.rgb / max(light.a, 1e-3));
    vec3 radiance = light.rgb;
    float weight = 1.0;
    for (int l = 1; l < 4; ++l) {
        weight *= g;
        uvw.z += layer;
        radiance += weight * textureLod(volume_tx, uvw, 0.0).rgb;
    }
    // What bands 0 to 3 leave of a sharp edge may dip below 0.
    return max(radiance, vec3(0.0)) / max(light.a, 1e-3);
}

// The same in the volume of a lattice.
vec3 layer_towards_eye(sampler3D volume_tx, LatticeParams lattice, vec3 uvw, float g)
{
    if (kMixedG)
        uvw = in_layer(lattice, uvw, 0);
    return light_towards_eye(volume_tx, uvw, (lattice.last.z + 1.0) * lattice.inverse_size.z, g);
}

vec3 world_in_scattering(vec3 uvw, float g)
{
    if (kWorldWalls) {
        LatticeParams lattice = u_volumes.world;
        ivec3 first = ivec3(0, 0, (int(lattice.layers) - 2) * (int(lattice.last.z) + 1));
        Walls walls;
        uvw = on_own_side(u_world_volume_tx, first, lattice.last, uvw / lattice.inverse_size - 0.5, walls);
        uvw = (uvw + 0.5) * lattice.inverse_size;
    }
    return layer_towards_eye(u_world_volume_tx, u_volumes.world, uvw, g);
}

// How much of the light is that of the volume amid the media: none beyond its faces, all of it from a rim on.
//   node  where, in nodes of that volume
float amid_share(vec3 node)
{
    vec3 depth = min(node * u_volumes.amid_per_low_rim, (u_volumes.amid.last - node) * u_volumes.amid_per_high_rim);
    return clamp(min(depth.x, min(depth.y, depth.z)), 0.0, 1.0);
}

// Of point i, where that volume has the light of flames.
float point_share(int i, vec3 node)
{
    bool is_flame = kAmidFlames && i >= u_volumes.first_flame && i < u_volumes.beyond_flame;
    return is_flame ? 1.0 - amid_share(node) : 1.0;
}

vec3 amid_in_scattering(vec3 node, float g)
{
    return layer_towards_eye(u_amid_volume_tx, u_volumes.amid, (node + 0.5) * u_volumes.amid.inverse_size, g);
}
