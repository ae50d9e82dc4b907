#include "window/script.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "window/keys.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kWaits{"loaded", "settled",    "reference", "plan",
                            "grids",  "thumbnails", "message"};

glm::dvec2 point(const Json& json)
{
    if (!json.is_array() || json.size() != 2)
        throw Error("a place is [x, y]");
    return {json[0].get<double>(), json[1].get<double>()};
}

Modifiers modifiers(const Json& action)
{
    return {.shift = action.value("shift", false),
            .control = action.value("control", false),
            .alt = action.value("alt", false)};
}

KeyEvent key(const std::string& name, Modifiers held)
{
    std::string rest = name;
    const auto takes = [&](std::string_view prefix) {
        const bool there = rest.starts_with(prefix) && rest.size() > prefix.size();
        if (there)
            rest.erase(0, prefix.size());
        return there;
    };
    held.control |= takes("Ctrl+");
    held.shift |= takes("Shift+");
    const int code = key_called(rest);
    if (code < 0)
        throw Error(fmt::format("no key is called '{}'", name));
    return {code, true, held};
}

int button(const Json& action)
{
    const std::string name = action.value("button", "left");
    constexpr std::array kNames{"left", "right", "middle"};
    for (std::size_t i = 0; i < kNames.size(); ++i)
        if (name == kNames[i])
            return static_cast<int>(i);
    throw Error(
        fmt::format("no button is called '{}' (there are: {})", name, fmt::join(kNames, ", ")));
}

}  // namespace

Script Script::read(const std::filesystem::path& file)
{
    Script script;
    script.file_ = file.string();
    Json all;
    try {
        all = Json::parse(write::read_whole(file));
    } catch (const Json::exception& error) {
        throw Error(fmt::format("{}: not valid JSON: {}", file.string(), error.what()));
    }
    if (!all.is_array())
        throw Error(fmt::format("{}: a script is a list of actions: [{{\"key\": \"S\"}}, ...]",
                                file.string()));
    int number = 0;
    const auto frame = [&](std::vector<ScriptAction> actions) {
        script.steps_.emplace_back(std::move(actions));
    };
    const auto events = [&](std::vector<Event> happen) { frame({happen.begin(), happen.end()}); };
    const auto add = [&](const Json& action) {
        if (!action.is_object() || action.empty())
            throw Error("an action is an object as {\"key\": \"S\"}");
        const std::string verb = action.begin().key();
        const Json& object = action.begin().value();
        const Modifiers held = modifiers(action);
        if (verb == "key") {
            KeyEvent pressed = key(object.get<std::string>(), held);
            events({pressed});
            pressed.down = false;
            events({pressed});
        } else if (verb == "text") {
            for (const char c : object.get<std::string>())
                events({TextEvent{static_cast<unsigned char>(c)}});
        } else if (verb == "move") {
            events({PointerMoved{point(object)}});
        } else if (verb == "click") {
            events({PointerMoved{point(object)}});
            events({PointerButton{button(action), true, held}});
            events({PointerButton{button(action), false, held}});
            if (action.value("double", false)) {
                events({PointerButton{button(action), true, held, true}});
                events({PointerButton{button(action), false, held}});
            }
        } else if (verb == "drag") {
            if (!object.is_array() || object.size() != 2)
                throw Error("a drag is [[x, y], [x, y]]");
            const glm::dvec2 from = point(object[0]), to = point(object[1]);
            const int frames = std::clamp(action.value("frames", 8), 1, 10000);
            events({PointerMoved{from}});
            events({PointerButton{button(action), true, held}});
            for (int i = 1; i <= frames; ++i)
                events({PointerMoved{glm::mix(from, to, static_cast<double>(i) / frames)}});
            events({PointerButton{button(action), false, held}});
        } else if (verb == "wheel") {
            if (action.contains("at"))
                events({PointerMoved{point(action["at"])}});
            events({Wheel{object.get<double>()}});
        } else if (verb == "set") {
            std::vector<ScriptAction> actions;
            for (const auto& [name, value] : object.items())
                actions.emplace_back(
                    SetSetting{name, value.is_string() ? value.get<std::string>() : value.dump()});
            frame(std::move(actions));
        } else if (verb == "open") {
            frame({OpenFile{object.get<std::string>()}});
        } else if (verb == "browse") {
            frame({Browse{object.get<std::string>()}});
        } else if (verb == "grid") {
            std::vector<ScriptAction> actions;
            for (const auto& [name, role] : object.items())
                actions.emplace_back(GiveRole{name, role.get<std::string>(),
                                              action.value("medium", std::size_t{0})});
            frame(std::move(actions));
        } else if (verb == "drop") {
            events({FilesDropped{object.get<std::vector<std::string>>()}});
        } else if (verb == "screenshot") {
            frame({Screenshot{object.get<std::string>()}});
        } else if (verb == "clipboard") {
            frame({WriteClipboard{object.get<std::string>()}});
        } else if (verb == "resize") {
            frame({ResizeWindow{glm::ivec2(point(object))}});
        } else if (verb == "minimise") {
            frame({Minimise{object.get<bool>()}});
        } else if (verb == "frames") {
            script.steps_.emplace_back(Wait{"frames", object.get<int>(), 1e9, number});
        } else if (verb == "wait") {
            Wait wait{"", 0, action.value("seconds", 60.0), number};
            if (object.is_object()) {
                wait.what = "frame";
                wait.number = object.at("frame").get<int>();
            } else {
                wait.what = object.get<std::string>();
                if (std::find(kWaits.begin(), kWaits.end(), wait.what) == kWaits.end())
                    throw Error(fmt::format("nothing to wait for is called '{}' (there are: {}, "
                                            "{{\"frame\": N}})",
                                            wait.what, fmt::join(kWaits, ", ")));
            }
            script.steps_.emplace_back(wait);
        } else {
            throw Error(fmt::format("no action is called '{}'", verb));
        }
    };
    for (const Json& action : all) {
        ++number;
        try {
            add(action);
        } catch (const std::exception& error) {
            throw Error(fmt::format("{}: action {}: {}", file.string(), number, error.what()));
        }
    }
    return script;
}

bool Script::over(Wait& wait, const ScriptStatus& status)
{
    if (wait.what == "frames")
        return wait.number-- <= 0;
    return (wait.what == "loaded" && status.loaded) || (wait.what == "settled" && status.settled) ||
           (wait.what == "reference" && status.reference) || (wait.what == "plan" && status.plan) ||
           (wait.what == "grids" && status.grids) ||
           (wait.what == "thumbnails" && status.thumbnails) ||
           (wait.what == "message" && status.message) ||
           (wait.what == "frame" && status.frame == wait.number);
}

std::vector<ScriptAction> Script::step(const ScriptStatus& status, double seconds)
{
    if (steps_.empty())
        return {};
    if (auto* wait = std::get_if<Wait>(&steps_.front())) {
        waited_ += seconds;
        if (!over(*wait, status)) {
            if (waited_ > wait->seconds)
                throw Error(fmt::format("{}: action {}: waited {:g} s for '{}'", file_,
                                        wait->action, wait->seconds, wait->what));
            return {};
        }
        steps_.pop_front();
        waited_ = 0;
        return {};
    }
    auto actions = std::get<std::vector<ScriptAction>>(std::move(steps_.front()));
    steps_.pop_front();
    return actions;
}

}  // namespace fumarole::window
