#include "transparent/panes.h"

#include <algorithm>

namespace fumarole::transparent {

namespace {

/// Where rays meet its plane, as shared::PaneParams has it, at a place of the picture in NDC.
glm::dvec4 met(const Placed& one, const CameraRays& rays, glm::dvec2 ndc)
{
    const glm::dvec3 origin = rays.origin + ndc.x * rays.origin_dx + ndc.y * rays.origin_dy;
    const glm::dvec3 direction =
        rays.direction + ndc.x * rays.direction_dx + ndc.y * rays.direction_dy;
    const glm::dvec3 &a = one.edges[0], &b = one.edges[1], &normal = one.planes.front().normal;
    const glm::dvec3 to_a = glm::cross(b, normal), to_b = glm::cross(normal, a);
    const glm::dvec3 along_a = to_a / glm::dot(a, to_a), along_b = to_b / glm::dot(b, to_b);
    const glm::dvec3 from_corner = origin - one.corner;
    const double w = glm::dot(normal, direction);
    const double z = -glm::dot(normal, from_corner);
    const auto along = [&](const glm::dvec3& axis) {
        return glm::dot(axis, from_corner) * w + glm::dot(axis, direction) * z;
    };
    return {along(along_a), along(along_b), z, w};
}

/// How much of a pane's depth lies between two rays of a march's layer, where the media are [m].
double between_rays(const Placed& one, const PreparedFrame& frame)
{
    const glm::dvec2 depths(std::max(one.seen.view_z.x, frame.media_range.x),
                            std::min(one.seen.view_z.y, frame.media_range.y));
    if (!(depths.x < depths.y))
        return 0;
    const auto at = [&](double x, double y) { return met(one, frame.rays, {x, y}); };
    const glm::dvec4 middle = at(0, 0), dx = at(1, 0) - middle, dy = at(0, 1) - middle;
    const glm::dvec2 dz(dx.z, dy.z), dw(dx.w, dy.w);
    // Of view_z = z / w, steepest at its farthest; of parallel rays w is one number, else z is.
    const double w = frame.eye.perspective ? middle.z / depths.y : middle.w;
    const glm::dvec2 slope = glm::abs((dz - depths.y * dw) / w);
    const double ray = 2.0 * frame.settings.resolution;  // pixels, and NDC of them
    return glm::dot(slope, ray / glm::dvec2(frame.picture_size));
}

}  // namespace

std::vector<Placed> panes_of(std::vector<Placed>& ordered)
{
    std::vector<Placed> panes;
    for (Placed& one : ordered) {
        const auto is_it = [&](const Placed& pane) { return pane.seen.index == one.seen.index; };
        const auto found = std::find_if(panes.begin(), panes.end(), is_it);
        one.seen.pane = static_cast<int>(found - panes.begin());
        if (found != panes.end()) {  // of two pieces of it
            found->seen.view_z = {std::min(found->seen.view_z.x, one.seen.view_z.x),
                                  std::max(found->seen.view_z.y, one.seen.view_z.y)};
            continue;
        }
        if (!one.is_flat || panes.size() == MAX_PANES)
            return {};
        panes.push_back(one);
    }
    return panes;
}

bool suit_march(const std::vector<Placed>& panes, const PreparedFrame& frame)
{
    if (frame.settings.mode != Settings::Mode::raymarch || frame.settings.resolution == 1 ||
        !frame.sees_media)
        return true;
    const double between =
        (frame.media_range.y - frame.media_range.x) / double(frame.settings.splits);
    return std::all_of(panes.begin(), panes.end(),
                       [&](const Placed& one) { return between_rays(one, frame) <= between; });
}

shared::PaneParams pane_params(const TransparentSet& transparents, const std::vector<Placed>& panes,
                               const PreparedFrame& frame)
{
    shared::PaneParams params{};
    params.view_z = glm::vec2(frame.eye.near, frame.eye.far);
    params.count = static_cast<int>(panes.size());
    for (std::size_t i = 0; i < panes.size(); ++i) {
        const auto at = [&](double x, double y) { return met(panes[i], frame.rays, {x, y}); };
        const glm::dvec4 middle = at(0, 0);
        params.at[i] = glm::vec4(middle);
        params.at_dx[i] = glm::vec4(at(1, 0) - middle);
        params.at_dy[i] = glm::vec4(at(0, 1) - middle);
        const std::optional<PlainPane> pane = transparents.plain(panes[i].seen);
        if (!pane)
            continue;
        const glm::vec3 limited = glm::min(glm::vec3(pane->source), frame.params.radiance_limit);
        params.emitted[i] = glm::vec4(limited * pane->of_source(limited), 0);
        params.kept[i] = glm::vec4(pane->of_behind(limited), 0);
    }
    return params;
}

}  // namespace fumarole::transparent
