#include <fumarole/asset/sequence.h>

#include <algorithm>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <fumarole/asset/animation.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

std::string list_names(const VdbInfo& file)
{
    std::string names;
    for (const GridInfo& grid : file.grids)
        names += fmt::format("{}'{}'", names.empty() ? "" : ", ", grid.name);
    return names.empty() ? "they have no grids" : "they have " + names;
}

}  // namespace

std::vector<SequenceFrame> read_sequence(const std::filesystem::path& pattern)
{
    const std::vector<int> there = frames_of(pattern);
    if (there.empty())
        throw Error(
            fmt::format("{}: no file is called so, with a number in its place", pattern.string()));
    std::vector<SequenceFrame> frames(there.size());
    tbb::parallel_for(std::size_t{0}, there.size(), [&](std::size_t i) {
        frames[i].frame = there[i];
        try {
            frames[i].file = read_vdb_headers(frame_file(pattern, there[i]));
        } catch (const Error& error) {
            frames[i].error = error.what();
        }
    });
    if (std::all_of(frames.begin(), frames.end(),
                    [](const SequenceFrame& frame) { return !frame.error.empty(); }))
        throw Error(frames.front().error);
    return frames;
}

VdbInfo all_grids(const std::vector<SequenceFrame>& frames)
{
    VdbInfo all;
    for (const SequenceFrame& frame : frames) {
        if (all.creator.empty())
            all.creator = frame.file.creator;
        all.file_bytes += frame.file.file_bytes;
        for (const GridInfo& grid : frame.file.grids) {
            const auto same = std::find_if(all.grids.begin(), all.grids.end(),
                                           [&](const GridInfo& g) { return g.name == grid.name; });
            if (same == all.grids.end()) {
                all.grids.push_back(grid);
            } else {
                same->active_voxels += grid.active_voxels;
                same->max = std::max(same->max, grid.max);
            }
        }
    }
    return all;
}

void settle_sequences(Scene& scene)
{
    for (Medium& medium : scene.media) {
        auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || !is_sequence(grid->file))
            continue;
        const VdbInfo all = all_grids(read_sequence(grid->file));
        if (grid->grid.empty()) {
            const std::vector<const GridInfo*> candidates = fog_candidates(all);
            const auto held = std::find_if(candidates.begin(), candidates.end(),
                                           [](const GridInfo* g) { return g->active_voxels > 0; });
            if (held == candidates.end())
                throw Error(fmt::format("{}: nothing to take as fog in any frame; {}", grid->file,
                                        list_names(all)));
            grid->grid = (*held)->name;
        }
        for (const std::string& name :
             {grid->grid, grid->emission_grid, grid->color_grid, grid->temperature_grid})
            if (!name.empty() && !has_grid(all, name))
                throw Error(fmt::format("{}: no frame has a grid '{}'; {}", grid->file, name,
                                        list_names(all)));
    }
}

std::optional<int> first_frame_with_content(const Scene& scene)
{
    std::optional<int> first;
    for (const Medium& medium : scene.media) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || !is_sequence(grid->file))
            continue;
        const std::vector<SequenceFrame> frames = read_sequence(grid->file);
        const auto held = std::find_if(frames.begin(), frames.end(), [&](const SequenceFrame& of) {
            const auto holds = [&](const std::string& name) {
                return !name.empty() && voxels_in(of.file, name) > 0;
            };
            return voxels_in(of.file, grid->grid) > 0 || holds(grid->emission_grid) ||
                   holds(grid->temperature_grid);
        });
        const int frame = (held == frames.end() ? frames.begin() : held)->frame;
        first = std::min(first.value_or(frame), frame);
    }
    return first;
}

}  // namespace fumarole::asset
