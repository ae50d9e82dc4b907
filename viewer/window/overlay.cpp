#include "window/overlay.h"

#include <algorithm>
#include <fmt/format.h>
#include <imgui.h>

#include "light_fields.h"
#include "study/false_color.h"
#include "window/scene_handles.h"

namespace fumarole::window {

namespace {

ImDrawList& background()
{
    return *ImGui::GetBackgroundDrawList();
}

void draw_label(const std::string& words, float x, float y)
{
    const ImVec2 extent = ImGui::CalcTextSize(words.c_str());
    background().AddRectFilled({x - 4, y - 2}, {x + extent.x + 4, y + extent.y + 2},
                               IM_COL32(20, 20, 22, 190));
    background().AddText({x, y}, IM_COL32(230, 230, 230, 255), words.c_str());
}

/// A text in the middle of the picture's part of the window.
void draw_greeting(const std::string& greeting, const Area& picture)
{
    const glm::vec2 at(picture.at), size(picture.size);
    const ImVec2 extent = ImGui::CalcTextSize(greeting.c_str(), nullptr, false, size.x * 0.9f);
    background().AddText(nullptr, 0,
                         {at.x + (size.x - extent.x) / 2, at.y + (size.y - extent.y) / 2},
                         IM_COL32(210, 210, 210, 255), greeting.c_str(), nullptr, size.x * 0.9f);
}

/// What false colours mean, at the lower right corner.
void draw_legend(const std::string& caption, double low, double high, const std::string& unit,
                 const Area& picture)
{
    ImDrawList& draw = background();
    const glm::vec2 corner(picture.at + picture.size);
    const float em = ImGui::GetFontSize();
    const float width = std::max(16 * em, ImGui::CalcTextSize(caption.c_str()).x);
    const float bar = 0.8f * em;
    const ImVec2 at{corner.x - width - em, corner.y - 3.6f * em};
    draw.AddRectFilled({at.x - 0.5f * em, at.y - 0.3f * em}, {corner.x - 0.5f * em, corner.y},
                       IM_COL32(20, 20, 22, 210));
    constexpr int kPieces = 64;
    const auto piece = [&](int i) { return at.x + width * static_cast<float>(i) / kPieces; };
    for (int i = 0; i < kPieces; ++i) {
        const glm::vec3 color = write::display_transform(
            study::difference_color((static_cast<float>(i) + 0.5f) / kPieces,
                                    study::Difference::magnitude),
            {.exposure_ev = 0, .transform = Display::Transform::srgb});
        draw.AddRectFilled({piece(i), at.y}, {piece(i + 1), at.y + bar},
                           ImGui::ColorConvertFloat4ToU32({color.r, color.g, color.b, 1}));
    }
    const ImU32 ink = IM_COL32(230, 230, 230, 255);
    const std::string end = fmt::format("{:.3g} {}", high, unit);
    draw.AddText({at.x, at.y + bar}, ink, fmt::format("{:.3g}", low).c_str());
    draw.AddText({at.x + width - ImGui::CalcTextSize(end.c_str()).x, at.y + bar}, ink, end.c_str());
    draw.AddText({at.x, at.y + bar + 1.2f * em}, ink, caption.c_str());
}

/// What is shown: the mode at the left, both sides of a split, or the legend of their difference.
void draw_names(const OverlayContext& context)
{
    const ViewState& state = context.state;
    const Area& picture = context.layout.picture;
    const glm::vec2 at(picture.at);
    const float em = ImGui::GetFontSize();
    const std::string a =
        state.reference
            ? fmt::format("reference {:.0f} %", 100 * context.viewport.reference().picture().share)
            : std::string(mode_name(state.settings.mode));
    if (state.comparison == Comparison::split) {
        const float line = at.x + static_cast<float>(state.wipe * picture.size.x);
        draw_label(a, line - ImGui::CalcTextSize(a.c_str()).x - em, at.y + em);
        draw_label(state.other, line + em, at.y + em);
        if (context.pointer.over_split(state, picture))
            ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    } else if (state.comparison == Comparison::difference) {
        draw_legend(fmt::format("{} against {}, relative", a, state.other), 0,
                    100 * context.viewport.difference_scale(), "%", picture);
    } else {
        draw_label(a, at.x + em, at.y + em);
    }
}

void draw_inspection_legend(const OverlayContext& context)
{
    const Area& picture = context.layout.picture;
    const InspectionLegend& legend = context.viewport.sides().a().legend();
    const glm::vec2 corner(picture.at + picture.size);
    const float em = ImGui::GetFontSize();
    if (legend.false_color)
        draw_legend(legend.caption, legend.low, legend.high, legend.unit, picture);
    else
        draw_label(legend.caption, corner.x - 20 * em, corner.y - 2 * em);
}

void draw_handles(const Scene& scene, const Area& picture)
{
    ImDrawList& draw = background();
    const float em = ImGui::GetFontSize();
    const auto draw_handle = [&](const Handle& handle, ImU32 color, const std::string& name) {
        const glm::vec2 p(picture.at + handle.at * picture.size);
        if (!picture.holds(p))
            return;
        draw.AddCircleFilled({p.x, p.y}, 0.4f * em, color);
        draw.AddCircle({p.x, p.y}, 0.7f * em, IM_COL32(30, 30, 30, 255), 0, 2);
        draw_label(name, p.x + em, p.y - 0.5f * em);
    };
    for (const Handle& handle : transparent_handles(scene, picture.aspect()))
        draw_handle(handle, IM_COL32(130, 200, 255, 255),
                    transparent_name(scene.transparents[handle.index]));
    for (const Handle& handle : probe_handles(scene, picture.aspect()))
        draw_handle(handle, IM_COL32(170, 255, 170, 255), fmt::format("probe {}", handle.index));
    for (const Handle& handle : light_handles(scene, picture.aspect()))
        draw_handle(handle, IM_COL32(255, 225, 120, 255), light_name(scene.lights[handle.index]));
}

}  // namespace

void draw_overlay(const OverlayContext& context)
{
    const Area& picture = context.layout.picture;
    if (context.layout.too_small()) {
        draw_greeting(fmt::format("this window is too small: {} x {} at least", kMinWindowSize.x,
                                  kMinWindowSize.y),
                      picture);
        return;
    }
    const float em = ImGui::GetFontSize();
    const float left = static_cast<float>(picture.at.x) + em,
                bottom = static_cast<float>(picture.at.y + picture.size.y) - 2 * em;
    if (context.document.empty())
        draw_greeting("drop a .vdb or a scene here, or look for one (Ctrl+O)", picture);
    if (context.document.loading())
        draw_label(context.document.progress() + " ...", left, bottom);
    if (const std::string note = context.notices.note(); !note.empty())
        draw_label(note, left, bottom);
    if (!context.document.whole())
        return;
    draw_names(context);
    if (context.state.inspection && context.state.comparison != Comparison::difference)
        draw_inspection_legend(context);
    if (context.state.lights)
        draw_handles(context.document.scene(), picture);
}

}  // namespace fumarole::window
