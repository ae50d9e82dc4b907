// What the window does that needs no window: cameras under a hand, the layout, the pointer, the
// document and its sequence, the pace, what is drawn anew, the reference, the words of a command
// line, what is kept for a person, scripts.

#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <thread>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "light_fields.h"
#include "settings_input.h"
#include "shell_words.h"
#include "support/temp_folder.h"
#include "window/automation.h"
#include "window/camera_control.h"
#include "window/document.h"
#include "window/frame_store.h"
#include "window/glfw_window.h"
#include "window/keys.h"
#include "window/layout.h"
#include "window/look.h"
#include "window/notices.h"
#include "window/pace.h"
#include "window/playback.h"
#include "window/pointer_input.h"
#include "window/reference_view.h"
#include "window/saving.h"
#include "window/scene_handles.h"
#include "window/script.h"
#include "window/user_files.h"
#include "window/viewport.h"
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

// What an artist turns changes what it names and nothing else, of the grids where there are any.
TEST(Look, TurnsOneThingAtATime)
{
    Scene read;
    GridMedium smoke;
    smoke.sigma_s_per_density = {4, 6, 10};
    smoke.sigma_a_per_density = {1, 2, 0};
    smoke.emission_per_unit = {3, 1, 0};
    smoke.temperature_grid = "temperature";
    smoke.blackbody_intensity = 2;
    smoke.g = 0.4f;
    BoxMedium haze;
    haze.sigma_s = glm::vec3(0.1f);
    read.media = {haze, smoke};
    read.lights = {PointLight{}, SunLight{{0, 0, 1}, {5, 4, 3}}};
    read.world.radiance = {1, 2, 3};
    Scene scene = read;
    const auto now = [&]() -> GridMedium& { return std::get<GridMedium>(scene.media[1]); };

    EXPECT_DOUBLE_EQ(density_of(scene, read), 1);
    set_density(scene, read, 8);
    set_density(scene, read, 0.25);  // of what was read, not of what is
    EXPECT_NEAR(density_of(scene, read), 0.25, 1e-6);
    EXPECT_EQ(now().sigma_s_per_density, glm::vec3(1, 1.5f, 2.5f));
    EXPECT_EQ(std::get<BoxMedium>(scene.media[0]), haze) << "it is the smoke that is looked at";
    EXPECT_EQ(albedo_of(scene), albedo_of(read));

    set_albedo(scene, {0.5f, 0, 1});
    EXPECT_NEAR(density_of(scene, read), 0.25, 1e-6);
    EXPECT_EQ(albedo_of(scene), glm::vec3(0.5f, 0, 1));
    EXPECT_EQ(now().sigma_a_per_density, glm::vec3(0.625f, 2, 0));
    set_density(scene, read, 1);
    EXPECT_EQ(albedo_of(scene), glm::vec3(0.5f, 0, 1)) << "the colour stays as it was chosen";

    set_anisotropy(scene, -0.2f);
    EXPECT_FLOAT_EQ(anisotropy_of(scene), -0.2f);

    set_fire(scene, read, 3);
    EXPECT_DOUBLE_EQ(fire_of(scene, read), 3);
    EXPECT_EQ(now().emission_per_unit, glm::vec3(9, 3, 0));
    EXPECT_EQ(now().blackbody_intensity, 6);

    ASSERT_NE(sun_of(scene), nullptr);
    EXPECT_EQ(sun_of(scene)->irradiance, glm::vec3(5, 4, 3));
    set_sky(scene, read, 2);
    EXPECT_EQ(scene.world.radiance, glm::vec3(2, 4, 6));
    EXPECT_DOUBLE_EQ(sky_of(scene, read), 2);
    Scene dark = read;
    dark.world.radiance = glm::vec3(0);
    set_sky(scene, dark, 0.5);
    EXPECT_EQ(scene.world.radiance, glm::vec3(0.5f));
    EXPECT_DOUBLE_EQ(sky_of(scene, dark), 0.5);

    scene.media = {haze};  // with nothing else, it is looked at
    set_density(scene, scene, 2);
    EXPECT_EQ(std::get<BoxMedium>(scene.media[0]).sigma_s, glm::vec3(0.2f));
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
    RectLight rect;
    rect.center = {0.5, 0.1, 1.5};
    DiskLight disk;
    disk.center = {-0.5, 0.1, 2.2};
    scene.lights = {sun, point, spot, rect, disk};
    return scene;
}

