#include "scene_input.h"

#include <charconv>
#include <filesystem>
#include <fmt/format.h>

#include "command.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/frame_loader.h>
#include <fumarole/errors.h>

namespace fumarole::command {

glm::uvec2 parse_size(const std::string& text)
{
    glm::uvec2 size(0);
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, size.x);
    if (width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x') {
        const auto height = std::from_chars(width.ptr + 1, end, size.y);
        if (height.ec == std::errc{} && height.ptr == end && size.x >= 1 && size.y >= 1 &&
            size.x <= 16384 && size.y <= 16384)
            return size;
    }
    throw UsageError(fmt::format("--size: '{}' is no size; give WIDTHxHEIGHT, each 1..16384, e.g. "
                                 "480x270",
                                 text));
}

bool is_scene_file(const std::string& file)
{
    return std::filesystem::path(file).extension() == ".json";
}

namespace {

/// A scene file without the files that it names.
asset::LoadedScene parse_input(const SceneInput& input)
{
    if (!input.grid.empty() || input.up != "auto")
        throw UsageError("--grid and --up are for a .vdb; a scene file states its own");
    asset::LoadedScene parsed{asset::parse_scene(input.file), {}};
    if (!input.size.empty())
        parsed.scene.resolution = parse_size(input.size);
    return parsed;
}

asset::LoadedScene auto_scene(const SceneInput& input, const std::string& vdb)
{
    asset::AutoSceneOptions automatic;
    automatic.grid = input.grid;
    automatic.up = input.up == "auto" ? '\0' : input.up.front();
    if (!input.size.empty())
        automatic.resolution = parse_size(input.size);
    return asset::make_auto_scene(vdb, automatic);
}

std::string frame_note(const std::string& what, int frame)
{
    return fmt::format("frame {} of {}; --frames A..B renders more", frame, what);
}

}  // namespace

asset::LoadedScene load_input(const SceneInput& input)
{
    if (!is_scene_file(input.file)) {
        if (!is_sequence(input.file))
            return auto_scene(input, input.file);
        const std::vector<int> frames = frames_of(input.file);
        if (frames.empty())
            throw Error(
                fmt::format("{}: no file is called so, with a number for the #s", input.file));
        asset::LoadedScene loaded = auto_scene(input, frame_file(input.file, frames.front()));
        loaded.notes.push_back(frame_note(input.file, frames.front()));
        return loaded;
    }
    const asset::LoadedScene parsed = parse_input(input);
    const std::optional<int> first = first_frame(parsed.scene);
    asset::LoadedScene loaded = asset::load_frame(parsed.scene, first.value_or(0), parsed.scene);
    if (first)
        loaded.notes.push_back(frame_note(input.file, *first));
    return loaded;
}

asset::LoadedScene open_moving(const SceneInput& input, int first)
{
    if (is_scene_file(input.file))
        return parse_input(input);
    asset::check_frame(input.file, first);
    asset::LoadedScene loaded = auto_scene(input, frame_file(input.file, first));
    if (is_sequence(input.file)) {
        auto& grid = std::get<GridMedium>(loaded.scene.media.front());
        grid.file = input.file;
        grid.density = grid.emission = grid.color = nullptr;
    }
    return loaded;
}

}  // namespace fumarole::command
