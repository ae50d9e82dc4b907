// What passes run as makes no other picture: fragments and compute shaders (FrameSettings::passes),
// bit for bit, since both are the same lines of GLSL on the same numbers. Where the blending stage
// has its own arithmetic, as for integers, the bound says so.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <random>
#include <set>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "shared/bindings.h"
#include "shared/field_nodes.h"
#include "shared/field_params.h"
#include "shared/frame_params.h"
#include "shared/step_tile.h"
#include "shared/tile_list.h"
#include "study/stability_bench.h"
#include "support/gl_test.h"

namespace fumarole::test {
namespace {

using namespace fumarole::shared;
using Passes = Settings::Passes;

/// Coloured smoke in bricks, some of the picture and not all, before a ball and over a floor.
Scene smoke_over_floor()
{
    Scene scene = empty_scene();
    scene.resolution = {45, 27};  // no multiples of a group's 8 pixels
    scene.camera.vfov_deg = 30;
    scene.world.radiance = {0.1f, 0.2f, 0.3f};
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 3, 3}}, PointLight{{1, -5, 0.5}, {2, 3, 4}}};
    GridMedium smoke;
    smoke.density = study::make_grid({2, 1, 1}, glm::dmat4(0.1), [](glm::ivec3 at) {
        return 0.2 + (at.x * 37 + at.y * 11 + at.z * 5) % 101 / 101.0;
    });
    auto placed = std::make_shared<VoxelGrid>(*smoke.density);
    placed->world_from_index[3] = {-0.8, -6, -0.4, 1};
    smoke.density = placed;
    smoke.sigma_s_per_density = {1, 2, 3};
    smoke.g = 0.3f;
    scene.media = {smoke};
    scene.surfaces = {BoxSurface{{-9, -20, -1.2}, {9, 0, -1}, {0.5f, 0.4f, 0.3f}},
                      SphereSurface{{0.3, -5.5, 0}, 0.3, {0.6f, 0.6f, 0.6f}}};
    return scene;
}

Scene grey(Scene scene)
{
    std::get<GridMedium>(scene.media.front()).sigma_s_per_density = glm::vec3(2);
    return scene;
}

Scene behind_glass(Scene scene)
{
    QuadTransparent glass;
    glass.corner = {-1, -5, -1};
    glass.edges = {glm::dvec3(2, -1.5, 0), glm::dvec3(0, 0, 2)};
    glass.look.blend.kind = Blend::Kind::multiply;
    glass.look.filter = {0.5f, 0.9f, 0.7f};
    scene.transparents = {glass};
    return scene;
}

Settings small(Settings settings = {})
{
    settings.slices = 16;
    settings.tile = 4;
    settings.shadow_map = 64;
    settings.steps = 24;
    settings.shadow_steps = 4;
    settings.bounces = 0;
    settings.shadow_volume_size = settings.shadow_volume_size == 0 ? 0 : 12;
    settings.ambient_volume_size = settings.ambient_volume_size == 0 ? 0 : 6;
    return settings;
}

/// All that a frame leaves.
struct Drawn {
    std::vector<float> picture;
    std::vector<float> scattering, transmittance;  ///< of the layer itself, or the froxels
    LayerImages layers;
    std::string passes;
};

class PassForms : public GlTest {
protected:
    /// A host's picture of a scene.
    struct Host {
        Host(const Scene& scene, GLenum format)
            : color{gl::Texture::make_2d(gl(), "colour", glm::ivec2(scene.resolution), format,
                                         gl::Filter::linear)},
              depth{gl::Texture::make_2d(gl(), "depth", glm::ivec2(scene.resolution),
                                         GL_DEPTH_COMPONENT32F, gl::Filter::nearest)}
        {
            frame.color = color.view();
            frame.depth = depth.view();
            frame.depth_convention = {.zero_to_one = true, .reversed = true};
            look(scene, scene.camera);
        }
        void look(const Scene& scene, const Camera& camera)
        {
            frame.view_from_world = view_from_world(camera);
            frame.clip_from_view = clip_from_view(camera, scene.resolution, {0, 0});
        }
        gl::Texture color, depth;
        Frame frame;
    };

