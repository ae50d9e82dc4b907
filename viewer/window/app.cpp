#include "window/app.h"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <imgui.h>
#include <utility>

#include <GLFW/glfw3.h>

#include "overloaded.h"
#include "settings_input.h"
#include "study/flag_names.h"
#include "window/camera_control.h"
#include "window/overlay.h"
#include "window/saving.h"
#include "window/scene_handles.h"
#include "write/whole_file.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::window {

App::App(AppOptions options)
    : screen_{options.memory.size, options.debug}, gui_{screen_.window()}, memory_{std::move(
                                                                               options.memory)},
      document_{options.input}, viewport_{screen_.device(), GlfwWindow::get_proc(),
                                          [this](LogLevel, std::string_view line) { hear(line); }},
      browser_{"/proc/self/exe", ThumbnailCache(thumbnail_folder())},
      browser_panel_{screen_.device()}, automation_{std::move(options.script), options.frames,
                                                    options.screenshot},
      log_{screen_.device().capabilities().renderer}, save_scene_{std::move(options.save_scene)}
{
    notices_.show_message(options.complaint);
    planner_.ask(options.goal);
    if (!options.input.file.empty())
        add_recent(memory_, options.input.file);
}

AppReport App::run()
{
    GlfwWindow& window = screen_.window();
    while (!window.closing()) {
        frame();
        screen_.check();
        if (!automation_.ends(settled() || !notices_.message().empty()))
            continue;
        automation_.request_last_screenshot();
        while (automation_.has_screenshots()) {  // the window's letters may take frames to come
            frame();
            if (window.minimised())
                break;
        }
        window.close();
    }
    automation_.check_screenshots();
    if (!window.minimised())
        memory_.size = window.unscaled_size();
    if (!browser_.folder().empty())
        memory_.folder = browser_.folder();
    remember(memory_);
    if (!save_scene_.empty())
        throw Error(fmt::format("{}: not written; the window closed before the scene was read{}{}",
                                save_scene_, notices_.message().empty() ? "" : ": ",
                                notices_.message()));
    AppReport report = log_.report();
    report.message = notices_.message();
    report.plan = planner_.text();
    report.errors = viewport_.reference().errors();
    report_content(report);
    return report;
}

void App::report_content(AppReport& report) const
{
    const std::vector<GridList>& lists = document_.grids().lists();
    const std::vector<Medium>& media = document_.scene().media;
    for (std::size_t i = 0; i < std::min(lists.size(), media.size()); ++i)
        if (const auto* medium = std::get_if<GridMedium>(&media[i]))
            for (std::size_t row = 0; row < lists[i].rows.size(); ++row) {
                const GridRow& grid = lists[i].rows[row];
                report.grids.push_back({i, grid.name, grid.type,
                                        roles_text(roles_of(*medium, lists[i].rows, row)),
                                        lists[i].error, grid.voxels});
            }
    if (!browser_.is_open())
        return;
    for (const FileEntry& entry : browser_.entries()) {
        const Thumbnail& thumbnail = browser_.thumbnail(entry);
        report.files.push_back(
            {entry.name, thumbnail.error, entry.frames, thumbnail.picture.width > 0});
    }
}

double App::poll_timeout() const
{
    constexpr double kIdle = 0.25, kWorking = 0.05;
    if (automation_.active())
        return 0;
    if (screen_.window().minimised())
        return kIdle;
    if (viewport_.moving() || document_.sequence().playback().playing() ||
        (document_.whole() && !settled()))
        return viewport_.failed() ? kWorking : 0;
    const bool works = document_.loading() || document_.grids().busy() ||
                       (browser_.is_open() && !browser_.settled()) || !gui_.lettered() ||
                       viewport_.reference().busy() || planner_.busy();
    return works ? kWorking : kIdle;
}

bool App::settled() const
{
    return viewport_.settled(document_, state());
}

void App::frame()
{
    const std::vector<Event> from_person = screen_.window().poll(poll_timeout());
    const double seconds = log_.begin_frame();
    std::vector<Event> events = follow_script(seconds);
    events.insert(events.end(), from_person.begin(), from_person.end());
    if (screen_.window().minimised()) {
        take_loaded();
        log_.skip_frame();
        return;
    }
    gui_.begin(events, seconds);
    divide_window();
    take_loaded();
    browser_.take_read();
    for (const Event& event : events)
        handle(event);
    viewport_.invalidate(pointer_.fly(seconds, document_.scene().camera));
    play(seconds);
    draw_panels();
    update_plan();
    viewport_.follow_reference(document_, state(), layout_.picture_pixels(), log_.now());
    draw(seconds);
}

