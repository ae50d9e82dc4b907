#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

// Adaptive quadrature of colours along a line.

namespace fumarole::study {

/// The largest channel's size: what errors are measured in.
inline double largest(glm::dvec3 v)
{
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

struct Integral {
    glm::dvec3 value{0};
    double error = 0;  ///< estimated, absolute, of the largest channel
    /// Half of what the samples' two independent halves differ by: its square is on the mean the
    /// value's variance. 0 of a quadrature.
    glm::dvec3 noise{0};

    void operator+=(const Integral& other)
    {
        value += other.value;
        error += other.error;
        noise += other.noise;
    }
};

struct Accuracy {
    double relative = 1e-3;  ///< tolerance relative to the largest channel of the whole integral
    double absolute = 0;
    int most_intervals = 4000;  ///< refinement ends there, and the estimate says so
};

/// Gauss and Kronrod's rule of 7 and 15 points over [a, b]. The estimate is the rules' difference,
/// which is the lesser rule's error, sharpened as QUADPACK's (Piessens et al. 1983) where the
/// integrand is smooth. QUADPACK's own is the larger of the two ways: on smoke, a hundred times
/// what the error was.
template <class Integrand> Integral gauss_kronrod(const Integrand& f, double a, double b)
{
    constexpr std::array<double, 8> kNode{
        0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
        0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
        0.586087235467691130294144691693327, 0.405845151377397166906606412076961,
        0.207784955007898467600689403773245, 0.0};
    constexpr std::array<double, 8> kKronrod{
        0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
        0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
        0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
        0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
    constexpr std::array<double, 4> kGauss{
        0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
        0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

    const double middle = (a + b) / 2, half = (b - a) / 2;
    std::array<glm::dvec3, 15> values;
    glm::dvec3 kronrod(0), gauss(0);
    for (std::size_t i = 0; i < 8; ++i) {
        values[i] = f(middle - half * kNode[i]);
        glm::dvec3 pair = values[i];
        if (i < 7) {
            values[14 - i] = f(middle + half * kNode[i]);
            pair += values[14 - i];
        }
        kronrod += kKronrod[i] * pair;
        if (i % 2 == 1)
            gauss += kGauss[i / 2] * pair;
    }
    glm::dvec3 spread(0);
    for (std::size_t i = 0; i < 15; ++i)
        spread += kKronrod[i < 8 ? i : 14 - i] * glm::abs(values[i] - kronrod / 2.0);

    Integral result{kronrod * half, 0};
    for (int c = 0; c < 3; ++c) {
        const double difference = std::abs((kronrod[c] - gauss[c]) * half);
        const double s = std::abs(spread[c] * half);
        double error = difference;
        if (s > 0 && difference > 0)
            error = std::min(error, s * std::pow(200 * difference / s, 1.5));
        result.error = std::max(result.error, error);
    }
    return result;
}

/// The integral between the first and the last of `breaks` (ascending), which also say where the
/// integrand is not smooth. The interval that is worst is halved until the sum is good enough.
template <class Integrand>
Integral integrate(const Integrand& f, const std::vector<double>& breaks, const Accuracy& accuracy)
{
    struct Interval {
        double a, b;
        Integral integral;
        bool operator<(const Interval& other) const
        {
            return integral.error < other.integral.error;
        }
    };
    std::vector<Interval> heap;
    heap.reserve(2 * breaks.size() + 8);
    // The intervals' errors are of any sign, and their estimates are of the worse of two rules:
    // they add up as squares.
    glm::dvec3 value(0);
    double squares = 0;
    const auto square = [](double x) { return x * x; };
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        if (!(breaks[i] < breaks[i + 1]))
            continue;
        heap.push_back({breaks[i], breaks[i + 1], gauss_kronrod(f, breaks[i], breaks[i + 1])});
        value += heap.back().integral.value;
        squares += square(heap.back().integral.error);
    }
    std::make_heap(heap.begin(), heap.end());
    const auto good = [&] {
        return squares <= square(std::max(accuracy.absolute, accuracy.relative * largest(value)));
    };
    double rest = 0;  // of intervals too short to be halved
    while (!good() && !heap.empty() &&
           heap.size() < static_cast<std::size_t>(accuracy.most_intervals)) {
        std::pop_heap(heap.begin(), heap.end());
        const Interval worst = heap.back();
        heap.pop_back();
        const double middle = (worst.a + worst.b) / 2;
        squares = std::max(0.0, squares - square(worst.integral.error));
        if (worst.b - worst.a <= 1e-13 * std::max({std::abs(worst.a), std::abs(worst.b), 1e-300})) {
            rest += worst.integral.error;
            continue;
        }
        value -= worst.integral.value;
        for (const auto& [a, b] : {std::pair(worst.a, middle), std::pair(middle, worst.b)}) {
            const Interval half{a, b, gauss_kronrod(f, a, b)};
            value += half.integral.value;
            squares += square(half.integral.error);
            heap.push_back(half);
            std::push_heap(heap.begin(), heap.end());
        }
    }
    return {value, std::sqrt(squares) + rest};
}

}  // namespace fumarole::study
