#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <fmt/format.h>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <thread>

#include "bounce_count.h"
#include "command.h"
#include "device_options.h"
#include "frame_claim.h"
#include "gl/device.h"
#include "input_options.h"
#include "inspection_options.h"
#include "interruption.h"
#include "kept_programs.h"
#include "library_log.h"
#include "picture_files.h"
#include "pictures/ahead.h"
#include "planning.h"
#include "progress.h"
#include "scene_input.h"
#include "settings_input.h"
#include "study/deep_still.h"
#include "study/grain.h"
#include "study/reference.h"
#include "study/reference_state.h"
#include "write/whole_picture.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/frame_loader.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>
#include <fumarole/scene_renderer.h>
#include <fumarole/settings.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RenderOptions {
    std::string input;
    std::vector<std::string> outputs;
    std::string size, grid, up = "auto", exposure = "auto", display = "filmic", target, save_scene,
                            mode, region, bounces, surface_bounces = "auto";
    std::string frames = "1", missing_frames = "fail";
    std::string aa_text = "auto";
    int aa = 1;                ///< frames averaged, or the most of them:
    bool until_clear = false;  ///< no more than the grain of the picture asks for
    std::uint32_t seed = 0;
    std::optional<double> tolerance;   ///< tolerance of the reference
    std::optional<double> time_limit;  ///< seconds that a reference may take
    bool alpha = false, half = false, explain = false, json = false, resume = false;
    std::string line;  ///< the command line itself
    DeviceOptions device;
    InspectionOptions inspection;
    SettingsInput words;
    PlanWish wish;

    std::optional<study::PlanGoal> goal;  ///< goal of a plan that is to find the settings
    int timed_frames = 1;                 ///< number of timed frames of a still
    std::optional<FrameRange> range;      ///< frames of a moving picture

    [[nodiscard]] bool reference() const { return mode == "reference"; }
};

bool is_of_transparents(const std::string& target)
{
    return target == "transparents" || target == "transparents_kept";
}

/// A word that only the other mode understands is a mistake, not a wish to be passed over.
void check_mode(const RenderOptions& options, const CLI::App& command)
{
    const auto refuse = [&](const std::string& name, const char* why) {
        if (command.get_option(name)->count() > 0)
            throw UsageError(fmt::format("{}: {}", name, why));
    };
    const bool deep = std::any_of(options.outputs.begin(), options.outputs.end(), is_deep);
    if (deep &&
        (options.reference() || !options.target.empty() || !options.inspection.show.empty()))
        throw UsageError("-o: a .deep.exr is all that OpenGL sees; not for --mode reference, "
                         "--target or --show");
    if (!options.reference()) {
        for (const char* name : {"--tolerance", "--time-limit"})
            refuse(name, "is for --mode reference");
        if (options.target == "error")
            throw UsageError("--target error: is for --mode reference, which estimates its error");
        return;
    }
    if (is_of_transparents(options.target))
        throw UsageError(
            fmt::format("--target {}: is for OpenGL; the composite of --mode reference "
                        "has the transparents",
                        options.target));
    constexpr const char* kWhy =
        "is for OpenGL; --mode reference has no such thing, it "
        "takes --tolerance, --time-limit, --region, --bounces, --surface-bounces and --aa";
    for (const char* name : {"--preset", "--seed", "--backend", "--device", "--alpha", "--explain",
                             "--max-error", "--budget"})
        refuse(name, kWhy);
    if (!options.range)
        refuse("--frames", kWhy);
    for (const SettingInfo& info : setting_table())
        if (info.name != "bounces" && info.name != "surface-bounces")  // both have them
            refuse("--" + std::string(info.name), kWhy);
}

std::optional<PictureRegion> parse_region(const std::string& text)
{
    if (text.empty())
        return std::nullopt;
    std::array<int, 4> numbers{};
    const char *at = text.data(), *end = at + text.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto parsed = std::from_chars(at, end, numbers[i]);
        at = parsed.ptr;
        const bool last = i + 1 == numbers.size();
        if (parsed.ec != std::errc{} || numbers[i] < (i < 2 ? 0 : 1) ||
            (last ? at != end : at == end || *at++ != ','))
            throw UsageError(fmt::format("--region: '{}' is no region; give X,Y,WIDTH,HEIGHT in "
                                         "pixels from the top left, e.g. 200,100,64,48",
                                         text));
    }
    return PictureRegion{numbers[0], numbers[1], numbers[2], numbers[3]};
}

/// All of them where nothing is said.
int bounces_of(const RenderOptions& options)
{
    return options.bounces.empty() ? study::kAllBounces
                                   : parse_bounces("--bounces", options.bounces);
}

int surface_bounces_of(const RenderOptions& options, const Scene& scene)
{
    return parse_surface_bounces(options.surface_bounces, scene);
}

/// Single scattering is integrated; what bounces is sampled, and a tenth of the error costs a
/// hundred times the samples.
double tolerance_of(const RenderOptions& options, int surface_bounces)
{
    return options.tolerance.value_or(bounces_of(options) == 0 && surface_bounces == 0 ? 1e-3
                                                                                       : 2e-2);
}

constexpr int kMostAutomatic = 64;  ///< frames

/// N, or `auto`: a still is averaged until its grain is gone. What is timed, planned, moving or a
/// reference is of as many frames as are asked for, one if nothing is said.
void parse_aa(RenderOptions& options, const CLI::App& command)
{
    if (options.aa_text == "auto") {
        const bool one = options.reference() || options.wish.asked() ||
                         command.get_option("--frames")->count() > 0;
        options.until_clear = !one;
        options.aa = one ? 1 : kMostAutomatic;
        return;
    }
    const char *at = options.aa_text.data(), *end = at + options.aa_text.size();
    const auto parsed = std::from_chars(at, end, options.aa);
    if (parsed.ec != std::errc{} || parsed.ptr != end || options.aa < 1 || options.aa > 65536)
        throw UsageError(fmt::format("--aa: '{}' is neither auto nor a number of frames to average "
                                     "(1..65536)",
                                     options.aa_text));
}

