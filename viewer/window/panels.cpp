#include "window/panels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include "light_fields.h"
#include "window/controls.h"
#include "window/keys.h"
#include "window/look.h"
#include "window/scene_handles.h"

namespace fumarole::window {

namespace {

bool section(const char* name, bool open = true)
{
    return ImGui::CollapsingHeader(name, open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
}

void text(const std::string& line)
{
    ImGui::TextWrapped("%s", line.c_str());
}

template <typename... T> void say(fmt::format_string<T...> format, T&&... arguments)
{
    text(fmt::format(format, std::forward<T>(arguments)...));
}

bool setting_group(std::string_view group, ViewState& state)
{
    const Settings first = find_preset(state.preset);
    bool changed = false;
    for (const SettingInfo& info : setting_table())
        if (info.group == group)
            changed |= setting_control(info, state.settings, first);
    return changed;
}

// ------------------------------------------------------------------------------- path of light

template <typename T> const T* same_kind(const Medium* first)
{
    return first == nullptr ? nullptr : std::get_if<T>(first);
}

bool medium_controls(GridMedium& medium, const GridMedium& first)
{
    text(std::filesystem::path(medium.file).filename().string() +
         (medium.grid.empty() ? "" : ": " + medium.grid));
    bool changed = triple_control({"sigma_s", "1/m", "", "scattering per unit of density"},
                                  medium.sigma_s_per_density, 0, first.sigma_s_per_density);
    changed |= triple_control({"sigma_a", "1/m", "", "absorption per unit of density"},
                              medium.sigma_a_per_density, 0, first.sigma_a_per_density);
    changed |= number_control({"g", "", "", "Henyey-Greenstein: > 0 scatters forward"}, medium.g,
                              -0.99f, 0.99f, first.g);
    if (medium.emission != nullptr)
        changed |= triple_control(
            {"emission", "", "", "W/m^2/sr per metre, per unit of the emission grid"},
            medium.emission_per_unit, 0, first.emission_per_unit);
    if (medium.temperature != nullptr) {
        changed |= number_control({"kelvin", "K", "", "per unit of the temperature grid"},
                                  medium.temperature_scale, 1, 5000, first.temperature_scale);
        changed |=
            number_control({"blackbody", "", "", "intensity; 1: a blackbody's, in MW/m^2/sr"},
                           medium.blackbody_intensity, 0, 1000, first.blackbody_intensity);
        changed |= triple_control({"tint", "", "", "times the blackbody's colour"},
                                  medium.blackbody_tint, 0, first.blackbody_tint);
    }
    changed |= triple_control({"translate", "m", "", "where the grid stands"}, medium.translate,
                              -1e9, first.translate);
    changed |=
        number_control({"scale", "", "", "of the grid"}, medium.scale, 0.01, 100, first.scale);
    return changed;
}

bool profile_controls(Profile& profile, const Profile& first)
{
    if (auto* height = std::get_if<ExpHeightProfile>(&profile)) {
        const auto& was = std::get<ExpHeightProfile>(first);
        bool changed = number_control({"scale height", "m", "", "over which it thins by e"},
                                      height->scale_height, 0.01, 1000, was.scale_height);
        changed |= number_control({"z0", "m", "", "where it has its coefficients"}, height->z0,
                                  -100, 100, was.z0);
        return changed;
    }
    auto* noise = std::get_if<NoiseProfile>(&profile);
    if (noise == nullptr)
        return false;
    const auto& was = std::get<NoiseProfile>(first);
    bool changed = number_control({"feature size", "m", "", "of the first octave's cells"},
                                  noise->feature_size, 0.01, 100, was.feature_size);
    changed |= number_control({"octaves", "", "", "of noise"}, noise->octaves, 1, 16, was.octaves);
    changed |= number_control({"threshold", "", "", "noise under it is empty"}, noise->threshold, 0,
                              0.99, was.threshold);
    return changed;
}

bool medium_controls(BoxMedium& medium, const BoxMedium& first)
{
    bool changed =
        triple_control({"sigma_s", "1/m", "", "scattering"}, medium.sigma_s, 0, first.sigma_s);
    changed |=
        triple_control({"sigma_a", "1/m", "", "absorption"}, medium.sigma_a, 0, first.sigma_a);
    changed |= number_control({"g", "", "", "Henyey-Greenstein: > 0 scatters forward"}, medium.g,
                              -0.99f, 0.99f, first.g);
    changed |= triple_control({"emission", "", "", "W/m^2/sr per metre"}, medium.emission, 0,
                              first.emission);
    if (medium.profile.index() == first.profile.index())
        changed |= profile_controls(medium.profile, first.profile);
    return changed;
}

bool draw_media(Scene& scene, const Scene& first)
{
    bool changed = false;
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        const Medium* was = i < first.media.size() ? &first.media[i] : nullptr;
        if (i > 0)
            ImGui::Separator();
        if (auto* grid = std::get_if<GridMedium>(&scene.media[i])) {
            const auto* kind = same_kind<GridMedium>(was);
            changed |= medium_controls(*grid, kind != nullptr ? *kind : GridMedium(*grid));
        } else {
            auto& box = std::get<BoxMedium>(scene.media[i]);
            const auto* kind = same_kind<BoxMedium>(was);
            text("a box of fog");
            changed |= medium_controls(box, kind != nullptr ? *kind : BoxMedium(box));
        }
        ImGui::PopID();
    }
    return changed;
}

bool direction_controls(glm::dvec3& direction, const glm::dvec3& first, const char* what)
{
    const auto angles = [](const glm::dvec3& d) {
        return glm::dvec2(glm::degrees(std::atan2(d.y, d.x)),
                          glm::degrees(std::asin(std::clamp(d.z, -1.0, 1.0))));
    };
    glm::dvec2 now = angles(direction);
    const glm::dvec2 was = angles(first);
    bool changed = number_control({"azimuth", "deg", "", std::string(what) + ", from +x to +y"},
                                  now.x, -180, 180, was.x);
    changed |= number_control({"elevation", "deg", "", std::string(what) + ", over the horizon"},
                              now.y, -90, 90, was.y);
    if (changed) {
        const glm::dvec2 a = glm::radians(now);
        direction = {std::cos(a.y) * std::cos(a.x), std::cos(a.y) * std::sin(a.x), std::sin(a.y)};
    }
    return changed;
}

/// A control for each field of a light, and of the light that its resets go back to.
struct LightControls {
    bool changed = false;

