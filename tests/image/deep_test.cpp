// Deep pictures: flattened they are the still, and in front of any depth they are what the media do
// there, by a closed form.

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>

#include "fog_panes.h"
#include "study/deep_still.h"
#include "support/temp_folder.h"
#include <fumarole/asset/auto_scene.h>
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

/// "Interpreting OpenEXR Deep Pixels": each over what is behind it, none of it behind `view_z`. A
/// volume that reaches over that depth is split there.
glm::dvec4 flatten(std::span<const DeepSample> samples, double view_z = 1e30)
{
    glm::dvec4 sum(0);
    for (const DeepSample& sample : samples) {
        if (double(sample.front) >= view_z)
            break;
        glm::dvec4 rgba(glm::dvec3(sample.color), double(sample.alpha));
        if (double(sample.back) > view_z) {
            const double share =
                (view_z - double(sample.front)) / (double(sample.back) - double(sample.front));
            const double alpha = 1 - std::pow(1 - rgba.w, share);
            rgba *= rgba.w > 0 ? alpha / rgba.w : share;
        }
        sum += (1 - sum.w) * rgba;
    }
    return sum;
}

std::span<const DeepSample> pixel(const DeepImage& image, std::size_t i)
{
    return std::span(image.samples).subspan(image.first[i], image.first[i + 1] - image.first[i]);
}

class Deep : public ImageTest {
protected:
    struct Pictures {
        Still still;
        DeepImage deep;
    };

    Pictures render(const Scene& scene, const Settings& settings, bool foreground = false,
                    int frames = 1, std::optional<PictureRegion> region = std::nullopt)
    {
        SceneRenderer renderer(get_proc());
        Pictures pictures;
        StillOptions options;
        options.aa = frames;
        options.foreground = foreground;
        options.region = region;
        pictures.still = renderer.render(scene, settings, options);
        pictures.deep = study::deep_still(renderer, scene, settings, pictures.still,
                                          {.frames = frames, .region = region});
        return pictures;
    }

    /// Flattened it is `still`; samples are in order; less than 16 a pixel.
    static void expect_whole(const Pictures& pictures)
    {
        const auto& [still, deep] = pictures;
        const bool cut_out = !still.foreground.empty();
        const std::size_t pixels = still.composite.size() / 3;
        ASSERT_EQ(deep.first.size(), pixels + 1);
        EXPECT_LT(double(deep.samples.size()), 16.0 * double(pixels));
        double mean = 0;
        for (const float value : still.composite)
            mean += double(value) / double(still.composite.size());
        for (std::size_t i = 0; i < pixels; ++i) {
            const auto samples = pixel(deep, i);
            float end = 0;
            for (const DeepSample& sample : samples) {
                ASSERT_GE(sample.front, end) << "pixel " << i;
                ASSERT_GE(sample.back, sample.front) << "pixel " << i;
                end = sample.back;
            }
            const glm::dvec4 flat = flatten(samples);
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(
                    flat[int(c)],
                    double(cut_out ? still.foreground[4 * i + c] : still.composite[3 * i + c]),
                    1e-3 * mean)
                    << "pixel " << i;
            ASSERT_NEAR(flat.w, cut_out ? double(still.foreground[4 * i + 3]) : 1.0, 1e-3);
            if (!samples.empty() && samples.back().alpha == 1) {
                ASSERT_EQ(samples.back().front, still.depth[i]) << "pixel " << i;
            }
        }
    }
};

