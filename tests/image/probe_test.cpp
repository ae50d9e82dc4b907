// Glossy surfaces under a world's map and beside placed probes, against integrals of the BRDF over
// what lies around, in double.

#include <cmath>
#include <fmt/format.h>
#include <numbers>
#include <numeric>

#include "gl/texture.h"
#include "image_test.h"
#include "shared/bindings.h"
#include "study/metrics.h"
#include "study/reference.h"
#include "support/ggx.h"

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

using Radiance = std::function<glm::dvec3(glm::dvec3)>;

std::shared_ptr<const Environment> environment_of(int width, const Radiance& radiance)
{
    auto map = std::make_shared<Environment>();
    map->width = width;
    map->height = width / 2;
    for (int y = 0; y < map->height; ++y)
        for (int x = 0; x < width; ++x) {
            const double phi = (0.5 - (x + 0.5) / width) * 2 * kPi;
            const double theta = (y + 0.5) / map->height * kPi;
            map->radiance.emplace_back(
                radiance({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                          std::cos(theta)}));
        }
    return map;
}

/// A sky that brightens upward, with a lamp as wide as 15 degrees.
glm::dvec3 lamp_sky(glm::dvec3 d)
{
    static const glm::dvec3 lamp = glm::normalize(glm::dvec3(0.3, 0.8, 0.6));
    return glm::dvec3(0.3, 0.5, 0.9) * (1.3 + d.z + 0.3 * std::sin(4 * d.x)) +
           glm::dvec3(20, 16, 10) * std::exp(30 * (glm::dot(d, lamp) - 1));
}

