// A frame never waits for the GPU and compiles nothing that was prepared: every GL function through
// which the library could wait is counted where it would.

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>

#include "gl/program.h"
#include "gl/texture.h"
#include "support/gl_test.h"
#include "support/host_draws.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

/// What was called that waits, or compiles, by name.
struct Watch {
    const gl::Device* gl = nullptr;
    gl::GetProc real = nullptr;
    std::map<std::string, int> waits, compiles;
    std::set<GLuint> orphaned;  ///< buffers whose contents were let go of and not written since

    void forget()
    {
        waits.clear();
        compiles.clear();
    }
};

Watch& watch()
{
    static Watch one;
    return one;
}

/// A GL function that is counted in a map of Watch, and then called.
/// @tparam Function of GladGLContext @tparam Counts whether a call with these arguments counts
template <auto Function, auto Map, auto Counts,
          typename Proc = std::decay_t<decltype(std::declval<GladGLContext>().*Function)>>
struct Counted;
template <auto Function, auto Map, auto Counts, typename R, typename... A>
struct Counted<Function, Map, Counts, R (*)(A...)> {
    static inline const char* name = "";
    static R GLAD_API_PTR call(A... arguments)
    {
        if (Counts(arguments...))
            ++(watch().*Map)[name];
        return (watch().gl->operator->()->*Function)(arguments...);
    }
};

template <auto Function, auto Map, auto Counts>
std::pair<const std::string, GLADapiproc> counted(const char* name)
{
    using One = Counted<Function, Map, Counts>;
    One::name = name;
    return {name, reinterpret_cast<GLADapiproc>(One::call)};
}

constexpr auto kAlways = [](auto...) { return true; };
constexpr auto kIntoMemory = [](auto...) {
    GLint buffer = 0;
    (*watch().gl)->GetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &buffer);
    return buffer == 0;
};
constexpr auto kNotThereYet = [](GLuint query, GLenum what, auto*) {
    GLuint available = GL_FALSE;
    (*watch().gl)->GetQueryObjectuiv(query, GL_QUERY_RESULT_AVAILABLE, &available);
    return what == GL_QUERY_RESULT && available == GL_FALSE;
};
constexpr auto kHasTime = [](GLsync, GLbitfield, GLuint64 timeout) { return timeout > 0; };
constexpr auto kSynchronized = [](auto, GLintptr, GLsizeiptr, GLbitfield access) {
    return (access & (GL_MAP_UNSYNCHRONIZED_BIT | GL_MAP_PERSISTENT_BIT)) == 0;
};
constexpr auto kAsksForResult = [](GLuint, GLenum what, GLint*) {
    return what == GL_LINK_STATUS || what == GL_COMPILE_STATUS;
};
/// Never counts itself.
constexpr auto kOrphans = [](GLuint buffer) {
    watch().orphaned.insert(buffer);
    return false;
};
/// What is in use is written where it is.
constexpr auto kInPlace = [](GLuint buffer, auto...) {
    return watch().orphaned.erase(buffer) == 0;
};