TEST_F(Deep, FogIsSplitAtAnyDepthAsItsClosedFormHasIt)
{
    const Scene scene = fog_scene(16);
    for (Settings settings : plain_siblings()) {
        SCOPED_TRACE(int(settings.mode));
        settings.splits = 32;
        const Pictures pictures = render(scene, settings);
        expect_whole(pictures);
        const double tangent = std::tan(glm::radians(double(scene.camera.vfov_deg)) / 2);
        for (const std::size_t i : {0u, 8u * 16u + 8u}) {
            const glm::dvec2 at = (glm::dvec2(i % 16, i / 16) + 0.5) / 8.0 - 1.0;
            const FogRay ray{std::sqrt(1 + glm::dot(at, at) * tangent * tangent)};
            for (const double view_z : {3.0, 4.3, 5.0, 5.71, 7.0}) {
                const glm::dvec4 flat = flatten(pixel(pictures.deep, i), view_z);
                const glm::dvec3 passed = ray.passed(view_z);
                EXPECT_NEAR(flat.w, 1 - (passed.x + passed.y + passed.z) / 3, 2e-3) << view_z;
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(flat[c], ray.glowed(view_z)[c], 2e-3) << view_z;
            }
        }
        EXPECT_LT(pictures.deep.samples.size(), 14u * 256u) << "of 32 cuts";
    }
}

/// A smoke with its ground and sky: frames averaged, and without the sky.
TEST_F(Deep, SmokeFlattensToItsStill)
{
    asset::AutoSceneOptions wanted;
    Scene scene = asset::make_auto_scene(
                      std::filesystem::path(FUM_TEST_DATA) / "smoke_seq" / "smoke_0006.vdb", wanted)
                      .scene;
    scene.resolution = {32, 18};
    for (Settings settings : {find_preset("default"), find_preset("eevee2017")}) {
        SCOPED_TRACE(int(settings.mode));
        settings.bounces = 0;
        const bool march = settings.mode == Settings::Mode::raymarch;
        expect_whole(render(scene, settings, !march, march ? 2 : 1));
    }
}

