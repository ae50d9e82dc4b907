#include "window/document.h"

#include <algorithm>

#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

/// Puts a frame's grids and images into a scene whose coefficients and places stay.
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
    for (std::size_t i = 0; i < std::min(scene.transparents.size(), frame.transparents.size());
         ++i) {
        TransparentLook& look = look_of(scene.transparents[i]);
        look.image_file = look_of(frame.transparents[i]).image_file;
        look.image = look_of(frame.transparents[i]).image;
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
    scene_.time = frame->time;
    if (scene_.camera == as_read_.camera)
        scene_.camera = frame->camera;
    as_read_ = *frame;
    return Change::frame;
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
