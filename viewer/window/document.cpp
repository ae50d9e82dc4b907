#include "window/document.h"

#include <filesystem>
#include <fmt/format.h>
#include <new>
#include <utility>

#include "window/glfw_window.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/frame_loader.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

/// What can be drawn while files are still being read.
Scene without_missing(const Scene& scene)
{
    Scene there = scene;
    std::erase_if(there.media, [](const Medium& medium) {
        const auto* grid = std::get_if<GridMedium>(&medium);
        return grid != nullptr && (grid->density == nullptr ||
                                   (!grid->emission_grid.empty() && grid->emission == nullptr) ||
                                   (!grid->color_grid.empty() && grid->color == nullptr));
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

/// Other media of the same file and grids need not read it again.
void share(Scene& scene, const GridMedium& from)
{
    for (Medium& medium : scene.media)
        if (auto* grid = std::get_if<GridMedium>(&medium);
            grid != nullptr && grid->density == nullptr && grid->file == from.file &&
            grid->grid == from.grid && grid->emission_grid == from.emission_grid &&
            grid->color_grid == from.color_grid) {
            grid->density = from.density;
            grid->emission = from.emission;
            grid->color = from.color;
        }
}

}  // namespace

void Document::open(const command::SceneInput& input)
{
    input_ = input;
    mail_ = std::make_shared<Mail>();
    task_.run([input, mail = mail_](const Background::Stop& stop) { read(input, *mail, stop); });
}

std::optional<Document::News> Document::take()
{
    const std::lock_guard lock(mail_->lock);
    return std::exchange(mail_->news, std::nullopt);
}

std::string Document::progress() const
{
    const std::lock_guard lock(mail_->lock);
    return mail_->progress;
}

void Document::read(const command::SceneInput& input, Mail& mail, const Background::Stop& stop)
{
    const auto fail = [&](const std::string& why) {
        const std::lock_guard lock(mail.lock);
        mail.news = News{.loaded = {}, .whole = false, .moving = {}, .error = why};
    };
    try {
        read_scene(input, mail, stop);
    } catch (const std::bad_alloc&) {
        fail(input.file + ": out of memory");
    } catch (const std::exception& error) {
        fail(error.what());
    }
}

void Document::read_scene(const command::SceneInput& input, Mail& mail,
                          const Background::Stop& stop)
{
    const auto tell = [&](const std::string& progress) {
        const std::lock_guard lock(mail.lock);
        mail.progress = progress;
    };
    const auto send = [&](News news) {
        {
            const std::lock_guard lock(mail.lock);
            mail.news = std::move(news);
        }
        GlfwWindow::wake();
    };
    if (!command::is_scene_file(input.file)) {
        int first = 0;
        if (is_sequence(input.file)) {
            const std::vector<int> frames = frames_of(input.file);
            first = frames.empty() ? 0 : frames.front();
        }
        tell(what_is_read(frame_file(input.file, first).string()));
        News news;
        news.moving = command::open_moving(input, first).scene;
        news.loaded = asset::load_frame(news.moving, first, news.moving);
        news.whole = true;
        send(std::move(news));
        return;
    }
    News news;
    news.moving = command::open_moving(input, 0).scene;
    const int first = first_frame(news.moving).value_or(0);
    for (const Medium& medium : news.moving.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium))
            asset::check_frame(grid->file, first);
    asset::LoadedScene& loaded = news.loaded;
    loaded.scene = scene_at(news.moving, first);
    const auto send_part = [&] {
        send({.loaded = {without_missing(loaded.scene), loaded.notes},
              .whole = false,
              .moving = {},
              .error = {}});
    };
    send_part();
    // One at a time, the media first: they are what one came for.
    for (Medium& medium : loaded.scene.media) {
        auto* grid = std::get_if<GridMedium>(&medium);
        if (grid == nullptr || grid->density != nullptr || stop)
            continue;
        tell(what_is_read(grid->file));
        asset::LoadedScene alone{{}, {}};
        alone.scene.media = {*grid};
        asset::load_scene_files(alone);
        medium = alone.scene.media.front();
        loaded.notes.insert(loaded.notes.end(), alone.notes.begin(), alone.notes.end());
        share(loaded.scene, std::get<GridMedium>(medium));
        send_part();
    }
    tell("reading surfaces and world");
    if (!stop)
        asset::load_scene_files(loaded);
    news.whole = true;
    send(std::move(news));
}

}  // namespace fumarole::window
