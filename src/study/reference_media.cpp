#include "study/reference_media.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "noise_gradient.h"
#include "overloaded.h"
#include "study/reference_blackbody.h"
#include "study/reference_quadrature.h"
#include "study/reference_sampling.h"

namespace fumarole::study {

namespace {

using Span = asset::VdbSampler::Span;

glm::dvec3 value_of(const Span& span, double t)
{
    const double s = t - span.begin;
    return span.c[0] + s * (span.c[1] + s * (span.c[2] + s * span.c[3]));
}

glm::dvec3 integral_of(const Span& span, double t)
{
    const double s = t - span.begin;
    return s * (span.c[0] + s * (span.c[1] / 2.0 + s * (span.c[2] / 3.0 + s * span.c[3] / 4.0)));
}

/// Integral of exp(-(z - z0) / h) from begin to end along a ray.
double exp_height_integral(const ExpHeightProfile& profile, const Ray& ray, double begin,
                           double end)
{
    const double k = ray.direction.z / profile.scale_height, length = end - begin;
    const double first =
        std::exp((profile.z0 - ray.origin.z - ray.direction.z * begin) / profile.scale_height);
    const double x = k * length;
    if (std::abs(x) < 1e-8)
        return first * length * (1 - x / 2);
    return first * -std::expm1(-x) / k;
}

// ----------------------------------------------------------------------------------- noise
// Gradients as the scene format defines them, blended by the quintic fade of Perlin 2002.

double gradient_noise(glm::dvec3 q, std::uint32_t seed)
{
    const glm::dvec3 whole = glm::floor(q), f = q - whole;
    const glm::dvec3 u = noise_fade(f);
    glm::uvec3 cell;
    for (int axis = 0; axis < 3; ++axis)
        cell[axis] = static_cast<std::uint32_t>(
            static_cast<std::int64_t>(std::fmod(whole[axis], 4294967296.0)));
    double sum = 0;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const glm::uvec3 step(i & 1u, i >> 1u & 1u, i >> 2u);
        const double weight = (step.x != 0 ? u.x : 1 - u.x) * (step.y != 0 ? u.y : 1 - u.y) *
                              (step.z != 0 ? u.z : 1 - u.z);
        const glm::dvec3 gradient = noise_gradient(cell + step, seed);
        sum += weight * glm::dot(gradient, f - glm::dvec3(step));
    }
    return sum;
}

/// Half a cell of the third octave [m]: nothing larger slips between samples that far apart.
double noise_piece(const NoiseProfile& profile)
{
    return profile.feature_size / std::pow(profile.lacunarity, std::min(profile.octaves - 1, 2)) /
           2;
}

/// Appends cubics that follow `field` over [a, b] to within `error`.
template <class F>
void fit(const F& field, double a, double b, double error, int halvings, std::vector<Span>& out)
{
    const double h = b - a;
    std::array<double, 7> y;
    for (std::size_t i = 0; i < 7; ++i)
        y[i] = field(a + h * static_cast<double>(i) / 6);
    // Through the nodes 0, 1/3, 2/3, 1; those between tell how well.
    const double c0 = y[0], c1 = -5.5 * y[0] + 9 * y[2] - 4.5 * y[4] + y[6];
    const double c2 = 9 * y[0] - 22.5 * y[2] + 18 * y[4] - 4.5 * y[6];
    const double c3 = -4.5 * y[0] + 13.5 * y[2] - 13.5 * y[4] + 4.5 * y[6];
    double worst = 0;
    for (const std::size_t i : {1u, 3u, 5u}) {
        const double s = static_cast<double>(i) / 6;
        worst = std::max(worst, std::abs(c0 + s * (c1 + s * (c2 + s * c3)) - y[i]));
    }
    if (worst > error && halvings > 0) {
        fit(field, a, a + h / 2, error, halvings - 1, out);
        fit(field, a + h / 2, b, error, halvings - 1, out);
        return;
    }
    if (c0 != 0 || c1 != 0 || c2 != 0 || c3 != 0)
        out.push_back({a,
                       b,
                       {glm::dvec3(c0), glm::dvec3(c1 / h), glm::dvec3(c2 / (h * h)),
                        glm::dvec3(c3 / (h * h * h))}});
}

}  // namespace

