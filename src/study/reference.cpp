#include "study/reference.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <mutex>
#include <numbers>
#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/parallel_for.h>

#include "light/surface_turns.h"
#include "study/reference_emitters.h"
#include "study/reference_geometry.h"
#include "study/reference_lights.h"
#include "study/reference_media.h"
#include "study/reference_paths.h"
#include "study/reference_quadrature.h"
#include "study/reference_transparents.h"
#include "study/reference_world.h"
#include <fumarole/errors.h>
#include <fumarole/scene_renderer.h>

namespace fumarole::study {

namespace {

/// The scene's camera as rays from its near plane on.
class EyeRays {
public:
    explicit EyeRays(const Scene& scene) : camera_{scene.camera}, size_{scene.resolution}
    {
        forward_ = glm::normalize(camera_.look_at - camera_.position);
        right_ = glm::normalize(glm::cross(forward_, camera_.up));
        up_ = glm::cross(right_, forward_);
        const double tangent = std::tan(glm::radians(camera_.vfov_deg) / 2);
        if (camera_.projection == Camera::Projection::perspective)
            half_ = tangent;
        else
            half_ = camera_.ortho_height > 0
                        ? camera_.ortho_height / 2
                        : tangent * glm::length(camera_.look_at - camera_.position);
    }

    /// A ray through a point of the picture; `per_z`: its metres per metre of view depth.
    [[nodiscard]] Ray ray(glm::dvec2 point, double& per_z) const
    {
        const double aspect = size_.x / size_.y;
        const glm::dvec2 ndc(2 * point.x / size_.x - 1, 1 - 2 * point.y / size_.y);
        const glm::dvec3 across = ndc.x * half_ * aspect * right_ + ndc.y * half_ * up_;
        per_z = 1;
        if (camera_.projection == Camera::Projection::orthographic)
            return {camera_.position + across, forward_};
        const glm::dvec3 d = forward_ + across;
        per_z = glm::length(d);
        return {camera_.position, d / per_z};
    }

    [[nodiscard]] double near() const { return camera_.near; }
    [[nodiscard]] double far() const { return camera_.far; }

private:
    const Camera& camera_;
    glm::dvec2 size_;
    glm::dvec3 forward_, right_, up_;
    double half_ = 1;
};

}  // namespace

class Reference::Impl {
public:
    Impl(const Scene& scene, double tolerance, int bounces, int surface_bounces,
         const std::atomic<bool>* cancel)
        : eye_{scene}, surfaces_{scene.surfaces}, transparents_{scene}, media_{scene, tolerance},
          tracking_{media_}, world_{scene,
                                    surfaces_,
                                    transparents_,
                                    media_,
                                    tracking_,
                                    -std::log(0.1 * tolerance),
                                    media_.emits() && bounces != kLampsAndWorldOnce,
                                    cancel},
          emitters_{bounces == kLampsAndWorldOnce ? SurfaceEmitters()
                                                  : SurfaceEmitters(scene.surfaces)},
          // What is integrated errs alike in neighbouring pixels, so it is not as lax as what is
          // sampled.
          tolerance_{tolerance}, quadrature_{bounces > 0 || surface_bounces > 0
                                                 ? std::min(tolerance, 0.02)
                                                 : tolerance},
          traced_{(media_.scatters() && bounces > 0) || surface_bounces > 0 || !emitters_.empty()},
          paths_{surfaces_,
                 transparents_,
                 media_,
                 tracking_,
                 world_.radiance(),
                 lights_,
                 emitters_,
                 orders(bounces, surface_bounces),
                 cancel},
          clear_media_{Scene(), tolerance}, clear_tracking_{clear_media_},
          clear_paths_{surfaces_,
                       transparents_,
                       clear_media_,
                       clear_tracking_,
                       world_.radiance(),
                       lights_,
                       emitters_,
                       orders(bounces, surface_bounces),
                       cancel}
    {
        for (const Light& light : scene.lights)
            if (const ReferenceLight made(light); !made.black())
                lights_.push_back(made);
    }

