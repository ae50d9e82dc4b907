// Light that scatters more than once: what is known of it in closed form, and a path tracer.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

#include "image_test.h"
#include "study/metrics.h"
#include "study/reference.h"
#include <fumarole/asset/scene_file.h>
#include <fumarole/asset/vdb_file.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

study::ReferenceOptions all_bounces()
{
    study::ReferenceOptions options;
    options.tolerance = 0.03;
    options.bounces = study::kAllBounces;
    return options;
}

class Bounces : public ImageTest {
protected:
    /// A box of 2 m that is looked at askew, in a white world or none.
    static Scene box_scene(float sigma_s, float sigma_a, float g, float world)
    {
        Scene scene = empty_scene(24);
        scene.camera.position = {2, -4, 1.5};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.vfov_deg = 40;
        scene.world.radiance = glm::vec3(world);
        BoxMedium box;
        box.min = glm::dvec3(-1);
        box.max = glm::dvec3(1);
        box.sigma_s = sigma_s * glm::vec3(1, 0.5f, 0.25f);
        box.sigma_a = sigma_a * glm::vec3(1, 0.5f, 0.25f);
        box.g = g;
        scene.media = {box};
        return scene;
    }
    static double mean(const std::vector<float>& picture)
    {
        double sum = 0;
        for (const float v : picture)
            sum += v;
        return sum / static_cast<double>(picture.size());
    }
    /// The mean of what media scatter and emit.
    double seen(const Scene& scene, int bounces)
    {
        Settings settings = plain_settings();
        settings.bounces = bounces;
        return mean(render(scene, settings).scattering);
    }
    /// By how much more of it the default has than the path tracer.
    double bias(const char* name, const Scene& scene)
    {
        const double truth = mean(study::render_reference(scene, all_bounces()).scattering);
        const double by = seen(scene, kAutomatic) / truth - 1;
        figure(fmt::format("{}: bias", name), by);
        return by;
    }
    /// A ball of white smoke, of so many bricks along an edge.
    static GridMedium white_ball(int bricks, double voxel, glm::dvec3 middle, float sigma_s)
    {
        const int voxels = 8 * bricks;
        GridMedium ball;
        ball.density =
            make_grid(glm::ivec3(bricks), study::voxels(voxel, middle - 0.5 * voxel * (voxels - 1)),
                      [&](glm::ivec3 at) {
                          const glm::dvec3 off = glm::dvec3(at) - 0.5 * (voxels - 1);
                          return std::clamp(0.5 * voxels - 1 - glm::length(off), 0.0, 1.0);
                      });
        ball.sigma_s_per_density = glm::vec3(sigma_s);
        return ball;
    }
    /// A ball of white smoke, 3.5 m wide and an optical depth of some 5, and 120 m of fog.
    static Scene foggy_scene(int size)
    {
        Scene scene = empty_scene(size);
        scene.camera.position = {3, -14, 4};
        scene.camera.look_at = {0, 0, 0};
        scene.camera.vfov_deg = 12;
        BoxMedium fog;
        fog.min = {-60, -60, -20};
        fog.max = {60, 60, 20};
        fog.sigma_s = glm::vec3(0.01f);
        scene.media = {white_ball(2, 0.25, {0, 0, 0}, 1.5f), fog};
        return scene;
    }
    /// The sample's fire, looked at from near by.
    static Scene fire_scene(int size, float sigma_s, float sigma_a, float emission)
    {
        const fs::path file = fs::path(FUM_TEST_DATA) / "fire_plume.vdb";
        const auto grid = [&](const char* name) {
            return std::make_shared<const VoxelGrid>(asset::load_grid(file, name).grid);
        };
        Scene scene = empty_scene(size);
        scene.camera.position = {1.5, -14.5, 1.7};
        scene.camera.look_at = {-0.05, 0, 1.6};
        scene.camera.vfov_deg = 8;
        GridMedium smoke;
        smoke.density = grid("density");
        smoke.emission = grid("flame");
        smoke.sigma_s_per_density = glm::vec3(sigma_s);
        smoke.sigma_a_per_density = glm::vec3(sigma_a);
        smoke.emission_per_unit = glm::vec3(emission);
        scene.media = {smoke};
        return scene;
    }
    Still with_bounces(const Scene& scene, Settings settings, int bounces)
    {
        settings.bounces = bounces;
        settings.ambient_volume_size = 12;
        return render(scene, settings);
    }
};

