// Light that media scatter towards the eye at points of a line: every light and the world, once.
#include "lib/aureole.glsl"
#include "lib/channels.glsl"
#include "lib/phase.glsl"
#include "lib/falloff.glsl"
#include "shared/step_tile.h"
#include "scene/frame.glsl"
#include "scene/light_volumes.glsl"

// Variant
const bool kVolumeShadows = false;  // media dim the light on its way to the point
const bool kDepthAtPoint = false;   // light_depth() is the depth volume's at the point: all that scatters is in it
const bool kWorldLight = false;     // the world's light scatters too: its mean, undimmed, isotropic, unless in a volume
const int kShadowTaps = 1;          // of a step, by which a sun's shadow is looked up
const bool kSteepSuns = false;      // around a sun in view, where a cosine has too few digits
const bool kShadeOverStep = false;  // a step takes the mean of what media dim of suns and points
const bool kExactFalloff = false;   // a step takes the mean of 1/d^2 over its length, not that at its sample
const bool kShadedPoints = false;   // kFarPoints: g_shaded_points says which of them surfaces may hide from a line
const bool kFarPoints = false;      // where every light that has a place is far from each step, against its length
const bool kAureole = false;        // lights are dimmed without what is scattered straight on

// As tile_shaded_points() of shared/step_tile.h has them, which are the same all over a tile.
uint g_shaded_points;

// The media's optical depth that dims light i at p: a function of who includes this.
extinction_t light_depth(int i, vec3 p, LightSample light);

// A line, and all that its points are looked up by: what is the same along it, and what grows evenly with t,
// as begin + t * slope. Worked out once a line: few compilers take it out of a loop by themselves.
struct LightLine {
    Ray ray;
    vec3 wo;                      // unit length, to the eye
    vec3 sun[max(kSunCount, 1)];  // what it scatters if nothing hides or dims it; kMixedG, kAureole: its irradiance
    Aureole aureole[kAureole ? max(kSunCount, 1) : 1];
    float peak_g, peak_straight;
    vec3 shadow[max(kSunCount, 1)], dshadow[max(kSunCount, 1)];   // its inner shadow view, of all media: uv, depth
    vec3 column[max(kSunCount, 1)], dcolumn[max(kSunCount, 1)];   // its columns in the depth volume
    SunLayer layer[max(kSunCount, 1)];                            // which have this part of it
    extinction_t dimming;                                         // of what is stored there
    vec3 depth, ddepth;                                           // of others: in nodes of that volume
    vec3 world, dworld;                                           // and of the world's
    vec3 amid, damid;                                             // in nodes of the volume amid the media
    vec3 point[max(kPointCount, 1)], power[max(kPointCount, 1)];  // points: where they are [m], and their intensity
    vec2 placed[max(kPlacedCount, 1)];  // kExactFalloff: t nearest to a light that has a place, and how far it is [m]
};

float phase_at(float cos_theta, float g)
{
    if (kIsotropic)
        return phase_isotropic();
    float g_clamp = u_frame.g_clamp;
    return phase_henyey_greenstein(cos_theta, clamp(g, -g_clamp, g_clamp));
}

float phase_of(LightSample light, vec3 wo, float g)
{
    if (kSteepSuns)
        return phase_henyey_greenstein(light.wi, wo, clamp(g, -u_frame.g_clamp, u_frame.g_clamp));
    return phase_at(dot(-light.wi, wo), g);
}
vec3 scattered_open(LightSample light, vec3 wo, float g) { return light.irradiance * phase_of(light, wo, g); }