    [[nodiscard]] ReferenceSample sample(glm::dvec2 point, double floor, double surface_floor,
                                         double relax) const
    {
        ReferenceSample out;
        double per_z = 1;
        const Ray ray = eye_.ray(point, per_z);
        const double begin = eye_.near() * per_z;
        const auto hit = surfaces_.intersect(ray, begin, eye_.far() * per_z);
        const double end = hit ? hit->t : kInfinity;
        const std::uint32_t seed = seed_of(point);
        double surface_error = 0;
        if (hit) {
            out.view_z = hit->t / per_z;
            surface_error = shade(*hit, -ray.direction, seed, surface_floor, relax, out);
        } else {
            out.surface = out.surface_lit = world_.radiance()(ray.direction);
        }
        const std::vector<TransparentHit> hits =
            transparents_.along(ray, begin, eye_.far() * per_z, end);
        MediaAlongRay along(media_);
        if (!media_.empty()) {
            along.set(ray, begin, end);
            out.transmittance = glm::exp(-along.whole_depth());
        }
        gather(ray, along, hits, {begin, end, seed, floor, relax, surface_error}, out);
        return out;
    }

    [[nodiscard]] const ReferenceMedia& media() const { return media_; }
    [[nodiscard]] const ReferenceWorld& world() const { return world_; }
    [[nodiscard]] double tolerance() const { return tolerance_; }

private:
    /// A ray as sample() sends it.
    struct Sent {
        double begin, end;
        std::uint32_t seed;
        double floor, relax;
        double surface_error;
    };

    /// From the surface to the eye: what media add between one transparent and the next, and what
    /// each transparent makes of all that is behind it. Fills in scattering and composite.
    void gather(const Ray& ray, const MediaAlongRay& along, const std::vector<TransparentHit>& hits,
                const Sent& sent, ReferenceSample& out) const
    {
        const std::vector<Integral> added = scattered(ray, along, hits, sent);
        // Radiance where it is; alpha is the transparents' own. Noise and error are as the eye has
        // them, in which they add up.
        glm::dvec4 behind(out.surface_lit, 1);
        out.composite_noise = out.surface_noise * out.transmittance;
        out.error = sent.surface_error * largest(out.transmittance);
        glm::dvec3 passed = out.transmittance;  // from the eye to there
        for (std::size_t i = hits.size() + 1; i-- > 0;) {
            out.scattering += added[i].value;
            out.noise += added[i].noise;
            out.composite_noise += added[i].noise;
            out.error = std::hypot(out.error, added[i].error);
            const glm::dvec3 nearer = i > 0 && !media_.empty()
                                          ? glm::exp(-along.optical_depth(hits[i - 1].t))
                                          : glm::dvec3(1);
            for (int c = 0; c < 3; ++c)  // what the eye sees nothing of is nothing
                behind[c] = nearer[c] > 1e-200
                                ? (behind[c] * passed[c] + added[i].value[c]) / nearer[c]
                                : 0.0;
            passed = nearer;
            if (i == 0)
                break;
            const glm::dvec3 kept(hits[i - 1].kept(behind));
            behind = hits[i - 1].over(behind);
            out.composite_noise *= kept;
            out.error *= largest(kept);
        }
        out.composite = behind;
    }

