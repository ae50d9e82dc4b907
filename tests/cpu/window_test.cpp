// What the window does that needs no window: cameras under a hand, the pace, the playhead, the
// words of a command line, what is kept for a person, scripts.

#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "settings_input.h"
#include "shell_words.h"
#include "support/temp_folder.h"
#include "window/camera_control.h"
#include "window/frame_store.h"
#include "window/keys.h"
#include "window/pace.h"
#include "window/playback.h"
#include "window/scene_handles.h"
#include "window/script.h"
#include "window/user_files.h"
#include <fumarole/errors.h>

namespace fumarole::window {
namespace {

using test::TempFolder;
using testing::ElementsAre;
using testing::HasSubstr;

double distance(const Camera& camera)
{
    return glm::length(camera.look_at - camera.position);
}

TEST(CameraControl, AnOrbitKeepsItsDistanceAndItsTarget)
{
    const Camera camera;
    const Camera moved = orbited(camera, {0.7, 0.3});
    EXPECT_EQ(moved.look_at, camera.look_at);
    EXPECT_NEAR(distance(moved), distance(camera), 1e-12);
    // A picture that is dragged to the right shows more of its left: the eye goes left.
    EXPECT_LT(glm::dot(moved.position - camera.position, axes_of(camera)[0]), 0);
    const Camera back = orbited(orbited(camera, {0.7, 0}), {-0.7, 0});
    EXPECT_NEAR(glm::length(back.position - camera.position), 0, 1e-12);
}

TEST(CameraControl, AnOrbitStopsShortOfThePoles)
{
    for (const double turn : {10.0, -10.0}) {
        const Camera moved = orbited(Camera(), {0, turn});
        const double sine =
            glm::length(glm::cross(glm::normalize(moved.position - moved.look_at), moved.up));
        EXPECT_NEAR(sine, 0.02, 1e-4);
        EXPECT_TRUE(std::isfinite(axes_of(moved)[0].x));
    }
}

TEST(CameraControl, APanKeepsThePointUnderThePointer)
{
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic}) {
        Camera camera;
        camera.projection = projection;
        const double height = 300, aspect = 16.0 / 9;
        const Projected before = project(camera, camera.look_at, aspect);
        const Projected after = project(panned(camera, {30, -12}, height), camera.look_at, aspect);
        EXPECT_NEAR((after.at.x - before.at.x) * height * aspect, 30, 1e-9);
        EXPECT_NEAR((after.at.y - before.at.y) * height, -12, 1e-9);
    }
}

TEST(CameraControl, ADollyKeepsItsPlaceInTheWorldAndStopsAtTheNearPlane)
{
    const Camera camera;
    EXPECT_NEAR(distance(dollied(camera, 0.5)), 0.5 * distance(camera), 1e-12);
    EXPECT_NEAR(distance(dollied(camera, 1e-9)), camera.near, 1e-12);
    Camera flat;
    flat.projection = Camera::Projection::orthographic;
    flat.ortho_height = 6;
    EXPECT_EQ(dollied(flat, 0.5).ortho_height, 3);
}

TEST(CameraControl, AFitHoldsAllCornersAndTouchesTheEdge)
{
    const Bounds box{{-1, 2, 0}, {3, 4, 9}};
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic})
        for (const double aspect : {0.5, 1.0, 2.5}) {
            Camera camera;
            camera.position = {20, -30, 12};
            camera.projection = projection;
            const Camera moved = fitted(camera, box, aspect);
            double farthest = 0;
            for (int i = 0; i < 8; ++i) {
                const Projected p = project(moved, box.corner(i), aspect);
                EXPECT_GT(p.view_z, 0);
                const glm::dvec2 off = glm::abs(p.at - 0.5);
                farthest = std::max({farthest, off.x, off.y});
            }
            EXPECT_LE(farthest, 0.5);
            EXPECT_GT(farthest, 0.4) << "it could be nearer";
        }
}

