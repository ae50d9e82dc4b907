// Volumes of light: the optical depth towards lights, and the world's light, against integrals in
// double, closed forms and the reference on the CPU.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <tuple>
#include <utility>

#include "gl/state_guard.h"
#include "host_picture.h"
#include "image_test.h"
#include "study/metrics.h"
#include "study/reference.h"
#include "support/tile_bench.h"
#include <fumarole/asset/auto_scene.h>
#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/live_scene.h>

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

class LightVolume : public ImageTest {
protected:
    /// How many of the tiles that march lie far from all lights that have places.
    static std::string far_tiles(const Scene& scene, const Settings& settings)
    {
        const gl::StateGuard guard(gl(), BLOCK_COUNT, IMAGE_COUNT, STORAGE_COUNT);
        TileBench bench(gl());
        bench.set(scene);
        const PreparedFrame frame = bench.prepare(scene, settings);
        bench.tools.bind_block(frame);
        pass::StepTiles tiles(bench.tools);
        tiles.set(frame);
        int marched = 0, far = 0;
        for (const glm::uvec4& tile : bench.read(*tiles.textures()[0])) {
            marched += tile.x != 0 ? 1 : 0;
            far += tile.x != 0 && shared::tile_is_far(tile.w) ? 1 : 0;
        }
        return far == 0 ? "none" : far < marched ? "some" : "all";
    }

    /// Lines of explain() that name a volume; they tell the time that it was filled in.
    static std::vector<std::string> volumes(const Renderer& renderer)
    {
        std::vector<std::string> lines = renderer.explain(Settings{});
        std::erase_if(lines, [](const std::string& line) {
            return line.find("filled") == std::string::npos;
        });
        return lines;
    }
};

// -- shadows -------------------------------------------------------------------------------------

struct ShadowCase {
    const char* name;
    Light light;
    glm::dmat4 turn{1.0};  ///< of the grid about its middle
};

void PrintTo(const ShadowCase& shadow, std::ostream* out)
{
    *out << shadow.name;
}

/// 16 voxels across about (0, -5, 0), turned about that point.
GridMedium turned_lump(const glm::dmat4& turn)
{
    GridMedium smoke;
    const glm::dmat4 world_from_index = glm::translate(glm::dmat4(1.0), glm::dvec3(0, -5, 0)) *
                                        turn * glm::scale(glm::dmat4(1.0), glm::dvec3(0.25)) *
                                        glm::translate(glm::dmat4(1.0), glm::dvec3(-7.5, -7, -8));
    smoke.density = lump(world_from_index);
    smoke.sigma_s_per_density = {0.5f, 1.5f, 3.0f};
    smoke.sigma_a_per_density = {0.2f, 0.5f, 0.8f};
    smoke.g = 0.3f;
    return smoke;
}

const std::array kShadowCases{
    ShadowCase{"sun", SunLight{{0.7, 0.3, 0.6}, glm::vec3(4)}},
    // Columns along each axis and both ways, on a tie of two axes, and straight.
    ShadowCase{"sun_from_minus_x", SunLight{{-0.9, 0.3, 0.2}, glm::vec3(4)}},
    ShadowCase{"sun_from_minus_y", SunLight{{0.3, -0.8, 0.4}, glm::vec3(4)}},
    ShadowCase{"sun_on_the_diagonal", SunLight{{1, -1, 1}, glm::vec3(4)}},
    ShadowCase{"sun_overhead", SunLight{{0, 0, 1}, glm::vec3(4)}},
    ShadowCase{"point_outside", PointLight{{2.5, -4, 2.0}, glm::vec3(30)}},
    ShadowCase{"point_inside", PointLight{{0.4, -5.2, 0.3}, glm::vec3(5)}},
    ShadowCase{"spot", SpotLight{{1.5, -2.5, 2.0}, {-0.4, -0.6, -0.5}, 60, 0.5, glm::vec3(30)}},
    ShadowCase{"sun_in_a_turned_grid", SunLight{{0.7, 0.3, 0.6}, glm::vec3(4)},
               glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(0.3, 0.5, 0.8))},
    ShadowCase{"point_in_a_sheared_grid", PointLight{{2.5, -4, 2.0}, glm::vec3(30)},
               glm::dmat4(1, 0, 0, 0, 0.5, 1, 0, 0, -0.3, 0.2, 0.7, 0, 0, 0, 0, 1)},
};

class ShadowVolume : public LightVolume, public testing::WithParamInterface<ShadowCase> {};

TEST_P(ShadowVolume, AgreesWithTheIntegral)
{
    const ShadowCase& shadow = GetParam();
    Scene scene = empty_scene(12);
    scene.camera.vfov_deg = 40;
    const GridMedium smoke = turned_lump(shadow.turn);
    scene.media = {smoke};
    scene.lights = {shadow.light};

    const VoxelLookup lookup(*smoke.density);
    const glm::dmat4 index_from_world = glm::inverse(smoke.density->world_from_index);
    const glm::dvec3 sigma_s(smoke.sigma_s_per_density),
        sigma_t(smoke.sigma_s_per_density + smoke.sigma_a_per_density);
    const glm::dvec3 low(-4, -9, -4), high(4, -1, 4);  // around the field, however it is turned
    const auto light_at = [&](glm::dvec3 p) -> std::tuple<glm::dvec3, double, double> {
        if (const auto* sun = std::get_if<SunLight>(&shadow.light))
            return {glm::normalize(sun->direction_to_light), 1e9, double(sun->irradiance.x)};
        const auto* spot = std::get_if<SpotLight>(&shadow.light);
        const auto* point = std::get_if<PointLight>(&shadow.light);
        const glm::dvec3 to_light = (spot ? spot->position : point->position) - p;
        const double d = glm::length(to_light);
        double power = double(spot ? spot->radiant_intensity.x : point->radiant_intensity.x);
        if (spot) {
            const double edge = std::cos(spot->cone_deg * kPi / 360);
            const double x = (glm::dot(-to_light / d, glm::normalize(spot->direction)) - edge) /
                             ((1 - edge) * spot->blend);
            power *= glm::smoothstep(0.0, 1.0, x);
        }
        return {to_light / d, d, power / (d * d)};
    };
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const Segment inside = box_segment(ray, low, high);
        constexpr int kSteps = 400;
        const double ds = inside.length() / kSteps;
        double column = 0;
        glm::dvec3 radiance(0);
        for (int i = 0; i < kSteps && ds > 0; ++i) {
            const glm::dvec3 p = ray.origin + ray.direction * (inside.begin + (i + 0.5) * ds);
            const double density = lookup.sample(glm::dvec3(index_from_world * glm::dvec4(p, 1))).x;
            if (density == 0)
                continue;
            const auto [wi, range, irradiance] = light_at(p);
            Segment way = box_segment({p, wi, 1}, low, high);
            way.end = std::min(way.end, range);
            const double dark = grid_column(lookup, index_from_world, p, wi, way, 30);
            radiance += density * sigma_s * irradiance *
                        henyey_greenstein(glm::dot(wi, ray.direction), 0.3) *
                        glm::exp(-sigma_t * (dark + column + density * ds / 2)) * ds;
            column += density * ds;
        }
        return radiance;
    });
    double mean = 0;
    for (const float v : truth.pixels)
        mean += double(v) / static_cast<double>(truth.pixels.size());
    ASSERT_GT(mean, 0);
    for (Settings settings : plain_siblings()) {
        set_steps(settings, 512);
        const Still still = render(scene, settings);
        const study::Metrics kept = study::compare(still.scattering, truth.pixels);
        figure(fmt::format("{}, {}: relMSE", shadow.name, mode_name(settings.mode)), kept.relmse);
        EXPECT_LT(kept.relmse, 1e-4) << mode_name(settings.mode);
        settings.shadow_volume_size = 4;  // far too coarse: the volume is what is looked at
        const study::Metrics coarse =
            study::compare(render(scene, settings).scattering, truth.pixels);
        EXPECT_GT(coarse.relmse, 3 * kept.relmse) << mode_name(settings.mode);
    }
}

INSTANTIATE_TEST_SUITE_P(Lights, ShadowVolume, testing::ValuesIn(kShadowCases),
                         [](const auto& shadow) { return std::string(shadow.param.name); });

