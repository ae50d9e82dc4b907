#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "asset/auto_scene.h"
#include "asset/scene_file.h"
#include "command.h"
#include "errors.h"
#include "gl/headless_context.h"
#include "scene_input.h"
#include "scene_renderer.h"
#include "settings.h"
#include "write/image_writer.h"

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
    std::string input;
    std::vector<std::string> outputs;
    std::string size, grid, up = "auto", backend = "osmesa", exposure = "auto", display = "filmic",
                            preset = "default", target, save_scene, mode;
    int aa = 1, frames = 1;
    std::uint32_t seed = 0;
    bool alpha = false, explain = false, json = false;
    std::map<std::string, std::string> settings;  ///< by name, as given
};

Settings parse_settings(const Options& options)
{
    try {
        Settings settings = find_preset(options.preset);
        for (const auto& [name, value] : options.settings)
            find_setting(name).set(settings, value);
        if (!options.mode.empty())
            settings.mode = find_mode(options.mode);
        return settings;
    } catch (const Error& error) {
        throw UsageError(error.what());
    }
}

/// The channels of one target, as they are called in an EXR of all of them.
struct Target {
    std::string name;
    const std::vector<float>* pixels;
    int channels;
};

std::vector<Target> targets_of(const Still& still)
{
    return {{"composite", &still.composite, 3},         {"scattering", &still.scattering, 3},
            {"transmittance", &still.transmittance, 3}, {"surface", &still.surface, 3},
            {"surface_lit", &still.surface_lit, 3},     {"depth", &still.depth, 1}};
}

Image empty_image(const Still& still)
{
    Image image;
    image.width = still.width;
    image.height = still.height;
    return image;
}

/// R, G, B of one target; depth thrice.
Image single_target(const Still& still, const Target& target)
{
    Image image = empty_image(still);
    image.channels = {"R", "G", "B"};
    const std::size_t pixels = target.pixels->size() / static_cast<std::size_t>(target.channels);
    for (std::size_t i = 0; i < pixels; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            image.pixels.push_back(target.channels == 3 ? (*target.pixels)[i * 3 + c]
                                                        : (*target.pixels)[i]);
    return image;
}

/// Depth with the sky, which would rule any exposure, made 0.
Image without_sky(Image depth)
{
    for (float& value : depth.pixels)
        value = value >= Still::kSkyDepth ? 0.0f : value;
    return depth;
}

Image with_alpha(const Still& still)
{
    Image image = empty_image(still);
    image.channels = {"R", "G", "B", "A"};
    image.pixels = still.foreground;
    return image;
}

Image all_targets(const Still& still, const Image& beauty)
{
    Image image = empty_image(still);
    image.channels = beauty.channels;
    std::vector<Target> rest = targets_of(still);
    rest.erase(rest.begin());  // the composite stands as R, G, B
    for (const Target& target : rest) {
        if (target.channels == 1)
            image.channels.push_back(target.name + ".Z");
        else
            for (const char* c : {".R", ".G", ".B"})
                image.channels.push_back(target.name + c);
    }
    const std::size_t own = beauty.channels.size();
    const auto pixels =
        static_cast<std::size_t>(still.width) * static_cast<std::size_t>(still.height);
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t c = 0; c < own; ++c)
            image.pixels.push_back(beauty.pixels[i * own + c]);
        for (const Target& target : rest)
            for (std::size_t c = 0; c < static_cast<std::size_t>(target.channels); ++c)
                image.pixels.push_back(
                    (*target.pixels)[i * static_cast<std::size_t>(target.channels) + c]);
    }
    return image;
}

float parse_exposure(const std::string& text)
{
    float stops = 0;
    const char* end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, stops);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !(std::abs(stops) <= 60.0f))
        throw UsageError(
            fmt::format("--exposure: '{}' is neither 'auto' nor stops in -60..60", text));
    return stops;
}

/// Says which of the outputs can't be before any work is done for them.
void check_outputs(const Options& options)
{
    for (const std::string& output : options.outputs) {
        const std::string extension = fs::path(output).extension();
        if (extension != ".exr" && extension != ".png")
            throw UsageError(fmt::format("-o: '{}' ends in neither .exr (linear, all targets) nor "
                                         ".png (for a screen)",
                                         output));
    }
}

std::string preset_line(const Options& options)
{
    std::string line = "preset " + options.preset;
    for (const auto& [name, value] : options.settings)
        line += fmt::format(", {} {}", name, value);
    return line;
}

