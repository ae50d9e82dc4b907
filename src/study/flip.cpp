// LDR-FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, FLIP: A
// Difference Evaluator for Alternating Images. Written from the paper; the symbols are its own.
//
//   colour   encoded sRGB -> YCxCz -> what the eye resolves (contrast sensitivity filters)
//            -> L*a*b*, chroma less in the dark (Hunt) -> HyAB distance -> 0..1
//   feature  luma -> edges and points (Gaussian derivatives) -> how much more of them -> 0..1
//   FLIP     colour ^ (1 - feature): a lost or added edge makes a colour difference worse

#include "study/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <tbb/parallel_for.h>

#include "study/srgb.h"
#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

// The paper's exponents, and where the colour difference's two linear pieces meet.
constexpr float kColorExponent = 0.7f;   // q_c
constexpr float kKneeAt = 0.4f;          // p_c, share of the largest colour difference
constexpr float kKneeTo = 0.95f;         // p_t, what that share becomes
constexpr float kFeatureWidth = 0.082f;  // w [degrees], width of an edge that the eye detects

/// A picture of one channel, rows from the top.
using Plane = std::vector<float>;

struct Size {
    int width, height;
    [[nodiscard]] std::size_t pixels() const
    {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
};

/// Taps of a filter over -radius..radius, of odd length.
using Kernel = std::vector<float>;

template <class F> void for_each_row(Size size, F&& row)
{
    tbb::parallel_for(0, size.height, row);
}

/// The border's pixels go on beyond it, so that the picture's frame is no edge.
Plane filter_rows(const Plane& in, Size size, const Kernel& kernel)
{
    const int radius = static_cast<int>(kernel.size() / 2);
    Plane out(size.pixels(), 0.0f);
    for_each_row(size, [&](int y) {
        const auto width = static_cast<std::size_t>(size.width);
        const float* from = in.data() + static_cast<std::size_t>(y) * width;
        float* to = out.data() + static_cast<std::size_t>(y) * width;
        std::vector<float> padded(width + 2 * static_cast<std::size_t>(radius));
        std::fill_n(padded.begin(), radius, from[0]);
        std::copy_n(from, width, padded.begin() + radius);
        std::fill_n(padded.end() - radius, radius, from[width - 1]);
        for (std::size_t k = 0; k < kernel.size(); ++k) {
            for (std::size_t x = 0; x < width; ++x) {
                to[x] += kernel[k] * padded[x + k];
            }
        }
    });
    return out;
}

Plane filter_columns(const Plane& in, Size size, const Kernel& kernel)
{
    const int radius = static_cast<int>(kernel.size() / 2);
    Plane out(size.pixels(), 0.0f);
    for_each_row(size, [&](int y) {
        const auto width = static_cast<std::size_t>(size.width);
        float* to = out.data() + static_cast<std::size_t>(y) * width;
        for (std::size_t k = 0; k < kernel.size(); ++k) {
            const int row = std::clamp(y + static_cast<int>(k) - radius, 0, size.height - 1);
            const float* from = in.data() + static_cast<std::size_t>(row) * width;
            for (std::size_t x = 0; x < width; ++x) {
                to[x] += kernel[k] * from[x];
            }
        }
    });
    return out;
}

// ------------------------------------------------------------------------------------- colour

/// Linear sRGB to XYZ over the white's XYZ (IEC 61966-2-1, D65), so that greys are equal triples.
const glm::mat3& xyz_from_rgb()
{
    static const glm::mat3 matrix = [] {
        glm::mat3 m(0.4124f, 0.2126f, 0.0193f, 0.3576f, 0.7152f, 0.1192f, 0.1805f, 0.0722f,
                    0.9505f);
        const glm::vec3 white = m * glm::vec3(1);
        for (int column = 0; column < 3; ++column) {
            m[column] /= white;
        }
        return m;
    }();
    return matrix;
}

const glm::mat3& rgb_from_xyz()
{
    static const glm::mat3 matrix = glm::inverse(xyz_from_rgb());
    return matrix;
}

/// CIE 1976 L*a*b* of XYZ over white, with the Hunt effect: dark colours look less colourful, so a*
/// and b* are weighted by L*.
glm::vec3 hunt_lab(glm::vec3 xyz)
{
    constexpr float kDelta = 6.0f / 29.0f;
    const auto f = [](float t) {
        return t > kDelta * kDelta * kDelta ? std::cbrt(t)
                                            : t / (3 * kDelta * kDelta) + 4.0f / 29.0f;
    };
    const float fx = f(xyz.x), fy = f(xyz.y), fz = f(xyz.z);
    const float lightness = 116 * fy - 16;
    const float hunt = 0.01f * lightness;
    return {lightness, hunt * 500 * (fx - fy), hunt * 200 * (fy - fz)};
}

/// Abasi, Amani Tehran, Fairchild 2020: city block between lightness and chroma, made for large
/// differences of colour.
float hyab(glm::vec3 a, glm::vec3 b)
{
    return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// A luma and two chroma planes. YCxCz but for its factors and its offset, which a filter whose
/// taps sum to one leaves as they are: Y, X - Y, Y - Z, each over white.
using Opponent = std::array<Plane, 3>;

Opponent opponent(std::span<const float> encoded, Size size)
{
    Opponent planes;
    for (Plane& plane : planes) {
        plane.resize(size.pixels());
    }
    for_each_row(size, [&](int y) {
        const auto width = static_cast<std::size_t>(size.width);
        for (std::size_t i = static_cast<std::size_t>(y) * width, end = i + width; i < end; ++i) {
            const glm::vec3 rgb(srgb_decode(encoded[3 * i]), srgb_decode(encoded[3 * i + 1]),
                                srgb_decode(encoded[3 * i + 2]));
            const glm::vec3 xyz = xyz_from_rgb() * rgb;
            planes[0][i] = xyz.y;
            planes[1][i] = xyz.x - xyz.y;
            planes[2][i] = xyz.y - xyz.z;
        }
    });
    return planes;
}

/// One Gaussian of a contrast sensitivity function, in space: a sqrt(pi / b) exp(-pi^2 x^2 / b),
/// x in degrees.
struct Lobe {
    float a, b;
};

/// The paper's table of contrast sensitivity, after Johnson and Fairchild 2003: of luma, red-green,
/// blue-yellow. Only the last needs two Gaussians.
constexpr std::array<std::array<Lobe, 2>, 3> kSensitivity = {{
    {{{1, 0.0047f}, {0, 1e-5f}}},
    {{{1, 0.0053f}, {0, 1e-5f}}},
    {{{34.1f, 0.04f}, {13.5f, 0.025f}}},
}};
constexpr float kWidestLobe = 0.04f;

/// In two dimensions each Gaussian separates, and their sum is a sum of separable filters. All taps
/// together sum to one.
Plane filter_sensitivity(const Plane& in, Size size, const std::array<Lobe, 2>& lobes, float ppd)
{
    constexpr float kPi = std::numbers::pi_v<float>;
    const float widest_sigma = std::sqrt(kWidestLobe / (2 * kPi * kPi));
    const int radius = static_cast<int>(std::ceil(3 * widest_sigma * ppd));

    std::array<Kernel, 2> kernels;
    std::array<float, 2> weights{};
    float sum = 0;
    for (std::size_t i = 0; i < lobes.size(); ++i) {
        float taps = 0;
        for (int k = -radius; k <= radius; ++k) {
            const float x = static_cast<float>(k) / ppd;
            kernels[i].push_back(std::exp(-kPi * kPi * x * x / lobes[i].b));
            taps += kernels[i].back();
        }
        for (float& tap : kernels[i]) {
            tap /= taps;
        }
        weights[i] = lobes[i].a * std::sqrt(kPi / lobes[i].b) * taps * taps;
        sum += weights[i];
    }

    Plane out(size.pixels(), 0.0f);
    for (std::size_t i = 0; i < lobes.size(); ++i) {
        if (weights[i] == 0) {
            continue;
        }
        const Plane blurred = filter_columns(filter_rows(in, size, kernels[i]), size, kernels[i]);
        for (std::size_t p = 0; p < out.size(); ++p) {
            out[p] += weights[i] / sum * blurred[p];
        }
    }
    return out;
}

std::vector<glm::vec3> perceived(const Opponent& picture, Size size, float ppd)
{
    Opponent seen;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        seen[i] = filter_sensitivity(picture[i], size, kSensitivity[i], ppd);
    }
    std::vector<glm::vec3> lab(size.pixels());
    for_each_row(size, [&](int y) {
        const auto width = static_cast<std::size_t>(size.width);
        for (std::size_t i = static_cast<std::size_t>(y) * width, end = i + width; i < end; ++i) {
            const glm::vec3 xyz(seen[1][i] + seen[0][i], seen[0][i], seen[0][i] - seen[2][i]);
            // Filters of different width can leave the screen's gamut.
            const glm::vec3 rgb = glm::clamp(rgb_from_xyz() * xyz, 0.0f, 1.0f);
            lab[i] = hunt_lab(xyz_from_rgb() * rgb);
        }
    });
    return lab;
}

/// The largest distance a screen can show is between its green and its blue.
float largest_color_difference()
{
    static const float largest = std::pow(hyab(hunt_lab(xyz_from_rgb() * glm::vec3(0, 1, 0)),
                                               hunt_lab(xyz_from_rgb() * glm::vec3(0, 0, 1))),
                                          kColorExponent);
    return largest;
}

/// 0..1: large differences are squeezed together, since beyond a point they all look large.
float color_difference(glm::vec3 a, glm::vec3 b)
{
    const float largest = largest_color_difference();
    const float knee = kKneeAt * largest;
    const float difference = std::pow(hyab(a, b), kColorExponent);
    if (difference < knee) {
        return kKneeTo * difference / knee;
    }
    return std::min(1.0f, kKneeTo + (1 - kKneeTo) * (difference - knee) / (largest - knee));
}

// ------------------------------------------------------------------------------------ feature

/// A Gaussian and its derivatives in one dimension. The derivatives' positive taps sum to 1 and the
/// negative ones to -1, so a filter answers 1 to the strongest edge or point.
struct FeatureKernels {
    Kernel blur, edge, point;
};

void balance(Kernel& kernel)
{
    float positive = 0, negative = 0;
    for (const float tap : kernel) {
        (tap > 0 ? positive : negative) += tap;
    }
    for (float& tap : kernel) {
        tap /= tap > 0 ? positive : -negative;
    }
}

FeatureKernels feature_kernels(float ppd)
{
    const float sigma = 0.5f * kFeatureWidth * ppd;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    FeatureKernels kernels;
    float sum = 0;
    for (int k = -radius; k <= radius; ++k) {
        const auto x = static_cast<float>(k);
        const float g = std::exp(-x * x / (2 * sigma * sigma));
        kernels.blur.push_back(g);
        kernels.edge.push_back(-x * g);
        kernels.point.push_back((x * x / (sigma * sigma) - 1) * g);
        sum += g;
    }
    for (float& tap : kernels.blur) {
        tap /= sum;
    }
    balance(kernels.edge);
    balance(kernels.point);
    return kernels;
}

struct Features {
    Plane edge, point;  ///< lengths of the gradient and of the second derivatives, 0..sqrt(2)
};

Plane length(const Plane& x, const Plane& y)
{
    Plane out(x.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
    }
    return out;
}

Features features(const Plane& luma, Size size, const FeatureKernels& kernels)
{
    const Plane blurred = filter_rows(luma, size, kernels.blur);
    return {
        .edge = length(filter_columns(filter_rows(luma, size, kernels.edge), size, kernels.blur),
                       filter_columns(blurred, size, kernels.edge)),
        .point = length(filter_columns(filter_rows(luma, size, kernels.point), size, kernels.blur),
                        filter_columns(blurred, size, kernels.point))};
}

void check(std::span<const float> test, std::span<const float> reference, int width, int height,
           float ppd)
{
    const auto expected = width > 0 && height > 0 ? Size{width, height}.pixels() * 3 : 0;
    if (expected == 0 || test.size() != expected || reference.size() != expected) {
        throw Error(fmt::format("FLIP needs two pictures of {} x {} pixels with R, G, B; got {} "
                                "and {} values",
                                width, height, test.size(), reference.size()));
    }
    if (!(ppd >= 4 && ppd <= 1000)) {
        throw Error(fmt::format("FLIP: {} pixels per degree are outside 4..1000; a desk's screen "
                                "has about 67",
                                ppd));
    }
    const auto is_nan = [](float value) { return std::isnan(value); };
    if (std::any_of(test.begin(), test.end(), is_nan) ||
        std::any_of(reference.begin(), reference.end(), is_nan)) {
        throw Error("FLIP: a picture has a NaN, which no screen shows; mend it first");
    }
}

}  // namespace

