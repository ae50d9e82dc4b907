// A frame's insides: each kind against a closed form, or against the same thing read another way.
// False colours are turned back to numbers by the palette that a legend names.

#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

#include "host_picture.h"
#include "study/false_color.h"
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

using Kind = Inspection::Kind;

constexpr float kDim = 0.25f;     ///< what stays of the picture where there is nothing to show
constexpr float kOutline = 0.6f;  ///< grey of the lines around all media

float luminance(glm::vec3 rgb)
{
    return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

/// The number that a false colour stands for: the palette's luminance rises throughout.
double value_of(glm::vec3 color, const InspectionLegend& legend)
{
    double low = 0, high = 1;
    for (int i = 0; i < 40; ++i) {
        const double t = (low + high) / 2;
        const glm::vec3 at =
            study::difference_color(static_cast<float>(t), study::Difference::magnitude);
        (luminance(at) < luminance(color) ? low : high) = t;
    }
    return legend.low + (legend.high - legend.low) * (low + high) / 2;
}

class Inspect : public ImageTest {
protected:
    static InspectionStill inspect(const Scene& scene, const Settings& settings,
                                   const Inspection& inspection)
    {
        return scene_renderer().inspect(scene, settings, inspection);
    }
    static glm::vec3 color_at(const InspectionStill& still, int x, int y)
    {
        return pixel(still.pixels, still.width, x, y);
    }
    static double value_at(const InspectionStill& still, int x, int y)
    {
        return value_of(color_at(still, x, y), still.legend);
    }
    /// A box of fog 4 m ahead, 2 m deep, under a white sky.
    static Scene box_scene(int size = 48)
    {
        Scene scene = empty_scene(size);
        scene.camera.vfov_deg = 40;
        scene.world.radiance = glm::vec3(0.8f);
        BoxMedium fog;
        fog.min = {-1, -6, -1};
        fog.max = {1, -4, 1};
        fog.sigma_s = {0.3f, 0.2f, 0.1f};
        fog.sigma_a = {0, 0.1f, 0.2f};
        scene.media = {fog};
        return scene;
    }
};

TEST_F(Inspect, ADensitySliceOfABoxIsItsExtinctionInside)
{
    Scene scene = box_scene();
    const glm::dvec3 ball(0.3, -4.5, 0.2);
    constexpr double kRadius = 0.3;
    scene.surfaces = {SphereSurface{ball, kRadius, glm::vec3(0)}};
    for (const Settings& settings : plain_siblings()) {
        const InspectionStill still =
            inspect(scene, settings, {.kind = Kind::density_slice, .axis = 1, .position = 0.25});
        EXPECT_EQ(still.legend.unit, "1/m");
        EXPECT_NE(still.legend.caption.find("y = -5.5 m"), std::string::npos)
            << still.legend.caption;
        EXPECT_EQ(still.legend.low, 0);
        EXPECT_EQ(still.legend.high, 0.4) << "a round number above 0.3";
        int inside = 0, outside = 0, hidden = 0;
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x) {
                const PixelRay ray = ray_of(scene, x, y);
                const glm::dvec3 p = ray.direction * (-5.5 / ray.direction.y);
                const double edge = std::max(std::abs(p.x), std::abs(p.z)) - 1;
                const double past = glm::length(glm::cross(ray.direction, ball)) - kRadius;
                const glm::vec3 color = color_at(still, x, y);
                if (std::abs(edge) < 0.1 || std::abs(past) < 0.1 || color == glm::vec3(kOutline))
                    continue;
                if (past < 0) {
                    ++hidden;
                    ASSERT_EQ(color, glm::vec3(0)) << x << ", " << y << ": the ball is black";
                } else if (edge < 0) {
                    ++inside;
                    ASSERT_NEAR(value_of(color, still.legend), 0.3, 1e-5) << x << ", " << y;
                } else {
                    ++outside;
                    ASSERT_NEAR(color.r, kDim * 0.8f, 1e-6) << x << ", " << y;
                }
            }
        EXPECT_GT(inside, 250);
        EXPECT_GT(outside, 400);
        EXPECT_GT(hidden, 20);
    }
}