    PassForms() : renderer_{get_proc()} {}

    void set(const Scene& scene, const Settings& settings)
    {
        scene_ = scene;
        renderer_.set_scene(scene, settings);
        renderer_.wait_until_ready();
    }

    /// Some frames of a camera that goes aside; of the last what it leaves.
    Drawn draw(Settings settings, Passes passes, GLenum format = GL_RGBA32F, int frames = 1)
    {
        settings.passes = passes;
        Host host(scene_, format);
        Frame& frame = host.frame;
        View view = renderer_.make_view();
        for (int i = 0; i < frames; ++i) {
            Camera camera = scene_.camera;
            camera.position.x += 0.03 * i;
            camera.look_at.x += 0.03 * i;
            host.look(scene_, camera);
            frame.index = static_cast<std::uint64_t>(i);
            renderer_.draw_surfaces(frame, settings, true);
            renderer_.composite(view, frame, settings);
        }
        Drawn drawn;
        drawn.passes = renderer_.take_report().passes;
        drawn.picture = host.color.read(4);
        const OwnLayers own = view.own_layers();
        if (own.scattering)
            drawn.scattering = gl::read_texture(gl(), own.scattering, 4);
        if (own.transmittance)
            drawn.transmittance = gl::read_texture(gl(), own.transmittance, 4);
        drawn.layers = renderer_.read_layers(view, frame, settings);
        return drawn;
    }

    /// Bit for bit on a software rasteriser, but for a last bit of the logarithms and exponentials
    /// of a lookup of froxels, which it orders by the lanes that it has. A GPU's compiler may
    /// contract a product and a sum in one form of a pass and not in the other, which a rounding
    /// to the layer's format shows: a step of it, of 5 bits in the smallest, or what a few dozen
    /// steps make of 24.
    static void expect_same_values(const std::vector<float>& a, const std::vector<float>& b,
                                   const Settings& settings, const std::string& what)
    {
        using Format = Settings::Format;
        ASSERT_EQ(a.size(), b.size()) << what;
        const bool froxel = settings.mode == Settings::Mode::froxel;
        const float step = gl().capabilities().software            ? (froxel ? 0x1p-22f : 0.0f)
                           : settings.format == Format::r11g11b10f ? 0x1p-5f
                           : settings.format == Format::rgba16f    ? 0x1p-9f
                                                                   : 1e-4f;
        std::size_t differ = 0;
        float most = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const float difference = std::abs(a[i] - b[i]);
            differ += difference <= step * std::max(std::abs(a[i]), 1.0f) ? 0 : 1;
            most = std::max(most, difference);
        }
        EXPECT_EQ(differ, 0u) << what << ": of " << a.size() << " numbers, by " << most;
    }

    /// Both forms of a frame. @returns what compute left
    Drawn expect_same(const Settings& settings, const std::string& name, int frames = 1)
    {
        const Drawn fragments = draw(settings, Passes::fragment, GL_RGBA32F, frames);
        Drawn compute = draw(settings, Passes::compute, GL_RGBA32F, frames);
        const auto compare = [&](const auto& of, const char* what) {
            expect_same_values(of(fragments), of(compute), settings,
                               fmt::format("{}, {}", name, what));
        };
        compare([](const Drawn& d) { return d.picture; }, "picture");
        compare([](const Drawn& d) { return d.scattering; }, "layer's scattering");
        compare([](const Drawn& d) { return d.transmittance; }, "layer's transmittance");
        compare([](const Drawn& d) { return d.layers.scattering; }, "scattering");
        compare([](const Drawn& d) { return d.layers.transmittance; }, "transmittance");
        EXPECT_EQ(fragments.passes, "fragments") << name;
        EXPECT_EQ(compute.passes, "compute shaders") << name;
        return compute;
    }

    double count(Settings settings, Passes passes)
    {
        settings.passes = passes;
        View view = renderer_.make_view();
        return renderer_.count_samples(view, Host(scene_, GL_RGBA32F).frame, settings);
    }

    Renderer renderer_;
    Scene scene_;
};