double phase_henyey_greenstein(double cos_theta, double g)
{
    const double d = (1 - g) * (1 - g) + 2 * g * (1 - cos_theta);
    return (1 - g * g) / (4 * std::numbers::pi * d * std::sqrt(d));
}

// ------------------------------------------------------------------------------------- setup

ReferenceMedia::ReferenceMedia(const Scene& scene, double tolerance) : time_{scene.time}
{
    for (const Medium& medium : scene.media)
        std::visit(Overloaded{[&](const GridMedium& grid) { add(grid); },
                              [&](const BoxMedium& box) { add(box, tolerance); }},
                   medium);
}

ReferenceMedia::Field ReferenceMedia::place(const VoxelGrid& grid, const GridMedium& medium)
{
    Field field;
    field.grid = &grid;
    for (const auto& [source, sampler] : samplers_)
        if (source == &grid)
            field.sampler = sampler;
    if (field.sampler == nullptr) {
        field.sampler = std::make_shared<const asset::VdbSampler>(grid);
        samplers_.emplace_back(&grid, field.sampler);
    }
    const glm::dmat4 world_from_index =
        glm::scale(glm::translate(glm::dmat4(1.0), medium.translate), glm::dvec3(medium.scale)) *
        grid.world_from_index;
    field.index_from_world = glm::inverse(world_from_index);
    field.index_bounds = {glm::dvec3(grid.index_min) - 1.0, glm::dvec3(grid.index_max) + 1.0};
    field.world_bounds = field.index_bounds.transformed(world_from_index);
    field.voxel = kInfinity;
    for (int axis = 0; axis < 3; ++axis)
        field.voxel = std::min(field.voxel, glm::length(glm::dvec3(world_from_index[axis])));
    return field;
}

void ReferenceMedia::add(const GridMedium& medium)
{
    Entry entry;
    entry.sigma_s = medium.sigma_s_per_density;
    entry.sigma_t = entry.sigma_s + glm::dvec3(medium.sigma_a_per_density);
    entry.emission = medium.emission_per_unit;
    entry.g = static_cast<double>(medium.g);
    if (entry.dims() && medium.density != nullptr && !medium.density->empty()) {
        entry.density = place(*medium.density, medium);
        entry.bounds.add(entry.density->world_bounds);
        if (medium.color != nullptr && !medium.color->empty())
            entry.tint = place(*medium.color, medium);
    } else {
        entry.sigma_s = entry.sigma_t = glm::dvec3(0);
    }
    if (entry.emission != glm::dvec3(0) && medium.emission != nullptr &&
        !medium.emission->empty()) {
        entry.emission_field = place(*medium.emission, medium);
        entry.bounds.add(entry.emission_field->world_bounds);
    } else {
        entry.emission = glm::dvec3(0);
    }
    if (glows_hot(medium)) {
        entry.blackbody = glm::dvec3(medium.blackbody_tint) * double(medium.blackbody_intensity);
        entry.kelvin_per_unit = kelvin_per_unit(medium);
        entry.temperature = place(*medium.temperature, medium);
        entry.bounds.add(entry.temperature->world_bounds);
    }
    if (entry.is_grid())
        entries_.push_back(std::move(entry));
}

void ReferenceMedia::add(const BoxMedium& medium, double tolerance)
{
    Entry entry;
    entry.bounds = {medium.min, medium.max};
    entry.profile = medium.profile;
    entry.sigma_s = medium.sigma_s;
    entry.sigma_t = entry.sigma_s + glm::dvec3(medium.sigma_a);
    entry.emission = medium.emission;
    entry.g = static_cast<double>(medium.g);
    if (!entry.dims() && entry.emission == glm::dvec3(0))
        return;
    if (const auto* noise = std::get_if<NoiseProfile>(&medium.profile)) {
        double amplitudes = 0;
        for (int i = 0; i < noise->octaves; ++i)
            amplitudes += std::pow(noise->gain, i);
        entry.noise_scale = 1 / amplitudes;
        entry.noise_error =
            0.2 * tolerance / std::max(1.0, largest(entry.sigma_t) * entry.bounds.diagonal());
    }
    entries_.push_back(std::move(entry));
}