GLADapiproc watched_proc(const char* name)
{
    using G = GladGLContext;
    constexpr auto kWaits = &Watch::waits;
    constexpr auto kCompiles = &Watch::compiles;
    static const std::map<std::string, GLADapiproc> table{
        counted<&G::Finish, kWaits, kAlways>("glFinish"),
        counted<&G::ReadPixels, kWaits, kIntoMemory>("glReadPixels"),
        counted<&G::ReadnPixels, kWaits, kIntoMemory>("glReadnPixels"),
        counted<&G::GetTexImage, kWaits, kIntoMemory>("glGetTexImage"),
        counted<&G::GetnTexImage, kWaits, kIntoMemory>("glGetnTexImage"),
        counted<&G::GetTextureImage, kWaits, kIntoMemory>("glGetTextureImage"),
        counted<&G::GetTextureSubImage, kWaits, kIntoMemory>("glGetTextureSubImage"),
        counted<&G::GetQueryObjectiv, kWaits, kNotThereYet>("glGetQueryObjectiv"),
        counted<&G::GetQueryObjectuiv, kWaits, kNotThereYet>("glGetQueryObjectuiv"),
        counted<&G::GetQueryObjecti64v, kWaits, kNotThereYet>("glGetQueryObjecti64v"),
        counted<&G::GetQueryObjectui64v, kWaits, kNotThereYet>("glGetQueryObjectui64v"),
        counted<&G::ClientWaitSync, kWaits, kHasTime>("glClientWaitSync"),
        counted<&G::MapBuffer, kWaits, kAlways>("glMapBuffer"),
        counted<&G::MapNamedBuffer, kWaits, kAlways>("glMapNamedBuffer"),
        counted<&G::MapBufferRange, kWaits, kSynchronized>("glMapBufferRange"),
        counted<&G::MapNamedBufferRange, kWaits, kSynchronized>("glMapNamedBufferRange"),
        counted<&G::GetBufferSubData, kWaits, kAlways>("glGetBufferSubData"),
        counted<&G::GetNamedBufferSubData, kWaits, kAlways>("glGetNamedBufferSubData"),
        counted<&G::BufferSubData, kWaits, kAlways>("glBufferSubData"),
        counted<&G::NamedBufferSubData, kWaits, kInPlace>("glNamedBufferSubData"),
        counted<&G::InvalidateBufferData, kWaits, kOrphans>("glInvalidateBufferData"),
        counted<&G::LinkProgram, kCompiles, kAlways>("glLinkProgram"),
        counted<&G::CompileShader, kCompiles, kAlways>("glCompileShader"),
        counted<&G::GetProgramiv, kCompiles, kAsksForResult>("glGetProgramiv"),
        counted<&G::GetShaderiv, kCompiles, kAsksForResult>("glGetShaderiv")};
    const auto found = table.find(name);
    return found != table.end() ? found->second : watch().real(name);
}

std::string list(const std::map<std::string, int>& calls)
{
    std::string all;
    for (const auto& [name, count] : calls)
        all += fmt::format("{} x {}; ", name, count);
    return all;
}

class Blocking : public GlTest {
protected:
    static constexpr glm::ivec2 kSize{64, 64};

    Blocking()
        : color_{gl::Texture::make_2d(gl(), "picture", kSize, GL_RGBA16F, gl::Filter::nearest)},
          depth_{gl::Texture::make_2d(gl(), "depth", kSize, GL_DEPTH_COMPONENT32F,
                                      gl::Filter::nearest)}
    {
        watch() = {};
        watch().gl = &gl();
        watch().real = get_proc();
    }

    /// As a preset, with volumes and maps that are filled in no time.
    static Settings small(std::string_view preset)
    {
        Settings settings = find_preset(preset);
        settings.steps = std::min(settings.steps, 16);
        settings.slices = 16;
        settings.shadow_steps = 4;
        settings.shadow_map = 128;
        settings.shadow_volume_size = settings.shadow_volume_size == 0 ? 0 : 12;
        settings.ambient_volume_size = settings.ambient_volume_size == 0 ? 0 : 8;
        settings.world_directions = 26;
        return settings;
    }

    [[nodiscard]] Frame frame(const Scene& scene, std::uint64_t index) const
    {
        Frame frame;
        frame.color = color_.view();
        frame.depth = depth_.view();
        frame.depth_convention = {.zero_to_one = true, .reversed = true};
        frame.view_from_world = view_from_world(scene.camera);
        frame.clip_from_view = clip_from_view(scene.camera, glm::uvec2(kSize), {0, 0});
        frame.index = index;
        return frame;
    }

    static Scene sample(const char* file)
    {
        return asset::load_scene(std::string(FUM_TEST_DATA) + "/" + file).scene;
    }

    gl::Texture color_, depth_;
};

class BlockingByPreset : public Blocking, public testing::WithParamInterface<std::string_view> {};

INSTANTIATE_TEST_SUITE_P(Presets, BlockingByPreset,
                         testing::Values("default", "eevee2017", "froxel", "eevee2017-froxel"),
                         [](const auto& preset) {
                             std::string name(preset.param);
                             std::erase(name, '-');
                             return name;
                         });