TEST(LightHandles, ALightFollowsThePointer)
{
    const Scene scene = lit_scene();
    const double aspect = 1.6;
    const auto handles = light_handles(scene, aspect);
    ASSERT_EQ(handles.size(), 5u);
    for (const Handle& handle : handles) {
        Scene moved = scene;
        const glm::dvec2 to = handle.at + glm::dvec2(-0.03, 0.04);
        moved.lights[handle.index] = dragged(scene, scene.lights[handle.index], to, aspect);
        const glm::dvec2 now = light_handles(moved, aspect)[handle.index].at;
        EXPECT_NEAR(glm::length(now - to), 0, 1e-9) << light_name(scene.lights[handle.index]);
    }
}

TEST(LightHandles, ASunDraggedFarAwayStaysADirection)
{
    const Scene scene = lit_scene();
    const Light moved = dragged(scene, scene.lights[0], {5, -3}, 1.6);
    EXPECT_NEAR(glm::length(std::get<SunLight>(moved).direction_to_light), 1, 1e-12);
}

TEST(LightHandles, ATransparentFollowsThePointerToo)
{
    Scene scene = lit_scene();
    QuadTransparent quad;
    quad.corner = {0.3, 0.2, 1.8};
    BillboardTransparent board;
    board.center = {-0.4, 0.5, 2.1};
    MeshTransparent mesh;
    mesh.translate = {0.1, 0.2, 0.3};
    auto triangle = std::make_shared<Mesh>();
    triangle->positions = {{0, 0, 1}, {1, 0, 2}, {0, 1, 3}};
    mesh.mesh = triangle;
    scene.transparents = {quad, board, mesh};
    const double aspect = 1.6;
    const auto handles = transparent_handles(scene, aspect);
    ASSERT_EQ(handles.size(), 3u);
    for (const Handle& handle : handles) {
        Scene moved = scene;
        const glm::dvec2 to = handle.at + glm::dvec2(-0.03, 0.04);
        moved.transparents[handle.index] =
            dragged(scene, scene.transparents[handle.index], to, aspect);
        const glm::dvec2 now = transparent_handles(moved, aspect)[handle.index].at;
        EXPECT_NEAR(glm::length(now - to), 0, 1e-9)
            << transparent_name(scene.transparents[handle.index]);
    }
}

TEST(LightHandles, TheNearestWithinReachIsTaken)
{
    const std::vector<Handle> handles{{0, {0.5, 0.5}}, {1, {0.52, 0.5}}};
    EXPECT_EQ(handle_at(handles, {0.515, 0.5}, {1000, 500}, 12), 1u);
    EXPECT_EQ(handle_at(handles, {0.6, 0.5}, {1000, 500}, 12), std::nullopt);
}

TEST(ProbeHandles, AProbeFollowsThePointer)
{
    Scene scene = lit_scene();
    LightProbe probe;
    probe.position = scene.camera.look_at + glm::dvec3(0.2, 0.1, 0.3);
    scene.probes = {LightProbe{.position = scene.camera.position}, probe};
    const auto handles = probe_handles(scene, 1.6);
    ASSERT_EQ(handles.size(), 1u) << "one is at the eye";
    ASSERT_EQ(handles[0].index, 1u);
    const glm::dvec2 to = handles[0].at + glm::dvec2(-0.03, 0.04);
    scene.probes[1] = dragged(scene, probe, to, 1.6);
    EXPECT_NEAR(glm::length(probe_handles(scene, 1.6)[0].at - to), 0, 1e-9);
    EXPECT_EQ(handle_at(probe_handles(scene, 1.6), to, {1000, 500}, 12), 1u);
    EXPECT_GT(probe_ball_radius(scene), 0);
}

