// A voxel grid on the GPU, in every layout and storage, against VoxelLookup in double: what is
// uploaded, how it is bound and what glsl/lib/grid.glsl makes of it.

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "medium/media_set.h"
#include "shared/bindings.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

using medium::Layout;
using medium::Storage;

/// Random bricks, one at negative indices, a tile of 2 bricks, gaps; values up to `largest`.
std::shared_ptr<VoxelGrid> make_grid(int channels, float largest)
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "random";
    grid->channels = channels;
    grid->bricks = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 2, 1}};
    std::mt19937 random(13);
    std::uniform_real_distribution<float> value(0, largest);
    for (std::size_t i = 0; i < grid->bricks.size() * 512 * std::size_t(channels); ++i)
        grid->values.push_back(value(random));
    grid->values[0] = largest;
    // A constant region beside bricks and beside air, and one large enough for pages that are one
    // constant, which its last layer of bricks is not.
    grid->tiles = {{{0, 0, 1}, {1, 0, 1}, glm::vec3(0.75f, 0.5f, 0.25f) * largest},
                   {{0, 1, 2}, {2, 3, 4}, glm::vec3(0.3f, 0.6f, 0.9f) * largest}};
    grid->index_min = {-8, 0, 0};
    grid->index_max = {23, 31, 39};
    grid->active_voxels = (grid->bricks.size() + 2 + 27) * 512;
    grid->max_value = largest;
    return grid;
}

struct SamplingCase {
    int channels;
    Layout layout;
    Storage storage;
    float largest;
};

std::string name_of(const SamplingCase& c)
{
    constexpr std::array kLayout{"auto", "dense", "bricks"};
    constexpr std::array kStorage{"auto", "r32f", "r16f", "r8"};
    return fmt::format("{}_{}_{}_max1e{}", c.channels == 1 ? "scalar" : "rgb",
                       kLayout.at(std::size_t(c.layout)), kStorage.at(std::size_t(c.storage)),
                       c.largest < 1 ? "m6"
                                     : fmt::format("{}", std::lround(std::log10(c.largest))));
}

class GridSampling : public GlTest, public testing::WithParamInterface<SamplingCase> {};

TEST_P(GridSampling, AgreesWithVoxelLookup)
{
    const SamplingCase& c = GetParam();
    auto grid = make_grid(c.channels, c.largest);
    // Turned, squeezed and far away: the eye is near it, so nothing is lost.
    glm::dmat4 world_from_index = glm::translate(glm::dmat4(1.0), glm::dvec3(1e5, -2e4, 300));
    world_from_index = glm::rotate(world_from_index, 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
    grid->world_from_index = glm::scale(world_from_index, glm::dvec3(0.5, 0.25, 0.125));
    GridMedium medium;
    medium.density = grid;
    Scene scene;
    scene.media = {medium};
    medium::MediaSet media(gl());
    Settings settings;
    settings.layout = c.layout;
    settings.storage = c.storage;
    media.set(scene, settings);
    const glm::dvec3 eye(1e5 + 2, -2e4, 301);
    media.bind(eye);
    const Kernel kernel(gl(), R"(
#include "scene/media.glsl"
void kernel(int i) { out_data[i] = vec4(sample_media(in_data[i].xyz).sigma_s, 0.0); }
)",
                        1, 1, media.defines());

    std::mt19937 random(17);
    std::uniform_real_distribution<double> x(-12, 28), y(-4, 36), z(-4, 44);
    std::uniform_int_distribution<int> whole(-2, 6);
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 20000; ++i) {
        glm::dvec3 p(x(random), y(random), z(random));
        for (int axis = 0; axis < 3; ++axis)  // on and beside brick borders
            if (i % 4 == axis)
                p[axis] = 8.0 * whole(random) + (i % 8 < 4 ? 0.0 : -1e-4);
        points.push_back(p);
    }
    std::vector<glm::vec4> inputs;
    for (const glm::dvec3& p : points)
        inputs.emplace_back(glm::vec3(glm::dvec3(grid->world_from_index * glm::dvec4(p, 1)) - eye),
                            0.0f);
    const std::vector<glm::vec4> values = kernel(inputs);

    // Of the largest value. Rounding of storage; of texture coordinates, whose error of some 1e-6
    // texture widths meets a slope of one voxel; hardware filters with weights of 8 bits, and
    // llvmpipe filters 8-bit texels in 8 bits, rounding each of three times.
    const bool software = gl().capabilities().software;
    const double storage = c.storage == Storage::r8     ? (software ? 2.0 : 0.5) / 255
                           : c.storage == Storage::r16f ? 0.5 / 2048
                                                        : 0.0;
    const double filter = software ? 2e-4 : 3.0 / 256;
    const double tolerance = (storage + filter) * c.largest;
    const VoxelLookup lookup(*grid);
    const glm::dmat4 index_from_world = glm::inverse(grid->world_from_index);
    double inside = 0, mean_error = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        // Where the float that was sent lies.
        const glm::dvec3 p(index_from_world * glm::dvec4(glm::dvec3(inputs[i]) + eye, 1));
        glm::dvec3 expected = lookup.sample(p);
        if (c.channels == 1)
            expected = glm::dvec3(expected.x);
        for (int channel = 0; channel < 3; ++channel) {
            ASSERT_NEAR(values[i][channel], expected[channel], tolerance)
                << "at index " << p.x << ' ' << p.y << ' ' << p.z;
            inside += expected[channel] > 0 ? 1 : 0;
            mean_error += (values[i][channel] - expected[channel]) / c.largest;
        }
    }
    EXPECT_GT(inside, 6000);
    EXPECT_NEAR(mean_error / inside, 0, c.storage == Storage::r8 ? 0.5 / 255 : 1e-4)
        << "no bias past the rounding of a constant";
    gl()->BindBufferBase(GL_UNIFORM_BUFFER, MEDIA_BLOCK, 0);
}

