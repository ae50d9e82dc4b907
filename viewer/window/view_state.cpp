#include "window/view_state.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "settings_input.h"
#include "shell_words.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

void show_mode(ViewState& state, Settings::Mode mode)
{
    state.settings.mode = mode;
    state.reference = false;
    // A march has no froxels to look into.
    if (mode == Settings::Mode::raymarch && state.inspection &&
        state.inspection->kind == Inspection::Kind::froxel_slice)
        state.inspection.reset();
}

/// Compares in a way, or no longer if it does so already.
void toggle(ViewState& state, Comparison comparison)
{
    state.comparison = state.comparison == comparison ? Comparison::none : comparison;
}

/// From the picture through all that can be seen inside, and back to the picture.
void inspect_next(ViewState& state)
{
    const auto kinds = inspection_table();
    std::size_t next = state.inspection ? static_cast<std::size_t>(state.inspection->kind) + 1 : 0;
    const auto suits = [&](Inspection::Kind kind) {
        return kind != Inspection::Kind::froxel_slice ||
               state.settings.mode == Settings::Mode::froxel;
    };
    while (next < kinds.size() && !suits(kinds[next].kind))
        ++next;
    if (next >= kinds.size()) {
        state.inspection.reset();
        return;
    }
    if (!state.inspection)
        state.inspection.emplace();
    state.inspection->kind = kinds[next].kind;
}

}  // namespace

bool change_view(ViewState& state, Action action)
{
    switch (action) {
    case Action::raymarch:
        show_mode(state, Settings::Mode::raymarch);
        return true;
    case Action::froxel:
        show_mode(state, Settings::Mode::froxel);
        return true;
    case Action::reference:
        state.reference = true;
        return true;
    case Action::split:
        toggle(state, Comparison::split);
        return true;
    case Action::difference:
        toggle(state, Comparison::difference);
        return true;
    case Action::see_inside:
        inspect_next(state);
        return true;
    case Action::lights:
        state.lights = !state.lights;
        return true;
    case Action::panel:
        state.panel = !state.panel;
        return true;
    case Action::help:
        state.help = !state.help;
        return true;
    default:
        return false;
    }
}

Display display_of(const ViewState& state)
{
    if (state.inspection && state.inspection->kind != Inspection::Kind::scattering &&
        state.inspection->kind != Inspection::Kind::probe)
        return {.exposure_ev = 0, .transform = Display::Transform::srgb};
    return state.display();
}

std::vector<std::string> others()
{
    std::vector<std::string> names{"raymarch", "froxel"};
    for (const auto& [name, settings] : presets())
        if (std::find(names.begin(), names.end(), name) == names.end())
            names.emplace_back(name);
    names.emplace_back("reference");
    return names;
}

std::optional<Settings> other_settings(const ViewState& state)
{
    if (state.other == "reference")
        return std::nullopt;
    if (state.other == "raymarch" || state.other == "froxel") {
        Settings settings = state.settings;
        settings.mode = find_mode(state.other);
        return settings;
    }
    try {
        return find_preset(state.other);
    } catch (const Error&) {
        throw Error(fmt::format("'{}' is nothing to compare with (there are: {})", state.other,
                                fmt::join(others(), ", ")));
    }
}

void change_setting(ViewState& state, const std::string& name, const std::string& value)
{
    if (name == "preset") {
        state.settings = find_preset(value);
        state.preset = value;
    } else if (name == "mode") {
        state.settings.mode = find_mode(value);
    } else {
        find_setting(name).set(state.settings, value);
    }
}

std::string command_line(const ViewState& state, const std::string& input, glm::ivec2 pixels,
                         const std::string& output)
{
    std::string line = fmt::format("fumarole render {} --size {}x{}", input, pixels.x, pixels.y);
    if (state.reference) {
        line += fmt::format(" --mode reference --tolerance {:g}", state.tolerance);
        if (state.settings.bounces == 0)
            line += " --bounces 0";
    } else {
        const Settings preset = find_preset(state.preset);
        if (state.preset != "default")
            line += " --preset " + state.preset;
        if (state.settings.mode != preset.mode)
            line += fmt::format(" --mode {}", mode_name(state.settings.mode));
        if (const std::string words = command::settings_words(state.settings, preset);
            !words.empty())
            line += " " + words;
        if (state.inspection) {
            const Inspection& what = *state.inspection;
            line += fmt::format(" --show {}", inspection_name(what.kind));
            if (what.kind == Inspection::Kind::probe)
                line += fmt::format("={}", what.probe);
            if (what.kind == Inspection::Kind::density_slice)
                line += fmt::format(" --slice {}={:g}", "xyz"[what.axis], what.position);
            if (what.kind == Inspection::Kind::froxel_slice)
                line += fmt::format(" --slice {:g}", what.position);
            if (what.scale > 0)
                line += fmt::format(" --scale {:g}", what.scale);
        }
    }
    if (!state.inspection)
        line += fmt::format(" --aa {}", state.aa);
    line += fmt::format(" --exposure {:.4g}", state.exposure_ev);
    if (state.transform == Display::Transform::srgb)
        line += " --display srgb";
    return line + " -o " + command::shell_word(output);
}

}  // namespace fumarole::window