    static ControlText text_of(const LightField& field)
    {
        return {field.label, field.sign, "", field.help};
    }
    void to_light(const LightField& field, glm::dvec3& d, const glm::dvec3& first)
    {
        changed |= direction_controls(d, first, field.help);
    }
    void axis(const LightField& field, glm::dvec3& d, const glm::dvec3& first)
    {
        changed |= direction_controls(d, first, field.help);
    }
    void position(const LightField& field, glm::dvec3& p, const glm::dvec3& first)
    {
        changed |= triple_control(text_of(field), p, -1e9, first);
    }
    void number(const LightField& field, double& value, double first)
    {
        const bool bounded = std::isfinite(field.max);
        const double inset = !field.open ? 0 : bounded ? 1 : 1e-3;
        changed |= number_control(text_of(field), value, field.min + inset,
                                  bounded ? field.max - inset : 1e3, first);
    }
    void flag(const LightField& field, bool& value, bool first)
    {
        changed |= switch_control(text_of(field), value, first);
    }
    void edges(const LightField& field, std::array<glm::dvec3, 2>& value,
               const std::array<glm::dvec3, 2>& first)
    {
        for (std::size_t i = 0; i < value.size(); ++i) {
            ControlText words = text_of(field);
            words.label = fmt::format("{} {}", field.label, "uv"[i]);
            changed |= triple_control(words, value.at(i), -1e9, first.at(i));
        }
    }
    void power(const LightField& field, glm::vec3& value, const glm::vec3& first)
    {
        changed |= triple_control(text_of(field), value, 0, first);
    }
};

bool light_controls(Light& light, const Light& was)
{
    LightControls controls;
    std::visit(
        [&](auto& one) {
            using Type = std::remove_reference_t<decltype(one)>;
            const Type first = std::get<Type>(was);
            visit_fields(controls, one, first);
        },
        light);
    return controls.changed;
}

bool look_controls(TransparentLook& look, const TransparentLook& first, bool may_cast)
{
    bool changed = false;
    if (look.image != nullptr)
        changed |= number_control({"scale", "W/m2/sr", "", "of the image's 1"}, look.scale, 0.001f,
                                  1000, first.scale);
    else if (look.blend.kind == Blend::Kind::multiply)
        changed |= triple_control({"filter", "", "", "what it lets through"}, look.filter, 0,
                                  first.filter);
    else
        changed |= triple_control({"radiance", "W/m2/sr", "", "that it sends"}, look.radiance, 0,
                                  first.radiance);
    changed |= number_control({"alpha", "", "", "opacity"}, look.alpha, 0, 1, first.alpha);
    changed |= number_control({"depth fade", "m", "", "before a surface; 0: none"}, look.depth_fade,
                              0, 10, first.depth_fade);
    if (may_cast)
        changed |= switch_control({"casts", "", "", "filters light too: coloured shadows"},
                                  look.casts, first.casts);
    return changed;
}

bool draw_transparents(Document& document)
{
    bool changed = false;
    const Scene& first = document.as_read();
    for (std::size_t i = 0; i < document.transparent_count(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        Transparent& transparent = document.transparent(i);
        bool on = document.is_on(i);
        const bool switched = ImGui::Checkbox(
            fmt::format("{} {}", transparent_name(transparent), i + 1).c_str(), &on);
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        const bool same =
            i < first.transparents.size() && first.transparents[i].index() == transparent.index();
        Transparent was = same ? first.transparents[i] : transparent;
        changed |= triple_control({"position", "m", "", "in the world"}, place_of(transparent),
                                  -1e9, place_of(was));
        TransparentLook& look = look_of(transparent);
        changed |= look_controls(look, look_of(was),
                                 can_cast(look.blend) &&
                                     !std::holds_alternative<BillboardTransparent>(transparent));
        ImGui::PopID();
        if (gone) {
            document.remove_transparent(i);
            return true;
        }
        if (switched) {
            document.switch_transparent(i, on);
            return true;
        }
    }
    return changed;
}

bool draw_lights(ViewState& state, Scene& scene, const Scene& first)
{
    bool changed = false;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        Light& light = scene.lights[i];
        say("{} {}", light_name(light), i + 1);
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        const bool same = i < first.lights.size() && first.lights[i].index() == light.index();
        const Light own = light;
        changed |= light_controls(light, same ? first.lights[i] : own);
        ImGui::PopID();
        if (gone) {
            scene.lights.erase(scene.lights.begin() + static_cast<std::ptrdiff_t>(i));
            return true;
        }
    }
    text("add");
    for (const Light& type : light_types()) {
        ImGui::SameLine();
        if (!ImGui::SmallButton(light_name(type)))
            continue;
        Light light = type;
        const Bounds subject = subject_of(scene);
        if (!position_of(light).far)
            move_to(light, subject.empty() ? scene.camera.look_at
                                           : 0.5 * (subject.min + subject.max) +
                                                 glm::dvec3(0, 0, 0.6 * subject.diagonal()));
        if (!subject.empty())
            scale_to(light, subject.diagonal());
        scene.lights.push_back(light);
        changed = true;
    }
    switch_control({"handles", "", "", "drag lights, probes and transparents in the picture (L)"},
                   state.lights, false);
    if (scene.world.environment == nullptr)
        changed |= triple_control({"world", "W/m2/sr", "", "radiance of the world"},
                                  scene.world.radiance, 0, first.world.radiance);
    else
        changed |=
            number_control({"world", "x", "", "the environment map is scaled by it"},
                           scene.world.environment_scale, 0, 100, first.world.environment_scale);
    return changed;
}

/// A row for each probe: where it is, when it was last captured, and what that cost.
bool draw_probes(const PanelContext& context, Scene& scene, const Scene& first)
{
    bool changed = false;
    const Renderer& renderer = context.viewport.renderer();
    const std::vector<ProbeState> states = renderer.probes();
    if (const std::string placement = renderer.probe_placement(); !placement.empty())
        text(placement);
    for (std::size_t i = 0; i < states.size(); ++i) {
        const ProbeState& state = states[i];
        if (state.captures == 0)
            say("probe {}: not captured yet", i);
        else
            say("probe {}: captured {:.0f} s ago{}, {} times", i, state.seconds_ago,
                state.capture_ms ? fmt::format(", in {:.0f} ms", *state.capture_ms) : "",
                state.captures);
        if (!state.by_itself)
            continue;
        ImGui::SameLine();
        if (ImGui::SmallButton("keep")) {  // to be moved, and saved with the scene
            scene.probes.push_back(state.probe);
            return true;
        }
    }
    for (std::size_t i = 0; i < scene.probes.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        LightProbe& probe = scene.probes[i];
        const LightProbe was = i < first.probes.size() ? first.probes[i] : probe;
        say("probe {}", i);
        ImGui::SameLine();
        const bool gone = ImGui::SmallButton("remove");
        changed |= triple_control({"position", "m", "", "in the world"}, probe.position, -1e9,
                                  was.position);
        changed |= number_control({"radius", "m", "", "within which surfaces have light from it"},
                                  probe.radius, 1e-3, 1e4, was.radius);
        changed |= number_control({"falloff", "", "", "part of it over which that ends"},
                                  probe.falloff, 0, 1, was.falloff);
        ImGui::PopID();
        if (gone) {
            scene.probes.erase(scene.probes.begin() + static_cast<std::ptrdiff_t>(i));
            return true;
        }
    }
    return changed;
}

// ----------------------------------------------------------------------------- other sections

void draw_actions(const PanelContext& context, PanelWishes& wishes)
{
    const auto button = [&](const char* name, Action action) {
        if (ImGui::Button(name))
            wishes.actions.push_back(action);
    };
    button("fit", Action::fit);
    ImGui::SameLine();
    button("first camera", Action::first_camera);
    ImGui::SameLine();
    button("save scene", Action::save_scene);
    button("PNG", Action::save_png);
    ImGui::SameLine();
    button("EXR", Action::save_exr);
    ImGui::SameLine();
    button("copy command line", Action::copy_command);
    for (const std::string& note : context.document.notes())
        ImGui::TextDisabled("%s", note.c_str());
}

void draw_file(const PanelContext& context, std::string& path, PanelWishes& wishes)
{
    const Document& document = context.document;
    text(document.input().file.empty() ? "no file" : document.input().file);
    if (ImGui::InputTextWithHint("##path", "a .vdb or a scene", &path,
                                 ImGuiInputTextFlags_EnterReturnsTrue) &&
        !path.empty())
        wishes.open = path;
    ImGui::SameLine();
    if (ImGui::Button("open") && !path.empty())
        wishes.open = path;
    if (ImGui::Button("files ..."))
        wishes.actions.push_back(Action::browse);
    if (ImGui::IsItemHovered())
        ImGui::SetTooltip("look for a file by its picture (Ctrl+O)");
    if (!context.recent.empty()) {
        ImGui::SameLine();
        ImGui::SetNextItemWidth(-1);
        if (ImGui::BeginCombo("##recent", "recent")) {
            for (const std::string& file : context.recent)
                if (ImGui::Selectable(file.c_str()))
                    wishes.open = file;
            ImGui::EndCombo();
        }
    }
    if (document.loading())
        say("{} ...", document.progress());
    if (document.whole())
        draw_actions(context, wishes);
}

/// What is known of a grid. @param all of its type too, and all digits
std::string about(const GridRow& row, bool all)
{
    std::string voxels = fmt::format("{}", row.voxels);
    for (std::size_t at = voxels.size(); at > 3; at -= 3)
        voxels.insert(at - 3, ",");
    std::string text = fmt::format("{}; {} voxels",
                                   all ? row.type : row.type.substr(0, row.type.find(',')), voxels);
    if (row.range)
        text += all ? fmt::format("; {:.9g} .. {:.9g}", row.range->first, row.range->second)
                    : fmt::format("; {:.3g} .. {:.3g}", row.range->first, row.range->second);
    return text;
}

/// What one grid is taken for. @returns what it is to be taken for from now on, if that is another
std::optional<GridRole> role_control(const GridRow& row, const std::vector<GridRole>& roles)
{
    std::optional<GridRole> chosen;
    if (!ImGui::BeginCombo("##role", roles_text(roles).c_str()))
        return chosen;
    for (const GridRole role : grid_roles()) {
        const std::string refusal = role_refusal(row, role);
        const bool now =
            roles.empty() ? role == GridRole::off : roles == std::vector<GridRole>{role};
        const bool picked = ImGui::Selectable(std::string(role_name(role)).c_str(), now,
                                              refusal.empty() ? 0 : ImGuiSelectableFlags_Disabled);
        if (picked && !now)
            chosen = role;
        if (!refusal.empty() && ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
            ImGui::SetTooltip("%s", refusal.c_str());
    }
    ImGui::EndCombo();
    return chosen;
}

/// What went wrong, beside what was asked for.
void draw_wrong(const std::string& error)
{
    if (error.empty())
        return;
    ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.92f, 0.51f, 0.43f, 1));
    text(error);
    ImGui::PopStyleColor();
}

/// The grids of each medium's file, and what each is taken for.
void draw_grids(Document& document)
{
    const std::vector<GridList>& lists = document.grids().lists();
    const std::vector<Medium>& media = document.scene().media;
    for (std::size_t i = 0; i < std::min(lists.size(), media.size()); ++i) {
        const auto* medium = std::get_if<GridMedium>(&media[i]);
        if (medium == nullptr || medium->file.empty())
            continue;
        const GridList& list = lists[i];
        ImGui::PushID(static_cast<int>(i));
        if (media.size() > 1)
            text(std::filesystem::path(medium->file).filename().string());
        if (!list.listed)
            ImGui::TextDisabled("reading its grids ...");
        if (!find_row(list.rows, list.wrong))
            draw_wrong(list.error);
        std::optional<std::pair<std::size_t, GridRole>> chosen;
        for (std::size_t row = 0; row < list.rows.size(); ++row) {
            const GridRow& grid = list.rows[row];
            ImGui::PushID(static_cast<int>(row));
            const float width = ImGui::GetContentRegionAvail().x;
            ImGui::AlignTextToFramePadding();
            ImGui::TextUnformatted(grid.name.empty() ? "(no name)" : grid.name.c_str());
            ImGui::SameLine(width * 0.54f);
            ImGui::SetNextItemWidth(-1);
            if (const auto role = role_control(grid, roles_of(*medium, list.rows, row)))
                chosen = {row, *role};
            ImGui::TextDisabled("%s", about(grid, false).c_str());
            if (ImGui::IsItemHovered())
                ImGui::SetTooltip("%s\n%s", grid.name.c_str(), about(grid, true).c_str());
            if (find_row(list.rows, list.wrong) == row)
                draw_wrong(list.error);
            ImGui::PopID();
        }
        if (chosen)
            document.give_role(i, list.rows[chosen->first].name, chosen->second);
        ImGui::PopID();
    }
    if (const std::string progress = document.grids().progress(); !progress.empty())
        ImGui::TextDisabled("%s ...", progress.c_str());
}

bool has_grids(const Scene& scene)
{
    return std::any_of(scene.media.begin(), scene.media.end(), [](const Medium& medium) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        return grid != nullptr && !grid->file.empty();
    });
}