// wo: unit length, to the eye. spread: how wide the square is that the line stands for, at its origin and more
// of it per unit of t [m].
LightLine light_line(Ray ray, vec3 wo, vec2 spread)
{
    LightLine line;
    line.ray = ray;
    line.wo = wo;
    line.peak_g = kAureole ? u_media.peak_g : 0.0;
    line.peak_straight = kAureole ? u_media.peak_straight : 0.0;
    for (int i = 0; i < kSunCount; ++i) {
        line.sun[i] = u_lights.lights[i].intensity;
        if (kAureole) {
            vec3 chord = sun_sample(i, vec3(0.0)).wi + wo;
            line.aureole[i] = aureole_of(dot(chord, chord), min(u_media.peak_g, u_frame.g_clamp));
        } else if (!kMixedG) {
            line.sun[i] *= phase_of(sun_sample(i, vec3(0.0)), wo, u_media.media[0].g);
        }
        if (kSurfaceShadows) {
            ShadowView view = u_lights.views[int(u_lights.lights[i].first_view)];
            line.shadow[i] = vec3((view.clip_from_world * vec4(ray.origin, 1.0)).xy * 0.5 + 0.5,
                                  dot(ray.origin - view.depth.origin, view.depth.travel) * view.depth.inverse_range);
            line.dshadow[i] = vec3((view.clip_from_world * vec4(ray.direction, 0.0)).xy * 0.5,
                                   dot(ray.direction, view.depth.travel) * view.depth.inverse_range);
        }
        if (kDepthVolume) {
            line.column[i] = sun_column(i, ray.origin).xyz;
            line.dcolumn[i] = sun_column_way(i, ray.direction).xyz;
            line.layer[i] = sun_layer(i);
        }
    }
    if (kDepthVolume) {
        line.dimming = u_media.marched_light_dimming * from_volume(volume_t(1.0));
        line.depth = node_at(u_volumes.depth, ray.origin);
        line.ddepth = node_way(u_volumes.depth, ray.direction);
    }
    if (kWorldVolume) {
        line.world = first_layer_at(u_volumes.world, ray.origin);
        line.dworld = first_layer_way(u_volumes.world, ray.direction);
    }
    if (kAmidVolume) {
        line.amid = node_at(u_volumes.amid, ray.origin);
        line.damid = node_way(u_volumes.amid, ray.direction);
    }
    for (int i = 0; i < kPointCount; ++i) {
        line.point[i] = u_lights.lights[kSunCount + i].position;
        line.power[i] = u_lights.lights[kSunCount + i].intensity;
    }
    for (int i = 0; kExactFalloff && i < kPlacedCount; ++i) {
        vec3 to_light = u_lights.lights[kSunCount + i].position - ray.origin;
        float t = dot(to_light, ray.direction) / dot(ray.direction, ray.direction);
        vec3 from_line = to_light - ray.direction * t;
        float disc = inversesqrt(kPi) * max(spread.x + spread.y * t, 0.0);  // as large as the square
        if (kFlames)
            disc = length(vec2(disc, flame_radius(kSunCount + i)));
        line.placed[i] = vec2(t, max(distance_of_disc(dot(from_line, from_line), disc), kLeastRange));
    }
    return line;
}

// The optical depth that dims a light on its way to p, kDepthAtPoint: stored is the marched ones' depth, as it is in the
// volume.
extinction_t depth_of(vec3 p, LightLine line, LightSample light, volume_t stored)
{
    return closed_dimming(p, light.wi, light.range) + line.dimming * stored;
}

// The optical depth that dims light i on its way to t of the line.
extinction_t dimming_on(int i, LightLine line, float t, LightSample light)
{
    vec3 p = line.ray.origin + line.ray.direction * t;
    if (kDepthAtPoint)
        return depth_of(p, line, light,
                        light.is_sun ? stored_of_sun(line.layer[i], line.column[i] + line.dcolumn[i] * t)
                                     : stored_of_placed(i, line.depth + line.ddepth * t));
    return light_depth(i, p, light);
}

// What the media let through of it.
vec3 volume_shadow(int i, LightLine line, float t, LightSample light)
{
    return kVolumeShadows ? vec3(exp(-dimming_on(i, line, t, light))) : vec3(1.0);
}

// The mean over a step of the phase of a light that has a place, weighted as its light is: evenly in the angle.
// Past a light that is near it swings from one end of the phase to the other within a step. Gauss and
// Legendre's three points.
float phase_over(Falloff falloff, float g)
{
    if (kIsotropic)
        return phase_isotropic();
    float middle = falloff.begin + 0.5 * falloff.angle;
    float reach = 0.3872983346 * falloff.angle;
    return (4.0 * phase_at(-sin(middle), g) +
            2.5 * (phase_at(-sin(middle - reach), g) + phase_at(-sin(middle + reach), g))) /
           9.0;
}

LightSample line_point(int i, LightLine line, vec3 p)
{
    // Over a step it is the distance to the line that a flame keeps.
    float radius = kExactFalloff ? 0.0 : flame_radius(i);
    return sample_of(line.point[i - kSunCount], line.power[i - kSunCount], radius, p);
}

// A piece of a line whose light is asked for at one point of it.
struct LightStep {
    float t;               // of the point
    vec2 ends;             // t of the piece
    float share;           // of its length that lies before t
    float g;               // of the medium there
    extinction_t sigma_t;  // [1/m]
    float to_eye;          // kAureole: optical depth from the eye to the point of what is scattered straight on
};