// Albedo 1 in a white world: whatever is scattered away is scattered in.
TEST_F(Bounces, WhiteFurnace)
{
    struct Case {
        float sigma_s, g;
        double mean, worst;
        int bounces = 40;
    };
    // Measured when the bounds were set: 0.0001, 0.0004; 0.0004, 0.0017; 0.0004, 0.0022; and with a
    // guess at what no number of orders reaches, 0.001, 0.002 but for the third, of which three
    // orders are followed and their lobes with them: 0.0004, 0.01. Forty orders are not enough for
    // an optical depth of 20: 0.016, 0.13.
    for (const Case& c :
         {Case{0.1f, 0, 0.0002, 0.001}, Case{1, 0, 0.001, 0.003}, Case{10, 0, 0.02, 0.15},
          Case{1, 0.7f, 0.001, 0.004}, Case{1, 0.7f, 0.001, 0.013, Settings::kAutomatic},
          Case{10, 0, 0.0015, 0.004, Settings::kAutomatic},
          Case{10, 0.7f, 0.0015, 0.004, Settings::kAutomatic},
          Case{1000, 0, 0.0015, 0.004, Settings::kAutomatic}}) {
        const Scene scene = box_scene(c.sigma_s, 0, c.g, 1);
        for (const Settings& settings : {plain_settings(), plain_froxels(4)}) {
            const Still still = with_bounces(scene, settings, c.bounces);
            const auto [low, high] =
                std::minmax_element(still.composite.begin(), still.composite.end());
            const double worst = std::max(1.0 - *low, *high - 1.0);
            const std::string name = fmt::format("sigma_s {}, g {}, bounces {}, {}", c.sigma_s, c.g,
                                                 c.bounces, mode_name(settings.mode));
            EXPECT_NEAR(mean(still.composite), 1, c.mean) << name;
            EXPECT_LT(worst, c.worst) << name;
            figure("furnace, mean error, " + name, mean(still.composite) - 1);
            figure("furnace, worst error, " + name, worst);
        }
    }
}

// Each order has its source from the one before and loses some of it: more of them add ever less,
// and all together no more than what came in.
TEST_F(Bounces, OrdersFallOffAndMakeNoLight)
{
    for (const float g : {0.0f, 0.7f}) {
        Scene scene = box_scene(20, 0, g, 0);
        scene.lights = {SunLight{{0.5, -0.6, 0.6}, glm::vec3(3)}};
        std::vector<double> light;
        for (const int bounces : {0, 1, 2, 3, 4, 12, 40})
            light.push_back(mean(with_bounces(scene, plain_settings(), bounces).scattering));
        for (std::size_t i = 1; i < light.size(); ++i)
            EXPECT_GT(light[i], light[i - 1]) << "g " << g << ", step " << i;
        for (std::size_t i = 2; i < 5 && g == 0; ++i)
            EXPECT_LT(light[i] - light[i - 1], light[i - 1] - light[i - 2]) << "order " << i;
        // A white box sends back less than a white wall would, all of it towards us: E / pi.
        const double most = 3 / 3.14159;
        const Still still = with_bounces(scene, plain_settings(), 40);
        for (const float v : still.scattering)
            ASSERT_LT(v, 1.5 * most) << "g " << g;
        EXPECT_LT(mean(still.scattering), most);
    }
}

// A wall between two boxes, thinner than a node: no light gets past it, but where a lookup lies
// between the last node behind it and the first before it, of which it has a part.
TEST_F(Bounces, StopAtWalls)
{
    Scene scene = box_scene(2, 0, 0, 0);
    scene.lights = {PointLight{{0.8, 0.1, 0.1}, glm::vec3(5)}};
    scene.surfaces = {BoxSurface{{-0.01, -30, -30}, {0.01, 30, 30}, glm::vec3(0)}};
    scene.camera.position = {-4, -4, 0.5};
    const Still dark = with_bounces(scene, plain_settings(), 8);
    scene.surfaces.clear();
    const Still lit = with_bounces(scene, plain_settings(), 8);
    // Seen from behind the wall.
    double behind = 0, open = 0;
    for (std::size_t i = 0; i < dark.scattering.size(); ++i) {
        behind = std::max(behind, static_cast<double>(dark.scattering[i]));
        open = std::max(open, static_cast<double>(lit.scattering[i]));
    }
    EXPECT_GT(open, 0.05);
    EXPECT_LT(behind, 0.012 * open);
    figure("behind a wall, of the open", behind / open);
}

// What glows lights its neighbours: a dim medium beside a bright one has light with no lamp.
TEST_F(Bounces, EmissionIsALight)
{
    Scene scene = box_scene(0.5f, 0, 0, 0);
    BoxMedium ember;
    ember.min = {0.5, -0.25, -0.25};
    ember.max = {0.9, 0.25, 0.25};
    ember.sigma_a = glm::vec3(1);
    ember.emission = glm::vec3(4, 2, 1);
    scene.media.push_back(ember);
    const Still off = with_bounces(scene, plain_settings(), 0);
    const Still on = with_bounces(scene, plain_settings(), 4);
    const double added = mean(on.scattering) - mean(off.scattering);
    EXPECT_GT(added, 0.05 * mean(off.scattering));
    figure("emission scattered, of what is seen at once", added / mean(off.scattering));
}