    /// Radiance scattered and emitted on the parts of a ray before, between and beyond the
    /// transparents, as seen from the eye.
    [[nodiscard]] std::vector<Integral> scattered(const Ray& ray, const MediaAlongRay& along,
                                                  const std::vector<TransparentHit>& hits,
                                                  const Sent& sent) const
    {
        std::vector<Integral> parts(hits.size() + 1);
        if (along.breaks().empty())
            return parts;
        std::vector<double> splits;
        splits.reserve(hits.size());
        for (const TransparentHit& hit : hits)
            splits.push_back(hit.t);
        glm::dvec3 known(0);
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const std::vector<double> breaks =
                hits.empty() ? along.breaks()
                             : along.breaks_between(i > 0 ? splits[i - 1] : sent.begin,
                                                    i < splits.size() ? splits[i] : sent.end);
            if (breaks.size() < 2)
                continue;
            parts[i] = emitted(along, breaks, sent.floor);
            for (const ReferenceLight& light : lights_)
                if (media_.scatters())
                    parts[i] += from_light(ray, along, breaks, light, sent.floor);
            known += parts[i].value;
        }
        if (!media_.scatters())
            return parts;
        const ScatteringPlaces places(along);
        const auto add = [&](const std::vector<Integral>& sampled) {
            for (std::size_t i = 0; i < parts.size(); ++i) {
                parts[i].value += sampled[i].value;
                parts[i].noise += sampled[i].noise;
                parts[i].error = std::hypot(parts[i].error, sampled[i].error);
                known += sampled[i].value;
            }
        };
        if (!world_.black())
            add(world_.scattered(ray, places, splits, hash(sent.seed, 1),
                                 sampling(known, sent.floor, sent.relax)));
        if (traced_)
            add(paths_.scattered(ray, places, splits, hash(sent.seed, 2),
                                 sampling(known, sent.floor, sent.relax)));
        return parts;
    }

    /// A light's irradiance of a plane that faces it, with all that is in its way.
    [[nodiscard]] glm::dvec3 arriving(const ReferenceLight& light, const Origin& from,
                                      glm::dvec3& clear) const
    {
        clear = light.irradiance(from.p);
        if (clear == glm::dvec3(0))
            return clear;
        const glm::dvec3 wi = light.place().wi(from.p);
        const double range = light.place().range(from.p);
        if (surfaces_.hidden(from, wi, range)) {
            clear = glm::dvec3(0);
            return clear;
        }
        clear *= transparents_.filter({from.p, wi}, range);
        return clear * glm::exp(-media_.optical_depth({from.p, wi}, range));
    }

    /// Fills in the surfaces' radiance; answers with its estimated error.
    double shade(const SurfaceHit& hit, glm::dvec3 wo, std::uint32_t seed, double floor,
                 double relax, ReferenceSample& out) const
    {
        const double error = hit.gloss != nullptr ? shade_glossy(hit, wo, seed, floor, relax, out)
                                                  : shade_lambertian(hit, seed, floor, relax, out);
        out.surface += glm::dvec3(hit.emission);
        out.surface_lit += glm::dvec3(hit.emission);
        return error;
    }

    double shade_glossy(const SurfaceHit& hit, glm::dvec3 wo, std::uint32_t seed, double floor,
                        double relax, ReferenceSample& out) const
    {
        const SurfaceReflection reflection(hit, wo);
        const Origin from = surfaces_.leave(hit);
        for (const ReferenceLight& light : lights_) {
            if (light.has_area())
                continue;
            const glm::dvec3 sent = reflection(light.place().wi(hit.p));
            if (sent == glm::dvec3(0))
                continue;
            glm::dvec3 clear;
            out.surface_lit += sent * arriving(light, from, clear);
            out.surface += sent * clear;
        }
        SamplingAccuracy asked = sampling(out.surface_lit, floor, relax);
        // Few directions of a lobe are lost below the surface: so few samples that have met none
        // would agree on what is wrong by more than the tolerance.
        constexpr double kSamples = 8192;
        asked.first = std::max(asked.first, std::bit_ceil(static_cast<std::uint32_t>(
                                                std::min(kSamples, 1 / (8 * asked.relative)))));
        const Integral found = paths_.reflected(hit, wo, hash(seed, 3), asked);
        out.surface += media_.empty() ? found.value
                                      : clear_paths_.reflected(hit, wo, hash(seed, 3), asked).value;
        out.surface_lit += found.value;
        out.surface_noise = found.noise;
        return found.error;
    }

