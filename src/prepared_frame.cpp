#include "prepared_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "halton.h"
#include "ray_range.h"
#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// NDC depth from the depth that the buffer holds: n = x * depth + y.
glm::dvec2 ndc_from_depth(const DepthConvention& convention)
{
    return convention.zero_to_one ? glm::dvec2(1, 0) : glm::dvec2(2, -1);
}

/// view_z = (x * depth + y) / (z * depth + w). From clip z and w of a point at view depth -z:
/// n = (P22 z + P32) / (P23 z + P33), solved for -z.
glm::dvec4 view_z_from_depth(const Frame& frame)
{
    const glm::dmat4& p = frame.clip_from_view;
    const glm::dvec2 n = ndc_from_depth(frame.depth_convention);
    const glm::dvec2 top(p[3][3], -p[3][2]);  // of n: slope, constant
    const glm::dvec2 bottom(p[2][3], -p[2][2]);
    return {top.x * n.x, top.x * n.y + top.y, bottom.x * n.x, bottom.x * n.y + bottom.y};
}

double view_z_of(double depth, const glm::dvec4& map)
{
    const double bottom = map.z * depth + map.w;
    const double view_z = (map.x * depth + map.y) / bottom;
    // An infinite far plane has bottom = 0 at its depth.
    return std::isfinite(view_z) ? view_z : std::numeric_limits<double>::infinity();
}

/// @throws Error if the projection is neither perspective nor orthographic or can't be inverted.
Eye make_eye(const Frame& frame)
{
    const glm::dmat4& p = frame.clip_from_view;
    Eye eye;
    eye.world_from_view = glm::transpose(glm::dmat3(frame.view_from_world));
    eye.position = -(eye.world_from_view * glm::dvec3(frame.view_from_world[3]));
    eye.forward = -eye.world_from_view[2];
    eye.perspective = p[2][3] != 0;
    const double determinant = glm::determinant(p);
    if (!std::isfinite(determinant) || determinant == 0 || (p[2][3] == 0 && p[3][3] == 0))
        throw Error("the frame's clip_from_view is no projection: it can't be inverted; give a "
                    "perspective or an orthographic matrix");
    const glm::dvec4 map = view_z_from_depth(frame);
    const bool reversed = frame.depth_convention.reversed;
    eye.near = view_z_of(reversed ? 1 : 0, map);
    eye.far = view_z_of(reversed ? 0 : 1, map);
    if (!(eye.near < eye.far))
        throw Error("the frame's near plane is not nearer than its far plane: clip_from_view does "
                    "not match depth_convention (reversed, zero_to_one)");
    return eye;
}

/// Nearest and farthest view_z of a box [m].
glm::dvec2 view_z_range(const Eye& eye, const Bounds& bounds)
{
    glm::dvec2 range(std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity());
    for (int i = 0; i < 8; ++i) {
        const double z = glm::dot(bounds.corner(i) - eye.position, eye.forward);
        range = {std::min(range.x, z), std::max(range.y, z)};
    }
    return range;
}

/// As PreparedFrame::media_range.
glm::dvec2 media_range(const Eye& eye, const Bounds& media)
{
    if (media.empty())
        return {eye.near, eye.far};
    return glm::max(view_z_range(eye, media), glm::dvec2(eye.near));
}

/// As PreparedFrame::step_range.
glm::dvec2 step_range(const PreparedFrame& frame)
{
    const Eye& eye = frame.eye;
    if (frame.settings.range == Settings::Range::camera)
        return {eye.near, std::isfinite(eye.far) ? eye.far : frame.media_range.y};
    return frame.media_range;
}

CameraRays camera_rays(const Frame& frame, const Eye& eye)
{
    // Two points on a pixel's ray in view space; any two depths do, these are always finite.
    const glm::dmat4 view_from_clip = glm::inverse(frame.clip_from_view);
    const glm::dmat4& p = frame.clip_from_view;
    const double z0 = eye.near;
    const double z1 = eye.near + std::max(std::abs(eye.near), 1.0);
    const auto point = [&](double x, double y, double view_z) {
        const double n = (p[2][2] * -view_z + p[3][2]) / (p[2][3] * -view_z + p[3][3]);
        const glm::dvec4 h = view_from_clip * glm::dvec4(x, y, n, 1.0);
        return glm::dvec3(h) / h.w;
    };
    const auto ray = [&](double x, double y) {
        const glm::dvec3 a = point(x, y, z0);
        const glm::dvec3 direction = (point(x, y, z1) - a) / (z1 - z0);
        return std::pair{eye.world_from_view * (a - direction * z0),
                         eye.world_from_view * direction};
    };
    const auto [origin, direction] = ray(0, 0);
    const auto [origin_x, direction_x] = ray(1, 0);
    const auto [origin_y, direction_y] = ray(0, 1);
    CameraRays rays;
    rays.direction = direction;
    if (eye.perspective) {
        rays.direction_dx = direction_x - direction;
        rays.direction_dy = direction_y - direction;
    } else {
        rays.origin = origin;
        rays.origin_dx = origin_x - origin;
        rays.origin_dy = origin_y - origin;
    }
    return rays;
}

