#include "window/document.h"

#include <algorithm>

#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

/// Puts a frame's grids into a scene whose coefficients and places stay.
void take_grids(Scene& scene, const Scene& frame)
{
    for (std::size_t i = 0; i < std::min(scene.media.size(), frame.media.size()); ++i) {
        auto* grid = std::get_if<GridMedium>(&scene.media[i]);
        const auto* next = std::get_if<GridMedium>(&frame.media[i]);
        if (grid == nullptr || next == nullptr)
            continue;
        grid->file = next->file;
        grid->density = next->density;
        grid->emission = next->emission;
        grid->color = next->color;
        grid->temperature = next->temperature;
    }
}

}  // namespace

Document::Document(const command::SceneInput& input) : input_{input}
{
    if (!input.file.empty())
        loader_.open(input);
}

void Document::open(const std::string& file)
{
    loader_.open(
        {.file = file, .size = "", .grid = "", .up = "auto", .hold_missing = input_.hold_missing});
}

Change Document::take_loaded()
{
    std::optional<SceneLoader::Loaded> loaded = loader_.take();
    if (!loaded)
        return Change::none;
    if (!loaded->error.empty())
        throw Error(loaded->error);
    input_ = loader_.input();
    whole_ = loaded->whole;
    notes_ = std::move(loaded->part.notes);
    scene_ = std::move(loaded->part.scene);
    as_read_ = scene_;
    off_.clear();
    sequence_ =
        whole_ ? Sequence(std::move(loaded->moving), scene_, loaded->frame, input_.hold_missing)
               : Sequence();
    return Change::scene;
}

Change Document::play(double seconds)
{
    const std::optional<Scene> frame = sequence_.advance(seconds);
    if (!frame)
        return Change::none;
    take_grids(scene_, *frame);
    take_images(*frame);
    scene_.time = frame->time;
    if (scene_.camera == as_read_.camera)
        scene_.camera = frame->camera;
    as_read_ = *frame;
    return Change::frame;
}

std::size_t Document::place_of(std::size_t i) const
{
    return i - static_cast<std::size_t>(std::distance(off_.begin(), off_.lower_bound(i)));
}

Transparent& Document::transparent(std::size_t i)
{
    const auto off = off_.find(i);
    return off != off_.end() ? off->second : scene_.transparents.at(place_of(i));
}

void Document::switch_transparent(std::size_t i, bool on)
{
    if (is_on(i) == on)
        return;
    const auto at = scene_.transparents.begin() + static_cast<std::ptrdiff_t>(place_of(i));
    if (on) {
        scene_.transparents.insert(at, off_.at(i));
        off_.erase(i);
    } else {
        off_.emplace(i, *at);
        scene_.transparents.erase(at);
    }
}

void Document::remove_transparent(std::size_t i)
{
    switch_transparent(i, false);
    off_.erase(i);
    std::map<std::size_t, Transparent> moved;  // those after it go up
    for (auto& [place, transparent] : off_)
        moved.emplace(place > i ? place - 1 : place, std::move(transparent));
    off_ = std::move(moved);
}

void Document::take_images(const Scene& frame)
{
    for (std::size_t i = 0; i < std::min(transparent_count(), frame.transparents.size()); ++i) {
        TransparentLook& look = look_of(transparent(i));
        look.image_file = look_of(frame.transparents[i]).image_file;
        look.image = look_of(frame.transparents[i]).image;
    }
}

bool Document::untouched() const
{
    return !sequence_.moves() && scene_.camera == as_read_.camera && same_content(scene_, as_read_);
}

bool Document::at_rest() const
{
    return whole_ && !loading() && !sequence_.playback().playing() && !sequence_.waits();
}

}  // namespace fumarole::window
