#include "study/chart.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include "study/flag_names.h"
#include "study/flip.h"
#include "study/seconds.h"
#include <fumarole/errors.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::study {

namespace {

/// One setting alone, from the default preset.
Sweep alone(std::string_view setting, std::vector<std::string_view> values,
            std::vector<std::string_view> quick)
{
    return {"default", {{setting, std::move(values), std::move(quick)}}};
}

/// The same where shadows are marched and not kept in volumes.
Sweep marched(std::string_view setting, std::vector<std::string_view> values,
              std::vector<std::string_view> quick)
{
    return {
        "default", {{setting, std::move(values), std::move(quick)}}, {{"shadow-volume-size", "0"}}};
}

/// The same of froxels, in a frame on its own: what a history gathers would hide what one costs.
Sweep alone_in_froxels(std::string_view setting, std::vector<std::string_view> values,
                       std::vector<std::string_view> quick)
{
    return {"froxel", {{setting, std::move(values), std::move(quick)}}, {{"history", "0"}}};
}

std::vector<Sweep> make_sweeps()
{
    return {
        {"default"},
        {"eevee2017"},
        {"froxel"},
        {"eevee2017-froxel"},
        alone("steps", {"8", "16", "32", "64", "128", "256"}, {"16", "256"}),
        alone("step-spacing", {"medium", "fixed"}, {"fixed"}),
        alone("empty-space-skipping", {"on", "off"}, {"off"}),
        alone("min-transmittance", {"0", "0.001", "0.01", "0.1"}, {"0"}),
        alone("falloff", {"exact", "sampled"}, {}),
        alone("temporal", {"off", "on"}, {"on"}),
        {"default", {{"steps", {"8", "16", "32"}, {}}}, {{"temporal", "on"}}},
        alone("resolve-passes", {"1", "2"}, {"2"}),
        alone("splits", {"2", "4", "8", "16", "32", "64"}, {"4", "64"}),
        alone("transparency", {"split", "single", "doubled"}, {}),
        marched("shadow-steps", {"2", "4", "8", "16", "32", "64"}, {"4", "64"}),
        alone("shadow-volume-size", {"0", "32", "64", "auto", "192"}, {"0", "32"}),
        alone("ambient-volume-size", {"0", "16", "auto", "64"}, {"0"}),
        alone("world-directions", {"auto", "26", "74"}, {}),
        alone("bounces", {"0", "1", "2", "4", "8", "auto"}, {"0"}),
        alone("surface-bounces", {"0", "1", "2", "4"}, {}),
        alone("probes", {"auto", "off"}, {}),
        alone("resolution", {"full", "half", "quarter"}, {"full", "quarter"}),
        alone("upsample", {"2x2", "4x4", "4x4-box"}, {"4x4"}),
        alone("distribution", {"0", "0.5", "0.8", "1"}, {}),
        alone("jitter", {"blue", "none"}, {"none"}),
        alone("range", {"media", "camera"}, {}),
        marched("shadow-range", {"media", "light"}, {}),
        alone("layer-depth", {"checkerboard", "corner"}, {}),
        alone("depth-threshold", {"0.01", "0.05", "0.2"}, {}),
        alone("targets", {"auto", "two", "mono"}, {}),
        alone("target-format", {"r11g11b10f", "rgba16f", "rgba32f"}, {}),
        alone("storage", {"auto", "r32f", "r16f", "r8"}, {"r8"}),
        alone("layout", {"auto", "dense", "bricks"}, {"bricks"}),
        alone("noise-grid", {"on", "off"}, {}),
        alone("volume-shadows", {"on", "off"}, {"off"}),
        alone("world-light", {"on", "off"}, {}),
        alone("shadow-map", {"256", "512", "1024", "4096"}, {}),
        {"froxel", {{"history", {"0", "0.95"}, {"0"}}}},
        {"froxel", {{"history-format", {"r11g11b10f", "auto", "rgba32f"}, {}}}},
        alone_in_froxels("tile", {"4", "8", "16"}, {"4", "16"}),
        alone_in_froxels("slices", {"32", "64", "128"}, {"128"}),
        alone_in_froxels("slice-spacing", {"exponential", "power", "linear"}, {}),
        alone_in_froxels("lookup", {"trilinear", "tricubic"}, {"tricubic"}),
        alone_in_froxels("integration", {"hillaire", "wronski"}, {}),
        alone_in_froxels("froxel-shadows", {"media", "grid"}, {}),
        {"default",
         {{"steps", {"8", "16", "32", "64", "128"}, {"16", "128"}},
          {"shadow-steps", {"2", "4", "8", "16", "32"}, {"4", "16"}},
          {"resolution", {"full", "half", "quarter"}, {"full", "half"}}}},
        {"froxel",
         {{"tile", {"4", "8", "16"}, {}},
          {"slices", {"32", "64", "128"}, {}},
          {"shadow-steps", {"4", "16"}, {}}},
         {{"history", "0"}}},
    };
}

/// The settings in words: what differs from the sweep's preset.
ChartPoint make_point(const Sweep& sweep, Settings settings, bool once)
{
    Settings base = sweep.base();
    if (once)
        settings.bounces = base.bounces = 0;
    ChartPoint point;
    point.preset = sweep.preset;
    point.settings = settings;
    point.is_preset = sweep.axes.empty();
    const Settings preset = find_preset(sweep.preset);
    int from_base = 0;
    for (const SettingInfo& info : setting_table()) {
        if (info.get(settings) != info.get(preset))
            point.changes.emplace_back(info.name, info.get(settings));
        from_base += info.get(settings) != info.get(base) ? 1 : 0;
    }
    const bool of_default = sweep.preset == "default" || sweep.preset == "froxel";
    point.alone = of_default && from_base <= 1;
    return point;
}

/// Adds what an axis makes of each of these settings.
std::vector<Settings> spread(const std::vector<Settings>& from, const Axis& axis, bool quick)
{
    std::vector<Settings> to;
    for (const Settings& settings : from)
        for (const std::string_view value : quick ? axis.quick : axis.values) {
            to.push_back(settings);
            find_setting(axis.setting).set(to.back(), value);
        }
    return to;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return (values[(n - 1) / 2] + values[n / 2]) / 2;
}

std::vector<float>& target_of(Still& still, std::size_t target)
{
    const std::array pixels{&Still::composite, &Still::scattering, &Still::transmittance};
    return still.*pixels[target];
}

const std::vector<float>& target_of(const ReferenceStill& still, std::size_t target)
{
    const std::array pixels{&ReferenceStill::composite, &ReferenceStill::scattering,
                            &ReferenceStill::transmittance};
    return still.*pixels[target];
}

Display display_of(const ReferenceStill& reference)
{
    Image image;
    image.width = reference.width;
    image.height = reference.height;
    image.channels = {"R", "G", "B"};
    image.pixels = reference.composite;
    return {.exposure_ev = write::auto_exposure(image)};
}

/// Goes to points and measures them.
class Visitor {
public:
    Visitor(const Scene& scene, const ReferenceStill& reference, SceneRenderer& renderer,
            const ChartOptions& options)
        : scene_{scene}, reference_{reference}, renderer_{renderer}, options_{options},
          display_{display_of(reference)},
          noise_{noise_relmse(reference.noise, reference.composite),
                 noise_relmse(reference.scattering_noise, reference.scattering), NoiseShare{}}
    {
    }

