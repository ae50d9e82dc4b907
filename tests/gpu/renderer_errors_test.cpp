// What a host or a scene does wrong: the documented Error, and a Renderer that works on.

#include <fmt/format.h>

#include "gl/texture.h"
#include "shared/bindings.h"
#include "support/gl_test.h"
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

class RendererErrors : public GlTest {
protected:
    /// The message of the Error that `call` throws, which must hold `part` and be one line.
    template <typename Call> static void expect_error(const Call& call, const std::string& part)
    {
        try {
            call();
            ADD_FAILURE() << "no error; expected: " << part;
        } catch (const Error& error) {
            const std::string what = error.what();
            EXPECT_NE(what.find(part), std::string::npos) << what;
            EXPECT_EQ(what.find('\n'), std::string::npos) << what;
        }
    }

    static BoxMedium fog()
    {
        BoxMedium medium;
        medium.min = {-1, -6, -1};
        medium.max = {1, -4, 1};
        medium.sigma_s = glm::vec3(0.2f);
        return medium;
    }
    static std::shared_ptr<VoxelGrid> grid()
    {
        auto g = std::make_shared<VoxelGrid>();
        g->name = "grid";
        g->bricks = {{0, 0, 0}};
        g->values.assign(512, 0.5f);
        g->index_min = {0, 0, 0};
        g->index_max = {7, 7, 7};
        g->active_voxels = 512;
        g->max_value = 0.5f;
        return g;
    }
    static Settings settings()
    {
        Settings s;
        s.shadow_map = 16;
        s.steps = 8;
        s.bounces = 0;
        return s;
    }

    /// After a scene that was refused, a good one gives the picture that it gives a new Renderer.
    static void expect_works_on(Renderer& renderer)
    {
        Scene scene = empty_scene(16);
        scene.media = {fog()};
        scene.lights = {SunLight{}};
        scene.surfaces = {SphereSurface{{0, -7, 0}, 0.5, glm::vec3(0.5f)}};
        Renderer fresh(get_proc());
        std::vector<std::vector<float>> pictures;
        for (Renderer* one : {&fresh, &renderer}) {
            Target target(scene);
            one->set_scene(scene, settings());
            one->draw_surfaces(target.frame, settings(), true);
            View view = one->make_view();
            one->composite(view, target.frame, settings());
            pictures.push_back(target.color.read(4));
        }
        EXPECT_EQ(pictures[0], pictures[1]);
    }

    struct Target {
        explicit Target(const Scene& scene)
            : color{gl::Texture::make_2d(gl(), "picture", glm::ivec2(scene.resolution), GL_RGBA16F,
                                         gl::Filter::nearest)},
              depth{gl::Texture::make_2d(gl(), "depth", glm::ivec2(scene.resolution),
                                         GL_DEPTH_COMPONENT32F, gl::Filter::nearest)}
        {
            frame.color = color.view();
            frame.depth = depth.view();
            frame.depth_convention = {.zero_to_one = true, .reversed = true};
            frame.view_from_world = view_from_world(scene.camera);
            frame.clip_from_view = clip_from_view(scene.camera, scene.resolution, {0, 0});
        }
        gl::Texture color, depth;
        Frame frame;
    };
};

TEST_F(RendererErrors, TooManyLights)
{
    Renderer renderer(get_proc());
    Scene scene = empty_scene();
    scene.lights.assign(MAX_LIGHTS, PointLight{});
    scene.media = {fog()};
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    scene.lights.push_back(PointLight{});
    expect_error([&] { renderer.set_scene(scene, settings()); },
                 fmt::format("{} lights, and {} is the most", MAX_LIGHTS + 1, MAX_LIGHTS));
    // Dark ones don't count.
    std::get<PointLight>(scene.lights.back()).radiant_intensity = glm::vec3(0);
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    expect_works_on(renderer);
}

TEST_F(RendererErrors, AfterARefusalNothingIsLeftOfTheScene)
{
    // A host may catch the error and draw on: then with no medium, and the picture keeps its bits.
    Scene scene = empty_scene(16);
    scene.media.assign(MAX_MEDIA + 1, fog());
    scene.lights.assign(MAX_LIGHTS, PointLight{{0, -5, 0}, glm::vec3(1)});
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    expect_error([&] { renderer.set_scene(scene, settings()); }, "media");
    Target target(scene);
    renderer.draw_surfaces(target.frame, settings(), true);
    const std::vector<float> before = target.color.read(4);
    renderer.composite(view, target.frame, settings());
    EXPECT_EQ(before, target.color.read(4));
}

