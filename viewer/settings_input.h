#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <fumarole/settings.h>

namespace CLI {
class App;
}

namespace fumarole::command {

/// Settings as they were typed: a preset, and what differs from it.
struct SettingsInput {
    std::string preset = "default";
    std::string mode;                            ///< "" for the preset's
    std::map<std::string, std::string> changed;  ///< values of settings by name, as given
};

/// Adds `--preset` and an option for each row of setting_table(). `input` outlives the command.
void add_settings(CLI::App& command, SettingsInput& input);

/// The words of a command line with present names in the place of settings' old ones, of each of
/// which tell_of_old_name() tells.
std::vector<std::string> with_present_names(std::vector<std::string> words);

/// Says on stderr, once a process, that `name` is an old name of a setting; nothing of others.
void tell_of_old_name(std::string_view name);

/// @throws UsageError naming what can't be
Settings parse_settings(const SettingsInput& input);

/// `--steps 32 --jitter none`: what makes `settings` of a preset's, "" if nothing differs. The mode
/// is left out.
std::string settings_words(const Settings& settings, const Settings& preset);

}  // namespace fumarole::command
