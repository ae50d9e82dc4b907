#include "pass/history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace fumarole::pass {

namespace {

/// Beyond these a frame shows another place, and not the same one from further on.
constexpr double kCutTurn = 0.35;    ///< radians between one frame and the next
constexpr double kCutTravel = 0.25;  ///< share of the depth that steps or slices span
constexpr double kCutZoom = 1.25;    ///< ratio of the picture's scale

/// Whether `now` sees another place than `last` or in another way.
bool is_cut(const HistoryView& last, const HistoryView& now)
{
    const glm::dmat4 &a = last.clip_from_view, &b = now.clip_from_view;
    const auto zoomed = [&](int axis) {
        const double zoom = b[axis][axis] / a[axis][axis];
        return !(zoom < kCutZoom && zoom > 1 / kCutZoom);
    };
    return glm::dot(last.forward, now.forward) < std::cos(kCutTurn) ||
           glm::length(now.eye - last.eye) > kCutTravel * (last.range.y - last.range.x) ||
           a[2][3] != b[2][3] || zoomed(0) || zoomed(1);
}

}  // namespace

HistoryView make_history_view(const PreparedFrame& frame)
{
    glm::dvec2 range = frame.step_range;
    range.y = std::max(range.y, range.x * (1 + 1e-6) + 1e-30);
    return {frame.host.view_from_world,
            frame.host.clip_from_view,
            frame.eye.position,
            frame.eye.forward,
            range,
            frame.settings,
            frame.scene_id,
            frame.media_id,
            frame.life_id};
}

glm::dvec4 view_z_from_eye(const HistoryView& view, glm::dvec3 eye)
{
    return {view.forward, glm::dot(view.forward, eye - view.eye)};
}

glm::dmat4 clip_from_eye(const HistoryView& view, glm::dvec3 eye)
{
    return view.clip_from_view * view.view_from_world * glm::translate(glm::dmat4(1.0), eye);
}

glm::vec4 eye_from_eye(const HistoryView& view, const Eye& now)
{
    return now.perspective ? glm::vec4(glm::vec3(view.eye - now.position), 1.0f)
                           : glm::vec4(glm::vec3(-view.forward), 0.0f);
}

SceneChange change_since(const std::optional<HistoryView>& last, const HistoryView& now)
{
    if (!last || last->scene_id == now.scene_id)
        return SceneChange::none;
    return last->media_id == now.media_id ? SceneChange::light : SceneChange::media;
}

const char* to_string(HistoryUse use, SceneChange change)
{
    if (has_history(use) && change != SceneChange::none) {
        const bool light = change == SceneChange::light;
        if (use == HistoryUse::still)
            return light ? "kept, clipped: light changed" : "kept, clipped: media changed";
        return light ? "reprojected, clipped: light changed"
                     : "reprojected, clipped: media changed";
    }
    constexpr std::array kNames{"off",
                                "none: first frame",
                                "dropped: a cut",
                                "dropped: another scene",
                                "dropped: settings changed",
                                "reprojected",
                                "kept: nothing moved"};
    return kNames.at(static_cast<std::size_t>(use));
}

bool has_history(HistoryUse use)
{
    return use == HistoryUse::still || use == HistoryUse::moved;
}

HistoryUse judge_history(bool keeps, const std::optional<HistoryView>& last, const HistoryView& now)
{
    if (!keeps)
        return HistoryUse::off;
    if (!last)
        return HistoryUse::first;
    if (last->life_id != now.life_id)
        return HistoryUse::other_scene;
    if (last->settings != now.settings)
        return HistoryUse::settings_changed;
    if (is_cut(*last, now))
        return HistoryUse::cut;
    const bool same = last->view_from_world == now.view_from_world &&
                      last->clip_from_view == now.clip_from_view && last->range == now.range;
    return same ? HistoryUse::still : HistoryUse::moved;
}

float HistoryWeight::next(HistoryUse use, float asked)
{
    if (!has_history(use))
        reset();
    // An exponential mean of weight w is worth 1 / (1 - w) frames of a running one.
    const double most = 1 / (1 - static_cast<double>(asked));
    if (use == HistoryUse::moved)
        fading_ = 1;
    if (fading_ > kFaded)
        frames_ = std::min(frames_, most - 1);
    else
        fading_ = 0;
    const double weight = frames_ / (frames_ + 1);
    fading_ *= weight;
    ++frames_;
    return static_cast<float>(weight);
}

}  // namespace fumarole::pass
