#include "study/bench_plot.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <vector>

#include "study/gnuplot.h"
#include "write/whole_file.h"

namespace fumarole::study {

namespace {

constexpr std::array kColors{"#1f6fb4", "#c8500a", "#2f8f5b", "#7a4fa3",
                             "#606060", "#b8860b", "#b0305c", "#008b8b"};

template <typename T> bool contains(const std::vector<T>& all, const T& one)
{
    return std::find(all.begin(), all.end(), one) != all.end();
}

/// Bars side by side: a cluster for each scene, a bar for each case.
std::string bars(std::span<const BenchFigure> figures, const std::string& group,
                 std::string_view quantity, const std::string& head)
{
    std::vector<std::string> scenes, names;
    for (const BenchFigure& f : figures) {
        if (f.group != group || f.quantity != quantity)
            continue;
        if (!contains(scenes, f.scene))
            scenes.push_back(f.scene);
        if (!contains(names, f.name))
            names.push_back(f.name);
    }
    if (scenes.empty())
        return "";
    std::string program, plots, tics;
    const double width = 0.8 / static_cast<double>(names.size());
    for (std::size_t n = 0; n < names.size(); ++n) {
        std::string rows;
        for (std::size_t s = 0; s < scenes.size(); ++s)
            if (const BenchFigure* f = find_figure(figures, group, scenes[s], names[n], quantity))
                rows += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g}\n",
                                    static_cast<double>(s) - 0.4 +
                                        width * (static_cast<double>(n) + 0.5),
                                    f->value.median, f->value.min, f->value.max, 0.92 * width);
        const std::string block = fmt::format("{}{}", group, n);
        program += data_block(block, rows);
        plots += fmt::format("{}${} using 1:2:5 with boxes fs solid 0.85 lc rgb '{}' title {}, "
                             "${} using 1:2:3:4 with yerrorbars pt 0 lw 1.5 lc rgb '#303030' "
                             "notitle",
                             plots.empty() ? "" : ", \\\n ", block, kColors[n % kColors.size()],
                             in_quotes(names[n]), block);
    }
    for (std::size_t s = 0; s < scenes.size(); ++s)
        tics += fmt::format("{}{} {}", s > 0 ? ", " : "", in_quotes(scenes[s]), s);
    return program + head +
           fmt::format("unset logscale x\nset logscale y\nset xrange [-0.6:{}]\nset autoscale y\n"
                       "set xtics ({}) noenhanced\nset xlabel ' '\nplot {}\n",
                       static_cast<double>(scenes.size()) - 0.4, tics, plots);
}

/// Curves of times along an axis, both by their logarithm.
std::string curves(std::span<const GrowthCurve> all, const std::string& group,
                   const std::string& axis, const std::string& head)
{
    std::string program, plots;
    std::size_t n = 0;
    for (const GrowthCurve& curve : all) {
        if (curve.group != group || curve.axis != axis)
            continue;
        std::string rows;
        for (const auto& [x, y] : curve.points)
            rows += fmt::format("{:.8g} {:.6g}\n", x, y);
        const std::string block = fmt::format("{}{}", group, n);
        program += data_block(block, rows);
        plots += fmt::format("{}${} using 1:2 with linespoints lw 2 pt {} ps 1.6 lc rgb '{}' "
                             "title {}",
                             plots.empty() ? "" : ", \\\n ", block, 5 + n % 9,
                             kColors[n % kColors.size()],
                             in_quotes(fmt::format("{}, {}: {} to the {:.2f}", curve.scene,
                                                   curve.name, axis, curve.growth.exponent)));
        ++n;
    }
    if (plots.empty())
        return "";
    return program + head +
           fmt::format(
               "set logscale xy\nset autoscale\nset xtics auto enhanced\nset format x '10^{{%L}}'\n"
               "set xlabel '{}'\nplot {}\nset format x\n",
               axis, plots);
}

}  // namespace

std::string bench_plot_program(std::span<const BenchFigure> figures, const std::string& title,
                               const std::filesystem::path& png)
{
    const std::vector<GrowthCurve> growth = growth_curves(figures, kVolumeTime);
    const auto head = [](const char* text, const char* y) {
        return fmt::format("set title {} noenhanced\nset ylabel '{}'\n", in_quotes(text), y);
    };
    const std::string worth = fmt::format("{}none", kTimesFaster);
    std::vector<std::string> panels;
    for (std::string panel :
         {bars(figures, "presets", kVolumeTime, head("presets, 480 x 270", "ms a frame")),
          curves(growth, "sizes", "pixels", head("time by pixels", "ms a frame")),
          curves(growth, "steps", "steps", head("time by steps", "ms a frame")),
          curves(growth, "lights", "lights", head("time by lights", "ms a frame")),
          curves(growth, "grids", "voxels stored",
                 head("time by the grid's size, 480 x 270", "ms a frame")),
          curves(growth_curves(figures, "grid on the GPU"), "grids", "active voxels",
                 head("a grid's memory", "bytes")),
          bars(figures, "load", "time", head("loading, stage by stage", "ms")),
          bars(figures, "ablation", worth,
               head("steps of the default, alone and all but one", "times faster than none"))})
        if (!panel.empty())
            panels.push_back(std::move(panel));
    if (panels.empty())
        return "";
    const std::size_t rows = panels.size() > 1 ? (panels.size() + 1) / 2 : 1;
    const std::size_t columns = panels.size() > 1 ? 2 : 1;
    std::string program = fmt::format(
        "set encoding utf8\nset terminal pngcairo size {},{} background '#ffffff' font 'sans,17'\n"
        "set output {}\n"
        "set grid ytics lt 1 lw 1 lc rgb '#dcdcdc'\nset border 3 lw 1.2\nset tics nomirror out\n"
        "set key outside bottom center horizontal maxcols 2 samplen 1.5 width 1 noenhanced\n"
        "set multiplot layout {},{} title {} noenhanced\n",
        950 * columns, 780 * rows, in_quotes(png.string()), rows, columns, in_quotes(title));
    for (const std::string& panel : panels)
        program += panel;
    return program + "unset multiplot\nunset output\n";
}

bool plot_bench(std::span<const BenchFigure> figures, const std::string& title,
                const std::filesystem::path& png)
{
    write::UnfinishedFile unfinished(png);
    const std::string program = bench_plot_program(figures, title, unfinished.path());
    if (program.empty())
        return false;
    run_gnuplot(program, png.parent_path());
    unfinished.finish();
    return true;
}

}  // namespace fumarole::study
