#include "study/reference_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/reference.h"
#include "study/reference_directions.h"
#include "study/reference_tracking.h"

namespace fumarole::study {

namespace {

/// Where the world is a map, the share of directions that its light chooses; the phase, or the
/// cosine, chooses the others. Mixed, neither leaves a direction unseen that the other needs.
constexpr double kMapShare = 0.5;

}  // namespace

// ------------------------------------------------------------------------------ what is seen

WorldRadiance::WorldRadiance(const World& world)
{
    if (world.environment == nullptr) {
        constant_ = mean_ = world.radiance;
        return;
    }
    map_ = world.environment.get();
    scale_ = static_cast<double>(world.environment_scale);
    // Between texels' centres radiance is interpolated: a texel's light reaches its neighbours.
    double rows = 0;
    for (int y = 0; y < map_->height; ++y) {
        double row = 0;
        for (int x = 0; x < map_->width; ++x) {
            mean_ += scale_ * solid_angle(y) / (4 * std::numbers::pi) * texel(x, y);
            double most = 0;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    most = std::max(most, largest(texel(x + dx, y + dy)));
            row += most * solid_angle(y);
            columns_.push_back(row);
        }
        rows_.push_back(rows += row);
    }
}

glm::dvec3 WorldRadiance::texel(int x, int y) const
{
    const int column = ((x % map_->width) + map_->width) % map_->width;
    const int row = std::clamp(y, 0, map_->height - 1);
    return map_->radiance[static_cast<std::size_t>(row) * static_cast<std::size_t>(map_->width) +
                          static_cast<std::size_t>(column)];
}

double WorldRadiance::solid_angle(int y) const
{
    return 2 * std::numbers::pi / map_->width *
           (std::cos(std::numbers::pi * y / map_->height) -
            std::cos(std::numbers::pi * (y + 1) / map_->height));
}

glm::dvec2 WorldRadiance::place(glm::dvec3 d) const
{
    return {(0.5 - std::atan2(d.y, d.x) / (2 * std::numbers::pi)) * map_->width,
            std::acos(std::clamp(d.z, -1.0, 1.0)) / std::numbers::pi * map_->height};
}

glm::dvec3 WorldRadiance::operator()(glm::dvec3 d) const
{
    if (map_ == nullptr)
        return constant_;
    // Between texels' centres: around in u, held at the poles in v.
    const glm::dvec2 at = place(d) - 0.5, low = glm::floor(at), f = at - low;
    const int x = static_cast<int>(low.x), y = static_cast<int>(low.y);
    return scale_ * glm::mix(glm::mix(texel(x, y), texel(x + 1, y), f.x),
                             glm::mix(texel(x, y + 1), texel(x + 1, y + 1), f.x), f.y);
}

glm::dvec3 WorldRadiance::sample(double u, double v) const
{
    const auto width = static_cast<std::size_t>(map_->width);
    const std::size_t y = choose(rows_.data(), rows_.size(), u);
    const std::size_t x = choose(columns_.data() + y * width, width, v);
    const double top = std::cos(std::numbers::pi * static_cast<double>(y) / map_->height),
                 bottom = std::cos(std::numbers::pi * static_cast<double>(y + 1) / map_->height);
    const double z = glm::mix(top, bottom, u), r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * std::numbers::pi * (0.5 - (static_cast<double>(x) + v) / map_->width);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

double WorldRadiance::pdf(glm::dvec3 d) const
{
    const glm::ivec2 at =
        glm::clamp(glm::ivec2(place(d)), glm::ivec2(0), glm::ivec2(map_->width, map_->height) - 1);
    const std::size_t i = static_cast<std::size_t>(at.y) * static_cast<std::size_t>(map_->width) +
                          static_cast<std::size_t>(at.x);
    const double before = at.x == 0 ? 0 : columns_[i - 1];
    return (columns_[i] - before) / rows_.back() / solid_angle(at.y);
}

double WorldRadiance::bound() const
{
    if (map_ == nullptr)
        return largest(constant_);
    double most = 0;
    for (const glm::vec3& texel : map_->radiance)
        most = std::max(most, largest(texel));
    // By a phase or a cosine alone, or, of a small bright thing, by sample() alone.
    return scale_ * std::min(most / (1 - kMapShare), rows_.back() / std::numbers::pi / kMapShare);
}

// ----------------------------------------------------------------------------------- gathering

ReferenceWorld::ReferenceWorld(const Scene& scene, const ReferenceSurfaces& surfaces,
                               const ReferenceTransparents& transparents,
                               const ReferenceMedia& media, const MediaTracking& tracking,
                               double opaque, bool emission_lights, const std::atomic<bool>* cancel)
    : surfaces_{surfaces},
      transparents_{transparents}, media_{media}, tracking_{tracking}, cancel_{cancel},
      radiance_{scene.world}, bound_{radiance_.bound()}, opaque_{opaque}, emits_{emission_lights}
{
}

void ReferenceWorld::check_cancel() const
{
    if (cancel_ != nullptr && *cancel_)
        throw ReferenceCancelled();
}

glm::dvec3 ReferenceWorld::arriving(const Origin& from, glm::dvec3 wi, const SobolPoint& u,
                                    glm::dvec3& clear) const
{
    clear = radiance_(wi);
    glm::dvec3 lit(0);
    const Ray ray{from.p, wi};
    if (clear != glm::dvec3(0)) {
        if (surfaces_.hidden(from, wi, kInfinity)) {
            clear = glm::dvec3(0);
        } else {
            clear *= transparents_.filter(ray, kInfinity);
            lit = clear * glm::exp(-media_.optical_depth(ray, kInfinity, opaque_));
        }
    }
    if (emits_) {
        Random random(u.word());
        lit += tracking_.emitted(ray, surfaces_.distance(from, wi), random,
                                 transparents_.along_way(ray));
    }
    return lit;
}

glm::dvec3 ReferenceWorld::one_direction(glm::dvec3 p, glm::dvec3 wo, double g,
                                         const SobolPoint& u) const
{
    const auto phase = [&](glm::dvec3 wi) { return phase_henyey_greenstein(glm::dot(-wi, wo), g); };
    const bool by_map = radiance_.is_map() && u(2) < kMapShare;
    const glm::dvec3 wi =
        by_map ? radiance_.sample(u(0), u(1))
               : directed(-wo, sample_henyey_greenstein(g, u(0)), 2 * std::numbers::pi * u(1));
    double weight = 1;  // phase / pdf
    if (radiance_.is_map()) {
        const double value = phase(wi);
        weight = value / (kMapShare * radiance_.pdf(wi) + (1 - kMapShare) * value);
    }
    glm::dvec3 clear;
    return weight * arriving({p, -1, glm::dvec3(0)}, wi, u, clear);
}

SamplingAccuracy ReferenceWorld::bounded(SamplingAccuracy accuracy, double scale) const
{
    accuracy.bound = bound_ * scale;
    return accuracy;
}

Integral ReferenceWorld::in_scattering(glm::dvec3 p, glm::dvec3 wo, double g, std::uint32_t seed,
                                       const SamplingAccuracy& accuracy) const
{
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            const glm::dvec3 v = one_direction(p, wo, g, u);
            return std::array{v.x, v.y, v.z};
        },
        seed, bounded(accuracy, 1));
    return {{mean.value[0], mean.value[1], mean.value[2]},
            mean.error,
            {mean.noise[0], mean.noise[1], mean.noise[2]}};
}