TEST_F(PassForms, EveryPresetAndTargetFormatDrawsTheSamePicture)
{
    const Scene scene = smoke_over_floor();
    for (const auto& [name, preset] : presets()) {
        Settings settings = small(preset);
        set(scene, settings);
        for (const Settings::Format format :
             {Settings::Format::r11g11b10f, Settings::Format::rgba16f, Settings::Format::rgba32f}) {
            settings.format = format;
            const Drawn drawn =
                expect_same(settings, fmt::format("{}, format {}", name, static_cast<int>(format)));
            EXPECT_LT(*std::min_element(drawn.layers.transmittance.begin(),
                                        drawn.layers.transmittance.end()),
                      0.9f);
        }
    }
}

TEST_F(PassForms, DrawTheSameWithAHistoryOfEachKindOfLayerAndAmidTransparents)
{
    for (const bool is_grey : {false, true}) {
        const Scene scene = smoke_over_floor();
        Settings settings = small();
        settings.temporal = true;
        set(behind_glass(is_grey ? grey(scene) : scene), settings);
        expect_same(settings, is_grey ? "grey, moving" : "coloured, moving", 3);
        EXPECT_EQ(renderer_.fragment_count(), FragmentCount{}) << "a pane in order is in no list";
        settings.temporal = false;
        settings.resolution = 1;
        expect_same(settings, is_grey ? "grey, full" : "coloured, full");
    }
}

TEST_F(PassForms, DrawTheSameOfParallelRaysAndNothingWhereNoMediumIsSeen)
{
    Scene scene = grey(smoke_over_floor());
    scene.camera.projection = Camera::Projection::orthographic;
    scene.camera.ortho_height = 3;
    const Settings settings = small();
    set(scene, settings);
    expect_same(settings, "orthographic");
    EXPECT_EQ(count(settings, Passes::compute), count(settings, Passes::fragment));
    EXPECT_GT(count(settings, Passes::compute), 100);
    scene_.camera.look_at = {0, 100, 0};
    expect_same_values(draw(settings, Passes::fragment).picture,
                       draw(settings, Passes::compute).picture, settings, "away");
    EXPECT_EQ(count(settings, Passes::compute), 0);
}

