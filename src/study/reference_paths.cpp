#include "study/reference_paths.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "study/reference.h"
#include "study/reference_directions.h"

namespace fumarole::study {

namespace {

double mean(glm::dvec3 v)
{
    return (v.x + v.y + v.z) / 3;
}

/// Of two ways to a direction, the first's part (the balance heuristic).
double share_of(double pdf, double other)
{
    return pdf / (pdf + other);
}

/// The same by the power heuristic: a lamp that is small, and seldom met, is left to its own
/// samples all but wholly, or the estimate of the error would not know what few meetings bring.
double squared_share_of(double pdf, double other)
{
    return pdf * pdf / (pdf * pdf + other * other);
}

}  // namespace

/// What a path needs beside its weight.
struct ReferencePaths::Walker {
    explicit Walker(const MediaTracking& tracking) : flight{tracking} {}

    FreeFlight flight;
    Random random{0};
};

/// Where light is scattered, or reflected by a surface.
struct ReferencePaths::Vertex {
    Origin from;
    glm::dvec3 wo{0};  ///< towards where it goes on
    double g = 0;
    const SurfaceReflection* surface = nullptr;

    /// Sent to wo per irradiance from wi. [1/sr]
    [[nodiscard]] glm::dvec3 operator()(glm::dvec3 wi) const
    {
        return surface != nullptr ? (*surface)(wi)
                                  : glm::dvec3(phase_henyey_greenstein(glm::dot(-wi, wo), g));
    }
    [[nodiscard]] double pdf(glm::dvec3 wi) const
    {
        return surface != nullptr ? surface->pdf(wi)
                                  : phase_henyey_greenstein(glm::dot(-wi, wo), g);
    }
    [[nodiscard]] bool glossy() const { return surface != nullptr && surface->glossy(); }
};

ReferencePaths::ReferencePaths(const ReferenceSurfaces& surfaces,
                               const ReferenceTransparents& transparents,
                               const ReferenceMedia& media, const MediaTracking& tracking,
                               const WorldRadiance& world,
                               const std::vector<ReferenceLight>& lights,
                               const SurfaceEmitters& emitters, PathOrders orders,
                               const std::atomic<bool>* cancel)
    : surfaces_{surfaces}, transparents_{transparents}, media_{media}, tracking_{tracking},
      world_{world}, lights_{lights}, emitters_{emitters}, orders_{orders},
      emits_{media.emits() && orders.media_light}, world_lights_{!world.black()}, cancel_{cancel}
{
}

glm::dvec3 ReferencePaths::transmittance(const Ray& ray, double range, Random& random) const
{
    return transparents_.filter(ray, range) * tracking_.transmittance(ray, range, random);
}

void ReferencePaths::check_cancel() const
{
    if (cancel_ != nullptr && *cancel_)
        throw ReferenceCancelled();
}

std::vector<Integral> ReferencePaths::scattered(const Ray& ray, const ScatteringPlaces& places,
                                                const std::vector<double>& splits,
                                                std::uint32_t seed,
                                                const SamplingAccuracy& accuracy) const
{
    if (places.empty())
        return std::vector<Integral>(splits.size() + 1);
    Walker walker(tracking_);
    return sampled_parts(
        [&](const auto& u) {
            const ScatteringPlaces::Place place = places.choose(u(3));
            glm::dvec3 v(0);
            if (place.weight == glm::dvec3(0))
                return std::pair(place.t, v);
            walker.random = Random(u.word());
            const Vertex vertex{{ray.at(place.t), -1, glm::dvec3(0)}, -ray.direction, place.g};
            if (orders_.first == 0)
                v += place.weight * direct(vertex, walker.random);
            else
                v += place.weight * from_emitters(vertex, walker.random);
            const double cosine = sample_henyey_greenstein(place.g, u(0));
            v += walk(walker, u,
                      {vertex.from, directed(ray.direction, cosine, 2 * std::numbers::pi * u(1)),
                       phase_henyey_greenstein(cosine, place.g)},
                      place.weight, orders_.first);
            return std::pair(place.t, v);
        },
        splits, seed, accuracy);
}

namespace {

Integral integral_from(const SampledMean<3>& mean)
{
    return {{mean.value[0], mean.value[1], mean.value[2]},
            mean.error,
            {mean.noise[0], mean.noise[1], mean.noise[2]}};
}

}  // namespace

Integral ReferencePaths::irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                    const SamplingAccuracy& accuracy) const
{
    Walker walker(tracking_);
    SurfaceHit white = hit;
    white.albedo = glm::vec3(1);
    const SurfaceReflection reflection(white, hit.shading);
    const Vertex vertex{surfaces_.leave(hit), hit.shading, 0, &reflection};
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            walker.random = Random(u.word());
            glm::dvec3 v(0);
            if (!emitters_.empty())
                v += std::numbers::pi * from_emitters(vertex, walker.random);
            const double cosine = std::sqrt(1 - u(0));
            v += walk(walker, u,
                      {vertex.from, directed(hit.shading, cosine, 2 * std::numbers::pi * u(1)),
                       cosine / std::numbers::pi},
                      glm::dvec3(std::numbers::pi), 1);
            return std::array{v.x, v.y, v.z};
        },
        seed, accuracy);
    return integral_from(mean);
}

