// Grids whose parts lie far apart, and constant tiles as large as files may have them: each part
// looks as it does alone, and what is seen through it is its closed form.

#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "image_test.h"

namespace fumarole::test {
namespace {

class FarMedia : public ImageTest {};

constexpr double kVoxel = 0.15;  // m
constexpr glm::ivec3 kFarBricks(25000, -3000, 7000);

/// A lump 5 m ahead of the eye.
glm::dmat4 ahead()
{
    return glm::translate(glm::dmat4(1.0), glm::dvec3(-1.1, -6.2, -1.1)) *
           glm::scale(glm::dmat4(1.0), glm::dvec3(kVoxel));
}

/// The same bricks once more, far away.
std::shared_ptr<VoxelGrid> twice(const VoxelGrid& one)
{
    auto both = std::make_shared<VoxelGrid>(one);
    both->bricks.clear();
    both->values.clear();
    // Along z, then y, then x: the far ones come last.
    for (const glm::ivec3 offset : {glm::ivec3(0), kFarBricks})
        for (std::size_t i = 0; i < one.bricks.size(); ++i) {
            both->bricks.push_back(one.bricks[i] + offset);
            const auto begin = one.values.begin() + static_cast<std::ptrdiff_t>(512 * i);
            both->values.insert(both->values.end(), begin, begin + 512);
        }
    both->index_min = glm::min(one.index_min, one.index_min + 8 * kFarBricks);
    both->index_max = glm::max(one.index_max, one.index_max + 8 * kFarBricks);
    return both;
}

Scene scene_of(std::shared_ptr<const VoxelGrid> grid, glm::dvec3 moved)
{
    Scene scene;
    scene.resolution = {48, 48};
    scene.camera.position = moved;
    scene.camera.look_at = moved + glm::dvec3(0, -1, 0);
    scene.camera.up = {0, 0, 1};
    scene.camera.vfov_deg = 40;
    scene.camera.near = 0.1;
    scene.camera.far = 1e6;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.7, 0.3, 0.6)), glm::vec3(3)}};
    GridMedium smoke;
    smoke.density = std::move(grid);
    smoke.sigma_s_per_density = glm::vec3(1.2f);
    smoke.sigma_a_per_density = glm::vec3(0.3f);
    scene.media = {smoke};
    return scene;
}

TEST_F(FarMedia, EachPuffOfTwoLooksAsItDoesAlone)
{
    const std::shared_ptr<VoxelGrid> one = lump(ahead()), both = twice(*one);
    const glm::dvec3 far = kVoxel * 8 * glm::dvec3(kFarBricks);
    Settings settings = plain_settings();
    settings.shadow_volume_size = 0;
    const Still alone = render(scene_of(one, glm::dvec3(0)), settings);
    const Image expected = picture_of(alone, alone.transmittance);
    ASSERT_LT(*std::min_element(alone.transmittance.begin(), alone.transmittance.end()), 0.3f);
    settings.shadow_volume_size = Settings::kAutomatic;
    for (const glm::dvec3 moved : {glm::dvec3(0), far}) {
        Settings default_steps = settings;
        default_steps.spacing = Settings().spacing;
        default_steps.steps = Settings().steps;
        for (const Settings& own : {settings, default_steps}) {
            const Still still = render(scene_of(both, moved), own);
            // Steps lie elsewhere: of a ray's end and, where shadows are marched, of a shadow's.
            EXPECT_TRUE(images_near(picture_of(still, still.transmittance), expected, 4e-3, 1e-3,
                                    "midpoints of other steps"));
            const Image lit = picture_of(still, still.scattering),
                        lit_alone = picture_of(alone, alone.scattering);
            EXPECT_TRUE(images_near(lit, lit_alone, 2e-3, 5e-4, "midpoints of other steps"));
            figure("transmittance",
                   max_difference(picture_of(still, still.transmittance), expected));
            figure("scattering", max_difference(lit, lit_alone));
        }
    }
}

TEST_F(FarMedia, EachPuffHasVolumesOfLightOfItsOwn)
{
    const std::shared_ptr<VoxelGrid> one = lump(ahead()), both = twice(*one);
    const glm::dvec3 far = kVoxel * 8 * glm::dvec3(kFarBricks);
    struct Case {
        const char* name;
        bool sky, two_phases;
    };
    for (const Case& c :
         {Case{"sky and sun", true, false}, {"sun", false, false}, {"of two phases", true, true}}) {
        SCOPED_TRACE(c.name);
        Settings settings = plain_settings();
        settings.bounces = Settings::kAutomatic;
        const auto lit = [&](const std::shared_ptr<VoxelGrid>& grid, glm::dvec3 moved,
                             const Settings& own) {
            Scene scene = scene_of(grid, moved);
            scene.world.radiance = c.sky ? glm::vec3(0.4f, 0.6f, 1.0f) : glm::vec3(0);
            auto& smoke = std::get<GridMedium>(scene.media[0]);
            smoke.sigma_s_per_density = glm::vec3(2.4f);
            smoke.sigma_a_per_density = glm::vec3(0.05f);
            if (c.two_phases) {
                GridMedium ahead_of_it = smoke;
                ahead_of_it.g = 0.7f;
                scene.media.push_back(ahead_of_it);
            }
            const Still still = render(scene, own);
            return picture_of(still, still.scattering);
        };
        const Image alone = lit(one, glm::dvec3(0), settings);
        Settings without = settings;
        without.ambient_volume_size = 0;
        const double light = max_difference(lit(both, far, without), alone);
        EXPECT_GT(light, 0.05) << "or there is nothing to see";
        figure("what the volumes change", light);
        for (const glm::dvec3 moved : {glm::dvec3(0), far}) {
            const Image lit_both = lit(both, moved, settings);
            EXPECT_TRUE(images_near(lit_both, alone, 2e-3, 5e-4, "midpoints of other steps"));
            figure("scattering", max_difference(lit_both, alone));
        }
    }
}