// With no bounce it is direct light: a thin glowing box over a floor, against the integral over it.
// Where something stands where a light of its would be, its light comes along 74 ways, of which one
// goes straight down: right under it is 6 % too much, what is missing there is missing beside it.
TEST_F(Bounces, FireLightsTheFloorUnderIt)
{
    constexpr double kEdge = 1, kEmission = 4, kHeight = 0.9;
    struct Case {
        double beside, relmse;
        bool carried;
    };
    double light[2] = {}, expected[2] = {};
    for (const Case& c : {Case{0, 2e-2, true}, Case{0.7, 4e-2, true}, Case{0, 1e-4, false},
                          Case{0.7, 1e-4, false}}) {
        Scene scene = empty_scene(24);
        scene.camera.position = {c.beside, c.beside, 4};
        scene.camera.look_at = {c.beside, c.beside + 1e-3, 0};
        scene.camera.vfov_deg = 14;  // what is as near to it as half of its size
        BoxMedium fire;
        fire.min = glm::dvec3(-kEdge / 2, -kEdge / 2, kHeight - kEdge / 2);
        fire.max = fire.min + kEdge;
        fire.sigma_a = glm::vec3(1e-3f);
        fire.emission = glm::vec3(kEmission);
        scene.media = {fire};
        scene.surfaces = {BoxSurface{{-3, -3, -0.5}, {3, 3, 0}, glm::vec3(1)}};
        if (c.carried)
            scene.surfaces.emplace_back(
                SphereSurface{{kEdge / 4, kEdge / 4, kHeight + kEdge / 4}, 0.01, glm::vec3(0)});
        Settings settings = plain_settings();
        settings.bounces = 0;
        const Still still = render(scene, settings);
        const Image truth = ideal(scene, [&](glm::dvec2 at) {
            const PixelRay ray = ray_at(scene, at);
            const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
            constexpr int kCells = 8;
            double irradiance = 0;
            for (int i = 0; i < kCells * kCells * kCells; ++i) {
                const glm::dvec3 cell(i % kCells, i / kCells % kCells, i / (kCells * kCells));
                const glm::dvec3 way = glm::dvec3(fire.min) + (cell + 0.5) * (kEdge / kCells) - p;
                irradiance += kEmission * std::pow(kEdge / kCells, 3) * way.z /
                              std::pow(glm::dot(way, way), 1.5);
            }
            return glm::dvec3(irradiance / std::numbers::pi);
        });
        const study::Metrics m = study::compare(still.surface_lit, truth.pixels);
        const std::string name = fmt::format("floor {} m beside a fire{}: ", c.beside,
                                             c.carried ? ", whose light is carried" : "");
        figure(name + "relMSE", m.relmse);
        figure(name + "bias", m.bias);
        EXPECT_LT(m.relmse, c.relmse) << name;
        light[c.carried ? 1 : 0] += mean(still.surface_lit);
        expected[c.carried ? 1 : 0] += mean(truth.pixels);
    }
    figure("floor under and beside a fire: bias", light[0] / expected[0] - 1);
    figure("floor under and beside a fire whose light is carried: bias",
           light[1] / expected[1] - 1);
    EXPECT_NEAR(light[0], expected[0], 0.01 * expected[0]);
    // 9 harmonics of light from straight above add up to 17/16 of it.
    EXPECT_NEAR(light[1], expected[1], 0.0625 * expected[1]);
}

/// A slab of optical depth 6, with haze around it or not.
std::vector<Medium> slab_in_haze(float g, bool hazy)
{
    BoxMedium slab, haze;
    slab.min = {-3, -3, -0.5};
    slab.max = {3, 3, 0.5};
    slab.sigma_s = glm::vec3(5.4f);
    slab.sigma_a = glm::vec3(0.6f);
    slab.g = g;
    haze.min = {-3, -3, -2};
    haze.max = {3, 3, 2};
    haze.sigma_s = glm::vec3(0.1f);
    std::vector<Medium> media{slab};
    if (hazy)
        media.emplace_back(haze);
    return media;
}

// What smoke scatters onto a floor, which nothing else lights but what is in it and a lamp: against
// the sum over its cells. It comes along rays to all of the smoke, and shows none.
TEST_F(Bounces, SmokeLightsTheFloorUnderIt)
{
    constexpr float kSigma = 0.005f, kIntensity = 900;
    const glm::dvec3 lamp{0.3, -0.2, 4.5};
    Scene scene = empty_scene(48);
    scene.camera.position = {0.02, 0.01, 30};
    scene.camera.look_at = {0.02, 0.011, 0};
    scene.camera.vfov_deg = 6;
    BoxMedium smoke;
    smoke.min = {-0.8, -0.8, 0.5};
    smoke.max = {0.8, 0.8, 2.5};
    smoke.sigma_s = glm::vec3(kSigma);
    smoke.emission = glm::vec3(1e-6f);
    scene.media = {smoke};
    scene.lights = {PointLight{lamp, glm::vec3(kIntensity)}};
    scene.surfaces = {BoxSurface{{-9, -9, -0.5}, {9, 9, 0}, glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.surface_bounces = 0;
    settings.bounces = 0;
    const std::vector<float> direct = render(scene, settings).surface_lit;
    settings.bounces = 1;
    std::vector<float> seen = render(scene, settings).surface_lit;
    for (std::size_t i = 0; i < seen.size(); ++i)
        seen[i] -= direct[i];
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
        constexpr int kCells = 10;
        const glm::dvec3 edges = (smoke.max - smoke.min) / double(kCells);
        double irradiance = 0;
        for (int i = 0; i < kCells * kCells * kCells; ++i) {
            const glm::dvec3 cell(i % kCells, i / kCells % kCells, i / (kCells * kCells));
            const glm::dvec3 q = smoke.min + (cell + 0.5) * edges, way = q - p;
            const double range = glm::length(way), from_lamp = glm::distance(lamp, q);
            const double in_smoke = (q.z - smoke.min.z) / way.z * range +
                                    (smoke.max.z - q.z) / (lamp.z - q.z) * from_lamp;
            irradiance += std::exp(-double(kSigma) * in_smoke) / (from_lamp * from_lamp) * edges.x *
                          edges.y * edges.z * way.z / std::pow(range, 3);
        }
        irradiance *= double(kIntensity * kSigma) / (4 * std::numbers::pi);
        return glm::dvec3(irradiance / std::numbers::pi);
    });
    const study::Metrics m = study::compare(seen, truth.pixels);
    figure("floor under smoke: relMSE", m.relmse);
    figure("floor under smoke: bias", m.bias);
    double least = 1e9, most = 0;
    for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
        const double ratio = double(seen[i]) / double(truth.pixels[i]);
        least = std::min(least, ratio);
        most = std::max(most, ratio);
    }
    figure("floor under smoke: least", least);
    figure("floor under smoke: most", most);
    EXPECT_LT(m.relmse, 2e-3);
    EXPECT_LT(std::abs(m.bias), 0.04);
}

