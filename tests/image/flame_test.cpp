// Flames that are small beside what they light: how much of their light arrives, by how far it has
// gone.

#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <numbers>
#include <optional>

#include "blackbody.h"
#include "image_test.h"
#include "study/metrics.h"
#include "study/reference_blackbody.h"
#include <fumarole/asset/scene_file.h>

namespace fumarole::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A picture's pixels by how far they see past a flame, or lie from it: each ring ends where the
/// next begins.
struct Rings {
    double unit = 1;  ///< metres: a node of the lattice that light would be carried through
    struct Ring {
        double begin = 0, end = 0;  ///< in units
        std::vector<float> seen, truth;
    };
    std::vector<Ring> rings{{0, 0.5, {}, {}}, {0.5, 1, {}, {}}, {1, 2, {}, {}},
                            {2, 4, {}, {}},   {4, 8, {}, {}},   {8, 16, {}, {}}};

    void add(double metres, glm::vec3 seen, glm::dvec3 truth)
    {
        for (Ring& ring : rings)
            if (metres >= ring.begin * unit && metres < ring.end * unit)
                for (int c = 0; c < 3; ++c) {
                    ring.seen.push_back(seen[c]);
                    ring.truth.push_back(static_cast<float>(truth[c]));
                }
    }
};

class Flames : public ImageTest {
protected:
    static constexpr double kHalf = 5;               ///< of the haze's edges [m]
    static constexpr double kNode = 2 * kHalf / 31;  ///< of its lattice [m]
    static constexpr float kHaze = 0.02f;            ///< sigma_s [1/m]

    static BoxMedium haze(float g)
    {
        BoxMedium box;
        box.min = glm::dvec3(-kHalf);
        box.max = glm::dvec3(kHalf);
        box.sigma_s = glm::vec3(kHaze);
        box.g = g;
        return box;
    }
    /// As bright in all, however large it is: some 0.4 W/sr.
    static BoxMedium flame(glm::dvec3 middle, glm::dvec3 edges)
    {
        BoxMedium box;
        box.min = middle - 0.5 * edges;
        box.max = middle + 0.5 * edges;
        box.sigma_a = glm::vec3(1e-3f);
        box.emission = glm::vec3(glm::dvec3(1, 0.5, 0.25) * (0.4 / (edges.x * edges.y * edges.z)));
        return box;
    }
    static glm::dvec3 middle_of(const BoxMedium& box) { return 0.5 * (box.min + box.max); }
    /// f(middle, m^3) of the cells of a box, as many along each edge.
    template <class F> static void for_cells(const BoxMedium& box, int count, const F& f)
    {
        const glm::dvec3 edge = (box.max - box.min) / double(count);
        for (int i = 0; i < count * count * count; ++i)
            f(box.min +
                  (glm::dvec3(i % count, i / count % count, i / (count * count)) + 0.5) * edge,
              edge.x * edge.y * edge.z);
    }
    /// What haze scatters of a flame, along a ray: over the ray by the angle that each cell of the
    /// flame sees it under, in which 1 / d^2 is even. Within a cell's own ball there is as much as
    /// in its rim.
    static glm::dvec3 scattered(const PixelRay& ray, const BoxMedium& haze, const BoxMedium& flame,
                                int cells)
    {
        constexpr int kAngles = 96;
        const Segment inside = box_segment(ray, haze.min, haze.max);
        const double sigma = static_cast<double>(haze.sigma_s.r);
        double sum = 0;
        for_cells(flame, cells, [&](glm::dvec3 at, double size) {
            const double ball = std::cbrt(3 * size / (4 * kPi));
            const double middle = glm::dot(at - ray.origin, ray.direction);
            const double beside =
                std::max(glm::length(ray.origin + ray.direction * middle - at), 0.5 * ball);
            const double begin = std::atan((inside.begin - middle) / beside),
                         end = std::atan((inside.end - middle) / beside);
            for (int k = 0; k < kAngles; ++k) {
                const double angle = begin + (end - begin) * (k + 0.5) / kAngles;
                const double t = middle + beside * std::tan(angle);
                const glm::dvec3 way = ray.origin + ray.direction * t - at;
                const double range = std::max(glm::length(way), 1e-9);
                const double ds = (end - begin) / kAngles * beside / std::pow(std::cos(angle), 2);
                const double arrives = range < ball ? 3 / (ball * ball) : 1 / (range * range);
                sum += ds * sigma * size * arrives * std::exp(-sigma * (t - inside.begin + range)) *
                       henyey_greenstein(-glm::dot(way, ray.direction) / range, double(haze.g));
            }
        });
        return sum * glm::dvec3(flame.emission);
    }
    void expect(const Rings& rings, const std::string& name, double bias, double relmse)
    {
        for (const Rings::Ring& ring : rings.rings) {
            constexpr std::size_t kFewPixels = 8;
            if (ring.seen.size() < 3 * kFewPixels)
                continue;
            const study::Metrics m = study::compare(ring.seen, ring.truth);
            const std::string where = fmt::format("{}, {:.2f} to {:.2f} m", name,
                                                  ring.begin * rings.unit, ring.end * rings.unit);
            figure(where + ": relMSE", m.relmse);
            figure(where + ": bias", m.bias);
            EXPECT_LT(std::abs(m.bias), bias) << where;
            EXPECT_LT(m.relmse, relmse) << where;
        }
    }
};