void App::hear(std::string_view line)
{
    const std::string text = study::with_flags(line);
    notices_.show_note(text);
    log_.note(text);
}

void App::draw(double seconds)
{
    const std::string error = viewport_.draw(document_, state(), layout_.picture_pixels(), seconds);
    if (!error.empty())
        notices_.show_message(error);
    screen_.clear(layout_.framebuffer);
    screen_.show(viewport_.displayed(state(), layout_));
    draw_overlay({layout_, state(), document_, viewport_, pointer_, notices_});
    notices_.pass(seconds);
    gui_.end();
    if (const std::string note = gui_.take_note(); !note.empty())
        hear(note);
    if (gui_.lettered())
        for (const std::string& file : automation_.take_screenshots())
            screen_.take_screenshot(file);
    screen_.window().swap();
    log_.end_frame(document_.whole() && viewport_.sides().a().picture(), settled());
}

// ---------------------------------------------------------------------------------- what comes in

void App::open(const std::string& file)
{
    notices_.close_message();
    save_scene_.clear();  // of another scene
    document_.open(file);
    add_recent(memory_, file);
}

void App::take_loaded()
{
    try {
        const Change change = document_.take_loaded();
        viewport_.invalidate(change);
        if (change != Change::none)
            screen_.window().set_title(
                std::filesystem::path(document_.input().file).filename().string() + " - Fumarole");
    } catch (const Error& error) {
        notices_.show_message(error.what());
    }
    // Whoever asked by a command line waits for its file or an error, and may see no window.
    if (document_.whole() && !save_scene_.empty())
        asset::save_scene(document_.as_opened(), std::exchange(save_scene_, ""));
}

void App::play(double seconds)
{
    try {
        viewport_.invalidate(document_.play(seconds));
    } catch (const Error& error) {
        notices_.show_message(error.what());
    }
}

std::vector<Event> App::follow_script(double seconds)
{
    const bool message = !notices_.message().empty();
    const ScriptStatus status{.loaded = !document_.loading() && (document_.whole() || message),
                              .settled = settled(),
                              .reference = viewport_.reference().picture().whole && settled(),
                              .plan = planner_.done(),
                              .grids = document_.whole() && !document_.grids().busy(),
                              .thumbnails = browser_.settled(),
                              .message = message,
                              .frame = document_.sequence().shown()};
    std::vector<Event> events;
    for (const ScriptAction& action : automation_.step(status, seconds)) {
        try {
            perform(action, events);
        } catch (const Error& error) {
            notices_.show_message(error.what());
        }
    }
    return events;
}

void App::perform(const ScriptAction& action, std::vector<Event>& events)
{
    GlfwWindow& window = screen_.window();
    std::visit(
        Overloaded{
            [&](const Event& event) { events.push_back(event); },
            [&](const SetSetting& set) {
                command::tell_of_old_name(set.name);
                change_setting(state(), set.name, set.value);
                viewport_.invalidate(Change::view);
            },
            [&](const OpenFile& file) { open(file.file); },
            [&](const Screenshot& shot) { automation_.request_screenshot(shot.file); },
            [&](const ResizeWindow& resize) { window.resize(resize.size); },
            [&](const Minimise& minimise) { window.minimise(minimise.on); },
            [&](const GiveRole& give) {
                document_.give_role(give.medium, give.grid, find_role(give.role));
            },
            [&](const Browse& where) { browse(where.folder); },
            [&](const WriteClipboard& to) { write::write_whole(to.file, window.clipboard()); }},
        action);
}

void App::handle(const Event& event)
{
    if (const auto* key = std::get_if<KeyEvent>(&event)) {
        handle_key(*key);
    } else if (const auto* dropped = std::get_if<FilesDropped>(&event)) {
        if (!dropped->files.empty())
            open(dropped->files.front());
    } else {
        viewport_.invalidate(pointer_.handle(event, {.scene = document_.scene(),
                                                     .state = state(),
                                                     .picture = layout_.picture,
                                                     .whole = document_.whole(),
                                                     .over_panel = gui_.has_pointer()}));
    }
}

