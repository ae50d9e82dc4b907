// What must not change the picture: nothing to see, the grid's layout, the layer's targets, units,
// the origin, and how a VDB's transform is turned, sheared, mirrored or stretched. And what a
// coarser storage may change, measured.

#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "gl/texture.h"
#include "image_test.h"
#include "medium/grid_layout.h"

namespace fumarole::test {
namespace {

class Invariance : public ImageTest {};

// -- nothing to see ------------------------------------------------------------------------------

/// A host's picture of any bits that a colour may have: tiny, huge, negative and odd alphas.
class EmptyMedia : public ImageTest {
protected:
    static constexpr glm::ivec2 kSize{33, 17};

    EmptyMedia()
        : color_{gl::Texture::make_2d(gl(), "host colour", kSize, GL_RGBA32F, gl::Filter::nearest)},
          depth_{gl::Texture::make_2d(gl(), "host depth", kSize, GL_DEPTH_COMPONENT32F,
                                      gl::Filter::nearest)}
    {
        std::mt19937 random(5);
        std::uniform_real_distribution<float> exponent(-140, 120), unit(0, 1);
        for (int i = 0; i < kSize.x * kSize.y; ++i) {
            for (int c = 0; c < 4; ++c)
                bits_.push_back(std::exp2(exponent(random)) * (unit(random) < 0.2f ? -1.0f : 1.0f));
            depths_.push_back(unit(random) < 0.3f ? 0.0f : unit(random));
        }
        bits_[8] = -0.0f;
        color_.upload(GL_RGBA, GL_FLOAT, bits_.data());
        depth_.upload(GL_DEPTH_COMPONENT, GL_FLOAT, depths_.data());
        frame_.color = color_.view();
        frame_.depth = depth_.view();
        frame_.depth_convention = {.zero_to_one = true, .reversed = true};
        const Scene camera = empty_scene();
        frame_.view_from_world = view_from_world(camera.camera);
        frame_.clip_from_view = clip_from_view(camera.camera, glm::uvec2(kSize), glm::dvec2(0));
    }
    /// Composites; true if every bit is as it was.
    bool keeps_bits(const Scene& scene, const Settings& settings)
    {
        Renderer& renderer = scene_renderer().renderer();
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        renderer.composite(view, frame_, settings);
        const std::vector<float> after = color_.read(4);
        return std::memcmp(after.data(), bits_.data(), bits_.size() * sizeof(float)) == 0;
    }