// White smoke takes nothing in: around a lamp in the middle of a ball of it all is as if there were
// none, but for the ball. The floor has that light far beyond the nodes that light on surfaces is
// kept at, and along their rim. Along 26 ways it falls in a star, of which a ring has a tenth too
// much or too little; where a node's cell has an optical depth of 1 light is lost on its way out.
TEST_F(Bounces, SmokeWithALampInItLightsTheFloorFarOff)
{
    constexpr double kHeight = 2.5, kIntensity = 100;
    for (const auto& [sigma_s, bound] :
         {std::pair{3.0f, 0.12}, std::pair{6.0f, 0.12}, std::pair{12.0f, 0.35}}) {
        Scene scene = empty_scene(48);
        scene.camera.position = {0, 0, 50};
        scene.camera.look_at = {0, 0.001, 0};
        scene.camera.projection = Camera::Projection::orthographic;
        scene.camera.ortho_height = 24;
        scene.media = {white_ball(3, 0.1, {0, 0, kHeight}, sigma_s)};
        scene.lights = {PointLight{{0, 0, kHeight}, glm::vec3(kIntensity)}};
        scene.surfaces = {BoxSurface{{-40, -40, -0.5}, {40, 40, 0}, glm::vec3(1)}};
        Settings settings = plain_settings();
        settings.surface_bounces = 0;
        settings.bounces = kAutomatic;
        const std::vector<float> seen = render(scene, settings).surface_lit;
        for (const auto& [from, to] :
             {std::pair{1.5, 3.0}, std::pair{3.0, 6.0}, std::pair{6.0, 12.0}}) {
            double found = 0, expected = 0;
            for (int i = 0; i < 48 * 48; ++i) {
                const glm::dvec2 at = 0.5 * glm::dvec2(i % 48 - 23.5, i / 48 - 23.5);
                const double off = glm::length(at);
                if (off < from || off >= to)
                    continue;
                found += double{seen[static_cast<std::size_t>(3 * i)]};
                expected +=
                    kIntensity * kHeight / std::pow(std::hypot(off, kHeight), 3) / std::numbers::pi;
            }
            figure(fmt::format("floor {} to {} m from a lamp in smoke of {} a metre: bias", from,
                               to, sigma_s),
                   found / expected - 1);
            EXPECT_NEAR(found, expected, bound * expected) << from << " to " << to << " m";
        }
    }
}

// A slab in a sun, from where it is lit and from behind, against the path tracer. Four bands of a
// phase function of g 0.7 send too much light on and too little back, and light gets to the far
// side in many orders. Haze around it scatters nothing straight on, and so dims whole.
TEST_F(Bounces, ASlabSendsAsMuchLightBackAsItLetsThrough)
{
    Scene scene = empty_scene(2);
    scene.camera.vfov_deg = 1;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.3, 0.2, 1)), glm::vec3(3)}};
    const study::ReferenceOptions options = all_bounces();
    struct Case {
        float g;
        bool hazy;
    };
    for (const Case& one : {Case{0, false}, Case{0.7f, false}, Case{0.8f, true}})
        for (const double side : {1.0, -1.0}) {
            scene.media = slab_in_haze(one.g, one.hazy);
            scene.camera.position = {0.5, 0.4, side * 6};
            scene.camera.look_at = {0.5, 0.41, 0};
            const double truth = mean(study::render_reference(scene, options).scattering);
            for (Settings settings : plain_siblings()) {
                settings.bounces = kAutomatic;
                const double seen = mean(render(scene, settings).scattering);
                const std::string where =
                    fmt::format("{}, g {}", side > 0 ? "lit side" : "far side", one.g);
                figure(where, seen / truth - 1);
                EXPECT_NEAR(seen / truth, 1, 0.06) << where;
            }
        }
}

