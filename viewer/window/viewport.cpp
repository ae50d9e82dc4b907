#include "window/viewport.h"

#include <chrono>
#include <fmt/format.h>

#include "study/false_color.h"
#include "study/reference.h"
#include "window/scene_handles.h"

namespace fumarole::window {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kTimesKept = 120;

}  // namespace

// ------------------------------------------------------------------------------------- exposure

void ExposureDue::note(Change change)
{
    once_sharp_ |= change >= Change::content;
    at_once_ |= change >= Change::scene;
}

void ExposureDue::chosen(bool settled)
{
    once_sharp_ = once_sharp_ && !settled;
    at_once_ = false;
}

// ------------------------------------------------------------------------------------- viewport

Viewport::Viewport(const gl::Device& device, gl::GetProc get_proc, Log log)
    : device_{device}, pace_{device.capabilities().software}, sides_{get_proc, std::move(log)}
{
}

bool Viewport::settled(const Document& document, const ViewState& state) const
{
    if (!document.at_rest() || moving() || !pace_.full())
        return false;
    if (failed())
        return true;
    const int frames = state.frames_at_rest();
    const bool b_counts = state.compares() && state.other != "reference";
    const bool b_waits = b_counts && (sides_.b() == nullptr || sides_.b()->frames() < frames);
    return sides_.a().frames() >= frames && !b_waits;
}

std::string Viewport::draw(const Document& document, ViewState& state, glm::ivec2 pixels,
                           double seconds)
{
    pace_.target_ms = state.target_ms;
    pace_.begin(change_, seconds);
    exposure_.note(change_);
    if (change_ != Change::none) {
        sides_.retry();
        reference_.outdate_errors();
    }
    change_ = Change::none;
    const bool had_failed = failed();
    const auto begin = Clock::now();
    if (document.drawable() && !had_failed)
        draw_sides(document, state, pixels);
    if (device_.capabilities().software)
        device_->Finish();
    statistics_.frame_ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    pace_.end(statistics_.frame_ms);
    if (settled(document, state))
        measure_errors(state);
    return had_failed ? "" : sides_.error();
}

SideRequest Viewport::request(const Scene& scene, const ViewState& state, const Settings& settings,
                              glm::ivec2 pixels) const
{
    const glm::dvec2 drawn = glm::dvec2(pixels) * pace_.effort().scale;
    return {.scene = &scene,
            .settings = pace_.settings(settings),
            .pixels = glm::max(glm::ivec2(drawn + 0.5), glm::ivec2(8)),
            .average = !pace_.moving() && pace_.full(),
            .most = state.frames_at_rest(),
            .inspection = state.inspection,
            .probe_balls = state.lights ? probe_ball_radius(scene) : 0};
}

void Viewport::draw_sides(const Document& document, ViewState& state, glm::ivec2 pixels)
{
    const SideRequest a = request(document.scene(), state, state.settings, pixels);
    std::optional<SideRequest> b;
    if (const auto other = state.compares() ? other_settings(state) : std::nullopt)
        b = request(document.scene(), state, *other, pixels);
    const bool drawn = sides_.draw(a, b);
    const bool sharp = settled(document, state);
    record(drawn, sharp, a);
    choose_exposure(sharp, state);
    if (state.comparison == Comparison::difference && (drawn || state.other == "reference"))
        measure_difference(state);
}

void Viewport::record(bool drawn, bool settled, const SideRequest& request)
{
    if (drawn) {
        double ms = 0;
        for (const auto& [name, pass_ms] : sides_.a().report().pass_ms)
            ms += pass_ms;
        std::vector<float>& kept = statistics_.gpu_ms;
        kept.push_back(static_cast<float>(ms));
        if (kept.size() > kTimesKept)
            kept.erase(kept.begin());
    }
    if (pace_.moving())
        statistics_.samples = 0;
    else if (settled && statistics_.samples == 0 && !failed())
        statistics_.samples = sides_.a().samples(request);
}

void Viewport::choose_exposure(bool settled, ViewState& state)
{
    if (!exposure_.now(settled) || !state.auto_exposure || state.inspection ||
        !sides_.a().picture() || failed())
        return;
    state.exposure_ev = write::auto_exposure(sides_.a().read());
    exposure_.chosen(settled);
}