/// Of lamp_sky() what a round lobe of GGX about d has.
glm::dvec3 round_lobe(glm::dvec3 d, double alpha)
{
    constexpr int kRings = 40, kTurns = 48;
    const glm::dvec3 x = glm::normalize(
        glm::cross(d, std::abs(d.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 y = glm::cross(d, x);
    glm::dvec3 sum(0);
    double weights = 0;
    for (int i = 0; i < kRings; ++i) {
        const double u = (i + 0.5) / kRings;
        const double angle = 2 * std::atan(alpha * std::sqrt(u / (1 - u)));
        if (angle >= kPi / 2)
            break;
        for (int j = 0; j < kTurns; ++j) {
            const double phi = 2 * kPi * (j + 0.5) / kTurns;
            sum += std::cos(angle) *
                   lamp_sky(std::cos(angle) * d +
                            std::sin(angle) * (std::cos(phi) * x + std::sin(phi) * y));
            weights += std::cos(angle);
        }
    }
    return sum / weights;
}

/// The mean of lamp_sky() over a surface's lobe as scene/ambient_gloss.glsl has it of maps without
/// texels: four round lobes.
glm::dvec3 four_round_lobes(glm::dvec3 wo, double alpha, glm::dvec3 f0)
{
    constexpr double kSlopes[3][4]{{-1.5567, 0.0581, -0.6070, 1.6021},
                                   {1.7452, -0.5586, 2.9181, -0.4813},
                                   {-0.0859, 0.8849, -1.6474, 0.0219}};
    constexpr double kWidths[3][4]{{1.0693, 1.6638, 0.0451, 1.4278},
                                   {0.5580, -3.6862, 1.6229, 1.2999},
                                   {-0.5322, 3.5409, -0.1982, -0.2568}};
    const double r = std::sqrt(alpha);
    const auto at = [&](const double(&c)[3][4], int i) {
        return c[0][i] + r * (c[1][i] + r * c[2][i]);
    };
    const glm::dvec3 n(0, 0, 1);
    glm::dvec3 sum(0), weights(0);
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 h = glm::normalize(n + (wo - n * wo.z) * (alpha * at(kSlopes, i)));
        const double wo_h = glm::dot(wo, h);
        const glm::dvec3 d = 2 * wo_h * h - wo;
        if (wo_h <= 0 || d.z <= 0)
            continue;
        const double v = ggx_d_v(1, wo.z, d.z, alpha) * kPi * alpha * alpha;
        const glm::dvec3 weight =
            (f0 + (1.0 - f0) * std::pow(1 - wo_h, 5)) * (v * d.z * wo_h / h.z);
        sum += weight * round_lobe(d, std::min(alpha * std::max(at(kWidths, i) * wo_h, 0.2), 1.0));
        weights += weight;
    }
    return sum / weights;
}

class ProbeSurfaces : public ImageTest {
protected:
    static Gloss gloss_of(double roughness, double metallic)
    {
        return {.roughness = static_cast<float>(roughness),
                .metallic = static_cast<float>(metallic)};
    }

    /// A ball of 1 m at the origin, seen by a camera of 12 degrees.
    static Scene ball_scene(int size, Gloss gloss)
    {
        Scene scene = empty_scene(size);
        scene.camera.position = {0, -10, 0};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.up = {0, 0, 1};
        scene.camera.vfov_deg = 12;
        scene.world.radiance = glm::vec3(0);
        SphereSurface ball;
        ball.albedo = glm::vec3(1);
        ball.gloss = gloss;
        scene.surfaces = {ball};
        return scene;
    }

    /// Where the ray of a pixel meets it; false beside it.
    static bool meets_ball(const PixelRay& ray, glm::dvec3& n)
    {
        const double b = glm::dot(ray.origin, ray.direction);
        const double root = b * b - glm::dot(ray.origin, ray.origin) + 1;
        if (root < 0)
            return false;
        n = ray.origin + ray.direction * (-b - std::sqrt(root));
        return true;
    }
};

TEST_F(ProbeSurfaces, AWhiteBallInAnEvenMapIsAsBrightAsIt)
{
    for (const double metallic : {0.0, 1.0})
        for (const double roughness : {0.0, 0.1, 0.3, 0.6, 1.0}) {
            Scene scene = ball_scene(32, gloss_of(roughness, metallic));
            scene.world.environment = environment_of(32, [](glm::dvec3) { return glm::dvec3(1); });
            const Still still = render(scene, plain_settings());
            for (const float value : still.composite)
                ASSERT_NEAR(value, 1, 0.01)
                    << "roughness " << roughness << " metallic " << metallic;
        }
}

TEST_F(ProbeSurfaces, AMirrorBallShowsTheMap)
{
    const int size = 64;
    Scene scene = ball_scene(size, gloss_of(0, 1));
    scene.world.environment = environment_of(512, lamp_sky);
    const Still still = render(scene, plain_settings());
    double worst = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const PixelRay ray = ray_of(scene, x, y);
            glm::dvec3 n;
            if (!meets_ball(ray, n) || -glm::dot(n, ray.direction) < 0.3)
                continue;  // the ball is of triangles: at its edge it misses the sphere's
            const glm::dvec3 expected = lamp_sky(glm::reflect(ray.direction, n));
            const glm::dvec3 found(pixel(still.composite, size, x, y));
            for (int c = 0; c < 3; ++c)
                worst = std::max(worst, std::abs(found[c] / expected[c] - 1));
        }
    figure("mirror_worst", worst);
    // A texel of 0.7 degrees, where the lamp's light changes by 7 % a degree at most.
    EXPECT_LT(worst, 0.05);
}

TEST_F(ProbeSurfaces, RoughnessIsTheBrdfsIntegral)
{
    // A ground that fills the picture, so that the eye looks along all slants.
    const int size = 12;
    const auto map = environment_of(512, lamp_sky);
    for (const double metallic : {0.0, 1.0})
        for (const double roughness : {0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0}) {
            Scene scene = empty_scene(size);
            scene.camera.position = {0, -3, 2.5};
            scene.camera.look_at = {0, 0, 0};
            scene.camera.up = {0, 0, 1};
            scene.camera.vfov_deg = 50;
            scene.world.environment = map;
            BoxSurface ground;
            ground.min = {-50, -50, -1};
            ground.max = {50, 50, 0};
            ground.albedo = {0.9f, 0.6f, 0.3f};
            ground.gloss = gloss_of(roughness, metallic);
            scene.surfaces = {ground};
            Settings settings = plain_settings();
            settings.ambient_volume_size = 0;  // the ground hides nothing of the sky
            const Still still = render(scene, settings);
            const double alpha = ggx_alpha(ground.gloss->roughness);
            const glm::dvec3 albedo(ground.albedo);
            const glm::dvec3 f0 = glm::mix(glm::dvec3(0.04), albedo, metallic);
            glm::dvec3 irradiance(0);
            for (int i = 0; i < 128; ++i)
                for (int j = 0; j < 256; ++j) {
                    const double c = std::sqrt((i + 0.5) / 128), phi = 2 * kPi * (j + 0.5) / 256;
                    const double s = std::sqrt(1 - c * c);
                    irradiance +=
                        lamp_sky({s * std::cos(phi), s * std::sin(phi), c}) * (kPi / (128 * 256));
                }
            double sum = 0, of_lobes = 0, to_lobes = 0;
            int asked = 0;
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const glm::dvec3 wo_world = -ray_of(scene, x, y).direction;
                    // over_ggx_lobe() has the eye anywhere above z.
                    glm::dvec3 reflected(0);
                    over_ggx_lobe(wo_world, alpha, 96, 96, [&](glm::dvec3 wi, double weight) {
                        const double f =
                            std::pow(1 - glm::dot(wo_world, glm::normalize(wo_world + wi)), 5);
                        reflected += weight * (f0 + (1.0 - f0) * f) * lamp_sky(wi);
                    });
                    const glm::dvec2 ab = ggx_albedos(wo_world.z, alpha, 64, 64);
                    const glm::dvec3 base = ggx_base(albedo, metallic, ab) / kPi * irradiance;
                    const glm::dvec3 expected = reflected + base;
                    const glm::dvec3 found(pixel(still.composite, size, x, y));
                    for (int c = 0; c < 3; ++c)
                        sum += std::pow(found[c] / expected[c] - 1, 2) / (3.0 * size * size);
                    if (metallic == 0 || roughness < 0.3 || x % 3 != 1 || y % 3 != 0)
                        continue;
                    const glm::dvec3 lobes =
                        (f0 * ab.x + ab.y) * four_round_lobes(wo_world, alpha, f0) + base;
                    ++asked;
                    for (int c = 0; c < 3; ++c) {
                        of_lobes += std::pow(lobes[c] / expected[c] - 1, 2) / 3;
                        to_lobes += std::pow(found[c] / lobes[c] - 1, 2) / 3;
                    }
                }
            figure(fmt::format("roughness_{:.2f}_metallic_{:.0f}", roughness, metallic), sum);
            // Four round lobes stand for one that is none, and a metal shows nothing else: that is
            // most of what it errs by.
            EXPECT_LT(sum, 1e-3) << roughness << ' ' << metallic;
            if (asked == 0)
                continue;
            figure(fmt::format("roughness_{:.2f}: four round lobes, exactly", roughness),
                   of_lobes / asked);
            figure(fmt::format("roughness_{:.2f}: to four round lobes", roughness),
                   to_lobes / asked);
            EXPECT_LT(to_lobes / asked, 1e-3) << roughness;
        }
}