    /// @throws ChartCancelled between two frames
    ChartVisit visit(const ChartPoint& point, int round)
    {
        const auto begin = std::chrono::steady_clock::now();
        ChartVisit visit;
        visit.point = point.name();
        visit.round = round;
        try {
            StillReport report;
            // The picture of a later visit is not looked at.
            const int frames =
                round == 0 && point.gathers() ? ChartPoint::kGathered : options_.frames;
            StillOptions still_options{.timed_frames = frames, .progress = cancels()};
            Still first = renderer_.render(scene_, point.settings, still_options, &report);
            visit.volume = report.volume;
            visit.frames = frames;
            visit.samples = report.samples;
            visit.gpu_bytes = report.gpu_bytes;
            if (round == 0)
                visit.errors = errors(point, first);
        } catch (const Error& error) {
            visit.refusal = with_flags(error.what());
        }
        visit.seconds = seconds_since(begin);
        return visit;
    }

private:
    [[nodiscard]] std::function<void(int, int)> cancels() const
    {
        return [this](int, int) {
            if (options_.cancel != nullptr && *options_.cancel)
                throw ChartCancelled();
        };
    }

    PointErrors errors(const ChartPoint& point, Still& first)
    {
        PointErrors found;
        found.flip = std::numeric_limits<double>::infinity();
        if (std::all_of(first.composite.begin(), first.composite.end(),
                        [](float v) { return std::isfinite(v); }))
            found.flip = flip_of_radiance(first.composite, reference_.composite, first.width,
                                          first.height, display_)
                             .mean;
        std::array<std::vector<std::vector<float>>, 3> frames;
        const auto add = [&](Still& still) {
            for (std::size_t t = 0; t < frames.size(); ++t)
                frames[t].push_back(std::move(target_of(still, t)));
        };
        add(first);
        // Without jitter every seed gives the same picture.
        found.seeds = point.settings.jitter == Settings::Jitter::none ? 1 : options_.seeds;
        for (int seed = 1; seed < found.seeds; ++seed) {
            Still still =
                render_point(renderer_, scene_, point,
                             {.seed = static_cast<std::uint32_t>(seed), .progress = cancels()});
            add(still);
        }
        for (std::size_t t = 0; t < frames.size(); ++t)
            found.targets[t] = target_error(frames[t], target_of(reference_, t), noise_[t]);
        return found;
    }

