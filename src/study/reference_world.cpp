#include "study/reference_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/reference.h"

namespace fumarole::study {

namespace {

constexpr double kPi = std::numbers::pi;
/// Where the world is a map, the share of directions that its light chooses; the phase, or the
/// cosine, chooses the others. Mixed, neither leaves a direction unseen that the other needs.
constexpr double kMapShare = 0.5;

glm::dvec3 about(glm::dvec3 axis, double cosine, double phi)
{
    const glm::dvec3 helper = std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(helper, axis));
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return cosine * axis + sine * (std::cos(phi) * right + std::sin(phi) * glm::cross(axis, right));
}

/// A cosine whose density is Henyey and Greenstein's phase, by inversion.
double sample_henyey_greenstein(double g, double u)
{
    if (std::abs(g) < 1e-4)
        return 2 * u - 1 + 1.5 * g * (1 - std::pow(2 * u - 1, 2));  // to the first order of g
    const double root = (1 - g * g) / (1 - g + 2 * g * u);
    return std::clamp((1 + g * g - root * root) / (2 * g), -1.0, 1.0);
}

/// Chooses a part of a running sum that starts after `before`; u becomes the place in the part.
std::size_t choose(const double* first, std::size_t count, double& u)
{
    const double want = u * first[count - 1];
    const std::size_t i = std::min(
        static_cast<std::size_t>(std::upper_bound(first, first + count, want) - first), count - 1);
    const double low = i == 0 ? 0 : first[i - 1];
    u = first[i] > low ? std::clamp((want - low) / (first[i] - low), 0.0, 1.0) : 0.5;
    return i;
}

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
            mean_ += scale_ * solid_angle(y) / (4 * kPi) * texel(x, y);
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
    return 2 * kPi / map_->width *
           (std::cos(kPi * y / map_->height) - std::cos(kPi * (y + 1) / map_->height));
}

glm::dvec2 WorldRadiance::place(glm::dvec3 d) const
{
    return {(0.5 - std::atan2(d.y, d.x) / (2 * kPi)) * map_->width,
            std::acos(std::clamp(d.z, -1.0, 1.0)) / kPi * map_->height};
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
    const double top = std::cos(kPi * static_cast<double>(y) / map_->height),
                 bottom = std::cos(kPi * static_cast<double>(y + 1) / map_->height);
    const double z = glm::mix(top, bottom, u), r = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi = 2 * kPi * (0.5 - (static_cast<double>(x) + v) / map_->width);
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

// ----------------------------------------------------------------------------------- gathering

ReferenceWorld::ReferenceWorld(const Scene& scene, const ReferenceSurfaces& surfaces,
                               const ReferenceMedia& media, double opaque,
                               const std::atomic<bool>* cancel)
    : surfaces_{surfaces}, media_{media}, cancel_{cancel}, radiance_{scene.world}, opaque_{opaque}
{
}

void ReferenceWorld::check_cancel() const
{
    if (cancel_ != nullptr && *cancel_)
        throw ReferenceCancelled();
}

glm::dvec3 ReferenceWorld::arriving(const Origin& from, glm::dvec3 wi, glm::dvec3& clear) const
{
    clear = radiance_(wi);
    if (clear == glm::dvec3(0) || surfaces_.hidden(from, wi, kInfinity))
        return clear = glm::dvec3(0);
    return clear * glm::exp(-media_.optical_depth({from.p, wi}, kInfinity, opaque_));
}

glm::dvec3 ReferenceWorld::one_direction(glm::dvec3 p, glm::dvec3 wo, double g, glm::dvec3 u) const
{
    const auto phase = [&](glm::dvec3 wi) { return phase_henyey_greenstein(glm::dot(-wi, wo), g); };
    const bool by_map = radiance_.is_map() && u.z < kMapShare;
    const glm::dvec3 wi = by_map ? radiance_.sample(u.x, u.y)
                                 : about(-wo, sample_henyey_greenstein(g, u.x), 2 * kPi * u.y);
    double weight = 1;  // phase / pdf
    if (radiance_.is_map()) {
        const double value = phase(wi);
        weight = value / (kMapShare * radiance_.pdf(wi) + (1 - kMapShare) * value);
    }
    glm::dvec3 clear;
    return weight * arriving({p, -1, glm::dvec3(0)}, wi, clear);
}

Integral ReferenceWorld::in_scattering(glm::dvec3 p, glm::dvec3 wo, double g, std::uint32_t seed,
                                       const SamplingAccuracy& accuracy) const
{
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            const glm::dvec3 v = one_direction(p, wo, g, {u(0), u(1), u(2)});
            return std::array{v.x, v.y, v.z};
        },
        seed, accuracy);
    return {{mean.value[0], mean.value[1], mean.value[2]}, mean.error};
}

