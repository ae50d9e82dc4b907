#include "study/plan_facts.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <oneapi/tbb/parallel_for.h>

#include "light_fields.h"
#include "medium/media_set.h"
#include "scene_words.h"

namespace fumarole::study {

namespace {

/// Ways from each face of the bounds are on a lattice of so many times so many points.
constexpr int kWaysAcross = 24;

bool shines(const Light& light)
{
    return power_of(light) != glm::vec3(0);
}

/// Where light comes from at p: a unit vector, and metres.
std::pair<glm::dvec3, double> way_to(const Light& light, glm::dvec3 p)
{
    const LightPosition place = position_of(light);
    if (place.far)
        return {place.at, std::numeric_limits<double>::infinity()};
    const glm::dvec3 to = place.at - p;
    const double range = glm::length(to);
    return {range > 0 ? to / range : glm::dvec3(0, 0, 1), range};
}

std::vector<glm::dvec3> points_on_faces(const Bounds& box)
{
    std::vector<glm::dvec3> points;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {0.0, 1.0})
            for (int i = 0; i < kWaysAcross * kWaysAcross; ++i) {
                glm::dvec3 share;
                share[axis] = side;
                share[(axis + 1) % 3] = (i % kWaysAcross + 0.5) / kWaysAcross;
                share[(axis + 2) % 3] = (i / kWaysAcross + 0.5) / kWaysAcross;
                points.push_back(glm::mix(box.min, box.max, share));
            }
    return points;
}

}  // namespace

bool is_black(const World& world)
{
    return world.environment == nullptr ? world.radiance == glm::vec3(0)
                                        : world.environment_scale == 0;
}

double deepest_way(const Reference& reference, const Bounds& media,
                   const std::vector<Light>& lights)
{
    const std::vector<glm::dvec3> points = points_on_faces(media);
    const glm::dvec3 middle = (media.min + media.max) / 2.0;
    std::vector<double> deepest(points.size(), 0.0);
    oneapi::tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
        const auto look = [&](glm::dvec3 wi, double range) {
            const glm::dvec3 t = reference.transmittance(points[i], wi, range);
            const double least = std::max(std::min({t.x, t.y, t.z}), 1e-300);
            deepest[i] = std::max(deepest[i], -std::log(least));
        };
        for (const Light& light : lights)
            if (shines(light)) {
                const auto [wi, range] = way_to(light, points[i]);
                look(wi, range);
            }
        look(glm::normalize(middle - points[i]), std::numeric_limits<double>::infinity());
    });
    return *std::max_element(deepest.begin(), deepest.end());
}

std::vector<PlanFact> scene_facts(const Scene& scene, const medium::MediaTraits& media,
                                  double depth, const Settings& settings)
{
    std::vector<PlanFact> facts;
    const bool march = settings.mode == Settings::Mode::raymarch;
    const bool lit = std::any_of(scene.lights.begin(), scene.lights.end(), shines);
    if (media.colored_extinction)
        facts.push_back({words::kColoredExtinction});
    else if (march)
        facts.push_back({words::kGreyExtinction, std::pair("targets", "two")});
    else
        facts.push_back({"extinction: grey"});
    if (media.noise_grids > 0)
        facts.push_back({"noise: stands still: read from a grid, its octaves are not worked out",
                         std::pair("noise-grid", "off")});
    if (!media.emission)
        facts.push_back({words::kNoEmission});
    if (media.isotropic)
        facts.push_back({words::kIsotropic});
    if (is_black(scene.world))
        facts.push_back({words::kBlackWorld});
    if (scene.surfaces.empty())
        facts.push_back({words::kNoSurfaces});
    if (!lit) {
        facts.push_back({words::kNoLights});
        return facts;
    }
    if (media.heterogeneous == 0)
        facts.push_back({words::kHomogeneous});
    if (depth < kThin) {
        facts.push_back(
            {fmt::format("optical depth never above {:.2g}: shadows change nothing", depth)});
        if (!settings.volume_shadows)
            facts.back().without = std::pair("volume-shadows", "on");
    } else {
        facts.push_back({fmt::format("optical depth up to {:.2g}: media throw shadows", depth)});
    }
    if (media.marched > 0 && settings.volume_shadows && settings.shadow_volume_size != 0)
        facts.push_back(
            {fmt::format("{}: shadows out of a volume, one fetch for {} steps",
                         scene.lights.size() == 1 ? "one light"
                                                  : fmt::format("{} lights", scene.lights.size()),
                         settings.shadow_steps),
             std::pair("shadow-volume-size", "0")});
    return facts;
}

}  // namespace fumarole::study
