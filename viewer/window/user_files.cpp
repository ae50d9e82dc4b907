#include "window/user_files.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path xdg_folder(const char* variable, const char* in_home)
{
    // The specification has relative paths ignored.
    if (const char* named = std::getenv(variable);
        named != nullptr && fs::path(named).is_absolute())
        return fs::path(named) / "fumarole";
    const char* home = std::getenv("HOME");
    return home == nullptr ? fs::path() : fs::path(home) / in_home / "fumarole";
}

void read_state(const Json& json, ViewState& state)
{
    change_setting(state, "preset", json.value("preset", state.preset));
    const Json settings = json.value("settings", Json::object());
    for (const auto& [name, value] : settings.items())
        change_setting(state, name, value.get<std::string>());
    state.other = json.value("compare_with", state.other);
    static_cast<void>(other_settings(state));
    state.transform = json.value("display", "filmic") == std::string("srgb")
                          ? Display::Transform::srgb
                          : Display::Transform::filmic;
    state.aa = std::clamp(json.value("aa", state.aa), 1, 65536);
    state.target_ms = std::clamp(json.value("frame_time_ms", state.target_ms), 1.0, 10000.0);
    state.tolerance = std::clamp(json.value("tolerance", state.tolerance), 1e-6, 0.5);
    state.panel = json.value("panel", state.panel);
    state.lights = json.value("lights", state.lights);
}

}  // namespace

fs::path memory_file()
{
    const fs::path folder = xdg_folder("XDG_CONFIG_HOME", ".config");
    return folder.empty() ? folder : folder / "view.json";
}

fs::path cache_folder()
{
    return xdg_folder("XDG_CACHE_HOME", ".cache");
}

Remembered recall(const fs::path& file, std::string& complaint)
{
    Remembered what;
    what.file = file;
    std::error_code none;
    if (file.empty() || !fs::exists(file, none))
        return what;
    try {
        const Json json = Json::parse(write::read_whole(file));
        what.recent = json.value("recent", what.recent);
        what.folder = json.value("folder", what.folder);
        const auto size = json.value("window", std::vector<int>{what.size.x, what.size.y});
        if (size.size() == 2)
            what.size =
                glm::clamp(glm::ivec2(size[0], size[1]), glm::ivec2(320, 240), glm::ivec2(16384));
        ViewState state;
        read_state(json, state);
        what.state = state;
    } catch (const std::exception& error) {
        complaint = fmt::format("{}: not read: {}; it is written anew at the end", file.string(),
                                error.what());
    }
    return what;
}

void remember(const Remembered& what)
{
    const fs::path& file = what.file;
    if (file.empty())
        return;
    const ViewState& state = what.state;
    const Settings preset = find_preset(state.preset);
    Json settings = Json::object();
    for (const SettingInfo& info : setting_table())
        if (const std::string value = info.get(state.settings); value != info.get(preset))
            settings[std::string(info.name)] = value;
    if (state.settings.mode != preset.mode)
        settings["mode"] = mode_name(state.settings.mode);
    const Json json{{"recent", what.recent},
                    {"folder", what.folder},
                    {"window", {what.size.x, what.size.y}},
                    {"preset", state.preset},
                    {"settings", settings},
                    {"compare_with", state.other},
                    {"display", state.transform == Display::Transform::srgb ? "srgb" : "filmic"},
                    {"aa", state.aa},
                    {"frame_time_ms", state.target_ms},
                    {"tolerance", state.tolerance},
                    {"panel", state.panel},
                    {"lights", state.lights}};
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error)
        throw Error(fmt::format("{}: {}; what you chose is not kept", file.parent_path().string(),
                                error.message()));
    write::write_whole(file, json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

void add_recent(Remembered& what, const std::string& file)
{
    constexpr std::size_t kMost = 10;
    std::error_code error;
    const std::string absolute = fs::absolute(file, error).lexically_normal().string();
    if (error)
        return;
    std::erase(what.recent, absolute);
    what.recent.insert(what.recent.begin(), absolute);
    what.recent.resize(std::min(what.recent.size(), kMost));
}

}  // namespace fumarole::window
