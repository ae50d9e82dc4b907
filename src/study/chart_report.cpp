#include "study/chart_report.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "study/false_color.h"
#include "write/whole_file.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;

constexpr int kWidest = 480;  ///< pixels of a picture in the report

std::string base64(std::string_view bytes)
{
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve(bytes.size() / 3 * 4 + 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group =
                group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

std::string picture(std::string_view png, std::string_view what)
{
    return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", html_text(what),
                       base64(png));
}

Image halved(const Image& from)
{
    const std::size_t channels = from.channels.size();
    Image to;
    to.width = std::max(1, from.width / 2);
    to.height = std::max(1, from.height / 2);
    to.channels = from.channels;
    for (int y = 0; y < to.height; ++y)
        for (int x = 0; x < to.width; ++x)
            for (std::size_t c = 0; c < channels; ++c) {
                float sum = 0;
                for (int i = 0; i < 4; ++i)
                    sum += from.at(std::min(2 * x + i % 2, from.width - 1),
                                   std::min(2 * y + i / 2, from.height - 1), static_cast<int>(c));
                to.pixels.push_back(sum / 4);
            }
    return to;
}

Image rgb(std::vector<float> pixels, int width, int height)
{
    Image image;
    image.width = width;
    image.height = height;
    image.channels = {"R", "G", "B"};
    image.pixels = std::move(pixels);
    return image;
}

Image small(Image image)
{
    while (image.width > kWidest)
        image = halved(image);
    return image;
}

std::string png_bytes(const Image& image, const Display& display, const fs::path& folder)
{
    const write::UnfinishedFile file(folder / "picture.png");
    write::write_png(image, display, file.path());
    return write::read_whole(file.path());
}

const std::vector<float>& target_of(const Still& still, Target target)
{
    return target == Target::composite    ? still.composite
           : target == Target::scattering ? still.scattering
                                          : still.transmittance;
}

const std::vector<float>& target_of(const ReferenceStill& still, Target target)
{
    return target == Target::composite    ? still.composite
           : target == Target::scattering ? still.scattering
                                          : still.transmittance;
}

std::string_view target_name(const Chart& chart)
{
    return kTargetNames[static_cast<std::size_t>(chart.target)];
}

/// A factor as one reads it: 0.42, 1.00, 12.3.
std::string ratio_text(double ratio)
{
    return ratio >= 10 ? fmt::format("{:.1f}", ratio) : fmt::format("{:.2f}", ratio);
}

constexpr std::string_view kStyle = R"(
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 70em;
       margin: 2em auto; padding: 0 1.5em; }