TEST_F(LightVolume, SurfacesBesideTheSmokeAreShadedByIt)
{
    Scene scene = empty_scene(24);
    scene.camera.position = {0, 0, 9};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.up = {0, 1, 0};
    scene.camera.vfov_deg = 60;
    scene.surfaces = {BoxSurface{{-50, -50, -1}, {50, 50, 0}, glm::vec3(1)}};
    GridMedium smoke = turned_lump(glm::dmat4(1.0));
    smoke.translate = {0, 5, 3};
    scene.media = {smoke};
    const Light below = PointLight{{0.2, 0.1, 6.5}, glm::vec3(20)};
    const Light sun = SunLight{{0.5, 0.2, 1}, glm::vec3(3)};
    for (const Light& light : {below, sun}) {
        scene.lights = {light};
        Settings settings = plain_settings();
        const Still kept = render(scene, settings);
        settings.shadow_volume_size = 0;
        settings.shadow_steps = 128;  // times 4 on surfaces
        const Still marched = render(scene, settings);
        const Image lit = picture_of(kept, kept.surface_lit);
        const double largest = *std::max_element(lit.pixels.begin(), lit.pixels.end());
        EXPECT_LT(rms_difference(lit, picture_of(marched, marched.surface_lit)), 4e-3 * largest)
            << "the volume rounds the shadow's edge over a node";
        EXPECT_GT(max_difference(lit, picture_of(kept, kept.surface)), 0.3 * largest)
            << "there is a shadow";
    }
}

// A software rasteriser asks the media of suns only where a surface may be dimmed by them. A lamp
// without any light has it ask all over.
TEST_F(LightVolume, SunsAreAskedForWhereverMediaDimThem)
{
    Scene scene = empty_scene(32);
    scene.resolution = {80, 144};
    scene.camera.vfov_deg = 60;
    GridMedium smoke = turned_lump(glm::dmat4(1.0));
    smoke.translate = {0, 5, 3};
    scene.media = {smoke};
    scene.surfaces = {BoxSurface{{-50, -50, -1}, {50, 50, 0}, glm::vec3(1)},
                      BoxSurface{{2.5, -50, -1}, {3, 50, 9}, glm::vec3(1)},
                      SphereSurface{{-1, 0.5, 1.2}, 0.5, glm::vec3(1)}};
    const Light dim = PointLight{{0, 20, 20}, glm::vec3(0)};
    const std::vector<Light> suns{SunLight{{-0.8, 0.2, 1}, glm::vec3(3)},
                                  SunLight{{0.1, -0.7, 0.6}, glm::vec3(1, 2, 3)}};
    const std::vector<std::pair<glm::dvec3, glm::dvec3>> eyes{
        {{0, -0.1, 9}, {0, 0, 0}},      // above
        {{-7, -5, 2.5}, {0.5, 0, 1}},   // beside
        {{1.8, 0, 1}, {-3, 0.5, 0}},    // in the shadow
        {{-0.5, -0.3, 3}, {3, 1, 0}}};  // in the smoke
    Settings settings = plain_settings();
    settings.bounces = settings.surface_bounces = 0;
    for (std::size_t count : {1, 2})
        for (const auto& [eye, at] : eyes) {
            SCOPED_TRACE(fmt::format("{} suns from {}, {}, {}", count, eye.x, eye.y, eye.z));
            scene.camera.position = eye;
            scene.camera.look_at = at;
            scene.lights.assign(suns.begin(), suns.begin() + static_cast<std::ptrdiff_t>(count));
            const Still parts = render(scene, settings);
            scene.lights.push_back(dim);
            const Still whole = render(scene, settings);
            const Image lit = picture_of(parts, parts.surface_lit);
            const double largest = *std::max_element(lit.pixels.begin(), lit.pixels.end());
            EXPECT_LT(max_difference(lit, picture_of(whole, whole.surface_lit)), 2e-6 * largest);
            EXPECT_GT(max_difference(lit, picture_of(parts, parts.surface)), 0.1 * largest)
                << "there is a shadow";
        }
}

// -- many lights ---------------------------------------------------------------------------------

/// On a ball of 8 to 11 m around the lump, each of a strength and a colour of its own.
std::vector<Light> points_around(int count)
{
    std::vector<Light> points;
    for (int i = 0; i < count; ++i) {
        const double turn = 2.4 * i, up = 0.9 * std::sin(1.7 * i), range = 8 + i * 5 % 4;
        const double out = std::sqrt(1 - up * up);
        const glm::dvec3 way(std::cos(turn) * out, std::sin(turn) * out, up);
        const glm::vec3 color(0.5f + 0.2f * static_cast<float>(i % 3), 1,
                              1.4f - 0.2f * static_cast<float>(i % 5));
        points.emplace_back(PointLight{glm::dvec3(0, -5, 0) + range * way,
                                       color * (100.0f + 40.0f * static_cast<float>(i % 4))});
    }
    return points;
}

struct ManyLightsCase {
    const char* name;
    std::vector<Light> lights;
    float g = 0;
    int steps = 250, alone_steps = 250;
    glm::vec3 haze{0};  ///< of a box around the lump, or instead of it [1/m]
    bool lump = true;
    std::vector<Surface> surfaces{};
    bool volume_shadows = true;
    /// With light that scatters again, of which a part is guessed: not a sum, so that the lights
    /// are held to themselves where nothing is told of tiles.
    bool bounces = false;
    bool all_far = true;    ///< all tiles are far from all lights; else some are
    double most_error = 0;  ///< relMSE
};

void PrintTo(const ManyLightsCase& many, std::ostream* out)
{
    *out << many.name;
}

/// Where steps are 3 cm and lights 8 m away, 1/d^2 and the phase are those of a step's middle to
/// the square of their quotient, 2e-5, and the light has its middle 1e-3 of a step from there,
/// where a medium of 5/m has dimmed it by 2e-4 more or less.
constexpr double kOfFineSteps = 2e-4 * 2e-4;
/// A parabola is 1/d^2 to 2.5e-4 where half a step is an eighth of the distance, the most of any.
constexpr double kOfParabola = 2.5e-4 * 2.5e-4;

std::vector<ManyLightsCase> many_lights_cases()
{
    const std::vector<Light> five = points_around(5);
    std::vector<Light> of_all_kinds = five;
    of_all_kinds.emplace(of_all_kinds.begin(), SunLight{{0.5, 0.5, 0.7}, glm::vec3(2)});
    of_all_kinds.emplace_back(SpotLight{{7, -12, 4}, {-0.65, 0.65, -0.4}, 50, 0.5, glm::vec3(500)});
    of_all_kinds.emplace_back(SpotLight{{-8, -2, -3}, {0.8, -0.3, 0.3}, 40, 0.5, {90, 300, 200}});
    std::vector<Light> with_area = five;
    with_area.emplace_back(RectLight{.center = {-6, -5, 7},
                                     .edges = {glm::dvec3(1, 0, 0), glm::dvec3(0, 0.8, 0.3)},
                                     .radiance = glm::vec3(70)});
    // Outside: lamps among media have a finer layer around them, whose tiles are all near.
    std::vector<Light> one_close = five;
    one_close.emplace_back(PointLight{{0.3, -5, 1.05}, {1.5f, 2, 2.5f}});
    // Ahead, behind and beside: cosines from -1 to 1 are what the parabola is of.
    const std::vector<Light> along{PointLight{{0.3, -13, 0.2}, {60, 20, 10}},
                                   PointLight{{-0.4, 3.5, 0.1}, {30, 70, 20}},
                                   PointLight{{7, -5, 5}, {10, 20, 50}}};
    // Each hides some of the lights from some of the smoke.
    const std::vector<Surface> boxes{BoxSurface{{-1.5, -6, -3.2}, {0.5, -4, -3}},
                                     BoxSurface{{3, -6.5, -1}, {3.2, -5, 1.5}},
                                     BoxSurface{{-4, -3.4, 2}, {-2, -3.2, 4}}};
    const glm::vec3 thin(0.05f, 0.1f, 0.02f);
    return {
        {.name = "of_all_kinds", .lights = of_all_kinds, .g = 0.8f, .most_error = kOfFineSteps},
        {.name = "with_an_area", .lights = with_area, .g = 0.3f, .most_error = kOfFineSteps},
        {.name = "scattering_again",
         .lights = with_area,
         .g = 0.8f,
         .bounces = true,
         .most_error = kOfFineSteps},
        {.name = "in_haze", .lights = five, .g = 0.3f, .haze = thin, .most_error = kOfFineSteps},
        {.name = "one_close",
         .lights = one_close,
         .steps = 24,
         .alone_steps = 24,
         .haze = thin,
         .lump = false,
         .all_far = false,
         .most_error = kOfParabola},
        {.name = "behind_surfaces",
         .lights = points_around(16),
         .g = 0.3f,
         .surfaces = boxes,
         .most_error = kOfFineSteps},
        {.name = "of_long_steps",
         .lights = along,
         .steps = 8,
         .alone_steps = 1000,  // 1/d^2 over long ones has a lamp ahead in their middle
         .haze = glm::vec3(0.3f),
         .lump = false,
         .volume_shadows = false,
         .most_error = kOfParabola},
    };
}

class ManyLights : public LightVolume, public testing::WithParamInterface<ManyLightsCase> {};