TEST_F(Inspect, ADensitySliceOfAGridIsTheGrid)
{
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 40;
    glm::dmat4 world_from_index(0.1);
    world_from_index[3] = {-1.2, -6, -1.2, 1};
    const auto ramp = [](glm::ivec3 i) { return 0.02 * i.x + 0.01 * i.z; };
    GridMedium smoke;
    smoke.density = make_grid({3, 3, 3}, world_from_index, ramp);
    smoke.sigma_s_per_density = glm::vec3(2);
    scene.media = {smoke};
    const VoxelLookup lookup(*smoke.density);
    // The slice shows 2 times the ramp, whose slopes are 0.02 and 0.01 a voxel.
    const double tolerance = 1e-4 + filter_rounding() * 2 * (0.02 + 0.01);
    for (const medium::Layout layout : {medium::Layout::dense, medium::Layout::bricks}) {
        Settings settings = plain_settings();
        settings.layout = layout;
        const InspectionStill still =
            inspect(scene, settings, {.kind = Kind::density_slice, .axis = 1, .position = 0.5});
        const double place = -6 + 0.1 * 11.5;  // bounds are the voxels -1 .. 24
        int inside = 0;
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x) {
                const PixelRay ray = ray_of(scene, x, y);
                const glm::dvec3 p = ray.direction * (place / ray.direction.y);
                const glm::vec3 color = color_at(still, x, y);
                if (std::abs(p.x) > 1.1 || std::abs(p.z) > 1.1 || color == glm::vec3(kOutline))
                    continue;
                ++inside;
                const glm::dvec3 q = glm::inverse(world_from_index) * glm::dvec4(p, 1);
                ASSERT_NEAR(value_of(color, still.legend), 2 * lookup.sample(q).x, tolerance)
                    << x << ", " << y;
            }
        EXPECT_GT(inside, 400);
    }
}

TEST_F(Inspect, LayersAreThoseOfTheComposite)
{
    Scene scene = box_scene();
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 2, 1}}};
    scene.surfaces = {SphereSurface{{0.3, -4.5, 0.2}, 0.3, glm::vec3(0.5f)}};
    for (Settings settings : {plain_settings(2), plain_froxels(4)})
        for (const auto targets : {Settings::Targets::two, Settings::Targets::mono}) {
            settings.targets = targets;
            const Still still = render(scene, settings);
            const InspectionStill through = inspect(scene, settings, {.kind = Kind::transmittance});
            const InspectionStill light = inspect(scene, settings, {.kind = Kind::scattering});
            EXPECT_EQ(through.pixels, still.transmittance) << mode_name(settings.mode);
            EXPECT_EQ(light.pixels, still.scattering) << mode_name(settings.mode);
            EXPECT_FALSE(through.legend.false_color);
            EXPECT_FALSE(light.legend.false_color);
            EXPECT_EQ(light.legend.unit, "W/m^2/sr");
        }
}

TEST_F(Inspect, DepthIsTheStillsDepth)
{
    Scene scene = box_scene();
    scene.surfaces = {SphereSurface{{0.3, -4.5, 0.2}, 0.8, glm::vec3(0.5f)},
                      BoxSurface{{-90, -90, -2}, {90, 90, -1}, glm::vec3(0.5f)}};
    const Still still = render(scene, plain_settings());
    float nearest = Still::kSkyDepth, farthest = 0;
    for (const float z : still.depth)
        if (z < Still::kSkyDepth) {
            nearest = std::min(nearest, z);
            farthest = std::max(farthest, z);
        }
    for (const double scale : {0.0, 12.0}) {
        const InspectionStill seen =
            inspect(scene, plain_settings(), {.kind = Kind::depth, .scale = scale});
        EXPECT_EQ(seen.legend.unit, "m");
        EXPECT_NEAR(seen.legend.low, nearest, 1e-5 * nearest);
        EXPECT_NEAR(seen.legend.high, scale > 0 ? scale : farthest, 1e-5 * farthest);
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x) {
                const float z = still.depth[static_cast<std::size_t>(y * still.width + x)];
                if (z == Still::kSkyDepth)
                    ASSERT_NEAR(color_at(seen, x, y).r, kDim * 0.8f, 1e-6) << "the sky is dimmed";
                else
                    ASSERT_NEAR(value_at(seen, x, y), std::min<double>(z, seen.legend.high),
                                1e-5 * seen.legend.high)
                        << x << ", " << y;
            }
    }
}

