#include "study/reference_paths.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/reference.h"
#include "study/reference_directions.h"

namespace fumarole::study {

namespace {

double mean(glm::dvec3 v)
{
    return (v.x + v.y + v.z) / 3;
}

}  // namespace

/// What a path needs beside its weight.
struct ReferencePaths::Walker {
    explicit Walker(const MediaTracking& tracking) : flight{tracking} {}

    FreeFlight flight;
    Random random{0};
};

ReferencePaths::ReferencePaths(const ReferenceSurfaces& surfaces, const ReferenceMedia& media,
                               const MediaTracking& tracking, const WorldRadiance& world,
                               const std::vector<ReferenceLight>& lights, PathOrders orders,
                               const std::atomic<bool>* cancel)
    : surfaces_{surfaces}, media_{media}, tracking_{tracking}, world_{world}, lights_{lights},
      orders_{orders}, emits_{media.emits()}, world_lights_{!world.black()}, cancel_{cancel}
{
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
            const glm::dvec3 p = ray.at(place.t);
            if (orders_.first == 0)
                v += place.weight * direct(p, -ray.direction, place.g, walker.random);
            const double cosine = sample_henyey_greenstein(place.g, u(0));
            v += walk(walker, u, {p, -1, glm::dvec3(0)},
                      directed(ray.direction, cosine, 2 * std::numbers::pi * u(1)),
                      phase_henyey_greenstein(cosine, place.g), place.weight);
            return std::pair(place.t, v);
        },
        splits, seed, accuracy);
}

Integral ReferencePaths::irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                    const SamplingAccuracy& accuracy) const
{
    Walker walker(tracking_);
    const Origin from = surfaces_.leave(hit);
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            walker.random = Random(u.word());
            const glm::dvec3 direction =
                directed(hit.shading, std::sqrt(1 - u(0)), 2 * std::numbers::pi * u(1));
            const glm::dvec3 v = walk(walker, u, from, direction, -1, glm::dvec3(std::numbers::pi));
            return std::array{v.x, v.y, v.z};
        },
        seed, accuracy);
    return {{mean.value[0], mean.value[1], mean.value[2]},
            mean.error,
            {mean.noise[0], mean.noise[1], mean.noise[2]}};
}

glm::dvec3 ReferencePaths::from_light(const ReferenceLight& light, glm::dvec3 p, glm::dvec3 wo,
                                      double g, Random& random) const
{
    const glm::dvec3 clear = light.irradiance(p);
    if (clear == glm::dvec3(0))
        return clear;
    const glm::dvec3 wi = light.place().wi(p);
    const double range = light.place().range(p);
    if (surfaces_.hidden({p, -1, glm::dvec3(0)}, wi, range))
        return glm::dvec3(0);
    return clear * phase_henyey_greenstein(glm::dot(-wi, wo), g) *
           tracking_.transmittance({p, wi}, range, random);
}

glm::dvec3 ReferencePaths::direct(glm::dvec3 p, glm::dvec3 wo, double g, Random& random) const
{
    glm::dvec3 sum(0);
    for (const ReferenceLight& light : lights_)
        if (light.has_area()) {
            const double u = random(), v = random();
            sum += from_light(light.part({u, v}, 1), p, wo, g, random);
        } else {
            sum += from_light(light, p, wo, g, random);
        }
    if (world_lights_ && world_.is_map()) {
        const double u = random(), v = random();
        const glm::dvec3 wi = world_.sample(u, v), radiance = world_(wi);
        if (radiance != glm::dvec3(0) && !surfaces_.hidden({p, -1, glm::dvec3(0)}, wi, kInfinity)) {
            const double phase = phase_henyey_greenstein(glm::dot(-wi, wo), g);
            sum += radiance * phase / (world_.pdf(wi) + phase) *
                   tracking_.transmittance({p, wi}, kInfinity, random);
        }
    }
    return sum;
}

glm::dvec3 ReferencePaths::walk(Walker& walker, const SobolPoint& point, Origin from,
                                glm::dvec3 direction, double phase, glm::dvec3 weight) const
{
    // Depths that have even points of their own; further on they would bring nothing more.
    constexpr int kEvenDepths = 6;
    // Scatterings from which on a path ends by chance.
    constexpr int kRoulette = 3;
    Random& random = walker.random;
    glm::dvec3 sum(0);
    const double whole = largest(weight);
    for (int k = 0;; ++k) {
        const Ray ray{from.p, direction};
        const double range = surfaces_.distance(from, direction);
        const bool counts = k >= orders_.first;
        if (counts && emits_)
            sum += weight * tracking_.emitted(ray, range, random);
        const bool seen = counts && world_lights_ && range == kInfinity;
        if (k == orders_.last && !seen)
            return sum;

        // A flight: real collision, or the range's end.
        bool scatters = false;
        TentativeCollision collision;
        if (k == 0 && !counts) {
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
        if (!scatters) {
            if (seen) {
                double share = 1;  // of multiple importance sampling
                if (world_.is_map() && phase >= 0)
                    share = phase / (phase + world_.pdf(direction));
                sum += share * weight * world_(direction);
            }
            return sum;
        }
        if (k == orders_.last)
            return sum;

        // Vertex k + 1.
        const glm::dvec3 p = ray.at(collision.t), wo = -direction;
        const double g = tracking_.g(p);
        if (k + 1 >= orders_.first)
            sum += weight * direct(p, wo, g, random);
        if (k + 1 >= kRoulette) {
            check_cancel();
            const double survival = std::min(1.0, largest(weight) / whole);
            if (random() >= survival)
                return sum;
            weight /= survival;
        }
        double u = 0, v = 0;
        if (k < kEvenDepths) {
            const SobolPoint even = point.padded(static_cast<std::uint32_t>(k));
            u = even(0);
            v = even(1);
        } else {
            u = random();
            v = random();
        }
        const double cosine = sample_henyey_greenstein(g, u);
        phase = phase_henyey_greenstein(cosine, g);
        direction = directed(direction, cosine, 2 * std::numbers::pi * v);
        from = {p, -1, glm::dvec3(0)};
    }
}

}  // namespace fumarole::study