void App::handle_key(const KeyEvent& key)
{
    if (pointer_.take_key(key) || !key.down || gui_.has_keys())
        return;
    // A message lies over the files, and is closed before them.
    const bool message = key.key == GLFW_KEY_ESCAPE && !notices_.message().empty();
    if (!message && browser_.take_key(key))
        return;
    for (const KeyBinding& binding : key_table())
        if (binding.key == key.key && binding.control == key.modifiers.control)
            act(binding.action);
}

void App::act(Action action)
{
    Scene& scene = document_.scene();
    switch (action) {
    case Action::copy_command:
    case Action::save_png:
    case Action::save_exr:
    case Action::save_scene:
        save(action);
        return;
    case Action::browse:
        if (browser_.is_open())
            browser_.close();
        else
            browse("");
        return;
    case Action::fit:
        scene.camera = fitted(scene.camera, subject_of(scene), layout_.picture.aspect());
        break;
    case Action::first_camera:
        scene.camera = document_.as_read().camera;
        break;
    case Action::close:
        notices_.close_message();
        state().help = false;
        break;
    default:
        if (!change_view(state(), action))
            document_.sequence().playback().act(action);
    }
    viewport_.invalidate(Change::view);
}

void App::browse(const std::string& folder)
{
    std::string where = folder;
    if (where.empty() && browser_.folder().empty()) {
        const std::string& file = document_.input().file;
        where = file.empty() ? memory_.folder : std::filesystem::path(file).parent_path().string();
    }
    browser_.open(where);
}

void App::save(Action action)
{
    if (!document_.whole())
        return;
    const glm::ivec2 pixels = layout_.picture_pixels();
    try {
        if (action == Action::copy_command) {
            screen_.window().set_clipboard(copied_command(document_, state(), pixels));
            notices_.show_note("the command line was copied");
            return;
        }
        const char* extension = action == Action::save_png   ? ".png"
                                : action == Action::save_exr ? ".exr"
                                                             : ".json";
        const std::string file = unused_name(document_.input().file, extension);
        if (action == Action::save_scene)
            asset::save_scene(document_.to_save(), file);
        else
            save_picture(file, document_, state(), viewport_, pixels);
        notices_.show_note("wrote " + file);
    } catch (const std::exception& error) {
        notices_.show_message(error.what());
    }
}

// ---------------------------------------------------------------------------------- what is shown

void App::divide_window()
{
    const GlfwWindow& window = screen_.window();
    const Layout layout = lay_out(window.size(), window.pixels(), ImGui::GetFontSize(),
                                  state().panel, document_.sequence().moves());
    if (layout.picture.size != layout_.picture.size)
        viewport_.invalidate(Change::view);
    layout_ = layout;
}

void App::draw_panels()
{
    if (layout_.too_small())
        return;
    if (layout_.panel_width > 0)
        grant(panels_.draw_panel({.state = state(),
                                  .document = document_,
                                  .viewport = viewport_,
                                  .recent = memory_.recent,
                                  .device = log_.report().device,
                                  .plan = planner_.text()},
                                 layout_));
    if (layout_.timeline_height > 0 && document_.sequence().moves())
        Panels::draw_timeline(document_.sequence(), layout_);
    const glm::vec2 size(layout_.window);
    if (browser_.is_open())
        browser_panel_.draw(browser_, size);
    if (const std::string file = browser_.taken(); !file.empty())
        open(file);
    if (state().help)
        state().help = Panels::draw_help(size);
    if (!notices_.message().empty() && !Panels::draw_message(notices_.message(), size))
        notices_.close_message();
}

void App::grant(const PanelWishes& wishes)
{
    viewport_.invalidate(wishes.change);
    if (!wishes.open.empty())
        open(wishes.open);
    for (const Action action : wishes.actions)
        act(action);
    if (wishes.plan)
        planner_.ask(wishes.plan);
}

void App::update_plan()
{
    if (const std::optional<Planner::Answer> answer = planner_.take()) {
        if (answer->error.empty()) {
            state().settings = answer->settings;
            viewport_.invalidate(Change::view);
        } else {
            notices_.show_message("plan: " + answer->error);
        }
    }
    // Not beside the loading, nor while a hand holds the camera.
    if (!planner_.asked() || !settled())
        return;
    Scene scene = document_.scene();
    scene.resolution = glm::uvec2(layout_.picture_pixels());
    planner_.start(scene, state().settings, state().preset, screen_.software());
}

}  // namespace fumarole::window
