#include "probe_captures.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "gl/state_guard.h"
#include "gl/stopwatch.h"
#include "light/probe_place.h"
#include "shared/bindings.h"

namespace fumarole {

ProbeCaptures::ProbeCaptures(const gl::Device& device, gl::PassTimers& timers,
                             light::Probes& probes, MakeView make_view, DrawFace draw_face)
    : device_{device}, timers_{timers}, probes_{probes}, make_view_{std::move(make_view)},
      draw_face_{std::move(draw_face)}
{
}

ProbeCaptures::Canvas& ProbeCaptures::canvas_of(int size)
{
    Canvas& its = canvases_[size];
    if (its.view)
        return its;
    its.color = gl::Texture::make_2d(device_, "probe's picture", glm::ivec2(size), GL_RGBA32F,
                                     gl::Filter::nearest);
    its.depth = gl::Texture::make_2d(device_, "probe's depth", glm::ivec2(size),
                                     GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    its.view.emplace(make_view_());
    return its;
}

void ProbeCaptures::draw_faces(int i, Canvas& canvas, int faces,
                               const std::function<void(int face)>& done)
{
    const LightProbe probe = probes_.at(i);
    // Whatever frames are drawn with: a probe is the scene's.
    FrameSettings s;
    s.resolution = 2;
    constexpr double kNear = 1e-3;  // of the radius
    Frame face;
    face.color = canvas.color.view();
    face.depth = canvas.depth.view();
    face.depth_convention = {.zero_to_one = true, .reversed = true};
    face.clip_from_view = light::probe_clip_from_view(kNear * probe.radius);
    for (int k = 0; k < faces; ++k) {
        face.view_from_world = light::probe_view_from_world(probe.position, k);
        face.index = static_cast<std::uint64_t>(k);
        draw_face_(face, s, *canvas.view, probes_.unseen(i));
        done(k);
    }
}

void ProbeCaptures::capture(int i)
{
    const auto time = timers_.scope("probe");
    const gl::Stopwatch watch(device_, timers_);
    Canvas& canvas = canvas_of(probes_.at(i).size);
    probes_.begin_capture(probes_.shown_to(i));
    draw_faces(i, canvas, 6, [&](int face) {
        const gl::StateGuard guard(device_, BLOCK_COUNT, IMAGE_COUNT);
        probes_.take_face(face, canvas.color);
    });
    probes_.end_capture();
    const gl::StateGuard guard(device_, BLOCK_COUNT, IMAGE_COUNT);
    probes_.finish(i, watch);
}

std::vector<glm::dvec3> ProbeCaptures::mean_around(bool before_last_turn)
{
    constexpr int kSize = 16;
    Canvas canvas = std::move(canvas_of(kSize));
    canvases_.erase(kSize);
    std::vector<glm::dvec3> means;
    using Shown = light::Probes::Shown;
    probes_.begin_capture(before_last_turn ? Shown::before_last_turn : Shown::later_turn);
    for (int i = 0; i < probes_.count(); ++i) {
        glm::dvec3 sum(0);
        double weights = 0;
        draw_faces(i, canvas, 6, [&](int) {
            const std::vector<float> rgb = canvas.color.read(3);
            for (std::size_t k = 0; k < std::size_t{kSize} * kSize; ++k) {
                const std::size_t row = k / kSize;
                const double x = (2 * double(k % kSize) + 1) / kSize - 1,
                             y = (2 * double(row) + 1) / kSize - 1;
                const double weight = std::pow(1 + x * x + y * y, -1.5);  // solid angle
                weights += weight;
                sum += weight * glm::dvec3(rgb[3 * k], rgb[3 * k + 1], rgb[3 * k + 2]);
            }
        });
        means.push_back(sum / weights);
    }
    probes_.end_capture();
    return means;
}

void ProbeCaptures::prepare()
{
    if (probes_.count() == 0)
        return;
    {
        const gl::StateGuard guard(device_, BLOCK_COUNT, IMAGE_COUNT);
        probes_.prepare();
    }
    // Both as the first captures are drawn, without any, and as later ones are.
    for (const bool preparing : {false, true}) {
        using Shown = light::Probes::Shown;
        probes_.begin_capture(preparing ? Shown::later_turn : Shown::first_turn);
        probes_.set_preparing(preparing);
        std::set<int> sizes;
        for (int i = 0; i < probes_.count(); ++i) {
            if (!sizes.insert(probes_.at(i).size).second)
                continue;
            Canvas& canvas = canvas_of(probes_.at(i).size);
            draw_faces(i, canvas, 1, [&](int face) {
                const gl::StateGuard guard(device_, BLOCK_COUNT, IMAGE_COUNT);
                probes_.take_face(face, canvas.color);
            });
        }
    }
    probes_.end_capture();
}

void ProbeCaptures::update(const Frame& frame, std::uint64_t scene_id,
                           SceneSettings::ProbeUpdate when)
{
    if (probes_.count() == 0)
        return;
    using Update = SceneSettings::ProbeUpdate;
    probes_.fade(false);
    const LastFrame now{frame.view_from_world, scene_id};
    const bool moves = std::exchange(last_frame_, now) != now;
    if (when == Update::never || (when == Update::still && moves))
        return;
    take_glimpse(scene_id);
    if (glimpse_)
        return;
    if (const auto i = probes_.doubted()) {
        glimpse_from(*i, scene_id);
        if (!probes_.next(true))
            return;
    }
    if (const auto i = probes_.next(true))
        capture(*i);
    else if (const auto not_yet = probes_.unglimpsed())
        glimpse_from(*not_yet, scene_id);
}

void ProbeCaptures::glimpse_from(int i, std::uint64_t scene_id)
{
    constexpr int kSize = 32;  // pixels of 3 degrees
    Canvas& canvas = canvas_of(kSize);
    glimpse_ = Glimpse{i, scene_id, {}};
    probes_.begin_capture(light::Probes::Shown::later_turn);
    draw_faces(i, canvas, 6,
               [&](int) { glimpse_->faces.emplace_back(device_, canvas.color.view(), 0, GL_RGB); });
    probes_.end_capture();
    take_glimpse(scene_id);
}

void ProbeCaptures::take_glimpse(std::uint64_t scene_id)
{
    if (glimpse_ && glimpse_->scene_id != scene_id)
        glimpse_.reset();
    if (!glimpse_ || !std::ranges::all_of(glimpse_->faces, &gl::Readback::ready))
        return;
    std::vector<float> rgb;
    for (const gl::Readback& face : glimpse_->faces)
        rgb.insert(rgb.end(), face.texels().begin(), face.texels().end());
    probes_.take_glimpse(glimpse_->probe, std::move(rgb));
    glimpse_.reset();
}

void ProbeCaptures::capture_all(bool anew)
{
    probes_.believe_none();
    while (const auto i = probes_.next(anew)) {
        capture(*i);
        probes_.fade(true);
    }
    probes_.fade(true);
}

std::optional<double> ProbeCaptures::next_turn()
{
    if (probes_.count() == 0 || !probes_.have_two_turns())
        return {};
    if (next_turn_ && next_turn_->first == probes_.captures())
        return next_turn_->second;
    const std::vector<glm::dvec3> before = mean_around(true), now = mean_around(false);
    const auto sum = [](glm::dvec3 rgb) { return rgb.r + rgb.g + rgb.b; };
    double most = 0;
    for (std::size_t i = 0; i < now.size(); ++i)
        most = std::max(most, sum(glm::abs(now[i] - before[i])) / std::max(sum(now[i]), 1e-20));
    next_turn_ = {probes_.captures(), most};
    return most;
}

}  // namespace fumarole
