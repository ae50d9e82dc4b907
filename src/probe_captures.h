#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include <fumarole/frame.h>
#include <fumarole/settings.h>
#include <fumarole/view.h>

#include "gl/device.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "gl/transfer.h"
#include "light/probes.h"

namespace fumarole {

/// Draws what a renderer's probes see, face by face, and decides which of them a frame has the time
/// for.
class ProbeCaptures {
public:
    /// Draws the surfaces as seen through the media, and the media.
    /// @param unseen a flag for each surface that is left out
    using DrawFace = std::function<void(const Frame& face, const FrameSettings& settings,
                                        View& view, const std::vector<bool>& unseen)>;
    using MakeView = std::function<View()>;

    ProbeCaptures(const gl::Device& device, gl::PassTimers& timers, light::Probes& probes,
                  MakeView make_view, DrawFace draw_face);

    /// Captures all that are out of date. @param anew those that a frame would leave as well
    void capture_all(bool anew);

    /// Captures a probe that is out of date, if a frame leaves the time for it.
    void update(const Frame& frame, std::uint64_t scene_id, SceneSettings::ProbeUpdate when);

    /// Draws one face of each kind, so that captures compile nothing.
    void prepare();

    /// The part of what the probes have seen that another turn would add, if there have been two.
    [[nodiscard]] std::optional<double> next_turn();

    /// Lets go of the pictures that faces are drawn to.
    void forget() { canvases_.clear(); }

private:
    /// What a probe's faces are drawn to.
    struct Canvas {
        gl::Texture color, depth;
        std::optional<View> view;  ///< the view that shows the media in them
    };
    Canvas& canvas_of(int size);
    void capture(int i);
    /// Draws what a probe sees, the first so many faces, and calls `done` after each.
    void draw_faces(int i, Canvas& canvas, int faces, const std::function<void(int face)>& done);
    /// The mean radiance around each of them, from small faces: as all have faded in, or before the
    /// last turn.
    [[nodiscard]] std::vector<glm::dvec3> mean_around(bool before_last_turn);
    /// Looks from a probe at so little that it takes a small part of a capture.
    void glimpse_from(int i, std::uint64_t scene_id);
    /// Takes what came back of that, frames later where the GPU takes so long.
    void take_glimpse(std::uint64_t scene_id);

    const gl::Device& device_;
    gl::PassTimers& timers_;
    light::Probes& probes_;
    MakeView make_view_;
    DrawFace draw_face_;
    std::map<int, Canvas> canvases_;                   ///< canvases by the pixels along an edge
    std::optional<std::pair<int, double>> next_turn_;  ///< next turn of so many captures
    /// Of the last frame, by which it is known whether anything moves: a jittered projection is no
    /// movement.
    struct LastFrame {
        glm::dmat4 view_from_world{0.0};
        std::uint64_t scene_id = 0;
        bool operator==(const LastFrame&) const = default;
    } last_frame_;
    /// What a probe was looked from to see, on its way back.
    struct Glimpse {
        int probe = 0;
        std::uint64_t scene_id = 0;
        std::vector<gl::Readback> faces;
    };
    std::optional<Glimpse> glimpse_;
};

}  // namespace fumarole
