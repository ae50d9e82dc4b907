#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "study/reference_quadrature.h"

// Integrals over more than a line: randomised quasi-Monte Carlo.

namespace fumarole::study {

/// A good hash of two words (the finaliser of MurmurHash3).
inline std::uint32_t hash(std::uint32_t a, std::uint32_t b)
{
    std::uint32_t h = a ^ (b * 0x9e3779b9u + 0x85ebca6bu + (a << 6u) + (a >> 2u));
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

/// Sobol's sequence in up to four dimensions, scrambled as Owen does it by a hash: each digit is
/// turned by the digits above it (Burley 2020, "Practical Hash-based Owen Scrambling", sec. 3). Any
/// seed gives points of the same evenness, independent of another seed's, each uniform by itself.
class Sobol {
public:
    static constexpr std::size_t kDimensions = 4;

    explicit Sobol(std::uint32_t seed) : seed_{seed} {}

    /// Coordinate of point i, in [0, 1).
    [[nodiscard]] double operator()(std::uint32_t i, std::size_t dimension) const
    {
        const std::uint32_t digits =
            nested_uniform(plain(i, dimension), hash(seed_, static_cast<std::uint32_t>(dimension)));
        return digits * 0x1p-32;
    }

    /// The place of point i once points are shuffled as Owen scrambles digits: the first 2^k points
    /// become 2^k points that stand together in the sequence, which are as even.
    static std::uint32_t shuffled(std::uint32_t i, std::uint32_t seed)
    {
        return nested_uniform(i, seed);
    }

private:
    static std::uint32_t reversed(std::uint32_t x)
    {
        x = (x << 16u) | (x >> 16u);
        x = ((x & 0x00ff00ffu) << 8u) | ((x & 0xff00ff00u) >> 8u);
        x = ((x & 0x0f0f0f0fu) << 4u) | ((x & 0xf0f0f0f0u) >> 4u);
        x = ((x & 0x33333333u) << 2u) | ((x & 0xccccccccu) >> 2u);
        return ((x & 0x55555555u) << 1u) | ((x & 0xaaaaaaaau) >> 1u);
    }
    /// Laine and Karras 2011, sec. 4: a hash whose every bit hangs on lower bits alone, applied to
    /// the word reversed.
    static std::uint32_t nested_uniform(std::uint32_t x, std::uint32_t seed)
    {
        x = reversed(x);
        x += seed;
        x ^= x * 0x6c50b47cu;
        x ^= x * 0xb82f1e52u;
        x ^= x * 0xc7afe638u;
        x ^= x * 0x8d22f6e6u;
        return reversed(x);
    }
    static std::uint32_t plain(std::uint32_t i, std::size_t dimension)
    {
        if (dimension == 0)
            return reversed(i);
        static const auto kDirections = directions();
        std::uint32_t x = 0;
        for (std::size_t bit = 0; i != 0; i >>= 1u, ++bit)
            if ((i & 1u) != 0)
                x ^= kDirections[dimension - 1][bit];
        return x;
    }
    /// From the primitive polynomials and first numbers of Joe and Kuo 2008, dimensions 2 to 4.
    static std::array<std::array<std::uint32_t, 32>, kDimensions - 1> directions()
    {
        struct Row {
            std::size_t degree;
            std::uint32_t polynomial;
            std::array<std::uint32_t, 3> first;
        };
        constexpr std::array<Row, kDimensions - 1> kRows{Row{1, 0, {1, 0, 0}}, Row{2, 1, {1, 3, 0}},
                                                         Row{3, 1, {1, 3, 1}}};
        std::array<std::array<std::uint32_t, 32>, kDimensions - 1> all{};
        for (std::size_t d = 0; d < kRows.size(); ++d) {
            const Row& row = kRows[d];
            auto& v = all[d];
            for (std::size_t k = 0; k < 32; ++k) {
                if (k < row.degree) {
                    v[k] = row.first[k] << (31 - k);
                    continue;
                }
                v[k] = v[k - row.degree] ^ (v[k - row.degree] >> row.degree);
                for (std::size_t j = 1; j < row.degree; ++j)
                    if ((row.polynomial >> (row.degree - 1 - j) & 1u) != 0)
                        v[k] ^= v[k - j];
            }
        }
        return all;
    }

    std::uint32_t seed_;
};

/// One point of a scrambled sequence, asked for its coordinates. What needs more dimensions than a
/// sequence has asks for more points (Burley 2020, sec. 4: padding).
class SobolPoint {
public:
    SobolPoint(std::uint32_t seed, std::uint32_t index)
        : sequence_(seed), seed_{seed}, index_{index}
    {
    }

    /// In [0, 1).
    [[nodiscard]] double operator()(std::size_t dimension) const
    {
        return sequence_(index_, dimension);
    }

    /// A point of another sequence, number `set`, shuffled: unlike points of equal index, whose
    /// digits would hang on each other, the two together are spread over all dimensions.
    [[nodiscard]] SobolPoint padded(std::uint32_t set) const
    {
        const std::uint32_t seed = hash(seed_, 0x70616464u + set);
        return {seed, Sobol::shuffled(index_, hash(seed, 0x73687566u))};
    }

    /// A word of its own, to seed a generator with.
    [[nodiscard]] std::uint64_t word() const
    {
        return (std::uint64_t{hash(seed_, index_)} << 32u) | hash(index_ + 0x9e3779b9u, seed_);
    }

private:
    Sobol sequence_;
    std::uint32_t seed_, index_;
};

/// Chooses a part of a running sum that starts after `before`; u becomes the place in the part.
inline std::size_t choose(const double* first, std::size_t count, double& u)
{
    const double want = u * first[count - 1];
    const std::size_t i = std::min(
        static_cast<std::size_t>(std::upper_bound(first, first + count, want) - first), count - 1);
    const double low = i == 0 ? 0 : first[i - 1];
    u = first[i] > low ? std::clamp((want - low) / (first[i] - low), 0.0, 1.0) : 0.5;
    return i;
}

/// Means of numbers over the unit cube. Several scrambles are followed side by side, twice as far
/// each time, until what they differ by says that their means are good enough. The estimate is two
/// standard errors, of the worst of the numbers.
struct SampledMeans {
    std::vector<double> value;
    double error = 0;
    std::vector<double> noise;  ///< as Integral's
};

struct SamplingAccuracy {
    double relative = 1e-3;  ///< tolerance relative to the largest number
    double absolute = 0;
    std::uint32_t first = 16;  ///< samples of each scramble before the first look at the error
    std::uint32_t most = 1u << 18u;  ///< samples; it ends there, and the estimate says so
    /// The most that a sample may find, where little may be found seldom: of samples that have
    /// found next to nothing one more could have found that. 0: it is not known.
    double bound = 0;
};

/// Half of the scrambles of sampled_means().
class SampledHalf {
public:
    static constexpr std::uint32_t kScrambles = 4;

    explicit SampledHalf(std::size_t count) : count_{count}, sums_(kScrambles * count) {}

    /// Goes on to so many samples of each scramble. @param first number of its first scramble
    template <class Add>
    void go_on(const Add& add, std::uint32_t seed, std::uint32_t first, std::uint32_t upto)
    {
        for (std::uint32_t s = 0; s < kScrambles; ++s)
            for (std::uint32_t i = done_; i < upto; ++i)
                found_ += add(SobolPoint(hash(seed, first + s), i), &sums_[s * count_]) ? 1 : 0;
        done_ = upto;
    }
    [[nodiscard]] double mean(std::size_t c) const
    {
        double sum = 0;
        for (std::uint32_t s = 0; s < kScrambles; ++s)
            sum += sums_[s * count_ + c];
        return sum / kScrambles / done_;
    }
    /// Square of the standard error of mean().
    [[nodiscard]] double variance(std::size_t c) const
    {
        const double of_all = mean(c);
        double squares = 0;
        for (std::uint32_t s = 0; s < kScrambles; ++s)
            squares += std::pow(sums_[s * count_ + c] / done_ - of_all, 2);
        return squares / (kScrambles * (kScrambles - 1.0));
    }
    /// Whether this and another half that has seen the same together are good enough.
    [[nodiscard]] bool is_good(const SamplingAccuracy& accuracy) const
    {
        // So many tell how much they differ by.
        constexpr std::uint32_t kFew = 16;
        double size = 0, squares = 0;
        for (std::size_t c = 0; c < count_; ++c) {
            size = std::max(size, std::abs(mean(c)));
            squares = std::max(squares, variance(c));
        }
        double error = 2 * std::sqrt(squares / 2);
        // More than so many would be asked for what is hardly ever found.
        constexpr std::uint32_t kMany = 1u << 12u;
        const std::uint32_t samples = 2 * kScrambles * done_;
        if (found_ < kFew && samples < kMany)
            error = std::max(error, 2 * accuracy.bound / samples);
        return error <= std::max(accuracy.absolute, accuracy.relative * size);
    }

private:
    std::size_t count_;
    std::vector<double> sums_;  ///< of each scramble
    std::uint32_t done_ = 0;    ///< samples of each
    std::uint32_t found_ = 0;   ///< samples of all that have found something
};

/// @param add adds a point's numbers, as many as `count`, to those that it is given, and says
/// whether it found any: add(point, double*)
template <class Add>
SampledMeans sampled_means(const Add& add, std::size_t count, std::uint32_t seed,
                           const SamplingAccuracy& accuracy)
{
    // Each half ends when the other is good enough. Ended by themselves, those that happened to
    // find little would agree on it the sooner, and the mean over pixels would be too low.
    std::array<SampledHalf, 2> halves{SampledHalf(count), SampledHalf(count)};
    std::array<std::optional<SampledHalf>, 2> ended;
    for (std::uint32_t upto = accuracy.first; !ended[0] || !ended[1]; upto *= 2) {
        for (std::uint32_t h = 0; h < 2; ++h)
            halves[h].go_on(add, seed, h * SampledHalf::kScrambles, upto);
        const bool is_last = 2 * SampledHalf::kScrambles * upto >= accuracy.most;
        for (std::size_t h = 0; h < 2; ++h)
            if (!ended[h] && (is_last || halves[1 - h].is_good(accuracy)))
                ended[h] = halves[h];
    }
    SampledMeans mean{std::vector<double>(count), 0, std::vector<double>(count)};
    for (std::size_t c = 0; c < count; ++c) {
        const double a = ended[0]->mean(c), b = ended[1]->mean(c);
        mean.value[c] = (a + b) / 2;
        mean.noise[c] = (a - b) / 2;
        mean.error = std::max(mean.error, std::sqrt(ended[0]->variance(c) + ended[1]->variance(c)));
    }
    return mean;
}

/// The mean of f(point), N numbers, each point being asked as point(dimension).
template <std::size_t N> struct SampledMean {
    std::array<double, N> value{};
    double error = 0;
    std::array<double, N> noise{};  ///< as Integral's
};

template <std::size_t N, class F>
SampledMean<N> sampled_mean(const F& f, std::uint32_t seed, const SamplingAccuracy& accuracy)
{
    const auto add = [&](const SobolPoint& point, double* sums) {
        const std::array<double, N> v = f(point);
        bool found = false;
        for (std::size_t c = 0; c < N; ++c) {
            sums[c] += v[c];
            found = found || v[c] != 0;
        }
        return found;
    };
    const SampledMeans means = sampled_means(add, N, seed, accuracy);
    SampledMean<N> mean;
    mean.error = means.error;
    std::copy_n(means.value.begin(), N, mean.value.begin());
    std::copy_n(means.noise.begin(), N, mean.noise.begin());
    return mean;
}

/// The mean of what is found at places on a line, for each part of it apart.
/// @param splits ascending, where one part ends and the next begins
/// @param f gives a point's place and what it finds there
template <class F>
std::vector<Integral> sampled_parts(const F& f, const std::vector<double>& splits,
                                    std::uint32_t seed, const SamplingAccuracy& accuracy)
{
    const auto add = [&](const SobolPoint& point, double* sums) {
        const std::pair<double, glm::dvec3> found = f(point);
        const auto part = std::upper_bound(splits.begin(), splits.end(), found.first);
        for (int c = 0; c < 3; ++c)
            sums[3 * (part - splits.begin()) + c] += found.second[c];
        return found.second != glm::dvec3(0);
    };
    const SampledMeans means = sampled_means(add, 3 * (splits.size() + 1), seed, accuracy);
    std::vector<Integral> parts(splits.size() + 1);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        // Each may err by as much as the worst of them, and all together by no more.
        parts[i].error = means.error / std::sqrt(static_cast<double>(parts.size()));
        for (int c = 0; c < 3; ++c) {
            parts[i].value[c] = means.value[3 * i + static_cast<std::size_t>(c)];
            parts[i].noise[c] = means.noise[3 * i + static_cast<std::size_t>(c)];
        }
    }
    return parts;
}

}  // namespace fumarole::study