    double shade_lambertian(const SurfaceHit& hit, std::uint32_t seed, double floor, double relax,
                            ReferenceSample& out) const
    {
        glm::dvec3 clear(0), lit(0);
        const Origin from = surfaces_.leave(hit);
        const glm::dvec3 reflected = glm::dvec3(hit.albedo) / std::numbers::pi;
        if (reflected == glm::dvec3(0))
            return 0;
        const auto of_part = [&](const ReferenceLight& part, double&) {
            const double cosine = std::max(glm::dot(hit.shading, part.place().wi(hit.p)), 0.0);
            glm::dvec3 without(0);
            const glm::dvec3 with = cosine > 0 ? arriving(part, from, without) : without;
            return glm::dmat2x3(cosine * with, cosine * without);
        };
        double light_error = 0;
        for (const ReferenceLight& light : lights_) {
            const glm::dmat2x3 both =
                light.over_parts(accuracy(floor / largest(reflected)), light_error, of_part);
            lit += both[0];
            clear += both[1];
        }
        const WorldIrradiance world =
            world_.irradiance(hit, seed, sampling(lit, floor / largest(reflected), relax));
        clear += world.clear;
        lit += world.lit;
        glm::dvec3 noise = world.noise;
        double error = std::hypot(light_error, world.error);
        if (traced_) {
            const SamplingAccuracy asked = sampling(lit, floor / largest(reflected), relax);
            const Integral bounced = paths_.irradiance(hit, hash(seed, 3), asked);
            clear += media_.empty() ? bounced.value
                                    : clear_paths_.irradiance(hit, hash(seed, 3), asked).value;
            lit += bounced.value;
            noise += bounced.noise;
            error = std::hypot(error, bounced.error);
        }
        out.surface = reflected * clear;
        out.surface_lit = reflected * lit;
        out.surface_noise = reflected * noise;
        return largest(reflected) * error;
    }

    // Of the tolerance a quarter is the quadratures' along the ray, whose errors are of no known
    // sign; the rest, as they add up in squares, the sampling's of the world.
    [[nodiscard]] Accuracy accuracy(double floor) const
    {
        const double integrals = 1 + static_cast<double>(lights_.size());
        return {.relative = quadrature_ / 4,
                .absolute = floor / 4 / integrals * (quadrature_ / tolerance_)};
    }
    /// @param known what is there already, which the tolerance is relative to as well
    [[nodiscard]] SamplingAccuracy sampling(glm::dvec3 known, double floor, double relax) const
    {
        const double share = traced_ ? 0.9 / std::numbers::sqrt2 : 0.9;
        // A lax picture is done before so many points as an exact one begins with.
        const double wanted = relax * tolerance_;
        const std::uint32_t first = wanted <= 0.01 ? 16 : wanted < 0.03 ? 8 : 4;
        return {.relative = share * wanted,
                .absolute = share * relax * std::max(floor, tolerance_ * largest(known)),
                .first = first};
    }

    static PathOrders orders(int bounces, int surface_bounces)
    {
        return {.first = 1,
                .last = std::max(bounces, 0),
                .surfaces = surface_bounces,
                .media_light = bounces != kLampsAndWorldOnce};
    }

    /// The same point is asked the same way, whoever asks.
    static std::uint32_t seed_of(glm::dvec2 point)
    {
        std::uint32_t seed = 0;
        for (const double x : {point.x, point.y}) {
            const auto bits = std::bit_cast<std::uint64_t>(x);
            seed = hash(hash(seed, static_cast<std::uint32_t>(bits)),
                        static_cast<std::uint32_t>(bits >> 32u));
        }
        return seed;
    }

    Integral emitted(const MediaAlongRay& along, const std::vector<double>& breaks,
                     double floor) const
    {
        const auto source = [&](double t) {
            const glm::dvec3 emission = along.at(t).emission;
            return emission == glm::dvec3(0) ? emission
                                             : emission * glm::exp(-along.optical_depth(t));
        };
        return media_.emits() ? integrate(source, breaks, accuracy(floor)) : Integral{};
    }

    Integral from_light(const Ray& ray, const MediaAlongRay& along,
                        const std::vector<double>& breaks, const ReferenceLight& light,
                        double floor) const
    {
        Integral sum;
        sum.value = light.over_parts(
            accuracy(floor), sum.error, [&](const ReferenceLight& part, double& error) {
                const Integral one = from_part(ray, along, breaks, part, floor);
                error += one.error;
                return one.value;
            });
        return sum;
    }

