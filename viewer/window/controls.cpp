#include "window/controls.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <glm/glm.hpp>
#include <imgui.h>
#include <map>
#include <optional>
#include <vector>

#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

/// Draws name, control, reset and help; `control` draws the middle and says whether it changed.
template <typename Control, typename Reset>
bool row(const ControlText& text, bool is_first, Control&& control, Reset&& reset)
{
    ImGui::PushID(text.label.c_str());
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(text.label.c_str());
    bool hovered = ImGui::IsItemHovered();
    ImGui::SameLine(width * 0.40f);
    ImGui::SetNextItemWidth(width * 0.46f);
    bool changed = control();
    hovered |= ImGui::IsItemHovered();
    if (!text.unit.empty()) {
        ImGui::SameLine();
        ImGui::TextDisabled("%s", text.unit.c_str());
    }
    if (!is_first) {
        ImGui::SameLine(width - ImGui::GetFontSize() * 0.6f);
        if (ImGui::SmallButton("<")) {
            reset();
            changed = true;
        }
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("back to what it was");
    }
    if (hovered && !text.help.empty()) {
        std::string tip = text.help;
        if (!text.range.empty() || !text.unit.empty())
            tip += fmt::format("\n{}{}{}", text.range, text.range.empty() ? "" : " ", text.unit);
        ImGui::SetTooltip("%s", tip.c_str());
    }
    ImGui::PopID();
    return changed;
}

ImGuiSliderFlags flags_of(double low, double high)
{
    constexpr double kFarApart = 200;
    const bool far_apart =
        low >= 0 && high > kFarApart * std::max(low, 1e-9) && (low > 0 || high >= kFarApart);
    return ImGuiSliderFlags_AlwaysClamp | (far_apart ? ImGuiSliderFlags_Logarithmic : 0);
}

/// What a row of setting_table() takes, from its own words.
struct Takes {
    std::vector<std::string> names;  ///< `none|blue`
    bool automatic = false;          ///< `auto|0..512`
    std::optional<std::pair<double, double>> range;
    bool whole = false;  ///< numbers
};

double to_number(std::string_view text)
{
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

Takes read_takes(const SettingInfo& info)
{
    Takes takes;
    std::string_view rest = info.values;
    while (!rest.empty()) {
        const std::size_t bar = std::min(rest.find('|'), rest.size());
        const std::string_view part = rest.substr(0, bar);
        rest.remove_prefix(std::min(bar + 1, rest.size()));
        if (const std::size_t dots = part.find(".."); dots != std::string_view::npos)
            takes.range = {to_number(part.substr(0, dots)), to_number(part.substr(dots + 2))};
        else
            takes.names.emplace_back(part);
    }
    takes.automatic = takes.range && !takes.names.empty();
    if (takes.range) {
        // The table says nothing of types: what takes no fraction is whole.
        Settings trial;
        const double fraction = std::min(takes.range->first + 0.5, 0.99 * takes.range->second);
        try {
            info.set(trial, fmt::format("{:f}", fraction));
        } catch (const Error&) {
            takes.whole = true;
        }
    }
    return takes;
}

const Takes& takes_of(const SettingInfo& info)
{
    static std::map<std::string_view, Takes> known;
    auto there = known.find(info.name);
    if (there == known.end())
        there = known.emplace(info.name, read_takes(info)).first;
    return there->second;
}

bool set(const SettingInfo& info, Settings& settings, const std::string& value)
{
    if (info.get(settings) == value)
        return false;
    info.set(settings, value);
    return true;
}

bool draw_number(const SettingInfo& info, const Takes& takes, Settings& settings)
{
    const auto [low, high] = *takes.range;
    const double now = to_number(info.get(settings));
    if (takes.whole) {
        int value = static_cast<int>(now);
        return ImGui::SliderInt("##n", &value, static_cast<int>(low), static_cast<int>(high), "%d",
                                flags_of(low, high)) &&
               set(info, settings, fmt::format("{}", value));
    }
    auto value = static_cast<float>(now);
    return ImGui::SliderFloat("##n", &value, static_cast<float>(low), static_cast<float>(high),
                              "%.4g", flags_of(low, high)) &&
           set(info, settings,
               fmt::format("{}",
                           std::clamp(value, static_cast<float>(low), static_cast<float>(high))));
}

bool draw_choice(std::string& value, const std::vector<std::string>& names)
{
    bool changed = false;
    if (ImGui::BeginCombo("##c", value.c_str())) {
        for (const std::string& name : names)
            if (ImGui::Selectable(name.c_str(), name == value) && name != value) {
                value = name;
                changed = true;
            }
        ImGui::EndCombo();
    }
    return changed;
}

bool draw_automatic(const SettingInfo& info, const Takes& takes, Settings& settings)
{
    constexpr const char* kStart = "32";  // a number to begin with, in the range of all that are
    bool automatic = info.get(settings) == "auto";
    if (automatic) {
        if (ImGui::Button("auto", {ImGui::CalcItemWidth(), 0}))
            return set(info, settings, kStart);
        return false;
    }
    ImGui::SetNextItemWidth(ImGui::CalcItemWidth() * 0.7f);
    bool changed = draw_number(info, takes, settings);
    ImGui::SameLine();
    if (ImGui::SmallButton("auto"))
        changed |= set(info, settings, "auto");
    return changed;
}

template <typename T> std::string span(T low, T high)
{
    return fmt::format("{:g}..{:g}", static_cast<double>(low), static_cast<double>(high));
}

}  // namespace