// Chandrasekhar 1960, "Radiative Transfer", ch. V: what a half space sends back towards a cosine
// mu, of a beam of irradiance 1 that comes along a cosine mu0 and is scattered alike to all sides.
double sent_back(double albedo, double mu, double mu0)
{
    constexpr int kPoints = 200;
    std::vector<double> x(kPoints), h(kPoints, 1.0);
    for (int i = 0; i < kPoints; ++i)
        x[std::size_t(i)] = (i + 0.5) / kPoints;
    const auto next = [&](double at) {
        double sum = 0;
        for (std::size_t i = 0; i < h.size(); ++i)
            sum += x[i] * h[i] / (at + x[i]);
        return 1 / (std::sqrt(1 - albedo) + 0.5 * albedo * sum / kPoints);
    };
    for (int turn = 0; turn < 200; ++turn) {
        std::vector<double> better(h.size());
        for (std::size_t i = 0; i < h.size(); ++i)
            better[i] = next(x[i]);
        h = std::move(better);
    }
    const double pi = 3.14159265358979;
    return albedo / (4 * pi) * mu0 / (mu + mu0) * next(mu) * next(mu0);
}

// A box of 12 mean free paths, lit from before its face and from beside it. What comes along the
// face is half of it from outside: taken for light that went through the medium all along, it made
// the face up to 8 % too bright, and 15 % where the sun comes along it. That falls off from the
// face within less than a cell of nodes.
TEST_F(Bounces, AFaceOfADenseBoxIsThatOfAHalfSpace)
{
    Scene scene = empty_scene(2);
    scene.camera.vfov_deg = 1;
    BoxMedium box;
    box.min = glm::dvec3(-1);
    box.max = glm::dvec3(1);
    constexpr float kSigma = 6;
    const glm::vec3 albedo(0.5f, 0.7f, 0.85f);
    box.sigma_s = kSigma * albedo;
    box.sigma_a = kSigma * (1.0f - albedo);
    scene.media = {box};
    for (const double mu0 : {0.15, 0.5, 0.98})
        for (const double mu : {0.3, 0.9}) {
            const double across0 = std::sqrt(1 - mu0 * mu0), across = std::sqrt(1 - mu * mu);
            scene.lights = {SunLight{{0.6 * across0, 0.8 * across0, mu0}, glm::vec3(1)}};
            scene.camera.look_at = {0.03, 0.05, 1};
            scene.camera.position = scene.camera.look_at + 6.0 * glm::dvec3(across, 0, mu);
            for (Settings settings : plain_siblings()) {
                settings.bounces = kAutomatic;
                set_steps(settings, 256);  // within a mean free path of the face there are ten
                const std::vector<float> seen = render(scene, settings).scattering;
                for (std::size_t c = 0; c < 3; ++c) {
                    const double truth = sent_back(albedo[glm::length_t(c)], mu, mu0);
                    const std::string where = fmt::format("sun at {}, eye at {}, albedo {}", mu0,
                                                          mu, albedo[glm::length_t(c)]);
                    figure(where, double(seen[c]) / truth - 1);
                    EXPECT_NEAR(double(seen[c]) / truth, 1, mu0 < 0.2 ? 0.1 : 0.03) << where;
                }
            }
        }
}

// A tint takes from what is scattered, straight on as to all sides, so lights are dimmed by more.
TEST_F(Bounces, ATintIsDarkerSmoke)
{
    Scene scene = empty_scene(12);
    scene.camera.position = {3, -14, 4};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 18;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(-0.7, 0.5, 0.5)), glm::vec3(3)}};
    const auto grid_of = [](int bricks, int first) {
        return make_grid(
            glm::ivec3(bricks), study::voxels(0.125, glm::dvec3(-1.9375)),
            [](glm::ivec3) { return 1.0; }, glm::ivec3(first));
    };
    constexpr float kSigma = 3, kTint = 0.2f;
    GridMedium tinted, darker;
    tinted.density = darker.density = grid_of(4, 0);
    const auto tint = grid_of(6, -1);  // wider: it must not fade as well
    tint->channels = 3;
    tint->values.assign(3 * tint->values.size(), kTint);
    tint->max_value = kTint;
    tinted.color = tint;
    tinted.sigma_s_per_density = glm::vec3(kSigma);
    darker.sigma_s_per_density = glm::vec3(kTint * kSigma);
    darker.sigma_a_per_density = glm::vec3((1 - kTint) * kSigma);
    tinted.g = darker.g = 0.7f;
    Settings settings = plain_settings();
    settings.bounces = kAutomatic;
    scene.media = {darker};
    const Still expected = render(scene, settings);
    scene.media = {tinted};
    const study::Metrics m =
        study::compare(render(scene, settings).scattering, expected.scattering);
    figure("tinted smoke: relMSE", m.relmse);
    figure("tinted smoke: bias", m.bias);
    EXPECT_LT(m.relmse, 1e-4);
    EXPECT_LT(std::abs(m.bias), 0.01);
}