    Integral from_part(const Ray& ray, const MediaAlongRay& along,
                       const std::vector<double>& media_breaks, const ReferenceLight& light,
                       double floor) const
    {
        const double begin = media_breaks.front(), end = media_breaks.back();
        std::vector<double> breaks;
        surfaces_.add_shadow_breaks(ray, begin, end, light.place(), breaks);
        transparents_.add_filter_breaks(ray, begin, end, light.place(), breaks);
        light.add_cone_breaks(ray, breaks);
        media_.add_light_breaks(ray, light.place(), breaks);
        std::erase_if(breaks, [&](double t) { return !(t > begin && t < end); });
        breaks.insert(breaks.end(), media_breaks.begin(), media_breaks.end());

        const Equiangular stretch(ray, light.place());
        if (!light.place().far)
            if (const double foot = stretch.to_t(0); foot > begin && foot < end)
                breaks.push_back(foot);
        std::sort(breaks.begin(), breaks.end());
        for (double& t : breaks)
            t = stretch.from_t(t);
        const glm::dvec3 wo = -ray.direction;
        const auto source = [&](double x) {
            const double t = stretch.to_t(x);
            const MediumPoint medium = along.at(t);
            if (medium.sigma_s == glm::dvec3(0))
                return glm::dvec3(0);
            const glm::dvec3 p = ray.at(t);
            glm::dvec3 clear;
            const glm::dvec3 here = arriving(light, {p, -1, glm::dvec3(0)}, clear);
            if (here == glm::dvec3(0))
                return here;
            const double phase =
                phase_henyey_greenstein(glm::dot(-light.place().wi(p), wo), medium.g);
            return medium.sigma_s * here * glm::exp(-along.optical_depth(t)) *
                   (phase * stretch.dt_dx(x));
        };
        return integrate(source, breaks, accuracy(floor));
    }

    EyeRays eye_;
    ReferenceSurfaces surfaces_;
    ReferenceTransparents transparents_;
    ReferenceMedia media_;
    MediaTracking tracking_;
    ReferenceWorld world_;
    SurfaceEmitters emitters_;
    double tolerance_, quadrature_;
    bool traced_;  ///< whether there are paths with more vertices than vertex 0
    std::vector<ReferenceLight> lights_;
    ReferencePaths paths_;
    // As if there were no media.
    ReferenceMedia clear_media_;
    MediaTracking clear_tracking_;
    ReferencePaths clear_paths_;
};

int measured_surface_bounces(const Scene& scene)
{
    return light::surface_turns(scene, {}).turns > 0 ? kAllBounces : 0;
}

Reference::Reference(const Scene& scene, double tolerance, int bounces, int surface_bounces,
                     const std::atomic<bool>* cancel)
    : impl_{std::make_unique<Impl>(scene, tolerance, bounces, surface_bounces, cancel)}
{
}

Reference::~Reference() = default;

ReferenceSample Reference::sample(glm::dvec2 point, double floor, double surface_floor,
                                  double relax) const
{
    return impl_->sample(point, floor, surface_floor, relax);
}

glm::dvec3 Reference::transmittance(glm::dvec3 p, glm::dvec3 wi, double range) const
{
    return glm::exp(-impl_->media().optical_depth({p, wi}, range));
}

glm::dvec3 Reference::world_in_scattering(glm::dvec3 p, glm::dvec3 wo, double g) const
{
    return impl_->world().in_scattering(p, wo, g, 0, {.relative = impl_->tolerance()}).value;
}

// ---------------------------------------------------------------------------------- a picture

