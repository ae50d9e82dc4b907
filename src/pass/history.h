#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "pass/volume_pass.h"
#include "prepared_frame.h"

// What passes that keep something of a view from frame to frame share: how last frame's view lay,
// whether it still holds, and how much it weighs.

namespace fumarole::pass {

/// How one frame saw the scene, in double: what the next frame's history is mapped by.
struct HistoryView {
    glm::dmat4 view_from_world{1.0}, clip_from_view{1.0};
    glm::dvec3 eye{0}, forward{0};  ///< metres, world; unit length
    glm::dvec2 range{0};            ///< view_z [m] of the steps' or slices' ends
    FrameSettings settings;
    std::uint64_t scene_id = 0, media_id = 0, life_id = 0;  ///< PreparedFrame's
};

HistoryView make_history_view(const PreparedFrame& frame);

/// view_z of an eye-centred point as a dot product; eye: what it is centred at (metres, world).
glm::dvec4 view_z_from_eye(const HistoryView& view, glm::dvec3 eye);
glm::dmat4 clip_from_eye(const HistoryView& view, glm::dvec3 eye);

/// Where the eye was, eye-centred, w 1; of an orthographic view the direction to it, w 0.
glm::vec4 eye_from_eye(const HistoryView& view, const Eye& now);

/// Why last frame's history was or was not used. What lies out of last frame's view is told apart
/// in the shaders.
enum class HistoryUse { off, first, cut, other_scene, settings_changed, moved, still };
bool has_history(HistoryUse use);

/// What has changed in the scene since last frame. Its history is then clipped to what this frame
/// has around each place, and counts for fewer frames the less it looks like that.
enum class SceneChange {
    none,
    light,  ///< lights, surfaces, how media scatter or glow: how they dim is as it was
    media,  ///< how media dim too
};
SceneChange change_since(const std::optional<HistoryView>& last, const HistoryView& now);

const char* to_string(HistoryUse use, SceneChange change);

/// @param keeps whether anything is kept of such a frame
HistoryUse judge_history(bool keeps, const std::optional<HistoryView>& last,
                         const HistoryView& now);

/// How much of its history a view keeps from frame to frame.
///
/// While nothing changes every frame counts the same: frame n weighs 1 / n, the mean, which
/// converges as far as the jitter goes. While the view moves, history is kept by the weight asked
/// for, since what was reprojected blurs and what was seen before no longer holds. When it comes to
/// rest that weight stays until what was gathered in motion has faded to kFaded; then frames count
/// again from where an exponential mean of that weight stands.
class HistoryWeight {
public:
    void reset() { *this = {}; }
    /// The weight of history in a frame that has some, 0..1.
    float next(HistoryUse use, float asked);

private:
    static constexpr double kFaded = 0.01;
    double frames_ = 0;  ///< number of frames that history is worth
    double fading_ = 0;  ///< share of what was gathered in motion that is still there
};

}  // namespace fumarole::pass
