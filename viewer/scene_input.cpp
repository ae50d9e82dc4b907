#include "scene_input.h"

#include <charconv>
#include <filesystem>
#include <fmt/format.h>

#include "asset/grid_names.h"
#include "command.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/frame_loader.h>
#include <fumarole/asset/sequence.h>
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

bool has_extension(const std::string& file, std::string_view extension)
{
    return asset::lower_case(std::filesystem::path(file).extension().string()) == extension;
}

bool is_scene_file(const std::string& file)
{
    return has_extension(file, ".json");
}

void check_no_glob(const std::string& file)
{
    std::error_code unknown;
    if (file.find_first_of("*?<") != std::string::npos && !std::filesystem::exists(file, unknown))
        throw Error(fmt::format("{}: no such file; the numbers of a sequence are #, e.g. "
                                "smoke_####.vdb",
                                file));
}

namespace {

/// A scene file without the files that it names.
asset::LoadedScene parse_input(const SceneInput& input)
{
    if (!input.grid.empty() || input.up != "auto")
        throw UsageError("--grid and --up are for a .vdb or .nvdb; a scene file states its own");
    asset::LoadedScene parsed{asset::parse_scene(input.file), {}};
    if (!input.size.empty())
        parsed.scene.resolution = parse_size(input.size);
    return parsed;
}

std::string frame_note(const std::string& what, int frame)
{
    return fmt::format("frame {} of {}; --frames A..B renders more", frame, what);
}

}  // namespace

asset::LoadedScene open_moving(const SceneInput& input)
{
    if (is_scene_file(input.file)) {
        asset::LoadedScene parsed = parse_input(input);
        asset::settle_sequences(parsed.scene);
        return parsed;
    }
    check_no_glob(input.file);
    asset::AutoSceneOptions automatic;
    automatic.grid = input.grid;
    automatic.up = input.up == "auto" ? '\0' : input.up.front();
    if (!input.size.empty())
        automatic.resolution = parse_size(input.size);
    return asset::make_auto_scene(input.file, automatic);
}

asset::LoadedScene load_input(const SceneInput& input)
{
    const asset::LoadedScene opened = open_moving(input);
    const std::optional<int> first = asset::first_frame_with_content(opened.scene);
    asset::LoadedScene loaded = asset::load_frame(opened.scene, first.value_or(0), opened.scene);
    loaded.notes.insert(loaded.notes.begin(), opened.notes.begin(), opened.notes.end());
    if (first)
        loaded.notes.push_back(frame_note(input.file, *first));
    return loaded;
}

}  // namespace fumarole::command