Json settings_json(const Settings& settings)
{
    Json json;
    for (const SettingInfo& info : setting_table())
        json[std::string(info.name)] = info.get(settings);
    return json;
}

void print_report(const StillReport& report, const gl::Device& gl, const Scene& scene,
                  const Options& options)
{
    fmt::print("{} x {} on {} ({}), {}\n", scene.resolution.x, scene.resolution.y,
               gl.capabilities().renderer, report.timing_method, preset_line(options));
    fmt::print("{:<26}{:>10}{:>10}{:>10}   ms over {} frames\n", "pass", "min", "median", "max",
               options.frames);
    std::vector<PassTime> rows = report.passes;
    rows.push_back(report.volume);
    rows.back().name = "all that the volume adds";
    for (const PassTime& pass : rows)
        fmt::print("{:<26}{:>10.2f}{:>10.2f}{:>10.2f}\n", pass.name, pass.min_ms, pass.median_ms,
                   pass.max_ms);
    fmt::print("{:<26}{:>20.2f}   ms, once: uploads, shadow map, volumes of light\n", "set-up",
               report.setup_ms);
    fmt::print("{:<26}{:>20.3g}   evaluations of the media a frame\n", "samples", report.samples);
    fmt::print("{:<26}{:>20.2f}   MB in textures and buffers\n", "on the GPU",
               static_cast<double>(report.gpu_bytes) * 1e-6);
}

Json report_json(const StillReport& report)
{
    Json passes = Json::array();
    const auto row = [](const PassTime& pass) {
        return Json{{"name", pass.name},
                    {"min_ms", pass.min_ms},
                    {"median_ms", pass.median_ms},
                    {"max_ms", pass.max_ms}};
    };
    for (const PassTime& pass : report.passes)
        passes.push_back(row(pass));
    return {{"timing", report.timing_method},       {"passes", passes},
            {"volume_ms", report.volume.median_ms}, {"volume", row(report.volume)},
            {"setup_ms", report.setup_ms},          {"samples", report.samples},
            {"gpu_bytes", report.gpu_bytes}};
}

void run(Options options)
{
    check_outputs(options);
    const Settings settings = parse_settings(options);
    if (options.exposure != "auto")
        parse_exposure(options.exposure);
    if (options.alpha && !options.target.empty())
        throw UsageError("--alpha goes with the composite; leave out --target");
    if (options.outputs.empty())
        options.outputs.push_back(fs::path(options.input).stem().string() + ".png");

    const asset::LoadedScene loaded =
        load_input({options.input, options.size, options.grid, options.up});
    const Scene& scene = loaded.scene;
    if (!options.save_scene.empty())
        asset::save_scene(scene, options.save_scene);
    if (!options.json) {
        for (const std::string& note : loaded.notes)
            fmt::print("{}\n", note);
        if (!is_scene_file(options.input))
            fmt::print("the scene that was chosen (--save-scene FILE keeps it):\n{}\n",
                       asset::scene_to_json(scene, fs::current_path()));
    }

    const auto context =
        gl::HeadlessContext::make(options.backend == "egl" ? gl::HeadlessContext::Backend::egl
                                                           : gl::HeadlessContext::Backend::osmesa);
    SceneRenderer renderer(context->get_proc());
    StillOptions still_options{.aa = options.aa,
                               .timed_frames = options.frames,
                               .seed = options.seed,
                               .foreground = options.alpha,
                               .progress = {}};
    if (isatty(STDERR_FILENO) != 0)
        still_options.progress = [](int done, int all) {
            if (all > 1 && done < all)
                fmt::print(stderr, "\rframe {} of {} ", done + 1, all);
            else if (all > 1)
                fmt::print(stderr, "\r{:24}\r", "");
        };
    StillReport report;
    const Still still = renderer.render(scene, settings, still_options, &report);

    Image beauty = single_target(still, {"composite", &still.composite, 3});
    if (options.alpha)
        beauty = with_alpha(still);
    Image picture = beauty;
    for (const Target& target : targets_of(still))
        if (target.name == options.target)
            picture = single_target(still, target);
    Display display;
    display.transform =
        options.display == "srgb" ? Display::Transform::srgb : Display::Transform::filmic;
    display.exposure_ev = options.exposure == "auto" ? write::auto_exposure(picture)
                                                     : parse_exposure(options.exposure);
    if (options.target == "transmittance" && options.exposure == "auto")
        display.exposure_ev = 0;  // it has a white of its own
    if (options.target == "depth" && options.exposure == "auto")
        display.exposure_ev = write::auto_exposure(without_sky(picture));
    for (const std::string& output : options.outputs) {
        if (fs::path(output).extension() == ".png")
            write::write_png(picture, display, output);
        else
            write::write_exr(options.target.empty() ? all_targets(still, beauty) : picture, output);
    }

    const std::vector<std::string> explained = renderer.renderer().explain(settings);
    if (options.json) {
        Json json{{"input", options.input},
                  {"outputs", options.outputs},
                  {"size", {scene.resolution.x, scene.resolution.y}},
                  {"aa", options.aa},
                  {"frames", options.frames},
                  {"seed", options.seed},
                  {"mode", mode_name(settings.mode)},
                  {"preset", options.preset},
                  {"settings", settings_json(settings)},
                  {"exposure_ev", display.exposure_ev},
                  {"device", renderer.renderer().device().capabilities().renderer},
                  {"notes", loaded.notes},
                  {"explain", explained}};
        json.update(report_json(report));
        fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
        return;
    }
    if (options.explain) {
        fmt::print("what this scene needs:\n");
        for (const std::string& line : explained)
            fmt::print("  {}\n", line);
    }
    print_report(report, renderer.renderer().device(), scene, options);
    for (const std::string& output : options.outputs)
        fmt::print("wrote {}{}\n", output,
                   fs::path(output).extension() == ".png"
                       ? fmt::format(" (exposure {:+.2f} stops)", display.exposure_ev)
                       : "");
}

}  // namespace