TEST_F(PassForms, CountHowEvenlyRaysEvaluateTheMedia)
{
    constexpr int kSize = 32;
    Scene scene = study::bare_scene(kSize);
    BoxMedium slab = study::slab(3, 9);
    slab.sigma_s = glm::vec3(0.1f);
    scene.media = {slab};
    Settings settings = small();
    settings.resolution = 1;
    settings.spacing = Settings::Spacing::fixed;
    set(scene, settings);
    const auto count = [&](int stripe, Passes passes) {
        settings.passes = passes;
        const Host host(scene_, GL_RGBA32F);
        std::vector<float> depths(kSize * kSize, 0.0f);  // the sky's, as depth is reversed
        for (int i = 0; i < kSize * kSize && stripe > 0; ++i)
            if (i % kSize / stripe % 2 == 1)
                depths[static_cast<std::size_t>(i)] = 1;  // the near plane's
        gl::Texture depth = gl::Texture::make_2d(gl(), "stripes", glm::ivec2(kSize),
                                                 GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
        depth.upload(GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
        Frame frame = host.frame;
        frame.depth = depth.view();
        View view = renderer_.make_view();
        return renderer_.sample_counts(view, frame, settings);
    };
    for (const Passes passes : {Passes::fragment, Passes::compute}) {
        const SampleCounts open = count(0, passes);
        EXPECT_GT(open.all, kSize * kSize);
        EXPECT_DOUBLE_EQ(open.even_4, 1);
        EXPECT_DOUBLE_EQ(open.even_8, 1);
        // Rays of every other column end before the slab.
        const SampleCounts columns = count(1, passes);
        EXPECT_DOUBLE_EQ(columns.all, open.all / 2);
        EXPECT_DOUBLE_EQ(columns.even_4, 0.5);
        EXPECT_DOUBLE_EQ(columns.even_8, 0.5);
        const SampleCounts squares = count(4, passes);
        EXPECT_DOUBLE_EQ(squares.all, open.all / 2);
        EXPECT_DOUBLE_EQ(squares.even_4, 1) << "all of a square's, or none";
        EXPECT_DOUBLE_EQ(squares.even_8, 0.5);
    }
    settings.mode = Settings::Mode::froxel;
    EXPECT_EQ(count(0, Passes::compute).even_4, 0);
}

TEST_F(PassForms, BlendWithAPictureOfAnyFormatAsTheBlendingStageDoes)
{
    set(smoke_over_floor(), small());
    // A resolve that laid nothing, or laid it twice, would differ by more than any rounding.
    const float seen = 0.2f;
    struct Format {
        const char* name;
        GLenum format;
        float bound;  ///< of a value, to the blending stage's; 0: the same bits
        bool is_image;
    };
    // llvmpipe blends bytes as integers, a rounding for each of the two products and the sum.
    const std::vector<Format> formats{{"rgba16f", GL_RGBA16F, 0, true},
                                      {"r11g11b10f", GL_R11F_G11F_B10F, 0, true},
                                      {"rgba8", GL_RGBA8, 2.0f / 255, true},
                                      {"rgba16", GL_RGBA16, 2.0f / 65535, true},
                                      {"srgb8_alpha8", GL_SRGB8_ALPHA8, 0, false}};
    for (const auto& [name, format, bound, is_image] : formats)
        for (const int passes : {1, 2}) {
            Settings settings = small();
            settings.resolve_passes = passes;
            const Drawn fragments = draw(settings, Passes::fragment, format);
            const Drawn compute = draw(settings, Passes::compute, format);
            float most = 0, sum = 0;
            for (std::size_t i = 0; i < compute.picture.size(); ++i) {
                most = std::max(most, std::abs(compute.picture[i] - fragments.picture[i]));
                sum = std::max(sum, compute.picture[i]);
            }
            EXPECT_LE(most, bound) << name << " in " << passes;
            EXPECT_GT(sum, seen) << name;
            EXPECT_EQ(compute.passes == "compute shaders", is_image) << compute.passes;
        }
}

TEST_F(PassForms, ATextureThatLacksLevelsIsDrawnTo)
{
    set(smoke_over_floor(), small());
    Settings settings = small();
    settings.passes = Passes::compute;
    const glm::ivec2 size(scene_.resolution);
    GLuint color = 0;
    gl()->GenTextures(1, &color);
    gl()->BindTexture(GL_TEXTURE_2D, color);
    gl()->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, size.x, size.y, 0, GL_RGBA, GL_FLOAT, nullptr);
    gl()->BindTexture(GL_TEXTURE_2D, 0);
    Host host(scene_, GL_RGBA16F);
    host.frame.color = {color, glm::ivec3(size, 1)};
    View view = renderer_.make_view();
    renderer_.draw_surfaces(host.frame, settings, true);
    renderer_.composite(view, host.frame, settings);
    EXPECT_NE(renderer_.take_report().passes, "compute shaders");
    expect_same_values(gl::read_texture(gl(), host.frame.color, 4),
                       draw(settings, Passes::fragment, GL_RGBA16F).picture, settings,
                       "a host's texture");
    gl()->DeleteTextures(1, &color);
}

class TileLists : public GlTest {};

/// How far along Morton's curve a tile is, of 8 x 8.
int along_curve(glm::ivec2 tile)
{
    int place = 0;
    for (int bit = 0; bit < 3; ++bit)
        place |= (tile.x >> bit & 1) << 2 * bit | (tile.y >> bit & 1) << (2 * bit + 1);
    return place;
}

TEST_F(TileLists, HoldEachTileOnceWhatTakesLongFirstAndNeighboursTogether)
{
    constexpr glm::ivec2 kCount(37, 21);
    constexpr int kSteps = 48;
    std::mt19937 engine(3);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    std::vector<glm::uvec4> texels;
    for (int i = 0; i < kCount.x * kCount.y; ++i) {
        const std::uint32_t slots = random() % 3 == 0 ? 0 : random() >> random() % 31;
        const std::uint32_t fours = random(), twos = random() & ~fours;
        texels.emplace_back(slots, slots & fours, slots & twos,
                            tile_place(4, static_cast<int>(random() % 4), random() % 2 == 0));
    }
    gl::Texture tiles =
        gl::Texture::make_2d(gl(), "tiles", kCount, GL_RGBA32UI, gl::Filter::nearest);
    tiles.upload(GL_RGBA_INTEGER, GL_UNSIGNED_INT, texels.data());
    gl::UniformBuffer<FrameParams> block(gl(), "frame");
    FrameParams frame{};
    frame.steps = kSteps;
    block.write(frame);
    const std::size_t capacity = texels.size();
    const gl::Buffer list(gl(), "list", sizeof(TileListHead) + 4 * TILE_CLASSES * capacity);
    const auto steps_in = [](const glm::uvec4& tile) {
        const auto of = [](std::uint32_t slots, int many) {
            return static_cast<double>(std::popcount(slots)) / many;
        };
        return (of(tile.x & ~(tile.y | tile.z), 1) + of(tile.z, 2) + of(tile.y, 4)) *
               (1 << tile_log2_width(tile.w));
    };
    for (const auto& [texels_along, all, lit] : {std::tuple{4, "true", true},
                                                 {4, "false", true},
                                                 {4, "false", false},
                                                 {16, "true", true}}) {
        const gl::Program program(gl(), {"pass/list_tiles.comp"},
                                  {{"kTilePixels", fmt::format("{}", texels_along)},
                                   {"kAllTiles", all},
                                   {"kLitTiles", lit ? "true" : "false"}});
        const TileListHead nothing{TILE_ROW, 0, 1, 0, {0, 0, 0, 0}};
        list.write(&nothing, sizeof(nothing));
        gl()->BindBufferBase(GL_UNIFORM_BUFFER, FRAME_BLOCK, block.id());
        gl()->BindBufferBase(GL_SHADER_STORAGE_BUFFER, TILE_LIST_BUFFER, list.id());
        tiles.bind(STEP_TILES_UNIT);
        gl()->UseProgram(program.id());
        gl()->DispatchCompute((kCount.x + 7) / 8, (kCount.y + 7) / 8, 1);
        gl()->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl()->UseProgram(0);
        TileListHead head{};
        std::vector<std::uint32_t> listed(TILE_CLASSES * capacity);
        gl()->GetNamedBufferSubData(list.id(), 0, sizeof(head), &head);
        gl()->GetNamedBufferSubData(list.id(), sizeof(head), 4 * std::ssize(listed), listed.data());
        std::set<std::size_t> seen;
        std::uint32_t groups = 0;
        int in_order = 0;
        const std::array<double, TILE_CLASSES + 1> kShares{1e9, 0.5, 0.25, 0.125, 0};
        for (std::size_t k = 0; k < TILE_CLASSES; ++k) {
            groups += (head.tiles[k] * texels_along * texels_along + 63) / 64;
            for (std::size_t i = 0; i < head.tiles[k]; ++i) {
                const glm::ivec2 at = tile_at(listed[k * capacity + i]);
                const auto index = static_cast<std::size_t>(at.y * kCount.x + at.x);
                EXPECT_TRUE(seen.insert(index).second) << "twice";
                const double share = steps_in(texels.at(index)) / kSteps;
                EXPECT_LE(share, kShares.at(k));
                EXPECT_GE(share, kShares.at(k + 1));
                const glm::ivec2 before = i > 0 ? tile_at(listed[k * capacity + i - 1]) : at + 8;
                if (at / 8 == before / 8) {
                    EXPECT_GT(along_curve(at), along_curve(before)) << at.x << " " << at.y;
                    ++in_order;
                }
            }
        }
        EXPECT_GT(in_order, int(seen.size()) / 2);
        std::size_t wanted = 0;
        for (const glm::uvec4& tile : texels)
            wanted += tile.x != 0 && (all[0] == 't' || tile_is_lit(tile.w) == lit) ? 1 : 0;
        EXPECT_EQ(seen.size(), wanted);
        EXPECT_GT(head.tiles[0], 0u);
        EXPECT_GT(head.tiles[3], 0u);
        EXPECT_EQ(head.groups, groups);
        EXPECT_EQ(glm::uvec3(head.groups_x, head.groups_y, head.groups_z),
                  glm::uvec3(TILE_ROW, (groups + TILE_ROW - 1) / TILE_ROW, 1));
    }
    gl()->BindTextureUnit(STEP_TILES_UNIT, 0);
}

/// Nodes of a lattice whose edges are no multiples of a group's: those with a medium and those
/// around them, each once, and as many groups as they fill.
TEST_F(GlTest, NodesNearMediaAreListedOnce)
{
    constexpr glm::ivec3 kCount(11, 7, 13);
    for (const int one_in : {2, 40, 1001, 100000}) {
        SCOPED_TRACE(one_in);
        std::mt19937 engine(7);
        std::vector<glm::vec4> sigma_t;
        for (int i = 0; i < kCount.x * kCount.y * kCount.z; ++i)
            sigma_t.emplace_back(0, 0, engine() % unsigned(one_in) == 0 ? 1e-20f : 0.0f, 0);
        if (one_in == 1001)
            sigma_t.back().r = 1;  // in a corner
        const auto is_dense = [&](glm::ivec3 node) {
            const glm::ivec3 at = glm::clamp(node, glm::ivec3(0), kCount - 1);
            return glm::vec3(sigma_t.at(std::size_t(at.x + kCount.x * (at.y + kCount.y * at.z)))) !=
                   glm::vec3(0);
        };
        std::set<std::uint32_t> wanted;
        for (int z = 0; z < kCount.z; ++z)
            for (int y = 0; y < kCount.y; ++y)
                for (int x = 0; x < kCount.x; ++x)
                    for (int k = 0; k < 27; ++k)
                        if (is_dense({x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1}))
                            wanted.insert(node_word({x, y, z}));
        gl::Texture texture =
            gl::Texture::make_3d(gl(), "sigma_t", kCount, GL_RGBA32F, gl::Filter::nearest);
        texture.upload(GL_RGBA, GL_FLOAT, sigma_t.data());
        gl::UniformBuffer<FieldParams> block(gl(), "field");
        const auto params = std::make_unique<FieldParams>();
        params->nodes.last = glm::vec3(kCount - 1);
        block.write(*params);
        std::vector<std::uint32_t> words(4 + sigma_t.size());
        words[1] = words[2] = 1;
        const gl::Buffer list(gl(), "list", 4 * words.size(), words.data());
        const gl::Program program(gl(), {"light/field_list.comp"}, {});
        gl()->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block.id());
        gl()->BindBufferBase(GL_SHADER_STORAGE_BUFFER, FIELD_NODES_BUFFER, list.id());
        texture.bind(FIELD_SIGMA_T_UNIT);
        gl()->UseProgram(program.id());
        gl()->DispatchCompute(3, 2, 4);
        gl()->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        gl()->UseProgram(0);
        gl()->GetNamedBufferSubData(list.id(), 0, 4 * std::ssize(words), words.data());
        FieldNodesHead head{};
        std::memcpy(&head, words.data(), sizeof(head));
        ASSERT_EQ(head.nodes, wanted.size());
        EXPECT_EQ(glm::uvec3(head.groups_x, head.groups_y, head.groups_z),
                  glm::uvec3((wanted.size() + FIELD_NODE_GROUP - 1) / FIELD_NODE_GROUP, 1, 1));
        EXPECT_EQ(std::set<std::uint32_t>(words.begin() + 4, words.begin() + 4 + head.nodes),
                  wanted);
        for (const std::uint32_t word : wanted)
            EXPECT_EQ(node_word(node_of_word(word)), word);
    }
    gl()->BindTextureUnit(FIELD_SIGMA_T_UNIT, 0);
}

}  // namespace
}  // namespace fumarole::test
