#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <memory>

#include "command.h"
#include "context/headless_context.h"
#include "library_log.h"
#include "scene_input.h"
#include "window/thumbnail_files.h"
#include "write/png_text.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::command {

namespace {

struct ThumbnailOptions {
    std::string input, output;
    int size = 256;
};

/// What a file manager asks for each file of a folder: no more than it takes to know one's smoke,
/// and no file that would make the desktop wait.
void run(const ThumbnailOptions& options)
{
    constexpr std::uint64_t kMostMemory = std::uint64_t(2) << 30;
    asset::set_memory_limit(kMostMemory);
    const unsigned height = static_cast<unsigned>(std::max(1, options.size * 3 / 4));
    const std::vector<write::PngText> texts = window::thumbnail_texts(options.input);
    SceneInput input;
    input.file = options.input;
    input.size = fmt::format("{}x{}", options.size, height);
    input.up = "auto";
    const asset::LoadedScene loaded = load_input(input);
    const auto context = gl::HeadlessContext::make();
    SceneRenderer renderer(context->get_proc(), library_log());
    Settings settings = find_preset("default");
    settings.bounces = 0;  // once is quick
    StillOptions still_options;
    still_options.aa = 8;
    still_options.layers = false;
    Still still = renderer.render(loaded.scene, settings, still_options);
    Image image;
    image.width = still.width;
    image.height = still.height;
    image.channels = {"R", "G", "B"};
    image.pixels = std::move(still.composite);
    // By these texts others know what it is of, and when it is out of date.
    write::write_png(image, {.exposure_ev = write::auto_exposure(image)}, options.output, texts);
}

}  // namespace

void add_thumbnail(CLI::App& app)
{
    CLI::App* command = app.add_subcommand("thumbnail", "A small picture, for a file manager");
    auto options = std::make_shared<ThumbnailOptions>();
    command->add_option("INPUT", options->input, "a .vdb or .nvdb file, or a scene")->required();
    command->add_option("OUTPUT", options->output, "a .png, whatever its name")->required();
    command->add_option("-s,--size", options->size, "the larger side in pixels [256]")
        ->type_name("N")
        ->check(within(1, 4096));
    command->group("");
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
