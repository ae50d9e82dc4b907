#include <fumarole/asset/frame_loader.h>

#include <fmt/format.h>

#include <fumarole/asset/animation.h>
#include <fumarole/asset/load_limits.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

namespace fs = std::filesystem;

/// Takes over what was read already of files that both scenes name. Frames of one scene have the
/// same media and surfaces in the same places.
void take_over(Scene& scene, const Scene& from)
{
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        auto* to = std::get_if<GridMedium>(&scene.media[i]);
        if (to == nullptr)
            continue;
        const auto& grid = std::get<GridMedium>(from.media[i]);
        // One unit for all frames, whatever the largest value of each.
        if (to->temperature_scale == 0)
            to->temperature_scale = grid.temperature_scale;
        if (grid.file == to->file) {
            to->density = grid.density;
            to->emission = grid.emission;
            to->color = grid.color;
            to->temperature = grid.temperature;
        }
    }
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        if (auto* mesh = std::get_if<MeshSurface>(&scene.surfaces[i]))
            mesh->mesh = std::get<MeshSurface>(from.surfaces[i]).mesh;
    for (std::size_t i = 0; i < scene.transparents.size(); ++i) {
        TransparentLook& look = look_of(scene.transparents[i]);
        const TransparentLook& other = look_of(from.transparents[i]);
        if (look.image_file == other.image_file)
            look.image = other.image;
        if (auto* mesh = std::get_if<MeshTransparent>(&scene.transparents[i]))
            mesh->mesh = std::get<MeshTransparent>(from.transparents[i]).mesh;
    }
    scene.world.environment = from.world.environment;
}

std::shared_ptr<const VoxelGrid> nothing(const std::string& name)
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = name;
    return grid;
}

/// Fills in those grids of a frame's medium that its file doesn't have, or has without a voxel.
void fill_absent(GridMedium& medium)
{
    const auto wanted = [](const std::shared_ptr<const VoxelGrid>& grid, const std::string& name) {
        return !grid && !name.empty();
    };
    if (medium.density && !wanted(medium.emission, medium.emission_grid) &&
        !wanted(medium.color, medium.color_grid) &&
        !wanted(medium.temperature, medium.temperature_grid))
        return;
    const VdbInfo file = read_vdb_headers(medium.file);
    if (!medium.density && voxels_in(file, medium.grid) == 0)
        medium.density = nothing(medium.grid);
    if (wanted(medium.emission, medium.emission_grid) && voxels_in(file, medium.emission_grid) == 0)
        medium.emission = nothing(medium.emission_grid);
    if (wanted(medium.color, medium.color_grid) && voxels_in(file, medium.color_grid) == 0)
        medium.color = nothing(medium.color_grid);
    if (wanted(medium.temperature, medium.temperature_grid) &&
        voxels_in(file, medium.temperature_grid) == 0)
        medium.temperature = nothing(medium.temperature_grid);
}

/// Gives a transparent a picture and a blend by which nobody sees it.
void show_nothing(TransparentLook& look)
{
    auto image = std::make_shared<TransparentImage>();
    image->width = image->height = 1;
    image->texels = {glm::vec4(0)};
    look.image = image;
    look.image_file.clear();
    look.blend = {};
}

/// Whether a medium has a file a frame.
bool is_moving(const Medium& medium)
{
    const auto* grid = std::get_if<GridMedium>(&medium);
    return grid != nullptr && is_sequence(grid->file);
}

}  // namespace

void check_frame(const fs::path& sequence, int frame)
{
    if (!is_sequence(sequence) || fs::exists(frame_file(sequence, frame)))
        return;
    const std::vector<int> there = frames_of(sequence);
    throw Error(fmt::format(
        "{}: frame {} is missing; {}", frame_file(sequence, frame).string(), frame,
        there.empty() ? fmt::format("no file is called {}", sequence.string())
                      : fmt::format("{} of {} are there, the first {}, the last {}", there.size(),
                                    sequence.string(), there.front(), there.back())));
}

LoadedScene load_frame(const Scene& scene, int frame, const Scene& like)
{
    LoadedScene loaded{scene_at(scene, frame), {}};
    take_over(loaded.scene, like);
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        if (!is_moving(scene.media[i]))
            continue;
        check_frame(std::get<GridMedium>(scene.media[i]).file, frame);
        fill_absent(std::get<GridMedium>(loaded.scene.media[i]));
    }
    for (const Transparent& transparent : scene.transparents)
        check_frame(look_of(transparent).image_file, frame);
    load_scene_files(loaded);
    return loaded;
}

FrameLoader::FrameLoader(LoadedScene scene, FrameRange frames, MissingFrames missing)
    : scene_{std::move(scene)}, frames_{frames}, missing_{missing}, next_{frames.first}
{
    start(next_);
}

void FrameLoader::start(int frame)
{
    loading_ = std::async(std::launch::async,
                          [this, frame] { return load_frame(scene_.scene, frame, scene_.scene); });
}

LoadedScene FrameLoader::held(int frame, const std::string& why) const
{
    LoadedScene loaded{scene_at(scene_.scene, frame), {}};
    take_over(loaded.scene, scene_.scene);
    for (std::size_t i = 0; i < loaded.scene.media.size(); ++i) {
        if (!is_moving(scene_.scene.media[i]))
            continue;
        if (!last_.media.empty()) {
            loaded.scene.media[i] = last_.media[i];
            continue;
        }
        auto& medium = std::get<GridMedium>(loaded.scene.media[i]);
        medium.density = nothing(medium.grid);
        medium.emission = nothing(medium.emission_grid);
        medium.color = nothing(medium.color_grid);
        medium.temperature = nothing(medium.temperature_grid);
    }
    for (std::size_t i = 0; i < loaded.scene.transparents.size(); ++i) {
        if (!is_sequence(look_of(scene_.scene.transparents[i]).image_file))
            continue;
        TransparentLook& look = look_of(loaded.scene.transparents[i]);
        if (!last_.transparents.empty())
            look = look_of(last_.transparents[i]);
        else
            show_nothing(look);
    }
    load_scene_files(loaded);
    loaded.notes.push_back(why + "; held the one before it");
    return loaded;
}

std::optional<LoadedScene> FrameLoader::next()
{
    const int frame = next_;
    std::optional<LoadedScene> loaded;
    try {
        loaded = loading_.get();
    } catch (const LoadCancelled&) {
        throw;
    } catch (const Error& error) {
        if (missing_ == MissingFrames::fail)
            throw;
        if (missing_ == MissingFrames::hold)
            loaded = held(frame, error.what());
    }
    if (loaded)
        last_ = loaded->scene;
    if (next_ > frames_.last - frames_.step)
        return loaded;
    // What the first frame read and no other changes is there for all.
    if (loaded) {
        for (std::size_t i = 0; i < scene_.scene.media.size(); ++i)
            if (!is_moving(scene_.scene.media[i]))
                scene_.scene.media[i] = loaded->scene.media[i];
            else
                std::get<GridMedium>(scene_.scene.media[i]).temperature_scale =
                    std::get<GridMedium>(loaded->scene.media[i]).temperature_scale;
        scene_.scene.surfaces = loaded->scene.surfaces;
        for (std::size_t i = 0; i < scene_.scene.transparents.size(); ++i)
            if (!is_sequence(look_of(scene_.scene.transparents[i]).image_file))
                scene_.scene.transparents[i] = loaded->scene.transparents[i];
        scene_.scene.world = loaded->scene.world;
    }
    next_ += frames_.step;
    start(next_);
    return loaded;
}

}  // namespace fumarole::asset
