#include "study/stability_held.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "study/chart.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

constexpr double kGrowth = 1.25;    // of a figure that falls short
constexpr double kMargin = 0.5;     // of the distance to its bound that a figure may use up
constexpr double kRounding = 5e-4;  // of a figure: stability.csv has four digits of it

constexpr std::array<std::string_view, 11> kColumns{"group",  "case",  "mode",  "preset",
                                                    "figure", "sense", "bound", "unit",
                                                    "holds",  "shows", "reason"};

std::string csv_row(const std::vector<std::string>& fields)
{
    std::string row;
    for (std::size_t i = 0; i < fields.size(); ++i) {
        if (i > 0)
            row += ',';
        row += csv_field(fields[i]);
    }
    row += "\r\n";
    return row;
}

/// Fields of the record that begins at `at`, which moves past it. Quotes as csv_field makes them.
std::vector<std::string> take_record(std::string_view csv, std::size_t& at)
{
    std::vector<std::string> fields{""};
    bool quoted = false;
    for (; at < csv.size(); ++at) {
        const char c = csv[at];
        if (c == '"' && quoted && at + 1 < csv.size() && csv[at + 1] == '"')
            fields.back() += csv[++at];
        else if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            fields.emplace_back();
        else if (c == '\n' && !quoted)
            break;
        else if (c != '\r' || quoted)
            fields.back() += c;
    }
    ++at;
    return fields;
}

std::vector<std::string> record_of(const StabilityResult& r)
{
    const StabilityCase& c = *r.run.what;
    return {fmt::format("{}", c.group),
            c.name,
            std::string(r.run.subject->mode),
            std::string(r.run.subject->preset),
            fmt::format("{:.4g}", r.figure.value),
            c.sense == StabilityCase::Bound::at_most ? "at most" : "at least",
            fmt::format("{:.4g}", c.bound),
            c.unit,
            r.holds ? "yes" : (r.refusal.empty() ? "no" : "no: " + r.refusal),
            c.shows,
            c.reason};
}

const StabilityResult* find_result(const std::vector<StabilityResult>& results,
                                   const HeldCase& before)
{
    const auto found = std::find_if(results.begin(), results.end(),
                                    [&](const StabilityResult& r) { return before.is(r.run); });
    return found == results.end() ? nullptr : &*found;
}

bool is_worse(const StabilityCase& one, const HeldCase& before, double figure)
{
    if (std::isnan(figure))
        return !std::isnan(before.figure);
    const double limit = held_limit(one, before);
    const double rounding = std::isfinite(before.figure) ? kRounding * std::abs(before.figure) : 0;
    return one.sense == StabilityCase::Bound::at_most ? figure > limit + rounding
                                                      : figure < limit - rounding;
}

/// "wire-half (raymarch, default): 0.01 then, 0.02 now, to be at most 0.03"
std::string change_line(const HeldCase& before, const StabilityResult& now)
{
    const StabilityCase& c = *now.run.what;
    return fmt::format("{} ({}, {}): {:.4g} then, {:.4g} now, to be {} {:.4g}{}", before.name,
                       before.mode, before.preset, before.figure, now.figure.value,
                       c.sense == StabilityCase::Bound::at_most ? "at most" : "at least", c.bound,
                       now.refusal.empty() ? "" : ": " + now.refusal);
}

}  // namespace

std::string stability_csv(const std::vector<StabilityResult>& results)
{
    std::string csv = csv_row({kColumns.begin(), kColumns.end()});
    for (const StabilityResult& r : results)
        csv += csv_row(record_of(r));
    return csv;
}

std::string merged_csv(const std::vector<StabilityRun>& runs,
                       const std::vector<std::filesystem::path>& files)
{
    std::vector<const std::vector<std::string>*> found(runs.size(), nullptr);
    std::vector<std::vector<HeldCase>> parts;
    for (const std::filesystem::path& file : files) {
        parts.push_back(read_held(write::read_whole(file), file));
        for (const HeldCase& one : parts.back()) {
            const auto run =
                std::ranges::find_if(runs, [&](const StabilityRun& r) { return one.is(r); });
            const std::string name = fmt::format("{} {}/{}", one.name, one.mode, one.preset);
            if (run == runs.end() || one.fields.size() != kColumns.size())
                throw Error(fmt::format("{}: {} is no run of this choice and program; merge with "
                                        "the options that the shards had",
                                        file.string(), name));
            const std::vector<std::string>*& slot =
                found[static_cast<std::size_t>(run - runs.begin())];
            if (slot != nullptr)
                throw Error(fmt::format("{}: {} is in a file before it too; give each shard once",
                                        file.string(), name));
            slot = &one.fields;
        }
    }
    std::string csv = csv_row({kColumns.begin(), kColumns.end()});
    for (std::size_t i = 0; i < runs.size(); ++i) {
        if (found[i] == nullptr)
            throw Error(fmt::format("{} {}/{} is in none of the files; a shard is missing",
                                    runs[i].what->name, runs[i].subject->mode,
                                    runs[i].subject->preset));
        csv += csv_row(*found[i]);
    }
    return csv;
}