/// A room whose walls glow, each in a colour of its own, with a ball in it and a probe.
class ProbeRoom : public ProbeSurfaces {
protected:
    static constexpr glm::dvec3 kLow{-2, -3, 0}, kHigh{2, 2, 3};
    static glm::dvec3 wall_color(int axis, bool high)
    {
        glm::dvec3 color(high ? 0.2 : 1.0);
        color[axis] = high ? 1.0 : 0.1;
        return color;
    }

    static Scene room(int size, Gloss gloss, double ball, bool white)
    {
        Scene scene = empty_scene(size);
        scene.camera.position = {0.2, -2.5, 1.4};
        scene.camera.look_at = {0.3, 0.5, 1.2};
        scene.camera.up = {0, 0, 1};
        scene.camera.vfov_deg = 12;
        scene.world.radiance = glm::vec3(0);
        scene.surfaces.clear();
        for (int axis = 0; axis < 3; ++axis)
            for (const bool high : {false, true}) {
                BoxSurface wall;
                wall.min = kLow - 0.5;
                wall.max = kHigh + 0.5;
                (high ? wall.min : wall.max)[axis] = (high ? kHigh : kLow)[axis];
                wall.albedo = glm::vec3(0);
                wall.emission = white ? glm::vec3(1) : glm::vec3(wall_color(axis, high));
                scene.surfaces.emplace_back(wall);
            }
        SphereSurface sphere;
        sphere.center = {0.3, 0.5, 1.2};
        sphere.radius = ball;
        sphere.albedo = glm::vec3(1);
        sphere.gloss = gloss;
        scene.surfaces.emplace_back(sphere);
        LightProbe probe;
        probe.position = {-0.4, -0.6, 1.7};
        probe.radius = 8;
        probe.falloff = 0.2;
        probe.parallax = LightProbe::Parallax::box;
        probe.parallax_min = kLow;
        probe.parallax_max = kHigh;
        scene.probes = {probe};
        return scene;
    }
};

