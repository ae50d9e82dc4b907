#include "history_test.h"

namespace fumarole::test {

FrameReport HistoryTest::run(Renderer& renderer, View& view, const Scene& scene,
                             const Settings& settings, int frames, std::uint64_t first)
{
    HostPicture picture(gl(), glm::ivec2(scene.resolution));
    const FrameReport report = draw_frames(renderer, view, picture, scene, settings, frames, first);
    layers = renderer.read_layers(view, picture.frame, settings);
    return report;
}

void HistoryTest::expect_dropped_for_reasons(
    Scene scene, Settings settings, const Settings& others,
    const std::function<std::vector<float>(const Scene&, const Settings&, std::uint64_t number)>&
        fresh)
{
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    run(renderer, view, scene, settings, 3);
    std::uint64_t number = 5;
    const auto expect_dropped = [&](const char* why) {
        EXPECT_EQ(run(renderer, view, scene, settings, 1, number).history, why);
        const std::vector<float> shown = layers.scattering;
        EXPECT_EQ(shown, fresh(scene, settings, number)) << why;
        ++number;
    };
    scene.camera.look_at = {0.45, -1, 0};  // 24 degrees
    expect_dropped("dropped: a cut");
    scene.camera.position = {-2, 0, 0};  // most of what is seen lies elsewhere
    scene.camera.look_at = {0, -5, 0};
    expect_dropped("dropped: a cut");
    settings = others;
    expect_dropped("dropped: settings changed");
    view.reset_history();
    expect_dropped("none: first frame");
    EXPECT_EQ(run(renderer, view, scene, settings, 1, number).history, "kept: nothing moved");
    const std::vector<float> mean = layers.scattering;
    EXPECT_NE(mean, fresh(scene, settings, number)) << "two frames' mean";
}

}  // namespace fumarole::test
