// Grids that go to the GPU over several frames: a picture has the old one or the new one, whole.

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>

#include "host_picture.h"
#include "image_test.h"
#include <fumarole/renderer.h>

namespace fumarole::test {
namespace {

class Uploads : public ImageTest {
protected:
    static constexpr std::uint64_t kLimit = 4096;  ///< bytes a frame

    Uploads() : host_(gl(), glm::ivec2(16)) { settings_ = quick(); }

    static Settings quick()
    {
        Settings settings;
        settings.jitter = Settings::Jitter::none;
        settings.bounces = 0;
        settings.steps = 8;
        settings.resolution = 1;
        settings.shadow_volume_size = 8;
        settings.ambient_volume_size = 0;
        settings.storage = medium::Storage::r32f;
        settings.layout = medium::Layout::dense;
        return settings;
    }

    /// A ball of smoke: 24^3 voxels of 4 bytes, 14 frames' worth, of a density of its own.
    static Scene smoke(float density)
    {
        constexpr int kSide = 24;
        std::vector<float> values;
        for (int z = 0; z < kSide; ++z)
            for (int y = 0; y < kSide; ++y)
                for (int x = 0; x < kSide; ++x) {
                    const glm::vec3 from = glm::vec3(x, y, z) - (kSide - 1) / 2.0f;
                    values.push_back(glm::length(from) < 10 ? density : 0.01f);
                }
        GridMedium medium;
        const glm::dmat4 world_from_index =
            glm::translate(glm::dmat4(1.0), glm::dvec3(-1.2, -6.2, -1.2)) *
            glm::scale(glm::dmat4(1.0), glm::dvec3(0.1));
        medium.density = std::make_shared<VoxelGrid>(
            make_voxel_grid(values, glm::ivec3(kSide), world_from_index));
        Scene scene = empty_scene(16);
        scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)}};
        scene.media = {medium};
        return scene;
    }

    Image draw(Renderer& renderer, View& view, const Scene& scene)
    {
        host_.look(scene.camera);
        host_.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        renderer.composite(view, host_.frame, settings_);
        return host_.read();
    }
    Image fresh(const Scene& scene)
    {
        Renderer renderer(get_proc());
        View view = renderer.make_view(View::History::none);
        renderer.set_scene(scene, settings_);
        return draw(renderer, view, scene);
    }
    static bool is_same(const Image& a, const Image& b) { return max_difference(a, b) == 0; }

    HostPicture host_;
    Settings settings_;
};

TEST_F(Uploads, APictureHasTheOldGridUntilTheNewOneIsWhole)
{
    const Scene first = smoke(0.5f);
    Scene second = smoke(2);
    const Image of_first = fresh(first), of_second = fresh(second);
    EXPECT_FALSE(is_same(of_first, of_second));
    Renderer renderer(get_proc());
    View view = renderer.make_view(View::History::none);
    renderer.set_upload_limit(kLimit);
    renderer.set_scene(first, settings_);
    EXPECT_TRUE(is_same(draw(renderer, view, first), of_first)) << "there is nothing else to show";
    renderer.take_report();

    int frames = 0, of_old = 0, grids = 0;
    std::uint64_t bytes = 0, allocated = 0;
    FrameReport report;
    do {
        renderer.set_scene(second, settings_);
        const Image picture = draw(renderer, view, second);
        report = renderer.take_report();
        EXPECT_LE(report.uploaded_bytes, kLimit);
        bytes += report.uploaded_bytes;
        grids += report.work.grids_uploaded;
        EXPECT_TRUE(frames == 0 || report.gpu_bytes <= allocated) << "no room for more is made";
        allocated = report.gpu_bytes;
        if (is_same(picture, of_first))
            ++of_old;
        else
            EXPECT_TRUE(is_same(picture, of_second));
        ++frames;
    } while (report.uploading && frames < 100);
    EXPECT_TRUE(is_same(draw(renderer, view, second), of_second));
    EXPECT_GE(bytes, 24u * 24 * 24 * 4);
    EXPECT_GE(frames, static_cast<int>(bytes / kLimit));
    EXPECT_GE(of_old, static_cast<int>(bytes / kLimit) - 1);
    EXPECT_EQ(grids, 1);

    // Lights change at once, and who waits or prepares has all.
    second.media = smoke(1).media;
    std::get<SunLight>(second.lights[0]).irradiance = glm::vec3(1, 2, 3);
    Scene brighter = first;
    brighter.lights = second.lights;
    renderer.set_scene(brighter, settings_);
    EXPECT_TRUE(renderer.take_report().uploading);
    renderer.wait_until_ready();
    EXPECT_FALSE(renderer.take_report().uploading);
    EXPECT_TRUE(is_same(draw(renderer, view, brighter), fresh(brighter)));
    std::get<SunLight>(second.lights[0]).irradiance = glm::vec3(3, 2, 1);
    renderer.set_scene(second, settings_);
    EXPECT_TRUE(renderer.take_report().uploading);
    brighter.lights = second.lights;
    EXPECT_TRUE(is_same(draw(renderer, view, brighter), fresh(brighter)));
}

TEST_F(Uploads, ASequenceFasterThanTheyAreShowsSomeOfItsFramesWhole)
{
    std::vector<Scene> scenes;
    std::vector<Image> pictures;
    for (const float density : {0.5f, 1.0f, 2.0f, 4.0f}) {
        scenes.push_back(smoke(density));
        pictures.push_back(fresh(scenes.back()));
    }
    Renderer renderer(get_proc());
    View view = renderer.make_view(View::History::none);
    renderer.set_upload_limit(7 * kLimit);
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < 17; ++i) {
        const Scene& scene = scenes[i % scenes.size()];
        renderer.set_scene(scene, settings_);
        const Image picture = draw(renderer, view, scene);
        const auto at = std::find_if(pictures.begin(), pictures.end(),
                                     [&](const Image& one) { return is_same(one, picture); });
        ASSERT_NE(at, pictures.end()) << "a mixture, frame " << i;
        if (i > 0)
            EXPECT_LE(renderer.take_report().uploaded_bytes, 7 * kLimit);
        else
            renderer.take_report();
        const auto which = static_cast<std::size_t>(at - pictures.begin());
        if (seen.empty() || seen.back() != which)
            seen.push_back(which);
    }
    EXPECT_GE(seen.size(), 3u) << "it goes on";
}

}  // namespace
}  // namespace fumarole::test