TEST_F(Deep, AFileHasTheChannelsThatCompositorsRead)
{
    const Pictures pictures = render(fog_scene(8), plain_settings(), true);
    const TempFolder folder;
    for (const bool half : {false, true}) {
        const auto file = folder.path() / "x.deep.exr";
        write::write_deep_exr(pictures.deep, file, {.half = half, .captured = "", .command = ""});
        const auto input = OIIO::ImageInput::open(file.string());
        ASSERT_TRUE(input) << OIIO::geterror();
        EXPECT_TRUE(input->spec().deep);
        EXPECT_EQ(input->spec().channelnames,
                  (std::vector<std::string>{"R", "G", "B", "A", "Z", "ZBack"}));
        OIIO::DeepData data;
        ASSERT_TRUE(input->read_native_deep_image(0, 0, data));
        for (std::size_t i = 0; i < 64; ++i) {
            const auto samples = pixel(pictures.deep, i);
            ASSERT_EQ(std::size_t(data.samples(std::int64_t(i))), samples.size());
            for (std::size_t s = 0; s < samples.size(); ++s) {
                const auto value = [&](int c) {
                    return data.deep_value(std::int64_t(i), c, int(s));
                };
                const float tolerance = half ? 1e-3f : 0.0f;
                EXPECT_NEAR(value(1), samples[s].color.g, tolerance);
                EXPECT_NEAR(value(3), samples[s].alpha, tolerance);
                EXPECT_EQ(value(4), samples[s].front);
                EXPECT_EQ(value(5), samples[s].back);
            }
        }
    }
    DeepImage bad = pictures.deep;
    bad.samples[0].color.g = std::nanf("");
    const auto error = [&](const DeepImage& image, const std::filesystem::path& file) {
        try {
            write::write_deep_exr(image, file);
        } catch (const Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_THAT(error(bad, folder.path() / "y.exr"),
                testing::HasSubstr("channel 'G' is NaN at pixel (0, 0)"));
    EXPECT_THAT(error(pictures.deep, folder.path() / "none" / "y.exr"),
                testing::HasSubstr("no such folder"));
    EXPECT_THAT(error({}, folder.path() / "y.exr"), testing::HasSubstr("is empty"));
}

/// One of each blend, before, in and behind the fog; edges cross the picture.
Scene scene_of_panes(int size)
{
    Scene scene = fog_scene(size);
    const auto add = [&](double distance, Kind kind, float alpha) -> QuadTransparent& {
        QuadTransparent quad = pane(distance, kind);
        quad.look.radiance = {0.3f, 0.1f, 0.6f};
        quad.look.alpha = alpha;
        return std::get<QuadTransparent>(scene.transparents.emplace_back(quad));
    };
    add(5, Kind::alpha, 0.4f);
    add(3, Kind::premultiplied, 0.25f).edges[0].x = -9.4;
    add(7, Kind::add, 1).edges[1].z = 9.3;
    add(4.5, Kind::multiply, 1).look.filter = {0.9f, 0.5f, 0.2f};
    add(5.5, Kind::factors, 0.5f).look.blend = {Kind::factors, BlendFactor::src_alpha,
                                                BlendFactor::one_minus_src_color};
    add(6.5, Kind::factors, 1).look.blend = {Kind::factors, BlendFactor::one_minus_dst_color,
                                             BlendFactor::one};  // screen
    add(4.8, Kind::factors, 1).look.blend = {Kind::factors, BlendFactor::dst_color,
                                             BlendFactor::src_alpha};
    return scene;
}

TEST_F(Deep, TransparentsAreSamplesOfTheirOwn)
{
    Scene scene = scene_of_panes(16);
    for (Settings settings : plain_siblings()) {
        SCOPED_TRACE(int(settings.mode));
        settings.splits = 32;
        expect_whole(render(scene, settings, false, 4));
        expect_whole(render(scene, settings, true, 2));
    }
    // In the middle of the fog it is dimmed by what is before it, and covers what is behind.
    scene.transparents.resize(1);
    Settings settings = plain_settings();
    settings.splits = 64;
    const Pictures pictures = render(scene, settings);
    const double tangent = std::tan(glm::radians(double(scene.camera.vfov_deg)) / 2);
    const FogRay ray{std::sqrt(1 + 2 * std::pow(tangent / 16, 2))};
    const std::size_t middle = 8 * 16 + 8;
    for (const double view_z : {4.5, 4.999, 5.001, 5.5, 7.0}) {
        const glm::dvec4 flat = flatten(pixel(pictures.deep, middle), view_z);
        const double kept = view_z > 5 ? 0.6 : 1;
        const glm::dvec3 before = ray.glowed(std::min(view_z, 5.0)),
                         behind = ray.glowed(std::max(view_z, 5.0)) - ray.glowed(5),
                         passed = ray.passed(view_z);
        EXPECT_NEAR(flat.w, 1 - kept * (passed.x + passed.y + passed.z) / 3, 3e-3) << view_z;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(
                flat[c],
                before[c] +
                    (1 - kept) * ray.passed(5)[c] *
                        double(std::get<QuadTransparent>(scene.transparents[0]).look.radiance[c]) +
                    kept * behind[c],
                3e-3)
                << view_z;
    }
    const auto samples = pixel(pictures.deep, middle);
    EXPECT_EQ(std::count_if(samples.begin(), samples.end(),
                            [](const DeepSample& s) {
                                return std::abs(s.front - 5) < 1e-4f && s.front == s.back &&
                                       std::abs(s.alpha - 0.4f) < 1e-6f;
                            }),
              1);
    // What hides all ends the pixel.
    std::get<QuadTransparent>(scene.transparents[0]).look.alpha = 1;
    const DeepImage hidden = render(scene, settings).deep;
    for (const DeepSample& sample : pixel(hidden, middle))
        EXPECT_LT(sample.back, 5.0001f);
    // A factor of the colour behind is a filter if it is the source's, and else a square.
    TransparentLook& look = std::get<QuadTransparent>(scene.transparents[0]).look;
    look.blend = {Kind::factors, BlendFactor::dst_color, BlendFactor::zero};
    const DeepImage filtered = render(scene, settings).deep;
    // One alpha for three channels: of what the fog before it lets through.
    const glm::dvec3 before = ray.passed(5), after = before * glm::dvec3(look.radiance);
    const double kept = (after.x + after.y + after.z) / (before.x + before.y + before.z);
    const auto left = pixel(filtered, middle);
    const auto filter = std::find_if(left.begin(), left.end(), [](const DeepSample& s) {
        return std::abs(s.front - 5) < 1e-4f && s.front == s.back;
    });
    ASSERT_NE(filter, left.end());
    EXPECT_NEAR(filter->alpha, 1 - kept, 1e-3);
    look.blend = {Kind::factors, BlendFactor::one, BlendFactor::dst_color};
    try {
        render(scene, settings);
        ADD_FAILURE() << "a square of what is behind has no sample";
    } catch (const Error& error) {
        for (const char* part : {"transparents[0]", "square of the color behind it", "flat .exr"})
            EXPECT_THAT(error.what(), testing::HasSubstr(part));
    }
}

TEST_F(Deep, APartOfAPictureIsThatPartOfTheWhole)
{
    const Scene scene = scene_of_panes(16);
    const PictureRegion region{3, 6, 9, 5};
    for (const Settings& settings : plain_siblings()) {
        SCOPED_TRACE(int(settings.mode));
        const Pictures part = render(scene, settings, false, 2, region);
        expect_whole(part);
        const DeepImage whole = render(scene, settings, false, 2).deep;
        EXPECT_EQ(part.deep.origin, glm::ivec2(3, 6));
        EXPECT_EQ(part.deep.whole, glm::ivec2(16));
        ASSERT_EQ(part.deep.width, 9);
        ASSERT_EQ(part.deep.height, 5);
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 9; ++x)
                for (const double view_z : {3.5, 4.7, 5.2, 6.5, 1e30}) {
                    const glm::dvec4 here =
                        flatten(pixel(part.deep, std::size_t(9 * y + x)), view_z);
                    const glm::dvec4 there =
                        flatten(pixel(whole, std::size_t(16 * (y + 6) + x + 3)), view_z);
                    for (int c = 0; c < 4; ++c)
                        ASSERT_NEAR(here[c], there[c], 2e-3)
                            << x << ' ' << y << " before " << view_z;
                }
    }
}

TEST_F(Deep, OiiotoolFlattensItToTheStill)
{
    if (std::system("oiiotool --help >/dev/null 2>&1") != 0)
        GTEST_SKIP() << "needs oiiotool (openimageio-tools)";
    const Pictures pictures =
        render(scene_of_panes(16), plain_settings(), false, 2, PictureRegion{3, 6, 9, 5});
    const TempFolder folder;
    const std::string deep = (folder.path() / "x.deep.exr").string();
    write::write_deep_exr(pictures.deep, deep);
    ASSERT_EQ(std::system(fmt::format("oiiotool '{}' --flatten -o '{}/flat.exr'", deep,
                                      folder.path().string())
                              .c_str()),
              0);
    const auto input = OIIO::ImageInput::open((folder.path() / "flat.exr").string());
    ASSERT_TRUE(input);
    EXPECT_EQ(glm::ivec2(input->spec().x, input->spec().y), glm::ivec2(3, 6));
    EXPECT_EQ(glm::ivec2(input->spec().full_width, input->spec().full_height), glm::ivec2(16));
    const Image flat = write::read_exr(folder.path() / "flat.exr", {"R", "G", "B"});
    double mean = 0;
    for (const float value : pictures.still.composite)
        mean += double(value) / double(pictures.still.composite.size());
    ASSERT_EQ(flat.pixels.size(), pictures.still.composite.size());
    for (std::size_t i = 0; i < flat.pixels.size(); ++i)
        ASSERT_NEAR(flat.pixels[i], pictures.still.composite[i], 1e-3 * mean) << i;
}

}  // namespace
}  // namespace fumarole::test