TEST_F(Inspect, SamplesAddUpToTheirCount)
{
    Scene scene = box_scene(32);
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 2, 1}}};
    glm::dmat4 world_from_index(0.1);
    world_from_index[3] = {-0.4, -5, -0.4, 1};
    GridMedium smoke;
    smoke.density = make_grid({1, 1, 1}, world_from_index, [](glm::ivec3) { return 0.5; });
    smoke.sigma_s_per_density = glm::vec3(2);
    scene.media.emplace_back(smoke);
    // Columns beyond the picture see no media, as the box lies within it: nothing is left out.
    for (Settings settings : {plain_settings(), plain_froxels(4)}) {
        settings.shadow_volume_size = 0;  // so that shadows are marched, and counted
        StillReport report;
        render(scene, settings, 1, &report);
        const InspectionStill still = inspect(scene, settings, {.kind = Kind::samples});
        EXPECT_EQ(still.legend.unit, "");
        double sum = 0;
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x)
                sum += value_at(still, x, y);
        const int share = settings.mode == Settings::Mode::froxel ? 4 * 4 : 1;
        EXPECT_GT(report.samples, 1000);
        EXPECT_NEAR(sum / share, report.samples, 1e-4 * report.samples) << mode_name(settings.mode);
    }
}

TEST_F(Inspect, ATexelsSamplesStandInAllItsPixels)
{
    const Scene scene = box_scene(32);
    const InspectionStill still = inspect(scene, plain_settings(4), {.kind = Kind::samples});
    for (int y = 0; y < still.height; ++y)
        for (int x = 0; x < still.width; ++x)
            ASSERT_EQ(color_at(still, x, y), color_at(still, x / 4 * 4, y / 4 * 4))
                << x << ", " << y;
    EXPECT_GT(value_at(still, 16, 16), 0);
    EXPECT_EQ(color_at(still, 0, 0), color_at(still, 31, 31)) << "none, in the corners";
}

TEST_F(Inspect, ASliceOfFroxelsInUniformFogIsConstant)
{
    Scene scene = empty_scene(36);
    scene.camera.vfov_deg = 40;
    scene.lights = {SunLight{{0.3, 0.2, 1}, {4, 4, 4}}};
    BoxMedium fog;
    fog.min = {-60, -60, -60};
    fog.max = {60, 2, 60};
    fog.sigma_s = {0.01f, 0.02f, 0.03f};
    scene.media = {fog};
    Settings settings = plain_froxels(8);
    settings.volume_shadows = false;
    const double expected = 0.02 * 4 / (4 * std::numbers::pi);
    for (const double position : {0.0, 0.3, 1.0}) {
        const InspectionStill still =
            inspect(scene, settings, {.kind = Kind::froxel_slice, .position = position});
        EXPECT_EQ(still.legend.unit, "W/m^2/sr/m");
        const int slice = std::min(static_cast<int>(position * 64), 63) + 1;
        EXPECT_NE(still.legend.caption.find(fmt::format("slice {} of 64", slice)),
                  std::string::npos)
            << still.legend.caption;
        for (int y = 0; y < still.height; ++y)
            for (int x = 0; x < still.width; ++x)
                ASSERT_NEAR(value_at(still, x, y), expected, 1e-4 * expected) << x << ", " << y;
    }
}