TEST_F(RendererErrors, TooManyMedia)
{
    Renderer renderer(get_proc());
    Scene scene = empty_scene();
    scene.media.assign(MAX_MEDIA, fog());
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    scene.media.push_back(fog());
    expect_error([&] { renderer.set_scene(scene, settings()); },
                 fmt::format("{} media, and {} is the most", MAX_MEDIA + 1, MAX_MEDIA));
    // Those that do nothing don't count.
    std::get<BoxMedium>(scene.media.back()).sigma_s = glm::vec3(0);
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    expect_works_on(renderer);
}

TEST_F(RendererErrors, TooManyGrids)
{
    Renderer renderer(get_proc());
    const int most = std::min(
        MAX_GRIDS, (renderer.device().capabilities().max_texture_units - MOST_SAMPLED) / 2);
    ASSERT_GE(most, 4);
    Scene scene = empty_scene();
    const auto add = [&] {
        GridMedium medium;
        medium.density = grid();
        scene.media.emplace_back(medium);
    };
    for (int i = 0; i < most; ++i)
        add();
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    const std::uint64_t bytes = renderer.device().bytes();
    add();
    expect_error([&] { renderer.set_scene(scene, settings()); },
                 fmt::format("more than {} grids", most));
    // Twice the same grid in the same place is one.
    std::get<GridMedium>(scene.media.back()).density =
        std::get<GridMedium>(scene.media.front()).density;
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    EXPECT_EQ(renderer.device().bytes(), bytes);
    expect_works_on(renderer);
}

TEST_F(RendererErrors, GridsThatTheGlCantHold)
{
    Renderer renderer(get_proc());
    auto huge = grid();
    const int far = renderer.device().capabilities().max_texture_3d;
    huge->bricks.push_back({far / 8, 0, 0});
    huge->values.resize(1024, 0.5f);
    huge->index_max.x = far + 7;
    GridMedium medium;
    medium.density = huge;
    Scene scene = empty_scene();
    scene.media = {medium};
    Settings dense = settings();
    dense.layout = medium::Layout::dense;
    expect_error([&] { renderer.set_scene(scene, dense); }, "bricks");
    EXPECT_NO_THROW(renderer.set_scene(scene, settings()));
    expect_works_on(renderer);
}