/// A..B, or A..BxS for every S-th frame.
std::optional<FrameRange> parse_range(std::string_view text)
{
    FrameRange range;
    const char *at = text.data(), *end = at + text.size();
    const auto number = [&](int& value) {
        const auto parsed = std::from_chars(at, end, value);
        at = parsed.ptr;
        return parsed.ec == std::errc{};
    };
    const auto word = [&](std::string_view expected) {
        if (!std::string_view(at, end).starts_with(expected))
            return false;
        at += expected.size();
        return true;
    };
    if (!number(range.first) || !word("..") || !number(range.last))
        return std::nullopt;
    if (at != end && (!word("x") || !number(range.step)))
        return std::nullopt;
    constexpr int kMost = 1'000'000'000;  // so that a frame more is a number still
    const bool fits = range.first >= -kMost && range.last <= kMost && range.first <= range.last &&
                      range.step >= 1 && range.step <= kMost;
    return at == end && fits ? std::optional(range) : std::nullopt;
}

/// N frames of a still, or frames A to B of a moving picture.
void parse_frames(RenderOptions& options)
{
    const char *at = options.frames.data(), *end = at + options.frames.size();
    int number = 0;
    const auto parsed = std::from_chars(at, end, number);
    if (parsed.ec == std::errc{} && parsed.ptr == end && number >= 1 && number <= 100000) {
        options.timed_frames = number;
        return;
    }
    options.range = parse_range(options.frames);
    if (!options.range)
        throw UsageError(
            fmt::format("--frames: '{}' is neither a number of frames to time (1..100000) nor "
                        "frames A..B of a moving picture, e.g. 1..48, or 1..48x2 for every second",
                        options.frames));
    check_no_glob(options.input);
    if (!is_scene_file(options.input) && !is_sequence(options.input))
        throw UsageError(
            fmt::format("--frames: '{}' is one file, and {} asks for a moving picture; "
                        "name a sequence, e.g. smoke_####.vdb, or a scene",
                        options.input, options.frames));
}

std::string preset_line(const RenderOptions& options)
{
    std::string line = "preset " + options.words.preset;
    for (const auto& [name, value] : options.words.changed)
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

void print_report(const StillReport& report, const std::string& device, const Scene& scene,
                  const RenderOptions& options)
{
    fmt::print("{} x {} on {} ({}), {}\n", scene.resolution.x, scene.resolution.y, device,
               report.timing_method, preset_line(options));
    fmt::print("{:<26}{:>10}{:>10}{:>10}   ms over {} frames\n", "pass", "min", "median", "max",
               options.timed_frames);
    std::vector<PassTime> rows = report.passes;
    rows.push_back(report.volume);
    rows.back().name = "all that the volume adds";
    for (const PassTime& pass : rows)
        fmt::print("{:<26}{:>10.2f}{:>10.2f}{:>10.2f}\n", pass.name, pass.min_ms, pass.median_ms,
                   pass.max_ms);
    fmt::print("{:<26}{:>20.2f}   ms, once: uploads, shadow map, volumes of light\n", "set-up",
               report.setup_ms);
    fmt::print("{:<26}{:>20.3g}   evaluations of the media a frame\n", "samples", report.samples);
    if (report.even_4 > 0)
        fmt::print("{:<26}{:>18.0f} %   of what 4 x 4 rays take as long as their longest, {:.0f} % "
                   "of 8 x 8\n",
                   "lanes at work", 100 * report.even_4, 100 * report.even_8);
    fmt::print("{:<26}{:>20.2f}   MB in textures and buffers\n", "on the GPU",
               static_cast<double>(report.gpu_bytes) * 1e-6);
    if (!report.passes_as.empty())
        fmt::print("{:<26}{}\n", "passes", report.passes_as);
    if (!report.history.empty())
        fmt::print("{:<26}{}\n", "history", report.history);
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
            {"gpu_bytes", report.gpu_bytes},        {"history", report.history},
            {"passes_as", report.passes_as},        {"lanes_at_work_4x4", report.even_4},
            {"lanes_at_work_8x8", report.even_8}};
}

/// What all modes print of a picture for machines.
/// @param frames that were averaged
Json picture_json(const RenderOptions& options, const Picture& picture, int frames,
                  float exposure_ev, const std::vector<std::string>& notes)
{
    return {{"input", options.input},
            {"outputs", options.outputs},
            {"size", {picture.width, picture.height}},
            {"aa", frames},
            {"mode", options.mode},
            {"exposure_ev", exposure_ev},
            {"notes", notes}};
}

void print_json(const Json& json)
{
    fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
}

Picture part_of(Picture picture, const std::optional<PictureRegion>& region, const Scene& scene)
{
    if (region) {
        picture.whole = glm::ivec2(scene.resolution);
        picture.origin = {region->x, region->y};
    }
    return picture;
}

PictureFiles files_of(const RenderOptions& options)
{
    return {.outputs = options.outputs,
            .target = options.target,
            .exposure = parse_exposure(options.exposure),
            .transform =
                options.display == "srgb" ? Display::Transform::srgb : Display::Transform::filmic,
            .exr = {.half = options.half,
                    .captured = capture_date(),
                    .software = "Fumarole " FUMAROLE_VERSION,
                    .command = options.line}};
}

// -------------------------------------------------------------------------------------- OpenGL