/// What media scatter of several lights is the sum of what they scatter of each: with one there is
/// neither a parabola for lights that are far nor a fetch for four of them, and surfaces are asked.
TEST_P(ManyLights, AreTheSumOfThemOneByOne)
{
    const ManyLightsCase& many = GetParam();
    Scene scene = empty_scene(48);
    scene.camera.vfov_deg = 50;
    scene.surfaces = many.surfaces;
    if (many.lump) {
        scene.media.emplace_back(turned_lump(glm::dmat4(1.0)));
        std::get<GridMedium>(scene.media.back()).g = many.g;
    }
    if (many.haze != glm::vec3(0)) {
        BoxMedium haze;
        haze.min = {-1, -8, -1};
        haze.max = {1, -2, 1};
        haze.sigma_s = many.haze;
        scene.media.emplace_back(haze);
    }
    Settings settings = plain_settings();
    settings.steps = many.alone_steps;
    settings.empty_space_skipping = false;  // so that nothing is told of tiles
    settings.falloff = Settings::Falloff::exact;
    settings.volume_shadows = many.volume_shadows;
    if (many.bounces)
        settings.bounces = kAutomatic;

    std::vector<std::vector<Light>> one_by_one;
    for (const Light& light : many.lights)
        one_by_one.push_back({light});
    if (many.bounces)
        one_by_one = {many.lights};
    std::vector<float> sum;
    for (const std::vector<Light>& lights : one_by_one) {
        scene.lights = lights;
        const Still alone = render(scene, settings);
        sum.resize(alone.scattering.size());
        std::transform(sum.begin(), sum.end(), alone.scattering.begin(), sum.begin(),
                       std::plus<>());
    }
    scene.lights = many.lights;
    settings.steps = many.steps;
    settings.empty_space_skipping = true;
    for (const Settings::Passes passes : {Settings::Passes::fragment, Settings::Passes::compute}) {
        settings.passes = passes;
        EXPECT_EQ(far_tiles(scene, settings), many.all_far ? "all" : "some");
        const double error = study::compare(render(scene, settings).scattering, sum).relmse;
        const char* name = passes == Settings::Passes::compute ? "compute" : "fragment";
        EXPECT_LT(error, many.most_error) << name;
        figure(fmt::format("{}, {}: relMSE to the sum", many.name, name), error);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ManyLights, testing::ValuesIn(many_lights_cases()),
                         [](const auto& many) { return std::string(many.param.name); });

TEST_F(LightVolume, SeveralMediaOfSeveralColoursShareOne)
{
    Scene scene = empty_scene(16);
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)},
                    PointLight{{0.6, -4, 1.5}, glm::vec3(20)}};
    GridMedium one = turned_lump(glm::dmat4(1.0)), two = one;
    one.translate = {0.8, 0, 0.3};
    two.translate = {-0.8, -0.4, 0};
    two.sigma_s_per_density = {3.0f, 1.0f, 0.2f};
    BoxMedium haze;
    haze.min = {-5, -9, -5};
    haze.max = {5, -1, 5};
    haze.sigma_s = {0.05f, 0.1f, 0.02f};
    BoxMedium noise = haze;
    noise.min = {-2, -6, -2};
    noise.max = {0, -4, 0};
    noise.sigma_s = glm::vec3(2);
    noise.profile = NoiseProfile{.feature_size = 1.0, .octaves = 2, .seed = 5};
    scene.media = {one, haze, two, noise};
    for (Settings settings : plain_siblings()) {
        const Still kept = render(scene, settings);
        settings.shadow_volume_size = 0;
        settings.shadow_steps = 64;
        const Still marched = render(scene, settings);
        EXPECT_LT(study::compare(kept.scattering, marched.scattering).relmse, 2e-4)
            << mode_name(settings.mode);
        settings.volume_shadows = false;
        EXPECT_GT(study::compare(kept.scattering, render(scene, settings).scattering).relmse, 1e-2)
            << "media shade each other, " << mode_name(settings.mode);
    }
}

// What a ground alone leaves out: a shadow map, and light at nodes and shaders for where it is not
// asked for. Another ground below it, which no one sees, has the map drawn.
TEST_F(LightVolume, AGroundAloneIsLitAsOneThatHasAnotherBelow)
{
    Scene scene = empty_scene(64);
    scene.world.radiance = {0.5f, 0.6f, 0.8f};
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)}};
    scene.media = {turned_lump(glm::dmat4(1.0))};
    const BoxSurface ground{
        .min = {-300, -300, -3}, .max = {300, 300, -1.2}, .albedo = glm::vec3(0.5f)};
    Renderer& renderer = scene_renderer().renderer();
    render(scene, plain_settings());
    scene.surfaces = {ground};
    renderer.take_report();
    const Still alone = render(scene, plain_settings());
    EXPECT_EQ(renderer.take_report().work.shadow_views, 0);
    BoxSurface below = ground;
    below.min.z = -30;
    below.max.z = -20;
    scene.surfaces.emplace_back(below);
    const Still both = render(scene, plain_settings());
    EXPECT_GT(renderer.take_report().work.shadow_views, 0);
    EXPECT_TRUE(images_near(picture_of(alone, alone.composite), picture_of(both, both.composite),
                            1e-6, 1e-6, "where a map hides nothing"));
    // A sun that has risen leaves the map that one below the ground had drawn.
    scene.surfaces = {ground};
    auto& sun = std::get<SunLight>(scene.lights[0]);
    sun.direction_to_light.z = -0.7;
    render(scene, plain_settings());
    renderer.take_report();
    sun.direction_to_light.z = 0.7;
    EXPECT_TRUE(images_near(picture_of(alone, render(scene, plain_settings()).composite),
                            picture_of(alone, alone.composite), 1e-6, 1e-6, "at noon"));
    EXPECT_GT(renderer.take_report().work.shadow_views, 0);
    // A ball is in the map, and throws a shadow.
    scene.surfaces = {ground, SphereSurface{.center = {1, -6, -0.6}, .radius = 0.6}};
    const Still ball = render(scene, plain_settings());
    EXPECT_GT(renderer.take_report().work.shadow_views, 0);
    EXPECT_GT(study::compare(ball.composite, alone.composite).relmse, 1e-3);
}

TEST_F(LightVolume, IsFilledOverFramesWhereThatIsAsked)
{
    Scene scene = empty_scene(16);
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)},
                    PointLight{{0.6, -4, 1.5}, glm::vec3(20)}};
    scene.media = {turned_lump(glm::dmat4(1.0))};
    Settings settings = plain_settings();
    settings.shadow_fill = 3;
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    HostPicture host(gl(), glm::ivec2(16));
    host.look(scene.camera);
    const auto next_frame = [&] {
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        renderer.composite(view, host.frame, settings);
        return host.read();
    };
    const auto at_once = [&] {
        Renderer fresh(get_proc());
        View fresh_view = fresh.make_view();
        fresh.set_scene(scene, settings);
        fresh.wait_until_ready();
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        fresh.composite(fresh_view, host.frame, settings);
        return host.read();
    };
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    EXPECT_TRUE(images_near(next_frame(), at_once(), 0, 0, "first")) << "a new volume is whole";

    std::get<PointLight>(scene.lights[1]).position.x += 1.5;
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    for (int i = 0; i < 3; ++i)
        EXPECT_GT(max_difference(next_frame(), at_once()), 1e-3) << "frame " << i;
    EXPECT_TRUE(images_near(next_frame(), at_once(), 1e-3, 1e-4, "16-bit depths of other sums"));

    // What moves on while it is filled is caught up with in one more turn.
    std::get<PointLight>(scene.lights[1]).position.x -= 2.5;
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    next_frame();
    std::get<SunLight>(scene.lights[0]).direction_to_light.x = -0.8;
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    for (int i = 0; i < 5; ++i)
        EXPECT_GT(max_difference(next_frame(), at_once()), 1e-3) << "frame " << i;
    EXPECT_TRUE(images_near(next_frame(), at_once(), 1e-3, 1e-4, "16-bit depths of other sums"));
}

/// Smoke over a floor, in which light scatters on, looked at frame by frame.
struct Filming {
    Filming(const gl::Device& device, gl::GetProc get, const Settings& plain, int frames)
        : settings{plain}, get_proc{get}, host{device, glm::ivec2(16)}
    {
        settings.bounces = kAutomatic;
        settings.field_fill = frames;
        scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)}};
        scene.world.radiance = glm::vec3(0.2f);
        scene.surfaces = {BoxSurface{{-4, -9, -2.2}, {4, -1, -2}, glm::vec3(0.5f)}};
        scene.media = {turned_lump(glm::dmat4(1.0))};
    }
    void set(Renderer& renderer) const
    {
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
    }
    Image draw(Renderer& renderer)
    {
        View view = renderer.make_view();
        host.look(scene.camera);
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        renderer.draw_surfaces(host.frame, settings, true);
        renderer.composite(view, host.frame, settings);
        return host.read();
    }
    Image draw_fresh()
    {
        Renderer fresh(get_proc);
        set(fresh);
        return draw(fresh);
    }
    void turn_sun(double by)
    {
        auto& sun = std::get<SunLight>(scene.lights[0]);
        sun.direction_to_light = glm::dvec3(glm::rotate(glm::dmat4(1.0), by, glm::dvec3(0, 0, 1)) *
                                            glm::dvec4(sun.direction_to_light, 0.0));
    }
    Scene scene = empty_scene(16);
    Settings settings;
    gl::GetProc get_proc;
    HostPicture host;
};