TEST(CameraControl, ALookAroundStaysWhereItIs)
{
    const Camera camera;
    const Camera moved = looked_around(camera, {0.2, 0.1});
    EXPECT_EQ(moved.position, camera.position);
    EXPECT_NEAR(distance(moved), distance(camera), 1e-12);
    EXPECT_GT(moved.look_at.z, camera.look_at.z) << "upwards";
}

Scene lit_scene()
{
    Scene scene;
    BoxMedium box;
    box.min = {-1, -1, 1};
    box.max = {1, 1, 3};
    scene.media.emplace_back(box);
    SunLight sun;
    sun.direction_to_light = glm::normalize(glm::dvec3(0.4, -0.5, 0.7));
    PointLight point;
    point.position = {1, 0.5, 2};
    SpotLight spot;
    spot.position = {-1, 0.3, 2.5};
    scene.lights = {sun, point, spot};
    return scene;
}

TEST(LightHandles, ALightFollowsThePointer)
{
    const Scene scene = lit_scene();
    const double aspect = 1.6;
    const auto handles = light_handles(scene, aspect);
    ASSERT_EQ(handles.size(), 3u);
    for (const LightHandle& handle : handles) {
        Scene moved = scene;
        const glm::dvec2 to = handle.at + glm::dvec2(-0.03, 0.04);
        moved.lights[handle.light] = dragged(scene, scene.lights[handle.light], to, aspect);
        const glm::dvec2 now = light_handles(moved, aspect)[handle.light].at;
        EXPECT_NEAR(glm::length(now - to), 0, 1e-9) << light_name(scene.lights[handle.light]);
    }
}

TEST(LightHandles, ASunDraggedFarAwayStaysADirection)
{
    const Scene scene = lit_scene();
    const Light moved = dragged(scene, scene.lights[0], {5, -3}, 1.6);
    EXPECT_NEAR(glm::length(std::get<SunLight>(moved).direction_to_light), 1, 1e-12);
}

TEST(LightHandles, TheNearestWithinReachIsTaken)
{
    const std::vector<LightHandle> handles{{0, {0.5, 0.5}}, {1, {0.52, 0.5}}};
    EXPECT_EQ(handle_at(handles, {0.515, 0.5}, {1000, 500}, 12), 1u);
    EXPECT_EQ(handle_at(handles, {0.6, 0.5}, {1000, 500}, 12), std::nullopt);
}

TEST(Pace, LosesNoMoreThanTheTimeAsksAndSharpensAtRest)
{
    Pace pace(false);
    pace.target_ms = 30;
    const auto cost = [&] {  // as a renderer of 200 ms at full effort would
        const Effort& e = pace.effort();
        return 200 * e.scale * e.scale * e.steps / (e.resolution * e.resolution);
    };
    for (int i = 0; i < 40; ++i) {
        pace.begin(true, 0.03);
        pace.end(cost());
    }
    EXPECT_TRUE(pace.moving());
    EXPECT_LE(cost(), 30);
    EXPECT_GT(cost(), 3) << "more than was needed was lost";
    int frames = 0;
    while (!pace.full() && frames < 100) {
        pace.begin(false, 0.03);
        pace.end(cost());
        ++frames;
    }
    EXPECT_LT(frames, 20);
    EXPECT_FALSE(pace.moving());
    pace.begin(true, 0.03);
    EXPECT_FALSE(pace.full()) << "what was learnt is kept";
}

TEST(Pace, FullEffortIsWhatWasAskedFor)
{
    Settings asked;
    asked.steps = 100;
    asked.resolution = 1;
    EXPECT_EQ(settings_at(asked, Effort{}, false), asked);
    const Settings less =
        settings_at(asked, Effort{.scale = 1, .steps = 0.5, .resolution = 2}, true);
    EXPECT_EQ(less.steps, 50);
    EXPECT_EQ(less.resolution, 2);
    EXPECT_LT(less.world_directions, asked.world_directions);
    asked.resolution = Settings::kAutomatic;  // half, or coarser
    EXPECT_EQ(settings_at(asked, Effort{.resolution = 2}, false).resolution, asked.resolution);
    EXPECT_EQ(settings_at(asked, Effort{.resolution = 4}, false).resolution, 4);
}