TEST_F(FarMedia, APuffWithAnotherFarBehindIt)
{
    // The eye looks from the one to the other, whose picture is far smaller than a pixel.
    const std::shared_ptr<VoxelGrid> one = lump(ahead()), both = twice(*one);
    const VoxelLookup lookup(*both);
    Scene scene = scene_of(both, glm::dvec3(0));
    const glm::dvec3 middle(0.1, -5, 0.1), to_far = glm::normalize(glm::dvec3(kFarBricks));
    scene.camera.position = middle - 5.0 * to_far;
    scene.camera.look_at = middle;
    for (const int steps : {64, Settings().steps}) {
        Settings settings = plain_settings();
        settings.steps = steps;
        const Still still = render(scene, settings);
        double worst = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const PixelRay ray = ray_of(scene, x, y);
                const double column = 1.5 * grid_column(lookup, glm::inverse(ahead()), ray.origin,
                                                        ray.direction, {0, 20}, 400);
                const double through = double{still.transmittance[std::size_t(3 * (y * 48 + x))]};
                worst = std::max(worst, std::abs(through - std::exp(-column)));
            }
        figure("transmittance", worst);
        EXPECT_LT(worst, 6e-3) << steps << " steps";
    }
}

TEST_F(FarMedia, FortySingleVoxelsOverHalfAMillion)
{
    auto grid = std::make_shared<VoxelGrid>();
    std::mt19937 random(11);
    std::uniform_int_distribution<int> place(0, (1 << 16) - 1);
    std::vector<glm::ivec3> bricks;
    for (int i = 0; i < 40; ++i)
        bricks.emplace_back(place(random), place(random), place(random));
    std::sort(bricks.begin(), bricks.end(), [](const glm::ivec3& a, const glm::ivec3& b) {
        return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
    });
    grid->bricks = bricks;
    grid->values.assign(40 * 512, 0);
    grid->index_min = glm::ivec3(1 << 30);
    for (std::size_t i = 0; i < 40; ++i) {
        grid->values[i * 512 + 4 * 64 + 4 * 8 + 4] = 1;
        grid->index_min = glm::min(grid->index_min, 8 * bricks[i] + 4);
        grid->index_max = glm::max(grid->index_max, 8 * bricks[i] + 4);
    }
    grid->max_value = 1;
    grid->active_voxels = 40;
    grid->name = "density";
    // Through a voxel's middle the field is a tent of two voxels: an optical depth of 1.
    Scene scene = scene_of(grid, glm::dvec3(0));
    std::get<GridMedium>(scene.media[0]).sigma_s_per_density = glm::vec3(0);
    std::get<GridMedium>(scene.media[0]).sigma_a_per_density = glm::vec3(1);
    scene.resolution = {33, 33};
    for (const std::size_t i : {std::size_t{0}, std::size_t{17}, std::size_t{39}}) {
        const glm::dvec3 at = 8.0 * glm::dvec3(bricks[i]) + 4.0;
        scene.camera.position = at + glm::dvec3(0, 6, 0);
        scene.camera.look_at = at;
        const Still still = render(scene, plain_settings());
        const double through = double{still.transmittance[std::size_t(3 * (16 * 33 + 16))]};
        figure(fmt::format("voxel {}", i), through);
        EXPECT_NEAR(through, std::exp(-1.0), 2e-3) << "voxel " << i;
        EXPECT_NEAR(double{still.transmittance[0]}, 1, 1e-6);
    }
}

TEST_F(FarMedia, LargeConstantTilesDimAsTheirClosedForm)
{
    for (const int dim : {512, 2048}) {  // bricks: 4096^3 and 16384^3 voxels
        auto grid = std::make_shared<VoxelGrid>();
        grid->tiles = {{glm::ivec3(0), glm::ivec3(dim - 1), glm::vec3(0.5f)}};
        grid->index_max = glm::ivec3(8 * dim - 1);
        grid->index_min = glm::ivec3(0);
        grid->max_value = 0.5f;
        grid->name = "density";
        const double width = 8 * dim;  // between the points where the field has fallen to half
        Scene scene = scene_of(grid, glm::dvec3(0));
        auto& smoke = std::get<GridMedium>(scene.media[0]);
        smoke.sigma_s_per_density = glm::vec3(0);
        smoke.sigma_a_per_density = glm::vec3(float(2 / width));
        const glm::dvec3 middle(width / 2);
        scene.camera.position = middle + glm::dvec3(0, 3 * width, 0);
        scene.camera.look_at = middle;
        scene.camera.far = 10 * width;
        const Still still = render(scene, plain_settings());
        double worst = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x) {
                const Segment in =
                    box_segment(ray_of(scene, x, y), glm::dvec3(-0.5), glm::dvec3(width - 0.5));
                // At an edge the ramp of a voxel counts for something.
                const double slack = in.length() > 0.02 * width ? 0 : 0.02;
                const double error =
                    std::abs(double{still.transmittance[std::size_t(3 * (y * 48 + x))]} -
                             std::exp(-in.length() / width));
                worst = std::max(worst, error - slack);
            }
        figure(fmt::format("{} voxels", 8 * dim), worst);
        EXPECT_LT(worst, 1e-3);
        EXPECT_LT(double{still.transmittance[std::size_t(3 * (24 * 48 + 24))]}, 0.4);
    }
}

}  // namespace
}  // namespace fumarole::test
