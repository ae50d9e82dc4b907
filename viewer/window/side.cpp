#include "window/side.h"

#include "gl/program.h"
#include "gl/state_guard.h"
#include "kept_programs.h"
#include "shared/bindings.h"

namespace fumarole::window {

Side::Side(gl::GetProc get_proc, Log log)
    : renderer_{get_proc, std::move(log), command::kept_programs()},
      stills_{renderer_.renderer().make_view(View::History::none)},
      live_{renderer_.renderer().make_view()}, programs_{renderer_.renderer().device()},
      fullscreen_{renderer_.renderer().device(), "window"}, framebuffer_{
                                                                renderer_.renderer().device(),
                                                                "window picture"}
{
    renderer_.renderer().set_timing(renderer_.renderer().measuring_timing());
}

bool Side::continues(const SideRequest& request) const
{
    return drawn_ && drawn_->settings == request.settings && drawn_->pixels == request.pixels &&
           drawn_->inspection == request.inspection && drawn_->probe_balls == request.probe_balls &&
           drawn_->scene.camera == request.scene->camera &&
           drawn_->scene.time == request.scene->time && same_content(drawn_->scene, *request.scene);
}

void Side::resize(glm::ivec2 pixels)
{
    if (mean_ && glm::ivec2(mean_.size()) == pixels)
        return;
    const gl::Device& gl = renderer_.renderer().device();
    color_ = gl::Texture::make_2d(gl, "window frame", pixels, GL_RGBA32F, gl::Filter::nearest);
    depth_ = gl::Texture::make_2d(gl, "window depth", pixels, GL_DEPTH_COMPONENT32F,
                                  gl::Filter::nearest);
    mean_ = gl::Texture::make_2d(gl, "window picture", pixels, GL_RGBA32F, gl::Filter::linear);
}

Frame Side::aim(const SideRequest& request, const Settings& settings, int frame) const
{
    Frame aimed = still_frame(request.scene->camera, settings, color_.view(), depth_.view(),
                              request.average ? frame : 0, 0);
    if (!request.average)  // what moves has a history, and then samples that change every frame
        aimed.index = live_frames_;
    return aimed;
}

Settings Side::settings_of(const SideRequest& request) const
{
    Settings settings = request.settings;
    if (request.average && request.most > 1 && settings.resolution == kAutomatic)
        settings.resolution = averaged_resolution(
            renderer_.renderer().settled(stills_, aim(request, settings, 0), settings).resolution);
    return settings;
}

void Side::accumulate(int frame)
{
    const gl::Device& gl = renderer_.renderer().device();
    const gl::StateGuard guard(gl, 0, 0);
    framebuffer_.attach_color({mean_.view()});
    framebuffer_.bind(glm::ivec2(mean_.size()));
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->BlendFunci(0, GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    gl->BlendColor(0, 0, 0, 1.0f / static_cast<float>(frame + 1));
    color_.bind(DISPLAY_A_UNIT);
    gl->UseProgram(programs_.get({"pass/fullscreen.vert", "pass/accumulate.frag"}, {}).id());
    gl->BindVertexArray(fullscreen_.id());
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->NamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT0, 0, 0);
}

bool Side::draw(const SideRequest& request)
{
    const bool more = request.average && continues(request) && frames_ > 0;
    if (more && frames_ >= request.most)
        return false;
    Renderer& renderer = renderer_.renderer();
    drawn_.reset();  // should this throw, the next one starts over
    // What is dragged or played has its probes captured when it comes to rest.
    if (const double ms = renderer_.set_scene(*request.scene, request.settings, !request.average);
        ms > 0)
        setup_ms_ = ms;
    resize(request.pixels);
    const int number = more ? frames_ : 0;
    const Settings settings = settings_of(request);
    const Frame frame = aim(request, settings, number);
    ++live_frames_;
    renderer.draw_surfaces(frame, settings, true);
    View& view = request.average ? stills_ : live_;
    if (request.inspection)
        legend_ = renderer.inspect(view, frame, settings, *request.inspection);
    else
        renderer.composite(view, frame, settings);
    if (request.probe_balls > 0 && !request.inspection)
        renderer.draw_probes(frame, settings, request.probe_balls);
    accumulate(number);
    FrameReport report = renderer.take_report();
    if (report.pass_ms.empty())  // none has come in since: the last ones known still tell
        report.pass_ms = std::move(report_.pass_ms);
    report_ = std::move(report);
    drawn_ = {*request.scene, request.settings, request.pixels, request.inspection,
              request.probe_balls};
    frames_ = request.average ? number + 1 : 0;
    return true;
}

double Side::samples(const SideRequest& request)
{
    if (!mean_ || renderer_.set_scene(*request.scene, request.settings) < 0)
        return 0;
    View& view = request.average ? stills_ : live_;
    const Settings settings = settings_of(request);
    return renderer_.renderer().count_samples(view, aim(request, settings, 0), settings);
}

Image Side::read() const
{
    Image image;
    image.channels = {"R", "G", "B"};
    if (!mean_)
        return image;
    const glm::ivec2 size(mean_.size());
    image.width = size.x;
    image.height = size.y;
    const std::vector<float> rgba = mean_.read(4);
    image.pixels.reserve(rgba.size() / 4 * 3);
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x; ++x) {
            const std::size_t at =
                4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                     static_cast<std::size_t>(x));
            image.pixels.insert(image.pixels.end(), {rgba[at], rgba[at + 1], rgba[at + 2]});
        }
    return image;
}

}  // namespace fumarole::window