double mean_difference(const Image& a, const Image& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        sum += std::abs(double(a.pixels[i]) - double(b.pixels[i]));
    return sum / static_cast<double>(a.pixels.size());
}

TEST_F(LightVolume, TheFieldIsFilledOverFramesAndFades)
{
    constexpr int kFrames = 4;
    Filming filming(gl(), get_proc(), plain_settings(), kFrames);
    Renderer renderer(get_proc());
    filming.set(renderer);
    EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 0, 0, "first"))
        << "the first is whole";

    // A light whose shadows stay: only the field is another.
    std::get<SunLight>(filming.scene.lights[0]).irradiance = {1, 3, 8};
    filming.settings.bounces = 0;
    renderer.take_report();
    filming.settings.bounces = kAutomatic;
    filming.set(renderer);
    EXPECT_EQ(renderer.take_report().work.fields, 0) << "nothing is filled at once";
    const Image last = filming.draw_fresh();
    std::vector<Image> frames;
    for (int i = 0; i <= 2 * kFrames; ++i)
        frames.push_back(filming.draw(renderer));
    EXPECT_TRUE(images_near(frames.back(), last, 0, 0, "last")) << "it is whole in the end";
    const double all = mean_difference(frames.front(), last);
    ASSERT_GT(all, 1e-2);
    int changes = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
        const double step = mean_difference(frames[i - 1], frames[i]);
        EXPECT_LT(step, 1.1 / kFrames * all) << "frame " << i << " jumps";
        EXPECT_LE(mean_difference(frames[i], last),
                  mean_difference(frames[i - 1], last) + 1e-3 * all)
            << "frame " << i << " goes back";
        changes += step > 0.5 / kFrames * all ? 1 : 0;
    }
    EXPECT_EQ(changes, kFrames) << "it fades evenly";
    EXPECT_EQ(renderer.take_report().work.fields, 1);
    filming.scene.camera.position.z += 0.01;
    filming.settings.probe_update = SceneSettings::ProbeUpdate::never;
    filming.set(renderer);
    EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 0, 0, "again"))
        << "what has nothing to be filled stays";
}

TEST_F(LightVolume, TheFieldOfAMovingSceneFollowsIt)
{
    constexpr int kFrames = 3;
    Filming filming(gl(), get_proc(), plain_settings(), kFrames);
    Renderer renderer(get_proc());
    filming.set(renderer);
    filming.draw(renderer);
    renderer.take_report();
    auto& smoke = std::get<GridMedium>(filming.scene.media[0]);
    auto& floor = std::get<BoxSurface>(filming.scene.surfaces[0]);
    for (int i = 0; i < 4 * kFrames; ++i) {
        filming.turn_sun(0.05);
        smoke.sigma_s_per_density *= 1.01f;
        smoke.translate.x += 0.01;
        floor.max.z += 0.01;
        filming.set(renderer);
        for (const float value : filming.draw(renderer).pixels)
            ASSERT_TRUE(std::isfinite(value));
    }
    const int fills = renderer.take_report().work.fields;
    EXPECT_GE(fills, 3) << "the field must not wait until nothing moves";
    EXPECT_LE(fills, 4);
    for (int i = 0; i < 3 * kFrames; ++i)
        filming.draw(renderer);
    EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 0, 0, "at rest"));
    renderer.take_report();
    filming.draw(renderer);
    EXPECT_EQ(renderer.take_report().work, SceneWork{}) << "and is left alone then";

    // What another shader is for can't go on by what was begun.
    filming.turn_sun(0.5);
    filming.set(renderer);
    filming.draw(renderer);
    filming.scene.lights.emplace_back(PointLight{{0.6, -4, 1.5}, glm::vec3(20)});
    filming.set(renderer);
    EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 0, 0, "a light more"));
    filming.turn_sun(0.5);
    filming.set(renderer);
    filming.draw(renderer);
    filming.scene.media.clear();
    filming.set(renderer);
    EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 0, 0, "no media"));
}

// What a fire throws on the floor is that of media and surfaces alone.
TEST_F(LightVolume, AFireOnSurfacesStaysWhileLightIsFilledOverFrames)
{
    constexpr int kFrames = 3;
    Filming filming(gl(), get_proc(), plain_settings(), kFrames);
    auto& smoke = std::get<GridMedium>(filming.scene.media[0]);
    auto& floor = std::get<BoxSurface>(filming.scene.surfaces[0]);
    smoke.emission = smoke.density;
    smoke.emission_per_unit = glm::vec3(0.5f);
    Renderer renderer(get_proc());
    filming.set(renderer);
    filming.draw(renderer);
    EXPECT_EQ(renderer.take_report().work.fires, 1);
    const auto expect_fires = [&](int fires, float near, const char* what) {
        filming.set(renderer);
        for (int i = 0; i < 3 * kFrames; ++i)
            filming.draw(renderer);
        EXPECT_EQ(renderer.take_report().work.fires, fires) << what;
        EXPECT_TRUE(
            images_near(filming.draw(renderer), filming.draw_fresh(), near, 0.1f * near, what));
    };
    filming.turn_sun(0.5);
    expect_fires(0, 0, "a light turned");
    filming.scene.world.radiance = {0.1f, 0.2f, 0.3f};
    expect_fires(0, 0, "the world");
    smoke.g = 0.4f;
    expect_fires(0, 0, "g");
    floor.albedo = {0.2f, 0.3f, 0.1f};
    expect_fires(0, 0, "a surface's colour");
    smoke.emission_per_unit = {1, 0.5f, 0.2f};
    expect_fires(1, 0, "emission");
    floor.max.z += 0.1;
    expect_fires(1, 0, "a surface moved");
    const glm::dvec3 by{0.37, -0.21, 1.13};
    smoke.translate += by;
    floor.min += by;
    floor.max += by;
    filming.scene.camera.position += by;
    filming.scene.camera.look_at += by;
    expect_fires(0, 2e-3f, "all moved together");
    // What has moved under another world is shown where it was until its light is there.
    smoke.translate -= by;
    floor.min -= by;
    floor.max -= by;
    filming.scene.camera.position -= by;
    filming.scene.camera.look_at -= by;
    filming.turn_sun(0.5);
    filming.scene.world.radiance *= 2.0f;
    expect_fires(1, 2e-3f, "all moved, under other lights");
}

TEST_F(LightVolume, TheFieldThatIsShownMovesWithItsScene)
{
    constexpr int kFrames = 4;
    Filming still(gl(), get_proc(), plain_settings(), kFrames),
        moved(gl(), get_proc(), plain_settings(), kFrames);
    const auto move = [&](glm::dvec3 by) {
        std::get<GridMedium>(moved.scene.media[0]).translate += by;
        auto& floor = std::get<BoxSurface>(moved.scene.surfaces[0]);
        floor.min += by;
        floor.max += by;
        moved.scene.camera.position += by;
        moved.scene.camera.look_at += by;
    };
    const auto other_sun = [](Filming& filming) {
        std::get<SunLight>(filming.scene.lights[0]).irradiance = {1, 3, 8};
    };
    Renderer one(get_proc()), other(get_proc());
    still.set(one);
    moved.set(other);
    const Image first = still.draw(one);
    other_sun(still);
    other_sun(moved);
    move({4, 3, -2});  // what is shown was filled for another sun, elsewhere
    still.set(one);
    moved.set(other);
    for (int i = 0; i < kFrames + 2; ++i) {
        EXPECT_TRUE(images_near(moved.draw(other), still.draw(one), 2e-3, 2e-4, "elsewhere")) << i;
        if (i == kFrames) {  // amid the fade
            move({-3, 2, 5});
            moved.set(other);
        }
    }
    ASSERT_GT(mean_difference(still.draw(one), first), 1e-2);
    moved.draw(other);

    // Nodes that are left behind are not filled any further.
    moved.turn_sun(0.7);
    moved.set(other);
    moved.draw(other);
    move({-30, 2, 5});
    moved.set(other);
    EXPECT_TRUE(images_near(moved.draw(other), moved.draw_fresh(), 2e-3, 2e-4, "far from there"));
}