bool draw_mode(ViewState& state)
{
    bool changed = false;
    const auto mode = [&](const char* name, bool on, auto&& choose) {
        if (ImGui::RadioButton(name, on) && !on) {
            choose();
            changed = true;
        }
    };
    const bool froxel = state.settings.mode == Settings::Mode::froxel;
    mode("ray march", !froxel && !state.reference, [&] {
        state.settings.mode = Settings::Mode::raymarch;
        state.reference = false;
    });
    ImGui::SameLine();
    mode("froxels", froxel && !state.reference, [&] {
        state.settings.mode = Settings::Mode::froxel;
        state.reference = false;
    });
    ImGui::SameLine();
    mode("reference", state.reference, [&] { state.reference = true; });
    std::vector<std::string> names;
    for (const auto& [name, settings] : presets())
        names.emplace_back(name);
    std::string preset = state.preset;
    if (choice_control({"preset", "", "", "settings by name; a change starts from it"}, preset,
                       names, preset)) {
        change_setting(state, "preset", preset);
        changed = true;
    }
    return changed;
}

bool draw_compare(const PanelContext& context)
{
    ViewState& state = context.state;
    bool changed = false;
    const auto choose = [&](const char* name, Comparison comparison) {
        if (ImGui::RadioButton(name, state.comparison == comparison)) {
            changed |= state.comparison != comparison;
            state.comparison = comparison;
        }
    };
    choose("one", Comparison::none);
    ImGui::SameLine();
    choose("split", Comparison::split);
    ImGui::SameLine();
    choose("difference", Comparison::difference);
    changed |=
        choice_control({"with", "", "", "a mode with these settings, a preset, or the reference"},
                       state.other, others(), "eevee2017");
    if (state.comparison == Comparison::difference)
        number_control({"scale", "", "", "difference at the end of the colours; 0: what suits"},
                       state.difference_scale, 0, 10, 0);
    number_control({"tolerance", "", "", "of the reference: relative error of a pixel"},
                   state.tolerance, 1e-3, 0.5, 0.1);
    const ReferenceView& reference = context.viewport.reference();
    if (const auto& picture = reference.picture(); reference.busy() || picture.share > 0) {
        ImGui::ProgressBar(static_cast<float>(picture.share), {-1, 0},
                           fmt::format("reference {:.0f} %", 100 * picture.share).c_str());
        if (!picture.error.empty())
            text("reference: " + picture.error);
    }
    for (const ErrorFigures& side : reference.errors())
        say("{}: relMSE {:.2e}, bias {:+.2f} %, SMAPE {:.2f} %, 99.9 %: {:.2g}", side.name,
            side.metrics.relmse, 100 * side.metrics.bias, 100 * side.metrics.smape,
            side.metrics.p999);
    return changed;
}

