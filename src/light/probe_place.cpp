#include "light/probe_place.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

#include "ray_range.h"

namespace fumarole::light {

namespace {

constexpr int kDirections = 64;   ///< number of directions that a glossy surface looks in
constexpr double kUnseen = 0.01;  ///< share of a white picture that nobody sees

const std::optional<Gloss>& gloss_of(const Surface& surface)
{
    return std::visit([](const auto& one) -> const std::optional<Gloss>& { return one.gloss; },
                      surface);
}

double mean_albedo_of(const Surface& surface)
{
    const glm::dvec3 albedo =
        std::visit([](const auto& one) { return glm::dvec3(one.albedo); }, surface);
    return (albedo.r + albedo.g + albedo.b) / 3;
}

/// A surface that reflects what lies around it.
struct Mirror {
    int surface = 0;
    glm::dvec3 place{0};  ///< place that it looks from, metres
    double reflects = 0;  ///< share of a white picture that it reflects, by direction
    double seen = 0;      ///< the part of it that surfaces and media send
    double alpha = 0;     ///< GGX's
    [[nodiscard]] double gain() const { return reflects * seen; }
};

/// What stands around: media, and surfaces that are no grounds.
Bounds neighborhood(const Scene& scene, const SurfaceRays& rays, const Bounds& media)
{
    constexpr double kDetail = 4;  // diagonals of the smallest
    double least = media.empty() ? std::numeric_limits<double>::infinity() : media.diagonal();
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        if (const Bounds& one = rays.bounds_of(static_cast<int>(i));
            gloss_of(scene.surfaces[i]) && !one.empty())
            least = std::min(least, one.diagonal());
    Bounds around;
    const auto add = [&](const Bounds& one) {
        if (!one.empty() && one.diagonal() <= kDetail * least)
            around.add(one);
    };
    add(media);
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        add(rays.bounds_of(static_cast<int>(i)));
    return around;
}

Mirror look_around(const Scene& scene, int surface, const SurfaceRays& rays, glm::dvec3 middle,
                   const Bounds& media, double opacity)
{
    const Surface& own = scene.surfaces[static_cast<std::size_t>(surface)];
    const Gloss& gloss = *gloss_of(own);
    const double metallic = static_cast<double>(gloss.metallic);
    // A dielectric reflects 0.04 straight on and 0.06 over all slants of a ball.
    constexpr double kDielectric = 0.06;
    Mirror mirror;
    mirror.surface = surface;
    mirror.alpha = static_cast<double>(gloss.roughness * gloss.roughness);
    // The widest lobe is a cosine's, all but, which irradiance stands for.
    mirror.reflects = (1 - mirror.alpha) * std::lerp(kDielectric, mean_albedo_of(own), metallic);
    const Bounds& bounds = rays.bounds_of(surface);
    const auto* sphere = std::get_if<SphereSurface>(&own);
    mirror.place = sphere != nullptr ? sphere->center : glm::clamp(middle, bounds.min, bounds.max);
    const glm::dvec3 outward = sphere != nullptr ? glm::dvec3(0) : middle - mirror.place;
    std::vector<bool> itself(scene.surfaces.size());
    itself[static_cast<std::size_t>(surface)] = !std::holds_alternative<MeshSurface>(own);
    int all = 0;
    for (const glm::dvec3& wi : even_directions(kDirections)) {
        if (glm::dot(wi, outward) < 0)
            continue;
        ++all;
        if (rays.first(mirror.place, wi, itself)) {
            mirror.seen += 1;
        } else if (!media.empty()) {
            const glm::dvec2 range = ray_range(mirror.place, wi, media);
            mirror.seen += range.x < range.y && range.y > 0 ? opacity : 0;
        }
    }
    mirror.seen /= std::max(all, 1);
    return mirror;
}

/// The largest extinction that media may have at a place [1/m].
double most_extinction(const medium::MediaSet& media, glm::dvec3 p)
{
    double sum = 0;
    for (const medium::Occupied& one : media.occupied()) {
        const glm::dvec3 q(glm::inverse(one.world_from_box) * glm::dvec4(p, 1));
        for (const medium::OccupiedBox& box : one.boxes)
            if (glm::all(glm::greaterThanEqual(q, box.bounds.min)) &&
                glm::all(glm::lessThanEqual(q, box.bounds.max)))
                sum += static_cast<double>(box.most);
    }
    return sum;
}

/// Where nothing is in the way, as near to `wanted` as it goes, and media are about as thick as
/// where the mirrors are: in smoke it would see none of what they see, and out of their fog more.
/// @param extinction there [1/m] @param scale metres, of what is around
std::optional<glm::dvec3> free_place(const medium::MediaSet& media, const SurfaceRays& rays,
                                     glm::dvec3 wanted, double extinction, double scale)
{
    constexpr int kShells = 24, kOnShell = 48;
    constexpr double kClear = 0.02;  // of the scale, to a surface
    constexpr double kThin = 0.1;    // optical depth over the scale, that it is off by
    std::optional<glm::dvec3> thinnest;
    double least = std::numeric_limits<double>::infinity();
    for (int shell = 0; shell <= kShells; ++shell) {
        const double radius = scale * shell / kShells;
        for (const glm::dvec3& way : even_directions(shell == 0 ? 1 : kOnShell)) {
            const glm::dvec3 p = wanted + radius * way;
            const double depth = scale * std::abs(most_extinction(media, p) - extinction);
            if (depth >= least || rays.is_near(p, kClear * scale))
                continue;
            // On the other side of a wall it would see another room.
            if (shell > 0 && !rays.is_near(wanted, 0)) {
                const auto hit = rays.first(wanted, way);
                if (hit && hit->range < radius)
                    continue;
            }
            thinnest = p;
            least = depth;
            if (depth <= kThin)
                return thinnest;
        }
    }
    return thinnest;
}

/// The faces of a box that stands for what a probe sees: the middle of where ways along an axis
/// end, from places around it, and the end of all surfaces where half of them meet nothing.
void set_parallax(LightProbe& probe, const SurfaceRays& rays, const std::vector<Surface>& surfaces)
{
    constexpr int kAcross = 5;
    constexpr double kAround = 0.15;  // of the radius
    const std::vector<bool> left_out = unseen_by(probe, surfaces);
    Bounds all;
    for (std::size_t i = 0; i < surfaces.size(); ++i)
        all.add(rays.bounds_of(static_cast<int>(i)));
    all.add(probe.position + 1e-3 * probe.radius);
    all.add(probe.position - 1e-3 * probe.radius);
    bool met = false;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        glm::dvec3 way(0);
        way[axis] = face % 2 == 0 ? -1 : 1;
        std::vector<double> ends;
        std::size_t count = 0;
        for (int i = 0; i < kAcross * kAcross; ++i) {
            glm::dvec3 from = probe.position;
            const double step = 2 * kAround * probe.radius / (kAcross - 1);
            from[(axis + 1) % 3] += step * (i % kAcross - kAcross / 2);
            from[(axis + 2) % 3] += step * (i / kAcross - kAcross / 2);
            if (rays.is_near(from, 0, left_out))
                continue;
            ++count;
            if (const auto hit = rays.first(from, way, left_out))
                ends.push_back(hit->range);
        }
        double& end = (face % 2 == 0 ? probe.parallax_min : probe.parallax_max)[axis];
        end = (face % 2 == 0 ? all.min : all.max)[axis];
        if (ends.empty() || 2 * ends.size() < count)
            continue;
        const auto middle = ends.begin() + static_cast<std::ptrdiff_t>(ends.size() / 2);
        std::nth_element(ends.begin(), middle, ends.end());
        end = probe.position[axis] + way[axis] * *middle;
        met = true;
    }
    probe.parallax = met ? LightProbe::Parallax::box : LightProbe::Parallax::none;
}

/// Texels of a probe's pictures for what is as smooth as that: a texel of the map is a right angle
/// over the size; a lobe is some 3 alpha wide.
int size_for(double alpha)
{
    return alpha < 0.05 ? 128 : 64;
}

std::string words_of(const LightProbe& probe)
{
    return fmt::format("at ({:.3g}, {:.3g}, {:.3g}) m, {} pixels a face, {}", probe.position.x,
                       probe.position.y, probe.position.z, probe.size,
                       probe.parallax == LightProbe::Parallax::box ? "on a box"
                                                                   : "what it sees is far");
}

/// Probes that are given a ball of their own: each takes as long to capture as one for all.
constexpr std::size_t kMostInBalls = 4;

std::vector<bool> alone(const Scene& scene, int surface)
{
    std::vector<bool> out(scene.surfaces.size());
    out[static_cast<std::size_t>(surface)] = true;
    return out;
}

/// Whether the surface is a ball in the middle of which a probe sees what the ball does: nothing
/// else stands there, and no smoke is in it that would be between.
bool is_free_inside(const Scene& scene, const Mirror& mirror, const SurfaceRays& rays,
                    const medium::MediaSet& media)
{
    constexpr double kThin = 0.1;  // optical depth to the ball's face
    const auto* ball =
        std::get_if<SphereSurface>(&scene.surfaces[static_cast<std::size_t>(mirror.surface)]);
    return ball != nullptr && most_extinction(media, ball->center) * ball->radius <= kThin &&
           !rays.is_near(ball->center, 0, alone(scene, mirror.surface));
}

/// A probe in a ball is nobody else's: beyond its face it ends.
LightProbe probe_in_ball(const Scene& scene, const Mirror& mirror, const SurfaceRays& rays)
{
    constexpr double kReach = 1.1, kFalloff = 0.05;
    const auto& ball =
        std::get<SphereSurface>(scene.surfaces[static_cast<std::size_t>(mirror.surface)]);
    LightProbe probe;
    probe.position = ball.center;
    probe.radius = kReach * ball.radius;
    probe.falloff = kFalloff;
    probe.size = size_for(mirror.alpha);
    set_parallax(probe, rays, scene.surfaces);
    return probe;
}

/// A probe for all of the mirrors, in the free place nearest to their middle, if there is one.
std::optional<LightProbe> probe_amid(const Scene& scene, const std::vector<Mirror>& mirrors,
                                     const SurfaceRays& rays, const medium::MediaSet& media,
                                     const Bounds& around)
{
    glm::dvec3 middle(0);
    double weights = 0, alpha = 1, extinction = 0;
    for (const Mirror& mirror : mirrors) {
        middle += mirror.gain() * mirror.place;
        weights += mirror.gain();
        extinction += mirror.gain() * most_extinction(media, mirror.place);
        if (mirror.gain() >= kUnseen)
            alpha = std::min(alpha, mirror.alpha);
    }
    middle /= weights;
    const double scale = around.empty() ? 1.0 : around.diagonal();
    const auto place = free_place(media, rays, middle, extinction / weights, scale / 2);
    if (!place)
        return {};
    LightProbe probe;
    probe.position = *place;
    probe.falloff = 0.25;
    // All that gains has it whole.
    double reach = 0;
    for (const Mirror& mirror : mirrors) {
        if (mirror.gain() < kUnseen)
            continue;
        const Bounds& own = rays.bounds_of(mirror.surface);
        for (int i = 0; i < 8; ++i) {
            const glm::dvec3 corner = own.corner(i);
            reach = std::max(
                reach,
                glm::distance(*place, around.empty() ? corner
                                                     : glm::clamp(corner, around.min, around.max)));
        }
    }
    probe.radius = std::max(reach, 1e-3 * scale) / (1 - probe.falloff);
    probe.size = size_for(alpha);
    set_parallax(probe, rays, scene.surfaces);
    return probe;
}

}  // namespace