TEST(Layout, APictureHasRoomOfItsOwn)
{
    const float em = 10;
    const Layout wide = lay_out({1000, 600}, {2000, 1200}, em, true, true);
    EXPECT_EQ(wide.panel_width, 250);
    EXPECT_EQ(wide.timeline_height, 24);
    EXPECT_EQ(wide.picture.at, glm::dvec2(250, 0));
    EXPECT_NEAR(wide.picture.size.x, 750, 1e-4);
    EXPECT_NEAR(wide.picture.size.y, 576, 1e-4);
    // Two pixels for a unit of the window; the framebuffer's rows begin at the bottom.
    EXPECT_EQ(wide.picture_pixels(), glm::ivec2(1500, 1152));
    EXPECT_EQ(wide.picture_lower_left(), glm::ivec2(500, 48));
    EXPECT_EQ(wide.picture.share({625, 288}), glm::dvec2(0.5));
    EXPECT_FALSE(wide.picture.holds({249, 10}));

    const Layout narrow = lay_out({440, 600}, {440, 600}, em, true, true);
    EXPECT_EQ(narrow.panel_width, 0) << "200 are the picture's at least";
    EXPECT_GT(narrow.timeline_height, 0) << "what the panel leaves is the timeline's";
    EXPECT_EQ(lay_out({290, 600}, {290, 600}, em, false, true).timeline_height, 0);
    EXPECT_EQ(lay_out({1000, 600}, {1000, 600}, em, false, false).picture.size,
              glm::dvec2(1000, 600));
    EXPECT_TRUE(lay_out({199, 600}, {199, 600}, em, false, false).too_small());
    EXPECT_FALSE(lay_out({200, 150}, {200, 150}, em, false, false).too_small());
}

/// A pointer over a picture of 160 x 100 units at (40, 0).
class PointerInputTest : public testing::Test {
protected:
    Change at(glm::dvec2 to) { return pointer_.handle(PointerMoved{to}, target()); }
    Change press(int button, bool shift = false)
    {
        return pointer_.handle(PointerButton{button, true, {.shift = shift}}, target());
    }
    Change release(int button)
    {
        return pointer_.handle(PointerButton{button, false, {}}, target());
    }
    PointerTarget target() { return {scene_, state_, {{40, 0}, {160, 100}}, whole_, over_panel_}; }

    Scene scene_ = lit_scene();
    const Camera first_ = scene_.camera;
    ViewState state_;
    bool whole_ = true, over_panel_ = false;
    PointerInput pointer_;
};

TEST_F(PointerInputTest, EachButtonMovesTheCameraInItsWay)
{
    const auto drag = [&](int button, bool shift) {
        scene_.camera = first_;
        EXPECT_EQ(at({100, 50}), Change::none);
        EXPECT_EQ(press(button, shift), Change::none);
        EXPECT_EQ(at({110, 45}), Change::view);
        release(button);
        EXPECT_EQ(at({150, 45}), Change::none) << "let go";
        return scene_.camera;
    };
    const Camera orbit = drag(0, false), look = drag(1, false), pan = drag(2, false);
    EXPECT_EQ(orbit.look_at, first_.look_at);
    EXPECT_NE(orbit.position, first_.position);
    EXPECT_EQ(look.position, first_.position);
    EXPECT_NE(look.look_at, first_.look_at);
    EXPECT_NE(pan.position, first_.position);
    EXPECT_NE(pan.look_at, first_.look_at);
    EXPECT_EQ(drag(0, true), pan) << "Shift pans";
    scene_.camera = first_;
    EXPECT_EQ(pointer_.handle(Wheel{1}, target()), Change::view);
    EXPECT_NEAR(distance(scene_.camera), 0.88 * distance(first_), 1e-9);
}

