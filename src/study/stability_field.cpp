// Groups 1, 3 and 7 where light scatters on: the white furnace, orders that lose energy, the grid
// around a bright light, and what is seen while the field changes.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

bool has_field(const StabilitySubject& subject)
{
    return !subject.preset.starts_with("eevee2017");
}

/// One ray or column of froxels for each pixel, no jitter, and so many orders.
Settings followed(const StabilityBench& bench, int bounces)
{
    Settings settings = bench.march_alone(128);
    settings.history = 0;
    settings.temporal = false;
    settings.bounces = bounces;
    return settings;
}

/// A box of 2 m that is looked at askew from outside.
Scene box_scene(float sigma_s, float sigma_a)
{
    Scene scene = bare_scene(24);
    scene.camera.position = {2, -4, 1.5};
    scene.camera.look_at = {0, 0, 0};
    BoxMedium box;
    box.min = glm::dvec3(-1);
    box.max = glm::dvec3(1);
    box.sigma_s = glm::vec3(sigma_s);
    box.sigma_a = glm::vec3(sigma_a);
    scene.media = {box};
    return scene;
}

// -- 1: the white furnace ------------------------------------------------------------------------

StabilityFigure furnace(const StabilityBench& bench, double depth, bool mean)
{
    Scene scene = box_scene(static_cast<float>(depth / 2), 0);
    scene.world.radiance = glm::vec3(1);
    const Picture picture =
        layer(bench.render(scene, followed(bench, Settings::kAutomatic), 0), &Still::composite);
    Picture white = picture;
    std::fill(white.rgb.begin(), white.rgb.end(), 1.0f);
    return mean ? mean_ratio(picture, white) : worst_difference(picture, white);
}

/// The largest ratio of what an order adds to what the one before it added.
StabilityFigure added_by_orders(const StabilityBench& bench)
{
    Scene scene = box_scene(4.75f, 0.25f);
    scene.world.radiance = glm::vec3(1);
    double before = 0, added_before = 0, worst = 0;
    for (int bounces = 0; bounces <= 12; ++bounces) {
        const double now =
            layer(bench.render(scene, followed(bench, bounces), 0), &Still::scattering).mean();
        const double added = now - before;
        if (bounces >= 2 && !(added / added_before <= worst))
            worst = added / added_before;
        before = now;
        added_before = added;
    }
    return {worst};
}

// -- 3: a bright light in thick smoke ------------------------------------------------------------

/// A lamp in the middle of the picture and off the middle of the lattice, which is turned against
/// the picture: the eight pixels that a square's symmetry brings to each other see the same light.
StabilityFigure grid_around_light(const StabilityBench& bench)
{
    constexpr int kSize = 64, kReach = 20;
    Scene scene = bare_scene(kSize);
    scene.camera.projection = Camera::Projection::orthographic;
    scene.camera.ortho_height = 4;
    scene.camera.position = {0, 12, 0};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0.5, 0, std::sqrt(0.75)};
    scene.lights = {PointLight{{0, 0, 0}, glm::vec3(1e3f)}};
    BoxMedium box;
    const glm::dvec3 off(0.11, 0.07, 0.05);
    box.min = off - 5.0;
    box.max = off + 5.0;
    box.sigma_s = glm::vec3(1.98f);
    box.sigma_a = glm::vec3(0.02f);
    scene.media = {box};
    Picture picture =
        layer(bench.render(scene, followed(bench, Settings::kAutomatic), 0), &Still::scattering);
    const Picture once = layer(bench.render(scene, followed(bench, 0), 0), &Still::scattering);
    for (std::size_t i = 0; i < picture.rgb.size(); ++i)
        picture.rgb[i] -= once.rgb[i];
    Picture expected = picture;
    double worst = 0;
    const auto index = [](int x, int y) { return 3 * static_cast<std::size_t>(y * kSize + x); };
    for (int y = kSize / 2; y < kSize / 2 + kReach; ++y)
        for (int x = kSize / 2; x < kSize / 2 + kReach; ++x) {
            const int u = kSize - 1 - x, v = kSize - 1 - y;
            const std::array alike{index(x, y), index(u, y), index(x, v), index(u, v),
                                   index(y, x), index(v, x), index(y, u), index(v, u)};
            double mean = 0;
            for (const std::size_t i : alike)
                mean += double(picture.rgb[i]) / 8;
            for (const std::size_t i : alike) {
                const double off_mean = std::abs(double(picture.rgb[i]) / mean - 1);
                if (!(off_mean <= worst))
                    worst = off_mean;
                for (std::size_t c = 0; c < 3; ++c)
                    expected.rgb[i + c] = static_cast<float>(mean);
            }
        }
    return {worst, {picture.width, picture.height, picture.rgb, expected.rgb}};
}