    const Scene& scene_;
    const ReferenceStill& reference_;
    SceneRenderer& renderer_;
    const ChartOptions& options_;
    Display display_;
    std::array<NoiseShare, 3> noise_;
};

/// Visits by point and round.
class Visits {
public:
    void add(const ChartVisit& visit) { found_[{visit.point, visit.round}] = visit; }

    [[nodiscard]] const ChartVisit* find(const std::string& point, int round) const
    {
        const auto at = found_.find({point, round});
        return at == found_.end() ? nullptr : &at->second;
    }

    /// Seconds that a visit may take, from the visits so far.
    [[nodiscard]] double guess(const ChartPoint& point, int round) const
    {
        if (const ChartVisit* first = find(point.name(), 0))
            return round > 0 ? again(*first) : first->seconds;
        double sum = 0;
        for (const auto& [at, visit] : found_)
            sum += visit.seconds;
        const double mean = found_.empty() ? 1.0 : sum / static_cast<double>(found_.size());
        ChartPoint other = point;
        other.changes.clear();
        const ChartVisit* base = find(other.name(), 0);
        if (base == nullptr || point.is_preset)
            return mean;
        // Each change counts as it does alone.
        double seconds = base->seconds;
        for (const auto& change : point.changes) {
            other.changes = {change};
            if (const ChartVisit* alone = find(other.name(), 0))
                seconds *= alone->seconds / base->seconds;
        }
        return seconds;
    }

    /// Seconds that all points' second visits would take.
    [[nodiscard]] double second_round() const
    {
        double seconds = 0;
        for (const auto& [at, visit] : found_)
            if (at.second == 0 && find(at.first, 1) == nullptr)
                seconds += again(visit);
        return seconds;
    }

private:
    /// A later visit measures no errors.
    static double again(const ChartVisit& first) { return 0.65 * first.seconds; }