Integral ReferencePaths::reflected(const SurfaceHit& hit, glm::dvec3 wo, std::uint32_t seed,
                                   const SamplingAccuracy& accuracy) const
{
    Walker walker(tracking_);
    const SurfaceReflection reflection(hit, wo);
    const Vertex vertex{surfaces_.leave(hit), wo, 0, &reflection};
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            walker.random = Random(u.word());
            glm::dvec3 v(0);
            for (const ReferenceLight& light : lights_)
                if (light.has_area())
                    v += from_area(light, vertex, walker.random);
            v += from_map(vertex, walker.random) + from_emitters(vertex, walker.random);
            if (const auto sent = reflection.sample(u(0), u(1), u(2)))
                v += walk(walker, u, {vertex.from, sent->wi, sent->pdf, true}, sent->weight, 0);
            return std::array{v.x, v.y, v.z};
        },
        seed, accuracy);
    return integral_from(mean);
}

glm::dvec3 ReferencePaths::from_light(const ReferenceLight& light, const Vertex& vertex,
                                      Random& random) const
{
    const glm::dvec3 p = vertex.from.p, clear = light.irradiance(p);
    if (clear == glm::dvec3(0))
        return clear;
    const glm::dvec3 wi = light.place().wi(p), sent = vertex(wi);
    const double range = light.place().range(p);
    if (sent == glm::dvec3(0) || surfaces_.hidden(vertex.from, wi, range))
        return glm::dvec3(0);
    return clear * sent * transmittance({p, wi}, range, random);
}

glm::dvec3 ReferencePaths::from_area(const ReferenceLight& light, const Vertex& vertex,
                                     Random& random) const
{
    const double u = random(), v = random();
    const ReferenceLight part = light.part({u, v}, 1);
    const glm::dvec3 found = from_light(part, vertex, random);
    if (found == glm::dvec3(0) || !vertex.glossy())
        return found;
    const glm::dvec3 wi = part.place().wi(vertex.from.p);
    return found * squared_share_of(light.seen({vertex.from.p, wi}).pdf, vertex.pdf(wi));
}

glm::dvec3 ReferencePaths::from_map(const Vertex& vertex, Random& random) const
{
    if (!world_lights_ || !world_.is_map())
        return glm::dvec3(0);
    const double u = random(), v = random();
    const glm::dvec3 wi = world_.sample(u, v), radiance = world_(wi), sent = vertex(wi);
    if (radiance * sent == glm::dvec3(0) || surfaces_.hidden(vertex.from, wi, kInfinity))
        return glm::dvec3(0);
    return radiance * sent / (world_.pdf(wi) + vertex.pdf(wi)) *
           transmittance({vertex.from.p, wi}, kInfinity, random);
}

glm::dvec3 ReferencePaths::from_emitters(const Vertex& vertex, Random& random) const
{
    if (emitters_.empty())
        return glm::dvec3(0);
    // What is met there is the emitter itself.
    constexpr double kBefore = 1 - 1e-9;
    const double u = random(), v = random(), which = random();
    const SurfaceEmitters::Sample found = emitters_.sample(vertex.from.p, u, v, which);
    if (!(found.pdf > 0))
        return glm::dvec3(0);
    const glm::dvec3 sent = vertex(found.wi);
    if (sent == glm::dvec3(0) || surfaces_.hidden(vertex.from, found.wi, kBefore * found.range))
        return glm::dvec3(0);
    return found.radiance * sent * (squared_share_of(found.pdf, vertex.pdf(found.wi)) / found.pdf) *
           transmittance({vertex.from.p, found.wi}, found.range, random);
}

glm::dvec3 ReferencePaths::met_lights(const Leg& leg, double range, Random& random) const
{
    glm::dvec3 sum(0);
    const Ray ray{leg.from.p, leg.direction};
    for (const ReferenceLight& light : lights_) {
        if (!light.has_area())
            continue;
        const ReferenceLight::Seen seen = light.seen(ray);
        if (seen.range < range)
            sum += seen.radiance * squared_share_of(leg.pdf, seen.pdf) *
                   transmittance(ray, seen.range, random);
    }
    return sum;
}

glm::dvec3 ReferencePaths::direct(const Vertex& vertex, Random& random) const
{
    glm::dvec3 sum(0);
    for (const ReferenceLight& light : lights_)
        sum +=
            light.has_area() ? from_area(light, vertex, random) : from_light(light, vertex, random);
    sum += from_map(vertex, random);
    return sum + from_emitters(vertex, random);
}