// A flame smaller than a node of the haze's lattice, one of two nodes, and one that is longer than
// it is thick. What it sends is seen beside it as far as there is haze, without rays along some
// directions.
TEST_F(Flames, LightHazeAsFarAsItIsSeen)
{
    struct Case {
        const char* name;
        glm::dvec3 edges;
        float g;
        double bias, relmse;  ///< measured: TODO
    };
    for (const Case& c : {Case{"0.2 m", glm::dvec3(0.2), 0, 0.05, 2e-2},
                          Case{"0.2 m, g 0.6", glm::dvec3(0.2), 0.6f, 0.05, 2e-2},
                          Case{"0.7 m", glm::dvec3(0.7), 0, 0.05, 2e-2},
                          Case{"1.5 m", glm::dvec3(1.5), 0, 0.05, 2e-2},
                          Case{"0.2 x 0.2 x 0.7 m", {0.2, 0.2, 0.7}, 0.3f, 0.05, 4e-2}})
        for (const double vfov : {4.0, 20.0}) {
            Scene scene = empty_scene(24);
            scene.camera.position = {0, -14, 0};
            scene.camera.look_at = {0.13, 0, 0.05};
            scene.camera.vfov_deg = vfov;
            const BoxMedium fire = flame({0.13, 0.07, 0.05}, c.edges);
            BoxMedium air = haze(c.g);
            scene.media = {air, fire};
            Settings settings;
            settings.bounces = 0;
            settings.resolution = 1;
            const Still lit = render(scene, settings, 16);
            std::swap(air.sigma_s, air.sigma_a);
            scene.media = {air, fire};
            const Still alone = render(scene, settings, 16);
            const glm::dvec3 middle = middle_of(fire);
            Rings rings{kNode};
            for (int y = 0; y < lit.height; ++y)
                for (int x = 0; x < lit.width; ++x) {
                    const PixelRay ray = ray_of(scene, x, y);
                    const double t = glm::dot(middle - ray.origin, ray.direction);
                    const auto i = static_cast<std::size_t>(3 * (y * lit.width + x));
                    const auto at = [&](const std::vector<float>& rgb) {
                        return glm::vec3(rgb[i], rgb[i + 1], rgb[i + 2]);
                    };
                    rings.add(glm::length(ray.origin + ray.direction * t - middle),
                              at(lit.scattering) - at(alone.scattering),
                              scattered(ray, haze(c.g), fire, c.edges.x > 0.5 ? 6 : 4));
                }
            expect(rings, fmt::format("flame of {}, {} degrees", c.name, vfov), c.bias, c.relmse);
        }
}