bool draw_inside(ViewState& state)
{
    std::vector<std::string> names{"the picture"};
    for (const InspectionInfo& info : inspection_table())
        names.emplace_back(info.name);
    std::string shown =
        state.inspection ? std::string(inspection_name(state.inspection->kind)) : names.front();
    bool changed = false;
    if (choice_control({"show", "", "", "what is drawn instead of the picture (V: the next)"},
                       shown, names, names.front())) {
        if (shown == names.front()) {
            state.inspection.reset();
        } else {
            const Inspection::Kind kind = find_inspection(shown);
            if (!state.inspection)
                state.inspection.emplace();
            state.inspection->kind = kind;
        }
        changed = true;
    }
    if (!state.inspection)
        return changed;
    Inspection& what = *state.inspection;
    const bool density = what.kind == Inspection::Kind::density_slice;
    if (density) {
        std::string axis(1, "xyz"[what.axis]);
        if (choice_control({"axis", "", "", "that the slice is across"}, axis, {"x", "y", "z"},
                           "z")) {
            what.axis = axis[0] - 'x';
            changed = true;
        }
    }
    if (what.kind == Inspection::Kind::probe)
        changed |=
            number_control({"probe", "", "", "of the scene's, from 0"}, what.probe, 0, 15, 0);
    if (density || what.kind == Inspection::Kind::froxel_slice)
        changed |= number_control({"position", "", "", "0..1 of the media, or of the slices"},
                                  what.position, 0, 1, 0.5);
    if (what.kind != Inspection::Kind::scattering && what.kind != Inspection::Kind::probe &&
        what.kind != Inspection::Kind::transmittance)
        changed |=
            number_control({"scale", "", "", "value at the end of the colours; 0: what suits"},
                           what.scale, 0, 1e5, 0);
    return changed;
}