// Where a light that has a place is looked up: at the point or, kExactFalloff, where the piece has its light.
float place_of_light(int i, LightLine line, LightStep step, out Falloff over)
{
    if (!kExactFalloff)
        return step.t;
    vec2 nearest = line.placed[i - kSunCount];
    float metres = length(line.ray.direction);
    vec2 s = (step.ends - nearest.x) * metres;
    over = falloff_over(s, nearest.y, step.share);
    return nearest.x + over.place / metres;
}

// Likewise of the phase times what the media let through, kShadeOverStep: past a light that is near, the way to it grows
// and shrinks within a step as well. With what the step lets through of itself, over the mean that its slab has of that.
vec3 seen_over(int i, LightLine line, LightStep step, Falloff falloff)
{
    // Gauss and Legendre's five points.
    const float kPlaces[5] = float[](-0.9061798459, -0.5384693101, 0.0, 0.5384693101, 0.9061798459);
    const float kWeights[5] = float[](0.1184634425, 0.2393143352, 0.2844444444, 0.2393143352, 0.1184634425);
    vec2 nearest = line.placed[i - kSunCount];
    float metres = length(line.ray.direction);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 5; ++k) {
        float angle = falloff.begin + falloff.angle * (0.5 + 0.5 * kPlaces[k]);
        float t = clamp(nearest.x + nearest.y * tan(angle) / metres, step.ends.x, step.ends.y);
        vec3 p = line.ray.origin + line.ray.direction * t;
        extinction_t depth = light_depth(i, p, line_point(i, line, p)) + step.sigma_t * ((t - step.ends.x) * metres);
        sum += kWeights[k] * phase_at(-sin(angle), step.g) * exp(-depth);
    }
    return sum / slab_weight(step.sigma_t * ((step.ends.y - step.ends.x) * metres));
}

// Of its irradiance there: times the phase, and, kExactFalloff, as the piece has them on average, times what sigma_t
// leaves of a piece's light between where this light has its middle and the piece's own.
vec3 scattered_of(LightSample light, LightLine line, LightStep step, Falloff over)
{
    if (!kExactFalloff)
        return light.irradiance * phase_of(light, line.wo, step.g);
    return light.irradiance *
           (over.mean * light.range * light.range * phase_over(over, step.g) * exp(-step.sigma_t * over.ahead));
}

// kAureole: how much of what is scattered where the media have a mean g of g is by the one with the strong lobe, if the
// others have none.
float peaked_share(LightLine line, float g) { return kMixedG ? clamp(g / line.peak_g, 0.0, 1.0) : 1.0; }

// kAureole: the phase of sun i at a step, whose light is dimmed by depth on its way to it.
float aureole_at(int i, LightLine line, LightStep step, LightSample light, float depth)
{
    if (!kAureole)
        return 1.0;
    float straight = depth * line.peak_straight;
    if (kMixedG) {  // others may dim, and scatter nothing straight on
        vec3 p = line.ray.origin + line.ray.direction * step.t;
        float closed = mean(closed_dimming(p, light.wi, light.range));
        straight = mean(closed_depth(p, light.wi, light.range)) - closed +
                   (depth - closed) * (1.0 / max(u_media.marched_light_dimming, 1e-6) - 1.0);
    }
    float phase = aureole_phase(line.aureole[i], straight, step.to_eye);
    if (kMixedG)
        phase =
            max(phase_of(light, line.wo, step.g) + peaked_share(line, step.g) * (phase - line.aureole[i].once), 0.0);
    return phase;
}

// What the media let through of sun i to a step, on its mean: as exp of a depth that grows evenly from one end of the
// step to the other, weighted by what the step lets through of itself.
// kAureole: times the phase.
vec3 sun_through_media(int i, LightLine line, LightStep step, LightSample light)
{
    if (!kVolumeShadows)
        return vec3(1.0);
    if (!kShadeOverStep) {
        extinction_t depth = dimming_on(i, line, step.t, light);
        return vec3(exp(-depth)) * aureole_at(i, line, step, light, mean(depth));
    }
    extinction_t near = light_depth(i, line.ray.origin + line.ray.direction * step.ends.x, light);
    extinction_t far = light_depth(i, line.ray.origin + line.ray.direction * step.ends.y, light);
    extinction_t own = step.sigma_t * ((step.ends.y - step.ends.x) * length(line.ray.direction));
    far += own;
    float aureole = aureole_at(i, line, step, light, mix(mean(near), mean(far - own), step.share));
    // From the end that is dimmed the less: the other's exp may be too large for a float.
    return vec3(exp(-min(near, far)) * slab_weight(abs(far - near)) / slab_weight(own)) * aureole;
}

