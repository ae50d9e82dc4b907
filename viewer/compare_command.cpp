#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bounce_count.h"
#include "command.h"
#include "compare_modes.h"
#include "input_options.h"
#include "picture_distance.h"
#include "picture_files.h"
#include "study/false_color.h"
#include "study/flip.h"
#include <fumarole/errors.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kComposite = "composite";

struct CompareOptions {
    std::string test, reference, output, target, exposure = "auto", difference = "magnitude";
    std::optional<double> max_relmse, scale;
    bool json = false;
    ModesOptions modes;  ///< where a scene is given instead of two pictures
};

/// Words of the one use of the command are mistakes in the other.
constexpr std::array kOfPictures{"B.exr", "--target", "--max-relmse", "--difference", "--scale"};
constexpr std::array kOfScenes{"--modes",        "--size",    "--grid",
                               "--up",           "--aa",      "--frames",
                               "--tolerance",    "--bounces", "--surface-bounces",
                               "--no-reference", "--backend", "--device"};

template <class Names> void refuse(const CLI::App& command, const Names& names, const char* why)
{
    for (const char* name : names)
        if (command.get_option(name)->count() > 0)
            throw UsageError(fmt::format("{}: {}", name, why));
}

using Channels = std::array<std::string, 3>;

/// The channels of a target in an EXR of many; the composite stands as R, G, B.
Channels channels_of(const std::string& target)
{
    const std::string prefix = target == kComposite ? "" : target + ".";
    return {prefix + "R", prefix + "G", prefix + "B"};
}

bool has(const std::vector<std::string>& names, const std::string& target)
{
    const Channels channels = channels_of(target);
    return std::all_of(channels.begin(), channels.end(), [&](const std::string& channel) {
        return std::find(names.begin(), names.end(), channel) != names.end();
    });
}

/// All that have R, G and B: a depth or an alpha is no picture that one can look at.
std::vector<std::string> targets_in(const std::vector<std::string>& names)
{
    std::vector<std::string> targets;
    if (has(names, kComposite))
        targets.emplace_back(kComposite);
    for (const std::string& name : names) {
        const std::size_t dot = name.rfind('.');
        if (dot == std::string::npos || name.substr(dot) != ".R")
            continue;
        if (has(names, name.substr(0, dot)))
            targets.push_back(name.substr(0, dot));
    }
    return targets;
}

