#include "compare_modes.h"

#include "gl/device.h"
#include "kept_programs.h"
#include "library_log.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "bounce_count.h"
#include "command.h"
#include "interruption.h"
#include "picture_distance.h"
#include "picture_files.h"
#include "progress.h"
#include "study/false_color.h"
#include "study/label_font.h"
#include "study/panels.h"
#include "study/reference_cache.h"
#include "study/srgb.h"
#include <fumarole/errors.h>

namespace fumarole::command {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kReference = "reference";
constexpr std::array<const char*, 3> kTargets{"composite", "scattering", "transmittance"};

/// A name of --modes: `raymarch` is the preset `default`, and any preset is its own.
struct Mode {
    std::string name;
    Settings settings;
};

Settings settings_of(const std::string& name)
{
    if (name == mode_name(Settings::Mode::raymarch))
        return Settings{};
    try {
        return find_preset(name);  // `froxel` is one
    } catch (const Error&) {
        std::vector<std::string_view> presets_there;
        for (const auto& preset : presets())
            presets_there.push_back(preset.first);
        throw UsageError(fmt::format("--modes: '{}' is no mode and no preset (there are: raymarch, "
                                     "{}, reference)",
                                     name, fmt::join(presets_there, ", ")));
    }
}

std::vector<Mode> parse_modes(const ModesOptions& options)
{
    std::vector<std::string> names;
    for (std::size_t at = 0; at <= options.modes.size();) {
        const std::size_t comma = std::min(options.modes.find(',', at), options.modes.size());
        names.push_back(options.modes.substr(at, comma - at));
        at = comma + 1;
    }
    std::vector<Mode> modes;
    for (const std::string& name : names) {
        if (std::count(names.begin(), names.end(), name) > 1)
            throw UsageError(fmt::format("--modes: '{}' stands there twice", name));
        if (name != kReference) {
            modes.push_back({name, settings_of(name)});
            if (options.bounces == "0")
                modes.back().settings.bounces = 0;
        } else if (options.no_reference)
            throw UsageError("--modes: 'reference' and --no-reference exclude each other");
    }
    if (modes.empty())
        throw UsageError("--modes: give one mode or preset at least, beside the reference");
    return modes;
}

/// A target's picture, of a Still or of a ReferenceStill.
template <class AnyStill> Image image_of_target(const AnyStill& still, std::string_view target)
{
    const std::vector<float>& pixels = target == "composite"    ? still.composite
                                       : target == "scattering" ? still.scattering
                                                                : still.transmittance;
    return {still.width, still.height, {"R", "G", "B"}, pixels};
}

/// All pictures of one way to render.
struct Rendered {
    std::string name;
    std::array<Image, kTargets.size()> pictures;  ///< as kTargets
    StillReport report;                           ///< not the reference's
};

template <class AnyStill> Rendered rendered(std::string name, const AnyStill& still)
{
    Rendered one{std::move(name), {}, {}};
    for (std::size_t t = 0; t < kTargets.size(); ++t)
        one.pictures[t] = image_of_target(still, kTargets[t]);
    return one;
}

struct Distance {
    std::string of, from, target;
    PictureDistance is;
};

// ---------------------------------------------------------------------------------- the pictures

constexpr int kGap = 8;

/// As a screen shows it through a display, in linear values again; green where it is no number.
Image shown(const Image& image, const Display& display)
{
    Image out = image;
    for (std::size_t i = 0; i + 2 < out.pixels.size(); i += 3) {
        const glm::vec3 radiance{out.pixels[i], out.pixels[i + 1], out.pixels[i + 2]};
        const bool number = std::isfinite(radiance.r + radiance.g + radiance.b);
        const glm::vec3 encoded =
            number ? write::display_transform(radiance, display) : glm::vec3(0, 1, 0);
        for (int c = 0; c < 3; ++c)
            out.pixels[i + static_cast<std::size_t>(c)] = study::srgb_decode(encoded[c]);
    }
    return out;
}

/// Under it its lines.
Image captioned(const Image& image, const std::vector<std::string>& lines)
{
    const int scale = std::max(1, image.width / 240), line = study::label_height(scale) + 2 * scale;
    Image panel = study::blank_sheet(image.width,
                                     image.height + kGap + line * static_cast<int>(lines.size()));
    study::paste(panel, image, 0, 0);
    for (std::size_t i = 0; i < lines.size(); ++i)
        study::draw_label(panel, 0, image.height + kGap + line * static_cast<int>(i), lines[i],
                          glm::vec3(0), scale);
    return panel;
}

/// Rows of panels, each panel in the column of its number.
Image sheet_of(const std::vector<std::vector<Image>>& rows)
{
    int column = 0, width = 0, height = 0;
    for (const std::vector<Image>& row : rows)
        for (const Image& panel : row)
            column = std::max(column, panel.width + kGap);
    for (const std::vector<Image>& row : rows) {
        int tallest = 0;
        for (const Image& panel : row)
            tallest = std::max(tallest, panel.height);
        width = std::max(width, column * static_cast<int>(row.size()) - kGap);
        height += tallest + kGap;
    }
    Image sheet = study::blank_sheet(width, height);
    int top = 0;
    for (const std::vector<Image>& row : rows) {
        int left = 0, tallest = 0;
        for (const Image& panel : row) {
            study::paste(sheet, panel, left, top);
            left += column;
            tallest = std::max(tallest, panel.height);
        }
        top += tallest + kGap;
    }
    return sheet;
}

// ------------------------------------------------------------------------------------ one scene

/// From a scene to the table and the picture, step by step.
class ModesRun {
public:
    ModesRun(const ModesOptions& options, std::vector<Mode> modes)
        : options_{options}, modes_{std::move(modes)}, exposure_{parse_exposure(options.exposure)},
          scene_{load_input(options.scene).scene}
    {
        if (scene_.media.empty())
            throw Error(fmt::format("{}: the scene has no media; there is nothing to compare",
                                    options.scene.file));
    }