// t where a step is asked for a sun's shadow the k-th time: each in a part of its own, as the point is in the whole.
float shadow_tap(LightStep step, int k)
{
    if (kShadowTaps == 1)
        return step.t;
    return mix(step.ends.x, step.ends.y, (float(k) + step.share) / float(kShadowTaps));
}

void add_sun(inout vec3 sum, int i, LightLine line, LightStep step)
{
    LightSample light = sun_sample(i, vec3(0.0));
    vec3 arriving = line.sun[i];
    if (kMixedG && !kAureole)
        arriving *= phase_of(light, line.wo, step.g);
    if (kLightFilters) {
        vec3 passed = vec3(0.0);
        for (int k = 0; k < kShadowTaps; ++k) {
            float t = shadow_tap(step, k);
            vec3 shadow = line.shadow[i] + line.dshadow[i] * t;
            float visible = visibility_in(int(u_lights.lights[i].first_view), shadow.xy, shadow.z);
            passed += visible * filter_in_medium(i, line.ray.origin + line.ray.direction * t);
        }
        arriving *= passed / float(kShadowTaps);
    } else if (kSurfaceShadows) {
        float visible = 0.0;
        for (int k = 0; k < kShadowTaps; ++k) {
            vec3 shadow = line.shadow[i] + line.dshadow[i] * shadow_tap(step, k);
            visible += visibility_in(int(u_lights.lights[i].first_view), shadow.xy, shadow.z);
        }
        arriving *= visible / float(kShadowTaps);
    }
    sum += arriving * sun_through_media(i, line, step, light);
}

void add_point(inout vec3 sum, int i, LightLine line, LightStep step)
{
    Falloff over;
    float t = place_of_light(i, line, step, over);
    vec3 p = line.ray.origin + line.ray.direction * t;
    LightSample light = line_point(i, line, p);
    const bool kSeenOver = kExactFalloff && kVolumeShadows && kShadeOverStep;
    vec3 arriving;
    if (kSeenOver)
        arriving = light.irradiance * (over.mean * light.range * light.range) * seen_over(i, line, step, over);
    else
        arriving = scattered_of(light, line, step, over);
    if (kSurfaceShadows)
        arriving *= point_visibility(i, p, light);
    if (kLightFilters)
        arriving *= filter_in_medium(i, p);
    if (!kSeenOver)
        arriving *= volume_shadow(i, line, t, light);
    sum += arriving * point_share(i, line.amid + line.damid * step.t);
}

// The light of a point that is far from the step: kFarPoints. 1/d^2 over the step is a parabola around its middle, by the
// second derivative, and the phase is the middle's. With x of half the step over the distance the next term is below
// x^4, which is 2.5e-4 where a light counts as far. By cos^2 and no angle: no atan, log, sin or cos, which exact falloff has.
vec3 scattered_far(int i, LightLine line, LightStep step)
{
    float middle = 0.5 * (step.ends.x + step.ends.y);
    vec3 to_light = line.point[i - kSunCount] - line.ray.origin - line.ray.direction * middle;
    float half_step = 0.5 * (step.ends.y - step.ends.x) * length(line.ray.direction);
    float least = max(kLeastRange, flame_radius(i));
    float inverse_range2 = 1.0 / max(dot(to_light, to_light), least * least);
    float inverse_range = sqrt(inverse_range2);
    float cosine = -dot(to_light, line.wo) * inverse_range;
    float x2 = half_step * half_step * inverse_range2;
    float mean = inverse_range2 * (1.0 + x2 * (4.0 * cosine * cosine - 1.0) / 3.0);
    // How far the mean place of that light lies beyond the middle, towards the lamp.
    float ahead = 2.0 / 3.0 * cosine * x2 / inverse_range;
    return line.power[i - kSunCount] * mean * phase_at(cosine, step.g) *
           max(1.0 - vec3(step.sigma_t) * ahead, 0.0);  // of the exp, and of no step that is opaque
}

