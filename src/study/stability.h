#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>
#include <fumarole/write/image_writer.h>

// The stability cases: each known failure of the methods as a scene made by code, a figure, a bound
// and the reason for the bound, over every way to render that can run it.

namespace fumarole::study {

/// The groups in words; group n is at n - 1.
extern const std::array<std::string_view, 12> kStabilityGroups;

/// A way to render that the cases run over.
struct StabilitySubject {
    std::string_view mode, preset;
    Settings settings;
    /// The setting by which it differs from its mode's first preset, whose value is then its name;
    /// "" of a preset. What is asked for by hand is no failure of the preset that it is asked of.
    std::string_view asked = {};
};

/// Every preset, in its mode, then what cases ask for by hand.
const std::vector<StabilitySubject>& stability_subjects();

/// What was drawn and what should have been: RGB, rows from the top, linear.
struct StabilityPictures {
    int width = 0, height = 0;
    std::vector<float> actual, expected;  ///< empty where a case has no picture
};

/// A measured number. NaN and infinity are numbers too: they keep no bound.
struct StabilityFigure {
    double value = 0;
    StabilityPictures pictures = {};  ///< pictures of the worst of what was looked at
};

class StabilityBench;

/// For StabilityCase::runs.
bool marches(const StabilitySubject& subject);
bool has_froxels(const StabilitySubject& subject);

/// One named case.
struct StabilityCase {
    enum class Bound { at_most, at_least };

    int group = 1;  ///< 1..12
    std::string name;
    std::string shows;  ///< what the figure is, in a line
    Bound sense = Bound::at_most;
    double bound = 0;
    std::string unit;
    std::string reason;  ///< why the bound is what it is
    bool quick = true;   ///< true if it is of --quick too
    /// True if light scatters as often as the subject has it; false if once, which the closed forms
    /// and the quadrature are of.
    bool bounces = false;
    /// A setting whose values asked for by hand it runs over too.
    std::string_view asks = {};
    /// Which of those subjects can run it; none given: all.
    std::function<bool(const StabilitySubject&)> runs = {};
    /// @throws Error where the subject can't do what the case asks; the case then falls short.
    std::function<StabilityFigure(const StabilityBench&)> measure;

    [[nodiscard]] bool holds(double figure) const
    {
        return sense == Bound::at_most ? figure <= bound : figure >= bound;
    }
};

/// All cases, by group. A new one joins by adding a row.
const std::vector<StabilityCase>& stability_table();

/// A case and one way to render it.
struct StabilityRun {
    const StabilityCase* what = nullptr;
    const StabilitySubject* subject = nullptr;

    [[nodiscard]] bool is(std::string_view name, std::string_view mode,
                          std::string_view preset) const
    {
        return what->name == name && subject->mode == mode && subject->preset == preset;
    }
};

struct StabilityChoice {
    bool quick = false;
    std::string pattern;       ///< a group's number, or a part of a case's name; "": all
    std::string mode, preset;  ///< "": all
};

/// The runs of a choice, in the table's order.
std::vector<StabilityRun> stability_runs(const StabilityChoice& choice);

struct StabilityResult {
    StabilityRun run;
    StabilityFigure figure;
    bool holds = false;
    std::string refusal;  ///< why there is no figure, in a line, or ""
    double seconds = 0;
};

/// Called with runs done, runs in all, the one that is next, and the seconds left.
using StabilityProgress = std::function<void(int, int, const StabilityRun&, double)>;

/// Measures each run. `scratch`: a folder for files that cases write, and remove.
std::vector<StabilityResult> measure_stability(const std::vector<StabilityRun>& runs,
                                               SceneRenderer& renderer,
                                               const std::filesystem::path& scratch,
                                               const StabilityProgress& progress);

/// One strip: actual, expected, and their difference in false colour with its scale.
Image stability_strip(const StabilityPictures& pictures);

}  // namespace fumarole::study