bool draw_display(ViewState& state)
{
    bool changed =
        switch_control({"auto exposure", "", "", "from the picture, when a scene is new"},
                       state.auto_exposure, true);
    std::string transform = state.transform == Display::Transform::srgb ? "srgb" : "filmic";
    if (choice_control({"display", "", "", "transform for the screen"}, transform,
                       {"filmic", "srgb"}, "filmic"))
        state.transform =
            transform == "srgb" ? Display::Transform::srgb : Display::Transform::filmic;
    changed |= number_control({"aa", "frames", "", "averaged at rest"}, state.aa, 1, 256, 16);
    number_control(
        {"frame time", "ms", "", "held while things move, by lower resolution and fewer steps"},
        state.target_ms, 5, 1000, 33);
    return changed;
}

void draw_cost(const PanelContext& context)
{
    const Viewport& viewport = context.viewport;
    const DrawStatistics& cost = viewport.statistics();
    const Side& a = viewport.sides().a();
    if (!cost.gpu_ms.empty()) {
        const float largest = *std::max_element(cost.gpu_ms.begin(), cost.gpu_ms.end());
        ImGui::PlotLines("##ms", cost.gpu_ms.data(), static_cast<int>(cost.gpu_ms.size()), 0,
                         fmt::format("{:.1f} ms a frame", cost.frame_ms).c_str(), 0, largest * 1.1f,
                         {-1, ImGui::GetFontSize() * 4});
    }
    for (const auto& [name, ms] : a.report().pass_ms)
        say("{:<24}{:>9.2f} ms", name, ms);
    if (const Side* b = viewport.sides().b(); b != nullptr && context.state.compares())
        for (const auto& [name, ms] : b->report().pass_ms)
            say("B {:<22}{:>9.2f} ms", name, ms);
    say("set-up {:.0f} ms; loss {} of {} to keep the frame time", a.setup_ms(),
        viewport.pace().level(), Pace::levels() - 1);
    const glm::ivec2 pixels(a.picture().size());
    say("{} x {}, frame {} of {}", pixels.x, pixels.y, a.frames(), context.state.aa);
    if (cost.samples > 0)
        say("{:.3g} evaluations of the media", cost.samples);
    say("{:.1f} MB in textures and buffers", static_cast<double>(a.report().gpu_bytes) * 1e-6);
    if (!a.report().history.empty())
        say("history: {}", a.report().history);
    say("{}, {}", context.device, context.viewport.timing_method());
}

