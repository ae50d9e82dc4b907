#include "window/app.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <imgui.h>
#include <numbers>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "picture_files.h"
#include "shell_words.h"
#include "study/false_color.h"
#include "study/reference_cache.h"
#include "study/srgb.h"
#include "study/whole_file.h"
#include "window/camera_control.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

constexpr glm::ivec2 kLeastSize{200, 150};  // under it a window says so
constexpr double kHandleReach = 12;         // pixels around a light's handle
constexpr std::size_t kTimesKept = 120;

void GLAD_API_PTR on_gl_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length,
                                const GLchar* text, const void* errors)
{
    if (type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR)
        static_cast<std::vector<std::string>*>(const_cast<void*>(errors))
            ->emplace_back(text, static_cast<std::size_t>(length));
}

/// Frames of a scene in time: its sequences', or those that its camera's path takes.
std::optional<std::pair<int, int>> frames_in(const Scene& moving)
{
    std::optional<std::pair<int, int>> range;
    for (const Medium& medium : moving.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium);
            grid != nullptr && is_sequence(grid->file))
            if (const std::vector<int> frames = frames_of(grid->file); !frames.empty()) {
                if (!range)
                    range = {frames.front(), frames.back()};
                range->first = std::min(range->first, frames.front());
                range->second = std::max(range->second, frames.back());
            }
    if (!range && moving.camera_path.size() > 1)
        range = {0, static_cast<int>(std::ceil((moving.camera_path.back().time - moving.time) *
                                               moving.frames_per_second))};
    return range && range->second > range->first ? range : std::nullopt;
}

}  // namespace

App::App(AppOptions options)
    : options_{std::move(options)}, window_{options_.memory.size, options_.debug}, gui_{window_},
      gl_{GlfwWindow::get_proc()}, display_{gl_}, pace_{gl_.capabilities().software},
      a_{std::make_unique<Side>(GlfwWindow::get_proc())}, state_{options_.memory.state}
{
    if (options_.debug) {
        gl_->Enable(GL_DEBUG_OUTPUT);
        gl_->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        gl_->DebugMessageCallback(on_gl_message, &gl_errors_);
    }
    message_ = options_.complaint;
    frames_left_ = options_.frames;
    plan_due_ = options_.goal.has_value();
    report_.device = gl_.capabilities().renderer;
    if (!options_.input.file.empty()) {
        document_.open(options_.input);
        file_ = options_.input.file;
        add_recent(options_.memory, file_);
    }
}

App::~App() = default;

AppReport App::run()
{
    while (!window_.closing()) {
        frame();
        check_gl();
        if (!options_.script.done())
            continue;
        // Without a number of frames a picture of the window is its end.
        const bool ends = options_.frames > 0
                              ? --frames_left_ <= 0
                              : !options_.screenshot.empty() && (settled() || !message_.empty());
        if (!ends)
            continue;
        if (!options_.screenshot.empty()) {
            screenshots_.push_back(options_.screenshot);
            frame();
        }
        window_.close();
    }
    if (!screenshots_.empty())
        throw Error(fmt::format("{}: not written: the window is minimised", screenshots_.front()));
    Remembered& memory = options_.memory;
    memory.state = state_;
    if (!window_.minimised())
        memory.size = window_.size();
    remember(memory, options_.memory_file);
    report_.message = message_;
    report_.errors = errors_;
    return report_;
}

/// How long a frame may wait for something to happen.
double App::patience() const
{
    constexpr double kIdle = 0.25, kWorking = 0.05;
    if (!options_.script.done() || options_.frames > 0 || !options_.screenshot.empty())
        return 0;
    if (window_.minimised())
        return kIdle;
    if (changed_ || pace_.moving() || playback_.playing() || (whole_ && !settled()))
        return failed_.empty() ? 0 : kWorking;
    const bool works = document_.loading() || reference_worker_.busy() || planner_.busy();
    return works ? kWorking : kIdle;
}

double App::now() const
{
    return std::chrono::duration<double>(Clock::now() - begin_).count();
}