TEST_F(PointerInputTest, NothingBeginsBesideThePictureOverAPanelOrBeforeTheSceneIsWhole)
{
    const auto nothing_moves = [&](glm::dvec2 from) {
        at(from);
        EXPECT_EQ(pointer_.handle(Wheel{1}, target()), Change::none);
        press(0);
        EXPECT_EQ(at(from + glm::dvec2(20, 10)), Change::none);
        release(0);
        EXPECT_EQ(scene_.camera, first_);
    };
    nothing_moves({10, 50});
    over_panel_ = true;
    nothing_moves({100, 50});
    over_panel_ = false;
    whole_ = false;
    nothing_moves({100, 50});
    // A drag goes on over a panel, and pauses while another scene comes in.
    whole_ = true;
    at({100, 50});
    press(0);
    over_panel_ = true;
    EXPECT_EQ(at({20, 50}), Change::view);
    whole_ = false;
    EXPECT_EQ(at({30, 50}), Change::none);
}

TEST_F(PointerInputTest, TheLineOfASplitAndTheHandlesOfLightsGoBeforeTheCamera)
{
    state_.comparison = Comparison::split;
    at({124, 50});
    EXPECT_TRUE(pointer_.over_split(state_, target().picture));
    press(0);
    EXPECT_EQ(at({72, 50}), Change::none) << "the picture is shown in other parts, not drawn anew";
    EXPECT_DOUBLE_EQ(state_.wipe, 0.2);
    at({900, 50});
    EXPECT_EQ(state_.wipe, 1);
    release(0);

    state_.comparison = Comparison::none;
    const Area picture = target().picture;
    const auto handles = light_handles(scene_, picture.aspect());
    const glm::dvec2 handle = picture.at + handles[1].at * picture.size;
    const Light before = scene_.lights[handles[1].index];
    at(handle);
    press(0);
    at(handle + glm::dvec2(3, 2));
    release(0);
    EXPECT_EQ(scene_.lights[handles[1].index], before) << "its handle was not shown";
    scene_.camera = first_;
    state_.lights = true;
    at(handle);
    press(0);
    EXPECT_EQ(at(handle + glm::dvec2(3, 2)), Change::content);
    EXPECT_NE(scene_.lights[handles[1].index], before);
    EXPECT_EQ(scene_.camera, first_);
    scene_.lights.clear();  // in the panel, while its handle is held
    EXPECT_EQ(at(handle), Change::none);
    release(0);
    scene_.probes = {LightProbe{.position = scene_.camera.look_at}};
    const glm::dvec2 probe =
        picture.at + probe_handles(scene_, picture.aspect())[0].at * picture.size;
    at(probe);
    press(0);
    EXPECT_EQ(at(probe + glm::dvec2(3, 2)), Change::content);
    EXPECT_NE(scene_.probes[0].position, scene_.camera.look_at);
    EXPECT_EQ(scene_.camera, first_);
}

TEST_F(PointerInputTest, KeysFlyOnlyWhileOneLooksAround)
{
    Camera& camera = scene_.camera;
    EXPECT_FALSE(pointer_.take_key({GLFW_KEY_D})) << "it means a difference otherwise";
    EXPECT_EQ(pointer_.fly(0.1, camera), Change::none);
    at({100, 50});
    press(1);
    EXPECT_EQ(pointer_.fly(0.1, camera), Change::none) << "no key is held";
    EXPECT_TRUE(pointer_.take_key({GLFW_KEY_W}));
    EXPECT_EQ(pointer_.fly(0.1, camera), Change::view);
    const glm::dvec3 ahead = glm::normalize(first_.look_at - first_.position);
    const double flown = glm::dot(camera.position - first_.position, ahead);
    EXPECT_NEAR(flown, 0.05 * distance(first_), 1e-9);
    EXPECT_FALSE(pointer_.take_key({GLFW_KEY_F}));
    release(1);
    EXPECT_EQ(pointer_.fly(0.1, camera), Change::none);
    press(1);
    EXPECT_EQ(pointer_.fly(0.1, camera), Change::none) << "the key was let go with the button";
}