TEST_F(LightVolume, TheFieldKnowsShadowsThatCameOverFrames)
{
    Filming filming(gl(), get_proc(), plain_settings(), 1);
    filming.settings.shadow_fill = 3;
    for (const int frames : {1, 2}) {
        filming.settings.field_fill = frames;
        Renderer renderer(get_proc());
        filming.set(renderer);
        filming.turn_sun(1.5);
        filming.set(renderer);
        for (int i = 0; i < 8; ++i)
            filming.draw(renderer);
        EXPECT_TRUE(images_near(filming.draw(renderer), filming.draw_fresh(), 2e-3, 2e-4,
                                "16-bit depths of other sums"))
            << frames;
    }
}

// Smoke in wide fog has nodes of its own, which take what the fog's send: that comes a turn later,
// and in the end they have it.
TEST_F(LightVolume, SmokeAmidWideFogHasAllOfItsLightInTheEnd)
{
    Filming filming(gl(), get_proc(), plain_settings(), 3);
    BoxMedium fog;
    fog.min = glm::dvec3(-40);
    fog.max = glm::dvec3(40);
    fog.sigma_s = glm::vec3(0.02f);
    filming.scene.media.emplace_back(fog);
    Renderer renderer(get_proc());
    filming.set(renderer);
    filming.draw(renderer);
    std::get<SunLight>(filming.scene.lights[0]).irradiance = {1, 3, 8};
    filming.set(renderer);
    const Image last = filming.draw_fresh();
    Image seen = filming.draw(renderer);
    EXPECT_GT(mean_difference(seen, last), 1e-3);
    // Of the fog, then of the smoke, of which each is filled and then fades.
    for (int i = 0; i < 20; ++i)
        seen = filming.draw(renderer);
    EXPECT_TRUE(images_near(seen, last, 0, 0, "a change of the light"));
    renderer.take_report();
    filming.draw(renderer);
    EXPECT_EQ(renderer.take_report().work, SceneWork{}) << "nothing is left to be done";
    // The smoke alone moves.
    std::get<GridMedium>(filming.scene.media[0]).translate.x += 1;
    filming.set(renderer);
    for (int i = 0; i < 20; ++i)
        seen = filming.draw(renderer);
    EXPECT_TRUE(images_near(seen, filming.draw_fresh(), 0, 0, "smoke that has moved"));
}

TEST_F(LightVolume, MovesWithItsMediumWhileItIsFilled)
{
    Scene scene = empty_scene(16);
    scene.lights = {PointLight{{0.6, -4, 1.5}, glm::vec3(20)}};
    scene.media = {turned_lump(glm::dmat4(1.0))};
    auto& light = std::get<PointLight>(scene.lights[0]);
    Settings settings = plain_settings();
    settings.shadow_fill = 3;
    Renderer renderer(get_proc());
    HostPicture host(gl(), glm::ivec2(16));
    const auto next_frame = [&](Renderer& by) {
        View view = by.make_view();
        host.look(scene.camera);
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        by.composite(view, host.frame, settings);
        return host.read();
    };
    renderer.set_scene(scene, settings);
    light.position.x += 1.5;
    renderer.set_scene(scene, settings);
    next_frame(renderer);
    renderer.take_report();
    const glm::dvec3 by{4, 3, -2};
    light.position += by;
    std::get<GridMedium>(scene.media[0]).translate += by;
    scene.camera.position += by;
    scene.camera.look_at += by;
    renderer.set_scene(scene, settings);
    for (int i = 0; i < 3; ++i)
        next_frame(renderer);
    EXPECT_EQ(renderer.take_report().work, SceneWork{}) << "it goes on where it was";
    Renderer fresh(get_proc());
    fresh.set_scene(scene, settings);
    EXPECT_TRUE(images_near(next_frame(renderer), next_frame(fresh), 2e-3, 2e-4, "moved"));
}

TEST_F(LightVolume, IsFilledAgainOnlyForWhatChanged)
{
    Scene scene = empty_scene(16);
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)},
                    PointLight{{0.6, -4, 1.5}, glm::vec3(20)}};
    scene.world.radiance = glm::vec3(0.3f);
    scene.media = {turned_lump(glm::dmat4(1.0))};
    const Settings settings = plain_settings();
    SceneRenderer renderer(get_proc());
    renderer.render(scene, settings, {});
    const std::vector<std::string> first = volumes(renderer.renderer());
    ASSERT_EQ(first.size(), 2u);
    renderer.render(scene, settings, {});
    EXPECT_EQ(volumes(renderer.renderer()), first) << "the same scene";
    std::get<PointLight>(scene.lights[1]).radiant_intensity *= 2.0f;
    renderer.render(scene, settings, {});
    EXPECT_EQ(volumes(renderer.renderer()), first) << "a brighter light";

    const auto matches_a_fresh_one = [&] {
        const Still kept = renderer.render(scene, settings, {});
        SceneRenderer fresh(get_proc());
        EXPECT_EQ(kept.scattering, fresh.render(scene, settings, {}).scattering);
    };
    std::get<PointLight>(scene.lights[1]).position.x += 0.5;
    matches_a_fresh_one();
    EXPECT_NE(volumes(renderer.renderer())[0], first[0]) << "a light moved";
    EXPECT_EQ(volumes(renderer.renderer())[1], first[1]) << "the world's light did not change";
    std::swap(scene.lights[0], scene.lights[1]);
    scene.lights.pop_back();
    matches_a_fresh_one();
    scene.world.radiance = glm::vec3(0);
    scene.lights.clear();
    renderer.render(scene, settings, {});
    EXPECT_TRUE(volumes(renderer.renderer()).empty()) << "nothing is kept that nothing needs";
}

/// Everything that a volume can depend on: two lights and the world, smoke that glows, haze, a
/// ball.
Scene living_scene()
{
    Scene scene;
    scene.resolution = {16, 16};
    scene.camera.position = {0, 0, 0};
    scene.camera.look_at = {0, -1, 0};
    scene.camera.vfov_deg = 40;
    scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(4)},
                    PointLight{{0.6, -4, 1.5}, glm::vec3(20)}};
    scene.world.radiance = glm::vec3(0.3f);
    GridMedium smoke = turned_lump(glm::dmat4(1.0));
    smoke.emission = smoke.density;
    smoke.emission_per_unit = glm::vec3(0.1f);
    BoxMedium haze;
    haze.min = {-4, -9, -4};
    haze.max = {4, -1, 4};
    haze.sigma_s = glm::vec3(0.02f);
    haze.g = 0.3f;
    scene.media = {smoke, haze};
    scene.surfaces = {SphereSurface{{1.2, -4.2, -0.8}, 0.5, glm::vec3(0.5f)}};
    return scene;
}

struct Change {
    const char* name;
    void (*change)(Scene& scene);
    SceneWork work;  ///< what it takes
    float near = 0;  ///< how much of a value the picture may differ from one without a past
};

void PrintTo(const Change& change, std::ostream* out)
{
    *out << change.name;
}

GridMedium& smoke_of(Scene& scene)
{
    return std::get<GridMedium>(scene.media[0]);
}

void move_all(Scene& scene, glm::dvec3 by)
{
    smoke_of(scene).translate += by;
    auto& haze = std::get<BoxMedium>(scene.media[1]);
    haze.min += by;
    haze.max += by;
    for (Surface& ball : scene.surfaces)
        std::get<SphereSurface>(ball).center += by;
    std::get<PointLight>(scene.lights[1]).position += by;
    scene.camera.position += by;
    scene.camera.look_at += by;
}

// A sun has 2 views of the ball, a point light 6. Where the volumes are not filled anew they lie in
// 16-bit floats as they were rounded elsewhere.
constexpr float kRounded = 2e-3f;