// A ball of few voxels, each an optical depth thick: what falls off within a voxel is told by
// nodes that stand closer than that. Three voxels apart a tenth is lost.
TEST_F(Bounces, FewThickVoxelsSendBackAsMuchAsManyWould)
{
    Scene scene = empty_scene(6);
    scene.camera.position = {3, -14, 4};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 12;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.7, -0.5, 0.5)), glm::vec3(3)}};
    GridMedium ball;
    ball.density =
        make_grid(glm::ivec3(2), study::voxels(0.25, {-1.875, -1.875, -1.875}), [](glm::ivec3 at) {
            return std::clamp(7 - glm::length(glm::dvec3(at) - 7.5), 0.0, 1.0);
        });
    ball.sigma_s_per_density = glm::vec3(3.6f);
    ball.sigma_a_per_density = glm::vec3(0.4f);
    scene.media = {ball};
    EXPECT_NEAR(bias("few thick voxels", scene), 0, 0.03);
}

// The sample's flame in smoke that is thick and nearly white: an optical depth of up to 3 lies
// between two nodes, and what they take in of each order they are to send out in the next.
TEST_F(Bounces, ThickSmokeLosesNoLightOfAFlame)
{
    const Scene scene = fire_scene(4, 20, 1, 3);
    EXPECT_NEAR(bias("flame in thick smoke", scene), 0, 0.1);
}

// A dense box asks for more orders than the mean of it and of the haze around it.
TEST_F(Bounces, ADenseBoxInHazeIsFollowedAsOftenAsOneAlone)
{
    Scene scene = empty_scene(12);
    scene.camera.position = {2, -9, 1.5};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 16;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.5, -0.6, 0.6)), glm::vec3(3)}};
    BoxMedium dense, haze;
    dense.min = glm::dvec3(-1);
    dense.max = glm::dvec3(1);
    dense.sigma_s = glm::vec3(8);
    dense.sigma_a = glm::vec3(0.08f);
    haze.min = glm::dvec3(-6);
    haze.max = glm::dvec3(6);
    haze.sigma_s = glm::vec3(0.005f);
    scene.media = {dense, haze};
    const double all = seen(scene, 64), by_default = seen(scene, kAutomatic);
    figure("dense box in haze: less than all orders", 1 - by_default / all);
    EXPECT_NEAR(by_default / all, 1, 0.02);
}

// Smoke in fog that is forty times as wide: nodes of one lattice for both would have nothing of it
// but its mean, and its lit side would be a third too dark.
TEST_F(Bounces, SmokeAmidWideFogIsLitAsSmokeAlone)
{
    Scene scene = foggy_scene(6);
    scene.camera.vfov_deg = 8;
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.7, -0.5, 0.5)), glm::vec3(3)}};
    EXPECT_NEAR(bias("smoke amid wide fog", scene), 0, 0.04);
}

// Smoke over a thin mist, with the sun behind it: much of what is seen of it is light of the mist,
// which leaves nodes of the wide lattice that have no medium near them.
TEST_F(Bounces, SmokeOverWideMistIsLitByIt)
{
    Scene scene = foggy_scene(6);
    scene.camera.position.z = 0;
    scene.camera.vfov_deg = 8;
    scene.media[0] = white_ball(6, 0.08, {0, 0, 0}, 1.5f);
    auto& mist = std::get<BoxMedium>(scene.media[1]);
    mist.min = {-20, -20, -5};
    mist.max = {20, 20, -4};
    mist.sigma_s = glm::vec3(2);
    scene.lights = {SunLight{glm::normalize(glm::dvec3(0.1, 0.6, 1)), glm::vec3(3)}};
    const double over_mist = seen(scene, kAutomatic);
    // Its nodes stand farther apart than it is thick.
    EXPECT_NEAR(bias("smoke over mist", scene), 0, 0.25);
    scene.media.pop_back();
    const double part = 1 - seen(scene, kAutomatic) / over_mist;
    figure("smoke over mist: part of its light that is the mist's", part);
    EXPECT_GT(part, 0.15);
}

// What fog sends into smoke amid it is what it scatters away of a white world. It is known of four
// bands at nodes that stand farther apart than the smoke is wide, some of whose light comes out of
// the smoke: 1 % too much.
TEST_F(Bounces, WhiteFurnaceOfSmokeAmidWideFog)
{
    Scene scene = foggy_scene(16);
    scene.world.radiance = glm::vec3(1);
    for (Settings settings : {plain_settings(), plain_froxels(4)}) {
        settings.bounces = kAutomatic;
        const Still still = render(scene, settings);
        const auto [low, high] =
            std::minmax_element(still.composite.begin(), still.composite.end());
        const std::string name(mode_name(settings.mode));
        figure("furnace amid fog, mean error, " + name, mean(still.composite) - 1);
        figure("furnace amid fog, worst error, " + name, std::max(1.0 - *low, *high - 1.0));
        EXPECT_NEAR(mean(still.composite), 1, 0.012) << name;
        EXPECT_GT(*low, 0.99) << name;
        EXPECT_LT(*high, 1.02) << name;
    }
}