TEST_F(ProbeRoom, AMirrorBallShowsTheWallsWhereTheyAre)
{
    const int size = 48;
    const double radius = 0.25;
    for (const bool by_itself : {false, true}) {
        Scene scene = room(size, gloss_of(0, 1), radius, false);
        if (by_itself)
            scene.probes.clear();
        const Still still = render(scene, plain_settings());
        int right = 0, all = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const PixelRay ray = ray_of(scene, x, y);
                const glm::dvec3 from = ray.origin - glm::dvec3(0.3, 0.5, 1.2);
                const double b = glm::dot(from, ray.direction);
                const double root = b * b - glm::dot(from, from) + radius * radius;
                if (root < 0)
                    continue;
                const glm::dvec3 n = (from + ray.direction * (-b - std::sqrt(root))) / radius;
                if (-glm::dot(n, ray.direction) < 0.3)
                    continue;
                const glm::dvec3 d = glm::reflect(ray.direction, n);
                const glm::dvec3 p = glm::dvec3(0.3, 0.5, 1.2) + radius * n;
                double t = 1e30;
                int axis = 0;
                for (int a = 0; a < 3; ++a) {
                    const double to = ((d[a] > 0 ? kHigh : kLow)[a] - p[a]) / d[a];
                    if (to < t)
                        t = to, axis = a;
                }
                ++all;
                right += glm::length(glm::dvec3(pixel(still.composite, size, x, y)) -
                                     wall_color(axis, d[axis] > 0)) < 0.05
                             ? 1
                             : 0;
            }
        figure(by_itself ? "right_by_itself" : "right", double(right) / all);
        EXPECT_GT(all, 200);
        // All but edges, which are a texel wide.
        EXPECT_GT(right, 0.9 * all) << by_itself;
    }
}

TEST_F(ProbeRoom, AWhiteBallInAnEvenRoomIsAsBrightAsIt)
{
    for (const double metallic : {0.0, 1.0})
        for (const double roughness : {0.0, 0.3, 1.0}) {
            const Still still =
                render(room(24, gloss_of(roughness, metallic), 0.15, true), plain_settings());
            for (const float value : still.composite)
                ASSERT_NEAR(value, 1, 0.01) << roughness << ' ' << metallic;
        }
}

TEST_F(ProbeRoom, OffIsAsIfThereWereNone)
{
    Scene scene = room(24, gloss_of(0.3, 1), 0.3, false);
    Settings off = plain_settings();
    off.probes = Settings::Probes::off;
    const Still with = render(scene, plain_settings()), without = render(scene, off);
    scene.probes.clear();
    EXPECT_EQ(without.composite, render(scene, off).composite);
    EXPECT_NE(with.composite, without.composite);
    // Nor where none pays: a ground that reflects by the widest lobe, in the open.
    Scene open = ball_scene(24, gloss_of(1, 1));
    EXPECT_EQ(render(open, off).composite, render(open, plain_settings()).composite);
}

