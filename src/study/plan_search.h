#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fumarole/settings.h>

// The plan's search among settings: which one to try next, and which of two is the better one.
// Nothing is drawn here.

namespace fumarole::study {

/// What a plan is to reach.
struct PlanGoal {
    enum class Kind {
        max_error,  ///< least time with an error of at most `value`: root of relMSE, composite
        budget,     ///< least error in at most `value` milliseconds a frame
    };
    Kind kind = Kind::max_error;
    double value = 0.01;
};

/// A setting that trades time for error, and its values from cheap to dear.
struct PlanRow {
    Settings::Mode mode;       ///< mode that the row is for
    std::string_view setting;  ///< a name of setting_table()
    std::vector<std::string_view> values;
    /// What one value can cost over the one before it, in frame times. A guard for the time limit.
    double growth = 1;
    /// What is filled anew for another value, by guess, in set-ups of the first picture. The price
    /// is set-up then: cheaper values save no time in a frame and are not looked for.
    double refills = 0;
};

/// The rows of all modes. A new setting joins the search by adding a row.
const std::vector<PlanRow>& plan_rows();

/// The settings with the row's value `by` places dearer; nothing beyond its ends. A number that the
/// row doesn't have lies between those that it has; another word that it doesn't have stays.
std::optional<Settings> moved(const Settings& settings, const PlanRow& row, int by);

/// What differs between settings, by setting_table(): name and value in `settings`.
std::vector<std::pair<std::string, std::string>> differences(const Settings& settings,
                                                             const Settings& from);

/// Settings that were tried.
struct PlanTry {
    Settings settings;
    double ms = 0;      ///< all that the volume adds to a frame; infinite if they can't be drawn
    double error = 0;   ///< predicted, root of relMSE of the composite
    double surely = 0;  ///< one standard error above it
};

/// Whether a try reaches the goal, its error's uncertainty included.
bool meets(const PlanGoal& goal, const PlanTry& tried);
/// Whether a is worth leaving b for: clearly, by more than times and errors are known.
bool better(const PlanGoal& goal, const PlanTry& a, const PlanTry& b);

/// Tries settings, a frame of which takes `ms` by guess. Nothing when there is no time for it.
using TrySettings = std::function<std::optional<PlanTry>(const Settings&, double ms)>;

/// Goes from `start` along the rows while it gets better, one setting at a time, then one dearer
/// with another cheaper where the single steps say that it might pay. Ends where nothing does, or
/// with the time.
PlanTry search_plan(const PlanGoal& goal, const std::vector<PlanRow>& rows, const PlanTry& start,
                    const TrySettings& attempt);

}  // namespace fumarole::study
