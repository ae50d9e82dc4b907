#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include <fumarole/settings.h>

// One line of a panel: a name, a control, a way back, and what it is on hovering. ImGui calls.

namespace fumarole::window {

/// What is said of a control: `unit` and `range` may be "".
struct ControlText {
    std::string label, unit, range, help;
};

/// A number between two ends; logarithmic where they lie far apart. @returns whether it changed
bool number_control(const ControlText& text, float& value, float low, float high, float first);
bool number_control(const ControlText& text, double& value, double low, double high, double first);
bool number_control(const ControlText& text, int& value, int low, int high, int first);
/// Three numbers, each `low` at least. Without an upper end: dragged at the pace of their size.
bool triple_control(const ControlText& text, glm::vec3& value, float low, glm::vec3 first);
bool triple_control(const ControlText& text, glm::dvec3& value, double low, glm::dvec3 first);
/// A colour, each channel 0..1.
bool color_control(const ControlText& text, glm::vec3& value, glm::vec3 first);
bool switch_control(const ControlText& text, bool& value, bool first);
/// One of several names.
bool choice_control(const ControlText& text, std::string& value,
                    const std::vector<std::string>& names, const std::string& first);

/// A row of setting_table(). @param first what its reset goes back to
bool setting_control(const SettingInfo& info, Settings& settings, const Settings& first);

}  // namespace fumarole::window
