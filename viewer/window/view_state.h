#pragma once

#include <optional>
#include <string>
#include <vector>

#include "window/display_pass.h"
#include "window/keys.h"
#include <fumarole/inspection.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>

namespace fumarole::window {

/// What a person has chosen to see, and how.
struct ViewState {
    std::string preset = "default";  ///< preset that the settings started from
    Settings settings;
    bool reference = false;  ///< shown in place of what the settings make

    Comparison comparison = Comparison::none;
    std::string other = "eevee2017";  ///< what it is compared with: a mode, a preset, `reference`
    double wipe = 0.5;
    double difference_scale = 0;  ///< difference at the end of the colours; 0: what suits

    std::optional<Inspection> inspection;

    bool auto_exposure = true;
    float exposure_ev = 0;
    Display::Transform transform = Display::Transform::filmic;

    int aa = 16;             ///< frames averaged at rest
    double target_ms = 33;   ///< time of a frame while things move [ms]
    double tolerance = 0.1;  ///< tolerance of the reference

    bool panel = true;
    bool lights = false;
    bool help = false;

    [[nodiscard]] bool compares() const { return comparison != Comparison::none; }
    [[nodiscard]] bool wants_reference() const
    {
        return reference || (compares() && other == "reference");
    }
    /// Frames that make a picture at rest: what is seen inside is drawn once.
    [[nodiscard]] int frames_at_rest() const { return inspection ? 1 : aa; }
    /// The picture's own display, whatever is seen inside.
    [[nodiscard]] Display display() const
    {
        return {.exposure_ev = exposure_ev, .transform = transform};
    }
};

/// Does what an action does to the state alone. Returns false if it is about something else.
bool change_view(ViewState& state, Action action);

/// How side A and side B are shown: as the picture is, but for what is seen inside, whose colours
/// are its values already.
Display display_of(const ViewState& state);

/// The settings of the other side, or nothing for `reference`. A mode takes the rest from
/// `settings`. @throws Error listing what there is
std::optional<Settings> other_settings(const ViewState& state);

/// What can stand in ViewState::other: modes, presets, `reference`.
std::vector<std::string> others();

/// Sets one setting by its name; `preset` and `mode` too. @throws Error as the table does
void change_setting(ViewState& state, const std::string& name, const std::string& value);

/// Words of a command line that makes what is on the screen.
/// @param input the scene's file, and the words that go with it
std::string command_line(const ViewState& state, const std::string& input, glm::ivec2 pixels,
                         const std::string& output);

}  // namespace fumarole::window