/// Has the settings planned that were not given, for a single frame, and says what was chosen.
/// @returns the line that says it
std::string plan(RenderOptions& options, Settings& settings, const Scene& scene,
                 SceneRenderer& renderer)
{
    constexpr double kSeconds = 10;
    const study::Plan plan =
        plan_settings(scene, renderer, *options.goal, options.words, kSeconds, false);
    settings = plan.chosen().tried.settings;
    options.mode = mode_name(settings.mode);
    for (const auto& [name, value] :
         study::differences(settings, find_preset(options.words.preset)))
        options.words.changed[name] = value;
    if (!options.json)
        fmt::print("{}\n", choice_text(plan));
    return choice_text(plan);
}

constexpr const char* kRaisedAlpha = "alpha is raised where media glow: light that covers nothing "
                                     "has none, and a .png shows nothing "
                                     "without (an .exr does)";

bool glows(const Scene& scene)
{
    return std::any_of(scene.media.begin(), scene.media.end(), [](const Medium& medium) {
        if (const auto* box = std::get_if<BoxMedium>(&medium))
            return box->emission != glm::vec3(0);
        const auto& grid = std::get<GridMedium>(medium);
        return glows_hot(grid) ||
               (grid.emission_per_unit != glm::vec3(0) && grid.emission && !grid.emission->empty());
    });
}

Scene without_glow(Scene scene)
{
    for (Medium& medium : scene.media) {
        if (auto* box = std::get_if<BoxMedium>(&medium)) {
            box->emission = glm::vec3(0);
            continue;
        }
        auto& grid = std::get<GridMedium>(medium);
        grid.emission_per_unit = glm::vec3(0);
        grid.blackbody_intensity = 0;
    }
    return scene;
}

/// Draws the same frames without what glows, for the alpha of a .png.
class CoverRenderer {
public:
    CoverRenderer(const RenderOptions& options, const PictureFiles& files, gl::GetProc get_proc)
        : wanted_{options.alpha && std::any_of(files.outputs.begin(), files.outputs.end(), is_png)},
          get_proc_{get_proc}
    {
    }

    /// @returns whether there is something that glows, and gives it to the picture
    bool add_to(Picture& picture, const Scene& scene, const Settings& settings,
                StillOptions options)
    {
        if (!wanted_ || !glows(scene))
            return false;
        // One of its own, or the two would take each other's history for theirs.
        if (!renderer_)
            renderer_.emplace(get_proc_, library_log(), kept_programs());
        options.timed_frames = 1;
        options.layers = false;
        options.progress = {};
        cover_ = renderer_->render(without_glow(scene), settings, options, nullptr).foreground;
        picture.cover = &cover_;
        return true;
    }

private:
    bool wanted_;
    gl::GetProc get_proc_;
    std::optional<SceneRenderer> renderer_;
    std::vector<float> cover_;
};

/// Whether more than the composite is written.
bool needs_layers(const PictureFiles& files)
{
    return !files.target.empty() ||
           !std::all_of(files.outputs.begin(), files.outputs.end(), is_png);
}

bool has_deep(const PictureFiles& files)
{
    return std::any_of(files.outputs.begin(), files.outputs.end(), is_deep);
}

/// Writes those of the files that have samples in depth.
/// @returns a line that says how many, or "" where there are none
std::string write_deep(SceneRenderer& renderer, const Scene& scene, const Settings& settings,
                       const Still& still, const StillOptions& drawn, const PictureFiles& files)
{
    if (!has_deep(files))
        return "";
    const DeepImage image =
        study::deep_still(renderer, scene, settings, still,
                          {.frames = still.frames, .seed = drawn.seed, .region = drawn.region});
    for (const std::string& output : files.outputs)
        if (is_deep(output))
            write::write_deep_exr(image, output, files.exr);
    return fmt::format("deep: {:.1f} samples a pixel",
                       static_cast<double>(image.samples.size()) / (image.width * image.height));
}

/// The grain of a still while its frames are averaged, in steps of the files' formats.
class Grain {
public:
    explicit Grain(const PictureFiles& files) : files_{files} {}

    [[nodiscard]] bool is_gone(const Halves& halves)
    {
        const int width = halves.width;
        Image mean{.width = width, .channels = {"R", "G", "B"}, .pixels = halves.first};
        mean.height = static_cast<int>(mean.pixels.size() / 3) / width;
        for (std::size_t i = 0; i < mean.pixels.size(); ++i)
            mean.pixels[i] = 0.5f * (mean.pixels[i] + halves.second[i]);
        const auto in = [&](const study::InSteps& steps) {
            return study::grain(halves.first, halves.second, width, steps);
        };
        left_ = 0;
        if (std::any_of(files_.outputs.begin(), files_.outputs.end(), is_png)) {
            const Display display{exposure_of("composite", mean, files_.exposure),
                                  files_.transform};
            left_ =
                in([&](glm::vec3 rgb) { return 255.0f * write::display_transform(rgb, display); });
        }
        if (!std::all_of(files_.outputs.begin(), files_.outputs.end(), is_png))
            left_ = std::max(*left_, in(study::relative_steps(mean.pixels)));
        return *left_ < 1;
    }

    /// At the last measurement, or nothing if there was none.
    [[nodiscard]] std::optional<double> left() const { return left_; }

    [[nodiscard]] std::string line(int frames) const
    {
        return fmt::format("{} frames averaged; grain left: {:.2g} of a step (.png: 1/255, .exr: "
                           "1 %){}",
                           frames, left_.value_or(0),
                           left_.value_or(0) < 1 ? "" : "; --aa N takes more");
    }

private:
    const PictureFiles& files_;
    std::optional<double> left_;
};