    std::map<std::pair<std::string, int>, ChartVisit> found_;
};

MeasuredPoint gather(const ChartPoint& point, const Visits& visits, int rounds)
{
    MeasuredPoint measured;
    measured.point = point;
    std::vector<double> medians;
    for (int round = 0; round < rounds; ++round) {
        const ChartVisit* visit = visits.find(point.name(), round);
        if (visit == nullptr)
            continue;
        if (!visit->refusal.empty()) {
            measured.refusal = visit->refusal;
            return measured;
        }
        if (round == 0) {
            measured.errors = visit->errors;
            measured.samples = visit->samples;
            measured.gpu_bytes = visit->gpu_bytes;
        }
        const bool first = medians.empty();
        measured.min_ms =
            first ? visit->volume.min_ms : std::min(measured.min_ms, visit->volume.min_ms);
        measured.max_ms = std::max(measured.max_ms, visit->volume.max_ms);
        measured.frames += visit->frames;
        medians.push_back(visit->volume.median_ms);
    }
    measured.visits = static_cast<int>(medians.size());
    if (!medians.empty())
        measured.median_ms = median(medians);
    return measured;
}

/// How many times longer than its shortest frame a point's longest one took; the median over all.
double usual_spread(const Chart& chart)
{
    std::vector<double> spreads;
    for (const MeasuredPoint& p : chart.points)
        if (p.finite() && p.min_ms > 0)
            spreads.push_back(p.max_ms / p.min_ms);
    return spreads.empty() ? 1 : median(std::move(spreads));
}

/// What to know before believing the numbers, in words.
std::vector<std::string> limits_of(const Chart& chart, const ChartOptions& asked)
{
    std::vector<std::string> limits;
    if (std::any_of(chart.points.begin(), chart.points.end(),
                    [](const MeasuredPoint& p) { return p.point.gathers(); }))
        limits.push_back(
            fmt::format("A point with a history shows what {} frames of a still view gather; all "
                        "others one frame on its own. What a history does while "
                        "things move is no part of the chart: fumarole stability --case 7.",
                        ChartPoint::kGathered));
    if (chart.left_out > 0)
        limits.push_back(fmt::format("The time limit left {} of {} points out: combinations of "
                                     "several settings first.",
                                     chart.left_out, chart.left_out + chart.points.size()));
    if (chart.rounds < asked.rounds)
        limits.push_back(fmt::format("The time limit let every point be visited {} of {} times.",
                                     chart.rounds, asked.rounds));
    if (chart.rounds < 2)
        limits.emplace_back("Each point was visited once: the spread of its times is that of "
                            "neighbouring frames, without the machine's drift.");
    constexpr double kBusy = 1.5;
    if (const double spread = usual_spread(chart); spread > kBusy)
        limits.push_back(fmt::format("The machine was busy: frames of one point differ by a factor "
                                     "of {:.1f}, at the median. Chart on an idle one.",
                                     spread));
    if (asked.quick)
        limits.emplace_back("--quick: few points, few seeds and a coarse reference; the whole "
                            "chart comes without it.");
    limits.emplace_back("Points on the front that lie closer together than their bars may change "
                        "places in another run.");
    for (const MeasuredPoint& p : chart.points) {
        if (!p.refusal.empty())
            limits.push_back(fmt::format("{}: not measured: {}", p.point.name(), p.refusal));
        else if (!p.finite())
            limits.push_back(fmt::format("{}: its picture is not finite; it is in the table and "
                                         "not in the chart.",
                                         p.point.name()));
    }
    return limits;
}

}  // namespace

// ------------------------------------------------------------------------------------- points

const std::vector<Sweep>& sweep_table()
{
    static const std::vector<Sweep> table = make_sweeps();
    return table;
}

Settings Sweep::base() const
{
    Settings settings = find_preset(preset);
    for (const auto& [setting, value] : changes)
        find_setting(setting).set(settings, value);
    return settings;
}

std::string ChartPoint::name() const
{
    std::string text = preset;
    for (const auto& [setting, value] : changes)
        text += fmt::format(" {}={}", setting, value);
    return text;
}

std::string ChartPoint::arguments(int frames) const
{
    std::string text = fmt::format("--preset {}", preset);
    for (const auto& [setting, value] : changes)
        text += fmt::format(" --{} {}", setting, value);
    return text + fmt::format(" --frames {}", gathers() ? kGathered : frames);
}

std::vector<ChartPoint> chart_points(bool quick, bool once, bool transparents)
{
    std::vector<ChartPoint> points;
    const auto is_of_transparents = [](const Axis& axis) {
        return axis.setting == "splits" || axis.setting == "transparency";
    };
    for (const Sweep& sweep : sweep_table()) {
        if (!transparents && std::any_of(sweep.axes.begin(), sweep.axes.end(), is_of_transparents))
            continue;
        std::vector<Settings> all{sweep.base()};
        for (const Axis& axis : sweep.axes)
            all = spread(all, axis, quick);
        for (const Settings& settings : all) {
            const ChartPoint point = make_point(sweep, settings, once);
            const bool known = std::any_of(points.begin(), points.end(), [&](const ChartPoint& p) {
                return p.settings == point.settings;
            });
            if (!known)
                points.push_back(point);
        }
    }
    return points;
}

// ----------------------------------------------------------------------------------- measuring

Still render_point(SceneRenderer& renderer, const Scene& scene, const ChartPoint& point,
                   StillOptions options)
{
    StillReport report;
    options.timed_frames = ChartPoint::kGathered;
    return renderer.render(scene, point.settings, options, point.gathers() ? &report : nullptr);
}

