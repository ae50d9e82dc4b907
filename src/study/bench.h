#pragma once

#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fumarole/scene_renderer.h>

// The bench: what frames cost, in cases that are visited in turn, round by round, so that a drift
// of the machine meets all of them; and what time, memory and loading grow with.

namespace fumarole::study {

/// Of what was measured several times.
struct Spread {
    double min = 0, median = 0, max = 0;
    int count = 0;
};
Spread spread_of(const std::vector<double>& values);

/// One figure: a row of bench.csv.
struct BenchFigure {
    std::string group;  ///< `presets`, `sizes`, `load`, ...
    std::string scene;  ///< or a file's name; "" of the machine itself
    std::string name;   ///< of the case: `default`, `all but shadow-volume-size`
    std::string axis;   ///< what grows from case to case: `pixels`; "" if nothing does
    double at = 0;      ///< where on that axis
    std::string quantity, unit;
    Spread value;
    glm::uvec2 size{0};  ///< of the picture; 0 where there is none
};

/// A way to render that is timed.
struct BenchCase {
    std::string group, name;
    std::string base;  ///< name of the case of the same group, scene and `at` to compare it with
    std::string scene_name;
    Scene scene;  ///< its resolution is the size
    Settings settings;
    std::string axis;
    double at = 0;

    [[nodiscard]] bool same_place(const BenchCase& other) const
    {
        return group == other.group && scene_name == other.scene_name && at == other.at;
    }
    /// `eevee2017`, `eevee2017 at 2073600 pixels`
    [[nodiscard]] std::string short_text() const;
    /// `sizes, smoke: eevee2017 at 2073600 pixels`
    [[nodiscard]] std::string text() const;
};

struct BenchScene {
    std::string name;
    Scene scene;
};

/// Whether light is marched through a medium of it: grids and noise have no closed form.
bool is_marched(const Scene& scene);

/// A setting of the default preset that saves time, and the value that does without.
struct AblatedStep {
    std::string_view setting, off;
};
/// As data: another one is a row.
std::span<const AblatedStep> ablated_steps();

/// The cases of the groups `presets`, `passes`, `ablation`, `steps`, `lights`, `sizes`, in this
/// order.
/// Presets are of all scenes; the rest of the first that has a grid and of the first where light
/// has a closed form, of that with a grid alone if quick.
/// @param presets names; none: all @param group one group alone; "": all
std::vector<BenchCase> plan_bench(std::span<const BenchScene> scenes,
                                  std::span<const std::string> presets, const std::string& group,
                                  bool quick);
/// The names of all groups, those that no case belongs to too: `grids`, `load`, `programs`.
std::span<const std::string_view> bench_groups();

/// The case of a preset at `size` pixels; presets are compared with eevee2017.
BenchCase preset_case(const BenchScene& scene, const std::string& preset, glm::uvec2 size);

/// What a case's rounds found.
struct MeasuredCase {
    BenchCase bench_case;
    std::string refusal;                           ///< why this scene or GL can't have it, or ""
    std::vector<std::pair<int, PassTime>> volume;  ///< round, and what the volume adds to a frame
    std::vector<std::vector<PassTime>> passes;     ///< of each round
    std::vector<double> machine;    ///< BenchOptions::machine_rate just before each round's visit
    double samples = 0;             ///< media evaluations of a frame
    double even_4 = 0, even_8 = 0;  ///< SampleCounts' of it
    std::uint64_t gpu_bytes = 0;
    double setup_ms = 0;  ///< of the first round: uploads, shadow map, volumes of light
    double seconds = 0;   ///< of the longest visit
};

struct BenchOptions {
    int rounds = 3, frames = 3;
    double seconds = 1e9;  ///< cases that would not end within are left out
    /// Measures what the machine can do with passes as these settings have them, just before each
    /// visit: it drifts.
    std::function<double(const Settings&)> machine_rate;
    std::function<void(const std::string&, double)> progress;  ///< what is done, share of it all
    const std::atomic<bool>* cancel = nullptr;
};

/// Visits the cases round by round. What there was no time for is named in `cuts`.
std::vector<MeasuredCase> measure_bench(std::vector<BenchCase> cases, SceneRenderer& renderer,
                                        const BenchOptions& options,
                                        std::vector<std::string>& cuts);

/// Times, bytes, evaluations; and how many times faster than its base each is, round by round.
std::vector<BenchFigure> case_figures(std::span<const MeasuredCase> cases);

/// How time grows along an axis.
struct Growth {
    double exponent = 0;  ///< of the power law through the logarithms
    /// Of the line fixed + slope * x whose relative errors are least.
    double fixed = 0, slope = 0;
};
/// @param points x and y, above 0, at least two different x
Growth fit_growth(std::span<const std::pair<double, double>> points);

/// A curve of figures of one quantity: all of one group, scene and name along an axis.
struct GrowthCurve {
    std::string group, scene, name, axis;
    std::vector<std::pair<double, double>> points;  ///< axis, median
    Growth growth;
};
std::vector<GrowthCurve> growth_curves(std::span<const BenchFigure> figures,
                                       std::string_view quantity);

/// What a pass that makes so many fetches reaches, round by round: fetches a second, and that over
/// the machine's own rate just before. Nothing if no round has that pass.
std::pair<Spread, Spread> fetch_rates(const MeasuredCase& measured, std::string_view pass,
                                      double fetches);

/// The first figure of that kind, or nullptr.
const BenchFigure* find_figure(std::span<const BenchFigure> figures, std::string_view group,
                               std::string_view scene, std::string_view name,
                               std::string_view quantity);

/// A row a figure, RFC 4180.
std::string bench_csv(std::span<const BenchFigure> figures);

inline constexpr std::string_view kVolumeTime = "volume time";
inline constexpr std::string_view kTimesFaster = "times faster than ";

}  // namespace fumarole::study