const std::array kChanges{
    Change{"nothing", [](Scene&) {}, {}},
    Change{"g", [](Scene& scene) { smoke_of(scene).g = 0.6f; }, {.fields = 1}},
    Change{"one_g_for_all",
           [](Scene& scene) { std::get<BoxMedium>(scene.media[1]).g = 0.6f; },
           {.fields = 1}},
    Change{"emission",
           [](Scene& scene) {
               smoke_of(scene).emission_per_unit = {1, 2, 3};
           },
           {.fields = 1, .fires = 1}},
    Change{"albedo_at_the_same_extinction",
           [](Scene& scene) {
               std::swap(smoke_of(scene).sigma_s_per_density, smoke_of(scene).sigma_a_per_density);
           },
           {.fields = 1}},
    Change{"a_tint",  // it takes from what is scattered and adds it to what is absorbed
           [](Scene& scene) {
               auto tint = std::make_shared<VoxelGrid>(*smoke_of(scene).density);
               for (float& value : tint->values)
                   value *= 0.5f;
               smoke_of(scene).color = tint;
           },
           {.grids_uploaded = 1, .fields = 1}},
    Change{"a_colour_of_a_surface",
           [](Scene& scene) {
               std::get<SphereSurface>(scene.surfaces[0]).albedo = {1, 0, 0};
           },
           {}},
    Change{"a_light_s_colour",
           [](Scene& scene) {
               std::get<PointLight>(scene.lights[1]).radiant_intensity = {30, 10, 5};
               std::get<SunLight>(scene.lights[0]).irradiance = {1, 2, 3};
           },
           {.fields = 1}},
    Change{"the_clock", [](Scene& scene) { scene.time += 3; }, {}},
    Change{"a_light_moved",
           [](Scene& scene) { std::get<PointLight>(scene.lights[1]).position.x += 0.5; },
           {.shadow_views = 6, .extinctions = 1, .depth_layers = 1, .fields = 1}},
    Change{"a_light_turned",
           [](Scene& scene) {
               std::get<SunLight>(scene.lights[0]).direction_to_light = {0.4, 0.6, 0.7};
           },
           {.shadow_views = 2, .depth_layers = 1, .fields = 1}},
    Change{"a_light_added",
           [](Scene& scene) {
               scene.lights.insert(scene.lights.begin(), SunLight{{-0.5, 0.5, 0.7}, glm::vec3(2)});
           },
           {.shadow_views = 2, .depth_layers = 1, .fields = 1}},
    Change{"a_light_removed",
           [](Scene& scene) { scene.lights.erase(scene.lights.begin()); },
           {.fields = 1}},
    Change{"all_moved_together",
           [](Scene& scene) {
               move_all(scene, {0.37, -0.21, 1.13});
           },
           {.shadow_views = 8},
           kRounded},
    Change{"the_haze_alone",  // it has a closed form towards the lights, none towards the world
           [](Scene& scene) { std::get<BoxMedium>(scene.media[1]).sigma_s = glm::vec3(0.04f); },
           {.world_volumes = 1, .fields = 1, .fires = 1}},
    Change{"the_world",
           [](Scene& scene) {
               scene.world.radiance = {0.1f, 0.2f, 0.3f};
           },
           {.world_volumes = 1, .fields = 1}},
    Change{"a_surface_moved",
           [](Scene& scene) { std::get<SphereSurface>(scene.surfaces[0]).center.z -= 0.3; },
           {.shadow_views = 8, .world_volumes = 1, .fields = 1, .lattices = 2, .fires = 1}},
    Change{"extinction",
           [](Scene& scene) { smoke_of(scene).sigma_a_per_density *= 2.0f; },
           {.extinctions = 1, .depth_layers = 2, .world_volumes = 1, .fields = 1, .fires = 1}},
    Change{"a_medium_moved_alone",  // within the haze, and suns are everywhere as far
           [](Scene& scene) { smoke_of(scene).translate.x += 0.25; },
           {.extinctions = 1, .depth_layers = 1, .world_volumes = 1, .fields = 1, .fires = 1},
           kRounded},
};

class LightVolumeChange : public LightVolume, public testing::WithParamInterface<Change> {};

TEST_P(LightVolumeChange, FillsWhatDependsOnIt)
{
    const Change& change = GetParam();
    const Settings settings = plain_settings();
    Renderer renderer(get_proc());
    HostPicture host(gl(), glm::ivec2(16));
    const auto picture = [&](Renderer& by, const Scene& scene) {
        View view = by.make_view();
        host.look(scene.camera);
        by.wait_until_ready();
        by.draw_surfaces(host.frame, settings, true);
        by.composite(view, host.frame, settings);
        return host.read();
    };
    Scene scene = living_scene();
    renderer.set_scene(scene, settings);
    picture(renderer, scene);
    const SceneWork all = renderer.take_report().work;
    EXPECT_EQ(all.depth_layers, 2);
    EXPECT_EQ(all.world_volumes, 1);
    EXPECT_EQ(all.fires, 1);
    // From the first edit on the world's light is kept apart from what is scattered again.
    std::get<PointLight>(scene.lights[1]).radiant_intensity *= 1.5f;
    renderer.set_scene(scene, settings);
    picture(renderer, scene);
    EXPECT_EQ(renderer.take_report().work, (SceneWork{.world_volumes = 1, .fields = 1}));

    change.change(scene);
    renderer.set_scene(scene, settings);
    const Image kept = picture(renderer, scene);
    const SceneWork work = renderer.take_report().work;
    EXPECT_EQ(work.grids_uploaded, change.work.grids_uploaded);
    EXPECT_EQ(work.meshes_uploaded, change.work.meshes_uploaded);
    EXPECT_EQ(work.shadow_views, change.work.shadow_views);
    EXPECT_EQ(work.extinctions, change.work.extinctions);
    EXPECT_EQ(work.depth_layers, change.work.depth_layers);
    EXPECT_EQ(work.world_volumes, change.work.world_volumes);
    EXPECT_EQ(work.fields, change.work.fields) << "the smoke glows";
    EXPECT_EQ(work.lattices, change.work.lattices);
    EXPECT_EQ(work.fires, change.work.fires) << "it lights the ball";
    Renderer fresh(get_proc());
    fresh.set_scene(scene, settings);
    EXPECT_TRUE(images_near(kept, picture(fresh, scene), change.near, 0.1f * change.near,
                            "a renderer made anew"));
}

INSTANTIATE_TEST_SUITE_P(Scenes, LightVolumeChange, testing::ValuesIn(kChanges),
                         [](const auto& change) { return std::string(change.param.name); });

// Half of the orders: what they leave out is to be of what changed from frame to frame, not of all.
TEST_F(LightVolume, OrdersOfAPlayingSequenceStartFromTheFrameBefore)
{
    const std::filesystem::path folder = std::filesystem::path(FUM_TEST_DATA) / "smoke_seq";
    Scene of_sequence =
        asset::make_auto_scene(folder / "smoke_0005.vdb", asset::AutoSceneOptions{}).scene;
    of_sequence.resolution = {48, 27};
    const auto frame = [&](int number) {
        Scene scene = of_sequence;
        auto& smoke = std::get<GridMedium>(scene.media[0]);
        smoke.density = std::make_shared<const VoxelGrid>(
            asset::load_grid(folder / fmt::format("smoke_{:04}.vdb", number), "density").grid);
        return scene;
    };
    Settings settings;
    settings.field_from_before = true;
    HostPicture host(gl(), glm::ivec2(48, 27));
    const auto draw = [&](Renderer& renderer, const Scene& scene) {
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        View view = renderer.make_view();
        host.look(scene.camera);
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        renderer.composite(view, host.frame, settings);
        return host.read();
    };
    const auto draw_fresh = [&](const Scene& scene) {
        Renderer fresh(get_proc());
        return draw(fresh, scene);
    };
    const auto starts_from_before = [&](const Renderer& renderer) {
        const std::vector<std::string> lines = renderer.explain(settings);
        return std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
            return line.find("from the light that was there before") != std::string::npos;
        });
    };
    Renderer renderer(get_proc());
    draw(renderer, frame(3));
    EXPECT_FALSE(starts_from_before(renderer)) << "nothing was there";
    draw(renderer, frame(4));
    Scene scene = frame(5);
    const Image played = draw(renderer, scene), alone = draw_fresh(scene);
    EXPECT_TRUE(starts_from_before(renderer));
    const study::Metrics apart = study::compare(played.pixels, alone.pixels);
    figure("relMSE", apart.relmse);
    EXPECT_LT(apart.relmse, 2e-6);
    EXPECT_LT(std::abs(apart.bias), 1.5e-3);
    EXPECT_GT(apart.relmse, 0);

    // Of so much more light what is left would be seen; in thick media, of any.
    std::get<SunLight>(scene.lights[0]).irradiance *= 1e-3f;
    EXPECT_TRUE(images_near(draw(renderer, scene), draw_fresh(scene), 0, 0, "sun went down"));
    EXPECT_FALSE(starts_from_before(renderer));
    for (const int number : {4, 5}) {
        scene = frame(number);
        std::get<GridMedium>(scene.media[0]).sigma_s_per_density *= 8;
        EXPECT_TRUE(images_near(draw(renderer, scene), draw_fresh(scene), 0, 0, "thick"));
    }
    // Behind a shutter that has closed, or in smoke that is another or has moved, there is none of
    // it.
    const std::vector<std::function<void(Scene&)>> changes{
        [](Scene& changed) {
            changed.surfaces.emplace_back(SphereSurface{.center = {0, 0, 9}, .radius = 2});
        },
        [](Scene& changed) { std::get<GridMedium>(changed.media[0]).sigma_s_per_density *= 1.01f; },
        [](Scene& changed) { std::get<GridMedium>(changed.media[0]).translate.x += 0.1; }};
    for (std::size_t i = 0; i < changes.size(); ++i) {
        draw(renderer, frame(4));
        scene = frame(5);
        changes[i](scene);
        EXPECT_TRUE(images_near(draw(renderer, scene), draw_fresh(scene), 0, 0, "changed")) << i;
    }
    // Nor where it is not asked for.
    settings.field_from_before = false;
    draw(renderer, frame(4));
    EXPECT_TRUE(images_near(draw(renderer, frame(5)), draw_fresh(frame(5)), 0, 0, "not asked for"));
    settings.field_from_before = true;
    // A number of orders that is asked for is that number.
    settings.bounces = 3;
    draw(renderer, frame(4));
    EXPECT_TRUE(images_near(draw(renderer, frame(5)), draw_fresh(frame(5)), 0, 0, "three orders"));
}

