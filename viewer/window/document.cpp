#include "window/document.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <fumarole/asset/animation.h>
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

/// What each medium of a scene takes its grids for; nothing of a box.
std::vector<std::map<GridRole, std::string>> parts_of_all(const Scene& scene)
{
    std::vector<std::map<GridRole, std::string>> parts(scene.media.size());
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (const auto* grid = std::get_if<GridMedium>(&scene.media[i]))
            parts[i] = parts_of(*grid);
    return parts;
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
    grids_.take_listed();
    if (whole_ && !loader_.loading())
        grids_.follow(moving_, scene_, sequence_.moves() ? sequence_.shown() : 0);
    Change change = take_scene();
    include(change, take_routed());
    return change;
}

Change Document::take_scene()
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
    moving_ = std::move(loaded->moving);
    sequence_ = whole_ ? Sequence(moving_, scene_, loaded->frame, input_.hold_missing) : Sequence();
    grids_.open(whole_ ? moving_ : Scene());
    read_memory_.assign(scene_.media.size(), {});
    parts_read_ = parts_of_all(scene_);
    return Change::scene;
}

Change Document::take_routed()
{
    std::optional<GridRouter::Routed> routed = grids_.take_routed();
    if (!routed)
        return Change::none;
    const auto medium = [&](Scene& scene) -> GridMedium& {
        return std::get<GridMedium>(scene.media[routed->medium]);
    };
    RoleMemory& memory = read_memory_[routed->medium];
    remember_parts(memory, medium(as_read_));
    for (Scene* scene : {&scene_, &as_read_}) {
        take_parts(medium(*scene), routed->as, scene == &scene_ ? RoleMemory() : memory);
        medium(*scene).file = routed->as.file;
    }
    const std::string file = medium(moving_).file;
    GridMedium& moving = medium(moving_);
    moving = medium(as_read_);
    moving.file = file;
    if (is_sequence(file))
        moving.density = moving.emission = moving.color = moving.temperature = nullptr;
    for (std::string& note : routed->notes)
        if (std::find(notes_.begin(), notes_.end(), note) == notes_.end())
            notes_.push_back(std::move(note));
    if (sequence_.moves()) {
        const Playback playback = sequence_.playback();
        // Its thread ends once it has read what it is reading, which nobody waits for.
        retired_.run([old = std::make_shared<Sequence>(std::move(sequence_))](
                         const Background::Stop&) mutable { old.reset(); });
        sequence_ = Sequence(moving_, scene_, routed->frame, input_.hold_missing);
        sequence_.playback() = playback;
    }
    return Change::content;
}

void Document::give_role(std::size_t medium, const std::string& grid, GridRole role)
{
    if (!whole_)
        throw Error("the scene is still being read");
    grids_.ask(medium, grid, role);
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

Scene Document::to_save() const
{
    Scene scene = scene_;
    scene.time = moving_.time;
    if (scene.camera == as_read_.camera)
        scene.camera = moving_.camera;
    for (std::size_t i = 0; i < std::min(scene.media.size(), moving_.media.size()); ++i) {
        const auto* moving = std::get_if<GridMedium>(&moving_.media[i]);
        auto* shown = std::get_if<GridMedium>(&scene.media[i]);
        if (moving != nullptr && shown != nullptr && is_sequence(moving->file))
            shown->file = moving->file;
    }
    for (std::size_t i = 0; i < moving_.transparents.size(); ++i) {
        const std::string& file = look_of(moving_.transparents[i]).image_file;
        if (is_on(i) && is_sequence(file))
            look_of(scene.transparents.at(place_of(i))).image_file = file;
    }
    return scene;
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
    return !sequence_.moves() && scene_.camera == as_read_.camera &&
           same_content(scene_, as_read_) && parts_of_all(scene_) == parts_read_;
}

bool Document::at_rest() const
{
    return whole_ && !loading() && !sequence_.playback().playing() && !sequence_.waits();
}

}  // namespace fumarole::window