TEST_F(Blocking, TheWatchSeesCallsThatWait)
{
    const gl::Device device(watched_proc);
    device->Finish();
    std::vector<float> texels(std::size_t{4} * kSize.x * kSize.y);
    device->GetTextureImage(color_.id(), 0, GL_RGBA, GL_FLOAT, GLsizei(texels.size() * 4),
                            texels.data());
    const GLsync fence = device->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    device->ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
    device->ClientWaitSync(fence, 0, 1);
    device->DeleteSync(fence);
    EXPECT_EQ(list(watch().waits), "glClientWaitSync x 1; glFinish x 1; glGetTextureImage x 1; ");
    gl::Program::compute(
        device, "nothing",
        gl::expand_text("nothing", "layout(local_size_x = 1) in; void main() {}", {}));
    EXPECT_EQ(list(watch().compiles), "glCompileShader x 1; glGetProgramiv x 1; glGetShaderiv x 1; "
                                      "glLinkProgram x 1; ");
}

TEST_P(BlockingByPreset, NoFrameOfAPlayingSequenceUnderAMovingSunWaits)
{
    const Settings settings = small(GetParam());
    asset::LoadedScene loaded{sample("smoke_seq.json"), {}};
    loaded.scene.surfaces.emplace_back(SphereSurface{{0.3, 0, 2.5}, 0.4, glm::vec3(0.5f)});
    std::get<GridMedium>(loaded.scene.media.front()).density = nullptr;
    std::vector<Scene> sequence;
    for (const char* file : {"smoke_0004.vdb", "smoke_0005.vdb", "smoke_0006.vdb"}) {
        asset::LoadedScene one = loaded;  // another file, nothing read of it yet
        auto& smoke = std::get<GridMedium>(one.scene.media.front());
        smoke.file = std::string(FUM_TEST_DATA) + "/smoke_seq/" + file;
        asset::load_scene_files(one);
        sequence.push_back(one.scene);
    }
    Renderer renderer(watched_proc);
    View view = renderer.make_view();
    renderer.set_timing(Timing::queries);
    constexpr std::uint64_t kLimit = 20000;  // a grid takes some frames
    int timed = 0, grids = 0;
    const HostPanes panes(gl());
    constexpr int kFrames = 75, kFirst = 6;
    for (int i = 0; i < kFirst + kFrames; ++i) {
        if (i == kFirst) {
            watch().forget();
            renderer.set_upload_limit(kLimit);
            grids = 0;
        }
        // Some of the first have media that stay, as those have that wait for the next.
        Scene scene = sequence[static_cast<std::size_t>(i < kFirst ? i / 3 : i) % sequence.size()];
        std::get<SunLight>(scene.lights.front()).direction_to_light = {std::cos(0.1 * i),
                                                                       std::sin(0.1 * i), 0.6};
        scene.camera.position.x += 0.02 * i;
        QuadTransparent pane;  // that moves, and whose lists grow
        pane.corner = {-1 - 0.05 * i, 0.2, 0.5};
        pane.edges = {glm::dvec3(2 + 0.1 * i, 0.3, 0), glm::dvec3(0, 0, 3)};
        pane.look.blend.kind = Blend::Kind::multiply;
        pane.look.filter = glm::vec3(0.9f);
        scene.transparents.assign(4, pane);
        Frame now = frame(scene, static_cast<std::uint64_t>(i));
        const HostPanes::Place place{pane.corner + glm::dvec3(0, 0.5, 0), pane.edges};
        now.transparents = {place.extent(now)};
        renderer.set_scene(scene, settings);
        renderer.draw_surfaces(now, settings, false);
        renderer.draw_surfaces(now, settings, true);
        renderer.begin_transparents(view, now, settings, HostPanes::kLists);
        for (unsigned k = 0; k < 4; ++k)
            panes.list(now, place, glm::vec4(0.1f), host_blend(1, 1), k);
        renderer.end_transparents(view);
        renderer.composite(view, now, settings);
        EXPECT_NE(view.volume_at().block, 0u);
        const FrameReport report = renderer.take_report();
        EXPECT_TRUE(report.pass_ms.empty() || report.timed_frame <= now.index);
        timed += report.pass_ms.empty() ? 0 : 1;
        grids += report.work.grids_uploaded;
        EXPECT_TRUE(i < kFirst || report.uploaded_bytes <= kLimit) << report.uploaded_bytes;
    }
    EXPECT_GT(grids, 2);
    EXPECT_LT(grids, kFrames / 2) << "each takes frames";
    EXPECT_EQ(list(watch().waits), "");
    EXPECT_EQ(list(watch().compiles), "");
    EXPECT_GT(timed, kFrames / 2) << "frames whose times have come to be known";
    const Frame last = frame(sequence.front(), 0);
    renderer.composite(view, last, settings);
    const std::vector<float> transmittance =
        renderer.read_layers(view, last, settings).transmittance;
    EXPECT_LT(*std::min_element(transmittance.begin(), transmittance.end()), 0.98f)
        << "there is smoke in it";
}

