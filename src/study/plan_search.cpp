#include "study/plan_search.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace fumarole::study {

namespace {

using Mode = Settings::Mode;

// Differences that are none: frames of one setting vary by some per cent, and an error that falls
// by a tenth is not worth twice the time.
constexpr double kLessTime = 0.97;
constexpr double kLessError = 0.9;
constexpr double kSameError = 0.97;

std::optional<double> number_of(std::string_view text)
{
    double number = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, number);
    return parsed.ec == std::errc{} && parsed.ptr == end ? std::optional(number) : std::nullopt;
}

/// How many exchanges are tried from one place.
constexpr std::size_t kExchanges = 3;

/// One step along a row from where the search stands.
struct Step {
    std::size_t row = 0;
    int by = 0;
    PlanTry tried;
};

class Search {
public:
    Search(const PlanGoal& goal, const std::vector<PlanRow>& rows, PlanTry start,
           const TrySettings& attempt)
        : goal_{goal}, rows_{rows}, attempt_{attempt}, here_{start}
    {
    }

    PlanTry run()
    {
        do
            while (single_steps()) {
            }
        while (exchange());
        return here_;
    }

private:
    /// Time is to be saved, or else error.
    [[nodiscard]] bool saves_time() const
    {
        return meets(goal_, here_) == (goal_.kind == PlanGoal::Kind::max_error);
    }

    std::optional<PlanTry> attempt(const Settings& settings, double growth)
    {
        if (out_of_time_)
            return std::nullopt;
        const std::optional<PlanTry> tried = attempt_(settings, here_.ms * growth);
        out_of_time_ = !tried;
        return tried;
    }

    std::optional<PlanTry> attempt_step(const PlanRow& row, int by)
    {
        const std::optional<Settings> next = moved(here_.settings, row, by);
        if (!next)
            return std::nullopt;
        return attempt(*next, by > 0 ? row.growth : 1);
    }

    /// Along each row as far as it pays. @returns whether anything did
    bool single_steps()
    {
        bool found = false;
        for (const PlanRow& row : rows_) {
            for (;;) {
                const int by = saves_time() ? -1 : 1;
                if (by < 0 && row.refills > 0)
                    break;
                const std::optional<PlanTry> tried = attempt_step(row, by);
                if (!tried || !better(goal_, *tried, here_))
                    break;
                here_ = *tried;
                found = true;
            }
        }
        return found && !out_of_time_;
    }

    /// One setting dearer and another one cheaper. What both do is guessed from what each does:
    /// times multiply, errors add up in squares. @returns whether a pair paid
    bool exchange()
    {
        std::vector<Step> dearer, cheaper;
        for (std::size_t i = 0; i < rows_.size(); ++i)
            for (const int by : {-1, 1})
                if (rows_[i].refills == 0)
                    if (const auto tried = attempt_step(rows_[i], by);
                        tried && std::isfinite(tried->ms + tried->error))
                        (by > 0 ? dearer : cheaper).push_back({i, by, *tried});
        std::vector<PlanTry> guesses;
        for (const Step& up : dearer)
            for (const Step& down : cheaper)
                if (rows_[up.row].setting != rows_[down.row].setting)
                    if (const PlanTry guess = combined(up, down); better(goal_, guess, here_))
                        guesses.push_back(guess);
        std::sort(guesses.begin(), guesses.end(), [&](const PlanTry& a, const PlanTry& b) {
            return goal_.kind == PlanGoal::Kind::max_error ? a.ms < b.ms : a.error < b.error;
        });
        guesses.resize(std::min(guesses.size(), kExchanges));
        for (const PlanTry& guess : guesses)
            if (const auto tried = attempt(guess.settings, guess.ms / here_.ms);
                tried && better(goal_, *tried, here_)) {
                here_ = *tried;
                return true;
            }
        return false;
    }

    [[nodiscard]] PlanTry combined(const Step& up, const Step& down) const
    {
        PlanTry both;
        both.settings = *moved(up.tried.settings, rows_[down.row], down.by);
        both.ms = up.tried.ms * down.tried.ms / here_.ms;
        const auto added = [&](double PlanTry::*error) {
            const auto square = [&](const PlanTry& tried) { return tried.*error * tried.*error; };
            return std::sqrt(std::max(0.0, square(up.tried) + square(down.tried) - square(here_)));
        };
        both.error = added(&PlanTry::error);
        both.surely = added(&PlanTry::surely);
        return both;
    }

    const PlanGoal& goal_;
    const std::vector<PlanRow>& rows_;
    const TrySettings& attempt_;
    PlanTry here_;
    bool out_of_time_ = false;
};

}  // namespace

