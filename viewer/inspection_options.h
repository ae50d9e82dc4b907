#pragma once

#include <optional>
#include <string>

#include <fumarole/inspection.h>
#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>
#include <fumarole/write/image_writer.h>

// `render --show`: words to an inspection, and an inspection to a picture for a screen.

namespace fumarole::command {

struct InspectionOptions {
    std::string show;
    std::optional<std::string> slice;
    std::optional<double> scale;
};

/// @throws UsageError for a word that the kind has no use for, or that is none.
Inspection parse_inspection(const InspectionOptions& options, const Settings& settings);

/// "density-slice: 0 .. 20 1/m, extinction at z = 3 m"
std::string legend_line(const Inspection& inspection, const InspectionLegend& legend);

/// R, G, B as drawn; with_bar: false colours have the bar of their colours under them.
Image image_of(const InspectionStill& still, bool with_bar);

}  // namespace fumarole::command