    gl::Texture color_, depth_;
    std::vector<float> bits_, depths_;
    Frame frame_;
};

TEST_F(EmptyMedia, LeaveTheHostsPictureBitIdentical)
{
    const auto in_view = [](BoxMedium box) {
        box.min = {-5, -8, -5};
        box.max = {5, -2, 5};
        return box;
    };
    BoxMedium clear = in_view({});
    BoxMedium behind;  // dense, but all of it behind the eye
    behind.min = {-5, 1, -5};
    behind.max = {5, 9, 5};
    behind.sigma_s = glm::vec3(10);
    GridMedium nothing;
    nothing.density = make_grid({2, 1, 1}, glm::dmat4(1), [](glm::ivec3) { return 0.0; });
    GridMedium no_grid;
    GridMedium no_coefficient;
    no_coefficient.density = make_grid({1, 1, 1}, glm::translate(glm::dmat4(1), {-4, -8, -4}),
                                       [](glm::ivec3) { return 1.0; });
    no_coefficient.sigma_s_per_density = glm::vec3(0);

    const std::vector<std::pair<const char*, std::vector<Medium>>> cases{
        {"no medium", {}},
        {"sigma 0", {clear}},
        {"a grid of zeros", {nothing}},
        {"a grid that was never loaded", {no_grid}},
        {"a grid with coefficients of 0", {no_coefficient}},
        {"all of them", {clear, nothing, no_grid, no_coefficient}},
        {"a medium behind the eye", {behind}},
    };
    for (const auto& [name, media] : cases)
        for (const int resolution : {1, 2}) {
            Scene scene = empty_scene();
            scene.media = media;
            scene.world.radiance = glm::vec3(1);
            scene.lights = {SunLight{}};
            Settings settings;
            settings.resolution = resolution;
            EXPECT_TRUE(keeps_bits(scene, settings)) << name << ", resolution " << resolution;
        }
    BoxMedium fog = in_view({});
    fog.sigma_a = glm::vec3(1);
    Scene scene = empty_scene();
    scene.media = {fog};
    EXPECT_FALSE(keeps_bits(scene, Settings{}))
        << "fog in view must show, or this test sees nothing";
}

TEST_F(EmptyMedia, AlphaAndDepthAreNeverWritten)
{
    BoxMedium fog;
    fog.min = {-5, -8, -5};
    fog.max = {5, -2, 5};
    fog.sigma_s = {1, 2, 3};
    Scene scene = empty_scene();
    scene.world.radiance = glm::vec3(1);
    for (const bool grey : {true, false}) {
        fog.sigma_s = grey ? glm::vec3(1) : glm::vec3(1, 2, 3);
        scene.media = {fog};
        EXPECT_FALSE(keeps_bits(scene, Settings{}));
        const std::vector<float> after = color_.read(4);
        for (std::size_t i = 3; i < after.size(); i += 4)
            ASSERT_EQ(std::memcmp(&after[i], &bits_[i], sizeof(float)), 0)
                << "alpha of pixel " << i / 4;
    }
    EXPECT_EQ(gl::read_texture(gl(), depth_.view(), 1, true), depths_);
}

// -- layouts and storage -------------------------------------------------------------------------

/// Looks at about (0, -5, 0), sun from the side.
Scene lit_scene()
{
    Scene scene = empty_scene(32);
    scene.camera.vfov_deg = 40;
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(3)}};
    scene.world.radiance = glm::vec3(0.2f);
    return scene;
}

/// Bricks of noise, one missing, one constant, on both sides of index 0.
GridMedium ragged_smoke(float largest = 1)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0, largest);
    const glm::dmat4 world_from_index(0.15, 0, 0, 0, 0, 0.15, 0, 0, 0, 0, 0.15, 0, 0, -5, 0, 1);
    GridMedium smoke;
    smoke.density =
        make_grid({3, 2, 3}, world_from_index,
                  [&](glm::ivec3 v) {
                      const glm::ivec3 brick = v >> 3;
                      if (brick == glm::ivec3(0, 0, 0))
                          return 0.0;
                      return brick == glm::ivec3(-1, 0, -1) ? 0.4 * largest : double(unit(random));
                  },
                  {-2, -1, -2});
    smoke.sigma_s_per_density = glm::vec3(0.6f / largest);
    smoke.sigma_a_per_density = glm::vec3(0.3f / largest);
    smoke.g = 0.3f;
    return smoke;
}

TEST_F(Invariance, DenseOrBricks)
{
    Scene scene = lit_scene();
    GridMedium smoke = ragged_smoke();
    // A GPU rounds a lookup's place. The layouts' places differ by the rounding of floats, some
    // 6e-6 of a texel in an atlas of 54, which tips the former over in one of 200 samples: that one
    // is then off by twice filter_rounding() of the difference between two voxels, which is 1 at
    // most, for a step of 2.7 m / 64 at an extinction of 1.5/m. A third of the rays have one.
    const double tipped = 2 * filter_rounding() * 1.5 * 2.7 / 64;
    for (const bool colored : {false, true}) {
        if (colored)
            smoke.sigma_a_per_density = {0.1f, 0.3f, 0.9f};
        scene.media = {smoke};
        Settings settings = plain_settings();
        settings.layout = medium::Layout::dense;
        const Still dense = render(scene, settings);
        settings.layout = medium::Layout::bricks;
        const Still bricks = render(scene, settings);
        for (const auto layer : {&Still::scattering, &Still::transmittance, &Still::composite}) {
            EXPECT_TRUE(images_near(
                picture_of(bricks, bricks.*layer), picture_of(dense, dense.*layer), 1e-5 + tipped,
                2e-6 + 0.1 * tipped, "32-bit texel coordinates, larger in the atlas"));
            figure("bricks - dense", max_difference(picture_of(bricks, bricks.*layer),
                                                    picture_of(dense, dense.*layer)));
        }
        EXPECT_LT(*std::min_element(dense.transmittance.begin(), dense.transmittance.end()), 0.3f);
    }
}