/// The few numbers that an artist turns; all others are under `advanced`.
bool draw_look(const PanelContext& context)
{
    Scene& scene = context.document.scene();
    const Scene& first = context.document.as_read();
    bool changed = false;
    if (double density = density_of(scene, first); density > 0) {
        if (number_control({"density", "x", "", "of all smoke, over what the file had"}, density,
                           1.0 / 64, 64, 1)) {
            set_density(scene, first, density);
            changed = true;
        }
        glm::vec3 albedo = albedo_of(scene);
        if (color_control({"colour", "", "", "of the smoke: how much of each colour it scatters"},
                          albedo, albedo_of(first))) {
            set_albedo(scene, albedo);
            changed = true;
        }
        float g = anisotropy_of(scene);
        if (number_control({"anisotropy", "", "", "> 0 scatters forward: it glows against a light"},
                           g, -0.95f, 0.95f, anisotropy_of(first))) {
            set_anisotropy(scene, g);
            changed = true;
        }
    }
    if (double fire = fire_of(scene, first); fire > 0 && has_fire(scene))
        if (number_control({"fire", "x", "", "its intensity, over what the file had"}, fire,
                           1.0 / 64, 64, 1)) {
            set_fire(scene, first, fire);
            changed = true;
        }
    if (SunLight* sun = sun_of(scene)) {
        Scene read = first;
        const SunLight was = sun_of(read) != nullptr ? *sun_of(read) : *sun;
        changed |=
            direction_controls(sun->direction_to_light, was.direction_to_light, "of the sun");
        const float base = std::max({was.irradiance.x, was.irradiance.y, was.irradiance.z});
        float strength = std::max({sun->irradiance.x, sun->irradiance.y, sun->irradiance.z});
        if (base > 0 && strength > 0) {
            strength /= base;
            if (number_control({"sun", "x", "", "its strength, over what the file had"}, strength,
                               1.0f / 64, 64, 1)) {
                sun->irradiance = strength * was.irradiance;
                changed = true;
            }
        }
    }
    double sky = sky_of(scene, first);
    if (number_control({"sky", "x", "", "light from all around, over what the file had"}, sky, 0,
                       16, sky_of(first, first))) {
        set_sky(scene, first, sky);
        changed = true;
    }
    return changed;
}

