#include "study/chart_plot.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "study/gnuplot.h"
#include "write/whole_file.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;

/// How a mode looks: its shape tells it apart where its colour can't.
struct ModeStyle {
    const char* color;
    int hollow, filled;  ///< gnuplot's point types of one shape
};

ModeStyle style_of(Settings::Mode mode)
{
    return mode == Settings::Mode::froxel ? ModeStyle{"#c8500a", 8, 9}   // triangle
                                          : ModeStyle{"#1f6fb4", 6, 7};  // circle
}

/// A preset has a mark of its own, drawn over its mode's.
constexpr std::array kPresetMarks{
    std::pair<std::string_view, int>{"default", 4},             // square
    std::pair<std::string_view, int>{"eevee2017", 10},          // triangle down
    std::pair<std::string_view, int>{"froxel", 12},             // diamond
    std::pair<std::string_view, int>{"eevee2017-froxel", 14}};  // pentagon

bool drawable(const MeasuredPoint& p, Target target)
{
    return p.finite() && p.median_ms > 0 && p.min_ms > 0 && p.error(target).relmse > 0 &&
           p.error(target).relmse_min > 0;
}

std::string row(const MeasuredPoint& p, Target target)
{
    const TargetError& e = p.error(target);
    return fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n", p.median_ms, e.relmse,
                       p.min_ms, p.max_ms, e.relmse_min, e.relmse_max);
}

/// Points of a mode that go by one mark.
struct Series {
    std::string title, style, rows;
};

std::vector<Series> series_of(const Chart& chart)
{
    std::vector<Series> series;
    const auto add = [&](const std::string& title, const std::string& style,
                         const MeasuredPoint& p) {
        auto at = std::find_if(series.begin(), series.end(),
                               [&](const Series& s) { return s.title == title; });
        if (at == series.end())
            at = series.insert(series.end(), {title, style, ""});
        at->rows += row(p, chart.target);
    };
    for (const bool alone : {false, true})
        for (const MeasuredPoint& p : chart.points) {
            if (p.point.alone != alone || !drawable(p, chart.target))
                continue;
            const ModeStyle mode = style_of(p.point.settings.mode);
            add(fmt::format("{}, {}", p.point.mode(),
                            alone ? "one setting changed" : "several changed"),
                fmt::format("pt {} ps {} lc rgb '{}'", alone ? mode.filled : mode.hollow,
                            alone ? 1.9 : 1.6, mode.color),
                p);
        }
    return series;
}

struct Span {
    double low = std::numeric_limits<double>::infinity(), high = 0;

    void add(double value)
    {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    /// Where a value lies from low, 0, to high, 1, by logarithm.
    [[nodiscard]] double share(double value) const
    {
        return std::log(value / low) / std::log(high / low);
    }
    /// A share of the span, and a little where it is none, on both sides.
    void widen(double share)
    {
        const double factor = std::max(1.15, std::pow(high / low, share));
        low /= factor;
        high *= factor;
    }
};

/// The numbers of the front beside its points; one label for neighbours whose own would lie on one
/// another: `7-10`.
std::string front_labels(const std::vector<const MeasuredPoint*>& front, Target target,
                         const Span& time, const Span& error)
{
    struct Label {
        const MeasuredPoint* at;
        int first, last;
    };
    const auto near = [&](const MeasuredPoint& a, const MeasuredPoint& b) {
        return std::abs(time.share(a.median_ms) - time.share(b.median_ms)) < 0.04 &&
               std::abs(error.share(a.error(target).relmse) - error.share(b.error(target).relmse)) <
                   0.04;
    };
    std::vector<Label> labels;
    int number = 0;
    for (const MeasuredPoint* p : front) {
        ++number;
        if (!drawable(*p, target))
            continue;
        if (!labels.empty() && near(*labels.back().at, *p))
            labels.back().last = number;
        else
            labels.push_back({p, number, number});
    }
    std::string rows;
    for (const Label& label : labels)
        rows +=
            fmt::format("{:.6g} {:.6g} {}\n", label.at->median_ms, label.at->error(target).relmse,
                        label.first == label.last ? fmt::format("{}", label.first)
                                                  : fmt::format("{}-{}", label.first, label.last));
    return rows;
}

std::string number_text(double value)
{
    return value < 1e-4 || value >= 1e5 ? fmt::format("{:.0e}", value) : fmt::format("{:g}", value);
}

std::string tick_list(const Span& span)
{
    std::string list;
    for (const double tick : log_ticks(span.low, span.high))
        list += fmt::format("{}'{}' {:g}", list.empty() ? "" : ", ", number_text(tick), tick);
    return list;
}

}  // namespace

std::vector<double> log_ticks(double low, double high)
{
    const double decades = std::log10(high / low);
    std::vector<double> ticks;
    const int stride = decades > 8 ? 2 : 1;
    for (int power = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, power) <= high;
         power += stride)
        for (const double digit : {1.0, 2.0, 5.0}) {
            const double tick = digit * std::pow(10.0, power);
            if (tick >= low && tick <= high && (digit == 1.0 || decades < 3))
                ticks.push_back(tick);
        }
    return ticks;
}