TEST_F(Invariance, ADenseGridBesideOneOfBricks)
{
    Scene scene = lit_scene();
    GridMedium dense = ragged_smoke(), sparse = ragged_smoke();
    // Two bricks with much nothing between them: bricks are smaller.
    sparse.density = make_grid(
        {16, 1, 1}, glm::dmat4(0.03, 0, 0, 0, 0, 0.06, 0, 0, 0, 0, 0.06, 0, -1.9, -5, 0.4, 1),
        [](glm::ivec3 v) { return v.x < 8 || v.x >= 120 ? 1.0 : 0.0; });
    auto trimmed = std::make_shared<VoxelGrid>(*sparse.density);
    trimmed->bricks = {{0, 0, 0}, {15, 0, 0}};
    trimmed->values.resize(2 * VoxelGrid::kBrickVoxels, 1.0f);
    sparse.density = trimmed;
    sparse.sigma_a_per_density = glm::vec3(4);
    const medium::Limits limits;
    ASSERT_EQ(medium::plan_layout(*sparse.density, medium::Layout::automatic, medium::Storage::r32f,
                                  limits)
                  .layout,
              medium::Layout::bricks);
    for (const bool turned : {false, true}) {
        scene.media =
            turned ? std::vector<Medium>{sparse, dense} : std::vector<Medium>{dense, sparse};
        Settings settings = plain_settings();
        const Still mixed = render(scene, settings);
        settings.layout = medium::Layout::dense;
        const Still one = render(scene, settings);
        EXPECT_TRUE(images_near(picture_of(mixed, mixed.composite), picture_of(one, one.composite),
                                1e-5, 2e-6, "32-bit texel coordinates, larger in the atlas"))
            << (turned ? "bricks first" : "dense first");
        Scene alone = scene;
        alone.media = {dense};
        EXPECT_GT(max_difference(picture_of(one, one.composite),
                                 picture_of(one, render(alone, settings).composite)),
                  0.05)
            << "the second grid is to be seen";
    }
}

TEST_F(Invariance, StorageCostsItsRoundingAndNoMore)
{
    Scene scene = lit_scene();
    scene.media = {ragged_smoke(1000)};
    Settings settings = plain_settings();
    const Still exact = render(scene, settings);
    const auto error = [&](medium::Storage storage, const char* name) {
        settings.storage = storage;
        const Still still = render(scene, settings);
        const double e = max_difference(picture_of(still, still.transmittance),
                                        picture_of(exact, exact.transmittance));
        figure(name, e);
        return e;
    };
    // T changes by T * dtau. Rounding to 11 bits: dtau < tau * 2^-12, and tau exp(-tau) < 0.37.
    EXPECT_LT(error(medium::Storage::r16f, "r16f"), 0.37 * std::ldexp(1, -12) + 2e-6);
    // To 8 bits of the largest value: dtau < sigma_t * length / 510 at the worst, with 5 m at the
    // most along a ray; rounding of neighbours is independent, so a twentieth of that is seen.
    EXPECT_LT(error(medium::Storage::r8, "r8"), 0.9 * 5 / 510);
    EXPECT_EQ(error(medium::Storage::r32f, "r32f"), 0);
}