// -- 7: while it changes -------------------------------------------------------------------------

Scene smoke_scene()
{
    Scene scene = box_scene(2.4f, 0.1f);
    scene.world.radiance = glm::vec3(0.2f);
    scene.lights = {SunLight{glm::normalize(glm::dvec3(-1, -0.4, 0.8)), glm::vec3(3)}};
    return scene;
}

constexpr int kFrames = 10;

/// A small lattice: what is asked is when it is filled.
Settings followed_in_motion(const StabilityBench& bench, int frames)
{
    Settings settings = followed(bench, Settings::kAutomatic);
    settings.ambient_volume_size = 12;
    settings.field_fill = frames;
    return settings;
}

/// All views have one renderer, and what is filled over frames fades from what it had.
void fill_at_once(const StabilityBench& bench, const Scene& scene)
{
    StabilityView(bench, followed_in_motion(bench, 1)).set_scene(scene);
}

/// What a view's mean jumps by from frame to frame beyond an even change, at most.
template <class Change>
StabilityFigure jumps(const StabilityBench& bench, int frames, const Change& change)
{
    Scene scene = smoke_scene();
    fill_at_once(bench, scene);
    StabilityView view(bench, followed_in_motion(bench, frames));
    std::vector<double> means;
    for (int frame = 0; frame < kFrames; ++frame) {
        change(scene, frame);
        view.set_scene(scene);
        means.push_back(view.draw(scene).mean());
    }
    double worst = 0;
    for (std::size_t i = 2; i < means.size(); ++i) {
        const double jump = std::abs(means[i] - 2 * means[i - 1] + means[i - 2]) / means[i];
        if (!(jump <= worst))
            worst = jump;
    }
    return {worst};
}

StabilityFigure moving_sun(const StabilityBench& bench, int frames)
{
    return jumps(bench, frames, [](Scene& scene, int frame) {
        const double angle = glm::radians(60.0 + 2 * frame);
        std::get<SunLight>(scene.lights[0]).direction_to_light = {-std::cos(angle), -0.3,
                                                                  std::sin(angle)};
    });
}

StabilityFigure playing_media(const StabilityBench& bench, int frames)
{
    return jumps(bench, frames, [](Scene& scene, int frame) {
        const float dense = 1 + 0.02f * static_cast<float>(frame);
        auto& box = std::get<BoxMedium>(scene.media[0]);
        box.sigma_s = glm::vec3(2.4f * dense);
        box.sigma_a = glm::vec3(0.1f * dense);
    });
}

/// Frames until a view is within 1 % of what a new one shows, once a lamp is switched off.
StabilityFigure switched_light(const StabilityBench& bench, int filled_over)
{
    Scene scene = smoke_scene();
    StabilityView still(bench, followed_in_motion(bench, 1));
    still.set_scene(scene);
    Picture expected = still.draw(scene);
    for (int frame = 1; frame < kFrames; ++frame)  // whatever takes frames to be whole
        expected = still.draw(scene);
    Scene lit = scene;
    lit.lights.emplace_back(PointLight{{0.4, -2, 0.2}, glm::vec3(8)});
    fill_at_once(bench, lit);
    StabilityView view(bench, followed_in_motion(bench, filled_over));
    view.set_scene(lit);
    for (int frame = 0; frame < 4; ++frame)
        view.draw(lit);
    view.set_scene(scene);
    for (int frame = 1; frame <= kFrames; ++frame)
        if (rms_over_mean(view.draw(scene), expected).value <= 0.01)
            return {static_cast<double>(frame)};
    return {static_cast<double>(kFrames + 1)};
}

}  // namespace