TEST(Playback, ShowsEachFrameForItsTimeAndLoops)
{
    Playback playback(3, 5, 10);
    playback.play(true);
    playback.advance(0.05, true);
    EXPECT_EQ(playback.frame(), 3);
    playback.advance(0.06, true);
    EXPECT_EQ(playback.frame(), 4);
    playback.advance(10, false);
    EXPECT_EQ(playback.frame(), 4) << "a frame that is not there is waited for, not skipped";
    playback.advance(0.1, true);
    playback.advance(0.1, true);
    EXPECT_EQ(playback.frame(), 3);
    playback.loop = false;
    playback.scrub(99);
    EXPECT_EQ(playback.frame(), 5);
    playback.advance(0.2, true);
    EXPECT_FALSE(playback.playing());
    playback.play(true);
    EXPECT_EQ(playback.frame(), 3) << "from the start again";
}

TEST(ViewState, ItsCommandLineGivesItsSettingsBack)
{
    ViewState state;
    change_setting(state, "preset", "eevee2017");
    change_setting(state, "steps", "37");
    change_setting(state, "mode", "froxel");
    change_setting(state, "distribution", "0.3");
    const std::string line = command_line(state, "x.vdb", {320, 200}, "x y.png");
    EXPECT_THAT(line, HasSubstr("--size 320x200"));
    EXPECT_THAT(line, HasSubstr("-o 'x y.png'"));
    EXPECT_THAT(line, HasSubstr("--preset eevee2017 --mode froxel"));
    Settings back = find_preset("eevee2017");
    back.mode = Settings::Mode::froxel;
    command::SettingsInput input;
    input.preset = "eevee2017";
    input.mode = "froxel";
    input.changed = {{"steps", "37"}, {"distribution", "0.3"}};
    EXPECT_EQ(command::parse_settings(input), state.settings);
    EXPECT_EQ(command::settings_words(state.settings, back), "--steps 37 --distribution 0.3");
}

TEST(ViewState, TheOtherSideIsAModeAPresetOrTheReference)
{
    ViewState state;
    change_setting(state, "steps", "5");
    state.other = "froxel";
    EXPECT_EQ(other_settings(state)->steps, 5);
    EXPECT_EQ(other_settings(state)->mode, Settings::Mode::froxel);
    state.other = "eevee2017";
    EXPECT_EQ(*other_settings(state), find_preset("eevee2017"));
    state.other = "reference";
    EXPECT_FALSE(other_settings(state));
    state.other = "cinema";
    EXPECT_THROW(other_settings(state), Error);
}

TEST(ShellWords, AShellReadsWordsBack)
{
    EXPECT_EQ(command::shell_word("a/b_####.vdb"), "'a/b_####.vdb'");
    EXPECT_EQ(command::shell_word("plain.vdb"), "plain.vdb");
    EXPECT_EQ(command::shell_word("it's"), "'it'\\''s'");
    EXPECT_EQ(command::shell_word(""), "''");
}

TEST(UserFiles, WhatIsRememberedIsRecalled)
{
    const TempFolder folder;
    const auto file = folder.path() / "deep" / "view.json";
    Remembered what;
    change_setting(what.state, "preset", "eevee2017");
    change_setting(what.state, "steps", "21");
    change_setting(what.state, "mode", "froxel");
    what.state.other = "reference";
    what.state.aa = 3;
    what.size = {700, 500};
    for (int i = 0; i < 12; ++i)
        add_recent(what, fmt::format("/x/{}.vdb", i));
    add_recent(what, "/x/5.vdb");
    remember(what, file);
    std::string complaint;
    const Remembered back = recall(file, complaint);
    EXPECT_EQ(complaint, "");
    EXPECT_EQ(back.state.settings, what.state.settings);
    EXPECT_EQ(back.state.preset, "eevee2017");
    EXPECT_EQ(back.state.other, "reference");
    EXPECT_EQ(back.state.aa, 3);
    EXPECT_EQ(back.size, what.size);
    ASSERT_EQ(back.recent.size(), 10u);
    EXPECT_EQ(back.recent[0], "/x/5.vdb");
    EXPECT_EQ(back.recent[1], "/x/11.vdb");
}