ProbePlaces place_probes(const Scene& scene, const medium::MediaSet& media)
{
    if (std::none_of(scene.surfaces.begin(), scene.surfaces.end(),
                     [](const Surface& one) { return gloss_of(one).has_value(); }))
        return {{}, "no probe placed: no surface is glossy"};
    const SurfaceRays rays(scene.surfaces);
    const Bounds bounds = media.bounds();
    const double opacity = -std::expm1(-media.mean_optical_depth());
    const Bounds around = neighborhood(scene, rays, bounds);
    const glm::dvec3 center = (around.min + around.max) / 2.0;
    std::vector<Mirror> mirrors;
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        if (gloss_of(scene.surfaces[i]) && !rays.bounds_of(static_cast<int>(i)).empty())
            mirrors.push_back(
                look_around(scene, static_cast<int>(i), rays, center, bounds, opacity));
    std::stable_sort(mirrors.begin(), mirrors.end(),
                     [](const Mirror& a, const Mirror& b) { return a.gain() > b.gain(); });
    if (mirrors.empty())
        return {{}, "no probe placed: no surface is glossy"};
    const Mirror& most = mirrors.front();
    const std::string figure = fmt::format(
        "surfaces[{}] reflects {:.2g} of a white picture by direction, and {:.2g} of what it sees "
        "are surfaces and media: {:.2g}",
        most.surface, most.reflects, most.seen, most.gain());
    if (most.gain() < kUnseen)
        return {{}, fmt::format("no probe placed: {}, less than {:.2g}", figure, kUnseen)};
    std::vector<LightProbe> probes;
    std::vector<Mirror> others;
    for (const Mirror& mirror : mirrors)
        if (probes.size() < kMostInBalls && mirror.gain() >= kUnseen &&
            is_free_inside(scene, mirror, rays, media))
            probes.push_back(probe_in_ball(scene, mirror, rays));
        else
            others.push_back(mirror);
    std::vector<std::string> where;
    where.reserve(probes.size() + 1);
    for (const LightProbe& probe : probes)
        where.push_back(words_of(probe) + ", in a ball");
    // They are sorted: the first of the others gains most.
    if (!others.empty() && others.front().gain() >= kUnseen) {
        if (const auto probe = probe_amid(scene, others, rays, media, around)) {
            probes.push_back(*probe);
            where.push_back(words_of(*probe));
        }
    }
    if (probes.empty())
        return {{},
                fmt::format("no probe placed: {}, but no place near their middle is free", figure)};
    return {probes, fmt::format("{} placed {}: {}", probes.size() == 1 ? "probe" : "probes",
                                fmt::join(where, "; "), figure)};
}