void run_still(RenderOptions options, const PictureFiles& files, Settings settings,
               const std::optional<PictureRegion>& region, const asset::LoadedScene& loaded)
{
    const Scene& scene = loaded.scene;
    const auto context = make_context(options.device);
    SceneRenderer renderer(context->get_proc(), library_log(), kept_programs());
    const gl::Device& device = renderer.renderer().device();
    std::string planned;
    if (options.goal) {
        const Interruption interruption;
        planned = plan(options, settings, scene, renderer);
    }
    Progress progress;
    StillOptions still_options;
    still_options.aa = options.aa;
    Grain grain(files);
    if (options.until_clear)
        still_options.enough = [&](const Halves& halves) { return grain.is_gone(halves); };
    still_options.region = region;
    still_options.layers = needs_layers(files);
    still_options.timed_frames = options.timed_frames;
    still_options.seed = options.seed;
    still_options.foreground = options.alpha;
    if (options.aa > 1 || options.timed_frames > 1)
        still_options.progress = [&](int done, int all) {
            progress.show("frames", static_cast<double>(done) / all);
        };
    StillReport report;
    const Still still = renderer.render(scene, settings, still_options, &report);
    still_options.aa = still.frames;  // of what goes with it, too
    still_options.enough = {};
    Picture picture = part_of(picture_of(still), region, scene);
    CoverRenderer cover(options, files, context->get_proc());
    const bool raised = cover.add_to(picture, scene, settings, still_options);
    progress.clear();
    const float exposure_ev = write_picture(picture, files);
    const std::string deep = write_deep(renderer, scene, settings, still, still_options, files);

    const std::vector<std::string> explained =
        renderer.renderer().explain(renderer.settled(scene, settings, still_options));
    if (options.json) {
        std::vector<std::string> notes = loaded.notes;
        if (raised)
            notes.emplace_back(kRaisedAlpha);
        Json json = picture_json(options, picture, still.frames, exposure_ev, notes);
        json["grain"] = grain.left() ? Json(*grain.left()) : Json();
        json.update({{"frames", options.timed_frames},
                     {"seed", options.seed},
                     {"preset", options.words.preset},
                     {"settings", settings_json(settings)},
                     {"explain", explained}});
        json.update(chosen_json(*context, device));
        if (options.goal)
            json["plan"] = planned;
        json.update(report_json(report));
        print_json(json);
        return;
    }
    if (options.explain) {
        fmt::print("what this scene needs:\n");
        for (const std::string& line : explained)
            fmt::print("  {}\n", line);
        fmt::print("  {}\n", kept_programs_text());
    }
    print_report(report, chosen_text(*context, device), scene, options);
    if (options.until_clear)
        fmt::print("{}\n", grain.line(still.frames));
    if (raised)
        fmt::print("{}\n", kRaisedAlpha);
    if (!deep.empty())
        fmt::print("{}\n", deep);
    print_written(files.outputs, exposure_ev);
}

// ---------------------------------------------------------------------------------- inspection

/// @returns the stops of a .png of radiance, which is exposed as a composite is; all else has
/// colours for a screen as it is
std::optional<float> write_inspection(const InspectionStill& still, const Inspection& inspection,
                                      const PictureFiles& files)
{
    std::optional<float> exposure_ev;
    Display display{.exposure_ev = 0, .transform = Display::Transform::srgb};
    if (inspection.kind == Inspection::Kind::scattering ||
        inspection.kind == Inspection::Kind::probe) {
        exposure_ev = exposure_of("scattering", image_of(still, false), files.exposure);
        display = {*exposure_ev, files.transform};
    }
    for (const std::string& output : files.outputs) {
        if (is_png(output))
            write::write_png(image_of(still, true), display, output);
        else
            write::write_exr(image_of(still, false), output, files.exr);
    }
    return exposure_ev;
}

void run_inspection(const RenderOptions& options, const PictureFiles& files,
                    const Settings& settings, const Inspection& inspection,
                    const asset::LoadedScene& loaded)
{
    const auto context = make_context(options.device);
    SceneRenderer renderer(context->get_proc(), library_log(), kept_programs());
    const InspectionStill still =
        renderer.inspect(loaded.scene, settings, inspection, options.seed);
    const std::optional<float> exposure_ev = write_inspection(still, inspection, files);
    const InspectionLegend& legend = still.legend;
    if (options.json) {
        Json json{{"input", options.input},
                  {"outputs", options.outputs},
                  {"size", {still.width, still.height}},
                  {"mode", options.mode},
                  {"show", options.inspection.show},
                  {"legend",
                   {{"low", legend.low},
                    {"high", legend.high},
                    {"unit", legend.unit},
                    {"caption", legend.caption},
                    {"false_color", legend.false_color}}},
                  {"exposure_ev", exposure_ev ? Json(*exposure_ev) : Json()},
                  {"notes", loaded.notes},
                  {"seed", options.seed},
                  {"preset", options.words.preset},
                  {"settings", settings_json(settings)}};
        json.update(chosen_json(*context, renderer.renderer().device()));
        print_json(json);
        return;
    }
    fmt::print("{}\n", legend_line(inspection, legend));
    print_written(files.outputs, exposure_ev);
}

// ----------------------------------------------------------------------------------- reference

/// What the reference says of its own error.
struct ErrorSummary {
    double mean = 0, worst = 0;  ///< absolute, of the composite's worst channel
    double above = 0;            ///< share of pixels whose estimate is above the tolerance, 0..1
};

/// The tolerance is relative to a pixel, or where it is dark to what relative MSE counts.
ErrorSummary summarize(const study::ReferenceStill& still, double tolerance)
{
    std::vector<double> values;
    for (std::size_t i = 0; i < still.composite.size(); i += 3)
        values.push_back(
            std::max({still.composite[i], still.composite[i + 1], still.composite[i + 2]}));
    const double pixels = static_cast<double>(values.size());
    const double square = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
    const double dark = std::sqrt(0.1 * square / pixels);
    ErrorSummary summary;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double error = still.error[i];
        summary.mean += error / pixels;
        summary.worst = std::max(summary.worst, error);
        if (error > tolerance * std::max(values[i], dark))
            summary.above += 1 / pixels;
    }
    return summary;
}