namespace {

/// What relative MSE (metrics.h) adds where a picture is dark, sqrt(0.1 mean(s^2)).
struct Darkness {
    double media = 0;      ///< radiance that media scatter
    double composite = 0;  ///< radiance of the picture
};

/// From few pixels spread over the whole picture, whatever the region.
template <class OfMedia>
Darkness darkness(const Reference& reference, const Scene& scene, double floor,
                  const OfMedia& of_media)
{
    constexpr int kColumns = 16, kRows = 9;
    std::vector<Darkness> found(std::size_t(kColumns) * kRows);
    oneapi::tbb::parallel_for(0, kColumns * kRows, [&](int i) {
        const glm::dvec2 share((i % kColumns + 0.5) / kColumns, (i / kColumns + 0.5) / kRows);
        const ReferenceSample s =
            reference.sample(glm::floor(share * glm::dvec2(scene.resolution)) + 0.5, floor);
        found[static_cast<std::size_t>(i)] = {of_media(s), largest(s.composite)};
    });
    Darkness mean_square;
    for (const Darkness& one : found) {
        mean_square.media += one.media * one.media / (kColumns * kRows);
        mean_square.composite += one.composite * one.composite / (kColumns * kRows);
    }
    return {std::sqrt(0.1 * mean_square.media), std::sqrt(0.1 * mean_square.composite)};
}

/// Absolute errors that are good enough where the picture is dark: what the relative MSE counts as
/// the tolerance there.
struct Floors {
    double media = 0;    ///< radiance that media scatter
    double surface = 0;  ///< radiance that surfaces send
};

/// Whether vertices other than the first one that the eye sees, or lobes, are sampled.
bool is_straight(const Scene& scene, const ReferenceOptions& options)
{
    return options.surface_bounces == 0 &&
           std::none_of(scene.surfaces.begin(), scene.surfaces.end(), [](const Surface& surface) {
               return std::visit(
                   [](const auto& of) { return of.gloss || of.emission != glm::vec3(0); }, surface);
           });
}

Floors dark_floors(const Scene& scene, const ReferenceOptions& options)
{
    if (!is_straight(scene, options)) {
        // Indoors most of the light may come from the walls: a lax look, and one to a floor that
        // is known by it.
        constexpr double kLax = 0.3, kAnything = 1e30;
        const Reference lax(scene, kLax, options.bounces, options.surface_bounces, options.cancel);
        const auto of_media = [](const ReferenceSample& s) { return largest(s.scattering); };
        const Darkness guess = darkness(lax, scene, kAnything, of_media);
        const Darkness lit = darkness(lax, scene, kLax * guess.composite, of_media);
        return {options.tolerance * lit.media, options.tolerance * lit.composite};
    }
    // The world's light is dear: a guess at it is enough here.
    Scene unlit = scene;
    unlit.world = {};
    const Reference relaxed(unlit, 0.05, 0, 0, options.cancel);
    const double world = 0.5 * largest(WorldRadiance(scene.world).mean());
    const Darkness guess = darkness(relaxed, unlit, 0, [&](const ReferenceSample& s) {
        return largest(s.scattering) + world * largest(1.0 - s.transmittance);
    });
    return {options.tolerance * guess.media, options.tolerance * guess.media};
}

void store(std::vector<float>& to, std::size_t pixel, glm::dvec3 color)
{
    for (int c = 0; c < 3; ++c)
        to[pixel * 3 + static_cast<std::size_t>(c)] = static_cast<float>(color[c]);
}

}  // namespace