std::vector<Integral> ReferenceWorld::scattered(const Ray& ray, const ScatteringPlaces& places,
                                                const std::vector<double>& splits,
                                                std::uint32_t seed,
                                                const SamplingAccuracy& accuracy) const
{
    check_cancel();
    if (places.empty())
        return std::vector<Integral>(splits.size() + 1);
    return sampled_parts(
        [&](const auto& u) {
            const ScatteringPlaces::Place place = places.choose(u(3));
            glm::dvec3 found(0);
            if (place.weight != glm::dvec3(0))
                found = place.weight * one_direction(ray.at(place.t), -ray.direction, place.g, u);
            return std::pair(place.t, found);
        },
        splits, seed, bounded(accuracy, places.weight()));
}

WorldIrradiance ReferenceWorld::irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                           const SamplingAccuracy& accuracy) const
{
    if (black())
        return {};
    check_cancel();
    const Origin from = surfaces_.leave(hit);
    const auto mean = sampled_mean<6>(
        [&](const auto& u) {
            const bool by_map = radiance_.is_map() && u(2) < kMapShare;
            const glm::dvec3 wi =
                by_map ? radiance_.sample(u(0), u(1))
                       : directed(hit.shading, std::sqrt(1 - u(0)), 2 * std::numbers::pi * u(1));
            const double cosine = glm::dot(wi, hit.shading);
            if (cosine <= 0)
                return std::array<double, 6>{};
            double weight = std::numbers::pi;  // cosine / pdf
            if (radiance_.is_map())
                weight = cosine / (kMapShare * radiance_.pdf(wi) +
                                   (1 - kMapShare) * cosine / std::numbers::pi);
            glm::dvec3 clear;
            const glm::dvec3 lit = weight * arriving(from, wi, u, clear);
            clear *= weight;
            return std::array{clear.x, clear.y, clear.z, lit.x, lit.y, lit.z};
        },
        seed, bounded(accuracy, std::numbers::pi));
    const auto& v = mean.value;
    return {{v[0], v[1], v[2]},
            {v[3], v[4], v[5]},
            mean.error,
            {mean.noise[3], mean.noise[4], mean.noise[5]}};
}

}  // namespace fumarole::study