// The floor under one, in haze and in clear air, where there is no other medium and the lattice
// ends near the flame.
TEST_F(Flames, LightTheFloorUnderThem)
{
    struct Case {
        const char* name;
        glm::dvec3 edges;
        double height;
        bool hazy;
        double bias, relmse;
    };
    for (const Case& c : {Case{"0.2 m in haze", glm::dvec3(0.2), 0.3, true, 0.06, 5e-3},
                          Case{"1 m in haze", glm::dvec3(1), 1, true, 0.06, 5e-3},
                          Case{"0.2 x 0.2 x 0.8 m in haze", {0.2, 0.2, 0.8}, 0.6, true, 0.06, 5e-3},
                          Case{"0.2 m", glm::dvec3(0.2), 0.3, false, 0.06, 5e-3},
                          Case{"1 m", glm::dvec3(1), 0.9, false, 0.06, 5e-3}})
        for (const double vfov : {6.0, 30.0}) {
            Scene scene = empty_scene(24);
            const BoxMedium fire = flame({0.13, 0.07, c.height}, c.edges);
            scene.camera.position = {0.13, 0.07, 12};
            scene.camera.look_at = {0.13, 0.071, 0};
            scene.camera.vfov_deg = vfov;
            if (c.hazy) {
                BoxMedium air = haze(0);
                air.min.z = 0;
                scene.media = {air};
            }
            scene.media.emplace_back(fire);
            scene.surfaces = {BoxSurface{{-20, -20, -1}, {20, 20, 0}, glm::vec3(1)}};
            Settings settings;
            settings.bounces = 0;
            const Still still = render(scene, settings);
            const double sigma = c.hazy ? static_cast<double>(kHaze) : 0;
            Rings rings{kNode};
            for (int y = 0; y < still.height; ++y)
                for (int x = 0; x < still.width; ++x) {
                    const PixelRay ray = ray_of(scene, x, y);
                    const glm::dvec3 p =
                        ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
                    double sum = 0;
                    for_cells(fire, 8, [&](glm::dvec3 at, double size) {
                        const double range = glm::length(at - p);
                        sum += size * at.z / std::pow(range, 3) * std::exp(-sigma * range);
                    });
                    const auto i = static_cast<std::size_t>(3 * (y * still.width + x));
                    rings.add(
                        glm::length(glm::dvec2(p) - glm::dvec2(middle_of(fire))),
                        {still.surface_lit[i], still.surface_lit[i + 1], still.surface_lit[i + 2]},
                        sum / kPi * glm::dvec3(fire.emission));
                }
            expect(rings, fmt::format("floor under a flame of {}, {} degrees", c.name, vfov),
                   c.bias, c.relmse);
        }
}

/// A flame of a grid, of several bricks, brighter below, in smoke as dense as that or none.
GridMedium torch(double density, bool hot)
{
    const glm::dmat4 place = study::voxels(0.02, {-0.16, -0.16, 0.7});
    const auto value = [](glm::ivec3 at) {
        const double r = glm::length(glm::dvec2(at) - 15.5) / 12, z = at.z / 31.0;
        return r < 1 ? (1 - r * r) * (1 - 0.7 * z) : 0.0;
    };
    GridMedium medium;
    const glm::ivec3 bricks(4);
    if (density > 0) {
        medium.density = make_grid(bricks, place, [&](glm::ivec3 at) { return value(at); });
        medium.sigma_a_per_density = glm::vec3(static_cast<float>(density));
        medium.sigma_s_per_density = glm::vec3(1e-4f);
    }
    if (hot) {
        medium.temperature =
            make_grid(bricks, place, [&](glm::ivec3 at) { return 2000 * value(at); });
        medium.temperature_scale = 1;
    } else {
        medium.emission = make_grid(bricks, place, value);
        medium.emission_per_unit = {30, 9, 2};
    }
    return medium;
}