// A core of 100 hides nothing of wisps of 0.01 elsewhere, though one scale for both would round
// them to 0: what the sky loses behind them is right.
TEST_F(Invariance, WispsBesideADenseCoreSurviveBytes)
{
    Scene scene = lit_scene();
    GridMedium smoke;
    const glm::dmat4 world_from_index(0.15, 0, 0, 0, 0, 0.15, 0, 0, 0, 0, 0.15, 0, 0, -5, 0, 1);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0.2, 1);
    smoke.density = make_grid({5, 2, 3}, world_from_index,
                              [&](glm::ivec3 v) {
                                  return unit(random) * (v.x < -8 ? 100 : v.x < 0 ? 0 : 0.01);
                              },
                              {-3, -1, -2});
    smoke.sigma_a_per_density = glm::vec3(100);
    scene.media = {smoke};
    Settings settings = plain_settings();
    settings.layout = medium::Layout::bricks;
    const Still exact = render(scene, settings);
    settings.storage = medium::Storage::r8;
    const Still bytes = render(scene, settings);
    // dT < dtau < sigma_t * length * what a stored value may err, 1.125 * 0.01 / 510. Of either
    // sign along 24 voxels, so a quarter is seen, even where a rasteriser filters bytes as bytes.
    const double bound = 0.25 * 100 * (24 * 0.15) * 1.125 * 0.01 / 510;
    double worst = 0, faintest = 1;
    for (int y = 0; y < exact.height; ++y)
        for (int x = 0; x < exact.width * 4 / 10; ++x) {  // looking along -y, +x is on the left
            const float t = pixel(exact.transmittance, exact.width, x, y).r;
            const float error = pixel(bytes.transmittance, exact.width, x, y).r - t;
            faintest = std::min(faintest, double{t});
            worst = std::max(worst, double{std::abs(error)});
        }
    figure("worst error of T beside the core", worst);
    EXPECT_LT(worst, bound);
    EXPECT_LT(faintest, 0.6) << "the wisps are to be seen";
    EXPECT_LT(pixel(exact.transmittance, exact.width, exact.width - 3, exact.height / 2).r, 1e-3)
        << "and the core";
    settings.layout = medium::Layout::dense;  // where all bytes have one scale
    const Still lost = render(scene, settings);
    EXPECT_EQ(pixel(lost.transmittance, exact.width, 4, exact.height / 2).r, 1)
        << "the test sees what it is for";
}

TEST_F(Invariance, OneTargetOrTwoForAGreyMedium)
{
    Scene scene = lit_scene();
    scene.media = {ragged_smoke()};
    for (const int resolution : {1, 2}) {
        Settings settings = plain_settings(resolution);
        settings.targets = Settings::Targets::mono;
        const Still mono = render(scene, settings);
        settings.targets = Settings::Targets::two;
        const Still two = render(scene, settings);
        EXPECT_TRUE(images_near(picture_of(mono, mono.composite), picture_of(two, two.composite),
                                1e-6, 1e-7, "c * t + s in one blend or in two"));
        EXPECT_TRUE(images_near(picture_of(mono, mono.transmittance),
                                picture_of(two, two.transmittance), 1e-6, 1e-7,
                                "the mean of three equal numbers"));
    }
}

TEST_F(Invariance, MonoOfAColouredMediumIsItsMean)
{
    Scene scene = lit_scene();
    BoxMedium box;
    box.min = {-9, -6, -9};
    box.max = {9, -4, 9};
    box.sigma_a = {0.2f, 0.5f, 1.0f};
    scene.media = {box};
    Settings settings = plain_settings();
    settings.targets = Settings::Targets::mono;
    const Still mono = render(scene, settings);
    settings.targets = Settings::Targets::two;
    const Still two = render(scene, settings);
    for (const int x : {0, 16}) {
        const glm::vec3 t = pixel(two.transmittance, 32, x, x);
        EXPECT_NEAR(pixel(mono.transmittance, 32, x, x).g, (t.r + t.g + t.b) / 3, 1e-6);
        EXPECT_EQ(pixel(mono.scattering, 32, x, x), pixel(two.scattering, 32, x, x));
    }
}

// -- units and origin ----------------------------------------------------------------------------