/// Takes what is loaded until the scene is whole. Returns the changes.
std::vector<Change> load(Document& document)
{
    std::vector<Change> changes;
    for (int i = 0; i < 3000 && !document.whole(); ++i) {
        if (const Change change = document.take_loaded(); change != Change::none)
            changes.push_back(change);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_TRUE(document.whole());
    while (document.loading())
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return changes;
}

command::SceneInput sample(const std::string& name)
{
    return {.file = FUM_TEST_DATA "/" + name, .size = "", .grid = "", .up = "auto"};
}

TEST(Document, IsReadInPartsAndStaysWhatItWasUntilTheNextIsThere)
{
    EXPECT_TRUE(Document({}).empty());
    Document document(sample("smoke_plume_sun.json"));
    EXPECT_FALSE(document.empty());
    EXPECT_FALSE(document.at_rest());
    EXPECT_THAT(load(document), testing::Each(Change::scene));
    EXPECT_TRUE(document.at_rest());
    EXPECT_TRUE(document.untouched());
    ASSERT_FALSE(document.scene().lights.empty());
    document.open("none.vdb");
    std::string error;
    for (int i = 0; i < 3000 && error.empty(); ++i) {
        try {
            document.take_loaded();
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        } catch (const Error& thrown) {
            error = thrown.what();
        }
    }
    EXPECT_THAT(error, HasSubstr("none.vdb"));
    EXPECT_TRUE(document.whole());
    EXPECT_THAT(document.input().file, HasSubstr("smoke_plume_sun.json"));
    document.scene().lights.clear();
    EXPECT_FALSE(document.untouched());
    EXPECT_FALSE(document.as_read().lights.empty());
}

TEST(Document, ATransparentIsSwitchedOffAndComesBackWhereItWas)
{
    Document document({});
    std::vector<Transparent> all;
    for (const double x : {0.0, 1.0, 2.0, 3.0}) {
        QuadTransparent quad;
        quad.corner.x = x;
        all.emplace_back(quad);
    }
    document.scene().transparents = all;
    document.switch_transparent(2, false);
    document.switch_transparent(0, false);
    EXPECT_EQ(document.scene().transparents, (std::vector<Transparent>{all[1], all[3]}));
    EXPECT_EQ(document.transparent_count(), 4u);
    for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_EQ(document.transparent(i), all[i]);
        EXPECT_EQ(document.is_on(i), i == 1 || i == 3);
    }
    document.remove_transparent(1);
    EXPECT_EQ(document.scene().transparents, std::vector<Transparent>{all[3]});
    EXPECT_FALSE(document.is_on(1)) << "all[2], which goes up";
    document.switch_transparent(1, true);
    document.switch_transparent(0, true);
    EXPECT_EQ(document.scene().transparents, (std::vector<Transparent>{all[0], all[2], all[3]}));
}