/// Three bricks in a row and one behind them, each a hundredth of the one before, beside each other
/// so that their shared layers are read by both scales.
std::shared_ptr<VoxelGrid> fading_grid()
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "fading";
    grid->bricks = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}};
    std::mt19937 random(29);
    std::uniform_real_distribution<float> value(0.5f, 1);
    for (float largest = 100; grid->values.size() < 4 * 512;
         largest *= grid->values.size() % 512 == 0 ? 0.01f : 1)
        grid->values.push_back(largest * value(random));
    grid->index_min = {0, 0, 0};
    grid->index_max = {23, 15, 7};
    grid->active_voxels = 4 * 512;
    grid->max_value = *std::max_element(grid->values.begin(), grid->values.end());
    return grid;
}

using GridScale = GlTest;

// What the GPU decodes is what each brick's own scale promises, and so never what another's would.
TEST_F(GridScale, IsTheBricksOwn)
{
    const auto grid = fading_grid();
    GridMedium medium;
    medium.density = grid;
    Scene scene;
    scene.media = {medium};
    medium::MediaSet media(gl());
    Settings settings;
    settings.layout = Layout::bricks;
    settings.storage = Storage::r8;
    media.set(scene, settings);
    media.bind(glm::dvec3(0));
    const Kernel kernel(gl(), R"(
#include "scene/media.glsl"
void kernel(int i) { out_data[i] = vec4(sample_media(in_data[i].xyz).sigma_s, 0.0); }
)",
                        1, 1, media.defines());
    std::mt19937 random(31);
    std::uniform_real_distribution<float> unit(0.02f, 0.98f);
    std::vector<glm::vec4> inputs;
    for (int z = -1; z < 8;
         ++z)  // one point in each cell between 8 voxels, so of one page for sure
        for (int y = -1; y < 16; ++y)
            for (int x = -1; x < 24; ++x)
                inputs.emplace_back(float(x) + unit(random), float(y) + unit(random),
                                    float(z) + unit(random), 0.0f);
    const std::vector<glm::vec4> values = kernel(inputs);
    const VoxelLookup lookup(*grid);
    // As in AgreesWithVoxelLookup; but of the page's largest value, rounded up by an eighth.
    const bool software = gl().capabilities().software;
    const double relative = 1.125 * (software ? 2.0 / 255 : 0.5 / 255 + 3.0 / 256) + 2e-4;
    std::array<int, 4> seen{};
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        const glm::ivec3 page = glm::floor(glm::vec3(inputs[i]) / 8.0f);
        double most = 0;
        for (int v = 0; v < 729; ++v)
            most = std::max(
                most, double{lookup.value(page * 8 + glm::ivec3{v % 9, v / 9 % 9, v / 81}).x});
        ASSERT_NEAR(double{values[i].x}, lookup.sample(glm::dvec3(inputs[i])).x,
                    relative * std::max(most, std::exp2(-16.0) * double{grid->max_value}))
            << "at " << inputs[i].x << ' ' << inputs[i].y << ' ' << inputs[i].z;
        const auto decade = static_cast<int>(-std::log10(most / double{grid->max_value}) / 2 + 0.1);
        if (most > 0)
            ++seen.at(static_cast<std::size_t>(std::min(decade, 3)));
    }
    EXPECT_GT(*std::min_element(seen.begin(), seen.end()), 100) << "all scales are met";
    gl()->BindBufferBase(GL_UNIFORM_BUFFER, MEDIA_BLOCK, 0);
}

std::vector<SamplingCase> sampling_cases()
{
    std::vector<SamplingCase> cases;
    for (const int channels : {1, 3})
        for (const Layout layout : {Layout::dense, Layout::bricks})
            for (const Storage storage : {Storage::r32f, Storage::r16f, Storage::r8})
                for (const float largest : {1e-6f, 1.0f, 1e6f})
                    cases.push_back({channels, layout, storage, largest});
    return cases;
}

INSTANTIATE_TEST_SUITE_P(Layouts, GridSampling, testing::ValuesIn(sampling_cases()),
                         [](const auto& test) { return name_of(test.param); });

using GridBounds = GlTest;

TEST_F(GridBounds, EndOneVoxelPastTheValues)
{
    GridMedium medium;
    auto grid = make_grid(1, 1);
    grid->world_from_index = glm::scale(glm::dmat4(1.0), glm::dvec3(0.5));
    medium.density = grid;
    medium.translate = {10, 0, 0};
    medium.scale = 2;
    Scene scene;
    scene.media = {medium};
    for (const Layout layout : {Layout::dense, Layout::bricks}) {
        medium::MediaSet media(gl());
        Settings settings;
        settings.layout = layout;
        media.set(scene, settings);
        const Bounds bounds = media.bounds();
        EXPECT_NEAR(glm::length(bounds.min - glm::dvec3(10 - 9, -1, -1)), 0, 1e-9);
        EXPECT_NEAR(glm::length(bounds.max - glm::dvec3(10 + 24, 32, 40)), 0, 1e-9);
    }
}

}  // namespace
}  // namespace fumarole::test
