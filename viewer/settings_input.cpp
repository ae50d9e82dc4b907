#include "settings_input.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <fmt/format.h>

#include "command.h"
#include "library_log.h"
#include <fumarole/errors.h>

namespace fumarole::command {

CLI::Validator within(double least, double most)
{
    return {[least, most](std::string& word) -> std::string {
                double value = 0;
                const char* end = word.data() + word.size();
                const auto parsed = std::from_chars(word.data(), end, value);
                return parsed.ec == std::errc{} && parsed.ptr == end && value >= least &&
                               value <= most
                           ? ""
                           : fmt::format("'{}' is no number in {:g}..{:g}", word, least, most);
            },
            "", "within"};
}

void add_settings(CLI::App& command, SettingsInput& input)
{
    std::string names;
    for (const auto& [name, settings] : presets())
        names += fmt::format("{}{}", names.empty() ? "" : "|", name);
    command.add_option("--preset", input.preset, "the settings to begin with [default]")
        ->type_name(names);
    for (const SettingInfo& info : setting_table()) {
        const std::string name(info.name);
        command
            .add_option_function<std::string>(
                "--" + name, [&input, name](const std::string& v) { input.changed[name] = v; },
                fmt::format("{}{} [{}]", info.help,
                            info.unit.empty() ? "" : fmt::format(" ({})", info.unit),
                            info.get(Settings{})))
            ->type_name(std::string(info.values))
            ->group("Settings: " + std::string(info.group));
    }
}

std::vector<std::string> with_present_names(std::vector<std::string> words)
{
    for (std::string& word : words) {
        if (word == "--")
            break;
        if (!word.starts_with("--"))
            continue;
        const std::string given = word.substr(2, word.find('=') - 2);
        tell_of_old_name(given);
        word.replace(2, given.size(), present_name(given));
    }
    return words;
}

void tell_of_old_name(std::string_view name)
{
    if (const std::string_view now = present_name(name); now != name)
        library_log()(LogLevel::warning,
                      fmt::format("--{} is now called --{}; the old name is accepted by this "
                                  "release only",
                                  name, now));
}

Settings parse_settings(const SettingsInput& input)
{
    Settings settings;
    try {
        settings = find_preset(input.preset);
    } catch (const Error& error) {
        throw UsageError(fmt::format("--preset: {}", error.what()));
    }
    try {
        for (const auto& [name, value] : input.changed)
            find_setting(name).set(settings, value);
        if (!input.mode.empty())
            settings.mode = find_mode(input.mode);
        return settings;
    } catch (const Error& error) {
        throw UsageError(error.what());
    }
}

std::string settings_words(const Settings& settings, const Settings& preset)
{
    std::string words;
    for (const SettingInfo& info : setting_table())
        if (const std::string value = info.get(settings); value != info.get(preset))
            words += fmt::format("{}--{} {}", words.empty() ? "" : " ", info.name, value);
    return words;
}

}  // namespace fumarole::command