// A fire in fog is a few points of light to the fog, and to its own smoke what glows in it.
TEST_F(Bounces, FireAmidWideFogLightsItsOwnSmoke)
{
    Scene scene = fire_scene(4, 12, 6, 3);
    BoxMedium fog;
    fog.min = {-15, -15, -3};
    fog.max = {15, 15, 12};
    fog.sigma_s = glm::vec3(0.02f);
    scene.media.emplace_back(fog);
    EXPECT_NEAR(bias("fire amid fog", scene), 0, 0.07);
}

// Near the sun's own direction light is spread by each scattering of a strong forward lobe: taken
// for light that goes straight on, that of g 0.9 is 74 % too bright 5 degrees from the sun, and
// 26 % too dark at 20. Haze around it spreads nothing.
TEST_F(Bounces, TheAureoleOfASunIsAsWideAsTheLobeMakesIt)
{
    Scene scene = empty_scene(2);
    scene.camera.vfov_deg = 1;
    scene.camera.position = {0.5, 0.4, -6};
    scene.camera.look_at = {0.5, 0.41, 0};
    const study::ReferenceOptions options = all_bounces();
    Settings settings = plain_settings();
    settings.bounces = kAutomatic;
    struct Case {
        float g;
        double degrees;
        bool hazy;
    };
    for (const Case& one : {Case{0.8f, 5, false}, Case{0.8f, 20, false}, Case{0.9f, 5, false},
                            Case{0.9f, 20, false}, Case{0.9f, 5, true}}) {
        const double angle = glm::radians(one.degrees);
        scene.media = slab_in_haze(one.g, one.hazy);
        scene.lights = {SunLight{{std::sin(angle), 0, std::cos(angle)}, glm::vec3(3)}};
        const double truth = mean(study::render_reference(scene, options).scattering);
        const double seen = mean(render(scene, settings).scattering);
        const std::string where = fmt::format("g {}, {} degrees from the sun{}", one.g, one.degrees,
                                              one.hazy ? ", in haze" : "");
        figure(where, seen / truth - 1);
        EXPECT_NEAR(seen / truth, 1, 0.04) << where;
    }
}

