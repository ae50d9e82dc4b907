#include "study/stability.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

#include "study/false_color.h"
#include "study/flag_names.h"
#include "study/label_font.h"
#include "study/panels.h"
#include "study/seconds.h"
#include "study/stability_bench.h"
#include <fumarole/errors.h>

namespace fumarole::study {

const std::array<std::string_view, 12> kStabilityGroups{
    "optical depth from 1e-6 to 1e4, emission without extinction, a channel without extinction",
    "g to +-0.999, a light's own direction in view",
    "a light inside the medium, on the camera, near a ray; radiance of 1e5",
    "depth edges: wires, foliage, silhouettes at 1/2 and 1/4 resolution",
    "sky, near = depth, the camera inside, a medium behind the camera that shades the view",
    "sheets thinner than a step, density step edges, order of convergence",
    "motion: pan, dolly, orbit, a cut, lights switched and moved, animated media; flicker",
    "storage of the layer: banding, overflow, a history that stalls",
    "far fog, a thin wall, misaligned edges, odd and changing sizes, corners of the frame",
    "transforms: turned, sheared, mirrored, stretched; far from the origin; other units",
    "brick borders and empty space: dense or sparse, the picture must not change",
    "hostile data: NaN, infinities, negatives, nothing, level sets, far voxels, torn and forged "
    "files",
};

namespace {

using Clock = std::chrono::steady_clock;

// -------------------------------------------------------------------------------------- pictures

constexpr int kPanel = 256;  ///< pixels that a small picture is brought to, whole times
constexpr int kGap = 8;

/// Each pixel `times` times in both directions.
std::vector<float> enlarged(const std::vector<float>& from, int width, int height, int channels,
                            int times)
{
    std::vector<float> to;
    to.reserve(from.size() * static_cast<std::size_t>(times * times));
    for (int y = 0; y < height * times; ++y)
        for (int x = 0; x < width * times; ++x)
            for (int c = 0; c < channels; ++c)
                to.push_back(from[static_cast<std::size_t>(
                    ((y / times) * width + x / times) * channels + c)]);
    return to;
}

/// Green where it is no number, as in false_color.
Image shown(std::vector<float> rgb, int width, int height, float exposure)
{
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const bool number =
            std::isfinite(rgb[i]) && std::isfinite(rgb[i + 1]) && std::isfinite(rgb[i + 2]);
        for (std::size_t c = 0; c < 3; ++c)
            rgb[i + c] =
                number ? std::clamp(rgb[i + c] * exposure, 0.0f, 1.0f) : (c == 1 ? 1.0f : 0.0f);
    }
    return {width, height, {"R", "G", "B"}, std::move(rgb)};
}

/// Digits alone are a group's number: `5` does not mean every name with a 5 in it.
bool matches(const StabilityCase& one, const std::string& pattern)
{
    if (!pattern.empty() && pattern.find_first_not_of("0123456789") == std::string::npos)
        return pattern == fmt::format("{}", one.group);
    return one.name.find(pattern) != std::string::npos;
}

}  // namespace

const std::vector<StabilitySubject>& stability_subjects()
{
    static const std::vector<StabilitySubject> subjects = [] {
        std::vector<StabilitySubject> all;
        for (const auto& [name, settings] : presets())
            all.push_back({mode_name(settings.mode), name, settings});
        const auto ask = [&](std::string_view setting, std::string_view value) {
            for (const Settings& settings : {find_preset("default"), find_preset("froxel")}) {
                all.push_back({mode_name(settings.mode), value, settings, setting});
                find_setting(setting).set(all.back().settings, value);
            }
        };
        ask(kTargetFormat, "r11g11b10f");
        ask(kTargetFormat, "rgba32f");
        ask(kTransparency, "single");
        ask(kTransparency, "doubled");
        return all;
    }();
    return subjects;
}

bool marches(const StabilitySubject& subject)
{
    return subject.settings.mode == Settings::Mode::raymarch;
}

bool has_froxels(const StabilitySubject& subject)
{
    return subject.settings.mode == Settings::Mode::froxel;
}