bool ReferenceMedia::emits() const
{
    return std::any_of(entries_.begin(), entries_.end(),
                       [](const Entry& entry) { return entry.glows(); });
}

bool ReferenceMedia::scatters() const
{
    return std::any_of(entries_.begin(), entries_.end(),
                       [](const Entry& entry) { return entry.sigma_s != glm::dvec3(0); });
}

void ReferenceMedia::add_light_breaks(const Ray& ray, const LightPlace& light,
                                      std::vector<double>& breaks) const
{
    for (const Entry& entry : entries_)
        if (entry.dims() && !entry.density)
            add_box_breaks(ray, entry.bounds, light, breaks);
}

// ---------------------------------------------------------------------------------- at a point

glm::dvec3 ReferenceMedia::Entry::emission_at(double value) const
{
    return blackbody * blackbody_emission(kelvin_per_unit * value);
}

glm::dvec3 ReferenceMedia::Field::sample(glm::dvec3 p) const
{
    return sampler->sample(glm::dvec3(index_from_world * glm::dvec4(p, 1)));
}

glm::dvec3 ReferenceMedia::Field::value(glm::dvec3 p) const
{
    return sampler->value(glm::dvec3(index_from_world * glm::dvec4(p, 1)));
}

void ReferenceMedia::Field::spans(const Ray& ray, double begin, double end, double most,
                                  std::vector<Span>& out) const
{
    sampler->spans(glm::dvec3(index_from_world * glm::dvec4(ray.origin, 1)),
                   glm::dvec3(index_from_world * glm::dvec4(ray.direction, 0)), begin, end, most,
                   out);
}

double ReferenceMedia::noise(const Entry& entry, const NoiseProfile& profile, glm::dvec3 p) const
{
    double sum = 0, amplitude = 1, frequency = 1 / profile.feature_size;
    for (int i = 0; i < profile.octaves; ++i) {
        sum += amplitude * gradient_noise((p - time_ * profile.drift) * frequency,
                                          noise_octave_seed(profile.seed, i));
        amplitude *= profile.gain;
        frequency *= profile.lacunarity;
    }
    const double fbm = 0.5 + 0.5 * sum * entry.noise_scale;
    return std::max(0.0, (fbm - profile.threshold) / (1 - profile.threshold));
}

glm::dvec3 ReferenceMedia::profile_at(const Entry& entry, glm::dvec3 p) const
{
    if (glm::any(glm::lessThan(p, entry.bounds.min)) ||
        glm::any(glm::greaterThan(p, entry.bounds.max)))
        return glm::dvec3(0);
    if (const auto* height = std::get_if<ExpHeightProfile>(&entry.profile))
        return glm::dvec3(std::exp((height->z0 - p.z) / height->scale_height));
    if (const auto* noise_profile = std::get_if<NoiseProfile>(&entry.profile))
        return glm::dvec3(noise(entry, *noise_profile, p));
    return glm::dvec3(1);
}

namespace {

/// Sums media at a point: coefficients and emission add, g is the mean weighted by sigma_s.
class PointSum {
public:
    void add(glm::dvec3 sigma_s, double g)
    {
        point_.sigma_s += sigma_s;
        const double weight = sigma_s.x + sigma_s.y + sigma_s.z;
        weights_ += weight;
        point_.g += weight * g;
    }
    void add_emission(glm::dvec3 emission) { point_.emission += emission; }
    [[nodiscard]] MediumPoint get() const
    {
        MediumPoint point = point_;
        point.g = weights_ > 0 ? point.g / weights_ : 0;
        return point;
    }

private:
    MediumPoint point_;
    double weights_ = 0;
};

}  // namespace

MediumPoint ReferenceMedia::at(glm::dvec3 p) const
{
    PointSum sum;
    for (const Entry& entry : entries_) {
        const glm::dvec3 value = entry.density     ? entry.density->sample(p)
                                 : entry.is_grid() ? glm::dvec3(0)
                                                   : profile_at(entry, p);
        const glm::dvec3 tint = entry.tint ? entry.tint->sample(p) : glm::dvec3(1);
        sum.add(entry.sigma_s * value * tint, entry.g);
        if (entry.emission != glm::dvec3(0))
            sum.add_emission(entry.emission *
                             (entry.emission_field ? entry.emission_field->sample(p) : value));
        if (entry.temperature)
            sum.add_emission(entry.emission_at(entry.temperature->sample(p).x));
    }
    return sum.get();
}