void App::frame()
{
    const std::vector<Event> real = window_.poll(patience());
    const double time = now(), seconds = time - last_;
    last_ = time;
    std::vector<Event> events = follow_script(seconds);
    events.insert(events.end(), real.begin(), real.end());
    if (window_.minimised()) {
        take_news();
        ++report_.frames;
        return;
    }
    gui_.begin(events, seconds);
    lay_out();
    take_news();
    for (const Event& event : events)
        handle(event);
    fly(seconds);
    show_frame(seconds);
    draw_panels();
    update_plan();
    update_reference();

    const glm::ivec2 pixels = window_.pixels();
    pace_.target_ms = state_.target_ms;
    // Only a person's changes make it move; frames that play are changes too.
    content_moves_ = content_changed_ || (content_moves_ && pace_.moving());
    pace_.begin(changed_, seconds);
    if (changed_)
        failed_.clear();
    changed_ = content_changed_ = false;
    const double begin = now();
    draw_sides();
    if (gl_.capabilities().software)
        gl_->Finish();
    frame_ms_ = 1e3 * (now() - begin);
    pace_.end(frame_ms_);
    update_errors();

    gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl_->Disable(GL_SCISSOR_TEST);
    gl_->Viewport(0, 0, pixels.x, pixels.y);
    gl_->ClearColor(0.07f, 0.07f, 0.08f, 1);
    gl_->Clear(GL_COLOR_BUFFER_BIT);
    draw_picture();
    draw_overlays();
    gui_.end();
    for (const std::string& file : std::exchange(screenshots_, {}))
        take_screenshot(file);
    window_.swap();
    if (++report_.frames == 1)
        report_.first_frame_ms = 1e3 * now();
    if (report_.first_picture_ms == 0 && whole_ && a_->picture())
        report_.first_picture_ms = 1e3 * now();
    if (report_.settled_ms == 0 && settled())
        report_.settled_ms = 1e3 * now();
}

void App::lay_out()
{
    const glm::dvec2 size(window_.size());
    const float em = ImGui::GetFontSize();
    panel_width_ = 25 * em;
    // A picture needs room of its own.
    if (!state_.panel || size.x < panel_width_ + kLeastSize.x)
        panel_width_ = 0;
    timeline_height_ = playback_.moves() && size.x - panel_width_ > 30 * em ? 2.4f * em : 0;
    const Area before = area_;
    area_.at = {panel_width_, 0};
    area_.size = {size.x - panel_width_, size.y - timeline_height_};
    if (before.size != area_.size)
        change_view();
}

std::vector<Event> App::follow_script(double seconds)
{
    const ScriptStatus status{.loaded = !document_.loading() && (whole_ || !message_.empty()),
                              .settled = settled(),
                              .reference = reference_.whole && settled(),
                              .plan = !plan_due_ && !planner_.busy() && !plan_text_.empty(),
                              .message = !message_.empty(),
                              .frame = shown_frame_};
    std::vector<Event> events;
    for (const ScriptAction& action : options_.script.step(status, seconds)) {
        try {
            if (const auto* event = std::get_if<Event>(&action)) {
                events.push_back(*event);
            } else if (const auto* set = std::get_if<SetSetting>(&action)) {
                change_setting(state_, set->name, set->value);
                change_view();
            } else if (const auto* file = std::get_if<OpenFile>(&action)) {
                open(file->file);
            } else if (const auto* shot = std::get_if<Screenshot>(&action)) {
                screenshots_.push_back(shot->file);
            } else if (const auto* size = std::get_if<ResizeWindow>(&action)) {
                window_.resize(size->size);
            } else if (const auto* minimise = std::get_if<Minimise>(&action)) {
                window_.minimise(minimise->on);
            } else if (const auto* to = std::get_if<WriteClipboard>(&action)) {
                study::write_whole(to->file, window_.clipboard());
            }
        } catch (const Error& error) {
            say(error.what());
        }
    }
    return events;
}

// ---------------------------------------------------------------------------------- what comes in

void App::open(const std::string& file)
{
    message_.clear();
    document_.open({.file = file, .size = "", .grid = "", .up = "auto"});
    add_recent(options_.memory, file);
}

void App::take_news()
{
    std::optional<Document::News> news = document_.take();
    if (!news)
        return;
    if (!news->error.empty()) {  // what was there stays
        say(news->error);
        return;
    }
    file_ = document_.input().file;
    window_.set_title(fs::path(file_).filename().string() + " - Fumarole");
    frames_.reset();
    playback_ = {};
    whole_ = news->whole;
    notes_ = news->loaded.notes;
    scene_ = std::move(news->loaded.scene);
    first_ = scene_;
    free_camera_ = false;
    if (const auto range = whole_ ? frames_in(news->moving) : std::nullopt) {
        playback_ = Playback(range->first, range->second, news->moving.frames_per_second);
        frames_ = std::make_unique<FrameStore>(std::move(news->moving), range->first, range->second,
                                               scene_);
        shown_frame_ = range->first;
    }
    scene_is_new_ = exposure_due_ = true;
    change_view();
    content_changed_ = true;
}

