#include "window/saving.h"

#include <filesystem>
#include <fmt/format.h>

#include "picture_files.h"
#include "shell_words.h"
#include "study/reference_cache.h"
#include "window/user_files.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

/// Words that name the scene as it was opened.
std::string opened_words(const command::SceneInput& input)
{
    std::string words = command::shell_word(input.file);
    if (!input.grid.empty())
        words += " --grid " + command::shell_word(input.grid);
    if (input.up != "auto")
        words += " --up " + input.up;
    return words;
}

/// Writes an edited scene where a command line can name it. Returns the file.
fs::path cached_scene(const Scene& scene)
{
    const fs::path folder = cache_folder() / "scenes";
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw Error(fmt::format("{}: {}; the scene of the command line can't be kept",
                                folder.string(), error.message()));
    const std::string text = asset::scene_to_json(scene, folder);
    fs::path file = folder / (study::text_hash(text) + ".json");
    asset::save_scene(scene, file);
    return file;
}

void write_image(const Image& image, const Display& display, const std::string& file)
{
    if (fs::path(file).extension() == ".png")
        write::write_png(image, display, file);
    else
        write::write_exr(image, file, {.captured = command::capture_date()});
}

}  // namespace

std::string unused_name(const std::string& scene_file, const std::string& extension)
{
    std::string stem = fs::path(scene_file).stem().string();
    std::erase(stem, '#');
    for (int i = 1;; ++i) {
        std::string name = i == 1 ? stem + extension : fmt::format("{}_{}{}", stem, i, extension);
        if (!fs::exists(name))
            return name;
    }
}

void save_picture(const std::string& file, const Document& document, const ViewState& state,
                  Viewport& viewport, glm::ivec2 pixels)
{
    if (state.inspection) {
        write_image(viewport.sides().a().read(), display_of(state), file);
        return;
    }
    if (state.reference) {
        if (!viewport.reference().picture().whole)
            throw Error("the reference is not whole yet: wait for it, then save");
        write_image(viewport.reference().image(), state.display(), file);
        return;
    }
    Scene scene = document.scene();
    scene.resolution = glm::uvec2(pixels);
    const Still still = viewport.still(scene, state);
    command::write_picture(command::picture_of(still),
                           {.outputs = {file},
                            .target = "",
                            .exposure = state.exposure_ev,
                            .transform = state.transform,
                            .exr = {.captured = command::capture_date()}});
}

std::string copied_command(const Document& document, const ViewState& state, glm::ivec2 pixels)
{
    const std::string input = document.untouched()
                                  ? opened_words(document.input())
                                  : command::shell_word(cached_scene(document.scene()).string());
    return command_line(state, input, pixels, unused_name(document.input().file, ".png"));
}

}  // namespace fumarole::window