// --------------------------------------------------------------------------------- along a ray

void ReferenceMedia::noise_spans(const Entry& entry, const Ray& ray, double begin, double end,
                                 std::vector<Span>& out) const
{
    const auto& profile = std::get<NoiseProfile>(entry.profile);
    const int count =
        std::max(1, static_cast<int>(std::ceil((end - begin) / noise_piece(profile))));
    const auto field = [&](double t) { return noise(entry, profile, ray.at(t)); };
    for (int i = 0; i < count; ++i)
        fit(field, begin + (end - begin) * i / count, begin + (end - begin) * (i + 1) / count,
            entry.noise_error, 12, out);
}

glm::dvec3 ReferenceMedia::depth_of(const Entry& entry, const Ray& ray, double range) const
{
    const glm::dvec2 inside = box_range(ray, entry.bounds);
    const double begin = std::max(inside.x, 0.0), end = std::min(inside.y, range);
    if (!(begin < end))
        return glm::dvec3(0);
    if (const auto* height = std::get_if<ExpHeightProfile>(&entry.profile))
        return entry.sigma_t * exp_height_integral(*height, ray, begin, end);
    return entry.sigma_t * (end - begin);
}

template <class OfGrid, class OfNoise>
glm::dvec3 ReferenceMedia::sum_depths(const Ray& ray, double range, const OfGrid& of_grid,
                                      const OfNoise& of_noise) const
{
    glm::dvec3 tau(0);
    for (const Entry& entry : entries_) {
        if (!entry.dims())
            continue;
        const glm::dvec2 inside = box_range(ray, entry.bounds);
        const double begin = std::max(inside.x, 0.0), end = std::min(inside.y, range);
        if (!(begin < end))
            continue;
        if (entry.density) {
            const glm::dmat4& to_index = entry.density->index_from_world;
            const double least = std::min({entry.sigma_t.x, entry.sigma_t.y, entry.sigma_t.z});
            tau += entry.sigma_t * of_grid(*entry.density->sampler,
                                           glm::dvec3(to_index * glm::dvec4(ray.origin, 1)),
                                           glm::dvec3(to_index * glm::dvec4(ray.direction, 0)),
                                           begin, end, least);
        } else if (const auto* height = std::get_if<ExpHeightProfile>(&entry.profile)) {
            tau += entry.sigma_t * exp_height_integral(*height, ray, begin, end);
        } else if (const auto* profile = std::get_if<NoiseProfile>(&entry.profile)) {
            tau += entry.sigma_t * of_noise(entry, *profile, begin, end);
        } else {
            tau += entry.sigma_t * (end - begin);
        }
    }
    return tau;
}

glm::dvec3 ReferenceMedia::optical_depth(const Ray& ray, double range, double most) const
{
    return sum_depths(
        ray, range,
        [&](const asset::VdbSampler& sampler, glm::dvec3 o, glm::dvec3 d, double begin, double end,
            double least) {
            return sampler.column(o, d, begin, end, least > 0 ? most / least : kInfinity);
        },
        [&](const Entry& entry, const NoiseProfile&, double begin, double end) {
            std::vector<Span> spans;
            noise_spans(entry, ray, begin, end, spans);
            glm::dvec3 sum(0);
            for (const Span& span : spans)
                sum += integral_of(span, span.end);
            return sum;
        });
}

const Span* MediaAlongRay::Spans::find(double t) const
{
    const auto after = std::upper_bound(
        list.begin(), list.end(), t, [](double at, const Span& span) { return at < span.begin; });
    return after == list.begin() ? nullptr : &*(after - 1);
}

glm::dvec3 MediaAlongRay::Spans::at(double t) const
{
    const Span* span = find(t);
    return span == nullptr || t > span->end ? glm::dvec3(0) : value_of(*span, t);
}

