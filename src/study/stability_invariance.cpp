// Groups 10 and 11: what must not change the picture.

#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "study/stability_bench.h"

namespace fumarole::study {

namespace {

// -- 10: transforms ------------------------------------------------------------------------------

glm::dmat4 stretch(double x, double y, double z)
{
    return glm::scale(glm::dmat4(1), glm::dvec3(x, y, z));
}

glm::dmat4 turn()
{
    return glm::rotate(glm::dmat4(1), 0.6, glm::normalize(glm::dvec3(1, 2, 3)));
}

glm::dmat4 shear()
{
    glm::dmat4 map(1);
    map[1][0] = 0.4;
    map[2][1] = -0.3;
    return map;
}

struct Map {
    std::string_view name;
    glm::dmat4 (*map)();
};

constexpr std::array kMaps{
    Map{"straight", [] { return stretch(0.15, 0.15, 0.15); }},
    Map{"turned", [] { return turn() * stretch(0.15, 0.15, 0.15); }},
    Map{"sheared", [] { return shear() * stretch(0.15, 0.15, 0.15); }},
    Map{"mirrored", [] { return stretch(-0.15, 0.15, 0.15); }},
    Map{"stretched", [] { return stretch(0.3, 0.1, 0.05); }},
    Map{"all-at-once", [] { return turn() * shear() * stretch(0.12, -0.2, 0.1); }},
};

/// A grid without symmetry, against its own column along each ray, in double precision.
StabilityFigure placed_grid(const StabilityBench& bench, const Map& map)
{
    Scene scene = bare_scene(32);
    scene.camera.vfov_deg = 45;
    GridMedium smoke;
    const glm::dmat4 to_view = glm::translate(glm::dmat4(1), {0.1, -5, -0.1});
    const glm::dmat4 centre = glm::translate(glm::dmat4(1), glm::dvec3(-7.5));
    smoke.density = make_grid({2, 2, 2}, to_view * map.map() * centre, [](glm::ivec3 v) {
        const glm::dvec3 p = (glm::dvec3(v) - 7.5) / 8.0;
        const double fade = std::max(0.0, 1 - glm::dot(p, p));
        return fade * (1 + 0.5 * p.x + 0.3 * p.y * (p.z > 0.2 ? 2 : 1));
    });
    smoke.sigma_s_per_density = glm::vec3(0);
    smoke.sigma_a_per_density = {0.5f, 1.0f, 2.0f};
    scene.media = {smoke};
    const Picture truth = true_transmittance(scene);
    // At full size: a small layer's interpolation of it is not the transform's.
    const Still still = bench.render(scene, bench.full_size(), 0);
    return rms_over_mean(layer(still, &Still::transmittance), truth);
}

struct Place {
    std::string_view name, words;
    double unit;
    glm::dvec3 origin;
};

constexpr std::array kPlaces{
    Place{"origin-1e6", "1e6 m from the origin", 1, {1234567.89, -987654.321, 1e6 + 0.1}},
    Place{"millimetres", "in millimetres", 1e-3, {0, 0, 0}},
    Place{"kilometres", "in kilometres", 1e3, {0, 0, 0}},
};

StabilityFigure moved_scene(const StabilityBench& bench, const Place& place, bool surfaces)
{
    const Settings settings = bench.with("target-format", "rgba32f");  // it must not round it away
    const auto picture = [&](double unit, glm::dvec3 origin) {
        return layer(bench.render(full_scene(unit, origin, surfaces), settings, 0),
                     &Still::composite);
    };
    const Picture there = picture(place.unit, place.origin), here = picture(1, glm::dvec3(0));
    // A silhouette may cross the middle of a pixel, which a maximum sees and no eye.
    return surfaces ? mean_ratio(there, here) : worst_ratio(there, here);
}

// -- 11: layouts ---------------------------------------------------------------------------------

StabilityFigure dense_or_bricks(const StabilityBench& bench, const Scene& scene)
{
    const auto picture = [&](std::string_view layout) {
        return layer(bench.render(scene, bench.with("layout", layout), 0), &Still::composite);
    };
    return worst_ratio(picture("bricks"), picture("dense"));
}

/// Bricks of waves, one missing, one constant, on both sides of index 0.
Scene ragged_scene()
{
    Scene scene = bare_scene(32);
    GridMedium smoke;
    smoke.density =
        make_grid({3, 2, 3}, voxels(0.15, {0, -5, 0}),
                  [](glm::ivec3 v) {
                      const glm::ivec3 brick = v >> 3;
                      if (brick == glm::ivec3(0, 0, 0))
                          return 0.0;
                      if (brick == glm::ivec3(-1, 0, -1))
                          return 0.4;
                      return 0.5 + 0.5 * std::sin(1.9 * v.x + 2.3 * v.y) * std::sin(2.9 * v.z);
                  },
                  {-2, -1, -2});
    smoke.sigma_s_per_density = glm::vec3(0.6f);
    smoke.sigma_a_per_density = {0.1f, 0.3f, 0.9f};
    smoke.g = 0.3f;
    scene.media = {smoke};
    scene.lights = {SunLight{{0.7, 0.3, 0.6}, glm::vec3(3)}};
    scene.world.radiance = glm::vec3(0.2f);
    return scene;
}

/// Two bricks far apart with nothing between.
Scene hollow_scene()
{
    Scene scene = ragged_scene();
    auto& smoke = std::get<GridMedium>(scene.media[0]);
    auto grid = std::make_shared<VoxelGrid>(
        *make_grid({16, 1, 1}, voxels(0.03, {-1.9, -5, 0}), [](glm::ivec3) { return 1.0; }));
    grid->bricks = {{0, 0, 0}, {15, 0, 0}};
    grid->values.resize(std::size_t(2) * VoxelGrid::kBrickVoxels);
    grid->active_voxels = std::size_t(2) * VoxelGrid::kBrickVoxels;
    smoke.density = grid;
    smoke.sigma_a_per_density = {2, 6, 18};
    return scene;
}

/// A ramp over four bricks: any error at their borders is a step in it.
StabilityFigure ramp(const StabilityBench& bench, std::string_view layout)
{
    Scene scene = bare_scene(48);
    GridMedium smoke;
    smoke.density = make_grid({4, 1, 4}, voxels(0.1, {-1.55, -5, -1.55}),
                              [](glm::ivec3 v) { return (v.x + 1) / 32.0 + (v.z + 1) / 64.0; });
    smoke.sigma_s_per_density = glm::vec3(0);
    smoke.sigma_a_per_density = {0.2f, 0.5f, 1.0f};
    scene.camera.vfov_deg = 28;
    scene.media = {smoke};
    const Picture truth = true_transmittance(scene);
    Settings settings = bench.march_alone(256);
    find_setting("layout").set(settings, layout);
    return worst_difference(layer(bench.render(scene, settings, 0), &Still::transmittance), truth);
}

/// A constant tile, or the same as bricks.
StabilityFigure tiles(const StabilityBench& bench)
{
    Scene scene = ragged_scene();
    auto& smoke = std::get<GridMedium>(scene.media[0]);
    const auto filled = make_grid({2, 2, 2}, voxels(0.15, {-1.2, -6.2, -1.2}), [](glm::ivec3 v) {
        return v.x < 8 ? 0.5 : 0.5 + 0.05 * (v.y - 8);
    });
    smoke.density = filled;
    const Picture expected = layer(bench.render(scene), &Still::composite);
    auto tiled = std::make_shared<VoxelGrid>(*filled);
    tiled->bricks.clear();
    tiled->values.clear();
    for (std::size_t i = 0; i < filled->bricks.size(); ++i) {
        if (filled->bricks[i].x == 0)
            continue;
        tiled->bricks.push_back(filled->bricks[i]);
        const auto first =
            filled->values.begin() + static_cast<std::ptrdiff_t>(i * VoxelGrid::kBrickVoxels);
        tiled->values.insert(tiled->values.end(), first, first + VoxelGrid::kBrickVoxels);
    }
    tiled->tiles = {{{0, 0, 0}, {0, 1, 1}, glm::vec3(0.5f)}};
    smoke.density = tiled;
    StabilityFigure worst;
    for (const char* layout : {"dense", "bricks"})
        worst = worse(worst, worst_ratio(layer(bench.render(scene, bench.with("layout", layout), 0),
                                               &Still::composite),
                                         expected));
    return worst;
}

}  // namespace

void add_invariance_cases(std::vector<StabilityCase>& table)
{
    for (const Map& map : kMaps)
        table.push_back(
            {.group = 10,
             .name = fmt::format("grid-{}", map.name),
             .shows = fmt::format("rms error of T of a grid, {}, full size", map.name),
             .bound = kJustNoticed,
             .unit = "of the mean",
             .reason = std::string(kNoticeReason),
             .measure = [map](const StabilityBench& bench) { return placed_grid(bench, map); }});
    for (const bool surfaces : {false, true})
        for (const Place& place : kPlaces)
            table.push_back(
                {.group = 10,
                 .name = fmt::format("{}{}", place.name, surfaces ? "-surfaces" : ""),
                 .shows = fmt::format("{} of a lit scene {}",
                                      surfaces ? "change of the mean, with surfaces,"
                                               : "largest change of a pixel",
                                      place.words),
                 .bound = surfaces ? 1e-3 : kScreenStep,
                 .unit = surfaces ? "of the mean" : "of the pixel",
                 .reason = surfaces ? "a thousandth: silhouettes cross the middles of a few pixels"
                                    : std::string(kScreenReason),
                 .measure = [=](const StabilityBench& bench) {
                     return moved_scene(bench, place, surfaces);
                 }});

    const std::string rounding =
        "4 * 2^-11: T and scattering are stored in 16 bits and added, for each of both pictures";
    const auto add = [&](std::string name, std::string shows, double bound, std::string unit,
                         std::string reason, decltype(StabilityCase::measure) measure) {
        table.push_back({.group = 11,
                         .name = std::move(name),
                         .shows = std::move(shows),
                         .bound = bound,
                         .unit = std::move(unit),
                         .reason = std::move(reason),
                         .measure = std::move(measure)});
    };
    add("dense-or-bricks", "largest change of a pixel, ragged bricks of waves", 4 * kHalfFloat,
        "of the pixel", rounding,
        [](const StabilityBench& bench) { return dense_or_bricks(bench, ragged_scene()); });
    add("empty-space", "the same, two bricks far apart", 4 * kHalfFloat, "of the pixel", rounding,
        [](const StabilityBench& bench) { return dense_or_bricks(bench, hollow_scene()); });
    add("tiles", "the same, a constant tile instead of bricks", 4 * kHalfFloat, "of the pixel",
        rounding, tiles);
    for (const char* layout : {"dense", "bricks"})
        add(fmt::format("ramp-{}", layout),
            fmt::format("largest error of T of a ramp over four bricks, {}", layout), kScreenStep,
            "of T", std::string(kScreenReason),
            [layout](const StabilityBench& bench) { return ramp(bench, layout); });
}

}  // namespace fumarole::study