/// The file beside a picture in which its reference is while it is not whole.
fs::path state_file(const PictureFiles& files)
{
    return study::reference_state_file(files.outputs.front());
}

/// Goes on from what an earlier run left beside `files`; that goes once the picture is written.
study::ResumedReference render_reference(const RenderOptions& options, const PictureFiles& files,
                                         const std::optional<PictureRegion>& region,
                                         const Scene& scene, Progress& progress)
{
    study::ReferenceOptions wanted;
    wanted.bounces = bounces_of(options);
    wanted.surface_bounces = surface_bounces_of(options, scene);
    wanted.tolerance = tolerance_of(options, wanted.surface_bounces);
    wanted.aa = options.aa;
    wanted.region = region;
    wanted.progress = [&](double share) { progress.show("reference", share); };
    wanted.cancel = Interruption::flag();
    return study::resume_reference(scene, wanted,
                                   {state_file(files),
                                    study::reference_facts(scene, wanted, FUMAROLE_VERSION),
                                    print_over_progress});
}

void remove_state(const PictureFiles& files)
{
    std::error_code ignored;
    fs::remove(state_file(files), ignored);
}

/// No OpenGL here: the reference runs on the processor.
void run_reference(const RenderOptions& options, const PictureFiles& files,
                   const std::optional<PictureRegion>& region, const asset::LoadedScene& loaded)
{
    Progress progress;
    progress.show("reference: preparing");
    const auto begin = std::chrono::steady_clock::now();
    const study::ResumedReference resumed =
        render_reference(options, files, region, loaded.scene, progress);
    const study::ReferenceStill& still = resumed.still;
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    progress.clear();
    const Picture picture = part_of(picture_of(still), region, loaded.scene);
    const float exposure_ev = write_picture(picture, files);
    remove_state(files);

    const int bounces = bounces_of(options);
    const int surface_bounces = surface_bounces_of(options, loaded.scene);
    const double tolerance = tolerance_of(options, surface_bounces);
    const ErrorSummary error = summarize(still, tolerance);
    if (options.json) {
        Json json = picture_json(options, picture, options.aa, exposure_ev, loaded.notes);
        json["region"] =
            region ? Json{region->x, region->y, region->width, region->height} : Json();
        json.update(
            {{"tolerance", tolerance},
             {"bounces", bounces_json(bounces)},
             {"surface_bounces", bounces_json(surface_bounces)},
             {"seconds", seconds},
             {"resumed", resumed.resumed},
             {"error",
              {{"worst", error.worst}, {"mean", error.mean}, {"above_tolerance", error.above}}}});
        print_json(json);
        return;
    }
    fmt::print("{} x {}, reference with {} bounces{} to {:g} of a pixel, {:.2f} s\n", still.width,
               still.height, bounces_text(bounces),
               surface_bounces == 0
                   ? ""
                   : fmt::format(" and {} of surfaces", bounces_text(surface_bounces)),
               tolerance, seconds);
    fmt::print("estimated error   mean {:.2e}, worst {:.2e} W/m^2/sr; above the tolerance in "
               "{:.2f} % of the pixels\n",
               error.mean, error.worst, 100 * error.above);
    print_written(files.outputs, exposure_ev);
}

// ------------------------------------------------------------------------------- moving pictures

/// A file of a frame. Its name has a place for a number: check_moving_outputs saw to that.
PictureFiles files_at(const PictureFiles& files, int frame)
{
    PictureFiles of_frame = files;
    for (std::string& output : of_frame.outputs)
        output = numbered_file(output, frame).string();
    return of_frame;
}

void check_moving_outputs(const RenderOptions& options)
{
    for (const std::string& output : options.outputs)
        if (!has_frame_number(output))
            throw UsageError(fmt::format("-o: '{}' has no # for the frames' numbers; give e.g. "
                                         "{}.####{}",
                                         output, fs::path(output).stem().string(),
                                         fs::path(output).extension().string()));
}

/// Frames that several processes draw are each to be the same whoever draws them.
void check_resume(const RenderOptions& options, const Settings& settings)
{
    if (!options.resume)
        return;
    const auto refuse = [](const char* why) { throw UsageError(fmt::format("--resume: {}", why)); };
    if (!options.range)
        refuse("is for a moving picture; give --frames A..B");
    if (options.missing_frames == "hold")
        refuse("a frame held from the one before is not known alone; give --missing-frames skip");
    if (options.wish.asked())
        refuse("each process would plan for itself; give the settings that a plan finds");
    if (!options.reference() && options.aa == 1 && settings.keeps_history())
        refuse("these frames build on those before them; give --aa N, or --history 0 and "
               "--temporal off");
    if (parse_exposure(options.exposure) == std::nullopt &&
        std::any_of(options.outputs.begin(), options.outputs.end(), is_png))
        refuse("each process would choose the exposure of its .png; give --exposure STOPS");
}

asset::MissingFrames missing_frames(const RenderOptions& options)
{
    return options.missing_frames == "hold"   ? asset::MissingFrames::hold
           : options.missing_frames == "skip" ? asset::MissingFrames::skip
                                              : asset::MissingFrames::fail;
}

/// What a frame's picture points into, while it is written.
struct DrawnFrame {
    Still still = {};
    study::ReferenceStill reference = {};
    Picture picture = {};
};