TEST(UserFiles, ADamagedFileIsSaidAndNotBelieved)
{
    const TempFolder folder;
    for (const char* text : {"{", "[]", R"({"settings": {"steps": "0"}})", R"({"preset": "none"})",
                             R"({"aa": "many"})", R"({"settings": {"nonsense": "1"}})"}) {
        std::string complaint;
        const Remembered back = recall(folder.write("view.json", text), complaint);
        EXPECT_THAT(complaint, HasSubstr("view.json")) << text;
        EXPECT_EQ(back.state.settings, Settings{}) << text;
    }
    std::string complaint;
    recall(folder.path() / "none.json", complaint);
    EXPECT_EQ(complaint, "");
}

TEST(Keys, EachKeyDoesOneThingAndCanBeCalled)
{
    std::set<std::pair<int, bool>> seen;
    for (const KeyBinding& binding : key_table()) {
        EXPECT_TRUE(seen.emplace(binding.key, binding.control).second) << binding.name;
        if (!binding.control) {
            EXPECT_EQ(key_called(binding.name), binding.key);
        }
        EXPECT_THAT(key_help(), HasSubstr(std::string(binding.help)));
    }
    EXPECT_EQ(key_called("no such"), -1);
}

/// Reads what a shelf asks for until it asks no more. @returns the frames read, in order
std::vector<int> fill(FrameShelf& shelf, std::uint64_t bytes_each)
{
    std::vector<int> read;
    for (std::optional<int> frame; (frame = shelf.next()) && read.size() < 100;) {
        read.push_back(*frame);
        shelf.put(*frame, Scene(), bytes_each);
    }
    return read;
}

TEST(FrameShelf, ReadsAheadRoundTheEndAndKeepsWhatWasShown)
{
    FrameShelf shelf(1, 40, 1000);
    shelf.move_to(36);
    EXPECT_THAT(fill(shelf, 1), ElementsAre(36, 37, 38, 39, 40, 1, 2, 3, 4));
    for (int frame = 1; frame <= 30; ++frame) {
        shelf.move_to(frame);
        fill(shelf, 1);
    }
    EXPECT_EQ(shelf.size(), FrameShelf::kKept);
    EXPECT_NE(shelf.find(1), nullptr) << "11 frames from now, in a loop";
    EXPECT_EQ(shelf.find(14), nullptr) << "24 frames from now";
}

TEST(FrameShelf, HoldsNoMoreBytesThanItMayAndReadsNothingTwice)
{
    FrameShelf shelf(1, 40, 1000);
    EXPECT_THAT(fill(shelf, 300), ElementsAre(1, 2, 3));
    shelf.move_to(2);
    EXPECT_THAT(fill(shelf, 300), ElementsAre(4));
    EXPECT_EQ(shelf.find(1), nullptr);
    // A frame may turn out larger than those before it: it goes, and is not asked for again.
    shelf.move_to(3);
    EXPECT_THAT(fill(shelf, 900), ElementsAre(5));
    EXPECT_EQ(shelf.size(), 2u);
    // What can't be read takes no room.
    FrameShelf broken(1, 40, 1000);
    broken.put_error(2, "damaged");
    EXPECT_THAT(fill(broken, 300), ElementsAre(1, 3, 4));
    broken.forget_errors();
    EXPECT_THAT(fill(broken, 300), ElementsAre(2));
}

TEST(FrameShelf, TheFrameThatIsShownAndTheNextFitAlways)
{
    FrameShelf shelf(1, 40, 1000);
    for (int frame = 1; frame <= 3; ++frame) {
        shelf.move_to(frame);
        fill(shelf, 5000);
        EXPECT_EQ(shelf.size(), 2u);
        EXPECT_NE(shelf.find(frame), nullptr);
        EXPECT_NE(shelf.find(frame + 1), nullptr);
    }
    shelf.move_to(20);
    EXPECT_THAT(fill(shelf, 5000), ElementsAre(20, 21));
    FrameShelf two(7, 8, 1000);
    EXPECT_THAT(fill(two, 5000), ElementsAre(7, 8));
}