// Flames of grids, of blackbodies too: as the sum over their voxels has it, through their own
// smoke.
TEST_F(Flames, OfGridsLightAFloor)
{
    struct Case {
        const char* name;
        double density;  ///< absorption at the most [1/m]
        bool hot;
        double bias;
    };
    for (const Case& c :
         {Case{"flame", 0, false, 0.03}, Case{"blackbody", 0, true, 0.03},
          Case{"flame in thin soot", 1.5, false, 0.03}, Case{"flame in soot", 8, false, 0.15}}) {
        Scene scene = empty_scene(16);
        scene.camera.position = {0.4, 0.3, 9};
        scene.camera.look_at = {0.4, 0.301, 0};
        scene.camera.vfov_deg = 20;
        const GridMedium medium = torch(c.density, c.hot);
        BoxMedium air = haze(0);
        air.min.z = 0;
        scene.media = {air, medium};
        scene.surfaces = {BoxSurface{{-20, -20, -1}, {20, 20, 0}, glm::vec3(1)}};
        Settings settings;
        settings.bounces = 0;
        const Still still = render(scene, settings);
        const VoxelGrid& grid = c.hot ? *medium.temperature : *medium.emission;
        const VoxelLookup glow(grid);
        std::optional<VoxelLookup> smoke;
        if (medium.density)
            smoke.emplace(*medium.density);
        const glm::dmat4 index_from_world = glm::inverse(grid.world_from_index);
        const auto radiance = [&](glm::dvec3 at) {
            const double value = glow.sample(at).x;
            if (!c.hot)
                return value * glm::dvec3(medium.emission_per_unit);
            return blackbody_luminance(value) * study::blackbody_color(value);
        };
        double seen = 0, truth = 0;
        for (int y = 0; y < still.height; y += 3)
            for (int x = 0; x < still.width; x += 3) {
                const PixelRay ray = ray_of(scene, x, y);
                const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
                glm::dvec3 sum(0);
                for (int i = 0; i < 32 * 32 * 32; ++i) {
                    const glm::ivec3 at(i % 32, i / 32 % 32, i / 1024);
                    const glm::dvec3 sent = radiance(at);
                    if (sent == glm::dvec3(0))
                        continue;
                    const glm::dvec3 q(grid.world_from_index * glm::dvec4(glm::dvec3(at), 1));
                    const double range = glm::length(q - p);
                    double tau = static_cast<double>(kHaze) * range;
                    if (smoke)
                        tau += c.density * grid_column(*smoke, index_from_world, q, (p - q) / range,
                                                       {0, 0.5}, 2);
                    sum += sent * std::pow(0.02, 3) * q.z / std::pow(range, 3) * std::exp(-tau);
                }
                truth += sum.r / kPi;
                seen += static_cast<double>(
                    still.surface_lit[static_cast<std::size_t>(3 * (y * still.width + x))]);
            }
        figure(fmt::format("floor under a {} of a grid: bias", c.name), seen / truth - 1);
        EXPECT_NEAR(seen / truth, 1, c.bias) << c.name;
    }
}

/// A fire as large as a man, of a grid, in as much soot: tongues of flame, and soot around and
/// between them.
GridMedium large_fire()
{
    const glm::dmat4 place = study::voxels(0.1, {-0.75, -0.75, 0.35});
    const auto at_height = [](glm::ivec3 at) {
        const double z = at.z / 31.0, r = glm::length(glm::dvec2(at) - 7.5) / 8;
        const double wave = 0.5 + 0.5 * std::sin(1.3 * at.x + 0.4 * at.z) * std::cos(1.1 * at.y);
        return glm::dvec3(r, z, wave);
    };
    GridMedium medium;
    const glm::ivec3 bricks(2, 2, 4);
    medium.emission = make_grid(bricks, place, [&](glm::ivec3 at) {
        const glm::dvec3 q = at_height(at);
        return std::max(0.0, (1 - q.x / (0.9 - 0.7 * q.y)) * q.z);
    });
    medium.density = make_grid(bricks, place, [&](glm::ivec3 at) {
        const glm::dvec3 q = at_height(at);
        return std::max(0.0, (1 - q.x) * (0.3 + q.y) * (1.2 - q.z));
    });
    medium.emission_per_unit = {9, 2.7f, 0.54f};
    medium.sigma_s_per_density = {2, 2.1f, 2.2f};
    medium.sigma_a_per_density = {3, 3.2f, 3.4f};
    return medium;
}