void draw_exposure(ViewState& state)
{
    if (number_control({"exposure", "stops", "", "radiance is multiplied by 2^stops"},
                       state.exposure_ev, -15, 15, state.exposure_ev))
        state.auto_exposure = false;
}

/// One slider for all settings of quality: those that the plan finds for an error or for a time are
/// looked for once it is let go.
void draw_quality(const PanelContext& context, PanelQuality& quality, PanelWishes& wishes)
{
    using Kind = study::PlanGoal::Kind;
    const bool by_time = quality.by_time;
    if (by_time)
        quality.due |= number_control({"quality", "ms", "", "the best that this time can buy"},
                                      quality.budget_ms, 1, 500, 16);
    else
        quality.due |= number_control({"quality", "", "",
                                       "error of a frame (the root of relMSE), "
                                       "by the cheapest settings that keep it"},
                                      quality.max_error, 0.001f, 0.3f, 0.01f);
    quality.by_time = ImGui::RadioButton("by time", by_time) || by_time;
    ImGui::SameLine();
    if (ImGui::RadioButton("by error", !by_time))
        quality.by_time = false;
    quality.due |= quality.by_time != by_time;
    if (quality.due && !ImGui::IsAnyItemActive()) {
        quality.due = false;
        wishes.plan = quality.by_time ? study::PlanGoal{Kind::budget, double{quality.budget_ms}}
                                      : study::PlanGoal{Kind::max_error, double{quality.max_error}};
    }
    if (!context.plan.empty())
        text(context.plan);
}

void draw_content(const PanelContext& context, PanelWishes& wishes)
{
    ViewState& state = context.state;
    Scene& scene = context.document.scene();
    const Scene& first = context.document.as_read();
    bool changed = false;
    if (section("medium")) {
        changed |= draw_media(scene, first);
        changed |= setting_group("medium", state);
    }
    if (section("lights", false)) {
        changed |= draw_lights(state, scene, first);
        changed |= setting_group("light", state);
    }
    if (!scene.surfaces.empty() && section("probes", false))
        changed |= draw_probes(context, scene, first);
    if (context.document.transparent_count() > 0 && section("transparents", false))
        changed |= draw_transparents(context.document);
    if (changed)
        include(wishes.change, Change::content);
}

bool draw_mode_settings(ViewState& state)
{
    bool changed = draw_mode(state);
    const bool froxel = state.settings.mode == Settings::Mode::froxel;
    changed |= setting_group(froxel ? "froxel" : "march", state);
    if (froxel && ImGui::TreeNode("shared with the march")) {
        changed |= setting_group("march", state);
        ImGui::TreePop();
    }
    return changed;
}

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;
/// A click on them leaves what lies over them where it is.
constexpr ImGuiWindowFlags kBehind = kFixed | ImGuiWindowFlags_NoBringToFrontOnFocus;

}  // namespace