/// Frames are loaded ahead, drawn in order with their history, and written one by one, each while
/// the next is drawn. All have the exposure of the first, or brightness would hunt.
void run_moving(RenderOptions options, PictureFiles files, Settings settings,
                const std::optional<PictureRegion>& region)
{
    const FrameRange range = *options.range;
    const asset::LoadedScene opened =
        open_moving({options.input, options.size, options.grid, options.up});
    if (!options.save_scene.empty())
        asset::save_scene(opened.scene, options.save_scene);
    std::unique_ptr<gl::HeadlessContext> context;
    std::optional<SceneRenderer> renderer;
    std::optional<CoverRenderer> cover;
    if (!options.reference()) {
        context = make_context(options.device);
        renderer.emplace(context->get_proc(), library_log(), kept_programs());
        cover.emplace(options, files, context->get_proc());
    }
    // A frame that is resumed has the same bits by whichever process.
    const bool from_before = options.words.changed.contains("field-start")
                                 ? settings.field_from_before
                                 : !options.resume;
    Progress progress;
    std::vector<std::string> notes = opened.notes;
    std::vector<double> volume;
    Json rows = Json::array();
    std::future<void> writing;
    const auto finish_writing = [&] {
        if (writing.valid())
            writing.get();
    };
    const auto draw = [&](int i, asset::FrameLoader& frames) {
        const int frame = range.first + i * range.step;
        const std::optional<asset::LoadedScene> loaded = frames.next();
        if (!loaded) {
            notes.push_back(fmt::format("frame {} is missing or broken, and left out", frame));
            return;
        }
        const asset::LoadedScene& now = *loaded;
        for (const std::string& note : now.notes)
            if (std::find(notes.begin(), notes.end(), note) == notes.end())
                notes.push_back(note);
        const PictureFiles of_frame = files_at(files, frame);
        Json row{{"frame", frame}, {"outputs", of_frame.outputs}};
        const auto drawn = std::make_shared<DrawnFrame>();
        StillOptions wanted;
        if (options.goal && rows.empty())
            plan(options, settings, now.scene, *renderer);
        if (renderer) {
            progress.show("frames", static_cast<double>(i) / range.count());
            wanted.aa = options.aa;
            wanted.seed = options.seed;
            wanted.foreground = options.alpha;
            wanted.region = region;
            wanted.layers = needs_layers(files);
            wanted.moving_frame = static_cast<std::uint64_t>(i);
            StillReport report;
            settings.field_from_before = from_before;
            drawn->still = renderer->render(now.scene, settings, wanted, &report);
            if (!report.passes.empty())
                volume.push_back(report.volume.median_ms);
            row["volume_ms"] = report.passes.empty() ? Json() : Json(report.volume.median_ms);
            row["setup_ms"] = report.setup_ms;
            row["history"] = report.history;
        } else {
            drawn->reference =
                render_reference(options, of_frame, region, now.scene, progress).still;
        }
        drawn->picture = part_of(renderer ? picture_of(drawn->still) : picture_of(drawn->reference),
                                 region, now.scene);
        if (cover && cover->add_to(drawn->picture, now.scene, settings, wanted) &&
            std::find(notes.begin(), notes.end(), kRaisedAlpha) == notes.end())
            notes.emplace_back(kRaisedAlpha);
        finish_writing();
        // The first says what exposure all have; a cover is kept for one frame, and what a
        // reference left behind goes once it is written.
        if (!files.exposure || drawn->picture.cover != nullptr || !renderer) {
            const float exposure_ev = write_picture(drawn->picture, of_frame);
            if (!files.exposure)
                files.exposure = exposure_ev;
        } else {
            writing = std::async(std::launch::async,
                                 [drawn, of_frame] { write_picture(drawn->picture, of_frame); });
        }
        if (renderer)
            write_deep(*renderer, now.scene, settings, drawn->still, wanted, of_frame);
        else
            remove_state(of_frame);
        rows.push_back(row);
    };
    const auto check_interruption = [&](int frame) {
        if (!*Interruption::flag())
            return;
        finish_writing();
        const char* what = Interruption::timed_out() ? "the time limit is over" : "interrupted";
        throw Error(options.resume
                        ? fmt::format("{} at frame {}; --resume goes on", what, frame)
                        : fmt::format("{}; the frames before {} were written", what, frame));
    };
    int found = 0;  // frames that need not be drawn
    if (!options.resume) {
        asset::FrameLoader frames(opened, range, missing_frames(options));
        for (int i = 0; i < range.count(); ++i) {
            check_interruption(range.first + i * range.step);
            draw(i, frames);
        }
        finish_writing();
    }
    const glm::ivec2 size =
        region ? glm::ivec2(region->width, region->height) : glm::ivec2(opened.scene.resolution);
    std::vector<int> left;
    for (int i = 0; options.resume && i < range.count(); ++i)
        left.push_back(i);
    while (!left.empty()) {
        std::vector<int> claimed;  // by others, who may be killed
        for (const int i : left) {
            const int frame = range.first + i * range.step;
            check_interruption(frame);
            const std::vector<std::string> outputs = files_at(files, frame).outputs;
            const auto is_done = [&] {
                return std::all_of(outputs.begin(), outputs.end(), [&](const std::string& output) {
                    return write::is_whole(output, size);
                });
            };
            if (is_done()) {
                ++found;
                continue;
            }
            const std::optional<FrameClaim> claim = FrameClaim::take(outputs.front());
            if (!claim) {
                claimed.push_back(i);
                continue;
            }
            if (is_done()) {  // since
                ++found;
                continue;
            }
            // With nothing of the frames before it, which another process may have drawn.
            if (renderer) {
                renderer.reset();
                renderer.emplace(context->get_proc(), library_log(), kept_programs());
            }
            asset::FrameLoader alone(opened, {frame, frame, 1}, missing_frames(options));
            draw(i, alone);
            finish_writing();
        }
        left = std::move(claimed);
        if (!left.empty())
            std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    progress.clear();
    if (options.json) {
        Json json{{"input", options.input},
                  {"mode", options.mode},
                  {"preset", options.words.preset},
                  {"aa", options.aa},
                  {"exposure_ev", files.exposure.value_or(0)},
                  {"notes", notes},
                  {"found", found},
                  {"frames", rows}};
        if (renderer)
            json.update(chosen_json(*context, renderer->renderer().device()));
        print_json(json);
        return;
    }
    if (renderer)
        fmt::print("on {}, {}\n", chosen_text(*context, renderer->renderer().device()),
                   preset_line(options));
    for (const std::string& note : notes)
        fmt::print("{}\n", note);
    if (!volume.empty()) {
        std::sort(volume.begin(), volume.end());
        fmt::print("all that the volume adds: {:.2f} .. {:.2f} .. {:.2f} ms a frame (min, median, "
                   "max of {})\n",
                   volume.front(), volume[volume.size() / 2], volume.back(), volume.size());
    }
    if (options.resume)
        fmt::print("drew {} of the {} frames; {} were there and whole\n", rows.size(),
                   range.count(), found);
    fmt::print("wrote frames {} to {}\n", options.frames, fmt::join(options.outputs, ", "));
}

void check_words(const RenderOptions& options, const CLI::App& command)
{
    if (options.input.empty())
        throw UsageError("INPUT: names no file; give a .vdb, a .nvdb or a scene file");
    check_mode(options, command);
    check_device(options.device);
    if (options.alpha && !options.target.empty())
        throw UsageError("--alpha goes with the composite; leave out --target");
    if (options.half && std::all_of(options.outputs.begin(), options.outputs.end(), is_png))
        throw UsageError("--half: is for an .exr; name one by -o");
}

/// What --show is asked for, or nothing; words of a picture's that it has no use for are refused.
std::optional<Inspection> inspection_of(const RenderOptions& options, const Settings& settings,
                                        const CLI::App& command)
{
    const auto refuse = [&](std::initializer_list<const char*> names, const std::string& why) {
        for (const char* name : names)
            if (command.get_option(name)->count() > 0)
                throw UsageError(fmt::format("{}: {}", name, why));
    };
    if (options.inspection.show.empty()) {
        refuse({"--slice", "--scale"}, "is for --show");
        return std::nullopt;
    }
    if (options.reference())
        throw UsageError("--show: is for OpenGL, and not for --mode reference");
    refuse({"--target", "--alpha", "--aa", "--region", "--frames", "--explain", "--max-error",
            "--budget"},
           "--show draws one frame's insides, and has no such thing");
    if (options.inspection.show != inspection_name(Inspection::Kind::scattering) &&
        !options.inspection.show.starts_with(inspection_name(Inspection::Kind::probe)))
        refuse({"--exposure", "--display"},
               fmt::format("--show {} has colours of its own", options.inspection.show));
    return parse_inspection(options.inspection, settings);
}

asset::LoadedScene load(const RenderOptions& options)
{
    asset::LoadedScene loaded = load_input({options.input, options.size, options.grid, options.up});
    if (is_of_transparents(options.target) && loaded.scene.transparents.empty())
        throw UsageError(fmt::format("--target {}: the scene has no transparents", options.target));
    if (!options.save_scene.empty())
        asset::save_scene(loaded.scene, options.save_scene);
    if (!options.json) {
        for (const std::string& note : loaded.notes)
            fmt::print("{}\n", note);
        if (!is_scene_file(options.input))
            fmt::print("the scene that was chosen (--save-scene FILE keeps it):\n{}\n",
                       asset::scene_to_json(loaded.scene, fs::current_path()));
    }
    return loaded;
}

/// The same where what comes after it ends at once when it is told to.
asset::LoadedScene load_alone(const RenderOptions& options)
{
    const Interruption interruption;
    return load(options);
}

void run(RenderOptions options, const CLI::App& command)
{
    parse_frames(options);
    parse_aa(options, command);
    check_words(options, command);
    if (options.outputs.empty() && options.range)
        options.outputs.push_back(fs::path(options.input).stem().string() + ".####.png");
    if (options.outputs.empty())
        options.outputs.push_back(fs::path(options.input).stem().string() + ".png");
    const PictureFiles files = files_of(options);
    if (!options.reference()) {
        options.words.mode = options.mode;
    } else {
        if (const auto bounces = options.words.changed.extract("bounces"))
            options.bounces = bounces.mapped();
        if (const auto bounces = options.words.changed.extract("surface-bounces"))
            options.surface_bounces = bounces.mapped();
    }
    const Settings settings = parse_settings(options.words);
    if (options.wish.asked())
        options.goal = parse_goal(options.wish);
    if (!options.reference())
        options.mode = mode_name(settings.mode);
    const std::optional<Inspection> inspection = inspection_of(options, settings, command);
    const std::optional<PictureRegion> region = parse_region(options.region);
    bounces_of(options);  // a mistake is said before anything is loaded
    surface_bounces_of(options, {});
    check_outputs(options.outputs);
    if (options.range)
        check_moving_outputs(options);
    check_resume(options, settings);
    if (!std::all_of(options.outputs.begin(), options.outputs.end(), is_png))
        pictures::open_ahead();
    if (inspection) {
        run_inspection(options, files, settings, *inspection, load_alone(options));
        return;
    }
    if (!options.reference() && !options.range) {
        run_still(options, files, settings, region, load_alone(options));
        return;
    }
    const Interruption interruption(options.time_limit);
    try {
        if (options.range)
            run_moving(options, files, settings, region);
        else
            run_reference(options, files, region, load(options));
    } catch (const study::ReferenceCancelled& cancelled) {
        const std::string what =
            Interruption::timed_out()
                ? fmt::format("the time limit of {:g} s is over", options.time_limit.value_or(0))
                : "interrupted";
        if (options.range)
            throw Error(fmt::format("{} in the middle of a frame; the same command line{} goes on",
                                    what, options.resume ? "" : " with --resume"));
        throw Error(cancelled.kept > 0
                        ? fmt::format("{}; {} keeps {:.1f} % of the pixels, and the same command "
                                      "line goes on with it",
                                      what, state_file(files).string(), 100 * cancelled.kept)
                        : fmt::format("{}; no picture was written", what));
    }
}

}  // namespace

