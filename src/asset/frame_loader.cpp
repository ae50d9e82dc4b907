#include <fumarole/asset/frame_loader.h>

#include <fmt/format.h>

#include <fumarole/asset/animation.h>
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
        if (const auto& grid = std::get<GridMedium>(from.media[i]); grid.file == to->file) {
            to->density = grid.density;
            to->emission = grid.emission;
            to->color = grid.color;
        }
    }
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        if (auto* mesh = std::get_if<MeshSurface>(&scene.surfaces[i]))
            mesh->mesh = std::get<MeshSurface>(from.surfaces[i]).mesh;
    scene.world.environment = from.world.environment;
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
    for (const Medium& medium : scene.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium))
            check_frame(grid->file, frame);
    LoadedScene loaded{scene_at(scene, frame), {}};
    take_over(loaded.scene, like);
    load_scene_files(loaded);
    return loaded;
}

FrameLoader::FrameLoader(LoadedScene scene, int first, int last)
    : scene_{std::move(scene)}, next_{first}, last_{last}
{
    start(first);
}

void FrameLoader::start(int frame)
{
    loading_ = std::async(std::launch::async,
                          [this, frame] { return load_frame(scene_.scene, frame, scene_.scene); });
}

LoadedScene FrameLoader::next()
{
    LoadedScene loaded = loading_.get();
    // What the first frame read and no other changes is there for all.
    if (Scene kept = scene_.scene; ++next_ <= last_) {
        for (std::size_t i = 0; i < kept.media.size(); ++i)
            if (auto* grid = std::get_if<GridMedium>(&kept.media[i]);
                grid != nullptr && !is_sequence(grid->file))
                kept.media[i] = loaded.scene.media[i];
        kept.surfaces = loaded.scene.surfaces;
        kept.world = loaded.scene.world;
        scene_.scene = std::move(kept);
        start(next_);
    }
    return loaded;
}

}  // namespace fumarole::asset