PanelWishes Panels::draw_panel(const PanelContext& context, const Layout& layout)
{
    PanelWishes wishes;
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({layout.panel_width, static_cast<float>(layout.window.y)});
    ImGui::Begin("panel", nullptr, kBehind | ImGuiWindowFlags_NoTitleBar);
    if (section("file"))
        draw_file(context, path_, wishes);
    if (context.document.whole())
        draw_sections(context, wishes);
    ImGui::End();
    return wishes;
}

void Panels::draw_sections(const PanelContext& context, PanelWishes& wishes)
{
    ViewState& state = context.state;
    bool changed = false;
    if (section("look")) {
        if (draw_look(context))
            include(wishes.change, Change::content);
        draw_exposure(state);
        draw_quality(context, quality_, wishes);
    }
    if (has_grids(context.document.scene()) && section("grids"))
        draw_grids(context.document);
    if (section("compare"))
        changed |= draw_compare(context);
    if (section("see inside", false))
        changed |= draw_inside(state);
    if (section("cost", false))
        draw_cost(context);
    if (section("advanced", false)) {
        ImGui::Indent();
        draw_content(context, wishes);
        if (section("mode"))
            changed |= draw_mode_settings(state);
        if (section("resolve", false))
            changed |= setting_group("resolve", state);
        if (section("display"))
            changed |= draw_display(state);
        if (section("what the scene needs", false))
            for (const std::string& line : context.viewport.explain(state.settings))
                text(line);
        ImGui::Unindent();
    }
    ImGui::TextDisabled("? lists the keys");
    if (changed)
        include(wishes.change, Change::view);
}

void Panels::draw_timeline(Sequence& sequence, const Layout& layout)
{
    Playback& playback = sequence.playback();
    const glm::vec2 corner(layout.window);
    const float width = corner.x - layout.panel_width;
    ImGui::SetNextWindowPos({layout.panel_width, corner.y - layout.timeline_height});
    ImGui::SetNextWindowSize({width, layout.timeline_height});
    ImGui::Begin("timeline", nullptr,
                 kBehind | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoScrollbar);
    if (ImGui::Button(playback.playing() ? "pause" : "play"))
        playback.play(!playback.playing());
    ImGui::SameLine();
    int frame = playback.frame();
    ImGui::SetNextItemWidth(std::max(60.0f, width - ImGui::GetFontSize() * 27));
    if (ImGui::SliderInt("##frame", &frame, playback.first(), playback.last(), "frame %d",
                         ImGuiSliderFlags_AlwaysClamp))
        playback.scrub(frame);
    ImGui::SameLine();
    ImGui::Checkbox("loop", &playback.loop);
    ImGui::SameLine();
    auto rate = static_cast<float>(playback.frames_per_second);
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 6);
    if (ImGui::SliderFloat("##fps", &rate, 1, 120, "%.3g/s", ImGuiSliderFlags_AlwaysClamp))
        playback.frames_per_second = rate;
    ImGui::SameLine();
    ImGui::TextDisabled("%s", fmt::format("{} frames there{}", sequence.frames_there(),
                                          sequence.waits() ? ", reading" : "")
                                  .c_str());
    ImGui::End();
}

bool Panels::draw_help(glm::vec2 size)
{
    bool open = true;
    ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin("keys", &open, kFixed | ImGuiWindowFlags_AlwaysAutoResize);
    if (ImGui::BeginTable("keys", 2)) {
        const auto line = [](std::string_view left, std::string_view right) {
            ImGui::TableNextRow();
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(left.data(), left.data() + left.size());
            ImGui::TableNextColumn();
            ImGui::TextUnformatted(right.data(), right.data() + right.size());
        };
        for (const KeyBinding& binding : key_table())
            line(binding.name, binding.help);
        for (const auto& [gesture, meaning] : pointer_table())
            line(gesture, meaning);
        ImGui::EndTable();
    }
    ImGui::End();
    return open;
}

bool Panels::draw_message(const std::string& message, glm::vec2 size)
{
    ImGui::SetNextWindowPos({size.x / 2, size.y * 0.4f}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowSize({std::min(size.x * 0.9f, ImGui::GetFontSize() * 34), 0});
    ImGui::Begin("message", nullptr, kFixed);
    text(message);
    const bool open = !ImGui::Button("close");
    ImGui::End();
    return open;
}

}  // namespace fumarole::window