const std::vector<PlanRow>& plan_rows()
{
    // What moves most comes first. Volumes are looked at where nothing else helps.
    static const std::vector<PlanRow> table{
        {Mode::raymarch, "resolution", {"quarter", "half", "full"}, 4},
        {Mode::raymarch, "steps", {"4", "8", "16", "32", "64", "128", "256", "512"}, 2},
        {Mode::raymarch, "steps", {"6", "12", "24", "48", "96", "192", "384"}, 1.5},  // between
        {Mode::raymarch, "upsample", {"2x2", "4x4"}, 1.5},
        {Mode::raymarch, "targets", {"mono", "auto"}, 1.5},
        {Mode::raymarch, "target-format", {"r11g11b10f", "rgba16f"}, 1.2},
        {Mode::raymarch, "volume-shadows", {"off", "on"}, 1.5},
        {Mode::raymarch, "shadow-volume-size", {"auto", "160"}, 1.2, 3},
        {Mode::raymarch, "ambient-volume-size", {"auto", "64"}, 1.2, 4},
        {Mode::raymarch, "bounces", {"0", "auto"}, 1.1, 4},
        {Mode::raymarch, "surface-bounces", {"0", "auto"}, 1.1, 4},
        {Mode::raymarch, "probes", {"off", "auto"}, 1.1, 4},
        {Mode::raymarch, "shadow-map", {"auto", "2048", "4096", "8192"}, 1.2, 1},
        {Mode::froxel, "tile", {"32", "16", "8", "4", "2"}, 4},
        {Mode::froxel, "slices", {"16", "32", "64", "128", "256"}, 2},
        {Mode::froxel, "lookup", {"trilinear", "tricubic"}, 2},
        {Mode::froxel, "volume-shadows", {"off", "on"}, 1.5},
        {Mode::froxel, "shadow-volume-size", {"auto", "160"}, 1.2, 3},
        {Mode::froxel, "ambient-volume-size", {"auto", "64"}, 1.2, 4},
        {Mode::froxel, "bounces", {"0", "auto"}, 1.1, 4},
        {Mode::froxel, "surface-bounces", {"0", "auto"}, 1.1, 4},
        {Mode::froxel, "probes", {"off", "auto"}, 1.1, 4},
        {Mode::froxel, "shadow-map", {"auto", "2048", "4096", "8192"}, 1.2, 1},
    };
    return table;
}

std::optional<Settings> moved(const Settings& settings, const PlanRow& row, int by)
{
    const SettingInfo& info = find_setting(row.setting);
    const std::string value = info.get(settings);
    const auto number = number_of(value);
    // What lies on the cheaper and on the dearer side of the value, cheap to dear.
    std::vector<std::string_view> below, above;
    bool passed = false;
    for (const std::string_view other : row.values) {
        const auto of_other = number_of(other);
        const bool less = number && of_other ? *of_other < *number : !passed && other != value;
        passed = passed || other == value;
        if (other != value)
            (less ? below : above).push_back(other);
    }
    if (!passed && !number)
        return std::nullopt;
    const std::vector<std::string_view>& side = by < 0 ? below : above;
    const auto steps = static_cast<std::size_t>(std::abs(by));
    if (steps == 0 || steps > side.size())
        return std::nullopt;
    Settings next = settings;
    info.set(next, by < 0 ? side[side.size() - steps] : side[steps - 1]);
    return next;
}

std::vector<std::pair<std::string, std::string>> differences(const Settings& settings,
                                                             const Settings& from)
{
    std::vector<std::pair<std::string, std::string>> found;
    for (const SettingInfo& info : setting_table())
        if (info.get(settings) != info.get(from))
            found.emplace_back(info.name, info.get(settings));
    return found;
}

bool meets(const PlanGoal& goal, const PlanTry& tried)
{
    return goal.kind == PlanGoal::Kind::max_error ? tried.surely <= goal.value
                                                  : tried.ms <= goal.value;
}

bool better(const PlanGoal& goal, const PlanTry& a, const PlanTry& b)
{
    if (meets(goal, a) != meets(goal, b))
        return meets(goal, a);
    const bool saves_time = meets(goal, b) == (goal.kind == PlanGoal::Kind::max_error);
    if (saves_time)
        return a.ms < kLessTime * b.ms;
    return a.error < kLessError * b.error ||
           (goal.kind == PlanGoal::Kind::budget && a.error < kSameError * b.error);
}

PlanTry search_plan(const PlanGoal& goal, const std::vector<PlanRow>& rows, const PlanTry& start,
                    const TrySettings& attempt)
{
    return Search(goal, rows, start, attempt).run();
}

}  // namespace fumarole::study