h1 { font-size: 1.6em; } h2 { font-size: 1.2em; margin-top: 2.2em; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25em .8em; text-align: right; border-bottom: 1px solid #ddd; }
th { border-bottom: 2px solid #888; font-weight: 600; } td.t, th.t { text-align: left; }
tr.d td { background: #f2f2f2; } tr.first td { border-top: 2px solid #bbb; }
code { font: 13px/1.4 ui-monospace, monospace; background: #f5f5f5; padding: .1em .3em;
       overflow-wrap: anywhere; }
img { max-width: 100%; height: auto; } .pair { display: flex; gap: 1em; flex-wrap: wrap; }
figure { margin: 1.2em 0 2em; } figcaption { margin-bottom: .4em; } .pair img { max-width: 48%; }
)";

std::string front_table(const Chart& chart, const ReportFacts& facts)
{
    std::string html = "<table><tr><th>no.</th><th class=t>settings</th><th>volume, ms</th>"
                       "<th>min to max</th><th>relMSE</th><th>bias part</th><th>variance</th>"
                       "<th>FLIP</th></tr>\n";
    int number = 0;
    for (const MeasuredPoint* p : chart.front()) {
        const TargetError& e = p->error(chart.target);
        html += fmt::format("<tr class=first><td>{}</td><td class=t>{}</td><td>{:.2f}</td>"
                            "<td>{:.2f} to {:.2f}</td><td>{:.3e}</td><td>{:.2e}</td>"
                            "<td>{:.2e}</td><td>{:.4f}</td></tr>\n",
                            ++number, html_text(p->point.name()), p->median_ms, p->min_ms,
                            p->max_ms, e.relmse, e.bias_part, e.variance, p->errors.flip);
        html += fmt::format("<tr><td></td><td class=t colspan=7><code>{} {} -o "
                            "point{}.exr</code></td></tr>\n",
                            html_text(facts.command), html_text(p->point.arguments(5)), number);
    }
    html += "</table>\n";
    if (number > 0)
        html += fmt::format("<p>Its error: <code>fumarole compare point1.exr {}</code></p>\n",
                            html_text(facts.reference_file.filename().string()));
    return html;
}

std::string effects_table(const Chart& chart)
{
    std::string html = "<table><tr><th class=t>setting</th><th class=t>value</th>"
                       "<th>time, &times; base</th><th>error, &times; base</th>"
                       "<th>volume, ms</th><th>relMSE</th><th class=t>alone it</th></tr>\n";
    std::string last;
    for (const SettingEffect& effect : setting_effects(chart)) {
        const bool first = effect.setting != last;
        last = effect.setting;
        html += fmt::format("<tr class=\"{}{}\"><td class=t>{}</td><td class=t>{}</td><td>{}</td>"
                            "<td>{}</td><td>{:.2f}</td><td>{:.3e}</td><td class=t>{}</td></tr>\n",
                            first ? "first " : "", effect.is_default ? "d" : "",
                            first ? html_text(effect.setting) : "", html_text(effect.value),
                            ratio_text(effect.time_ratio), ratio_text(effect.error_ratio),
                            effect.point->median_ms, effect.point->error(chart.target).relmse,
                            effect.verdict(chart.target));
    }
    return html + "</table>\n";
}

std::string presets_table(const Chart& chart)
{
    std::string html = "<table><tr><th class=t>preset</th><th>volume, ms</th>"
                       "<th>composite</th><th>scattering</th><th>transmittance</th><th>FLIP</th>"
                       "<th>on the front</th></tr>\n";
    for (const MeasuredPoint& p : chart.points)
        if (p.point.is_preset && p.finite())
            html += fmt::format("<tr><td class=t>{}</td><td>{:.2f}</td><td>{:.3e}</td>"
                                "<td>{:.3e}</td><td>{:.3e}</td><td>{:.4f}</td><td>{}</td></tr>\n",
                                html_text(p.point.name()), p.median_ms, p.errors.targets[0].relmse,
                                p.errors.targets[1].relmse, p.errors.targets[2].relmse,
                                p.errors.flip, p.front ? "yes" : "no");
    return html + "</table>\n";
}

}  // namespace

std::string html_text(std::string_view text)
{
    std::string out;
    for (const char c : text)
        switch (c) {
        case '&':
            out += "&amp;";
            break;
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '"':
            out += "&quot;";
            break;
        case '\'':
            out += "&#39;";
            break;
        default:
            out += c;
        }
    return out;
}

std::vector<FrontPicture> front_pictures(const Chart& chart, const Scene& scene,
                                         const ReferenceStill& reference, SceneRenderer& renderer,
                                         const fs::path& folder, const std::atomic<bool>* cancel)
{
    const std::vector<float>& truth = target_of(reference, chart.target);
    const int width = reference.width, height = reference.height;
    Display display;
    if (chart.target == Target::transmittance)
        display.transform = Display::Transform::srgb;
    else
        display.exposure_ev = write::auto_exposure(rgb(truth, width, height));

    std::vector<FrontPicture> pictures;
    std::vector<Image> maps;
    std::vector<double> scales;
    for (const MeasuredPoint* p : chart.front()) {
        if (cancel != nullptr && *cancel)
            throw ChartCancelled();
        const Still still = render_point(renderer, scene, p->point);
        const std::vector<float>& pixels = target_of(still, chart.target);
        pictures.push_back({p, png_bytes(small(rgb(pixels, width, height)), display, folder), ""});
        Image map;
        map.width = width;
        map.height = height;
        map.channels = {"difference"};
        map.pixels = difference_map(pixels, truth, 3, Difference::magnitude);
        scales.push_back(difference_scale(map.pixels));
        maps.push_back(small(std::move(map)));
    }
    // The middle one: that of the worst point would leave all others black.
    std::sort(scales.begin(), scales.end());
    const double scale = scales.empty() ? 0 : scales[scales.size() / 2];
    for (std::size_t i = 0; i < maps.size(); ++i) {
        const Image colored = false_color(
            maps[i].pixels, maps[i].width, maps[i].height,
            {.scale = scale, .caption = fmt::format("{} relative error", target_name(chart))});
        pictures[i].difference_png =
            png_bytes(colored, {.transform = Display::Transform::srgb}, folder);
    }
    return pictures;
}

std::string report_html(const Chart& chart, const ReportFacts& facts,
                        const std::vector<FrontPicture>& pictures)
{
    const std::string title = html_text(facts.title);
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8>\n<title>Chart of {}</title>\n"
        "<style>{}</style></head><body>\n<h1>{}: time against error</h1>\n"
        "<p>{} points at {} &times; {} pixels. Time is what the volume adds to a frame; error is "
        "the relative mean square error of the {} against the reference, single "
        "scattering computed on the CPU to a stated tolerance. Least error reached (floor): "
        "{:.3e}.</p>\n",
        title, kStyle, title, chart.points.size(), chart.size.x, chart.size.y, target_name(chart),
        chart.floor);
    if (!facts.chart_png.empty())
        html += picture(write::read_whole(facts.chart_png), "chart of time against error") + "\n";
    html += "<h2>What to know before believing it</h2>\n<ul>\n";
    for (const std::string& limit : chart.limits)
        html += "<li>" + html_text(limit) + "</li>\n";
    html += "</ul>\n<h2>The front</h2>\n<p>No measured point is both faster and nearer to the "
            "reference than one of these. Bias part is what averaging seeds does not remove, "
            "variance is what it does; they add up to relMSE.</p>\n";
    html += front_table(chart, facts);
    html +=
        fmt::format("<h2>Presets</h2>\n<p>relMSE of each target.</p>\n{}", presets_table(chart));
    html += "<h2>What each setting alone buys and costs</h2>\n<p>One setting of the default preset "
            "changed, the others left; of froxels, of one frame (<code>--preset froxel --history "
            "0</code>), but for the history itself, which is of the preset as it is. The grey row "
            "is that base. Below 1 is better in "
            "both columns. What lies within the spread of times or of seeds counts as not "
            "seen.</p>\n" +
            effects_table(chart);
    if (!pictures.empty())
        html += "<h2>The points on the front</h2>\n<p>Left the picture, right how far each pixel "
                "is from the reference, all in one scale: that of the middle one.</p>\n";
    int number = 0;
    for (const FrontPicture& p : pictures) {
        const std::string name = p.point->point.name();
        html += fmt::format("<figure><figcaption>{}. {}: {:.2f} ms, relMSE {:.3e}</figcaption>"
                            "<div class=pair>{}{}</div></figure>\n",
                            ++number, html_text(name), p.point->median_ms,
                            p.point->error(chart.target).relmse, picture(p.png, name),
                            picture(p.difference_png, "difference of " + name));
    }
    html += "<h2>Made on</h2>\n<table>\n";
    for (const auto& [what, value] : facts.machine)
        html += fmt::format("<tr><td class=t>{}</td><td class=t>{}</td></tr>\n", html_text(what),
                            html_text(value));
    return html + "</table>\n</body></html>\n";
}

}  // namespace fumarole::study