std::vector<bool> unseen_by(const LightProbe& probe, const std::vector<Surface>& surfaces)
{
    // Of the sphere around, that a ball covers.
    const auto part = [](double radius, double distance) {
        if (distance <= radius)
            return 0.5;
        const double sine = radius / distance;
        return 0.5 * (1 - std::sqrt(1 - sine * sine));
    };
    const SurfaceRays rays(surfaces);
    std::vector<bool> left_out(surfaces.size());
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const Bounds& own = rays.bounds_of(static_cast<int>(i));
        if (!gloss_of(surfaces[i]) || own.empty() ||
            std::holds_alternative<BoxSurface>(surfaces[i]))
            continue;
        const auto* sphere = std::get_if<SphereSurface>(&surfaces[i]);
        const double radius = sphere != nullptr ? sphere->radius : own.diagonal() / 2;
        const glm::dvec3 center = (own.min + own.max) / 2.0;
        const double distance = glm::distance(probe.position, center);
        if (sphere == nullptr && distance <= radius)
            continue;  // it may be a room
        double others = 0;
        for (std::size_t k = 0; k < surfaces.size(); ++k) {
            const Bounds& other = rays.bounds_of(static_cast<int>(k));
            if (k != i && gloss_of(surfaces[k]) && !other.empty())
                others = std::max(
                    others,
                    part(radius, glm::distance(center, glm::clamp(center, other.min, other.max))));
        }
        left_out[i] = part(radius, distance) > others;
    }
    return left_out;
}

}  // namespace fumarole::light