TEST_P(BlockingByPreset, TheFirstFrameAfterPrepareCompilesNothing)
{
    for (const bool temporal : {false, true}) {
        Settings settings = small(GetParam());
        if (temporal && settings.mode == Settings::Mode::froxel)
            break;  // they have their history either way
        settings.temporal = temporal;
        Scene scene = sample("smoke_glass.json");
        // A ball by which a probe is placed, captured in two of the frames.
        scene.surfaces.emplace_back(
            SphereSurface{.center = {1.5, -1, 0.6},
                          .radius = 0.5,
                          .gloss = Gloss{.roughness = 0.2f, .metallic = 1}});
        Renderer renderer(watched_proc);
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        Frame first = frame(scene, 0);
        first.transparents = {{.view_z = {1, 20}}};  // a host has some as well
        renderer.prepare(first, settings);
        EXPECT_FALSE(watch().compiles.empty());
        EXPECT_EQ(renderer.probes().size(), 1u) << renderer.probe_placement();
        watch().forget();
        Scene moving = scene;
        for (std::uint64_t i = 0; i < 6; ++i) {
            Frame now = frame(moving, i);
            now.transparents = first.transparents;
            renderer.draw_surfaces(now, settings, false);
            renderer.draw_surfaces(now, settings, true);
            if (i % 2 == 1) {
                renderer.begin_transparents(view, now, settings, {});
                renderer.end_transparents(view);
            }
            renderer.composite(view, now, settings);
            EXPECT_EQ(list(watch().compiles), "") << "frame " << i;
            moving.camera.position.x += i < 3 ? 0.0 : 0.1;
        }
        EXPECT_EQ(list(watch().waits), "");
        EXPECT_EQ(renderer.take_report().work.probes, 2);
        // Another scene, whose captures make nothing anew.
        moving.world.radiance *= 2.0f;
        renderer.set_scene(moving, settings);
        std::uint64_t made = 0;
        for (std::uint64_t i = 6; i < 9; ++i) {
            if (i == 7)  // the first sees that the scene has changed
                made = renderer.take_report().allocations;
            renderer.draw_surfaces(frame(moving, i), settings, true);
            renderer.composite(view, frame(moving, i), settings);
        }
        const FrameReport report = renderer.take_report();
        EXPECT_EQ(report.work.probes, 2);
        EXPECT_EQ(report.allocations, made);
    }
}

