// Scenes that change under a history: it is clipped where it is wrong, and stays.

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <vector>

#include "history_test.h"
#include "study/metrics.h"

namespace fumarole::test {
namespace {

constexpr int kPast = 24;    ///< frames before a change
constexpr int kAfter = 8;    ///< frames behind it, in which a history has to be right again
constexpr int kTruth = 128;  ///< frames of a still whose mean is taken for the truth

struct Mode {
    const char* name;
    Settings settings;
};

std::vector<Mode> modes()
{
    Settings march;
    march.temporal = true;
    march.steps = 12;
    march.shadow_map = 256;
    march.bounces = 0;  // it's the histories' test, and the truth is 128 frames of a still
    Settings froxels;
    froxels.mode = Settings::Mode::froxel;
    froxels.slices = 32;
    froxels.shadow_map = 256;
    froxels.bounces = 0;
    Settings fine = froxels;
    fine.tile = 4;
    return {{"march", march}, {"froxels", froxels}, {"froxels_of_4", fine}};
}

/// A lump of noise in a sun and a lamp, the eye at the origin.
Scene smoke()
{
    Scene scene;
    scene.resolution = {64, 64};
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 40;
    BoxMedium cloud;
    cloud.min = {-1.6, -6.5, -1.6};
    cloud.max = {1.6, -3.5, 1.6};
    cloud.profile = NoiseProfile{.feature_size = 1.2, .octaves = 2, .threshold = 0.35, .seed = 5};
    cloud.sigma_s = glm::vec3(1.5f);
    cloud.sigma_a = glm::vec3(0.2f);
    cloud.g = 0.3f;
    scene.media = {cloud};
    scene.lights = {SunLight{{0.5, 0.3, 0.8}, glm::vec3(2)},
                    PointLight{{2.8, -3.2, 1.6}, glm::vec3(60)}};
    return scene;
}

PointLight& lamp(Scene& scene)
{
    return std::get<PointLight>(scene.lights[1]);
}

NoiseProfile& noise(Scene& scene)
{
    return std::get<NoiseProfile>(std::get<BoxMedium>(scene.media[0]).profile);
}

/// Where a light changed, what was gathered of the media stays, and so the noise of a frame that
/// has gathered as much; where the media did, all of them, what comes after the change is all there
/// is. Something that changes from frame to frame, up to frame 0, and is still from then on.
struct Life {
    const char* name;
    void (*place)(Scene& scene, int frame);
    const char* told;  ///< of frame 0
    int worth;         ///< frames of a still that are as good as what it may leave
};

void PrintTo(const Life& life, std::ostream* out)
{
    *out << life.name;
}

const std::array kLives{
    Life{"switched_on",
         [](Scene& scene, int frame) { lamp(scene).radiant_intensity *= frame < 0 ? 0.0f : 1.0f; },
         "kept, clipped: light changed", kPast},
    Life{"switched_off",
         [](Scene& scene, int frame) { lamp(scene).radiant_intensity *= frame < 0 ? 1.0f : 0.0f; },
         "kept, clipped: light changed", kPast},
    Life{"dimmed",
         [](Scene& scene, int frame) { lamp(scene).radiant_intensity *= frame < 0 ? 1.0f : 0.8f; },
         "kept, clipped: light changed", kPast},
    Life{"moved",
         [](Scene& scene, int frame) { lamp(scene).position.y += 0.1 * std::min(frame, 0); },
         "kept, clipped: light changed", kPast},
    Life{"jumped", [](Scene& scene, int frame) { lamp(scene).position.x -= frame < 0 ? 0 : 5.6; },
         "kept, clipped: light changed", kPast},
    Life{"drifting",
         [](Scene& scene, int frame) {
             noise(scene).drift = {0.6, 0, 0.3};
             scene.time = std::min(frame, 0) / 12.0;
         },
         "kept, clipped: media changed", kAfter},
};

class LivingScene : public HistoryTest {
protected:
    std::vector<float> shown(Renderer& renderer, View& view, const Scene& scene,
                             const Settings& settings, int frames, std::uint64_t first)
    {
        run(renderer, view, scene, settings, frames, first);
        return layers.scattering;
    }
    /// A view with no past.
    std::vector<float> fresh(const Scene& scene, const Settings& settings, int frames)
    {
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        View view = renderer.make_view();
        return shown(renderer, view, scene, settings, frames, 0);
    }
    /// Root of the mean square, over the mean.
    static double error(const std::vector<float>& a, const std::vector<float>& b)
    {
        double squares = 0, sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            squares += std::pow(double(a[i]) - double(b[i]), 2);
            sum += double(b[i]);
        }
        return std::sqrt(squares * static_cast<double>(a.size())) / sum;
    }
};

class Living : public LivingScene, public testing::WithParamInterface<Life> {};

TEST_P(Living, IsRightAgainEightFramesAfterAChange)
{
    const Life& life = GetParam();
    for (const auto& [name, settings] : modes()) {
        const auto scene_at = [&](int frame) {
            Scene scene = smoke();
            life.place(scene, frame);
            return scene;
        };
        const Scene after = scene_at(0);
        const std::vector<float> truth = fresh(after, settings, kTruth);
        const double gathered = error(fresh(after, settings, life.worth), truth);
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        for (int i = -kPast; i < 0; ++i) {
            const Scene scene = scene_at(i);
            renderer.set_scene(scene, settings);
            run(renderer, view, scene, settings, 1, static_cast<std::uint64_t>(i + kPast));
        }
        renderer.set_scene(after, settings);
        EXPECT_EQ(run(renderer, view, after, settings, 1, kPast).history, life.told) << name;
        const double at_once = error(layers.scattering, truth);
        const double then =
            error(shown(renderer, view, after, settings, kAfter - 1, kPast + 1), truth);
        figure(fmt::format("{}, {}: rms error at once", life.name, name), at_once);
        figure(fmt::format("{}, {}: 8 frames after", life.name, name), then);
        figure(fmt::format("{}, {}: of a still that has gathered {}", life.name, name, life.worth),
               gathered);
        EXPECT_LT(then, std::max(0.01, 2 * gathered)) << name;
        // And on it goes to the same picture.
        const double end =
            error(shown(renderer, view, after, settings, 120, kPast + kAfter), truth);
        figure(fmt::format("{}, {}: 128 frames after", life.name, name), end);
        EXPECT_LT(end, std::max(0.004, 0.25 * gathered)) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Living, testing::ValuesIn(kLives),
                         [](const auto& life) { return std::string(life.param.name); });

/// Of frames that each have another truth: with a history, and each alone.
struct Errors {
    double with = 0, alone = 0;
};

// A lamp that is another one in each frame, a medium that drifts all along: what is gathered takes
// noise away all the same.
TEST_F(LivingScene, AHistoryHelpsWhereEveryFrameIsAnother)
{
    struct Case {
        const char* name;
        void (*place)(Scene& scene, int frame);
        double gain;  ///< of the error of frames alone, at most
    };
    const Case cases[] = {{"a flickering lamp",
                           [](Scene& scene, int frame) {
                               lamp(scene).radiant_intensity *=
                                   0.4f + 0.6f * std::abs(std::sin(2.4f * float(frame)));
                           },
                           0.7},
                          {"drifting noise",
                           [](Scene& scene, int frame) {
                               noise(scene).drift = {0.6, 0, 0.3};
                               scene.time = frame / 24.0;
                           },
                           1.0}};
    for (const Case& one : cases)
        for (const auto& [name, settings] : modes()) {
            Renderer renderer(get_proc());
            View view = renderer.make_view();
            Errors errors;
            for (int i = 0; i < 24; ++i) {
                Scene scene = smoke();
                one.place(scene, i);
                renderer.set_scene(scene, settings);
                const std::string told =
                    run(renderer, view, scene, settings, 1, static_cast<std::uint64_t>(i)).history;
                if (i < 20)
                    continue;
                EXPECT_EQ(told.rfind("kept, clipped", 0), 0u) << told;
                const std::vector<float> with = layers.scattering;
                const std::vector<float> truth = fresh(scene, settings, kTruth);
                Renderer other(get_proc());
                other.set_scene(scene, settings);
                View other_view = other.make_view();
                errors.with += error(with, truth) / 4;
                errors.alone += error(shown(other, other_view, scene, settings, 1,
                                            static_cast<std::uint64_t>(i)),
                                      truth) /
                                4;
            }
            figure(fmt::format("{}, {}: rms error with a history", one.name, name), errors.with);
            figure(fmt::format("{}, {}: of frames alone", one.name, name), errors.alone);
            EXPECT_LT(errors.with, std::max(0.01, one.gain * errors.alone)) << one.name << name;
        }
}

}  // namespace
}  // namespace fumarole::test