glm::dvec3 MediaAlongRay::Spans::integral(double t) const
{
    const Span* span = find(t);
    if (span == nullptr)
        return glm::dvec3(0);
    return before[static_cast<std::size_t>(span - list.data())] +
           integral_of(*span, std::min(t, span->end));
}

void MediaAlongRay::Spans::sum()
{
    before.clear();
    glm::dvec3 total(0);
    for (const Span& span : list) {
        before.push_back(total);
        total += integral_of(span, span.end);
    }
}

glm::dvec3 MediaAlongRay::profile_integral(const Part& part, double t) const
{
    const ReferenceMedia::Entry& entry = *part.entry;
    if (entry.density || std::holds_alternative<NoiseProfile>(entry.profile))
        return part.density.integral(t);
    const double end = std::min(t, part.end);
    if (!(end > part.begin) || entry.is_grid())
        return glm::dvec3(0);
    if (const auto* height = std::get_if<ExpHeightProfile>(&entry.profile))
        return glm::dvec3(exp_height_integral(*height, ray_, part.begin, end));
    return glm::dvec3(end - part.begin);
}

glm::dvec3 MediaAlongRay::optical_depth(double t) const
{
    glm::dvec3 tau(0);
    for (const Part& part : parts_)
        if (part.entry->dims())
            tau += part.entry->sigma_t * profile_integral(part, t);
    return tau;
}

MediumPoint MediaAlongRay::at(double t) const
{
    PointSum sum;
    for (const Part& part : parts_) {
        if (!(t >= part.begin && t <= part.end))
            continue;
        const ReferenceMedia::Entry& entry = *part.entry;
        glm::dvec3 value(0);
        if (entry.density || std::holds_alternative<NoiseProfile>(entry.profile))
            value = part.density.at(t);
        else if (!entry.is_grid())
            value = media_.profile_at(entry,
                                      glm::clamp(ray_.at(t), entry.bounds.min, entry.bounds.max));
        sum.add(entry.sigma_s * value * (entry.tint ? part.tint.at(t) : glm::dvec3(1)), entry.g);
        if (entry.emission != glm::dvec3(0))
            sum.add_emission(entry.emission * (entry.emission_field ? part.emission.at(t) : value));
        if (entry.temperature)
            sum.add_emission(entry.emission_at(part.temperature.at(t).x));
    }
    return sum.get();
}

void MediaAlongRay::add_span_breaks(const Spans& spans)
{
    // Short enough that a rule of 15 points looks into every cell, long enough to profit from it.
    constexpr int kMostSpans = 16;
    int since = kMostSpans;
    double last = -kInfinity;
    for (const Span& span : spans.list) {
        const bool gap = span.begin > last;
        if (gap && std::isfinite(last))
            breaks_.push_back(last);
        if (gap || ++since >= kMostSpans) {
            breaks_.push_back(span.begin);
            since = 0;
        }
        last = span.end;
    }
    if (std::isfinite(last))
        breaks_.push_back(last);
}

void MediaAlongRay::add_depth_breaks()
{
    // A medium so thick that all of it is seen in a sliver would slip between a rule's points.
    constexpr std::array kDepths{2.0, 8.0, 20.0, ReferenceMedia::kOpaque};
    const double end = end_;
    for (int c = 0; c < 3; ++c) {
        if (whole_[c] < 4)
            continue;
        for (const double depth : kDepths) {
            if (depth >= whole_[c])
                break;
            double a = begin_, b = end;
            for (int halving = 0; halving < 50; ++halving) {
                const double middle = (a + b) / 2;
                (optical_depth(middle)[c] < depth ? a : b) = middle;
            }
            breaks_.push_back(b);
        }
    }
    const double least = std::min({whole_.x, whole_.y, whole_.z});
    if (least > ReferenceMedia::kOpaque) {
        double a = begin_, b = end;
        for (int halving = 0; halving < 50; ++halving) {
            const double middle = (a + b) / 2;
            const glm::dvec3 tau = optical_depth(middle);
            (std::min({tau.x, tau.y, tau.z}) < ReferenceMedia::kOpaque ? a : b) = middle;
        }
        end_ = b;
    }
}

