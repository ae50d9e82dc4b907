#include <fumarole/inspection.h>

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include <fumarole/errors.h>

namespace fumarole {

namespace {

using Kind = Inspection::Kind;

constexpr std::array kTable{
    InspectionInfo{Kind::scattering, "scattering", "light that the media send to the eye"},
    InspectionInfo{Kind::transmittance, "transmittance", "what the media let through"},
    InspectionInfo{Kind::depth, "depth", "view depth of the surfaces"},
    InspectionInfo{Kind::samples, "samples", "evaluations of the media a pixel"},
    InspectionInfo{Kind::density_slice, "density-slice", "extinction on a plane"},
    InspectionInfo{Kind::froxel_slice, "froxel-slice", "light in one slice of the froxels"},
    InspectionInfo{Kind::bricks, "bricks", "boxes of what is kept of the media"},
    InspectionInfo{Kind::layers, "layers", "transparent layers of a pixel"},
    InspectionInfo{Kind::probe, "probe", "what a probe has seen, =N of several"}};

}  // namespace

std::span<const InspectionInfo> inspection_table()
{
    return kTable;
}

std::string_view inspection_name(Inspection::Kind kind)
{
    return kTable.at(static_cast<std::size_t>(kind)).name;
}

Inspection::Kind find_inspection(std::string_view name)
{
    const auto found = std::find_if(kTable.begin(), kTable.end(),
                                    [&](const InspectionInfo& info) { return info.name == name; });
    if (found != kTable.end())
        return found->kind;
    std::string names;
    for (const InspectionInfo& info : kTable)
        names += fmt::format("{}{}", names.empty() ? "" : ", ", info.name);
    throw Error(fmt::format("there is nothing called '{}' to show; there is: {}", name, names));
}

}  // namespace fumarole