/// Puts the playhead's frame in, once it is there. Media and lights that were changed stay so.
void App::show_frame(double seconds)
{
    if (!frames_)
        return;
    playback_.advance(seconds, shown_frame_ == playback_.frame());
    const int wanted = playback_.frame();
    const std::optional<Scene> there = frames_->at(wanted);
    if (wanted == shown_frame_)
        return;
    if (const std::string error = frames_->error(wanted); !error.empty()) {
        say(error);
        playback_.play(false);
        playback_.scrub(shown_frame_);
        frames_->forget_errors();
        return;
    }
    if (!there)
        return;
    for (std::size_t i = 0; i < scene_.media.size() && i < there->media.size(); ++i) {
        auto* grid = std::get_if<GridMedium>(&scene_.media[i]);
        const auto* now = std::get_if<GridMedium>(&there->media[i]);
        if (grid == nullptr || now == nullptr)
            continue;
        grid->file = now->file;
        grid->density = now->density;
        grid->emission = now->emission;
        grid->color = now->color;
    }
    scene_.time = there->time;
    if (!free_camera_)
        scene_.camera = there->camera;
    first_ = *there;
    shown_frame_ = wanted;
    change_view();
    content_changed_ = true;
}

void App::handle(const Event& event)
{
    if (const auto* moved = std::get_if<PointerMoved>(&event)) {
        handle_move(moved->to);
    } else if (const auto* button = std::get_if<PointerButton>(&event)) {
        handle_button(*button);
    } else if (const auto* wheel = std::get_if<Wheel>(&event)) {
        constexpr double kNotch = 0.88;  // of the distance
        if (whole_ && !gui_.has_pointer() && area_.holds(pointer_)) {
            scene_.camera = dollied(scene_.camera, std::pow(kNotch, wheel->notches));
            free_camera_ = true;
            change_view();
        }
    } else if (const auto* key = std::get_if<KeyEvent>(&event)) {
        handle_key(*key);
    } else if (const auto* dropped = std::get_if<FilesDropped>(&event)) {
        if (!dropped->files.empty())
            open(dropped->files.front());
    }
}

void App::handle_key(const KeyEvent& key)
{
    constexpr std::array kFly{GLFW_KEY_D, GLFW_KEY_A, GLFW_KEY_E,
                              GLFW_KEY_Q, GLFW_KEY_W, GLFW_KEY_S};
    for (std::size_t i = 0; i < kFly.size(); ++i)
        if (key.key == kFly[i] && (drag_ == Drag::look || !key.down)) {
            flying_[i] = key.down;
            if (drag_ == Drag::look)
                return;
        }
    if (!key.down || gui_.has_keys())
        return;
    for (const KeyBinding& binding : key_table())
        if (binding.key == key.key && binding.control == key.modifiers.control)
            act(binding.action);
}

void App::handle_button(const PointerButton& button)
{
    if (!button.down) {
        drag_ = Drag::none;
        return;
    }
    if (gui_.has_pointer() || !whole_ || !area_.holds(pointer_))
        return;
    constexpr double kWipeReach = 6;
    if (button.button == 0 && state_.comparison == Comparison::split &&
        std::abs(pointer_.x - area_.at.x - state_.wipe * area_.size.x) < kWipeReach) {
        drag_ = Drag::wipe;
        return;
    }
    if (button.button == 0 && state_.lights)
        if (const auto light = handle_at(light_handles(scene_, area_.aspect()),
                                         area_.share(pointer_), area_.size, kHandleReach)) {
            drag_ = Drag::light;
            dragged_light_ = *light;
            return;
        }
    if (button.button == 1)
        drag_ = Drag::look;
    else
        drag_ = button.button == 2 || button.modifiers.shift ? Drag::pan : Drag::orbit;
}

void App::handle_move(glm::dvec2 to)
{
    const glm::dvec2 by = to - pointer_;
    pointer_ = to;
    if (drag_ == Drag::none || !whole_)
        return;
    if (drag_ == Drag::wipe) {
        state_.wipe = std::clamp(area_.share(to).x, 0.0, 1.0);
        return;
    }
    if (drag_ == Drag::light) {
        if (dragged_light_ < scene_.lights.size()) {
            Light& light = scene_.lights[dragged_light_];
            light = dragged(scene_, light, area_.share(to), area_.aspect());
            change_content();
        }
        return;
    }
    const double half_turn = std::numbers::pi / area_.size.y;  // over the picture's height
    Camera& camera = scene_.camera;
    if (drag_ == Drag::orbit)
        camera = orbited(camera, {by.x * half_turn, -by.y * half_turn});
    else if (drag_ == Drag::pan)
        camera = panned(camera, by, area_.size.y);
    else
        camera = looked_around(camera, glm::dvec2(by.x, -by.y) *
                                           (glm::radians(camera.vfov_deg) / area_.size.y));
    free_camera_ = true;
    change_view();
}