/// Points along the edges of a box, in pixels from the top left.
std::vector<glm::dvec2> edge_pixels(const Scene& scene, glm::dvec3 min, glm::dvec3 max)
{
    const glm::dmat4 clip =
        clip_from_view(scene.camera, scene.resolution, {0, 0}) * view_from_world(scene.camera);
    std::vector<glm::dvec2> pixels;
    for (int axis = 0; axis < 3; ++axis)
        for (int edge = 0; edge < 4; ++edge)
            for (double s = 0.01; s < 1; s += 0.02) {
                glm::dvec3 side;
                side[axis] = s;
                side[(axis + 1) % 3] = edge % 2;
                side[(axis + 2) % 3] = edge / 2;
                const glm::dvec4 p = clip * glm::dvec4(glm::mix(min, max, side), 1);
                const glm::dvec2 ndc = glm::dvec2(p) / p.w;
                pixels.emplace_back((ndc.x + 1) / 2 * scene.resolution.x,
                                    (1 - ndc.y) / 2 * scene.resolution.y);
            }
    return pixels;
}

TEST_F(Inspect, BricksHaveLinesWhereTheirEdgesAre)
{
    Scene scene = empty_scene(64);
    scene.camera.vfov_deg = 40;
    scene.camera.position = {0.7, 0, 0.4};
    scene.camera.look_at = {0, -5, 0};
    scene.world.radiance = glm::vec3(0.8f);
    glm::dmat4 world_from_index(0.2);
    world_from_index[3] = {-0.8, -5, -0.8, 1};
    GridMedium smoke;
    // Nothing on the brick's faces, so that its neighbours hold nothing: the brick is 0 .. 8, the
    // field 0 .. 7.
    smoke.density = make_grid({1, 1, 1}, world_from_index, [](glm::ivec3 i) {
        const bool within = glm::all(glm::greaterThan(i, glm::ivec3(0))) &&
                            glm::all(glm::lessThan(i, glm::ivec3(7)));
        return within ? (i == glm::ivec3(3) ? 0.75 : 0.25) : 0.0;
    });
    smoke.sigma_s_per_density = glm::vec3(2);
    scene.media = {smoke};
    for (const medium::Layout layout : {medium::Layout::bricks, medium::Layout::dense})
        for (const bool behind_wall : {false, true}) {
            scene.surfaces.clear();
            if (behind_wall)  // its left half
                scene.surfaces = {BoxSurface{{0, -3.2, -9}, {9, -3, 9}, glm::vec3(0)}};
            Settings settings = plain_settings();
            settings.layout = layout;
            const InspectionStill still = inspect(scene, settings, {.kind = Kind::bricks});
            EXPECT_EQ(still.legend.high, 2) << "a round number above 1.5";
            EXPECT_NE(still.legend.caption.find("the one box"), std::string::npos)
                << still.legend.caption;
            const glm::vec3 color = study::difference_color(0.75f, study::Difference::magnitude);
            const double last = layout == medium::Layout::bricks ? 8 : 7;
            const glm::dvec3 low(-0.8, -5, -0.8);
            const std::vector<glm::dvec2> edges =
                edge_pixels(scene, low, low + glm::dvec3(0.2 * last));
            int seen = 0, hidden = 0, drawn = 0;
            for (const glm::dvec2 at : edges) {
                bool found = false;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        found |= glm::distance(color_at(still, int(at.x) + dx, int(at.y) + dy),
                                               color) < 1e-5f;
                ++(found ? seen : hidden);
            }
            for (int y = 0; y < still.height; ++y)
                for (int x = 0; x < still.width; ++x) {
                    if (glm::distance(color_at(still, x, y), color) > 1e-5f)
                        continue;
                    ++drawn;
                    const bool near = std::any_of(edges.begin(), edges.end(), [&](glm::dvec2 at) {
                        return glm::distance(at, glm::dvec2(x + 0.5, y + 0.5)) < 1.5;
                    });
                    ASSERT_TRUE(near) << x << ", " << y << " is on no edge";
                }
            EXPECT_GT(drawn, 100);
            if (behind_wall) {
                EXPECT_GT(hidden, 100);
                EXPECT_GT(seen, 100);
            } else {
                EXPECT_EQ(hidden, 0);
            }
        }
}

