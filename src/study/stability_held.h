#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "study/stability.h"

// stability.csv, and how a run of the cases compares with an earlier one: no figure may grow
// unseen, whether its case holds or falls short.

namespace fumarole::study {

/// A record of stability.csv each: group, case, mode, preset, figure, sense, bound, unit, holds
/// (`yes`, `no`, or `no: ` and why there is no figure), shows, reason.
std::string stability_csv(const std::vector<StabilityResult>& results);

/// A record of an earlier stability.csv.
struct HeldCase {
    std::string name, mode, preset;
    double figure = 0;  ///< rounded to four digits
    bool held = false;
    std::vector<std::string> fields;  ///< all of the record

    [[nodiscard]] bool is(const StabilityRun& run) const { return run.is(name, mode, preset); }
};

/// Reads stability_csv's text. @throws Error naming `file`, the line and what is wrong with it.
std::vector<HeldCase> read_held(std::string_view csv, const std::filesystem::path& file);

/// One stability.csv of several runs that shared the work, in the table's order.
/// @throws Error if a run is in none of them, or in two, or if one is not among `runs`
std::string merged_csv(const std::vector<StabilityRun>& runs,
                       const std::vector<std::filesystem::path>& files);

/// The worst figure that a case may have and still count as no worse than it was. One that held may
/// lose half of its margin to the bound; one that fell short may fall short 1.25 times as far,
/// measured from 0 for a bound from above and from the bound itself for one from below.
double held_limit(const StabilityCase& one, const HeldCase& before);

/// How a run differs from an earlier one: a line each.
struct HeldChanges {
    std::vector<std::string> lost;    ///< held before and no longer, or are no case any more
    std::vector<std::string> worse;   ///< hold or fall short as before, but beyond held_limit()
    std::vector<std::string> gained;  ///< fell short before and hold
    std::vector<std::string> added;   ///< have no earlier figure
};

/// Cases that this run left out are passed over.
HeldChanges compare_held(const std::vector<HeldCase>& before,
                         const std::vector<StabilityResult>& now);

/// The earlier stability.csv with this run's records in the place of its own. Those that this run
/// left out stay, unless they are no case any more.
/// @throws Error naming `file` if its columns are not those of stability_csv
std::string accepted_csv(const std::vector<HeldCase>& before,
                         const std::vector<StabilityResult>& now,
                         const std::filesystem::path& file);

}  // namespace fumarole::study
