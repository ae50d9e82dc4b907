#include "inspection_options.h"

#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "command.h"
#include "study/false_color.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

using Kind = Inspection::Kind;

/// [AXIS=]POSITION of --slice.
void parse_slice(const std::string& text, Inspection& inspection)
{
    constexpr std::string_view kAxes = "xyz";
    std::string_view rest = text;
    if (inspection.kind == Kind::density_slice && rest.size() > 2 && rest[1] == '=' &&
        kAxes.find(rest[0]) != std::string_view::npos) {
        inspection.axis = static_cast<int>(kAxes.find(rest[0]));
        rest.remove_prefix(2);
    }
    const auto parsed =
        std::from_chars(rest.data(), rest.data() + rest.size(), inspection.position);
    if (parsed.ec != std::errc{} || parsed.ptr != rest.data() + rest.size() ||
        !(inspection.position >= 0 && inspection.position <= 1))
        throw UsageError(
            fmt::format("--slice: '{}' is no slice; give {} in 0..1, e.g. {}", text,
                        inspection.kind == Kind::density_slice ? "[AXIS=]POSITION" : "POSITION",
                        inspection.kind == Kind::density_slice ? "x=0.5" : "0.5"));
}

}  // namespace

Inspection parse_inspection(const InspectionOptions& options, const Settings& settings)
{
    Inspection inspection;
    // probe=N
    constexpr std::string_view kProbe = "probe=";
    std::string show = options.show;
    if (show.starts_with(kProbe)) {
        const char *first = show.data() + kProbe.size(), *last = show.data() + show.size();
        const auto parsed = std::from_chars(first, last, inspection.probe);
        if (parsed.ec != std::errc{} || parsed.ptr != last || inspection.probe < 0)
            throw UsageError(
                fmt::format("--show: '{}' names no probe; give probe=N, from 0", show));
        show = "probe";
    }
    try {
        inspection.kind = find_inspection(show);
    } catch (const Error& error) {
        throw UsageError(fmt::format("--show: {}", error.what()));
    }
    const bool sliced =
        inspection.kind == Kind::density_slice || inspection.kind == Kind::froxel_slice;
    if (options.slice && !sliced)
        throw UsageError("--slice: is for --show density-slice and froxel-slice");
    if (options.slice)
        parse_slice(*options.slice, inspection);
    if (options.scale && (inspection.kind == Kind::scattering || inspection.kind == Kind::probe ||
                          inspection.kind == Kind::transmittance))
        throw UsageError(fmt::format("--scale: is for false colours; --show {} is shown as it is",
                                     options.show));
    if (options.scale && !(*options.scale > 0 && std::isfinite(*options.scale)))
        throw UsageError(
            fmt::format("--scale: {} is no end of a scale; give one above 0", *options.scale));
    inspection.scale = options.scale.value_or(0);
    if (inspection.kind == Kind::froxel_slice && settings.mode != Settings::Mode::froxel)
        throw UsageError("--show froxel-slice: goes with --mode froxel");
    return inspection;
}

std::string legend_line(const Inspection& inspection, const InspectionLegend& legend)
{
    std::string line = fmt::format("{}: ", inspection_name(inspection.kind));
    if (legend.false_color)
        line += fmt::format("{:.4g} .. {:.4g}{}{}, {}", legend.low, legend.high,
                            legend.unit.empty() ? "" : " ", legend.unit, legend.caption);
    else
        line +=
            legend.unit.empty() ? "as it is, 0 .. 1" : fmt::format("as it is [{}]", legend.unit);
    return line;
}

Image image_of(const InspectionStill& still, bool with_bar)
{
    Image image{still.width, still.height, {"R", "G", "B"}, still.pixels};
    const InspectionLegend& legend = still.legend;
    if (!with_bar || !legend.false_color)
        return image;
    std::array<std::string, 5> ticks;
    for (std::size_t i = 0; i < ticks.size(); ++i)
        ticks.at(i) =
            fmt::format("{:.3g}", legend.low + (legend.high - legend.low) * static_cast<double>(i) /
                                                   static_cast<double>(ticks.size() - 1));
    return study::with_color_bar(
        image, study::Difference::magnitude, ticks,
        legend.unit.empty() ? legend.caption : fmt::format("{} ({})", legend.caption, legend.unit));
}

}  // namespace fumarole::command