void App::fly(double seconds)
{
    if (drag_ != Drag::look) {
        flying_.fill(false);
        return;
    }
    const auto way = [&](std::size_t plus) { return flying_[plus] - flying_[plus + 1]; };
    const glm::dvec3 direction(way(0), way(2), way(4));
    if (direction == glm::dvec3(0))
        return;
    // As far as the target in two seconds.
    Camera& camera = scene_.camera;
    const double speed = 0.5 * glm::length(camera.look_at - camera.position);
    camera = flown(camera, direction * speed * std::min(seconds, 0.1));
    free_camera_ = true;
    change_view();
}

void App::see_next_inside()
{
    const auto kinds = inspection_table();
    std::size_t next =
        state_.inspection ? static_cast<std::size_t>(state_.inspection->kind) + 1 : 0;
    const auto suits = [&](Inspection::Kind kind) {
        return kind != Inspection::Kind::froxel_slice ||
               state_.settings.mode == Settings::Mode::froxel;
    };
    while (next < kinds.size() && !suits(kinds[next].kind))
        ++next;
    if (next >= kinds.size()) {
        state_.inspection.reset();
        return;
    }
    if (!state_.inspection)
        state_.inspection.emplace();
    state_.inspection->kind = kinds[next].kind;
}

void App::act(Action action)
{
    const auto mode = [&](Settings::Mode chosen) {
        state_.settings.mode = chosen;
        state_.reference = false;
        // What only froxels have is not shown of a march.
        if (chosen == Settings::Mode::raymarch && state_.inspection &&
            state_.inspection->kind == Inspection::Kind::froxel_slice)
            state_.inspection.reset();
    };
    const auto compare = [&](Comparison with) {
        state_.comparison = state_.comparison == with ? Comparison::none : with;
    };
    change_view();
    switch (action) {
    case Action::raymarch:
        mode(Settings::Mode::raymarch);
        break;
    case Action::froxel:
        mode(Settings::Mode::froxel);
        break;
    case Action::reference:
        state_.reference = true;
        break;
    case Action::split:
        compare(Comparison::split);
        break;
    case Action::difference:
        compare(Comparison::difference);
        break;
    case Action::see_inside:
        see_next_inside();
        break;
    case Action::fit:
        scene_.camera = fitted(scene_.camera, subject_of(scene_), area_.aspect());
        free_camera_ = true;
        break;
    case Action::first_camera:
        scene_.camera = first_.camera;
        free_camera_ = false;
        break;
    case Action::lights:
        state_.lights = !state_.lights;
        break;
    case Action::play:
        playback_.play(!playback_.playing());
        break;
    case Action::frame_back:
        playback_.scrub(playback_.frame() - 1);
        break;
    case Action::frame_on:
        playback_.scrub(playback_.frame() + 1);
        break;
    case Action::first_frame:
        playback_.scrub(playback_.first());
        break;
    case Action::panel:
        state_.panel = !state_.panel;
        break;
    case Action::help:
        state_.help = !state_.help;
        break;
    case Action::close:
        message_.clear();
        state_.help = false;
        break;
    case Action::copy_command:
        grant({.copy_command = true});
        break;
    case Action::save_png:
        grant({.save_png = true});
        break;
    case Action::save_exr:
        grant({.save_exr = true});
        break;
    case Action::save_scene:
        grant({.save_scene = true});
        break;
    }
}

// ---------------------------------------------------------------------------------- what goes out