void MediaAlongRay::set(const Ray& ray, double begin, double end)
{
    ray_ = ray;
    begin_ = begin;
    end_ = begin;
    parts_.clear();
    breaks_.clear();
    for (const ReferenceMedia::Entry& entry : media_.entries_) {
        const glm::dvec2 inside = box_range(ray, entry.bounds);
        Part part;
        part.entry = &entry;
        part.begin = std::max(inside.x, begin);
        part.end = std::min(inside.y, end);
        if (!(part.begin < part.end))
            continue;
        breaks_.push_back(part.begin);
        breaks_.push_back(part.end);
        end_ = std::max(end_, part.end);
        if (entry.density) {
            const double least = std::min({entry.sigma_t.x, entry.sigma_t.y, entry.sigma_t.z});
            entry.density->spans(ray, part.begin, part.end,
                                 least > 0 ? ReferenceMedia::kOpaque / least : kInfinity,
                                 part.density.list);
        } else if (std::holds_alternative<NoiseProfile>(entry.profile)) {
            media_.noise_spans(entry, ray, part.begin, part.end, part.density.list);
        }
        if (entry.emission_field)
            entry.emission_field->spans(ray, part.begin, part.end, kInfinity, part.emission.list);
        if (entry.temperature)
            entry.temperature->spans(ray, part.begin, part.end, kInfinity, part.temperature.list);
        if (entry.tint)
            entry.tint->spans(ray, part.begin, part.end, kInfinity, part.tint.list);
        part.density.sum();
        add_span_breaks(part.density);
        add_span_breaks(part.emission);
        add_span_breaks(part.temperature);
        parts_.push_back(std::move(part));
    }
    whole_ = optical_depth(end_);
    add_depth_breaks();
    std::sort(breaks_.begin(), breaks_.end());
    breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
    while (!breaks_.empty() && breaks_.back() >= end_)
        breaks_.pop_back();
    if (!breaks_.empty())
        breaks_.push_back(end_);
}

std::vector<double> MediaAlongRay::breaks_between(double a, double b) const
{
    if (breaks_.empty() || !(a < breaks_.back()) || !(b > breaks_.front()))
        return {};
    std::vector<double> between{std::max(a, breaks_.front())};
    for (const double t : breaks_)
        if (t > a && t < b && t > between.back())
            between.push_back(t);
    if (const double last = std::min(b, breaks_.back()); last > between.back())
        between.push_back(last);
    return between;
}

// ------------------------------------------------------------------------------- places by chance

ScatteringPlaces::ScatteringPlaces(const MediaAlongRay& along) : along_{along}
{
    // By intervals, evenly in each. An interval that looks empty from three points still gets a
    // little.
    const std::vector<double>& breaks = along.breaks();
    const auto seen = [&](double t) {
        return largest(along.at(t).sigma_s * glm::exp(-along.optical_depth(t)));
    };
    double sum = 0;
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i], d = breaks[i + 1] - a;
        shares_.push_back(d * (seen(a + 0.1 * d) + seen(a + 0.5 * d) + seen(a + 0.9 * d)) / 3);
        sum += shares_.back();
    }
    if (!(sum > 0)) {
        shares_.clear();
        return;
    }
    weight_ = sum;
    constexpr double kLittle = 0.01;
    const double length = breaks.back() - breaks.front();
    double running = 0;
    for (std::size_t i = 0; i < shares_.size(); ++i) {
        running +=
            (1 - kLittle) * shares_[i] / sum + kLittle * (breaks[i + 1] - breaks[i]) / length;
        shares_[i] = running;
    }
}

ScatteringPlaces::Place ScatteringPlaces::choose(double u) const
{
    const std::size_t i = study::choose(shares_.data(), shares_.size(), u);
    const double begin = along_.breaks()[i], d = along_.breaks()[i + 1] - begin;
    Place place;
    place.t = begin + d * u;
    const MediumPoint medium = along_.at(place.t);
    if (medium.sigma_s == glm::dvec3(0))
        return place;
    const double share = (shares_[i] - (i == 0 ? 0 : shares_[i - 1])) / shares_.back();
    place.weight = medium.sigma_s * glm::exp(-along_.optical_depth(place.t)) * (d / share);
    place.g = medium.g;
    return place;
}

}  // namespace fumarole::study