std::string joined(const std::vector<std::string>& names)
{
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// One of the two files.
struct Input {
    fs::path file;
    std::vector<std::string> channels, targets;

    explicit Input(const std::string& name)
        : file(name), channels(write::exr_channels(file)), targets(targets_in(channels))
    {
    }

    /// R, G, B of a target. A file of one target alone, as `render --target` writes it, holds it as
    /// R, G, B and does not say which one it is: there the user's word is taken.
    [[nodiscard]] Image read(const std::string& target) const
    {
        Channels names = channels_of(target);
        if (!has(channels, target)) {
            if (targets != std::vector<std::string>{kComposite})
                throw Error(fmt::format("{}: no target '{}' (has: {})", file.string(), target,
                                        joined(targets)));
            names = channels_of(kComposite);
        }
        Image image = write::read_exr(file, {names.begin(), names.end()});
        image.channels = {"R", "G", "B"};
        return image;
    }
};

/// Where the first value that is no number stands, or nothing.
std::string broken_place(const Image& image)
{
    const auto broken = std::find_if(image.pixels.begin(), image.pixels.end(),
                                     [](float value) { return !std::isfinite(value); });
    if (broken == image.pixels.end())
        return "";
    const auto at = static_cast<std::size_t>(broken - image.pixels.begin());
    const auto width = static_cast<std::size_t>(image.width);
    return fmt::format("{} of pixel {}, {} is {}", image.channels[at % 3], at / 3 % width,
                       at / 3 / width, *broken);
}

/// What was found of one target.
struct Row : PictureDistance {
    std::string target, broken;
};

Row measure(const std::string& target, const Image& test, const Image& reference,
            const CompareOptions& options, std::optional<float> exposure)
{
    Row row{picture_distance(target, test, reference, exposure), target, ""};
    if (!row.metrics.finite)
        row.broken = fmt::format("{}: {}: {}", options.test, target, broken_place(test));
    return row;
}

void write_difference(const Row& row, const Image& test, const Image& reference,
                      const CompareOptions& options)
{
    study::FalseColor style;
    style.difference =
        options.difference == "sign" ? study::Difference::sign : study::Difference::magnitude;
    const std::vector<float> map =
        study::difference_map(test.pixels, reference.pixels, 3, style.difference);
    style.scale = options.scale.value_or(study::difference_scale(map));
    style.caption =
        fmt::format("{} {}", row.target,
                    options.difference == "sign" ? "signed relative error" : "relative error");
    write::write_png(study::false_color(map, test.width, test.height, style),
                     {.exposure_ev = 0, .transform = Display::Transform::srgb}, options.output);
}

std::string shown_at(const Display& display)
{
    return fmt::format("{} {:+.2f}",
                       display.transform == Display::Transform::srgb ? "srgb" : "filmic",
                       display.exposure_ev);
}

void print(const std::vector<Row>& rows, const CompareOptions& options, const Image& size)
{
    fmt::print("{} against {}, {} x {}\n", options.test, options.reference, size.width,
               size.height);
    fmt::print("{:<16}{:>11}{:>11}{:>11}{:>11}{:>11}   {}\n", "target", "relMSE", "SMAPE", "bias",
               "p99.9", "FLIP", "FLIP shown at, stops");
    for (const Row& row : rows)
        fmt::print("{:<16}{:>11.3e}{:>11.3e}{:>+11.3e}{:>11.3e}{:>11.3e}   {}\n", row.target,
                   row.metrics.relmse, row.metrics.smape, row.metrics.bias, row.metrics.p999,
                   row.flip, shown_at(row.display));
    if (!options.output.empty())
        fmt::print("wrote {}\n", options.output);
}

Json to_json(const std::vector<Row>& rows, const CompareOptions& options, const Image& size,
             bool ok)
{
    Json targets = Json::object();
    for (const Row& row : rows) {
        targets[row.target] = {{"finite", row.metrics.finite},
                               {"relmse", row.metrics.relmse},
                               {"smape", row.metrics.smape},
                               {"bias", row.metrics.bias},
                               {"p999", row.metrics.p999},
                               {"flip", row.flip},
                               {"exposure_ev", row.display.exposure_ev}};
    }
    Json json{{"test", options.test},
              {"reference", options.reference},
              {"size", {size.width, size.height}},
              {"pixels_per_degree", study::kFlipPixelsPerDegree},
              {"targets", targets},
              {"ok", ok}};
    json["max_relmse"] = options.max_relmse ? Json(*options.max_relmse) : Json();
    json["output"] = options.output.empty() ? Json() : Json(options.output);
    return json;
}

/// Why the test picture is not good enough; empty if it is.
std::vector<std::string> faults_of(const std::vector<Row>& rows, const CompareOptions& options)
{
    std::vector<std::string> faults;
    for (const Row& row : rows) {
        if (!row.metrics.finite)
            faults.push_back(row.broken);
        else if (options.max_relmse && row.metrics.relmse > *options.max_relmse)
            faults.push_back(fmt::format("{}: relMSE {:.4g} is over --max-relmse {:.4g}",
                                         row.target, row.metrics.relmse, *options.max_relmse));
    }
    return faults;
}

/// That part of a whole picture which another picture is.
Image part_like(const Image& whole, const Image& part)
{
    Image cut = part;
    const std::size_t channels = whole.channels.size();
    const auto row = static_cast<std::size_t>(part.width) * channels;
    for (int y = 0; y < part.height; ++y) {
        const auto from = static_cast<std::ptrdiff_t>(
            (static_cast<std::size_t>(y + part.origin.y) * static_cast<std::size_t>(whole.width) +
             static_cast<std::size_t>(part.origin.x)) *
            channels);
        std::copy_n(whole.pixels.begin() + from, row,
                    cut.pixels.begin() + static_cast<std::ptrdiff_t>(row) * y);
    }
    return cut;
}

/// A part is compared with the same part of a whole picture.
void match_parts(Image& test, Image& reference)
{
    const auto is_whole_of = [](const Image& whole, const Image& part) {
        return whole.whole == glm::ivec2(0) && part.whole == glm::ivec2(whole.width, whole.height);
    };
    if (is_whole_of(test, reference))
        test = part_like(test, reference);
    else if (is_whole_of(reference, test))
        reference = part_like(reference, test);
}

void check_sizes(const CompareOptions& options, const Image& test, const Image& reference)
{
    if (test.width != reference.width || test.height != reference.height)
        throw Error(fmt::format("{} is {} x {} but {} is {} x {}; render both at one --size",
                                options.test, test.width, test.height, options.reference,
                                reference.width, reference.height));
    if (test.whole != reference.whole || test.origin != reference.origin)
        throw Error(fmt::format("{} and {} are different parts of a picture; render both with one "
                                "--region",
                                options.test, options.reference));
}

std::vector<std::string> common_targets(const Input& test, const Input& reference)
{
    std::vector<std::string> common;
    for (const std::string& target : test.targets)
        if (has(reference.channels, target))
            common.push_back(target);
    if (common.empty())
        throw Error(fmt::format("{} and {} have no target in common (they have: {}; {})",
                                test.file.string(), reference.file.string(), joined(test.targets),
                                joined(reference.targets)));
    return common;
}

void run(const CompareOptions& options)
{
    if (!options.output.empty())
        check_png("-o", options.output);
    // A NaN passes CLI11's ranges, and nothing is above it.
    for (const std::optional<double>& number : {options.max_relmse, options.scale})
        if (number && !std::isfinite(*number))
            throw UsageError("--max-relmse and --scale take finite numbers");
    const std::optional<float> exposure = parse_exposure(options.exposure);
    const Input test(options.test);
    const Input reference(options.reference);
    const std::vector<std::string> targets = options.target.empty()
                                                 ? common_targets(test, reference)
                                                 : std::vector<std::string>{options.target};
    const std::string drawn = options.target.empty() ? kComposite : options.target;
    if (!options.output.empty() &&
        std::find(targets.begin(), targets.end(), drawn) == targets.end())
        throw Error(fmt::format("-o: no composite in both files; choose one of {} with --target",
                                joined(targets)));

    std::vector<Row> rows;
    Image size;
    for (const std::string& target : targets) {
        Image test_picture = test.read(target);
        Image reference_picture = reference.read(target);
        match_parts(test_picture, reference_picture);
        check_sizes(options, test_picture, reference_picture);
        if (const std::string place = broken_place(reference_picture); !place.empty())
            throw Error(fmt::format("{}: {}: {}; nothing can be measured against it, make the "
                                    "reference again",
                                    options.reference, target, place));
        rows.push_back(measure(target, test_picture, reference_picture, options, exposure));
        if (target == drawn && !options.output.empty())
            write_difference(rows.back(), test_picture, reference_picture, options);
        size.width = test_picture.width;
        size.height = test_picture.height;
    }

    const std::vector<std::string> faults = faults_of(rows, options);
    if (options.json)
        fmt::print("{}\n", to_json(rows, options, size, faults.empty())
                               .dump(1, ' ', false, Json::error_handler_t::replace));
    else
        print(rows, options, size);
    if (!faults.empty())
        throw Error(fmt::format("{}", fmt::join(faults, "; ")));
}

bool is_scene(const std::string& input)
{
    return is_scene_file(input) || has_extension(input, ".vdb") || has_extension(input, ".nvdb");
}

void run_either(CompareOptions& options, const CLI::App& command)
{
    if (!is_scene(options.test)) {
        refuse(command, kOfScenes, "is for a scene, rendered in several modes");
        if (options.reference.empty())
            throw UsageError("B.exr is required: a picture is compared with another one, and a "
                             "scene file or a .vdb by its --modes");
        run(options);
        return;
    }
    refuse(command, kOfPictures, "is for two pictures; a scene is compared by its --modes");
    ModesOptions& modes = options.modes;
    modes.scene.file = options.test;
    modes.output = options.output;
    modes.exposure = options.exposure;
    modes.json = options.json;
    if (!modes.output.empty())
        check_png("-o", modes.output);
    compare_modes(modes);
}

}  // namespace