    void run()
    {
        render();
        if (!options_.no_reference)
            get_reference();
        progress_.clear();
        measure();
        if (!options_.output.empty())
            write();
        if (options_.json)
            print_json();
        else
            print_table();
        for (const Distance& d : distances_)
            if (!d.is.metrics.finite)
                throw Error(fmt::format("{}: its {} is not finite", d.of, d.target));
    }

private:
    void render()
    {
        const auto context = make_context(options_.device);
        SceneRenderer renderer(context->get_proc(), library_log(), kept_programs());
        device_ = chosen_text(*context, renderer.renderer().device());
        device_json_ = chosen_json(*context, renderer.renderer().device());
        for (const Mode& mode : modes_) {
            StillReport report;
            const StillOptions still_options{.aa = options_.aa,
                                             .timed_frames = options_.frames,
                                             .progress = [&](int done, int all) {
                                                 progress_.show(mode.name,
                                                                static_cast<double>(done) / all);
                                             }};
            rendered_.push_back(rendered(
                mode.name, renderer.render(scene_, mode.settings, still_options, &report)));
            rendered_.back().report = report;
        }
    }

    /// Kept beside the output, since it takes longer than all else.
    void get_reference()
    {
        progress_.show("reference: preparing");
        study::ReferenceOptions wanted;
        wanted.tolerance = tolerance_;
        wanted.bounces = bounces_;
        wanted.surface_bounces = surface_bounces_;
        wanted.aa = options_.aa;
        wanted.cancel = Interruption::flag();
        wanted.progress = [&](double share) { progress_.show(kReference, share); };
        const study::ReferenceStill still =
            options_.output.empty()
                ? study::render_reference(scene_, wanted)
                : study::keep_reference(scene_, wanted, fs::absolute(options_.output).parent_path(),
                                        FUMAROLE_VERSION, print_over_progress)
                      .still;
        reference_ = rendered(kReference, still);
        noise_ = {study::noise_relmse(still.noise, still.composite),
                  study::noise_relmse(still.scattering_noise, still.scattering),
                  study::NoiseShare{}};
    }

    void measure()
    {
        const auto add = [&](const Rendered& of, const Rendered& from) {
            for (std::size_t t = 0; t < kTargets.size(); ++t)
                distances_.push_back(
                    {of.name, from.name, kTargets[t],
                     picture_distance(kTargets[t], of.pictures[t], from.pictures[t], exposure_)});
        };
        if (reference_)
            for (const Rendered& one : rendered_)
                add(one, *reference_);
        for (std::size_t i = 0; i < distances_.size(); ++i) {
            double& relmse = distances_[i].is.metrics.relmse;
            relmse = noise_[i % kTargets.size()].off(relmse);
        }
        for (std::size_t i = 0; i < rendered_.size(); ++i)
            for (std::size_t k = i + 1; k < rendered_.size(); ++k)
                add(rendered_[k], rendered_[i]);
    }

    /// What the pictures are held against: the reference, or else the first of them.
    [[nodiscard]] const Rendered& truth() const { return reference_ ? *reference_ : rendered_[0]; }

    [[nodiscard]] const Distance* composite_distance(const std::string& of) const
    {
        for (const Distance& d : distances_)
            if (d.of == of && d.from == truth().name && d.target == kTargets[0])
                return &d;
        return nullptr;
    }

    /// The pictures, and under each how far it is from the truth, all in one scale.
    void write()
    {
        const Display display = display_for(kTargets[0], truth().pictures[0], exposure_);
        std::vector<Image> pictures, differences;
        std::vector<std::vector<float>> maps;
        double scale = 0;
        for (const Rendered& one : rendered_) {
            std::string figures;
            if (const Distance* d = composite_distance(one.name))
                figures = fmt::format("relMSE {:.1e}, bias {:+.1f} %", d->is.metrics.relmse,
                                      100 * d->is.metrics.bias);
            pictures.push_back(captioned(
                shown(one.pictures[0], display),
                {fmt::format("{}: {:.1f} ms", one.name, one.report.volume.median_ms), figures}));
            maps.push_back(study::difference_map(one.pictures[0].pixels, truth().pictures[0].pixels,
                                                 3, study::Difference::magnitude));
            scale = std::max(scale, study::difference_scale(maps.back()));
        }
        for (std::size_t i = 0; i < maps.size(); ++i)
            differences.push_back(study::false_color(
                maps[i], scene_.resolution.x, scene_.resolution.y,
                {.scale = scale,
                 .caption = fmt::format("{} - {}", rendered_[i].name, truth().name)}));
        if (reference_)
            pictures.push_back(captioned(shown(reference_->pictures[0], display),
                                         {fmt::format("reference, to {:g} %", 100 * tolerance_)}));
        write::write_png(sheet_of({pictures, differences}),
                         {.exposure_ev = 0, .transform = Display::Transform::srgb},
                         options_.output);
    }