void App::draw_panels()
{
    const glm::vec2 size(window_.size());
    if (size.x < static_cast<float>(kLeastSize.x) || size.y < static_cast<float>(kLeastSize.y))
        return;
    if (panel_width_ > 0) {
        PanelContext context{.state = state_,
                             .scene = scene_,
                             .first = first_,
                             .whole = whole_,
                             .notes = notes_,
                             .recent = options_.memory.recent,
                             .file = file_,
                             .loading = document_.loading() ? document_.progress() : "",
                             .side = *a_,
                             .other = compares() ? b_.get() : nullptr,
                             .samples = samples_,
                             .frame_ms = frame_ms_,
                             .history_ms = frame_times_,
                             .effort_level = pace_.level(),
                             .effort_levels = Pace::levels(),
                             .pixels = glm::ivec2(a_->picture().size()),
                             .reference = reference_,
                             .reference_runs = reference_worker_.busy(),
                             .errors = errors_,
                             .timing_method =
                                 timing_name(a_->renderer().renderer().measuring_timing()),
                             .device = report_.device.c_str(),
                             .plan = planner_.busy() ? planner_.progress() : plan_text_,
                             .explain = [this] {
                                 return whole_ ? a_->renderer().renderer().explain(state_.settings)
                                               : std::vector<std::string>{};
                             }};
        grant(panels_.draw_panel(context, panel_width_, size.y));
    }
    if (timeline_height_ > 0 && frames_ != nullptr)
        panels_.draw_timeline(playback_, frames_->frames_there(), playback_.frame() != shown_frame_,
                              {panel_width_, size.y - timeline_height_},
                              {size.x - panel_width_, timeline_height_});
    if (state_.help)
        state_.help = Panels::draw_help(size);
    if (!message_.empty() && !Panels::draw_message(message_, size))
        message_.clear();
}

void App::grant(const PanelWishes& wishes)
{
    if (wishes.view_changed)
        change_view();
    if (wishes.content_changed)
        change_content();
    if (!wishes.open.empty())
        open(wishes.open);
    if (wishes.fit)
        act(Action::fit);
    if (wishes.first_camera)
        act(Action::first_camera);
    if (wishes.plan) {
        options_.goal = wishes.plan;
        plan_due_ = true;
    }
    if (!whole_)
        return;
    const auto tell = [&](const std::string& what) {
        note_ = what;
        note_seconds_ = 4;
    };
    try {
        if (wishes.copy_command) {
            copy_command();
            tell("the command line was copied");
        }
        for (const auto& [wish, extension] :
             {std::pair{wishes.save_png, ".png"}, {wishes.save_exr, ".exr"}})
            if (wish) {
                const std::string file = output_name(extension);
                save_picture(file);
                tell("wrote " + file);
            }
        if (wishes.save_scene) {
            const std::string file = output_name(".json");
            asset::save_scene(scene_, file);
            tell("wrote " + file);
        }
    } catch (const std::exception& error) {
        say(error.what());
    }
}

glm::ivec2 App::picture_pixels(double scale) const
{
    return glm::max(glm::ivec2(glm::dvec2(area_pixels()) * scale + 0.5), glm::ivec2(8));
}

glm::ivec2 App::area_pixels() const
{
    const glm::dvec2 scale = glm::dvec2(window_.pixels()) / glm::dvec2(window_.size());
    return glm::max(glm::ivec2(area_.size * scale + 0.5), glm::ivec2(1));
}

SideRequest App::request(const Settings& settings) const
{
    const Effort& effort = pace_.effort();
    const bool content = content_moves_ && pace_.moving();
    return {.scene = &scene_,
            .settings = settings_at(settings, effort, content),
            .pixels = picture_pixels(effort.scale),
            .average = !pace_.moving() && pace_.full(),
            .most = state_.inspection ? 1 : state_.aa,
            .inspection = state_.inspection};
}

/// @returns whether there is another picture
bool App::draw_side(Side& side, const Settings& settings)
{
    try {
        return side.draw(request(settings));
    } catch (const std::exception& error) {  // said once; tried again when something changes
        failed_ = error.what();
        say(failed_);
        return false;
    }
}

void App::draw_sides()
{
    const bool nothing = scene_.media.empty() && scene_.surfaces.empty() && !whole_;
    if (nothing || !failed_.empty())
        return;
    bool drawn = draw_side(*a_, state_.settings);
    if (const auto other = compares() ? other_settings(state_) : std::nullopt) {
        if (!b_)
            b_ = std::make_unique<Side>(GlfwWindow::get_proc());
        drawn |= draw_side(*b_, *other);
    } else {
        b_.reset();
    }
    if (drawn) {
        double ms = 0;
        for (const auto& [name, pass_ms] : a_->report().pass_ms)
            ms += pass_ms;
        frame_times_.push_back(static_cast<float>(ms));
        if (frame_times_.size() > kTimesKept)
            frame_times_.erase(frame_times_.begin());
    }
    if (pace_.moving())
        samples_ = 0;
    else if (settled() && samples_ == 0 && failed_.empty())
        samples_ = a_->samples(request(state_.settings));
    update_exposure();
    if (state_.comparison == Comparison::difference && (drawn || state_.other == "reference"))
        update_difference();
}