/// Whether all of the picture, and `around` pixels on each side, lie within the media's outline.
bool fills_picture(const PreparedFrame& frame, double around)
{
    const CameraRays& rays = frame.rays;
    const glm::dvec2 corner = 1.0 + 2 * around / glm::dvec2(frame.picture_size);
    for (const glm::dvec2 side : {glm::dvec2(-1, -1), {1, -1}, {-1, 1}, {1, 1}}) {
        const glm::dvec2 ndc = side * corner;
        const glm::dvec3 origin =
            frame.eye.position + rays.origin + rays.origin_dx * ndc.x + rays.origin_dy * ndc.y;
        const glm::dvec3 direction =
            rays.direction + rays.direction_dx * ndc.x + rays.direction_dy * ndc.y;
        const glm::dvec2 inside = ray_range(origin, direction, frame.media);
        if (!(std::max(inside.x, frame.eye.near) < inside.y))
            return false;
    }
    return true;
}

constexpr int kSmallLayer = 4, kUsualLayer = 2;

/// Of a texel of a quarter of the size: the angle that it spans, or metres where rays are parallel.
double quarter_texel(const PreparedFrame& frame)
{
    return kSmallLayer * 2 / (std::abs(frame.host.clip_from_view[1][1]) * frame.picture_size.y);
}

/// Metres that it spans at the media's far end.
double quarter_width(const PreparedFrame& frame)
{
    return quarter_texel(frame) * (frame.eye.perspective ? frame.media_range.y : 1);
}

/// Why a quarter of the size would lose something; smooth: it would not.
/// @param within what it may have of each limit
LayerReason lost_by_quarter(const PreparedFrame& frame, const FrameScene& scene, double within)
{
    // Shares of what a texel may span: of a phase's lobe, 1 - g radians wide, of what media change
    // within, and of the fade of a beam, whose steepest part is a third of it. What a texel leaves
    // out grows with the square of its width: at these it is less than the grain that steps leave.
    constexpr double kOfLobe = 0.05, kOfDetail = 0.25, kOfBeam = 0.1;
    // Of a grid it may span more: that is linear within a voxel already, and what it holds is
    // coarser. docs/measurements.md has what texels of other widths leave out.
    constexpr double kReach = 3;  // texels beyond the picture that its pixels are made of: guards
    const double texel = quarter_texel(frame) / within, width = quarter_width(frame) / within;
    if (frame.eye.perspective && texel > kOfLobe * (1 - scene.most_g))
        return LayerReason::lobe;
    if (width > kOfBeam * scene.beam_edge)
        return LayerReason::beam;
    if (width > kOfDetail * scene.detail)
        return LayerReason::profile;
    if (width > LayerChoice::kMostOfVoxel * scene.voxel)
        return LayerReason::voxels;
    const double beyond = kSmallLayer * kReach + (1 - within) * frame.picture_size.y;
    if (scene.has_outline && !fills_picture(frame, beyond))
        return LayerReason::outline;
    return LayerReason::smooth;
}

/// The size of the march's layer, where that is left open: a quarter where neither a medium nor its
/// light changes much within a texel of that, else half. An eye that stays about a limit would go
/// to and fro, and its layers' textures and grain with it: from half it takes a quarter only where
/// that is well within.
LayerChoice choose_layer(const PreparedFrame& frame, const FrameScene& scene, int before)
{
    constexpr double kWellWithin = 0.9;
    LayerChoice choice{kUsualLayer, lost_by_quarter(frame, scene, 1),
                       quarter_width(frame) / scene.voxel};
    if (choice.reason != LayerReason::smooth)
        return choice;
    if (before == kUsualLayer && lost_by_quarter(frame, scene, kWellWithin) != LayerReason::smooth)
        choice.reason = LayerReason::held;
    else
        choice.scale = kSmallLayer;
    return choice;
}

/// What an automatic resolution is.
LayerChoice choose_resolution(const PreparedFrame& frame, const FrameScene& scene, int before)
{
    if (frame.settings.mode == Settings::Mode::froxel)
        return {1, LayerReason::no_layer};  // and no reason to drop a history
    if (frame.keeps_history)
        return {kUsualLayer, LayerReason::history};
    return choose_layer(frame, scene, before);
}

/// As PreparedFrame::layer_guard.
int layer_guard(const FrameSettings& settings)
{
    if (settings.resolution == 1)
        return 0;
    switch (settings.upsample) {
    case Settings::Upsample::tent4x4:
        return 2;
    case Settings::Upsample::bilinear2x2:
        return 1;
    default:
        return 0;
    }
}

/// Largest value that a layer format holds.
float format_limit(Settings::Format format)
{
    switch (format) {
    case Settings::Format::r11g11b10f:
        return 64512.0f;  // of its 10-bit blue, the smaller
    case Settings::Format::rgba16f:
        return 65504.0f;
    default:
        return 1e37f;
    }
}