Flip flip(std::span<const float> test, std::span<const float> reference, int width, int height,
          float pixels_per_degree)
{
    check(test, reference, width, height, pixels_per_degree);
    const Size size{width, height};
    const FeatureKernels kernels = feature_kernels(pixels_per_degree);
    const Opponent test_planes = opponent(test, size);
    const Opponent reference_planes = opponent(reference, size);
    const std::vector<glm::vec3> test_lab = perceived(test_planes, size, pixels_per_degree);
    const std::vector<glm::vec3> reference_lab =
        perceived(reference_planes, size, pixels_per_degree);
    const Features test_features = features(test_planes[0], size, kernels);
    const Features reference_features = features(reference_planes[0], size, kernels);

    Flip result;
    result.map.resize(size.pixels());
    for_each_row(size, [&](int y) {
        const auto columns = static_cast<std::size_t>(width);
        for (std::size_t i = static_cast<std::size_t>(y) * columns, end = i + columns; i < end;
             ++i) {
            const float color = color_difference(test_lab[i], reference_lab[i]);
            const float more =
                std::max(std::abs(test_features.edge[i] - reference_features.edge[i]),
                         std::abs(test_features.point[i] - reference_features.point[i]));
            // The square root is q_f, 0.5. Rounding alone can pass 1.
            const float feature = std::min(1.0f, std::sqrt(more / std::numbers::sqrt2_v<float>));
            result.map[i] = std::pow(color, 1 - feature);
        }
    });
    double sum = 0;
    for (const float value : result.map) {
        sum += static_cast<double>(value);
    }
    result.mean = sum / static_cast<double>(result.map.size());
    return result;
}

Flip flip_of_radiance(std::span<const float> test, std::span<const float> reference, int width,
                      int height, const Display& display, float pixels_per_degree)
{
    check(test, reference, width, height, pixels_per_degree);
    const auto shown = [&](std::span<const float> radiance) {
        std::vector<float> encoded(radiance.size());
        const Size size{width, height};
        for_each_row(size, [&](int y) {
            const auto columns = static_cast<std::size_t>(width);
            for (std::size_t i = static_cast<std::size_t>(y) * columns, end = i + columns; i < end;
                 ++i) {
                const glm::vec3 rgb = write::display_transform(
                    {radiance[3 * i], radiance[3 * i + 1], radiance[3 * i + 2]}, display);
                std::copy_n(&rgb.x, 3, encoded.begin() + static_cast<std::ptrdiff_t>(3 * i));
            }
        });
        return encoded;
    };
    return flip(shown(test), shown(reference), width, height, pixels_per_degree);
}

}  // namespace fumarole::study