TEST_F(Inspect, WithoutMediaInViewThereIsNothingToShow)
{
    Scene nothing = empty_scene(16), behind = empty_scene(16);
    BoxMedium fog;
    fog.min = {-1, 4, -1};
    fog.max = {1, 6, 1};
    fog.sigma_s = glm::vec3(0.3f);
    behind.media = {fog};
    for (Scene* scene : {&nothing, &behind}) {
        scene->world.radiance = glm::vec3(0.8f);
        for (const Settings& settings : plain_siblings())
            for (const InspectionInfo& info : inspection_table()) {
                if (info.kind == Kind::froxel_slice && settings.mode == Settings::Mode::raymarch)
                    continue;
                const InspectionStill still = inspect(*scene, settings, {.kind = info.kind});
                EXPECT_LT(still.legend.low, still.legend.high) << info.name;
                const float expected = info.kind == Kind::scattering      ? 0
                                       : info.kind == Kind::transmittance ? 1
                                                                          : kDim * 0.8f;
                for (const float v : still.pixels)
                    ASSERT_NEAR(v, expected, 1e-6) << info.name;
            }
    }
}

TEST_F(Inspect, WritesColourAloneAndKeepsItsAlpha)
{
    const Scene scene = box_scene();
    HostPicture picture(gl(), glm::ivec2(scene.resolution));
    picture.look(scene.camera);
    for (const Settings& settings : plain_siblings()) {
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        for (const InspectionInfo& info : inspection_table()) {
            if (info.kind == Kind::froxel_slice && settings.mode == Settings::Mode::raymarch)
                continue;
            picture.fill(glm::vec3(0.2f), scene.camera.near,
                         [](int, int y) { return y < 9 ? 0 : 5; });
            const std::vector<float> depth = gl::read_texture(gl(), picture.frame.depth, 1, true);
            renderer.inspect(view, picture.frame, settings, {.kind = info.kind});
            const std::vector<float> rgba = gl::read_texture(gl(), picture.frame.color, 4);
            for (std::size_t i = 3; i < rgba.size(); i += 4)
                ASSERT_EQ(rgba[i], 0.5f) << info.name;
            EXPECT_EQ(gl::read_texture(gl(), picture.frame.depth, 1, true), depth) << info.name;
        }
    }
}

TEST_F(Inspect, RefusesWhatCannotBeShown)
{
    const Scene scene = box_scene(16);
    const auto message = [&](const Inspection& inspection) -> std::string {
        try {
            inspect(scene, plain_settings(), inspection);
        } catch (const Error& error) {
            return error.what();
        }
        return "nothing was refused";
    };
    EXPECT_EQ(message({.kind = Kind::froxel_slice}),
              "froxel-slice: a ray march has no froxels; use FrameSettings::mode froxel");
    EXPECT_EQ(message({.kind = Kind::density_slice, .axis = 3}),
              "a slice's axis is 0, 1 or 2, and not 3");
    EXPECT_EQ(message({.kind = Kind::density_slice, .position = 1.5}),
              "a slice's position is 0..1, and not 1.5");
    EXPECT_EQ(message({.kind = Kind::depth, .scale = -1}),
              "a colour scale ends above 0, and not at -1");
    EXPECT_EQ(message({.kind = Kind::probe, .probe = 2}),
              "there is no probe 2: the scene has 0; probes count from 0");
    EXPECT_THROW(find_inspection("no-such"), Error);
    for (const InspectionInfo& info : inspection_table())
        EXPECT_EQ(find_inspection(inspection_name(info.kind)), info.kind);
}

}  // namespace
}  // namespace fumarole::test
