// A picture in tiles, and a part of a picture, are the picture: no seam anywhere.

#include "image/image_test.h"

#include <cmath>
#include <fmt/format.h>

#include <fumarole/asset/scene_file.h>
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

class Tiles : public ImageTest {
protected:
    static Scene scene(const char* name)
    {
        Scene scene = asset::load_scene(std::string(FUM_TEST_DATA) + "/" + name).scene;
        scene.resolution = {430, 301};  // odd, so that the layer ends in a part of a texel
        return scene;
    }

    static Settings settings_of(FrameSettings::Mode mode, int resolution)
    {
        Settings settings;
        settings.mode = mode;
        settings.resolution = resolution;
        settings.format = Settings::Format::rgba32f;
        settings.tile = 8;
        return settings;
    }

    /// How far a part is from the same part of the whole picture, over all that a Still has.
    struct Difference {
        double rms = 0;   ///< relative, or absolute below 1
        double most = 0;  ///< share of the values of a picture that are off by more than 1e-3
    };

    static Difference difference(const Still& part, const Still& whole, const PictureRegion& at)
    {
        Difference worst;
        const auto compare = [&](const std::vector<float>& a, const std::vector<float>& b,
                                 std::size_t channels) {
            ASSERT_EQ(a.size(), static_cast<std::size_t>(at.width * at.height) * channels);
            double squares = 0, off = 0;
            for (int y = 0; y < at.height; ++y)
                for (std::size_t x = 0; x < static_cast<std::size_t>(at.width) * channels; ++x) {
                    const double one = a[static_cast<std::size_t>(y * at.width) * channels + x];
                    const double other =
                        b[static_cast<std::size_t>((y + at.y) * whole.width + at.x) * channels + x];
                    const double d = std::abs(one - other) / std::max(1.0, std::abs(other));
                    (d > 1e-3 ? off : squares) += d > 1e-3 ? 1 : d * d;
                }
            const auto values = static_cast<double>(a.size());
            worst.rms = std::max(worst.rms, std::sqrt(squares / values));
            worst.most = std::max(worst.most, off / values);
        };
        compare(part.composite, whole.composite, 3);
        compare(part.scattering, whole.scattering, 3);
        compare(part.transmittance, whole.transmittance, 3);
        compare(part.surface, whole.surface, 3);
        compare(part.surface_lit, whole.surface_lit, 3);
        compare(part.foreground, whole.foreground, 4);
        compare(part.depth, whole.depth, 1);
        return worst;
    }

    /// Rays of a part are worked out by other sums, so they differ by some 1e-7. Texture units
    /// round a sample's place between texels to 8 bits, of which one flips here and there (1/256 of
    /// what two voxels differ by, in one of dozens of samples); a shadow's or a silhouette's edge
    /// may take another side in a pixel: up to 2.1e-5 of the values are off by 1e-3. Where the
    /// jitter lies elsewhere 31 % of them are, and 7e-5 where look-ups lack their margins.
    void expect_same(const std::string& name, const Difference& found)
    {
        EXPECT_LT(found.rms, 2e-5) << name;
        EXPECT_LT(found.most, 4e-5) << name;
        figure(name + ", rms", found.rms);
        figure(name + ", share off by 1e-3", found.most);
    }
};

TEST_F(Tiles, AreTheWholePicture)
{
    const Scene sun = scene("smoke_plume_sun.json");
    Scene parallel = sun;
    parallel.camera.projection = Camera::Projection::orthographic;
    parallel.camera.ortho_height = 3;
    const PictureRegion all{0, 0, 430, 301}, part{211, 40, 77, 93};
    struct Case {
        const char* name;
        const Scene& scene;
        Settings settings;
    };
    using Mode = FrameSettings::Mode;
    const std::vector<Case> cases{{"half", sun, settings_of(Mode::raymarch, 2)},
                                  {"full", sun, settings_of(Mode::raymarch, 1)},
                                  {"chosen", sun, settings_of(Mode::raymarch, kAutomatic)},
                                  {"orthographic", parallel, settings_of(Mode::raymarch, 2)},
                                  {"froxels", sun, settings_of(Mode::froxel, 1)}};
    for (const Case& c : cases) {
        StillOptions options;
        options.aa = 2;  // the second frame's samples lie elsewhere in their texels
        options.foreground = true;
        const Still whole = scene_renderer().render(c.scene, c.settings, options);
        options.most_side = 200;
        const Still tiles = scene_renderer().render(c.scene, c.settings, options);
        expect_same(c.name, difference(tiles, whole, all));
        options.region = part;
        const Still alone = scene_renderer().render(c.scene, c.settings, options);
        EXPECT_EQ(alone.width, 77);
        expect_same(fmt::format("{}, a part", c.name), difference(alone, whole, part));
    }
}