std::string plot_program(const Chart& chart, const std::string& title, const fs::path& svg,
                         const fs::path& png)
{
    Span time, error;
    std::string bars, front;
    for (const MeasuredPoint& p : chart.points) {
        if (!drawable(p, chart.target))
            continue;
        const TargetError& e = p.error(chart.target);
        time.add(p.min_ms);
        time.add(p.max_ms);
        error.add(e.relmse_min);
        error.add(e.relmse_max);
        bars += row(p, chart.target);
    }
    if (bars.empty())
        throw Error("no point of the chart has a time and an error above 0; there is nothing to "
                    "draw");
    time.widen(0.06);
    error.widen(0.10);
    const std::vector<const MeasuredPoint*> on_front = chart.front();
    for (const MeasuredPoint* p : on_front)
        if (drawable(*p, chart.target))
            front += row(*p, chart.target);
    // Drawn on to the right: more time than the last point takes buys nothing.
    if (!on_front.empty())
        front +=
            fmt::format("{:.6g} {:.6g}\n", time.high, on_front.back()->error(chart.target).relmse);

    std::string program = "set encoding utf8\n";
    program += data_block("bars", bars) + data_block("front", front) +
               data_block("numbers", front_labels(on_front, chart.target, time, error));
    std::string plots = fmt::format(
        "$bars using 1:2:3:4:5:6 with xyerrorbars ps 0 lw 1.2 lc rgb '#9c9c9c' "
        "title 'spread of times, of seeds', \\\n"
        " $front using 1:2 with steps lw 2.5 lc rgb '#000000' title 'front: no point beats it'");
    int block = 0;
    for (const Series& series : series_of(chart)) {
        const std::string name = fmt::format("series{}", block++);
        program += data_block(name, series.rows);
        plots += fmt::format(", \\\n ${} using 1:2 with points {} lw 1.6 title {}", name,
                             series.style, in_quotes(series.title));
    }
    for (const auto& [preset, mark] : kPresetMarks)
        for (const MeasuredPoint& p : chart.points)
            if (p.point.is_preset && p.point.preset == preset && drawable(p, chart.target)) {
                const std::string name = fmt::format("series{}", block++);
                program += data_block(name, row(p, chart.target));
                plots += fmt::format(", \\\n ${} using 1:2 with points pt {} ps 3.4 lw 3 lc rgb "
                                     "'#000000' title {}",
                                     name, mark, in_quotes(fmt::format("preset {}", preset)));
                program += fmt::format(
                    "set label {} at {:.6g},{:.6g} left offset character -1.2,-1.6 front\n",
                    in_quotes(preset), p.median_ms, p.error(chart.target).relmse);
            }
    plots += ", \\\n $numbers using 1:2:3 with labels left offset character 0.4,0.9 notitle";
    if (std::isfinite(chart.floor) && chart.floor > 0)
        plots += fmt::format(
            ", \\\n {:.6g} with lines dt 3 lw 1.5 lc rgb '#606060' title {}", chart.floor,
            in_quotes(fmt::format("floor: least error reached, {:.2e}", chart.floor)));

    program += fmt::format(
        "set title {} noenhanced\n"
        "set logscale xy\n"
        "set xrange [{:.6g}:{:.6g}]\nset yrange [{:.6g}:{:.6g}]\n"
        "set xtics ({})\nset ytics ({})\n"
        "set grid xtics ytics lt 1 lw 1 lc rgb '#dcdcdc'\n"
        "set border 3 lw 1.2\nset tics nomirror out\n"
        "set xlabel \"time that the volume adds to a frame, median  [ms]\\n \"\n"
        "set ylabel 'relative MSE of the {} to the reference  [1]'\n"
        "set key outside bottom center horizontal maxcols 3 samplen 2.5 width 1 noenhanced\n",
        in_quotes(title), time.low, time.high, error.low, error.high, tick_list(time),
        tick_list(error), kTargetNames[static_cast<std::size_t>(chart.target)]);
    program += fmt::format("set terminal pngcairo size 1600,1120 background '#ffffff' font "
                           "'sans,20' \nset output {}\nplot {}\nunset output\n",
                           in_quotes(png.string()), plots);
    program += fmt::format("set terminal svg size 1000,700 background '#ffffff' font "
                           "'sans-serif,13'\nset output {}\nreplot\nunset output\n",
                           in_quotes(svg.string()));
    return program;
}

void plot_chart(const Chart& chart, const std::string& title, const fs::path& svg,
                const fs::path& png)
{
    write::UnfinishedFile new_svg(svg), new_png(png);
    run_gnuplot(plot_program(chart, title, new_svg.path(), new_png.path()), svg.parent_path());
    new_svg.finish();
    new_png.finish();
}

}  // namespace fumarole::study