TEST_F(Blocking, PanesThatCastWholeInPiecesAndInListsCompileNothingAfterPrepare)
{
    const Settings settings = small("default");
    Scene scene = sample("smoke_panes.json");
    Renderer renderer(watched_proc);
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.prepare(frame(scene, 0), settings);
    EXPECT_FALSE(watch().compiles.empty());
    watch().forget();
    for (std::uint64_t i = 0; i < 6; ++i) {
        if (i == 2) {  // one that crosses them
            scene.transparents.emplace_back(
                QuadTransparent{{-3, 0, 1}, {glm::dvec3(2, 0, 0), glm::dvec3(0, 0, 4)}, {}});
            renderer.set_scene(scene, settings);
        }
        if (i == 4) {  // and more than there may be pieces of
            renderer.wait_until_ready();
            EXPECT_EQ(renderer.fragment_count(), FragmentCount{}) << "pieces";
            for (int k = 0; k < 40; ++k) {
                const glm::dvec3 a(4, 3 * std::cos(0.9 * k), 0), b(0, 3 * std::sin(0.9 * k), 4);
                scene.transparents.emplace_back(
                    QuadTransparent{{-2, -(a + b).y / 2 + 0.01 * k, 1}, {a, b}, {}});
            }
            renderer.set_scene(scene, settings);
        }
        const Frame now = frame(scene, i);
        renderer.draw_surfaces(now, settings, true);
        renderer.composite(view, now, settings);
        EXPECT_EQ(list(watch().compiles), "") << "frame " << i;
    }
    renderer.wait_until_ready();
    EXPECT_GT(renderer.fragment_count().fragments, 0u);
}

TEST_F(Blocking, SpritesThatComeAndGoCompileNothingAfterPrepare)
{
    const Settings settings = small("default");
    Scene scene = sample("smoke_glass.json");
    const std::vector<Transparent> kinds = scene.transparents;  // two panes, then sparks
    const auto spark = [&](std::size_t i) {
        auto one = std::get<BillboardTransparent>(kinds.at(2 + i % 4));
        one.center.y += 0.1 * double(i);
        return one;
    };
    scene.transparents = {kinds.front()};
    for (std::size_t i = 0; i < 11; ++i)
        scene.transparents.emplace_back(spark(i));
    // So many of them in view, the others beside it; then all, and the pane through them.
    const auto seen = [&](std::size_t sparks) {
        Scene one = scene;
        for (std::size_t i = 1 + sparks; i < one.transparents.size(); ++i)
            std::get<BillboardTransparent>(one.transparents[i]).center.x += 1000;
        return one;
    };
    Scene crosses = scene;
    std::get<QuadTransparent>(crosses.transparents.front()).edges[0] = {3, 2, 0};
    std::get<QuadTransparent>(scene.transparents.front()).corner = {-2, 2, 0};
    std::get<QuadTransparent>(scene.transparents.front()).edges[0] = {4, 0.2, 0};
    Renderer renderer(watched_proc);
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.prepare(frame(scene, 0), settings);
    EXPECT_FALSE(watch().compiles.empty());
    watch().forget();
    std::uint64_t i = 0;
    for (const Scene& one : {seen(11), seen(5), seen(0), crosses}) {
        renderer.set_scene(one, settings);
        for (int again = 0; again < 2; ++again) {
            const Frame now = frame(one, i++);
            renderer.draw_surfaces(now, settings, true);
            renderer.composite(view, now, settings);
            EXPECT_EQ(list(watch().compiles), "") << "frame " << i;
        }
        renderer.wait_until_ready();
        EXPECT_EQ(renderer.fragment_count(), FragmentCount{}) << i;
    }
}

TEST_F(Blocking, AShadowMapComesBackWithoutAWaitAndTheWaitGivesThePictureOfAStill)
{
    const Settings settings = small("default");
    const Scene scene = sample("smoke_plume_sun.json");
    const auto draw = [&](Renderer& renderer, View& view) {
        const Frame now = frame(scene, 0);
        renderer.draw_surfaces(now, settings, true);
        renderer.composite(view, now, settings);
        return color_.read(4);
    };
    Renderer waits(watched_proc);
    waits.set_scene(scene, settings);
    waits.wait_until_ready();
    EXPECT_FALSE(watch().waits.empty()) << "it says that it waits";
    View waiting = waits.make_view();
    const std::vector<float> still = draw(waits, waiting);

    watch().forget();
    Renderer renderer(watched_proc);
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    std::vector<float> picture;
    for (int i = 0; i < 100 && picture != still; ++i)
        picture = draw(renderer, view);
    EXPECT_EQ(picture, still);
    EXPECT_EQ(list(watch().waits), "");
}

}  // namespace
}  // namespace fumarole::test