void App::update_exposure()
{
    // Of a new scene at once, from whatever there is; once more when that is sharp, as of a scene
    // that was changed.
    const bool now = scene_is_new_ || (exposure_due_ && settled());
    if (!now || !state_.auto_exposure || state_.inspection || !a_->picture() || !failed_.empty())
        return;
    state_.exposure_ev = write::auto_exposure(a_->read());
    exposure_due_ = exposure_due_ && !settled();
    scene_is_new_ = false;
}

/// What is said of pixels is measured on few of them: the scale of the colours needs no more.
void App::update_difference()
{
    const Image x = a_->read();
    Image r = b_ ? b_->read() : Image{};
    if (state_.other == "reference") {
        r.width = reference_.width;
        r.height = reference_.height;
        r.pixels = reference_.composite;
    }
    if (x.pixels.size() != r.pixels.size() || r.pixels.empty())
        return;
    double square = 0;
    for (const float value : r.pixels)
        square += static_cast<double>(value) * value;
    tenth_of_mean_square_ = 0.1 * square / static_cast<double>(r.pixels.size());
    difference_scale_ = state_.difference_scale > 0
                            ? state_.difference_scale
                            : study::difference_scale(study::difference_map(
                                  x.pixels, r.pixels, 3, study::Difference::magnitude));
}

void App::update_plan()
{
    if (std::optional<Planner::Answer> answer = planner_.take()) {
        if (answer->error.empty()) {
            state_.settings = answer->settings;
            plan_text_ = answer->text;
            change_view();
        } else {
            say("plan: " + answer->error);
        }
    }
    // Not beside the loading, nor while a hand holds the camera.
    if (!plan_due_ || !whole_ || !settled())
        return;
    plan_due_ = false;
    Scene scene = scene_;
    scene.resolution = glm::uvec2(area_pixels());
    planner_.start(scene, state_.settings, state_.preset, *options_.goal,
                   gl_.capabilities().software);
}

void App::update_reference()
{
    if (!whole_ || !state_.wants_reference()) {
        if (reference_of_) {
            reference_worker_.stop();
            reference_of_.reset();
            reference_ = {};
            errors_.clear();
        }
        return;
    }
    Scene wanted = scene_;
    wanted.resolution = glm::uvec2(area_pixels());
    const bool same = reference_of_ && reference_of_->second == state_.tolerance &&
                      reference_of_->first.resolution == wanted.resolution &&
                      reference_of_->first.camera == wanted.camera &&
                      reference_of_->first.time == wanted.time &&
                      same_content(reference_of_->first, wanted);
    if (!same) {
        if (reference_of_)
            reference_worker_.stop();
        reference_of_.reset();
        errors_.clear();
        if (pace_.moving())  // not for each step of a drag
            return;
        reference_worker_.start(wanted, state_.tolerance);
        reference_of_.emplace(std::move(wanted), state_.tolerance);
    }
    // Copying a whole picture for each tile would cost more than the tiles.
    constexpr double kEach = 0.2;  // seconds
    if (reference_texture_ && reference_worker_.busy() && now() - reference_seen_ < kEach)
        return;
    reference_seen_ = now();
    const std::uint64_t before = reference_.version;
    reference_worker_.update(reference_);
    if (reference_.version == before && reference_texture_)
        return;
    const glm::ivec2 size(reference_.width, reference_.height);
    if (!reference_texture_ || glm::ivec2(reference_texture_.size()) != size)
        reference_texture_ =
            gl::Texture::make_2d(gl_, "reference", size, GL_RGBA32F, gl::Filter::nearest);
    std::vector<float> rgba;
    rgba.reserve(reference_.done.size() * 4);
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x; ++x) {
            const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                                  static_cast<std::size_t>(x);
            rgba.insert(rgba.end(),
                        {reference_.composite[i * 3], reference_.composite[i * 3 + 1],
                         reference_.composite[i * 3 + 2], static_cast<float>(reference_.done[i])});
        }
    reference_texture_.upload(GL_RGBA, GL_FLOAT, rgba.data());
}

