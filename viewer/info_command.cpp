#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "asset/grid_names.h"
#include "blackbody.h"
#include "command.h"
#include "device_options.h"
#include "medium/grid_layout.h"
#include "scene_input.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/sequence.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

using Json = nlohmann::ordered_json;

/// What a grid will take on the GPU, or why it can't go there.
struct GpuPlan {
    std::uint64_t bytes = 0;
    std::string layout, storage, storage_reason, refusal;
};

GpuPlan plan(const std::filesystem::path& file, const asset::GridInfo& grid)
{
    if (!grid.refusal.empty())
        return {0, "", "", "", grid.refusal};
    if (grid.active_voxels == 0)
        return {0, "", "", "", "empty"};
    try {
        const asset::LoadedGrid loaded = asset::load_grid(file, grid.name);
        const medium::GridLayout layout = medium::plan_layout(
            loaded.grid, medium::Layout::automatic, medium::Storage::automatic, medium::Limits{});
        return {layout.gpu_bytes(), layout.layout == medium::Layout::dense ? "dense" : "bricks",
                std::string(medium::storage_name(layout.storage)), layout.storage_reason, ""};
    } catch (const Error& error) {
        return {0, "", "", "", error.what()};
    }
}

bool is_temperature(const asset::GridInfo& grid)
{
    const auto& names = asset::temperature_names();
    return grid.active_voxels > 0 && !grid.value_type.starts_with("vec3") &&
           std::find(names.begin(), names.end(),
                     asset::lower_case(asset::without_number(grid.name))) != names.end();
}

/// As a scene takes it that states no temperature_scale.
double kelvin_per_unit(const asset::GridInfo& grid)
{
    return guess_kelvin_per_unit(grid.max);
}

Json to_json(glm::dvec3 v)
{
    return {v.x, v.y, v.z};
}
Json to_json(glm::ivec3 v)
{
    return {v.x, v.y, v.z};
}

Json to_json(const asset::GridInfo& grid, const GpuPlan& gpu)
{
    Json matrix = Json::array();
    for (int row = 0; row < 4; ++row) {
        Json numbers = Json::array();
        for (int column = 0; column < 4; ++column)
            numbers.push_back(grid.world_from_index[column][row]);
        matrix.push_back(numbers);
    }
    const bool empty = grid.active_voxels == 0;
    return {{"name", grid.name},
            {"type", grid.value_type},
            {"class", grid.grid_class},
            {"transform", grid.transform},
            {"world_from_index", matrix},
            {"voxel_size_m", to_json(grid.voxel_size)},
            {"index_min", empty ? Json() : to_json(grid.index_min)},
            {"index_max", empty ? Json() : to_json(grid.index_max)},
            {"world_min_m", empty ? Json() : to_json(grid.world_min)},
            {"world_max_m", empty ? Json() : to_json(grid.world_max)},
            {"active_voxels", grid.active_voxels},
            {"leaf_bricks", grid.leaf_bricks},
            {"active_tiles", grid.active_tiles},
            {"min", grid.min},
            {"max", grid.max},
            {"mean", grid.mean},
            {"kelvin_per_unit", is_temperature(grid) ? Json(kelvin_per_unit(grid)) : Json()},
            {"nan", grid.nan_count},
            {"infinite", grid.inf_count},
            {"negative", grid.negative_count},
            {"gpu_bytes", gpu.bytes},
            {"gpu_layout", gpu.layout},
            {"gpu_storage", gpu.storage},
            {"gpu_storage_reason", gpu.storage_reason},
            {"refusal", gpu.refusal}};
}

std::string triple(glm::dvec3 v)
{
    return fmt::format("{:.6g} {:.6g} {:.6g}", v.x, v.y, v.z);
}

