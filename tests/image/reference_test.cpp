// The default preset against path-traced single scattering of the same scenes, made with Cycles;
// tests/reference/README.md says how, with what noise.

#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "image_test.h"
#include "study/metrics.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

struct Case {
    const char* scene;
    /// Relative MSE above the reference's own noise.
    double transmittance, scattering, composite;
    /// Noise of the references as measured from two seeds.
    double scattering_noise, composite_noise;
    double bias;  ///< |mean error| over the mean, of each layer
    double scattering_bias;
};

// The bounds are the project's aim; measured when they were set: S1 1e-5, 3.2e-5, 3.7e-5 and a bias
// of 0.5 %; S2 1.1e-4, 1.1e-3, 2.1e-4 and a bias of 0.1 %, but of 2.6 % in its scattering: the
// exact integral on the CPU has 2.4 % more of it than the path tracer, which steps through the
// grid.
constexpr Case kCases[] = {
    {"S1", 3e-4, 1e-3, 2e-3, 1.4e-5, 8e-6, 0.01, 0.01},
    {"S2", 1e-3, 2e-3, 2e-3, 5e-4, 4e-5, 0.01, 0.03},
};

void PrintTo(const Case& bounds, std::ostream* out)
{
    *out << bounds.scene;
}

class PathTraced : public ImageTest, public testing::WithParamInterface<Case> {};

TEST_P(PathTraced, AgreesBeyondTheReferencesNoise)
{
    const Case& bounds = GetParam();
    const fs::path folder = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference";
    const fs::path file = folder / (std::string(bounds.scene) + ".json");
    if (!fs::exists(file))
        GTEST_SKIP() << "no reference pictures: " << file << " is not there";
    asset::LoadedScene loaded{asset::parse_scene(file), {}};
    for (const Medium& medium : loaded.scene.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium); grid && !fs::exists(grid->file))
            GTEST_SKIP() << "the reference's grid " << grid->file << " is not there";
    asset::load_scene_files(loaded);
    Settings settings;
    settings.bounces = 0;  // the path tracer's light scatters once
    const Still still = render(loaded.scene, settings, 16);

    const auto check = [&](const char* layer, const std::vector<float>& picture, double allowed,
                           double noise, double bias) {
        const Image reference = write::read_exr(
            folder / fmt::format("{}_{}.exr", bounds.scene, layer), {"R", "G", "B"});
        const study::Metrics m = study::compare(picture, reference.pixels);
        figure(fmt::format("{} {} relMSE", bounds.scene, layer), m.relmse);
        figure(fmt::format("{} {} bias", bounds.scene, layer), m.bias);
        EXPECT_TRUE(m.finite) << layer;
        EXPECT_LE(m.relmse, allowed + noise) << layer << ": relative MSE beyond the noise";
        EXPECT_LT(std::abs(m.bias), bias) << layer << ": bias";
    };
    check("transmittance", still.transmittance, bounds.transmittance, 0, bounds.bias);
    check("scattering", still.scattering, bounds.scattering, bounds.scattering_noise,
          bounds.scattering_bias);
    check("composite", still.composite, bounds.composite, bounds.composite_noise, bounds.bias);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PathTraced, testing::ValuesIn(kCases),
                         [](const auto& scene) { return std::string(scene.param.scene); });

}  // namespace
}  // namespace fumarole::test