    void print_table() const
    {
        fmt::print("{}, {} x {} on {}, {} frames{}\n", options_.scene.file, scene_.resolution.x,
                   scene_.resolution.y, device_, options_.frames,
                   options_.aa > 1 ? fmt::format(", {} averaged", options_.aa) : "");
        fmt::print("{:<18}{:>10}{:>13}{:>10}   history\n", "mode", "ms", "evaluations", "MB");
        for (const Rendered& one : rendered_)
            fmt::print("{:<18}{:>10.2f}{:>13.3g}{:>10.2f}   {}\n", one.name,
                       one.report.volume.median_ms, one.report.samples,
                       static_cast<double>(one.report.gpu_bytes) * 1e-6,
                       one.report.history.empty() ? "none in this mode" : one.report.history);
        fmt::print("{:<18}{:<18}{:<16}{:>11}{:>12}{:>11}\n", "mode", "against", "target", "relMSE",
                   "bias", "FLIP");
        for (const Distance& d : distances_) {
            const bool first = d.target == kTargets[0];
            fmt::print("{:<18}{:<18}{:<16}{:>11.3e}{:>+12.3e}{:>11.3e}\n", first ? d.of : "",
                       first ? d.from : "", d.target, d.is.metrics.relmse, d.is.metrics.bias,
                       d.is.flip);
        }
        if (!options_.output.empty())
            fmt::print("wrote {}\n", options_.output);
    }

    void print_json() const
    {
        Json modes = Json::array(), distances = Json::array();
        for (const Rendered& one : rendered_)
            modes.push_back({{"name", one.name},
                             {"volume_ms", one.report.volume.median_ms},
                             {"volume_ms_min", one.report.volume.min_ms},
                             {"volume_ms_max", one.report.volume.max_ms},
                             {"samples", one.report.samples},
                             {"gpu_bytes", one.report.gpu_bytes},
                             {"history", one.report.history}});
        for (const Distance& d : distances_)
            distances.push_back({{"mode", d.of},
                                 {"against", d.from},
                                 {"target", d.target},
                                 {"finite", d.is.metrics.finite},
                                 {"relmse", d.is.metrics.relmse},
                                 {"bias", d.is.metrics.bias},
                                 {"flip", d.is.flip}});
        Json json{{"input", options_.scene.file},
                  {"size", {scene_.resolution.x, scene_.resolution.y}},
                  {"aa", options_.aa},
                  {"frames", options_.frames},
                  {"modes", modes},
                  {"distances", distances}};
        json.update(device_json_);
        json["surface_bounces"] = reference_ ? bounces_json(surface_bounces_) : Json();
        json["tolerance"] = reference_ ? Json(tolerance_) : Json();
        json["output"] = options_.output.empty() ? Json() : Json(options_.output);
        fmt::print("{}\n", json.dump(1, ' ', false, Json::error_handler_t::replace));
    }

    const ModesOptions& options_;
    const std::vector<Mode> modes_;
    const std::optional<float> exposure_;
    const Scene scene_;
    Progress progress_;
    std::string device_;  ///< device, and why it is this one
    Json device_json_;
    std::vector<Rendered> rendered_;
    std::optional<Rendered> reference_;
    std::array<study::NoiseShare, kTargets.size()> noise_;  ///< the reference's
    const int bounces_ = options_.bounces == "0" ? 0 : study::kMeasuredBounces;
    const int surface_bounces_ = parse_surface_bounces(options_.surface_bounces, scene_);
    const double tolerance_ =
        options_.tolerance.value_or(study::usual_tolerance(std::max(bounces_, surface_bounces_)));
    std::vector<Distance> distances_;
};

}  // namespace

void compare_modes(const ModesOptions& options)
{
    std::vector<Mode> modes = parse_modes(options);
    if (!options.output.empty())
        check_outputs({options.output});
    const Interruption interruption;
    try {
        ModesRun(options, std::move(modes)).run();
    } catch (const study::ReferenceCancelled& cancelled) {
        throw Error(cancelled.kept > 0
                        ? fmt::format("interrupted with {:.1f} % of the reference's pixels kept; "
                                      "the same command line goes on from there",
                                      100 * cancelled.kept)
                        : "interrupted while the reference was rendered; nothing was written");
    }
}

}  // namespace fumarole::command