bool number_control(const ControlText& text, float& value, float low, float high, float first)
{
    ControlText with = text;
    with.range = span(low, high);
    return row(
        with, value == first,
        [&] { return ImGui::SliderFloat("##n", &value, low, high, "%.4g", flags_of(low, high)); },
        [&] { value = first; });
}

bool number_control(const ControlText& text, double& value, double low, double high, double first)
{
    auto number = static_cast<float>(value);
    if (!number_control(text, number, static_cast<float>(low), static_cast<float>(high),
                        static_cast<float>(first)))
        return false;
    value = number;
    return true;
}

bool number_control(const ControlText& text, int& value, int low, int high, int first)
{
    ControlText with = text;
    with.range = span(low, high);
    return row(
        with, value == first,
        [&] { return ImGui::SliderInt("##n", &value, low, high, "%d", flags_of(low, high)); },
        [&] { value = first; });
}

bool triple_control(const ControlText& text, glm::vec3& value, float low, glm::vec3 first)
{
    const float size = std::max({std::abs(value.x), std::abs(value.y), std::abs(value.z), 0.1f});
    const float high = low < 0 ? 1e9f : 1e30f;
    return row(
        text, value == first,
        [&] {
            return ImGui::DragFloat3("##t", &value.x, size * 0.01f, low, high, "%.4g",
                                     ImGuiSliderFlags_AlwaysClamp);
        },
        [&] { value = first; });
}

bool triple_control(const ControlText& text, glm::dvec3& value, double low, glm::dvec3 first)
{
    glm::vec3 numbers(value);
    if (!triple_control(text, numbers, static_cast<float>(low), glm::vec3(first)))
        return false;
    value = numbers == glm::vec3(first) ? first : glm::dvec3(numbers);
    return true;
}

bool color_control(const ControlText& text, glm::vec3& value, glm::vec3 first)
{
    constexpr float kRounded = 1e-4f;  // it is worked out of other numbers
    return row(
        text, glm::length(value - first) < kRounded,
        [&] {
            return ImGui::ColorEdit3("##k", &value.x,
                                     ImGuiColorEditFlags_Float | ImGuiColorEditFlags_NoInputs);
        },
        [&] { value = first; });
}

bool switch_control(const ControlText& text, bool& value, bool first)
{
    return row(
        text, value == first, [&] { return ImGui::Checkbox("##s", &value); },
        [&] { value = first; });
}

bool choice_control(const ControlText& text, std::string& value,
                    const std::vector<std::string>& names, const std::string& first)
{
    return row(
        text, value == first, [&] { return draw_choice(value, names); }, [&] { value = first; });
}

bool setting_control(const SettingInfo& info, Settings& settings, const Settings& first)
{
    const Takes& takes = takes_of(info);
    const std::string value = info.get(settings), was = info.get(first);
    return row(
        {std::string(info.name), std::string(info.unit), std::string(info.values),
         std::string(info.help)},
        value == was,
        [&] {
            if (takes.automatic)
                return draw_automatic(info, takes, settings);
            if (takes.range)
                return draw_number(info, takes, settings);
            std::string chosen = value;
            return draw_choice(chosen, takes.names) && set(info, settings, chosen);
        },
        [&] { info.set(settings, was); });
}

}  // namespace fumarole::window