void print(const asset::GridInfo& grid, const GpuPlan& gpu)
{
    fmt::print("grid '{}'\n", grid.name);
    fmt::print("  type           {}, {}\n", grid.value_type, grid.grid_class);
    fmt::print("  transform      {}, voxels of {} m\n", grid.transform, triple(grid.voxel_size));
    if (grid.active_voxels > 0) {
        fmt::print("  index bounds   {} .. {}\n", triple(glm::dvec3(grid.index_min)),
                   triple(glm::dvec3(grid.index_max)));
        fmt::print("  world bounds   {} .. {} m\n", triple(grid.world_min), triple(grid.world_max));
    }
    fmt::print("  active voxels  {} in {} bricks and {} tiles\n", grid.active_voxels,
               grid.leaf_bricks, grid.active_tiles);
    fmt::print("  values         {:.6g} .. {:.6g}, mean {:.6g}\n", grid.min, grid.max, grid.mean);
    if (is_temperature(grid))
        fmt::print("  temperature    {:.6g} K at most, 1 taken for {} K\n",
                   kelvin_per_unit(grid) * grid.max, kelvin_per_unit(grid));
    if (grid.nan_count + grid.inf_count + grid.negative_count > 0)
        fmt::print("  unusual        {} NaN, {} infinite, {} negative\n", grid.nan_count,
                   grid.inf_count, grid.negative_count);
    if (gpu.refusal.empty())
        fmt::print("  on the GPU     {:.2f} MB, {} in {} ({}), {:.2f} bytes an active voxel\n",
                   static_cast<double>(gpu.bytes) * 1e-6, gpu.layout, gpu.storage,
                   gpu.storage_reason,
                   static_cast<double>(gpu.bytes) / static_cast<double>(grid.active_voxels));
    else
        fmt::print("  on the GPU     nothing: {}\n", gpu.refusal);
}

/// Frames as a person writes them: 1..48, 50..60.
std::string spans(const std::vector<int>& frames)
{
    std::string text;
    for (std::size_t i = 0, end = 0; i < frames.size(); i = end) {
        for (end = i + 1; end < frames.size() && frames[end] == frames[end - 1] + 1; ++end) {
        }
        text += fmt::format("{}{}", text.empty() ? "" : ", ", frames[i]);
        if (end > i + 1)
            text += fmt::format("..{}", frames[end - 1]);
    }
    return text;
}

/// What the frames of a sequence have, by their headers; and the frame that tells most of it.
struct Frames {
    std::vector<int> there, empty, broken;
    asset::VdbInfo all;  ///< index bounds and the like are the first frame's, voxels of all
    int shown = 0;

    explicit Frames(const std::string& pattern)
    {
        const std::vector<asset::SequenceFrame> frames = asset::read_sequence(pattern);
        all = asset::all_grids(frames);
        std::uint64_t most = 0;
        for (const asset::SequenceFrame& frame : frames) {
            const std::uint64_t voxels = asset::voxels_in(frame.file, "");
            there.push_back(frame.frame);
            if (!frame.error.empty())
                broken.push_back(frame.frame);
            else if (voxels == 0)
                empty.push_back(frame.frame);
            if (voxels > most || frame.frame == there.front()) {
                most = voxels;
                shown = frame.frame;
            }
        }
    }

    void print(const std::string& pattern) const
    {
        fmt::print("{}: frames {}\n", pattern, spans(there));
        if (!empty.empty())
            fmt::print("  empty          {}\n", spans(empty));
        if (!broken.empty())
            fmt::print("  broken         {}\n", spans(broken));
        for (const asset::GridInfo& grid : all.grids)
            fmt::print("  grid           '{}', {} active voxels in all\n", grid.name,
                       grid.active_voxels);
        fmt::print("the fullest of them:\n");
    }

    [[nodiscard]] Json json() const
    {
        return {{"there", there}, {"empty", empty}, {"broken", broken}, {"shown", shown}};
    }
};

