#include "scene_input.h"

#include <charconv>
#include <filesystem>
#include <fmt/format.h>

#include "asset/auto_scene.h"
#include "command.h"

namespace fumarole::command {

namespace {

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

}  // namespace

bool is_scene_file(const std::string& file)
{
    return std::filesystem::path(file).extension() == ".json";
}

asset::LoadedScene load_input(const SceneInput& input)
{
    if (is_scene_file(input.file)) {
        if (!input.grid.empty() || input.up != "auto")
            throw UsageError("--grid and --up are for a .vdb; a scene file states its own");
        asset::LoadedScene loaded = asset::load_scene(input.file);
        if (!input.size.empty())
            loaded.scene.resolution = parse_size(input.size);
        return loaded;
    }
    asset::AutoSceneOptions automatic;
    automatic.grid = input.grid;
    automatic.up = input.up == "auto" ? '\0' : input.up.front();
    if (!input.size.empty())
        automatic.resolution = parse_size(input.size);
    return asset::make_auto_scene(input.file, automatic);
}

}  // namespace fumarole::command
