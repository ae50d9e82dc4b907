#pragma once

#include <map>
#include <string>

#include <fumarole/settings.h>

namespace CLI {
class App;
}

namespace fumarole::command {

/// Settings as they were typed: a preset, and what differs from it.
struct SettingsInput {
    std::string preset = "default";
    std::string mode;                            ///< "" for the preset's
    std::map<std::string, std::string> changed;  ///< by name, as given
};

/// Adds `--preset` and an option for each row of setting_table(). `input` outlives the command.
void add_settings(CLI::App& command, SettingsInput& input);

/// @throws UsageError naming what can't be
Settings parse_settings(const SettingsInput& input);

/// `--steps 32 --jitter none`: what makes `settings` of a preset's, "" if nothing differs. The mode
/// is left out.
std::string settings_words(const Settings& settings, const Settings& preset);

}  // namespace fumarole::command