void add_field_cases(std::vector<StabilityCase>& table)
{
    const std::string furnace_reason =
        "albedo 1 in a white world: what is scattered away is scattered in, whatever the depth";
    const auto add = [&](StabilityCase one) {
        one.bounces = true;
        one.runs = has_field;
        table.push_back(std::move(one));
    };
    for (const double depth : {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3}) {
        add({.group = 1,
             .name = fmt::format("furnace-depth-{}", depth),
             .shows = fmt::format("largest error of a white box of optical depth {} in a white "
                                  "world, all bounces",
                                  depth),
             .bound = 0.01,
             .unit = "of the world",
             .reason = furnace_reason,
             .quick = depth == 1 || depth == 100,
             .measure = [depth](const StabilityBench& bench) {
                 return furnace(bench, depth, false);
             }});
        add({.group = 1,
             .name = fmt::format("furnace-mean-depth-{}", depth),
             .shows = fmt::format("error of the mean of the same box of optical depth {}", depth),
             .bound = 0.01,
             .unit = "of the world",
             .reason = furnace_reason,
             .quick = depth == 10,
             .measure = [depth](const StabilityBench& bench) {
                 return furnace(bench, depth, true);
             }});
    }
    add({.group = 1,
         .name = "orders-lose-energy",
         .shows = "largest ratio of the light that an order of scattering adds to what the one "
                  "before added, albedo 0.95, optical depth 10, 12 orders",
         .bound = 0.95,
         .unit = "1",
         .reason = "a scattering keeps the albedo's share of the light, and some of it gets out",
         .measure = added_by_orders});
    add({.group = 3,
         .name = "grid-around-a-light",
         .shows = "largest difference of pixels that see alike, around a lamp in smoke of albedo "
                  "0.99 and optical depth 20, of the light that is scattered on",
         .bound = kJustNoticed,
         .unit = "of the pixel",
         .reason = std::string(kNoticeReason) + "; the lattice of the field would be seen",
         .measure = grid_around_light});
    for (const int frames : {1, 3}) {
        const std::string suffix = frames == 1 ? "" : fmt::format("-over-{}-frames", frames);
        const std::string filled =
            frames == 1 ? "" : fmt::format(", filled over {} frames", frames);
        add({.group = 7,
             .name = "field-moving-sun" + suffix,
             .shows =
                 "what the mean of smoke jumps by beyond an even change, a sun that turns by 2 "
                 "degrees a frame, all bounces" +
                 filled,
             .bound = kJustNoticed,
             .unit = "of the mean",
             .reason = std::string(kNoticeReason) + "; a field that comes in parts would flicker",
             .quick = false,
             .measure = [frames](const StabilityBench& bench) {
                 return moving_sun(bench, frames);
             }});
        add({.group = 7,
             .name = "field-playing-media" + suffix,
             .shows = "the same, media that grow denser by 2 % a frame" + filled,
             .bound = kJustNoticed,
             .unit = "of the mean",
             .reason = std::string(kNoticeReason) + "; a field that comes in parts would flicker",
             .quick = false,
             .measure = [frames](const StabilityBench& bench) {
                 return playing_media(bench, frames);
             }});
        add({.group = 7,
             .name = "field-switched-light" + suffix,
             .shows = "frames until smoke is within 1 % of a new view, a lamp switched off, all "
                      "bounces" +
                      filled,
             .bound = 6,
             .unit = "frames",
             .reason = "a tenth of a second at 60 a second, as for the other changes",
             .quick = false,
             .measure = [frames](const StabilityBench& bench) {
                 return switched_light(bench, frames);
             }});
    }
}

}  // namespace fumarole::study