void Viewport::measure_difference(const ViewState& state)
{
    const Image x = sides_.a().read();
    const Image r = state.other == "reference" ? reference_.image()
                    : sides_.b() != nullptr    ? sides_.b()->read()
                                               : Image{};
    if (x.pixels.size() != r.pixels.size() || r.pixels.empty())
        return;
    double square = 0;
    for (const float value : r.pixels)
        square += static_cast<double>(value) * value;
    difference_.tenth_of_mean_square = 0.1 * square / static_cast<double>(r.pixels.size());
    difference_.scale = state.difference_scale > 0
                            ? state.difference_scale
                            : study::difference_scale(study::difference_map(
                                  x.pixels, r.pixels, 3, study::Difference::magnitude));
}

// ------------------------------------------------------------------------------------ reference

void Viewport::follow_reference(const Document& document, const ViewState& state, glm::ivec2 pixels,
                                double now)
{
    if (!document.whole() || !state.wants_reference()) {
        reference_.drop();
        return;
    }
    Scene scene = document.scene();
    scene.resolution = glm::uvec2(pixels);
    const int bounces = state.settings.bounces == 0 ? 0 : study::kMeasuredBounces;
    reference_.follow(scene, state.tolerance, bounces, pace_.moving(), now);
    upload_reference();
}

void Viewport::upload_reference()
{
    const ReferenceView::Picture& picture = reference_.picture();
    if (picture.version == reference_tx_.version)
        return;
    reference_tx_.version = picture.version;
    const glm::ivec2 size(picture.width, picture.height);
    gl::Texture& texture = reference_tx_.texture;
    if (!texture || glm::ivec2(texture.size()) != size)
        texture = gl::Texture::make_2d(device_, "reference", size, GL_RGBA32F, gl::Filter::nearest);
    std::vector<float> rgba;
    rgba.reserve(picture.done.size() * 4);
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                                  static_cast<std::size_t>(x);
            const float* rgb = &picture.composite[i * 3];
            rgba.insert(rgba.end(), {rgb[0], rgb[1], rgb[2], static_cast<float>(picture.done[i])});
        }
    texture.upload(GL_RGBA, GL_FLOAT, rgba.data());
}

void Viewport::measure_errors(const ViewState& state)
{
    if (!reference_.unmeasured() || state.inspection || !sides_.a().picture())
        return;
    std::vector<std::pair<std::string, Image>> pictures{
        {fmt::format("A, {}", mode_name(state.settings.mode)), sides_.a().read()}};
    if (state.compares() && sides_.b() != nullptr)
        pictures.emplace_back("B, " + state.other, sides_.b()->read());
    reference_.measure(pictures);
}

// -------------------------------------------------------------------------------------- results

DisplayRequest Viewport::displayed(const ViewState& state, const Layout& layout) const
{
    DisplayRequest request;
    if (!sides_.a().picture())
        return request;
    request.size = layout.picture_pixels();
    request.lower_left = layout.picture_lower_left();
    const gl::Texture& reference = reference_tx_.texture;
    const Shown as_reference{&reference, state.display()};
    request.a = state.reference && reference ? as_reference
                                             : Shown{&sides_.a().picture(), display_of(state)};
    if (state.compares()) {
        if (state.other == "reference" && reference)
            request.b = as_reference;
        else if (sides_.b() != nullptr && sides_.b()->picture())
            request.b = {&sides_.b()->picture(), display_of(state)};
    }
    if (request.b.picture != nullptr)
        request.comparison = state.comparison;
    request.wipe = state.wipe;
    request.scale = difference_.scale;
    request.tenth_of_mean_square = difference_.tenth_of_mean_square;
    return request;
}

Still Viewport::still(const Scene& scene, const ViewState& state)
{
    StillOptions options;
    options.aa = state.aa;
    return sides_.a().renderer().render(scene, state.settings, options);
}

std::vector<std::string> Viewport::explain(const Settings& settings)
{
    return sides_.a().renderer().renderer().explain(settings);
}

const char* Viewport::timing_method()
{
    return timing_name(sides_.a().renderer().renderer().measuring_timing());
}

}  // namespace fumarole::window