void run(const std::string& name, bool json)
{
    std::optional<Frames> frames;
    check_no_glob(name);
    if (is_sequence(name))
        frames.emplace(name);
    const std::string file = frames ? frame_file(name, frames->shown).string() : name;
    const asset::VdbInfo info = asset::inspect_vdb(file);
    Json grids = Json::array();
    if (!json && frames)
        frames->print(name);
    if (!json)
        fmt::print("{}: {} grid{}, {} bytes{}\n", file, info.grids.size(),
                   info.grids.size() == 1 ? "" : "s", info.file_bytes,
                   info.creator.empty() ? "" : ", made by " + info.creator);
    for (const asset::GridInfo& grid : info.grids) {
        const GpuPlan gpu = plan(info.file, grid);
        if (json)
            grids.push_back(to_json(grid, gpu));
        else
            print(grid, gpu);
    }
    if (!json)
        return;
    Json all{{"file", file},
             {"file_bytes", info.file_bytes},
             {"creator", info.creator},
             {"grids", grids}};
    if (frames)
        all["frames"] = frames->json();
    fmt::print("{}\n", all.dump(1, ' ', false, Json::error_handler_t::replace));
}

// ------------------------------------------------------------------------------------- devices

std::string kind_of(const gl::DeviceDescription& device)
{
    return !device.refusal.empty() ? "can't be used: " + device.refusal
           : device.software       ? "software"
                                   : "GPU";
}

Json device_json(const gl::DeviceDescription& device)
{
    return {{"name", device.name},
            {"vendor", device.vendor},
            {"version", device.version},
            {"software", device.software},
            {"refusal", device.refusal.empty() ? Json() : Json(device.refusal)}};
}

/// EGL's devices by number, OSMesa, and which of them is taken where nothing is said.
void run_devices(bool json)
{
    const std::vector<gl::DeviceDescription> egl = gl::HeadlessContext::egl_devices();
    const gl::DeviceDescription osmesa = gl::HeadlessContext::osmesa_device();
    std::vector<bool> software;
    software.reserve(egl.size());
    for (const gl::DeviceDescription& device : egl)
        software.push_back(device.software);
    const gl::DeviceChoice choice =
        gl::choose_device({}, software, [&](std::size_t i) { return egl[i]; });
    if (json) {
        Json devices = Json::array();
        for (std::size_t i = 0; i < egl.size(); ++i) {
            devices.push_back({{"device", i}, {"backend", "egl"}});
            devices.back().update(device_json(egl[i]));
        }
        devices.push_back({{"device", nullptr}, {"backend", "osmesa"}});
        devices.back().update(device_json(osmesa));
        const Json all{{"devices", devices},
                       {"automatic",
                        {{"device", choice.egl_device ? Json(*choice.egl_device) : Json()},
                         {"backend", choice.egl_device ? "egl" : "osmesa"},
                         {"reason", choice.reason}}}};
        fmt::print("{}\n", all.dump(1, ' ', false, Json::error_handler_t::replace));
        return;
    }
    fmt::print("{:<8}{:<40}{:<22}{:<40}\n", "device", "name", "vendor", "OpenGL");
    const auto row = [](const std::string& number, const gl::DeviceDescription& device) {
        fmt::print("{:<8}{:<40}{:<22}{:<40}{}\n", number, device.name, device.vendor,
                   device.version, kind_of(device));
    };
    for (std::size_t i = 0; i < egl.size(); ++i)
        row(fmt::format("{}", i), egl[i]);
    row("osmesa", osmesa);
    fmt::print("--backend auto takes {}\n", choice.reason);
}

}  // namespace

void add_info(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "info", "What a .vdb file holds, and what it will take; or what there is to draw with");
    auto file = std::make_shared<std::string>();
    auto json = std::make_shared<bool>(false), devices = std::make_shared<bool>(false);
    CLI::Option* input =
        command->add_option("FILE", *file, "a .vdb or .nvdb file, or a sequence: smoke_####.vdb");
    command
        ->add_flag("--devices", *devices, "what OpenGL can draw with here, for --device, instead")
        ->excludes(input);
    command->add_flag("--json", *json, "print JSON");
    command->callback([=] {
        if (*devices)
            run_devices(*json);
        else if (file->empty())
            throw UsageError("info: FILE is required, or --devices");
        else
            run(*file, *json);
    });
}

}  // namespace fumarole::command