TargetError target_error(const std::vector<std::vector<float>>& frames,
                         std::span<const float> reference, const NoiseShare& noise)
{
    TargetError error;
    std::vector<double> sum(reference.size());
    const double n = static_cast<double>(frames.size());
    error.relmse_min = std::numeric_limits<double>::infinity();
    for (const std::vector<float>& frame : frames) {
        const double relmse = compare(frame, reference).relmse;
        error.relmse += relmse / n;
        error.relmse_min = std::min(error.relmse_min, relmse);
        error.relmse_max = std::max(error.relmse_max, relmse);
        for (std::size_t i = 0; i < sum.size(); ++i)
            sum[i] += static_cast<double>(frame[i]) / n;
    }
    const std::vector<float> mean(sum.begin(), sum.end());
    const Metrics of_mean = compare(mean, reference);
    error.bias = of_mean.bias;
    error.bias_part = of_mean.relmse;
    if (frames.size() > 1 && of_mean.finite) {
        // The mean of n frames still holds 1/n of their variance.
        error.variance = std::max(0.0, (error.relmse - of_mean.relmse) * n / (n - 1));
        error.bias_part = std::max(0.0, of_mean.relmse - error.variance / n);
    }
    for (double* with_noise :
         {&error.relmse, &error.relmse_min, &error.relmse_max, &error.bias_part})
        *with_noise = noise.off(*with_noise);
    return error;
}

bool MeasuredPoint::finite() const
{
    if (!refusal.empty() || visits == 0)
        return false;
    return std::all_of(errors.targets.begin(), errors.targets.end(),
                       [](const TargetError& e) { return std::isfinite(e.relmse); });
}

namespace {

struct Step {
    const ChartPoint* point;
    int round;
};

/// Presets, settings alone, combinations: what a time limit cuts off tells the least.
int rank(const ChartPoint& point)
{
    return point.is_preset ? 0 : point.alone ? 1 : 2;
}

/// Round by round, each in an order of its own, always the same; the first one by rank.
std::vector<Step> plan(const std::vector<ChartPoint>& points, int rounds)
{
    std::vector<Step> steps;
    std::mt19937 random(2017);
    for (int round = 0; round < rounds; ++round) {
        std::vector<Step> turn;
        turn.reserve(points.size());
        for (const ChartPoint& point : points)
            turn.push_back({&point, round});
        std::shuffle(turn.begin(), turn.end(), random);
        if (round == 0)
            std::stable_sort(turn.begin(), turn.end(), [](const Step& a, const Step& b) {
                return rank(*a.point) < rank(*b.point);
            });
        steps.insert(steps.end(), turn.begin(), turn.end());
    }
    return steps;
}

/// Is there time for a step? For presets always; for a combination only if there is time, too, to
/// visit all points so far, and it, once more.
bool affordable(const Step& step, const Visits& visits, int rounds, double seconds_left)
{
    const int its_rank = rank(*step.point);
    if (step.round == 0 && its_rank == 0)
        return true;
    double needed = visits.guess(*step.point, step.round);
    if (step.round == 0 && its_rank == 2 && rounds > 1)
        needed = 1.65 * needed + visits.second_round();
    return needed <= seconds_left;
}

/// What was measured of the points.
Chart gather_chart(const std::vector<ChartPoint>& points, const Visits& visits,
                   const ChartOptions& options)
{
    Chart chart;
    chart.target = options.target;
    chart.once = options.once;
    chart.rounds = options.rounds;
    chart.floor = std::numeric_limits<double>::infinity();
    std::vector<std::pair<double, double>> plane;
    for (const ChartPoint& point : points) {
        if (visits.find(point.name(), 0) == nullptr) {
            ++chart.left_out;
            continue;
        }
        chart.points.push_back(gather(point, visits, options.rounds));
        const MeasuredPoint& p = chart.points.back();
        constexpr double kNone = std::numeric_limits<double>::infinity();
        plane.emplace_back(p.finite() ? p.median_ms : kNone,
                           p.finite() ? p.error(chart.target).relmse : kNone);
        chart.floor = std::min(chart.floor, plane.back().second);
        if (p.refusal.empty())
            chart.rounds = std::min(chart.rounds, p.visits);
    }
    const std::vector<bool> front = pareto_front(plane);
    for (std::size_t i = 0; i < front.size(); ++i)
        chart.points[i].front = front[i];
    return chart;
}

}  // namespace