TEST_F(Invariance, MillimetresAndAMillionMetresFromTheOrigin)
{
    const auto expect_same = [](bool surfaces, const Settings& settings, double max_abs,
                                double mean_abs, const char* why) {
        const Still here = render(study::full_scene(1, glm::dvec3(0), surfaces), settings);
        const auto compare = [&](double unit, glm::dvec3 origin, const char* name) {
            const Still there = render(study::full_scene(unit, origin, surfaces), settings);
            const Image a = picture_of(there, there.composite);
            const Image b = picture_of(here, here.composite);
            figure(fmt::format("{}{}, max", name, surfaces ? " with surfaces" : ""),
                   max_difference(a, b));
            EXPECT_TRUE(images_near(a, b, max_abs, mean_abs, why)) << name;
        };
        compare(1e-3, glm::dvec3(0), "millimetres");
        compare(1, {1234567.89, -987654.321, 1e6 + 0.1}, "far from the origin");
        compare(1e3, glm::dvec3(0), "kilometres");
    };
    // What glows lights the media by a field whose radiance has 13 bits, and rounds at other
    // places.
    expect_same(false, plain_settings(), 5e-5, 4e-6, "32-bit rounding at another scale");
    for (const Settings& settings : {plain_settings(), Settings{}})
        expect_same(true, settings, 0.02, 7e-5,
                    "and a silhouette or a shadow's edge may cross the middle of a pixel, which a "
                    "maximum sees and the mean does not");
}

// -- a grid's transform --------------------------------------------------------------------------

TEST_F(Invariance, ATurnedShearedMirroredOrStretchedGridIsWhereItsTransformPutsIt)
{
    // Not symmetric in any axis, so a swap or a mirror shows.
    const auto value = [](glm::ivec3 v) {
        return 0.1 + 0.05 * v.x + 0.02 * v.y * (v.z > 9 ? 2 : 1);
    };
    const glm::dmat4 to_view = glm::translate(glm::dmat4(1), {0.1, -5, -0.1});
    const glm::dmat4 centre = glm::translate(glm::dmat4(1), glm::dvec3(-7.5));
    glm::dmat4 shear(1);
    shear[1][0] = 0.4;
    shear[2][1] = -0.3;
    const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.6, glm::normalize(glm::dvec3(1, 2, 3)));
    const auto scale = [](double x, double y, double z) {
        return glm::scale(glm::dmat4(1), glm::dvec3(x, y, z));
    };
    const std::vector<std::pair<const char*, glm::dmat4>> cases{
        {"straight", scale(0.15, 0.15, 0.15)},
        {"turned", turn * scale(0.15, 0.15, 0.15)},
        {"sheared", shear * scale(0.15, 0.15, 0.15)},
        {"mirrored", scale(-0.15, 0.15, 0.15)},
        {"stretched", scale(0.3, 0.1, 0.05)},
        {"turned, sheared, mirrored and stretched", turn * shear * scale(0.12, -0.2, 0.1)},
    };
    Scene scene = empty_scene(16);
    scene.camera.vfov_deg = 45;
    Settings settings = plain_settings();
    settings.steps = 256;
    for (const auto& [name, map] : cases)
        for (const medium::Layout layout : {medium::Layout::dense, medium::Layout::bricks}) {
            GridMedium smoke;
            smoke.density = make_grid({2, 2, 2}, to_view * map * centre, value);
            smoke.translate = {0.2, 0.1, 0};
            smoke.scale = 0.9;
            smoke.sigma_s_per_density = glm::vec3(0);
            smoke.sigma_a_per_density = glm::vec3(1.5f);
            scene.media = {smoke};
            settings.layout = layout;
            const Still still = render(scene, settings);

            const VoxelLookup lookup(*smoke.density);
            const glm::dmat4 world = glm::scale(glm::translate(glm::dmat4(1), smoke.translate),
                                                glm::dvec3(smoke.scale)) *
                                     smoke.density->world_from_index;
            const Image truth = ideal(scene, [&](glm::dvec2 at) {
                const PixelRay ray = ray_at(scene, at);
                const double column = grid_column(lookup, glm::inverse(world), ray.origin,
                                                  ray.direction, {0.1, 12}, 600);
                return glm::dvec3(std::exp(-1.5 * column));
            });
            EXPECT_LT(*std::min_element(truth.pixels.begin(), truth.pixels.end()), 0.8f) << name;
            EXPECT_TRUE(
                images_near(picture_of(still, still.transmittance), truth, 2e-3, 3e-4,
                            "256 midpoints over kinks at each voxel; 8 bits between voxels"))
                << name;
            figure(fmt::format("{}: max", name),
                   max_difference(picture_of(still, still.transmittance), truth));
        }
}

}  // namespace
}  // namespace fumarole::test