/// Irradiance of a floor at z 0 by a grid's own light: the sum over its voxels, each through the
/// grid's extinction and a haze that does not scatter.
glm::dvec3 floor_under(const GridMedium& medium, const BoxMedium& haze, glm::dvec3 p)
{
    const VoxelGrid &flame = *medium.emission, &soot = *medium.density;
    const VoxelLookup glow(flame), smoke(soot);
    const glm::dmat4 soot_from_world = glm::inverse(soot.world_from_index);
    const glm::dvec3 sigma_t(medium.sigma_s_per_density + medium.sigma_a_per_density);
    const double size = std::abs(glm::determinant(glm::dmat3(flame.world_from_index)));
    const double voxel = std::cbrt(std::abs(glm::determinant(glm::dmat3(soot.world_from_index))));
    glm::dvec3 low(soot.world_from_index * glm::dvec4(soot.index_min - 1, 1)),
        high(soot.world_from_index * glm::dvec4(soot.index_max + 1, 1));
    glm::dvec3 sum(0);
    for (int z = flame.index_min.z; z <= flame.index_max.z; ++z)
        for (int y = flame.index_min.y; y <= flame.index_max.y; ++y)
            for (int x = flame.index_min.x; x <= flame.index_max.x; ++x) {
                const double value = glow.sample({x, y, z}).x;
                if (value == 0)
                    continue;
                const glm::dvec3 q(flame.world_from_index * glm::dvec4(x, y, z, 1));
                const double range = glm::length(p - q);
                const PixelRay way{q, (p - q) / range};
                Segment in_soot = box_segment(way, low, high);
                in_soot.end = std::min(in_soot.end, range);
                const int panels = 1 + static_cast<int>(in_soot.length() / (3 * voxel));
                const double column =
                    grid_column(smoke, soot_from_world, q, way.direction, in_soot, panels);
                Segment in_haze = box_segment(way, haze.min, haze.max);
                in_haze.end = std::min(in_haze.end, range);
                const double metres = std::max(in_haze.length(), 0.0);
                sum += value * size * q.z / std::pow(range, 3) *
                       glm::exp(-sigma_t * column - glm::dvec3(haze.sigma_a) * metres);
            }
    return sum * glm::dvec3(medium.emission_per_unit);
}

// A fire too large and thick to be a light of its own: the floor under it and far from it has what
// the sum over its voxels says.
TEST_F(Flames, LargeInSootLightAFloor)
{
    struct Fire {
        std::string name;
        GridMedium medium;
        BoxMedium haze;
    };
    BoxMedium haze;
    haze.min = {-5, -5, 0};
    haze.max = {5, 5, 6};
    std::vector<Fire> fires{{"a large fire", large_fire(), haze}};
    haze.sigma_a = {0.1f, 0.15f, 0.2f};
    fires.push_back({"a large fire in haze", large_fire(), haze});
    haze.sigma_a = glm::vec3(0);
    if (std::getenv("FUM_TEST_FIGURES") != nullptr) {
        const Scene sample =
            asset::load_scene(std::string(FUM_TEST_DATA) + "/fire_plume.json").scene;
        fires.push_back({"the sample's", std::get<GridMedium>(sample.media.front()), haze});
    }
    for (const auto& [name, medium, around] : fires) {
        Rings rings{1};
        for (Rings::Ring& ring : rings.rings)
            ring.end *= 2, ring.begin *= 2;
        for (const double vfov : {14.0, 50.0, 110.0}) {
            Scene scene = empty_scene(48);
            scene.camera.position = {0.05, 0.03, 14};
            scene.camera.look_at = {0.05, 0.031, 0};
            scene.camera.vfov_deg = vfov;
            scene.media = {medium};
            if (around.sigma_a != glm::vec3(0))
                scene.media.emplace_back(around);
            scene.surfaces = {BoxSurface{{-80, -80, -1}, {80, 80, 0}, glm::vec3(1)}};
            Settings settings;
            settings.bounces = 0;
            const Still still = render(scene, settings);
            for (int y = 2; y < still.height; y += 7)
                for (int x = 2; x < still.width; x += 7) {
                    const PixelRay ray = ray_of(scene, x, y);
                    const glm::dvec3 p =
                        ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
                    const auto i = static_cast<std::size_t>(3 * (y * still.width + x));
                    rings.add(
                        glm::length(glm::dvec2(p)),
                        {still.surface_lit[i], still.surface_lit[i + 1], still.surface_lit[i + 2]},
                        floor_under(medium, around, p) / kPi);
                }
        }
        for (const Rings::Ring& ring : rings.rings) {
            double least = 1e9, most = 0;
            for (std::size_t i = 0; i < ring.seen.size(); ++i) {
                const double ratio = double(ring.seen[i]) / double(ring.truth[i]);
                least = std::min(least, ratio);
                most = std::max(most, ratio);
            }
            figure(fmt::format("floor under {}, {} to {} m: least", name, ring.begin, ring.end),
                   least);
            figure(fmt::format("floor under {}, {} to {} m: most", name, ring.begin, ring.end),
                   most);
        }
        expect(rings, "floor under " + name, 0.05, 5e-3);
    }
}