// A pixel's ray is origin + x dx + y dy, where x and y go from -1 to 1 over what is drawn: a tile's
// sums are others than the whole picture's. Each is three terms of floats, so directions are apart
// by a few units in the last place, and in haze, which has no texture, so is the way through it.
// What is more than that comes of texture units.
TEST_F(Tiles, HaveTheWholePicturesRaysButForTheRoundingOfTheirSums)
{
    Scene haze;
    haze.resolution = {430, 301};
    haze.camera.position = {0.3, -12, 1.7};
    haze.camera.look_at = {0, 0, 1.2};
    haze.camera.up = {0, 0, 1};
    BoxMedium box;
    box.min = {-2, -2, 0};
    box.max = {2, 2, 3};
    box.sigma_a = glm::vec3(0.4f);
    haze.media = {box};
    Settings settings = settings_of(FrameSettings::Mode::raymarch, 1);
    const Still whole = scene_renderer().render(haze, settings, {});
    StillOptions options;
    options.most_side = 200;
    const Still tiles = scene_renderer().render(haze, settings, options);
    double worst = 0;
    for (std::size_t i = 0; i < whole.transmittance.size(); ++i)
        worst = std::max(worst, std::abs(double{whole.transmittance[i]} - tiles.transmittance[i]));
    figure("transmittance", worst);
    EXPECT_LT(*std::min_element(whole.transmittance.begin(), whole.transmittance.end()), 0.3f);
    EXPECT_LT(worst, 1e-5);
}

TEST_F(Tiles, CountTheirFramesOnTheWholePicture)
{
    const Scene sun = scene("smoke_plume_sun.json");
    StillOptions options;
    options.aa = 64;
    options.most_side = 200;
    int asked = 0;
    options.enough = [&](const Halves& halves) {
        ++asked;
        EXPECT_EQ(halves.first.size(), halves.second.size());
        EXPECT_EQ(halves.first.size() % static_cast<std::size_t>(3 * halves.width), 0u);
        return halves.frames >= 16;
    };
    const Still still =
        scene_renderer().render(sun, settings_of(FrameSettings::Mode::raymarch, 4), options);
    EXPECT_EQ(still.frames, 16);
    EXPECT_EQ(asked, 2) << "after 8 and 16 frames, once for all tiles";
}

// Averaging takes the grain away, so what half a resolution blurs would be what is left.
TEST_F(Tiles, AreFullWhereFramesAreAveragedAndTheResolutionIsAutomatic)
{
    Scene sun = scene("smoke_plume_sun.json");
    sun.resolution = {66, 38};
    const auto composite = [&](int resolution, int frames) {
        StillOptions options;
        options.aa = frames;
        return scene_renderer()
            .render(sun, settings_of(FrameSettings::Mode::raymarch, resolution), options)
            .composite;
    };
    EXPECT_EQ(composite(kAutomatic, 1), composite(2, 1));
    EXPECT_EQ(composite(kAutomatic, 2), composite(1, 2));
    EXPECT_NE(composite(2, 2), composite(1, 2)) << "or there was nothing to tell apart";
}

TEST_F(Tiles, WhatNeedsTheWholeViewIsRefused)
{
    const Scene sun = scene("smoke_plume_sun.json");
    StillOptions options;
    options.region = PictureRegion{0, 0, 40, 40};
    Settings froxels = settings_of(FrameSettings::Mode::froxel, 1);
    froxels.froxel_shadows = FrameSettings::FroxelShadows::grid;
    EXPECT_THROW(scene_renderer().render(sun, froxels, options), Error);
    froxels.froxel_shadows = FrameSettings::FroxelShadows::media;
    options.moving_frame = 0;
    EXPECT_THROW(scene_renderer().render(sun, froxels, options), Error) << "a history";
    options.moving_frame.reset();
    options.region = PictureRegion{400, 0, 40, 40};
    EXPECT_THROW(scene_renderer().render(sun, froxels, options), Error) << "out of the picture";
}

}  // namespace
}  // namespace fumarole::test