Integral ReferenceWorld::scattered(const Ray& ray, const MediaAlongRay& along, std::uint32_t seed,
                                   const SamplingAccuracy& accuracy) const
{
    check_cancel();
    // Places are chosen where what scatters is seen: by intervals, evenly in each. An interval that
    // looks empty from three points still gets a little.
    const std::vector<double>& breaks = along.breaks();
    const auto seen = [&](double t) {
        return largest(along.at(t).sigma_s * glm::exp(-along.optical_depth(t)));
    };
    std::vector<double> shares;
    double sum = 0;
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i], d = breaks[i + 1] - a;
        shares.push_back(d * (seen(a + 0.1 * d) + seen(a + 0.5 * d) + seen(a + 0.9 * d)) / 3);
        sum += shares.back();
    }
    if (!(sum > 0))
        return {};
    constexpr double kLittle = 0.01;
    const double length = breaks.back() - breaks.front();
    double running = 0;
    for (std::size_t i = 0; i < shares.size(); ++i) {
        running += (1 - kLittle) * shares[i] / sum + kLittle * (breaks[i + 1] - breaks[i]) / length;
        shares[i] = running;
    }
    const auto mean = sampled_mean<3>(
        [&](const auto& u) {
            double in = u(3);
            const std::size_t i = choose(shares.data(), shares.size(), in);
            const double d = breaks[i + 1] - breaks[i], t = breaks[i] + d * in;
            const MediumPoint medium = along.at(t);
            if (medium.sigma_s == glm::dvec3(0))
                return std::array{0.0, 0.0, 0.0};
            const double share = (shares[i] - (i == 0 ? 0 : shares[i - 1])) / shares.back();
            const glm::dvec3 v =
                medium.sigma_s * glm::exp(-along.optical_depth(t)) * (d / share) *
                one_direction(ray.at(t), -ray.direction, medium.g, {u(0), u(1), u(2)});
            return std::array{v.x, v.y, v.z};
        },
        seed, accuracy);
    return {{mean.value[0], mean.value[1], mean.value[2]}, mean.error};
}

WorldIrradiance ReferenceWorld::irradiance(const SurfaceHit& hit, std::uint32_t seed,
                                           const SamplingAccuracy& accuracy) const
{
    if (radiance_.black())
        return {};
    check_cancel();
    const Origin from = surfaces_.leave(hit);
    const auto mean = sampled_mean<6>(
        [&](const auto& u) {
            const bool by_map = radiance_.is_map() && u(2) < kMapShare;
            const glm::dvec3 wi = by_map ? radiance_.sample(u(0), u(1))
                                         : about(hit.shading, std::sqrt(1 - u(0)), 2 * kPi * u(1));
            const double cosine = glm::dot(wi, hit.shading);
            if (cosine <= 0)
                return std::array<double, 6>{};
            double weight = kPi;  // cosine / pdf
            if (radiance_.is_map())
                weight = cosine / (kMapShare * radiance_.pdf(wi) + (1 - kMapShare) * cosine / kPi);
            glm::dvec3 clear;
            const glm::dvec3 lit = weight * arriving(from, wi, clear);
            clear *= weight;
            return std::array{clear.x, clear.y, clear.z, lit.x, lit.y, lit.z};
        },
        seed, accuracy);
    const auto& v = mean.value;
    return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, mean.error};
}

}  // namespace fumarole::study