TEST_F(ProbeRoom, FramesCaptureOneWhileNothingMoves)
{
    Scene scene = room(24, gloss_of(0.3, 1), 0.3, false);
    scene.probes.push_back(scene.probes[0]);
    scene.probes[1].position = {0.8, 0.2, 1};
    using Update = Settings::ProbeUpdate;
    for (const Update update : {Update::still, Update::always, Update::never}) {
        Settings settings = plain_settings();
        settings.probe_update = update;
        Renderer renderer(get_proc());
        renderer.set_scene(scene, settings);
        View view = renderer.make_view();
        const gl::Texture color =
            gl::Texture::make_2d(gl(), "picture", glm::ivec2(24), GL_RGBA32F, gl::Filter::nearest);
        const gl::Texture depth = gl::Texture::make_2d(gl(), "depth", glm::ivec2(24),
                                                       GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
        int frames = 0;
        const auto brightness = [&] {
            const std::vector<float> values = color.read(4);
            return std::accumulate(values.begin(), values.end(), 0.0f);
        };
        const auto captured = [&](int i) {
            Camera camera = scene.camera;
            camera.position.x += 0.01 * i;
            // Each with a jitter of its own, as hosts have it that average frames.
            const Frame frame =
                still_frame(camera, settings, color.view(), depth.view(), frames++, 0);
            renderer.draw_surfaces(frame, settings, true);
            renderer.composite(view, frame, settings);
            return renderer.take_report().work.probes;
        };
        renderer.take_report();
        int moving = 0, standing = 0;
        for (int i = 0; i < 3; ++i)
            moving += captured(i);
        const int at_once = captured(2);
        for (int i = 0; i < 6; ++i)
            standing += captured(2);
        EXPECT_EQ(moving, update == Update::always ? 3 : 0);
        EXPECT_EQ(at_once, update == Update::never ? 0 : 1);
        // Two turns of two.
        EXPECT_EQ(moving + at_once + standing, update == Update::never ? 0 : 4);

        renderer.set_scene(scene, settings);  // the same
        EXPECT_EQ(captured(2), 0);
        // Another probe, before them: those that are there keep what they have seen.
        Scene more = scene;
        more.probes.insert(more.probes.begin(), scene.probes[0]);
        more.probes[0].position = {0.1, 0.9, 2};
        renderer.set_scene(more, settings);
        const auto captures = [&] {
            std::vector<int> all;
            for (const ProbeState& state : renderer.probes())
                all.push_back(state.captures);
            return all;
        };
        if (update != Update::never) {
            EXPECT_EQ(captures(), (std::vector<int>{0, 2, 2}));
            for (int i = 0; i < 3; ++i)
                captured(2);
            EXPECT_EQ(captures(), (std::vector<int>{2, 2, 2}));
        }
        // A mirror ball and a matt one of each are in the picture, where nothing is before them.
        if (update == Update::still) {
            const Frame frame =
                still_frame(scene.camera, settings, color.view(), depth.view(), 0, 0);
            const auto changed = [&](double radius) {
                captured(2);
                const std::vector<float> plain = color.read(4);
                gl()->BindTextureUnit(SCENE_DEPTH_UNIT, 0);  // it binds what it reads
                renderer.draw_probes(frame, settings, radius);
                const std::vector<float> with = color.read(4);
                int count = 0;
                for (std::size_t i = 0; i < plain.size(); i += 4)
                    count += plain[i] != with[i] ? 1 : 0;
                return count;
            };
            EXPECT_GT(changed(0.2), 10);
            EXPECT_LT(changed(0.2), 24 * 24 / 2);
            EXPECT_EQ(changed(1e-6), 0);
        }
        // Those that are dragged keep their light until they are captured where they are now.
        if (update == Update::still) {
            for (int i = 0; i < 9; ++i)
                captured(2);
            const float before = brightness();
            for (LightProbe& probe : more.probes)
                probe.position.x += 0.05;
            renderer.set_scene(more, settings);
            captured(2);
            EXPECT_EQ(captures(), std::vector<int>(3, 2));
            EXPECT_NEAR(brightness() / before, 1, 0.02);
        }
        std::get<BoxSurface>(scene.surfaces[0]).emission *= 1.5f;
        renderer.set_scene(scene, settings);
        EXPECT_EQ(captured(2), update == Update::always ? 1 : 0) << "the scene has just changed";
        EXPECT_EQ(captured(2), update == Update::never ? 0 : 1);
        if (update != Update::still)
            continue;
        // A light in the room lights nothing that a probe outside of it sees.
        Scene two = scene;
        two.probes[0].radius = 1.8;  // or it would light the walls' outsides
        two.probes[1].radius = 3;
        two.probes[1].position = {6, 0, 1};
        two.surfaces.emplace_back(BoxSurface{{-9, -9, -2}, {9, 9, -1}});
        two.world.radiance = glm::vec3(0.3f);
        for (std::size_t i = 0; i < 6; ++i)
            std::get<BoxSurface>(two.surfaces[i]).albedo = glm::vec3(0.5f);
        const auto new_captures = [&] {
            const std::vector<int> before = captures();
            renderer.set_scene(two, settings);
            for (int i = 0; i < 10; ++i)
                captured(2);
            std::vector<int> all = captures();
            for (std::size_t i = 0; i < all.size() && i < before.size(); ++i)
                all[i] -= before[i];
            return all;
        };
        new_captures();
        two.lights.emplace_back(PointLight{{0, 0, 1.5}, glm::vec3(2)});
        EXPECT_EQ(new_captures(), (std::vector<int>{2, 0}));
        // Nor is a ball beside it seen from within.
        two.surfaces.emplace_back(SphereSurface{{0, 8, 0}, 1});
        EXPECT_EQ(new_captures(), (std::vector<int>{0, 2}));
    }
}

// Whatever a probe is put into, it gives numbers.
TEST_F(ProbeRoom, OddPlacesGiveNumbers)
{
    for (const glm::dvec3 place : {glm::dvec3(0.3, 0.5, 1.2),  // in the ball
                                   glm::dvec3(0, 5, 1),        // behind a wall, outside its box
                                   glm::dvec3(0, -1, 1)}) {  // in smoke that nothing shines through
        Scene scene = room(16, gloss_of(0.2, 1), 0.3, false);
        scene.probes[0].position = place;
        scene.probes[0].size = 32;
        BoxMedium smoke;
        smoke.min = {-1, -2, 0};
        smoke.max = {1, 0.1, 2.5};
        smoke.sigma_s = glm::vec3(300);
        scene.media = {smoke};
        scene.world.environment = environment_of(
            64, [](glm::dvec3 d) { return d.z > 0.99 ? glm::dvec3(1e5) : glm::dvec3(0); });
        const Still still = render(scene, plain_settings());
        for (const float value : still.composite)
            ASSERT_TRUE(std::isfinite(value) && value >= 0) << place.x << ' ' << place.y;
    }
}

// Walls that shine through fog, as a metal ball between them shows both.
TEST_F(ProbeSurfaces, ABallInFogBetweenTwoWallsIsTheReferences)
{
    const int size = 6;
    Scene scene = ball_scene(size, gloss_of(0.4, 1));
    scene.camera.position = {0, -4.5, 0};
    scene.camera.vfov_deg = 18;  // inside of the ball's edge
    scene.world.radiance = glm::vec3(0.05f);
    BoxSurface red, green;
    red.min = {-3.5, -5, -3};
    red.max = {-3, 3, 3};
    red.albedo = {0.5f, 0.1f, 0.1f};
    red.emission = {2, 0.2f, 0.1f};
    green.min = {3, -5, -3};
    green.max = {3.5, 3, 3};
    green.albedo = {0.1f, 0.5f, 0.1f};
    green.emission = {0.1f, 1.5f, 0.3f};
    scene.surfaces.emplace_back(red);
    scene.surfaces.emplace_back(green);
    BoxMedium fog;
    fog.min = {-3, -4, -2.5};
    fog.max = {3, 2.5, 2.5};
    fog.sigma_s = glm::vec3(0.08f);
    fog.sigma_a = glm::vec3(0.05f);
    scene.media = {fog};
    LightProbe probe;
    probe.position = {0.2, -1.4, 0.2};
    probe.radius = 6;
    probe.parallax = LightProbe::Parallax::box;
    probe.parallax_min = {-3, -5, -3};
    probe.parallax_max = {3, 3, 3};
    probe.size = 64;
    scene.probes = {probe};
    study::ReferenceOptions options;
    options.tolerance = 0.05;
    options.bounces = options.surface_bounces = study::kAllBounces;
    const study::ReferenceStill truth = study::render_reference(scene, options);
    Settings settings;
    settings.resolution = 1;
    const study::Metrics with = study::compare(render(scene, settings).composite, truth.composite);
    settings.probes = Settings::Probes::off;
    const study::Metrics without =
        study::compare(render(scene, settings).composite, truth.composite);
    scene.probes.clear();
    settings.probes = Settings::Probes::automatic;
    const study::Metrics by_itself =
        study::compare(render(scene, settings).composite, truth.composite);
    figure("relmse", with.relmse);
    figure("bias", with.bias);
    figure("by_itself", by_itself.relmse);
    figure("without", without.relmse);
    EXPECT_LT(with.relmse, 1e-2);
    // The ball is up to a metre nearer to the walls than the probe: -4.2 % if fog were left as the
    // probe sees it.
    EXPECT_LT(std::abs(with.bias), 0.03);
    EXPECT_LT(by_itself.relmse, 1e-2);
    EXPECT_GT(without.relmse, 3 * with.relmse);
}

}  // namespace
}  // namespace fumarole::test