ReferenceStill render_reference(const Scene& scene, const ReferenceOptions& options)
{
    const glm::ivec2 size(scene.resolution);
    const ReferenceRegion region = options.region.value_or(ReferenceRegion{0, 0, size.x, size.y});
    if (region.x < 0 || region.y < 0 || region.width <= 0 || region.height <= 0 ||
        region.width > size.x - region.x || region.height > size.y - region.y)
        throw Error(fmt::format("the region {} {} {} {} (x y width height) lies not within the "
                                "picture of {} x {}",
                                region.x, region.y, region.width, region.height, size.x, size.y));
    if (!(options.tolerance > 0))
        throw Error(fmt::format("a tolerance of {}: give more than 0", options.tolerance));
    const int aa = std::max(1, options.aa);

    ReferenceStill still;
    still.width = region.width;
    still.height = region.height;
    const auto pixels =
        static_cast<std::size_t>(region.width) * static_cast<std::size_t>(region.height);
    for (auto* rgb : {&still.composite, &still.scattering, &still.transmittance, &still.surface,
                      &still.surface_lit, &still.noise, &still.scattering_noise})
        rgb->resize(pixels * 3);
    still.depth.resize(pixels);
    still.error.resize(pixels);

    const Reference reference(scene, options.tolerance, options.bounces, options.surface_bounces,
                              options.cancel);
    const Floors floors = dark_floors(scene, options);
    // Whoever reads a pixel that is finished sees all that its thread stored before.
    std::vector<std::atomic<char>> finished(pixels);
    if (options.begun != nullptr) {
        if (options.begun->still.width != still.width ||
            options.begun->still.height != still.height || options.begun->finished.size() != pixels)
            throw std::logic_error("a reference goes on from one of another size");
        still = options.begun->still;
        for (std::size_t i = 0; i < pixels; ++i)
            finished[i] = options.begun->finished[i];
    }
    std::mutex keeping;
    const auto keep = [&](bool last) {
        const std::unique_lock lock(keeping, std::try_to_lock);
        if (lock.owns_lock() && options.keep)
            options.keep(
                still, [&] { return std::vector<char>(finished.begin(), finished.end()); }, last);
    };
    std::mutex progress;
    std::size_t done = 0;
    const auto render_pixel = [&](int x, int y) {
        if (options.cancel != nullptr && *options.cancel)
            throw ReferenceCancelled();
        const std::size_t pixel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(region.width) +
            static_cast<std::size_t>(x);
        if (finished[pixel] != 0)
            return;
        glm::dvec3 composite(0), scattering(0), transmittance(0), surface(0), surface_lit(0);
        glm::dvec3 noise(0), scattering_noise(0);
        double squares = 0;
        for (int i = 0; i < aa; ++i) {
            // subpixel_offset counts its y upwards, as OpenGL does.
            const glm::dvec2 offset = subpixel_offset(i) * glm::dvec2(1, -1);
            const ReferenceSample s =
                reference.sample(glm::dvec2(region.x + x, region.y + y) + 0.5 + offset,
                                 floors.media, floors.surface, std::sqrt(aa));
            composite += s.composite;
            scattering += s.scattering;
            transmittance += s.transmittance;
            surface += s.surface;
            surface_lit += s.surface_lit;
            noise += s.composite_noise;
            scattering_noise += s.noise;
            squares += s.error * s.error;
            if (i == 0)
                still.depth[pixel] = static_cast<float>(s.view_z);
        }
        const double n = aa;
        store(still.composite, pixel, composite / n);
        store(still.scattering, pixel, scattering / n);
        store(still.transmittance, pixel, transmittance / n);
        store(still.surface, pixel, surface / n);
        store(still.surface_lit, pixel, surface_lit / n);
        store(still.noise, pixel, noise / n);
        store(still.scattering_noise, pixel, scattering_noise / n);
        still.error[pixel] = static_cast<float>(std::sqrt(squares) / n);
        finished[pixel] = 1;
        keep(false);
    };
    const auto render_tile = [&](const oneapi::tbb::blocked_range2d<int>& tile) {
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
            for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
                render_pixel(x, y);
        const std::lock_guard lock(progress);
        done += tile.rows().size() * tile.cols().size();
        if (options.progress)
            options.progress(static_cast<double>(done) / static_cast<double>(pixels));
        if (options.on_tile)
            options.on_tile({tile.cols().begin(), tile.rows().begin(),
                             static_cast<int>(tile.cols().size()),
                             static_cast<int>(tile.rows().size())},
                            still);
    };
    constexpr int kTile = 8;
    try {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range2d<int>(0, region.height, kTile, 0, region.width, kTile),
            render_tile, oneapi::tbb::simple_partitioner());
    } catch (...) {
        keep(true);
        throw;
    }
    return still;
}

}  // namespace fumarole::study