const std::vector<StabilityCase>& stability_table()
{
    static const std::vector<StabilityCase> table = [] {
        std::vector<StabilityCase> cases;
        add_extinction_cases(cases);
        add_light_cases(cases);
        add_depth_cases(cases);
        add_march_cases(cases);
        add_motion_cases(cases);
        add_storage_cases(cases);
        add_frame_cases(cases);
        add_invariance_cases(cases);
        add_hostile_cases(cases);
        add_field_cases(cases);
        add_transparent_cases(cases);
        add_indoor_cases(cases);
        add_probe_cases(cases);
        std::stable_sort(cases.begin(), cases.end(),
                         [](const auto& a, const auto& b) { return a.group < b.group; });
        return cases;
    }();
    return table;
}

std::vector<StabilityRun> stability_runs(const StabilityChoice& choice)
{
    std::vector<StabilityRun> runs;
    for (const StabilityCase& one : stability_table()) {
        if (choice.quick && !one.quick)
            continue;
        if (!matches(one, choice.pattern))
            continue;
        for (const StabilitySubject& subject : stability_subjects())
            if ((choice.mode.empty() || choice.mode == subject.mode) &&
                (choice.preset.empty() || choice.preset == subject.preset) &&
                (subject.asked.empty() || subject.asked == one.asks) &&
                (!one.runs || one.runs(subject)))
                runs.push_back({&one, &subject});
    }
    return runs;
}

std::vector<StabilityResult> measure_stability(const std::vector<StabilityRun>& runs,
                                               SceneRenderer& renderer,
                                               const std::filesystem::path& scratch,
                                               const StabilityProgress& progress)
{
    const Clock::time_point begin = Clock::now();
    std::vector<StabilityResult> results;
    for (const StabilityRun& run : runs) {
        const int done = static_cast<int>(results.size());
        const double spent = seconds_since(begin);
        if (progress)
            progress(done, static_cast<int>(runs.size()), run,
                     spent / std::max(done, 1) * static_cast<double>(runs.size() - results.size()));
        StabilityResult result;
        result.run = run;
        try {
            Settings settings = run.subject->settings;
            if (!run.what->bounces)
                settings.bounces = 0;
            result.figure = run.what->measure(StabilityBench(renderer, settings, scratch));
            result.holds = run.what->holds(result.figure.value);
        } catch (const Error& error) {
            result.figure.value = std::nan("");
            const std::string text = with_flags(error.what());
            result.refusal = text.substr(0, text.find('\n'));
        }
        result.seconds = seconds_since(begin) - spent;
        results.push_back(std::move(result));
    }
    return results;
}

Image stability_strip(const StabilityPictures& pictures)
{
    const int times = std::max(1, kPanel / std::max(pictures.width, pictures.height));
    const int width = pictures.width * times, height = pictures.height * times;
    const std::vector<float> map =
        difference_map(pictures.actual, pictures.expected, 3, Difference::magnitude);
    const Image difference =
        false_color(enlarged(map, pictures.width, pictures.height, 1, times), width, height,
                    {Difference::magnitude, difference_scale(map), "actual - expected"});
    // Both in one exposure, the truth's brightest at white.
    float brightest = 0;
    for (const float v : pictures.expected)
        brightest = std::max(brightest, v);
    const float exposure = brightest > 0 ? 1 / brightest : 1;

    Image strip = blank_sheet(2 * (width + kGap) + difference.width,
                              std::max(height + 2 * kGap + label_height(2), difference.height));
    int left = 0;
    for (const auto& [name, rgb] :
         {std::pair{"actual", &pictures.actual}, std::pair{"expected", &pictures.expected}}) {
        paste(strip,
              shown(enlarged(*rgb, pictures.width, pictures.height, 3, times), width, height,
                    exposure),
              left, 0);
        draw_label(strip, left, height + kGap, name, glm::vec3(0), 2);
        left += width + kGap;
    }
    paste(strip, difference, left, 0);
    return strip;
}

}  // namespace fumarole::study