TEST(Document, AnotherFrameBringsItsGridsAndLeavesEditsAlone)
{
    Document document(sample("smoke_seq/smoke_####.vdb"));
    load(document);
    Sequence& sequence = document.sequence();
    ASSERT_TRUE(sequence.moves());
    EXPECT_EQ(sequence.shown(), 1);
    EXPECT_FALSE(document.untouched()) << "no one file is what is shown";
    EXPECT_EQ(document.play(0.1), Change::none) << "it does not play yet";
    auto& medium = std::get<GridMedium>(document.scene().media[0]);
    const auto first_grid = medium.density;
    medium.g = 0.7f;
    document.scene().camera.position += glm::dvec3(1, 0, 0);
    const Camera moved = document.scene().camera;
    const auto show_next = [&] {
        sequence.playback().act(Action::frame_on);
        EXPECT_TRUE(sequence.waits());
        EXPECT_FALSE(document.at_rest());
        Change change = Change::none;
        for (int i = 0; i < 3000 && change == Change::none; ++i) {
            change = document.play(0);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        EXPECT_EQ(change, Change::frame);
    };
    show_next();
    EXPECT_EQ(sequence.shown(), 2);
    EXPECT_TRUE(document.at_rest());
    const auto& second = std::get<GridMedium>(document.scene().media[0]);
    EXPECT_NE(second.density, first_grid);
    EXPECT_THAT(second.file, HasSubstr("0002"));
    EXPECT_EQ(second.g, 0.7f);
    EXPECT_EQ(document.scene().camera, moved);
    // What is saved is the sequence, with the edits, and begins where it did.
    const Scene saved = document.to_save();
    const auto& saved_medium = std::get<GridMedium>(saved.media[0]);
    EXPECT_THAT(saved_medium.file, HasSubstr("smoke_####.vdb"));
    EXPECT_EQ(saved_medium.g, 0.7f);
    EXPECT_EQ(saved.camera, moved);
    EXPECT_EQ(saved.time, document.as_opened().time);
    EXPECT_NE(saved.time, document.scene().time);
    // A camera that was not moved, or put back, is the scene's own.
    document.scene().camera = document.as_read().camera;
    show_next();
    EXPECT_EQ(document.scene().camera, document.as_read().camera);
}

TEST(Sequence, SpansAllOfItsFilesOrElseTheCamerasPath)
{
    const TempFolder folder;
    for (const char* name : {"a_03.vdb", "a_07.vdb", "b_5.vdb", "b_9.vdb"})
        folder.write(name, "");
    GridMedium a, b;
    a.file = (folder.path() / "a_##.vdb").string();
    b.file = (folder.path() / "b_#.vdb").string();
    Scene scene;
    scene.media = {a, b};
    EXPECT_EQ(frames_in(scene), std::pair(3, 9));
    scene.media.clear();
    EXPECT_EQ(frames_in(scene), std::nullopt);
    scene.frames_per_second = 10;
    scene.camera_path = {CameraKey{0, {}}, CameraKey{1.55, {}}};
    EXPECT_EQ(frames_in(scene), std::pair(0, 16));
    EXPECT_FALSE(Sequence().moves());
    EXPECT_FALSE(Sequence().waits());
}

TEST(ExposureDue, IsChosenAtOnceForANewSceneAndOnceMoreWhenThatIsSharp)
{
    ExposureDue due;
    EXPECT_TRUE(due.now(false));
    due.chosen(false);
    EXPECT_FALSE(due.now(false));
    EXPECT_TRUE(due.now(true));
    due.chosen(true);
    EXPECT_FALSE(due.now(true)) << "it does not follow the camera";
    due.note(Change::view);
    due.note(Change::frame);
    EXPECT_FALSE(due.now(true));
    due.note(Change::content);
    EXPECT_FALSE(due.now(false));
    EXPECT_TRUE(due.now(true));
    due.note(Change::scene);
    EXPECT_TRUE(due.now(false));
}

/// Follows the reference until it is whole.
void follow_to_the_end(ReferenceView& view, const Scene& scene, double tolerance)
{
    for (int i = 0; i < 3000 && !view.picture().whole; ++i) {
        view.follow(scene, tolerance, 0, false, 10.0 + i);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_TRUE(view.picture().whole) << view.picture().error;
}

TEST(ReferenceView, IsAskedForAtRestAndMeasuresEachPictureOnce)
{
    Scene scene = lit_scene();
    scene.resolution = {12, 8};
    scene.world.radiance = glm::vec3(1);
    ReferenceView view;
    view.follow(scene, 0.1, 0, true, 0);
    EXPECT_FALSE(view.busy()) << "not for each step of a drag";
    follow_to_the_end(view, scene, 0.1);
    EXPECT_EQ(view.picture().share, 1);
    const Image truth = view.image();
    ASSERT_EQ(truth.pixels.size(), 12u * 8 * 3);
    EXPECT_TRUE(view.unmeasured());
    Image brighter = truth, small = truth;
    for (float& value : brighter.pixels)
        value *= 1.5f;
    small.pixels.resize(3);
    view.measure({{"A", truth}, {"B", brighter}, {"of another size", small}});
    ASSERT_EQ(view.errors().size(), 2u);
    EXPECT_EQ(view.errors()[0].metrics.relmse, 0);
    EXPECT_NEAR(view.errors()[1].metrics.bias, 0.5, 1e-5);
    EXPECT_FALSE(view.unmeasured());
    view.outdate_errors();
    EXPECT_TRUE(view.unmeasured()) << "other settings, the same truth";
    // The same again asks for nothing; another camera does.
    view.follow(scene, 0.1, 0, false, 1e6);
    EXPECT_FALSE(view.busy());
    EXPECT_EQ(view.errors().size(), 2u);
    scene.camera.position.x += 0.1;
    view.follow(scene, 0.1, 0, true, 2e6);
    EXPECT_TRUE(view.errors().empty());
    view.drop();
    EXPECT_EQ(view.picture().version, 0u);
}

TEST(Notices, ANoteGoesAndAMessageStays)
{
    Notices notices;
    notices.show_message("lost");
    notices.show_note("wrote x.png");
    notices.pass(3);
    EXPECT_EQ(notices.note(), "wrote x.png");
    notices.pass(2);
    EXPECT_EQ(notices.note(), "");
    EXPECT_EQ(notices.message(), "lost");
    notices.close_message();
    EXPECT_EQ(notices.message(), "");
}

TEST(Saving, ANameIsNoFilesYet)
{
    const TempFolder folder;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    EXPECT_EQ(unused_name("/x/smoke_####.vdb", ".png"), "smoke_.png");
    folder.write("smoke.png", "");
    folder.write("smoke_2.png", "");
    EXPECT_EQ(unused_name("/x/smoke.vdb", ".png"), "smoke_3.png");
    EXPECT_EQ(unused_name("/x/smoke.vdb", ".exr"), "smoke.exr");
    std::filesystem::current_path(before);
}

TEST(Automation, ARunEndsAfterItsFramesOrWithItsPicture)
{
    Automation person({}, 0, "");
    EXPECT_FALSE(person.active());
    EXPECT_FALSE(person.ends(true));
    Automation counted({}, 2, "");
    EXPECT_TRUE(counted.active());
    EXPECT_FALSE(counted.ends(true));
    EXPECT_TRUE(counted.ends(false));
    EXPECT_FALSE(counted.request_last_screenshot());
    Automation shot({}, 0, "x.png");
    EXPECT_FALSE(shot.ends(false));
    EXPECT_TRUE(shot.ends(true));
    EXPECT_TRUE(shot.request_last_screenshot());
    EXPECT_THROW(shot.check_screenshots(), Error) << "no frame took it";
    EXPECT_THAT(shot.take_screenshots(), ElementsAre("x.png"));
    shot.check_screenshots();
    const TempFolder folder;
    Automation scripted(Script::read(folder.write("s.json", R"([{"frames": 1}])")), 1, "");
    EXPECT_FALSE(scripted.ends(true)) << "frames count after the script";
}

TEST(ViewState, ActionsChangeWhatIsShown)
{
    ViewState state;
    EXPECT_FALSE(change_view(state, Action::fit));
    EXPECT_TRUE(change_view(state, Action::split));
    EXPECT_EQ(state.comparison, Comparison::split);
    change_view(state, Action::difference);
    EXPECT_EQ(state.comparison, Comparison::difference);
    change_view(state, Action::difference);
    EXPECT_FALSE(state.compares());
    change_view(state, Action::reference);
    EXPECT_TRUE(state.wants_reference());
    change_view(state, Action::froxel);
    EXPECT_FALSE(state.wants_reference());
    EXPECT_EQ(state.settings.mode, Settings::Mode::froxel);
    // Through all that can be seen inside, and back to the picture; a march has no froxels.
    const auto count_kinds = [&] {
        int kinds = 0;
        for (change_view(state, Action::see_inside); state.inspection && kinds < 100;
             change_view(state, Action::see_inside))
            ++kinds;
        return kinds;
    };
    const int kinds = static_cast<int>(inspection_table().size());
    EXPECT_EQ(count_kinds(), kinds);
    state.inspection = Inspection{.kind = Inspection::Kind::froxel_slice};
    EXPECT_EQ(state.frames_at_rest(), 1);
    EXPECT_EQ(display_of(state).transform, Display::Transform::srgb);
    change_view(state, Action::raymarch);
    EXPECT_FALSE(state.inspection);
    EXPECT_EQ(state.frames_at_rest(), state.aa);
    EXPECT_EQ(count_kinds(), kinds - 1);
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
        pace.begin(Change::view, 0.03);
        pace.end(cost());
    }
    EXPECT_TRUE(pace.moving());
    EXPECT_LE(cost(), 30);
    EXPECT_GT(cost(), 3) << "more than was needed was lost";
    int frames = 0;
    while (!pace.full() && frames < 100) {
        pace.begin(Change::none, 0.03);
        pace.end(cost());
        ++frames;
    }
    EXPECT_LT(frames, 20);
    EXPECT_FALSE(pace.moving());
    pace.begin(Change::view, 0.03);
    EXPECT_FALSE(pace.full()) << "what was learnt is kept";
}

TEST(Pace, LightIsFilledOverFramesWhileWhatItIsFilledFromMoves)
{
    const Settings asked;
    Pace pace(false);
    pace.begin(Change::view, 0.03);
    EXPECT_EQ(pace.settings(asked).field_fill, 1);
    pace.begin(Change::frame, 0.03);
    const Settings moving = pace.settings(asked);
    EXPECT_GT(moving.field_fill, 1);
    EXPECT_EQ(moving.ambient_volume_size, asked.ambient_volume_size) << "as fine as at rest";
    pace.begin(Change::none, 0.03);
    EXPECT_EQ(pace.settings(asked).field_fill, moving.field_fill) << "a sequence plays on";
    pace.begin(Change::none, 10);
    EXPECT_EQ(pace.settings(asked).field_fill, 1) << "at rest";
    pace.begin(Change::view, 0.03);
    EXPECT_EQ(pace.settings(asked).field_fill, 1) << "the camera alone";
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
    EXPECT_EQ(less.shadow_volume_size, 24);
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
    change_setting(state, "skip", "on");  // as a file of the release before has it
    const std::string line = command_line(state, "x.vdb", {320, 200}, "x y.png");
    EXPECT_THAT(line, HasSubstr("--size 320x200"));
    EXPECT_THAT(line, HasSubstr("-o 'x y.png'"));
    EXPECT_THAT(line, HasSubstr("--preset eevee2017 --mode froxel"));
    EXPECT_THAT(line, HasSubstr("--empty-space-skipping on"));
    Settings back = find_preset("eevee2017");
    back.mode = Settings::Mode::froxel;
    command::SettingsInput input;
    input.preset = "eevee2017";
    input.mode = "froxel";
    input.changed = {{"steps", "37"}, {"distribution", "0.3"}, {"empty-space-skipping", "on"}};
    EXPECT_EQ(command::parse_settings(input), state.settings);
    EXPECT_EQ(command::settings_words(state.settings, back),
              "--steps 37 --distribution 0.3 --empty-space-skipping on");
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
    what.file = file;
    remember(what);
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

TEST(GlfwWindow, ItsSizeIsKeptOnAScreenOfAnyScale)
{
    for (const double scale : {1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 3.0})
        for (int width = 200; width < 1400; ++width) {
            // A unit is a dot: GLFW multiplies by the scale, and cuts off.
            const glm::ivec2 given(width, 800);
            const glm::ivec2 made(glm::dvec2(given) * scale);
            ASSERT_EQ(unscaled(made, made, scale), given) << scale;
        }
    // Where the system scales, the framebuffer alone is larger.
    EXPECT_EQ(unscaled({1280, 800}, {2560, 1600}, 2), glm::ivec2(1280, 800));
    EXPECT_EQ(unscaled({0, 0}, {0, 0}, 2), glm::ivec2(0));  // minimised
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