glm::dvec3 ReferencePaths::walk(Walker& walker, const SobolPoint& point, Leg leg, glm::dvec3 weight,
                                int first) const
{
    // Depths that have even points of their own; further on they would bring nothing more.
    constexpr int kEvenDepths = 6;
    // Vertices from which on a path ends by chance.
    constexpr int kRoulette = 3;
    // Between white surfaces nothing is lost, and no path would end.
    constexpr int kMany = 256;
    constexpr double kMostSurvival = 0.98;
    Random& random = walker.random;
    glm::dvec3 sum(0);
    const double whole = largest(weight);
    const bool surfaces = orders_.surfaces > 0 || !emitters_.empty();
    int scatterings = 0, reflections = 0;
    for (int k = 0;; ++k) {
        const Ray ray{leg.from.p, leg.direction};
        std::optional<SurfaceHit> met;
        double range = 0;
        if (surfaces) {
            if (glm::dot(leg.from.normal, leg.direction) < 0)  // below an interpolated normal
                return sum;
            met = surfaces_.meet(leg.from, leg.direction);
            range = met ? met->t : kInfinity;
        } else {
            range = surfaces_.distance(leg.from, leg.direction);
        }
        const bool counts = k >= first;
        if (counts && emits_)
            sum += weight * tracking_.emitted(ray, range, random, transparents_.along_way(ray));
        if (counts && leg.glossy)
            sum += weight * met_lights(leg, range, random);
        const bool seen = counts && world_lights_ && range == kInfinity;
        const bool glows = met && met->emission != glm::vec3(0);
        const bool reflects = met && met->surface >= 0 && reflections < orders_.surfaces &&
                              (met->albedo != glm::vec3(0) || met->gloss != nullptr);
        const bool last = scatterings == orders_.last;
        if (last && !seen && !glows && !reflects)
            return sum;

        // A flight: real collision, or the range's end.
        bool scatters = false;
        TentativeCollision collision;
        if (k == 0 && !counts && !glows && !reflects) {
            weight *= walker.flight.start_colliding(ray, range, random);
            if (weight == glm::dvec3(0))
                return sum;
        } else {
            walker.flight.start(ray, range, random);
        }
        while (!scatters && walker.flight.next(collision, random)) {
            const glm::dvec3 real = weight * collision.sigma_s / collision.majorant;
            const glm::dvec3 null = weight * (1.0 - collision.sigma_t / collision.majorant);
            const double to_real = mean(glm::abs(real)), to_null = mean(glm::abs(null));
            if (!(to_real + to_null > 0))
                return sum;
            const double chance = to_real / (to_real + to_null);
            scatters = random() < chance;
            weight = scatters ? real / chance : null / (1 - chance);
            // In a medium that only absorbs, a flight fades and never ends.
            constexpr double kFaint = 1e-2, kSurvival = 0.25;
            if (!scatters && largest(weight) < kFaint * whole) {
                if (random() >= kSurvival)
                    return sum;
                weight /= kSurvival;
            }
        }
        weight *= transparents_.filter(ray, scatters ? collision.t : range);
        Vertex vertex;
        vertex.wo = -leg.direction;
        std::optional<SurfaceReflection> reflection;
        if (scatters) {
            if (last)
                return sum;
            ++scatterings;
            const glm::dvec3 p = ray.at(collision.t);
            vertex.from = {p, -1, glm::dvec3(0)};
            vertex.g = tracking_.g(p);
        } else {
            if (seen) {
                double share = 1;  // of multiple importance sampling
                if (world_.is_map())
                    share = share_of(leg.pdf, world_.pdf(leg.direction));
                sum += share * weight * world_(leg.direction);
            }
            if (glows)
                sum += squared_share_of(leg.pdf, emitters_.pdf(leg.from.p, *met)) * weight *
                       glm::dvec3(met->emission);
            if (!reflects)
                return sum;
            ++reflections;
            vertex.from = surfaces_.leave(*met);
            vertex.surface = &reflection.emplace(*met, vertex.wo);
        }

        // Vertex k + 1.
        if (k + 1 >= first)
            sum += weight * direct(vertex, random);
        if (k + 1 >= kRoulette) {
            check_cancel();
            double survival = std::min(1.0, largest(weight) / whole);
            if (reflections > 0 && k >= kMany)
                survival = std::min(survival, kMostSurvival);
            if (random() >= survival)
                return sum;
            weight /= survival;
        }
        double u = 0, v = 0, which = 0;
        if (k < kEvenDepths) {
            const SobolPoint even = point.padded(static_cast<std::uint32_t>(k));
            u = even(0);
            v = even(1);
            which = even(2);
        } else {
            u = random();
            v = random();
            which = reflection ? random() : 0;
        }
        leg.from = vertex.from;
        leg.glossy = vertex.glossy();
        if (reflection) {
            const auto sent = reflection->sample(u, v, which);
            if (!sent)
                return sum;
            leg.direction = sent->wi;
            leg.pdf = sent->pdf;
            weight *= sent->weight;
        } else {
            const double cosine = sample_henyey_greenstein(vertex.g, u);
            leg.pdf = phase_henyey_greenstein(cosine, vertex.g);
            leg.direction = directed(leg.direction, cosine, 2 * std::numbers::pi * v);
        }
    }
}

}  // namespace fumarole::study