std::vector<HeldCase> read_held(std::string_view csv, const std::filesystem::path& file)
{
    std::size_t at = 0;
    const std::vector<std::string> names = take_record(csv, at);
    const auto column = [&](std::string_view name) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end())
            throw Error(
                fmt::format("{}: no column '{}'; is it a stability.csv?", file.string(), name));
        return static_cast<std::size_t>(found - names.begin());
    };
    const std::size_t name = column("case"), mode = column("mode"), preset = column("preset"),
                      figure = column("figure"), holds = column("holds");
    std::vector<HeldCase> cases;
    for (int record = 2; at < csv.size(); ++record) {
        std::vector<std::string> fields = take_record(csv, at);
        if (fields.size() != names.size())
            throw Error(fmt::format("{}: record {} has {} fields where {} belong", file.string(),
                                    record, fields.size(), names.size()));
        HeldCase one{fields[name], fields[mode], fields[preset], 0, fields[holds] == "yes", {}};
        const std::string& text = fields[figure];
        const auto [end, error] =
            std::from_chars(text.data(), text.data() + text.size(), one.figure);
        if (error != std::errc{} || end != text.data() + text.size())
            throw Error(
                fmt::format("{}: record {}: '{}' is no figure", file.string(), record, text));
        if (!one.held && !fields[holds].starts_with("no"))
            throw Error(fmt::format("{}: record {}: '{}' is neither yes nor no", file.string(),
                                    record, fields[holds]));
        one.fields = std::move(fields);
        cases.push_back(std::move(one));
    }
    return cases;
}

double held_limit(const StabilityCase& one, const HeldCase& before)
{
    const double figure = before.figure;
    const bool at_most = one.sense == StabilityCase::Bound::at_most;
    const double worst = at_most ? HUGE_VAL : -HUGE_VAL;
    if (before.held)  // an infinite order of convergence has no half way to its bound
        return std::isfinite(figure) ? figure + kMargin * (one.bound - figure) : one.bound;
    if (!std::isfinite(figure))
        return worst;
    return at_most ? kGrowth * figure : one.bound - kGrowth * (one.bound - figure);
}

HeldChanges compare_held(const std::vector<HeldCase>& before,
                         const std::vector<StabilityResult>& now)
{
    const std::vector<StabilityRun> all = stability_runs({});
    HeldChanges changes;
    for (const HeldCase& old : before) {
        const StabilityResult* result = find_result(now, old);
        if (result == nullptr) {
            if (old.held && std::none_of(all.begin(), all.end(),
                                         [&](const StabilityRun& run) { return old.is(run); }))
                changes.lost.push_back(fmt::format("{} ({}, {}) held and is no case any more",
                                                   old.name, old.mode, old.preset));
        } else if (old.held != result->holds) {
            (old.held ? changes.lost : changes.gained).push_back(change_line(old, *result));
        } else if (is_worse(*result->run.what, old, result->figure.value)) {
            changes.worse.push_back(fmt::format("{}; {:.4g} is the limit",
                                                change_line(old, *result),
                                                held_limit(*result->run.what, old)));
        }
    }
    for (const StabilityResult& r : now)
        if (std::none_of(before.begin(), before.end(),
                         [&](const HeldCase& old) { return old.is(r.run); }))
            changes.added.push_back(fmt::format("{} ({}, {}): {:.4g}, {}", r.run.what->name,
                                                r.run.subject->mode, r.run.subject->preset,
                                                r.figure.value, r.holds ? "holds" : "falls short"));
    return changes;
}

std::string accepted_csv(const std::vector<HeldCase>& before,
                         const std::vector<StabilityResult>& now, const std::filesystem::path& file)
{
    std::string csv = csv_row({kColumns.begin(), kColumns.end()});
    for (const StabilityRun& run : stability_runs({})) {
        const auto is_run = [&](const StabilityResult& r) {
            return r.run.what == run.what && r.run.subject == run.subject;
        };
        const auto measured = std::find_if(now.begin(), now.end(), is_run);
        const auto old = std::find_if(before.begin(), before.end(),
                                      [&](const HeldCase& held) { return held.is(run); });
        if (measured != now.end()) {
            csv += csv_row(record_of(*measured));
        } else if (old != before.end()) {
            if (old->fields.size() != kColumns.size())
                throw Error(fmt::format("{}: has {} columns where stability.csv has {}; measure "
                                        "all cases to replace it",
                                        file.string(), old->fields.size(), kColumns.size()));
            csv += csv_row(old->fields);
        }
    }
    return csv;
}

}  // namespace fumarole::study