/// A cloud of 56 voxels along its edges, of waves a few voxels long.
Scene wavy_cloud(float sigma_t)
{
    Scene scene = empty_scene(64);
    scene.camera.position = {0, -9, 0};
    scene.lights = {SunLight{{0.4, -0.5, 0.7}, glm::vec3(4)}};
    GridMedium cloud;
    cloud.density =
        make_grid(glm::ivec3(7), study::voxels(0.05, {-1.4, -1.4, -1.4}), [](glm::ivec3 at) {
            const glm::dvec3 p = (glm::dvec3(at) - 27.5) / 27.5;
            const double wave = std::sin(0.9 * at.x) * std::cos(1.1 * at.y + 0.4 * at.z);
            return std::max(0.0, (1 - glm::length(p)) * (1 + 0.7 * wave));
        });
    cloud.sigma_s_per_density = glm::vec3(sigma_t);
    scene.media = {cloud};
    return scene;
}

// Thin voxels need no two nodes each, thick ones do, and more of them where they are very thick.
TEST_F(LightVolume, NodesAreAsManyAsAVoxelIsThick)
{
    struct Case {
        const char* name;
        float sigma_t;
        double least, most;  ///< of the bytes that 96 nodes take
        double relmse;       ///< of the scattering, against 256 nodes
    };
    for (const Case& c : {Case{"thin", 3, 0.2, 0.4, 1e-5}, Case{"thick", 12, 0.45, 0.9, 1e-5},
                          Case{"very thick", 500, 1.3, 1.8, 1e-3}}) {
        const Scene scene = wavy_cloud(c.sigma_t);
        Settings settings = plain_settings();
        settings.world_light = false;
        const auto bytes = [&](int nodes) {
            settings.shadow_volume_size = nodes;
            Renderer renderer(get_proc());
            renderer.set_scene(scene, settings);
            return static_cast<double>(renderer.take_report().gpu_bytes);
        };
        const double none = bytes(0), share = (bytes(kAutomatic) - none) / (bytes(96) - none);
        settings.shadow_volume_size = 256;
        const Still fine = render(scene, settings);
        settings.shadow_volume_size = kAutomatic;
        const auto error = study::compare(render(scene, settings).scattering, fine.scattering);
        figure(fmt::format("{} voxels: bytes of those of 96 nodes", c.name), share);
        figure(fmt::format("{} voxels: relMSE", c.name), error.relmse);
        EXPECT_GE(share, c.least) << c.name;
        EXPECT_LE(share, c.most) << c.name;
        EXPECT_LT(error.relmse, c.relmse) << c.name;
    }
}

// What a host that edits its scene by ids pays for.
TEST_F(LightVolume, TheFieldOfTheSampleTakesLessThan8MB)
{
    const Scene scene = asset::load_scene(std::string(FUM_TEST_DATA) + "/smoke_plume.json").scene;
    const auto bytes = [&](int nodes) {
        Settings settings;
        settings.ambient_volume_size = nodes;
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        return static_cast<double>(renderer.take_report().gpu_bytes);
    };
    const double field = bytes(kAutomatic) - bytes(0);
    figure("bytes of the field", field);
    EXPECT_GT(field, 4e6);
    EXPECT_LT(field, 8e6);
}

TEST_F(LightVolume, EditsOfALiveSceneCostWhatDependsOnThem)
{
    const Settings settings = plain_settings();
    Renderer renderer(get_proc());
    LiveScene live(living_scene());
    const MediumId smoke = live.media()[0], haze = live.media()[1];
    const LightId sun = live.lights()[0], lamp = live.lights()[1];
    const SurfaceId ball = live.surfaces()[0];
    const auto work = [&] {
        renderer.set_scene(live.scene(), settings);
        return renderer.take_report().work;
    };
    const auto all = work();
    EXPECT_EQ(all.grids_uploaded, 1);
    EXPECT_EQ(all.depth_layers, 2);
    EXPECT_EQ(work(), SceneWork{}) << "no edit";

    auto cloud = std::get<GridMedium>(live.at(smoke));
    cloud.g = 0.7f;
    cloud.emission_per_unit = {1, 2, 3};
    live.update(smoke, cloud);
    EXPECT_EQ(work(), (SceneWork{.world_volumes = 1, .fields = 1, .fires = 1}))
        << "g and emission; of the world's light the sum with theirs alone was kept so far";
    cloud.g = 0.6f;
    live.update(smoke, cloud);
    EXPECT_EQ(work(), SceneWork{.fields = 1}) << "g again";
    auto point = std::get<PointLight>(live.at(lamp));
    point.position.y += 0.5;
    live.update(lamp, point);
    EXPECT_EQ(work(),
              (SceneWork{.shadow_views = 6, .extinctions = 1, .depth_layers = 1, .fields = 1}))
        << "a light moved";
    live.remove(ball);
    EXPECT_EQ(work(), (SceneWork{.world_volumes = 1, .fields = 1}))
        << "without surfaces there is no shadow map; the ball had hidden the world";
    live.set_world({});
    EXPECT_EQ(work(), (SceneWork{.world_volumes = 1, .fields = 1}))
        << "what glows lights surfaces still";
    const SurfaceId box = live.add(BoxSurface{{-1, -4, -1}, {1, -3.5, -0.5}, glm::vec3(0.5f)});
    const SurfaceId other = live.add(SphereSurface{{1.2, -4.2, -0.8}, 0.5, glm::vec3(0.5f)});
    EXPECT_EQ(work().shadow_views, 8);
    live.remove(box);
    EXPECT_EQ(
        work(),
        (SceneWork{.shadow_views = 8, .world_volumes = 1, .fields = 1, .lattices = 2, .fires = 1}))
        << "a surface removed: one lattice is the media's, the other the surfaces'";
    live.update(other, SphereSurface{{1.2, -4.2, -0.8}, 0.5, glm::vec3(0.9f)});
    EXPECT_EQ(work(), SceneWork{}) << "a surface's colour";

    const glm::dvec3 by{0.3, 0.2, -0.1};
    cloud.translate += by;
    point.position += by;
    auto fog = std::get<BoxMedium>(live.at(haze));
    fog.min += by;
    fog.max += by;
    live.update(smoke, cloud);
    live.update(lamp, point);
    live.update(haze, fog);
    SceneWork together = work();
    together.shadow_views = 0;  // the ball stays where it is
    EXPECT_EQ(together, (SceneWork{.world_volumes = 1, .fields = 1, .lattices = 2, .fires = 1}))
        << "media moved with their lamp; what glows shines past a ball that stays";
    cloud.density = std::make_shared<VoxelGrid>(*cloud.density);
    cloud.emission = cloud.density;
    live.update(smoke, cloud);
    EXPECT_EQ(work(), (SceneWork{.grids_uploaded = 1,
                                 .extinctions = 1,
                                 .depth_layers = 2,
                                 .world_volumes = 1,
                                 .fields = 1,
                                 .fires = 1}))
        << "the next frame's grid";
    live.remove(sun);
    EXPECT_EQ(work(), SceneWork{.fields = 1}) << "the lamp's layers go on";

    HostPicture host(gl(), glm::ivec2(16));
    const auto picture = [&](Renderer& by_whom) {
        View view = by_whom.make_view();
        host.look(live.scene().camera);
        by_whom.wait_until_ready();
        by_whom.draw_surfaces(host.frame, settings, true);
        by_whom.composite(view, host.frame, settings);
        return host.read();
    };
    Renderer fresh(get_proc());
    fresh.set_scene(live.scene(), settings);
    EXPECT_TRUE(images_near(picture(renderer), picture(fresh), 2e-3, 2e-4, "given at once"));
}