Chart measure_chart(const Scene& scene, const ReferenceStill& reference, SceneRenderer& renderer,
                    const ChartOptions& options)
{
    if (scene.media.empty())
        throw Error("the scene has no media; there is nothing to chart");
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<ChartPoint> points =
        chart_points(options.quick, options.once, !scene.transparents.empty());
    Visits visits;
    for (const ChartVisit& visit : options.known)
        visits.add(visit);
    std::vector<Step> steps = plan(points, options.rounds);
    std::erase_if(steps, [&](const Step& step) {
        return !options.shard.has(static_cast<std::size_t>(step.point - points.data())) ||
               visits.find(step.point->name(), step.round) != nullptr;
    });

    Visitor visitor(scene, reference, renderer, options);
    const int all = static_cast<int>(steps.size());
    int visited = 0;
    for (int i = 0; i < all; ++i) {
        if (options.cancel != nullptr && *options.cancel)
            throw ChartCancelled();
        const Step& step = steps[static_cast<std::size_t>(i)];
        const ChartVisit* first = visits.find(step.point->name(), 0);
        if (step.round > 0 && (first == nullptr || !first->refusal.empty()))
            continue;
        const double seconds_left = options.seconds - seconds_since(begin);
        if (options.progress) {
            double needed = 0;
            for (std::size_t k = static_cast<std::size_t>(i); k < steps.size(); ++k)
                needed += visits.guess(*steps[k].point, steps[k].round);
            options.progress(i, all, std::clamp(needed, 0.0, std::max(0.0, seconds_left)));
        }
        if (!affordable(step, visits, options.rounds, seconds_left))
            continue;
        const ChartVisit visit = visitor.visit(*step.point, step.round);
        visits.add(visit);
        ++visited;
        if (options.keep)
            options.keep(visit);
    }
    if (options.progress)
        options.progress(all, all, 0);

    Chart chart = gather_chart(points, visits, options);
    chart.visited = visited;
    chart.size = scene.resolution;
    chart.timing_method = timing_name(renderer.renderer().measuring_timing());
    chart.limits = limits_of(chart, options);
    return chart;
}

// ------------------------------------------------------------------------------------- reading

std::vector<bool> pareto_front(std::span<const std::pair<double, double>> points)
{
    std::vector<bool> front;
    for (const std::pair<double, double>& point : points) {
        const bool beaten = std::any_of(points.begin(), points.end(), [&](const auto& other) {
            return other.first <= point.first && other.second <= point.second && other != point;
        });
        front.push_back(!beaten && std::isfinite(point.first) && std::isfinite(point.second));
    }
    return front;
}

std::vector<const MeasuredPoint*> Chart::front() const
{
    std::vector<const MeasuredPoint*> found;
    for (const MeasuredPoint& p : points)
        if (p.front)
            found.push_back(&p);
    std::stable_sort(found.begin(), found.end(),
                     [](const auto* a, const auto* b) { return a->median_ms < b->median_ms; });
    return found;
}

const MeasuredPoint* Chart::find(std::string_view name) const
{
    for (const MeasuredPoint& p : points)
        if (p.point.name() == name)
            return &p;
    return nullptr;
}

std::vector<SettingEffect> setting_effects(const Chart& chart)
{
    std::vector<SettingEffect> effects;
    for (const Sweep& sweep : sweep_table()) {
        if (sweep.axes.size() != 1 || (chart.once && sweep.axes[0].setting == "bounces"))
            continue;
        const Settings start = sweep.base();
        const MeasuredPoint* base = chart.find(make_point(sweep, start, chart.once).name());
        if (base == nullptr || !base->finite())
            continue;
        const SettingInfo& info = find_setting(sweep.axes[0].setting);
        for (const std::string_view value : sweep.axes[0].values) {
            Settings settings = start;
            info.set(settings, value);
            const MeasuredPoint* point = chart.find(make_point(sweep, settings, chart.once).name());
            if (point != nullptr && point->finite())
                effects.push_back({.setting = std::string(info.name),
                                   .value = std::string(value),
                                   .point = point,
                                   .base = base,
                                   .time_ratio = point->median_ms / base->median_ms,
                                   .error_ratio = point->error(chart.target).relmse /
                                                  base->error(chart.target).relmse,
                                   .is_default = point == base});
        }
    }
    // A row for the preset's own value tells something only beside others.
    std::vector<SettingEffect> useful;
    for (const SettingEffect& effect : effects)
        if (std::any_of(effects.begin(), effects.end(), [&](const SettingEffect& other) {
                return other.setting == effect.setting && !other.is_default;
            }))
            useful.push_back(effect);
    return useful;
}

