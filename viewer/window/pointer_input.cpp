#include "window/pointer_input.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <GLFW/glfw3.h>

#include "window/camera_control.h"
#include "window/scene_handles.h"

namespace fumarole::window {

namespace {

constexpr double kHandleReach = 12;        // [pixels] around a light's handle
constexpr double kSplitReach = 6;          // [window's units] on either side of the split's line
constexpr double kWheelNotch = 0.88;       // of the distance to look_at
constexpr double kTargetsPerSecond = 0.5;  // distances to look_at that are flown in a second
constexpr double kLongestFlight = 0.1;     // [s] flown in one frame: none leaps after a stall
// In the order of PointerInput::flying_.
constexpr std::array kFlyKeys{GLFW_KEY_D, GLFW_KEY_A, GLFW_KEY_E,
                              GLFW_KEY_Q, GLFW_KEY_W, GLFW_KEY_S};

}  // namespace

Change PointerInput::handle(const Event& event, const PointerTarget& target)
{
    if (const auto* moved = std::get_if<PointerMoved>(&event))
        return move(moved->to, target);
    if (const auto* button = std::get_if<PointerButton>(&event))
        return press(*button, target);
    const auto* wheel = std::get_if<Wheel>(&event);
    if (wheel == nullptr || !may_begin(target))
        return Change::none;
    target.scene.camera = dollied(target.scene.camera, std::pow(kWheelNotch, wheel->notches));
    return Change::view;
}

bool PointerInput::may_begin(const PointerTarget& target) const
{
    return target.whole && !target.over_panel && target.picture.holds(pointer_);
}

bool PointerInput::over_split(const ViewState& state, const Area& picture) const
{
    return state.comparison == Comparison::split &&
           std::abs(pointer_.x - picture.at.x - state.wipe * picture.size.x) < kSplitReach;
}

Change PointerInput::press(const PointerButton& button, const PointerTarget& target)
{
    if (!button.down) {
        drag_ = Drag::none;
        return Change::none;
    }
    const Area& picture = target.picture;
    if (!may_begin(target))
        return Change::none;
    const bool left = button.button == 0;
    std::optional<std::size_t> light, probe, transparent;
    if (left && target.state.lights) {
        const auto at_pointer = [&](const std::vector<Handle>& handles) {
            return handle_at(handles, picture.share(pointer_), picture.size, kHandleReach);
        };
        light = at_pointer(light_handles(target.scene, picture.aspect()));
        probe = at_pointer(probe_handles(target.scene, picture.aspect()));
        transparent = at_pointer(transparent_handles(target.scene, picture.aspect()));
    }
    if (left && over_split(target.state, picture)) {
        drag_ = Drag::split;
    } else if (light) {
        drag_ = Drag::light;
        dragged_ = *light;
    } else if (probe) {
        drag_ = Drag::probe;
        dragged_ = *probe;
    } else if (transparent) {
        drag_ = Drag::transparent;
        dragged_ = *transparent;
    } else if (button.button == 1) {
        drag_ = Drag::look;
    } else {
        drag_ = button.button == 2 || button.modifiers.shift ? Drag::pan : Drag::orbit;
    }
    return Change::none;
}

Change PointerInput::move(glm::dvec2 to, const PointerTarget& target)
{
    const glm::dvec2 by = to - pointer_;
    pointer_ = to;
    const Area& picture = target.picture;
    if (drag_ == Drag::none || !target.whole)
        return Change::none;
    if (drag_ == Drag::split) {
        target.state.wipe = std::clamp(picture.share(to).x, 0.0, 1.0);
        return Change::none;  // what is drawn stays: only where it is shown differs
    }
    const auto drag_one_of = [&](auto& all) {
        if (dragged_ >= all.size())
            return Change::none;
        auto& one = all[dragged_];
        one = dragged(target.scene, one, picture.share(to), picture.aspect());
        return Change::content;
    };
    if (drag_ == Drag::light)
        return drag_one_of(target.scene.lights);
    if (drag_ == Drag::probe)
        return drag_one_of(target.scene.probes);
    if (drag_ == Drag::transparent)
        return drag_one_of(target.scene.transparents);
    return move_camera(by, target.scene.camera, picture.size.y);
}

Change PointerInput::move_camera(glm::dvec2 by, Camera& camera, double height) const
{
    const double half_turn = std::numbers::pi / height;  // over the picture's height
    if (drag_ == Drag::orbit)
        camera = orbited(camera, {by.x * half_turn, -by.y * half_turn});
    else if (drag_ == Drag::pan)
        camera = panned(camera, by, height);
    else
        camera = looked_around(camera,
                               glm::dvec2(by.x, -by.y) * (glm::radians(camera.vfov_deg) / height));
    return Change::view;
}

bool PointerInput::take_key(const KeyEvent& key)
{
    const bool looks = drag_ == Drag::look;
    for (std::size_t i = 0; i < kFlyKeys.size(); ++i)
        if (key.key == kFlyKeys[i] && (looks || !key.down)) {
            flying_[i] = key.down;
            return looks;
        }
    return false;
}

Change PointerInput::fly(double seconds, Camera& camera)
{
    if (drag_ != Drag::look) {
        flying_.fill(false);
        return Change::none;
    }
    const auto along = [&](std::size_t plus) { return flying_[plus] - flying_[plus + 1]; };
    const glm::dvec3 direction(along(0), along(2), along(4));
    if (direction == glm::dvec3(0))
        return Change::none;
    const double speed = kTargetsPerSecond * glm::length(camera.look_at - camera.position);
    camera = flown(camera, direction * speed * std::min(seconds, kLongestFlight));
    return Change::view;
}

}  // namespace fumarole::window