void App::update_errors()
{
    if (!settled() || reference_.share == 0 || reference_shown_ == reference_.version ||
        state_.inspection || !a_->picture())
        return;
    reference_shown_ = reference_.version;
    errors_.clear();
    const auto measure = [&](const std::string& name, const Side& side) {
        const Image picture = side.read();
        if (picture.pixels.size() == reference_.composite.size())
            errors_.push_back(
                {name, study::compare(picture.pixels, reference_.composite, reference_.done, 3)});
    };
    measure(fmt::format("A, {}", mode_name(state_.settings.mode)), *a_);
    if (b_ && compares())
        measure("B, " + state_.other, *b_);
}

Shown App::shown(const Side& side) const
{
    Display display{.exposure_ev = state_.exposure_ev, .transform = state_.transform};
    if (state_.inspection && state_.inspection->kind != Inspection::Kind::scattering)
        display = {.exposure_ev = 0, .transform = Display::Transform::srgb};
    return {&side.picture(), display};
}

void App::draw_picture()
{
    if (!a_->picture())
        return;
    const glm::dvec2 scale = glm::dvec2(window_.pixels()) / glm::dvec2(window_.size());
    DisplayRequest request;
    request.size = area_pixels();
    request.lower_left = {static_cast<int>(area_.at.x * scale.x + 0.5),
                          window_.pixels().y - request.size.y -
                              static_cast<int>(area_.at.y * scale.y + 0.5)};
    const Display display{.exposure_ev = state_.exposure_ev, .transform = state_.transform};
    request.a = shown(*a_);
    if (state_.reference && reference_texture_)
        request.a = {&reference_texture_, display};
    if (compares()) {
        if (state_.other == "reference" && reference_texture_)
            request.b = {&reference_texture_, display};
        else if (b_ && b_->picture())
            request.b = shown(*b_);
    }
    if (request.b.picture != nullptr)
        request.comparison = state_.comparison;
    request.wipe = state_.wipe;
    request.scale = difference_scale_;
    request.tenth_of_mean_square = tenth_of_mean_square_;
    display_.draw(request);
}

void App::draw_overlays()
{
    const glm::vec2 at(area_.at), size(area_.size);
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const float em = ImGui::GetFontSize();
    if (window_.size().x < kLeastSize.x || window_.size().y < kLeastSize.y) {
        Panels::draw_greeting(
            fmt::format("this window is too small: {} x {} at least", kLeastSize.x, kLeastSize.y),
            at, size);
        return;
    }
    const auto label = [&](const std::string& words, float x, float y) {
        const ImVec2 extent = ImGui::CalcTextSize(words.c_str());
        draw.AddRectFilled({x - 4, y - 2}, {x + extent.x + 4, y + extent.y + 2},
                           IM_COL32(20, 20, 22, 190));
        draw.AddText({x, y}, IM_COL32(230, 230, 230, 255), words.c_str());
    };
    if (file_.empty() && !document_.loading())
        Panels::draw_greeting("drop a .vdb or a scene here, or type its name at the left", at,
                              size);
    if (document_.loading())
        label(document_.progress() + " ...", at.x + em, at.y + size.y - 2 * em);
    if (note_seconds_ > 0) {
        note_seconds_ -= ImGui::GetIO().DeltaTime;
        label(note_, at.x + em, at.y + size.y - 2 * em);
    }
    if (!whole_)
        return;
    const std::string a = state_.reference
                              ? fmt::format("reference {:.0f} %", 100 * reference_.share)
                              : std::string(mode_name(state_.settings.mode));
    if (state_.comparison == Comparison::split) {
        const float wipe = at.x + static_cast<float>(state_.wipe) * size.x;
        label(a, wipe - ImGui::CalcTextSize(a.c_str()).x - em, at.y + em);
        label(state_.other, wipe + em, at.y + em);
        if (std::abs(pointer_.x - wipe) < 6)
            ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    } else if (state_.comparison == Comparison::difference) {
        Panels::draw_legend(fmt::format("{} against {}, relative", a, state_.other), 0,
                            100 * difference_scale_, "%", at + size);
    } else {
        label(a, at.x + em, at.y + em);
    }
    if (state_.inspection && state_.comparison != Comparison::difference) {
        const InspectionLegend& legend = a_->legend();
        if (legend.false_color)
            Panels::draw_legend(legend.caption, legend.low, legend.high, legend.unit, at + size);
        else
            label(legend.caption, at.x + size.x - 20 * em, at.y + size.y - 2 * em);
    }
    if (state_.lights)
        for (const LightHandle& handle : light_handles(scene_, area_.aspect())) {
            const glm::vec2 p = at + glm::vec2(handle.at) * size;
            if (!area_.holds(p))
                continue;
            draw.AddCircleFilled({p.x, p.y}, 0.4f * em, IM_COL32(255, 225, 120, 255));
            draw.AddCircle({p.x, p.y}, 0.7f * em, IM_COL32(30, 30, 30, 255), 0, 2);
            label(light_name(scene_.lights[handle.light]), p.x + em, p.y - 0.5f * em);
        }
}