shared::FrameParams make_params(const PreparedFrame& frame)
{
    shared::FrameParams params{};
    const Frame& host = frame.host;
    const FrameSettings& settings = frame.settings;
    const auto vec = [](glm::dvec3 v) { return glm::vec4(glm::vec3(v), 0.0f); };
    params.ray_origin = vec(frame.rays.origin);
    params.ray_origin_dx = vec(frame.rays.origin_dx);
    params.ray_origin_dy = vec(frame.rays.origin_dy);
    params.ray_direction = vec(frame.rays.direction);
    params.ray_direction_dx = vec(frame.rays.direction_dx);
    params.ray_direction_dy = vec(frame.rays.direction_dy);

    params.view_z_from_depth = glm::vec4(view_z_from_depth(host));
    params.sky_depth = host.depth_convention.reversed ? 0.0f : 1.0f;
    params.full_size = glm::vec2(frame.picture_size);
    params.inverse_full_size = 1.0f / glm::vec2(frame.picture_size);
    params.layer_size = glm::vec2(frame.layer_size);
    params.inverse_layer_size = 1.0f / glm::vec2(frame.layer_size);
    const double scale = settings.resolution;
    const glm::dvec2 guard(frame.layer_guard);
    params.layer_offset = glm::vec2(host.layer_offset - guard);
    params.layer_offset_pixels = glm::vec2(glm::round(host.layer_offset * scale) - guard * scale);

    const glm::dvec2 steps = frame.step_range;
    params.step_range = glm::vec2(steps);
    params.media_range = glm::vec2(frame.media_range);
    params.step_octaves = static_cast<float>(std::log2(steps.y / steps.x));
    params.media_depth = static_cast<float>(depth_reach(frame.eye, frame.media_range));
    params.steps = static_cast<float>(settings.steps);
    params.distribution = frame.eye.perspective ? settings.distribution : 0.0f;
    // Frames that are averaged by us are turned by us.
    const double jitter =
        frame.keeps_history ? golden_fraction(static_cast<double>(host.index)) : host.jitter_offset;
    params.step_jitter = static_cast<float>(jitter);
    params.shadow_steps = static_cast<float>(settings.shadow_steps);
    params.min_transmittance = settings.min_transmittance;
    params.min_extinction = settings.min_extinction;
    params.g_clamp = settings.g_clamp;
    params.radiance_limit = format_limit(settings.format);
    params.depth_threshold = settings.depth_threshold;
    return params;
}

}  // namespace

ViewCone view_cone(const CameraRays& rays)
{
    ViewCone cone{glm::normalize(rays.direction)};
    for (const glm::dvec2 ndc : {glm::dvec2(-1, -1), {1, -1}, {-1, 1}, {1, 1}}) {
        const glm::dvec3 corner =
            glm::normalize(rays.direction + rays.direction_dx * ndc.x + rays.direction_dy * ndc.y);
        cone.half_angle =
            std::max(cone.half_angle, std::acos(std::min(glm::dot(cone.axis, corner), 1.0)));
    }
    return cone;
}

PreparedFrame fine_frame(const PreparedFrame& frame)
{
    PreparedFrame out = frame;
    out.fine = true;
    out.settings.resolution = 1;
    out.host.layer_offset = glm::dvec2(0);
    out.layer_guard = 0;
    out.layer_size = out.picture_size;
    out.params = make_params(out);
    return out;
}

double depth_reach(const Eye& eye, glm::dvec2 media_range)
{
    return eye.perspective ? 0.0 : std::max(media_range.y - media_range.x, 1e-30);
}

PreparedFrame prepare_frame(const Frame& frame, const FrameSettings& settings,
                            const FrameScene& scene, const ViewPast& past)
{
    PreparedFrame out;
    out.host = frame;
    out.settings = settings;
    out.keeps_history = past.keeps_history && settings.keeps_history();
    out.scene_id = scene.id;
    out.media_id = scene.media_id;
    out.life_id = scene.life_id;
    out.eye = make_eye(frame);
    out.rays = camera_rays(frame, out.eye);
    out.media = scene.media;
    out.media_range = media_range(out.eye, scene.media);
    // 2017 marched whatever the view: its floor under the extinction is everywhere.
    const bool everywhere = settings.range == Settings::Range::camera;
    out.sees_media =
        !scene.media.empty() && (everywhere || view_z_range(out.eye, scene.media).y > out.eye.near);
    out.step_range = step_range(out);
    out.picture_size = glm::ivec2(frame.color.size);
    if (settings.resolution == Settings::kAutomatic)
        out.layer_choice = choose_resolution(out, scene, past.scale);
    if (out.layer_choice.scale > 0)
        out.settings.resolution = out.layer_choice.scale;
    const int scale = out.settings.resolution;
    out.layer_guard = layer_guard(out.settings);
    out.layer_size = (out.picture_size + scale - 1) / scale + 2 * out.layer_guard;
    out.params = make_params(out);
    return out;
}

}  // namespace fumarole