void add_render(CLI::App& app, const std::string& line)
{
    CLI::App* command =
        app.add_subcommand("render", "A picture of a .vdb file or of a scene, with what it cost");
    auto options = std::make_shared<RenderOptions>();
    RenderOptions& o = *options;
    o.line = line;
    command
        ->add_option("INPUT", o.input,
                     "a .vdb or .nvdb file, smoke_####.vdb, or a scene file (.json)")
        ->required();
    command
        ->add_option(
            "-o,--output", o.outputs,
            "x.exr: linear, all targets; x.deep.exr: samples in depth; x.png: for a screen; "
            "may be repeated [INPUT's name.png]")
        ->type_name("FILE")
        ->allow_extra_args(false);
    add_size_option(*command, o.size);
    add_grid_options(*command, o.grid, o.up);
    command
        ->add_option("--aa", o.aa_text,
                     "frames, or samples of the reference, averaged over the pixel's square; auto: "
                     "of a still as many as leave no grain in its format, 64 at most, of all else "
                     "1 [auto]")
        ->type_name("auto|N");
    command
        ->add_option("--frames", o.frames,
                     "N: frames timed; the table gives their median; froxels gather over them; "
                     "A..B: a moving picture, into files named by #s as x.####.png; A..BxS: every "
                     "S-th frame of it [1]")
        ->type_name("N|A..B|A..BxS");
    command
        ->add_option("--missing-frames", o.missing_frames,
                     "where a frame's file is missing or broken: fail, hold the one before it, or "
                     "skip it [fail]")
        ->check(CLI::IsMember({"fail", "hold", "skip"}));
    command->add_flag("--resume", o.resume,
                      "of --frames A..B: leave frames that are there and whole, and share the rest "
                      "with all who run the same");
    command
        ->add_option("--seed", o.seed,
                     "number that the jitter is drawn from: another seed, other grain [0]")
        ->type_name("N");
    command->add_option("--target", o.target, "write one target alone as RGB")
        ->check(CLI::IsMember({"composite", "scattering", "transmittance", "surface", "surface_lit",
                               "transparents", "transparents_kept", "depth", "error"}))
        ->type_name("TARGET");
    std::string kinds, kind_names;
    for (const InspectionInfo& info : inspection_table()) {
        kinds += fmt::format("{}{} ({})", kinds.empty() ? "" : ", ", info.name, info.help);
        kind_names += fmt::format("{}{}", kind_names.empty() ? "" : ",", info.name);
    }
    command->add_option("--show", o.inspection.show, "one frame's insides instead: " + kinds)
        ->type_name(fmt::format("KIND:{{{}}}", kind_names));
    command
        ->add_option("--slice", o.inspection.slice,
                     "of --show density-slice: where, in shares of the media's bounds along x, y "
                     "or z; of froxel-slice: in shares of the slices, near to far [z=0.5; 0.5]")
        ->type_name("[x=|y=|z=]0..1");
    command
        ->add_option("--scale", o.inspection.scale,
                     "of --show: the value where its colours end [one that suits]")
        ->type_name("NUMBER");
    command->add_flag("--half", o.half,
                      "16-bit floats in an .exr, cut off at 65504; depth keeps 32 bits");
    command->add_flag("--alpha", o.alpha, "leave out the sky; its transmittance becomes alpha");
    command
        ->add_option("--exposure", o.exposure,
                     "of a .png, in stops; auto: as suits the picture [auto]")
        ->type_name("auto|STOPS");
    command
        ->add_option("--display", o.display,
                     "of a .png: a filmic curve, or srgb, which cuts off what is brighter than "
                     "white [filmic]")
        ->check(CLI::IsMember({"filmic", "srgb"}));
    command
        ->add_option("--save-scene", o.save_scene,
                     "write the scene that is rendered, to be changed and rendered again")
        ->type_name("FILE.json");
    command->add_flag("--explain", o.explain, "which variant was chosen for the scene, and why");
    command->add_flag("--json", o.json, "print JSON");
    add_device_options(*command, o.device);
    command
        ->add_option("--mode", o.mode,
                     "raymarch or froxel on OpenGL, or reference: to a tolerance, on the "
                     "processor [the preset's]")
        ->check(CLI::IsMember({"raymarch", "froxel", "reference"}));
    command
        ->add_option("--tolerance", o.tolerance,
                     "of the reference: relative error of each pixel [0.02, with no bounces 0.001]")
        ->type_name("ERROR")
        ->check(within(1e-6, 0.5));
    command
        ->add_option("--time-limit", o.time_limit,
                     "of the reference: it ends then, and the same command line goes on with it "
                     "[none]")
        ->type_name("SECONDS")
        ->check(within(0.1, 1e7));
    command
        ->add_option("--region", o.region,
                     "this part alone, in pixels from the top left; an .exr keeps the whole "
                     "picture's display window")
        ->type_name("X,Y,WIDTH,HEIGHT");
    add_plan_options(*command, o.wish);
    add_settings(*command, o.words);
    command->footer("A reference that is interrupted or killed stays in OUTPUT.unfinished, and the "
                    "same command line goes\non with it, to the same picture.\n"
                    "Exit code: 0 all written, 1 not, 2 wrong command line.");
    command->callback([options, command] { run(*options, *command); });
}

}  // namespace fumarole::command
