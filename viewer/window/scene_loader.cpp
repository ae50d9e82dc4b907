#include "window/scene_loader.h"

#include <filesystem>
#include <fmt/format.h>
#include <new>
#include <utility>

#include "window/glfw_window.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/frame_loader.h>
#include <fumarole/asset/sequence.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

/// The media and surfaces that can be drawn while files are still being read.
Scene without_missing(const Scene& scene)
{
    Scene there = scene;
    std::erase_if(there.media, [](const Medium& medium) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        return grid != nullptr &&
               (grid->density == nullptr ||
                (!grid->emission_grid.empty() && grid->emission == nullptr) ||
                (!grid->color_grid.empty() && grid->color == nullptr) ||
                (!grid->temperature_grid.empty() && grid->temperature == nullptr));
    });
    std::erase_if(there.surfaces, [](const Surface& surface) {
        const auto* mesh = std::get_if<MeshSurface>(&surface);
        return mesh != nullptr && mesh->mesh == nullptr;
    });
    return there;
}

std::string what_is_read(const std::string& file)
{
    std::error_code error;
    const auto bytes = fs::file_size(file, error);
    const std::string name = fs::path(file).filename().string();
    return error ? "reading " + name
                 : fmt::format("reading {}, {:.1f} MB", name, static_cast<double>(bytes) * 1e-6);
}

/// Gives the grids of `from` to other media of the same file, which need not read it again.
void share(Scene& scene, const GridMedium& from)
{
    for (Medium& medium : scene.media)
        if (auto* grid = std::get_if<GridMedium>(&medium);
            grid != nullptr && grid->density == nullptr && grid->file == from.file &&
            grid->grid == from.grid && grid->emission_grid == from.emission_grid &&
            grid->color_grid == from.color_grid &&
            grid->temperature_grid == from.temperature_grid && grid->motion == from.motion) {
            grid->density = from.density;
            grid->emission = from.emission;
            grid->color = from.color;
            grid->temperature = from.temperature;
            if (grid->temperature_scale == 0)
                grid->temperature_scale = from.temperature_scale;
        }
}

}  // namespace

void SceneLoader::open(const command::SceneInput& input)
{
    input_ = input;
    shared_ = std::make_shared<Shared>();
    task_.run(
        [input, shared = shared_](const Background::Stop& stop) { read(input, *shared, stop); });
}

std::optional<SceneLoader::Loaded> SceneLoader::take()
{
    const std::lock_guard lock(shared_->lock);
    return std::exchange(shared_->loaded, std::nullopt);
}

std::string SceneLoader::progress() const
{
    const std::lock_guard lock(shared_->lock);
    return shared_->progress;
}

void SceneLoader::publish(Shared& shared, Loaded loaded)
{
    {
        const std::lock_guard lock(shared.lock);
        shared.loaded = std::move(loaded);
    }
    GlfwWindow::wake();
}

void SceneLoader::set_progress(Shared& shared, const std::string& progress)
{
    const std::lock_guard lock(shared.lock);
    shared.progress = progress;
}

void SceneLoader::read(const command::SceneInput& input, Shared& shared,
                       const Background::Stop& stop)
{
    const auto fail = [&](const std::string& why) {
        publish(shared, {.part = {}, .whole = false, .moving = {}, .error = why});
    };
    try {
        if (command::is_scene_file(input.file))
            read_scene(input, shared, stop);
        else
            read_vdb(input, shared);
    } catch (const std::bad_alloc&) {
        fail(input.file + ": out of memory");
    } catch (const std::exception& error) {
        fail(error.what());
    }
}

void SceneLoader::read_vdb(const command::SceneInput& input, Shared& shared)
{
    set_progress(shared, what_is_read(input.file));
    asset::LoadedScene opened = command::open_moving(input);
    Loaded loaded;
    loaded.frame = asset::first_frame_with_content(opened.scene).value_or(0);
    loaded.part = asset::load_frame(opened.scene, loaded.frame, opened.scene);
    loaded.part.notes.insert(loaded.part.notes.begin(), opened.notes.begin(), opened.notes.end());
    loaded.moving = std::move(opened.scene);
    loaded.whole = true;
    publish(shared, std::move(loaded));
}

void SceneLoader::read_scene(const command::SceneInput& input, Shared& shared,
                             const Background::Stop& stop)
{
    Loaded loaded;
    loaded.moving = command::open_moving(input).scene;
    loaded.frame = asset::first_frame_with_content(loaded.moving).value_or(0);
    asset::LoadedScene& part = loaded.part;
    part.scene = scene_at(loaded.moving, loaded.frame);
    const auto publish_part = [&] {
        publish(shared, {.part = {without_missing(part.scene), part.notes},
                         .whole = false,
                         .moving = {},
                         .error = {}});
    };
    publish_part();
    // The media are read first and one at a time: they are what the window was opened for.
    for (std::size_t i = 0; i < part.scene.media.size(); ++i) {
        auto* grid = std::get_if<GridMedium>(&part.scene.media[i]);
        if (grid == nullptr || grid->density != nullptr || stop)
            continue;
        set_progress(shared, what_is_read(grid->file));
        Scene only;
        only.media = {loaded.moving.media[i]};
        only.frames_per_second = loaded.moving.frames_per_second;
        const asset::LoadedScene alone = asset::load_frame(only, loaded.frame, only);
        part.scene.media[i] = alone.scene.media.front();
        part.notes.insert(part.notes.end(), alone.notes.begin(), alone.notes.end());
        share(part.scene, std::get<GridMedium>(part.scene.media[i]));
        publish_part();
    }
    set_progress(shared, "reading surfaces and world");
    if (!stop)
        asset::load_scene_files(part);
    loaded.whole = true;
    publish(shared, std::move(loaded));
}

}  // namespace fumarole::window