// What stands beside a large fire throws a shadow, and has light on the side that faces it alone.
TEST_F(Flames, LargeAreHiddenByAWall)
{
    Scene scene = empty_scene(32);
    scene.camera.position = {3.5, 0, 30};
    scene.camera.look_at = {3.5, 0.001, 0};
    scene.camera.vfov_deg = 9;
    scene.media = {large_fire()};
    scene.surfaces = {BoxSurface{{-20, -20, -1}, {20, 20, 0}, glm::vec3(1)}};
    Settings settings;
    settings.bounces = 0;
    const auto row = [&] { return render(scene, settings).surface_lit; };
    const std::vector<float> open = row();
    scene.surfaces.emplace_back(BoxSurface{{2.6, -8, 0}, {3.2, 8, 5}, glm::vec3(0)});
    const std::vector<float> walled = row();
    for (int x = 0; x < 32; ++x) {
        const PixelRay ray = ray_of(scene, x, 16);
        const glm::dvec3 p = ray.origin - ray.direction * (ray.origin.z / ray.direction.z);
        const auto i = static_cast<std::size_t>(3 * (16 * 32 + x));
        const double left = double(walled[i]) / double(open[i]);
        // Beside the wall nodes, 0.3 m apart, have parts of its shadow.
        if (p.x < 2.2) {
            EXPECT_NEAR(left, 1, 0.02) << p.x;
        }
        if (p.x > 4.5) {
            EXPECT_LT(left, 0.01) << p.x;
        }
    }
}

// A log that a flame burns around would hide a light in its middle: haze is lit as what is carried
// lights it, and not dark.
TEST_F(Flames, AreNoLightsInsideOfALog)
{
    Scene scene = empty_scene(16);
    scene.camera.position = {3, -14, 1};
    scene.camera.look_at = {3, 0, 1};
    scene.camera.vfov_deg = 10;
    scene.media = {haze(0), flame({0, 0, 0}, glm::dvec3(1.5))};
    Settings settings;
    settings.bounces = 0;
    const auto light = [&] {
        double sum = 0;
        for (const float v : render(scene, settings).scattering)
            sum += static_cast<double>(v);
        return sum;
    };
    const double open = light();
    scene.surfaces = {SphereSurface{{0, 0, 0}, 0.15, glm::vec3(0.1f)}};
    const double around = light();
    figure("haze around a flame with a log in it, of that without", around / open);
    // 26 directions have more of it in some places, and less in others.
    EXPECT_GT(around / open, 0.5);
    EXPECT_LT(around / open, 2);
}

}  // namespace
}  // namespace fumarole::test