// ------------------------------------------------------------------------------------------ deeds

bool App::settled() const
{
    if (!whole_ || document_.loading() || playback_.playing() || changed_ || pace_.moving() ||
        !pace_.full() || playback_.frame() != (frames_ ? shown_frame_ : playback_.frame()))
        return false;
    const int most = state_.inspection ? 1 : state_.aa;
    const bool b_waits = compares() && state_.other != "reference" && failed_.empty() &&
                         (!b_ || b_->frames() < most);
    return !failed_.empty() || (a_->frames() >= most && !b_waits);
}

/// A name beside which nothing is lost: smoke.png, smoke_2.png, ...
std::string App::output_name(const char* extension) const
{
    std::string stem = fs::path(file_).stem().string();
    std::erase(stem, '#');
    for (int i = 1;; ++i) {
        std::string name = i == 1 ? stem + extension : fmt::format("{}_{}{}", stem, i, extension);
        if (!fs::exists(name))
            return name;
    }
}

/// The scene as a command line names it: its own file if nothing was changed, else one that is
/// written for it, named after what it holds.
std::string App::input_words()
{
    const bool untouched =
        !frames_ && scene_.camera == first_.camera && same_content(scene_, first_);
    if (untouched) {
        std::string words = command::shell_word(file_);
        if (!document_.input().grid.empty())
            words += " --grid " + command::shell_word(document_.input().grid);
        if (document_.input().up != "auto")
            words += " --up " + document_.input().up;
        return words;
    }
    const fs::path folder = cache_folder() / "scenes";
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        throw Error(fmt::format("{}: {}; the scene of the command line can't be kept",
                                folder.string(), error.message()));
    const std::string text = asset::scene_to_json(scene_, folder);
    const fs::path file = folder / (study::text_hash(text) + ".json");
    asset::save_scene(scene_, file);
    return command::shell_word(file.string());
}

void App::copy_command()
{
    window_.set_clipboard(command_line(state_, input_words(), area_pixels(),
                                       fs::path(output_name(".png")).filename().string()));
}

/// As the command line makes it, at the size that is on the screen.
void App::save_picture(const std::string& file)
{
    const command::PictureFiles files{.outputs = {file},
                                      .target = "",
                                      .exposure = state_.exposure_ev,
                                      .transform = state_.transform};
    if (state_.inspection) {
        const Display display = shown(*a_).display;
        if (fs::path(file).extension() == ".png")
            write::write_png(a_->read(), display, file);
        else
            write::write_exr(a_->read(), file);
        return;
    }
    if (state_.reference) {
        if (!reference_.whole)
            throw Error("the reference is not whole yet: wait for it, then save");
        Image image;
        image.width = reference_.width;
        image.height = reference_.height;
        image.channels = {"R", "G", "B"};
        image.pixels = reference_.composite;
        if (fs::path(file).extension() == ".png")
            write::write_png(image, {state_.exposure_ev, state_.transform}, file);
        else
            write::write_exr(image, file);
        return;
    }
    Scene scene = scene_;
    scene.resolution = glm::uvec2(area_pixels());
    StillOptions still;
    still.aa = state_.aa;
    const Still made = a_->renderer().render(scene, state_.settings, still);
    command::write_picture(command::picture_of(made), files);
}

void App::take_screenshot(const std::string& file) const
{
    const glm::ivec2 size = window_.pixels();
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size.x) *
                                    static_cast<std::size_t>(size.y) * 3);
    gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    gl_->ReadBuffer(GL_BACK);
    gl_->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl_->ReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    Image image;
    image.width = size.x;
    image.height = size.y;
    image.channels = {"R", "G", "B"};
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x * 3; ++x)
            image.pixels.push_back(study::srgb_decode(
                static_cast<float>(
                    bytes[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) * 3 +
                          static_cast<std::size_t>(x)]) /
                255));
    write::write_png(image, {.exposure_ev = 0, .transform = Display::Transform::srgb}, file);
}

void App::check_gl()
{
    if (!gl_errors_.empty())
        throw Error("OpenGL: " + gl_errors_.front());
}

}  // namespace fumarole::window
