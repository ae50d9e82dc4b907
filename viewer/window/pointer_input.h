#pragma once

#include <array>
#include <glm/glm.hpp>

#include "window/change.h"
#include "window/event.h"
#include "window/layout.h"
#include "window/view_state.h"
#include <fumarole/scene.h>

namespace fumarole::window {

/// What the pointer works on: a scene, the state of the view, and where its picture is.
struct PointerTarget {
    Scene& scene;
    ViewState& state;
    Area picture;
    bool whole = true;        ///< false while files are still read: nothing may be moved
    bool over_panel = false;  ///< the interface has the pointer: no drag begins
};

/// The pointer on the picture: orbit, pan, look around, fly, dolly, drag the split's line, or a
/// light or a transparent by its handle.
class PointerInput {
public:
    /// Takes a motion, a button or the wheel; other events are left alone.
    Change handle(const Event& event, const PointerTarget& target);

    /// Takes W A S D Q E, which fly while one looks around. Returns false for a key that means
    /// something else.
    bool take_key(const KeyEvent& key);
    /// Moves the camera for the keys that are held.
    Change fly(double seconds, Camera& camera);

    [[nodiscard]] glm::dvec2 place() const { return pointer_; }
    /// Whether the pointer is near enough to the split's line to drag it.
    [[nodiscard]] bool over_split(const ViewState& state, const Area& picture) const;

private:
    enum class Drag { none, orbit, pan, look, split, light, probe, transparent };

    /// Whether a gesture on the picture may begin here.
    [[nodiscard]] bool may_begin(const PointerTarget& target) const;
    Change press(const PointerButton& button, const PointerTarget& target);
    Change move(glm::dvec2 to, const PointerTarget& target);
    Change move_camera(glm::dvec2 by, Camera& camera, double height) const;

    Drag drag_ = Drag::none;
    std::size_t dragged_ = 0;       ///< Scene::lights, probes or transparents: that is dragged
    glm::dvec2 pointer_{-1};        ///< pointer in the window's units
    std::array<bool, 6> flying_{};  ///< keys held: right, left, up, down, forward, back
};

}  // namespace fumarole::window