TEST_F(RendererErrors, FramesThatAreNone)
{
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    Scene scene = empty_scene(16);
    scene.media = {fog()};
    renderer.set_scene(scene, settings());
    Target target(scene);
    const auto expect_refused = [&](const Frame& frame, const std::string& part) {
        expect_error([&] { renderer.composite(view, frame, settings()); }, part);
        expect_error([&] { renderer.inspect(view, frame, settings(), {}); }, part);
        expect_error([&] { renderer.draw_surfaces(frame, settings(), true); }, part);
        if (part.find("can't draw") == std::string::npos) {
            expect_error([&] { renderer.read_layers(view, frame, settings()); }, part);
            expect_error([&] { renderer.count_samples(view, frame, settings()); }, part);
        }
    };

    const gl::Texture wide =
        gl::Texture::make_2d(gl(), "wide", {17, 16}, GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    Frame frame = target.frame;
    frame.depth = wide.view();
    expect_refused(frame, "colour (16 x 16) and depth (17 x 16) must be textures of one size");
    frame = target.frame;
    frame.color = {};
    expect_refused(frame, "must be textures of one size");

    frame = target.frame;
    frame.clip_from_view = glm::dmat4(0);
    expect_refused(frame, "clip_from_view is no projection");
    frame = target.frame;
    frame.depth_convention.reversed = false;
    expect_refused(frame, "does not match depth_convention");

    // A colour that can't be drawn to: depth.
    const gl::Texture not_color = gl::Texture::make_2d(gl(), "no colour", {16, 16},
                                                       GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    frame = target.frame;
    frame.color = not_color.view();
    gl()->Disable(GL_DEBUG_OUTPUT);  // the GL complains too
    expect_refused(frame, "can't draw to the colour texture given");
    gl()->Enable(GL_DEBUG_OUTPUT);
    expect_works_on(renderer);
}

Scene noise_in_a_sun(BoxMedium cloud)
{
    Scene scene = empty_scene(8);
    cloud.profile = NoiseProfile{};
    cloud.sigma_s = glm::vec3(1);
    scene.media = {cloud};
    scene.lights = {SunLight{}};
    return scene;
}

/// More turns of loops than llvmpipe takes.
Settings too_many_steps(Settings many)
{
    many.steps = 1000;
    many.shadow_steps = 100;
    many.shadow_volume_size = 0;
    return many;
}

// llvmpipe ends a shader's loops after 65535 turns in all, without a word: what would be too thin
// a fog is refused. No other GL is known to end any, so that elsewhere there is nothing to refuse.
TEST_F(RendererErrors, LoopsThatTheGlCutsOff)
{
    const bool llvmpipe = gl().capabilities().renderer.find("llvmpipe") != std::string::npos;
    ASSERT_EQ(gl().capabilities().max_loop_turns, llvmpipe ? 65535 : 0);
    if (!llvmpipe)
        GTEST_SKIP() << "only Mesa's llvmpipe limits loops, and this is "
                     << gl().capabilities().renderer;
    const Scene scene = noise_in_a_sun(fog());
    Settings many = too_many_steps(settings());
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, many);
    const Target target(scene);
    expect_error([&] { renderer.composite(view, target.frame, many); },
                 "lower FrameSettings::steps or FrameSettings::shadow_steps");
    many.steps = 64;
    renderer.composite(view, target.frame, many);
    many.steps = 1000;
    many.shadow_steps = 4;
    renderer.composite(view, target.frame, many);
    expect_works_on(renderer);
}

// Where no GL ends a loop there is nothing that prepare() can't compile, and the test is skipped.
// What prepare() can't compile it tells at once, and frames after it are as ever: of a renderer
// that still prepared all transparents would be taken to be seen.
TEST_F(RendererErrors, FramesThatCantBePreparedLeaveOthersAsTheyAre)
{
    if (gl().capabilities().max_loop_turns == 0)
        GTEST_SKIP() << "only Mesa's llvmpipe limits loops, and this is "
                     << gl().capabilities().renderer;
    Scene scene = noise_in_a_sun(fog());
    QuadTransparent behind_the_eye;
    behind_the_eye.corner = {0, 5, 0};
    behind_the_eye.look.blend = {Blend::Kind::factors, BlendFactor::dst_alpha, BlendFactor::one};
    scene.transparents = {behind_the_eye};
    Settings many = too_many_steps(settings());
    Renderer renderer(get_proc());
    renderer.set_scene(scene, many);
    const Target target(scene);
    expect_error([&] { renderer.prepare(target.frame, many); }, "lower FrameSettings::steps");
    many.steps = many.shadow_steps = 8;
    View view = renderer.make_view();
    renderer.composite(view, target.frame, many);
    EXPECT_THAT(renderer.explain(many),
                testing::Contains(testing::HasSubstr("the last view needed no lists")));
}

TEST_F(RendererErrors, MeshesThatAreNone)
{
    const auto triangle = [] {
        auto mesh = std::make_shared<Mesh>();
        mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh->normals.assign(3, {0, 0, 1});
        mesh->triangles = {0, 1, 2};
        return mesh;
    };
    auto beyond = triangle(), bare = triangle(), odd = triangle();
    beyond->triangles.insert(beyond->triangles.end(), {0, 1, 3});
    bare->normals.pop_back();
    odd->triangles.push_back(0);
    Renderer renderer(get_proc());
    const auto expect_refused = [&](const std::shared_ptr<const Mesh>& mesh, const char* part) {
        Scene scene = empty_scene();
        MeshSurface surface;
        surface.mesh = mesh;
        surface.emission = glm::vec3(1);
        scene.surfaces = {surface};
        expect_error([&] { renderer.set_scene(scene, settings()); }, part);
        scene.surfaces.clear();
        MeshTransparent transparent;
        transparent.mesh = mesh;
        scene.transparents = {transparent};
        expect_error([&] { renderer.set_scene(scene, settings()); }, part);
        expect_works_on(renderer);
    };
    expect_refused(beyond, "Mesh::triangles[5]: 3 is none of the 3 positions");
    expect_refused(bare, "Mesh::normals: 2 for 3 positions");
    expect_refused(odd, "Mesh::triangles: 4 indices");
}

TEST_F(RendererErrors, FroxelsThatTheGlCantHold)
{
    Scene scene = empty_scene(16);
    scene.resolution = {static_cast<unsigned>(gl().capabilities().max_texture_3d) + 8, 2};
    scene.media = {fog()};
    Settings froxels = settings();
    froxels.mode = Settings::Mode::froxel;
    froxels.tile = 1;
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, froxels);
    const Target target(scene);
    expect_error([&] { renderer.composite(view, target.frame, froxels); },
                 fmt::format("{} x 4 x 64 froxels", scene.resolution.x + 2));
    expect_error([&] { renderer.composite(view, target.frame, froxels); }, "FrameSettings::tile");
    expect_works_on(renderer);
}

TEST_F(RendererErrors, NoContext)
{
    expect_error([] { gl::Device([](const char*) -> GLADapiproc { return nullptr; }); },
                 "no context is current");
}

TEST_F(RendererErrors, PicturesLargerThanTheGlDrawsComeInParts)
{
    Scene scene = empty_scene();
    scene.resolution.x = static_cast<unsigned>(gl().capabilities().max_texture_2d) + 1;
    const Still still = render(scene, settings());
    EXPECT_EQ(still.width, static_cast<int>(scene.resolution.x));
    EXPECT_EQ(still.height, static_cast<int>(scene.resolution.y));
}

}  // namespace
}  // namespace fumarole::test