// What surfaces let through of points first to beyond - 1 where few of them can be hidden. A loop that takes as many turns
// as there are: llvmpipe looks up whatever is in an if, taken or not.
void see_points(out float visible[max(kPointCount, 1)], int first, int beyond, vec3 p)
{
    for (int k = 0; k < beyond - first; ++k)
        visible[k] = 1.0;
    uint bits = g_shaded_points;
    bits = (bits | bits << uint(kTilePoints)) & ((1u << uint(beyond - first)) - 1u);
    if (bits != 0u)
        do {
            int k = findLSB(bits);
            bits &= bits - 1u;
            visible[k] = point_visibility(first + k, p, point_sample(first + k, p));
        } while (bits != 0u);
}

// Points first to beyond - 1. Where they are far all are asked at one place, and four have their depths by one fetch.
void add_points(inout vec3 sum, int first, int beyond, LightLine line, LightStep step)
{
    if (!kFarPoints) {
        for (int i = first; i < beyond; ++i)
            add_point(sum, i, line, step);
        return;
    }
    const bool kFetchesFour = kPackedDepths && kVolumeShadows && kDepthAtPoint;
    vec3 p = line.ray.origin + line.ray.direction * step.t;
    const bool kAsksFew = kSurfaceShadows && kShadedPoints;
    float visible[max(kPointCount, 1)];
    if (kAsksFew)
        see_points(visible, first, beyond, p);
    for (int four = first; four < beyond; four += 4) {
        vec4 stored = vec4(0.0);
        if (kFetchesFour)
            stored = packed_depths(four, line.depth + line.ddepth * step.t);
        for (int k = 0; k < min(beyond - four, 4); ++k) {
            int i = four + k;
            LightSample light = line_point(i, line, p);
            vec3 arriving = scattered_far(i, line, step);
            if (kAsksFew)
                arriving *= visible[i - first];
            else if (kSurfaceShadows)
                arriving *= point_visibility(i, p, light);
            if (kLightFilters)
                arriving *= filter_in_medium(i, p);
            if (kFetchesFour)
                arriving *= vec3(exp(-depth_of(p, line, light, volume_t(stored[k]))));
            else
                arriving *= volume_shadow(i, line, step.t, light);
            sum += arriving * point_share(i, line.amid + line.damid * step.t);
        }
    }
}

void add_spot(inout vec3 sum, int i, LightLine line, LightStep step)
{
    Falloff over;
    float t = place_of_light(i, line, step, over);
    vec3 p = line.ray.origin + line.ray.direction * t;
    LightSample light = spot_sample(i, p);
    vec3 arriving = scattered_of(light, line, step, over);
    if (kSurfaceShadows)
        arriving *= spot_visibility(i, p, light);
    if (kLightFilters)
        arriving *= filter_in_medium(i, p);
    sum += arriving * volume_shadow(i, line, t, light);
}

#include "written/scattering.glsl"

// Variant. ISLAND_VOLUMES: parts of the media that lie far apart have volumes of the world's light of their own.
#ifdef ISLAND_VOLUMES
#include "scene/island_light.glsl"
vec3 world_on(LightLine line, LightStep step)
{
    return island_in_scattering(line.ray.origin + line.ray.direction * step.t, step.g);
}
#else
vec3 world_on(LightLine line, LightStep step)
{
    vec3 node = line.amid + line.damid * step.t;
    float amid = kAmidVolume ? amid_share(node) : 0.0;
    vec3 light = vec3(0.0);
    if (amid < 1.0)
        light = world_in_scattering(line.world + line.dworld * step.t, step.g);
    if (kAmidVolume && amid > 0.0)
        light = mix(light, amid_in_scattering(node, step.g), amid);
    return light;
}
#endif

// Radiance scattered towards the eye, per metre of line and unit of sigma_s.
vec3 in_scattering_on(LightLine line, LightStep step)
{
    vec3 in_scattering = vec3(0.0);
    if (kWorldVolume)
        in_scattering += world_on(line, step);
    else if (kWorldLight)
        in_scattering += u_lights.world_radiance.rgb;  // 4 pi sr of it, times the isotropic 1 / (4 pi)
    add_lights(in_scattering, line, step);
    return in_scattering;
}

// The same at a point. wo: unit length, to the eye.
vec3 in_scattering_at(vec3 p, vec3 wo, float g)
{
    LightStep step = LightStep(0.0, vec2(0.0), 0.0, g, extinction_t(0.0), 0.0);
    return in_scattering_on(light_line(Ray(p, vec3(0.0)), wo, vec2(0.0)), step);
}