// A layer that glows, two nodes of the field thick and opaque: a floor under it has the light of a
// black body of its source. Above half of it the light falls off, which tells nothing of the floor.
TEST_F(Bounces, LightOfAThickLayerIsNotCarriedOnToTheFloor)
{
    constexpr double kHeight = 1.2, kDepth = 5, kSource = 2;
    Scene scene = empty_scene(24);
    scene.camera.position = {0.2, 0.3, 12};
    scene.camera.look_at = {0.2, 0.301, 0};
    scene.camera.vfov_deg = 10;
    BoxMedium layer;
    layer.min = {-3, -3, 0};
    layer.max = {3, 3, kHeight};
    layer.sigma_a = glm::vec3(static_cast<float>(kDepth / kHeight));
    layer.emission = layer.sigma_a * static_cast<float>(kSource);
    scene.media = {layer};
    scene.surfaces = {BoxSurface{{-3, -3, -0.5}, {3, 3, 0}, glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.bounces = 0;
    const Still still = render(scene, settings);
    const double seen = mean(still.surface_lit) / kSource - 1;
    figure("floor under a thick layer that glows: bias", seen);
    EXPECT_NEAR(seen, 0, 0.06);  // its upper face lies between nodes
}

// A ball beside a box that shines: its nodes lie on all sides of it and inside, and none of them is
// taken up or left out at once from one pixel to the next.
TEST_F(Bounces, LightOnABallHasNoEdges)
{
    constexpr double kEmission = 4, kRadius = 0.6;
    const glm::dvec3 kMin(-0.5, -2.6, -0.5), kMax(0.9, -1.2, 0.9);
    Scene scene = empty_scene(64);
    scene.camera.position = {-3, -2, 1.5};
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 14;
    BoxMedium fire;
    fire.min = kMin;
    fire.max = kMax;
    fire.sigma_a = glm::vec3(1e-3f);
    fire.emission = glm::vec3(kEmission);
    scene.media = {fire};
    scene.surfaces = {SphereSurface{{0, 0, 0}, kRadius, glm::vec3(1)}};
    Settings settings = plain_settings();
    settings.bounces = 0;
    const Still still = render(scene, settings);
    const auto of_ball = [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        const double along = -glm::dot(ray.origin, ray.direction);
        const double inside = kRadius * kRadius - glm::dot(ray.origin, ray.origin) + along * along;
        if (inside < 0.1 * kRadius * kRadius)
            return glm::dvec3(0);  // beside it, or at its rim
        const glm::dvec3 p = ray.origin + ray.direction * (along - std::sqrt(inside));
        constexpr int kCells = 12;
        const glm::dvec3 edge = (kMax - kMin) / double(kCells);
        double irradiance = 0;
        for (int i = 0; i < kCells * kCells * kCells; ++i) {
            const glm::dvec3 cell(i % kCells, i / kCells % kCells, i / (kCells * kCells));
            const glm::dvec3 way = kMin + (cell + 0.5) * edge - p;
            irradiance += kEmission * edge.x * edge.y * edge.z *
                          std::max(glm::dot(way, p) / kRadius, 0.0) /
                          std::pow(glm::dot(way, way), 1.5);
        }
        return glm::dvec3(irradiance / std::numbers::pi);
    };
    const Image truth = ideal(scene, of_ball);
    const auto at = [&](const std::vector<float>& rgb, int x, int y) {
        return static_cast<double>(rgb[static_cast<std::size_t>(3 * (y * still.width + x))]);
    };
    double jump = 0, true_jump = 0, mean_light = 0, error = 0;
    int count = 0;
    for (int y = 0; y + 1 < still.height; ++y)
        for (int x = 0; x + 1 < still.width; ++x) {
            const glm::ivec2 by[2] = {{1, 0}, {0, 1}};
            for (const glm::ivec2 d : by) {
                const double here = at(truth.pixels, x, y),
                             next = at(truth.pixels, x + d.x, y + d.y);
                if (here <= 0 || next <= 0)
                    continue;
                jump = std::max(jump, std::abs(at(still.surface_lit, x + d.x, y + d.y) -
                                               at(still.surface_lit, x, y)));
                true_jump = std::max(true_jump, std::abs(next - here));
                mean_light += here;
                error += at(still.surface_lit, x, y) - here;
                ++count;
            }
        }
    mean_light /= count;
    figure("ball beside a fire: largest step between pixels", jump / mean_light);
    figure("ball beside a fire: truth's", true_jump / mean_light);
    figure("ball beside a fire: bias", error / count / mean_light);
    // Few directions cast shadows of their own; a node taken up at once is 7 of the truth.
    EXPECT_LT(jump, 3 * true_jump);
    EXPECT_NEAR(error / count / mean_light, 0, 0.05);
}

// Haze and soot: what would not show is not worked out.
TEST_F(Bounces, AutoLeavesOutWhatWouldNotShow)
{
    struct Case {
        const char* name;
        float sigma_s, sigma_a;
        bool none;
    };
    for (const Case& c : {Case{"haze", 0.05f, 0, true}, Case{"soot", 0.3f, 9, true},
                          Case{"smoke", 4, 0.4f, false}}) {
        Scene scene = box_scene(c.sigma_s, c.sigma_a, 0, 0.1f);
        scene.lights = {SunLight{{0.5, -0.6, 0.6}, glm::vec3(3)}};
        const Still once = with_bounces(scene, plain_settings(), 0);
        const Still as_asked = with_bounces(scene, plain_settings(), Settings::kAutomatic);
        EXPECT_EQ(once.scattering == as_asked.scattering, c.none) << c.name;
    }
}

// S2's smoke, surfaces black, with up to 64 scatterings, made with Cycles; its noise after a mean
// of 4x4 pixels is a relMSE of 8e-5, its own error about 1 %.
TEST_F(Bounces, SmokeAgreesWithAPathTracer)
{
    const fs::path folder = fs::path(FUM_TEST_DATA).parent_path() / "tests/reference";
    const fs::path picture = folder / "S2_scattering_multiple.exr";
    if (!fs::exists(picture))
        GTEST_SKIP() << "no reference picture: " << picture << " is not there";
    asset::LoadedScene loaded{asset::parse_scene(folder / "S2.json"), {}};
    for (const Medium& medium : loaded.scene.media)
        if (const auto* grid = std::get_if<GridMedium>(&medium); grid && !fs::exists(grid->file))
            GTEST_SKIP() << "the reference's grid " << grid->file << " is not there";
    asset::load_scene_files(loaded);
    for (Surface& surface : loaded.scene.surfaces)
        std::visit([](auto& s) { s.albedo = glm::vec3(0); }, surface);
    const Image reference = write::read_exr(picture, {"R", "G", "B"});
    const auto means = [&](const std::vector<float>& full) {
        const std::size_t width = 480, rows = 268;
        std::vector<float> out(width / 4 * (rows / 4) * 3, 0.0f);
        for (std::size_t y = 0; y < rows; ++y)
            for (std::size_t x = 0; x < width * 3; ++x)
                out[(y / 4 * (width / 4) + x / 3 / 4) * 3 + x % 3] += full[y * width * 3 + x] / 16;
        return out;
    };
    Settings settings;
    settings.bounces = Settings::kAutomatic;
    const Still still = render(loaded.scene, settings, 16);
    const study::Metrics m = study::compare(means(still.scattering), means(reference.pixels));
    figure("S2 all bounces, relMSE", m.relmse);
    figure("S2 all bounces, bias", m.bias);
    // Aimed at: 5e-4. Reached: 8.9e-4, as in dense smoke the field's nodes lie an optical depth of
    // 2 apart; with 48 of them along the longest edge it is 6e-4.
    EXPECT_LT(m.relmse, 1.1e-3);
    EXPECT_LT(std::abs(m.bias), 0.015);
}

}  // namespace
}  // namespace fumarole::test