void add_compare(CLI::App& app)
{
    CLI::App* command = app.add_subcommand(
        "compare", "How far a linear picture is from a reference, or a scene's modes from it and "
                   "from each other: relMSE, bias, FLIP, time");
    auto options = std::make_shared<CompareOptions>();
    CompareOptions& o = *options;
    command
        ->add_option(
            "A.exr", o.test,
            "the picture to judge; or a scene file (.json), a .vdb or a .nvdb, to be rendered")
        ->required();
    command->add_option("B.exr", o.reference, "the reference, of a picture");
    command
        ->add_option("-o,--output", o.output,
                     "a picture of where and how much they differ, in colours with their scale; of "
                     "a scene, its pictures too, and its reference is kept beside")
        ->type_name("FILE.png");
    command
        ->add_option("--target", o.target,
                     "compare this one alone: composite, scattering, transmittance, ...; a file of "
                     "R, G, B alone is taken to hold it [all that both have; -o composite]")
        ->type_name("TARGET");
    command
        ->add_option("--max-relmse", o.max_relmse,
                     "exit with 1 if a compared target's relMSE is above")
        ->type_name("NUMBER")
        ->check(within(0, 1e30));
    command
        ->add_option("--exposure", o.exposure,
                     "at which FLIP sees both; auto: the reference's [auto]")
        ->type_name("auto|STOPS");
    command
        ->add_option("--difference", o.difference,
                     "of -o: how much they differ, or also whether too dark or too bright "
                     "[magnitude]")
        ->check(CLI::IsMember({"magnitude", "sign"}));
    command
        ->add_option("--scale", o.scale,
                     "of -o: relative error at the end of the scale, to compare pictures [auto]")
        ->type_name("NUMBER")
        ->check(within(1e-30, 1e30));
    command->add_flag("--json", o.json, "print JSON");
    const std::string scenes = "Of a scene";
    ModesOptions& m = o.modes;
    command
        ->add_option("--modes", m.modes,
                     "modes and presets, with commas between; the reference comes too "
                     "[raymarch,froxel]")
        ->type_name("NAME,...")
        ->group(scenes);
    add_size_option(*command, m.scene.size, scenes);
    add_grid_options(*command, m.scene.grid, m.scene.up, scenes);
    command->add_option("--aa", m.aa, "frames averaged over the pixel's square [1]")
        ->type_name("N")
        ->check(within(1, 65536))
        ->group(scenes);
    command
        ->add_option("--frames", m.frames,
                     "frames timed; froxels gather over them, where none are averaged [16]")
        ->type_name("N")
        ->check(within(1, 100000))
        ->group(scenes);
    command
        ->add_option("--tolerance", m.tolerance,
                     "of the reference: relative error of each pixel [0.2, with no bounces 0.01]")
        ->type_name("ERROR")
        ->check(within(1e-6, 0.5))
        ->group(scenes);
    command
        ->add_option("--bounces", m.bounces,
                     "of the reference: all, or 0, with which light scatters once in the modes too "
                     "[all]")
        ->check(CLI::IsMember({"0", "all"}))
        ->group(scenes);
    command->add_option("--surface-bounces", m.surface_bounces, kSurfaceBouncesHelp)
        ->type_name(kSurfaceBouncesValue)
        ->group(scenes);
    command
        ->add_flag("--no-reference", m.no_reference,
                   "compare the modes with each other alone; the reference may take minutes")
        ->group(scenes);
    add_device_options(*command, m.device, scenes);
    command->footer("Exit code: 0 compared, 1 over --max-relmse, not finite or not comparable, "
                    "2 wrong command line.");
    command->callback([options, command] { run_either(*options, *command); });
}

}  // namespace fumarole::command