namespace {

/// -1 less, 1 more, 0 not told apart: a value and the range that it was found in.
int compare_spreads(const std::array<double, 3>& a, const std::array<double, 3>& b)
{
    const auto [a_low, a_middle, a_high] = a;
    const auto [b_low, b_middle, b_high] = b;
    if (a_middle < b_low && a_high < b_middle)
        return -1;
    return a_middle > b_high && a_low > b_middle ? 1 : 0;
}

}  // namespace

std::string_view SettingEffect::verdict(Target target) const
{
    if (is_default)
        return "";
    const auto time_of = [](const MeasuredPoint& p) {
        return std::array{p.min_ms, p.median_ms, p.max_ms};
    };
    const auto error_of = [&](const MeasuredPoint& p) {
        const TargetError& e = p.error(target);
        return std::array{e.relmse_min, e.relmse, e.relmse_max};
    };
    constexpr std::array<std::array<std::string_view, 3>, 3> kWords{
        {{"buys time and accuracy", "buys time, no cost seen", "buys time, costs accuracy"},
         {"buys accuracy, no cost seen", "no difference seen", "costs accuracy, buys nothing seen"},
         {"buys accuracy, costs time", "costs time, buys nothing seen",
          "costs time and accuracy"}}};
    const auto row = static_cast<std::size_t>(compare_spreads(time_of(*point), time_of(*base)) + 1);
    const auto column =
        static_cast<std::size_t>(compare_spreads(error_of(*point), error_of(*base)) + 1);
    return kWords[row][column];
}

std::string csv_field(std::string_view text)
{
    if (text.find_first_of(",\"\r\n") == std::string_view::npos)
        return std::string(text);
    std::string quoted = "\"";
    for (const char c : text) {
        quoted += c;
        if (c == '"')
            quoted += c;
    }
    return quoted + '"';
}

std::string chart_csv(const Chart& chart)
{
    std::vector<std::string> row{"point", "mode", "preset", "front"};
    for (const SettingInfo& info : setting_table())
        row.emplace_back(info.name);
    for (const char* name : {"volume_ms_min", "volume_ms_median", "volume_ms_max", "visits",
                             "frames", "samples", "gpu_bytes", "seeds"})
        row.emplace_back(name);
    for (const std::string_view target : kTargetNames)
        for (const char* name :
             {"relmse", "relmse_min", "relmse_max", "bias_part", "variance", "bias"})
            row.push_back(fmt::format("{}_{}", target, name));
    row.emplace_back("composite_flip");
    row.emplace_back("refusal");

    std::string csv;
    const auto finish_row = [&] {
        for (std::size_t i = 0; i < row.size(); ++i)
            csv += fmt::format("{}{}", i > 0 ? "," : "", csv_field(row[i]));
        csv += "\r\n";
        row.clear();
    };
    finish_row();
    for (const MeasuredPoint& p : chart.points) {
        row = {p.point.name(), std::string(p.point.mode()), p.point.preset, p.front ? "yes" : "no"};
        for (const SettingInfo& info : setting_table())
            row.push_back(info.get(p.point.settings));
        const bool measured = p.visits > 0;
        const auto number = [&](double value) {
            row.push_back(measured ? fmt::format("{:.6g}", value) : "");
        };
        for (const double value : {p.min_ms, p.median_ms, p.max_ms})
            number(value);
        row.push_back(fmt::format("{}", p.visits));
        row.push_back(fmt::format("{}", p.frames));
        number(p.samples);
        row.push_back(fmt::format("{}", p.gpu_bytes));
        row.push_back(fmt::format("{}", p.errors.seeds));
        for (const TargetError& e : p.errors.targets)
            for (const double value :
                 {e.relmse, e.relmse_min, e.relmse_max, e.bias_part, e.variance, e.bias})
                number(value);
        number(p.errors.flip);
        row.push_back(p.refusal);
        finish_row();
    }
    return csv;
}

}  // namespace fumarole::study
