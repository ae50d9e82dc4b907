#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "study/metrics.h"
#include "study/reference.h"
#include "study/shard.h"
#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>

// The chart: what each setting costs in milliseconds and buys in error, measured on the user's own
// scene against its reference.

namespace fumarole::study {

/// A setting and the values that it takes in a sweep.
struct Axis {
    std::string_view setting;  ///< a name of setting_table()
    std::vector<std::string_view> values;
    std::vector<std::string_view> quick;  ///< those of --quick; none: left out of it
};

/// All combinations of the axes' values, from a preset with some settings changed on; without axes
/// these themselves.
struct Sweep {
    std::string_view preset;
    std::vector<Axis> axes = {};
    std::vector<std::pair<std::string_view, std::string_view>> changes = {};

    /// Where it starts.
    [[nodiscard]] Settings base() const;
};

/// Every sweep as data. A new setting or preset joins the chart by adding a row.
const std::vector<Sweep>& sweep_table();

/// One way to render.
struct ChartPoint {
    std::string preset;
    /// What differs from the preset, in the order of setting_table().
    std::vector<std::pair<std::string, std::string>> changes;
    Settings settings;
    bool alone =
        false;  ///< true if at most one setting differs from its sweep's base, a mode's default
    bool is_preset = false;  ///< nothing differs from the preset but what the whole chart is of

    /// `default`, `default steps=32 resolution=full`: the same for the same settings.
    [[nodiscard]] std::string name() const;
    /// The same as options of `fumarole render`, and how many frames it times.
    [[nodiscard]] std::string arguments(int frames) const;

    [[nodiscard]] std::string_view mode() const { return mode_name(settings.mode); }
    /// With a history: the picture is what kGathered frames of a still view come to. All others are
    /// single frames.
    [[nodiscard]] bool gathers() const { return settings.keeps_history(); }
    static constexpr int kGathered = 16;
};

/// The points of all sweeps, each once, presets first.
/// @param once light scatters once in all of them, as in the truth that they are measured against
/// @param transparents whether the scene has some: nothing else changes with what is theirs alone
std::vector<ChartPoint> chart_points(bool quick, bool once = false, bool transparents = true);

/// The picture of a point, of one frame or of what it gathers.
Still render_point(SceneRenderer& renderer, const Scene& scene, const ChartPoint& point,
                   StillOptions options = {});

enum class Target { composite, scattering, transmittance };
inline constexpr std::array<std::string_view, 3> kTargetNames{"composite", "scattering",
                                                              "transmittance"};

/// The error of a point's pictures, over several seeds of the jitter.
struct TargetError {
    double relmse = 0;  ///< relMSE of a frame, the mean over the seeds: bias_part + variance
    double relmse_min = 0, relmse_max = 0;
    double bias_part = 0;  ///< relMSE of the mean of endless seeds, estimated: what is systematic
    double variance = 0;   ///< what the seeds differ by, in relMSE's unit
    double bias = 0;       ///< signed, of the mean: mean(x - r) / mean(r)
};

/// @param frames one picture for each seed
/// @param noise of the reference, which is taken off @throws Error as compare
TargetError target_error(const std::vector<std::vector<float>>& frames,
                         std::span<const float> reference, const NoiseShare& noise = {});

struct PointErrors {
    std::array<TargetError, 3> targets;  ///< errors of the targets in the order of Target
    double flip = 0;                     ///< FLIP of the first seed's composite, 0..1
    int seeds = 0;
};

/// What one visit to a point found. The first visit measures its errors too.
struct ChartVisit {
    std::string point;  ///< ChartPoint::name()
    int round = 0;
    PassTime volume;  ///< all that the volume adds to a frame
    int frames = 0;   ///< timed
    double samples = 0;
    std::uint64_t gpu_bytes = 0;
    PointErrors errors;   ///< errors of round 0
    std::string refusal;  ///< why this scene or this GL can't have these settings, or ""
    double seconds = 0;   ///< seconds that the visit took
};

/// A point and all that was measured of it.
struct MeasuredPoint {
    ChartPoint point;
    std::string refusal;
    double min_ms = 0, median_ms = 0, max_ms = 0;  ///< median of the visits' medians
    int visits = 0, frames = 0;
    double samples = 0;
    std::uint64_t gpu_bytes = 0;
    PointErrors errors;
    bool front = false;

    [[nodiscard]] bool finite() const;
    [[nodiscard]] const TargetError& error(Target target) const
    {
        return errors.targets[static_cast<std::size_t>(target)];
    }
};

struct ChartOptions {
    bool quick = false;
    bool once = false;                  ///< as chart_points
    Target target = Target::composite;  ///< target of the error axis and the front
    int frames = 3;                     ///< timed in each visit
    int rounds = 3;                     ///< visits to each point, in another order every time
    int seeds = 4;
    /// What is measured is cut to fit: rounds after the second, then combinations of settings, then
    /// the second round, then settings alone. Presets are measured whatever it takes.
    double seconds = 600;

    Shard shard;                    ///< the points that this run visits
    std::vector<ChartVisit> known;  ///< visits of an earlier run, which are not made again
    std::function<void(const ChartVisit&)> keep;  ///< called after each visit
    /// Called with visits done, visits in all and the seconds left.
    std::function<void(int, int, double)> progress;
    const std::atomic<bool>* cancel = nullptr;
};

struct Chart {
    Target target = Target::composite;
    glm::uvec2 size{0};
    std::vector<MeasuredPoint> points;
    double floor = 0;                 ///< the least error that any point reached
    bool once = false;                ///< as ChartOptions
    std::vector<std::string> limits;  ///< what to know before believing the chart, in words
    const char* timing_method = "";
    int rounds = 0;            ///< completed
    std::size_t left_out = 0;  ///< points for which there was no time; not among `points`
    int visited = 0;           ///< visits made now, not taken from an earlier run

    /// Those on the front, fastest first.
    [[nodiscard]] std::vector<const MeasuredPoint*> front() const;
    [[nodiscard]] const MeasuredPoint* find(std::string_view name) const;
};

struct ChartCancelled : std::runtime_error {
    ChartCancelled() : std::runtime_error("the chart was cancelled") {}
};

/// Measures the points. @throws Error if the scene has no media; ChartCancelled between frames.
Chart measure_chart(const Scene& scene, const ReferenceStill& reference, SceneRenderer& renderer,
                    const ChartOptions& options);

/// Which of the points (cost, error) no other one beats: none is at least as good in both and
/// better in one. Twins are both in or both out; what is not finite is out.
std::vector<bool> pareto_front(std::span<const std::pair<double, double>> points);

/// What one value of a setting, alone, does to its preset.
struct SettingEffect {
    std::string setting, value;
    const MeasuredPoint *point, *base;  ///< points with the change and without
    double time_ratio, error_ratio;     ///< ratios of time and error to the base
    bool is_default;

    /// What it buys and what it costs, in words; within the spread of times or seeds: nothing seen.
    [[nodiscard]] std::string_view verdict(Target target) const;
};
std::vector<SettingEffect> setting_effects(const Chart& chart);

/// Every measured point, RFC 4180.
std::string chart_csv(const Chart& chart);
/// Quoted where it must be.
std::string csv_field(std::string_view text);

}  // namespace fumarole::study