TEST(FrameShelf, AFramesBytesAreThoseOfItsOwnGrids)
{
    const auto grid = [](std::size_t bricks) {
        auto made = std::make_shared<VoxelGrid>();
        made->bricks.resize(bricks);
        made->values.resize(bricks * VoxelGrid::kBrickVoxels);
        return made;
    };
    GridMedium moving, still;
    moving.file = "smoke_####.vdb";
    still.file = "cloud.vdb";
    Scene scene;
    scene.media = {moving, still, moving, BoxMedium()};
    moving.density = grid(2);
    moving.emission = grid(1);
    still.density = grid(50);
    Scene frame;
    frame.media = {moving, still, moving, BoxMedium()};
    EXPECT_EQ(frame_bytes(scene, scene), 0u) << "nothing is read";
    EXPECT_EQ(frame_bytes(scene, frame), 3u * (512 * 4 + 12)) << "shared grids count once";
}

TEST(Script, ActionsComeInOrderAFrameApart)
{
    const TempFolder folder;
    Script script = Script::read(folder.write(
        "s.json", R"([{"wait": "loaded"}, {"key": "Ctrl+C"}, {"drag": [[0,0],[10,20]], "frames": 2},
                      {"set": {"steps": 9, "jitter": "none"}}])"));
    EXPECT_TRUE(script.step({}, 0.1).empty());
    const ScriptStatus loaded{.loaded = true};
    EXPECT_TRUE(script.step(loaded, 0.1).empty());
    std::vector<ScriptAction> all;
    while (!script.done())
        for (const ScriptAction& action : script.step(loaded, 0.1))
            all.push_back(action);
    ASSERT_EQ(all.size(), 9u);
    const auto& key = std::get<KeyEvent>(std::get<Event>(all[0]));
    EXPECT_TRUE(key.down && key.modifiers.control);
    EXPECT_EQ(std::get<PointerMoved>(std::get<Event>(all[4])).to, glm::dvec2(5, 10));
    EXPECT_EQ(std::get<SetSetting>(all[7]).value, "9");
    EXPECT_EQ(std::get<SetSetting>(all[8]).value, "none");
}

TEST(Script, WaitingInVainIsAnError)
{
    const TempFolder folder;
    Script script =
        Script::read(folder.write("s.json", R"([{"wait": "settled", "seconds": 0.5}])"));
    EXPECT_TRUE(script.step({}, 0.3).empty());
    try {
        script.step({}, 0.3);
        FAIL();
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("s.json: action 1: waited 0.5 s for 'settled'"));
    }
}

TEST(Script, MistakesNameTheirAction)
{
    const TempFolder folder;
    const std::vector<std::pair<const char*, const char*>> cases{
        {"{", "not valid JSON"},
        {"{}", "a script is a list"},
        {R"([{"key": "S"}, {"key": "Q7"}])", "action 2: no key is called 'Q7'"},
        {R"([{"dance": 1}])", "action 1: no action is called 'dance'"},
        {R"([{"wait": "forever"}])", "nothing to wait for is called 'forever'"},
        {R"([{"click": [1]}])", "a place is [x, y]"},
        {R"([{"click": [1, 2], "button": "third"}])", "no button is called 'third'"},
        {R"(["S"])", "action 1: an action is an object"},
    };
    for (const auto& [text, words] : cases) {
        try {
            Script::read(folder.write("s.json", text));
            FAIL() << text;
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), HasSubstr(words));
            EXPECT_THAT(error.what(), HasSubstr("s.json"));
        }
    }
    EXPECT_THROW(Script::read(folder.path() / "none.json"), Error);
}

}  // namespace
}  // namespace fumarole::window