// The clock moves noise that drifts, and a grid's shadow stays.
TEST_F(LightVolume, TheClockMattersToNoiseThatDrifts)
{
    Scene scene = living_scene();
    BoxMedium noise;
    noise.min = {-1, -6, -1};
    noise.max = {1, -4, 1};
    noise.sigma_s = glm::vec3(1);
    noise.profile = NoiseProfile{.feature_size = 1.0, .octaves = 2, .seed = 5};
    const Settings settings = plain_settings();
    for (const double drift : {0.0, 0.5}) {
        std::get<NoiseProfile>(noise.profile).drift.x = drift;
        scene.media = {noise};
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        renderer.take_report();
        scene.time += 1;
        renderer.set_scene(scene, settings);
        const SceneWork work = renderer.take_report().work;
        EXPECT_EQ(work.depth_layers, drift > 0 ? 2 : 0);
        EXPECT_EQ(work.world_volumes, drift > 0 ? 1 : 0);
    }
}

// A medium that is moved as a whole with its lights takes with it what light does in it.
TEST_F(LightVolume, LightThatScattersAgainMovesWithMediaAndLights)
{
    Scene scene = living_scene();
    scene.surfaces.clear();
    HostPicture host(gl(), {24, 16});
    Settings settings = plain_settings();
    settings.bounces = 4;
    Renderer renderer(get_proc()), fresh(get_proc());
    const auto picture = [&](Renderer& by) {
        by.set_scene(scene, settings);
        by.wait_until_ready();
        host.look(scene.camera);
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        View view = by.make_view();
        by.composite(view, host.frame, settings);
        return host.read();
    };
    picture(renderer);
    EXPECT_EQ(renderer.take_report().work.fields, 1);
    move_all(scene, {0.37, -0.21, 1.13});
    const Image moved = picture(renderer);
    EXPECT_EQ(renderer.take_report().work, SceneWork{});
    EXPECT_TRUE(images_near(moved, picture(fresh), 2e-3, 2e-4, "made anew"));
    std::get<PointLight>(scene.lights[1]).position.x += 0.1;
    picture(renderer);
    EXPECT_EQ(renderer.take_report().work.fields, 1) << "the lamp alone";
}

// Light that scattered again stayed in the media when a host asked for none.
TEST_F(LightVolume, BouncesThatAreTurnedOffAreGone)
{
    Scene scene = living_scene();
    scene.surfaces.clear();
    std::get<GridMedium>(scene.media[0]).emission_per_unit = glm::vec3(0);  // it keeps the field
    HostPicture host(gl(), {24, 16});
    host.look(scene.camera);
    Settings with = plain_settings(), without = with;
    with.bounces = 4;
    without.bounces = 0;
    Renderer renderer(get_proc()), fresh(get_proc());
    const auto picture = [&](Renderer& by, const Settings& settings) {
        by.set_scene(scene, settings);
        by.wait_until_ready();
        host.fill(glm::vec3(0), scene.camera.near, [](int, int) { return 0.0; });
        View view = by.make_view();
        by.composite(view, host.frame, settings);
        return host.read();
    };
    const Image of_none = picture(fresh, without);
    EXPECT_GT(max_difference(picture(renderer, with), of_none), 1e-3);
    EXPECT_EQ(max_difference(picture(renderer, without), of_none), 0);
}

// -- the world -----------------------------------------------------------------------------------

/// Integral of exp(-x / u) over u in 0..1.
double e2(double x)
{
    return integrate(1e-9, 1, 400, [&](double u) { return std::exp(-x / u); });
}

TEST_F(LightVolume, WorldInASlabIsItsExponentialIntegral)
{
    // z below the face of an endless slab d thick, isotropic scattering has
    // (E2(sigma z) + E2(sigma (d - z))) / 2 of a constant world.
    Scene scene = empty_scene(9);
    scene.camera.vfov_deg = 10;
    scene.world.radiance = {1.0f, 0.5f, 2.0f};
    BoxMedium slab;
    slab.min = {-400, -7, -400};
    slab.max = {400, -3, 400};
    slab.sigma_s = {0.1f, 0.4f, 0.8f};
    slab.sigma_a = {0.0f, 0.1f, 0.2f};
    scene.media = {slab};
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        glm::dvec3 radiance;
        for (int c = 0; c < 3; ++c) {
            const double sigma_s = slab.sigma_s[c], sigma_t = sigma_s + double(slab.sigma_a[c]);
            radiance[c] = integrate(0, 4, 20, [&](double z) {
                const double slant = 1 / std::abs(ray.direction.y);
                return slant * sigma_s * double(scene.world.radiance[c]) *
                       std::exp(-sigma_t * z * slant) * (e2(sigma_t * z) + e2(sigma_t * (4 - z))) /
                       2;
            });
        }
        return radiance;
    });
    for (const Settings& settings : plain_siblings()) {
        const Still still = render(scene, settings);
        const study::Metrics kept = study::compare(still.scattering, truth.pixels);
        figure(fmt::format("slab in a world, {}: bias", mode_name(settings.mode)), kept.bias);
        EXPECT_LT(std::abs(kept.bias), 0.01) << mode_name(settings.mode);
        EXPECT_LT(kept.relmse, 3e-4) << mode_name(settings.mode);
    }
}

/// A map that is bright about one direction, as smoothly as a hazy sky.
World bright_spot(glm::dvec3 direction)
{
    auto map = std::make_shared<Environment>();
    map->width = 64;
    map->height = 32;
    for (int y = 0; y < map->height; ++y)
        for (int x = 0; x < map->width; ++x) {
            const double phi = (0.5 - (x + 0.5) / map->width) * 2 * kPi;
            const double theta = (y + 0.5) / map->height * kPi;
            const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                               std::cos(theta));
            const double c = std::max(0.0, glm::dot(d, glm::normalize(direction)));
            map->radiance.emplace_back(glm::vec3(glm::dvec3(0.1 + 3 * c * c)) *
                                       glm::vec3(1.0f, 0.8f, 0.5f));
        }
    World world;
    world.environment = map;
    return world;
}

World constant_world()
{
    World world;
    world.radiance = glm::vec3(1);
    return world;
}

struct WorldCase {
    const char* name;
    World world;
    float g;
    bool ball;
    double relmse, bias;
};

void PrintTo(const WorldCase& world, std::ostream* out)
{
    *out << world.name;
}

const std::array kWorldCases{
    WorldCase{"isotropic", constant_world(), 0, false, 1e-3, 0.01},
    WorldCase{"forward", constant_world(), 0.5f, false, 1e-3, 0.01},
    WorldCase{"backward", constant_world(), -0.4f, false, 1e-3, 0.01},
    WorldCase{"map_ahead", bright_spot({0.2, -1, 0.3}), 0.5f, false, 1e-3, 0.02},
    WorldCase{"map_behind", bright_spot({0.2, 1, 0.3}), 0.5f, false, 1e-3, 0.02},
    // Ways lie along the box's own axes, the worst that can be: it is 0.9 % too dark without the
    // ball, at any number of nodes, and the ball's shadow adds 0.4 %. Directions at random angles
    // would have half of that, and would not meet the nodes.
    WorldCase{"hidden_by_a_ball", constant_world(), 0, true, 1e-3, 0.015},
};

class WorldVolume : public LightVolume, public testing::WithParamInterface<WorldCase> {};

TEST_P(WorldVolume, AgreesWithTheReference)
{
    const WorldCase& world = GetParam();
    Scene scene = empty_scene(8);
    scene.camera.vfov_deg = 45;
    scene.world = world.world;
    BoxMedium box;
    box.min = {-2, -7, -2};
    box.max = {2, -3, 2};
    box.sigma_s = {0.2f, 0.4f, 0.6f};
    box.sigma_a = glm::vec3(0.05f);
    box.g = world.g;
    scene.media = {box};
    if (world.ball)
        scene.surfaces = {SphereSurface{{0.5, -5.5, 0.2}, 1.2, glm::vec3(0)}};
    study::ReferenceOptions options;
    options.tolerance = 5e-3;
    const study::ReferenceStill truth = study::render_reference(scene, options);
    for (const Settings& settings : plain_siblings()) {
        const study::Metrics kept =
            study::compare(render(scene, settings).scattering, truth.scattering);
        figure(fmt::format("{}, {}: relMSE", world.name, mode_name(settings.mode)), kept.relmse);
        figure(fmt::format("{}, {}: bias", world.name, mode_name(settings.mode)), kept.bias);
        EXPECT_LT(kept.relmse, world.relmse) << mode_name(settings.mode);
        EXPECT_LT(std::abs(kept.bias), world.bias) << mode_name(settings.mode);
        Settings flat = settings;
        flat.ambient_volume_size = 0;
        EXPECT_GT(study::compare(render(scene, flat).scattering, truth.scattering).relmse,
                  10 * world.relmse)
            << "2017's constant is told apart, " << mode_name(settings.mode);
    }
}

INSTANTIATE_TEST_SUITE_P(Worlds, WorldVolume, testing::ValuesIn(kWorldCases),
                         [](const auto& world) { return std::string(world.param.name); });

}  // namespace
}  // namespace fumarole::test