void add_render(CLI::App& app)
{
    CLI::App* command =
        app.add_subcommand("render", "A picture of a .vdb file or of a scene, with what it cost");
    auto options = std::make_shared<Options>();
    Options& o = *options;
    command->add_option("INPUT", o.input, "a .vdb file, or a scene file (.json)")->required();
    command
        ->add_option("-o,--output", o.outputs,
                     "x.exr: linear, all targets; x.png: for a screen; may be repeated "
                     "[INPUT's name.png]")
        ->allow_extra_args(false);
    command->add_option("--size", o.size, "WIDTHxHEIGHT in pixels [480x270, or the scene's]");
    command->add_option("--grid", o.grid, "of a .vdb: name or name[n] [the first fog volume]");
    command->add_option("--up", o.up, "of a .vdb [auto]")->check(CLI::IsMember({"auto", "y", "z"}));
    command->add_option("--aa", o.aa, "frames averaged over the pixel's square [1]")
        ->check(CLI::Range(1, 65536));
    command->add_option("--frames", o.frames, "frames timed; the table gives their median [1]")
        ->check(CLI::Range(1, 100000));
    command->add_option("--seed", o.seed, "another seed, other jitter [0]");
    command->add_option("--target", o.target, "write one target alone as RGB")
        ->check(CLI::IsMember(
            {"composite", "scattering", "transmittance", "surface", "surface_lit", "depth"}));
    command->add_flag("--alpha", o.alpha, "leave out the sky; its transmittance becomes alpha");
    command->add_option("--exposure", o.exposure, "stops for a .png [auto]");
    command->add_option("--display", o.display, "transform for a .png [filmic]")
        ->check(CLI::IsMember({"filmic", "srgb"}));
    command->add_option("--save-scene", o.save_scene, "write the scene that is rendered");
    command->add_flag("--explain", o.explain, "which variant was chosen for the scene, and why");
    command->add_flag("--json", o.json, "print JSON");
    command->add_option("--backend", o.backend, "OpenGL without a window [osmesa]")
        ->check(CLI::IsMember({"osmesa", "egl"}));
    command->add_option("--mode", o.mode, "[the preset's]")
        ->check(CLI::IsMember({"raymarch", "froxel"}));
    command->add_option("--preset", o.preset,
                        "default, eevee2017, froxel or eevee2017-froxel [default]");
    for (const SettingInfo& info : setting_table()) {
        const std::string name(info.name);
        command
            ->add_option_function<std::string>(
                "--" + name, [options, name](const std::string& v) { options->settings[name] = v; },
                fmt::format("{} ({}{}{}) [{}]", info.help, info.values,
                            info.unit.empty() ? "" : " ", info.unit, info.get(Settings{})))
            ->group("Settings: " + std::string(info.group));
    }
    command->callback([options] { run(*options); });
}

}  // namespace fumarole::command
