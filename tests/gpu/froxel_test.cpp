// glsl/lib/froxel.glsl and tricubic.glsl against double, and how a view's history is weighed.

#include <cmath>
#include <glm/gtc/packing.hpp>
#include <random>

#include "pass/froxels.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

class FroxelLib : public GlTest {};

struct Spacing {
    const char* name;
    glm::vec4 params;  ///< SLICES_*, rate, exp2(rate) - 1
    double (*t)(double s);
};

const Spacing kSpacings[] = {
    {"linear", {0, 1, 1, 0}, [](double s) { return s; }},
    // Eevee's of October 2017 at distribution 0.8, as it was written: z = (exp2(s / d) - a) / b.
    {"exponential",
     {1, 1.25, std::exp2(1.25) - 1, 0},
     [](double s) {
         const double d = 0.8, near = 1, far = 2;
         const double a = (far - near * std::exp2(1 / d)) / (far - near);
         const double b = (1 - a) / near;
         return (std::exp2(s / d) - a) / b - 1;
     }},
    {"steep",
     {1, 25, std::exp2(25.0f) - 1, 0},
     [](double s) { return std::expm1(25 * s * std::log(2)) / std::expm1(25 * std::log(2)); }},
    {"power", {2, 5, 0, 0}, [](double s) { return std::pow(s, 5); }},
};

TEST_F(FroxelLib, SlicesAreWhereTheirSpacingSaysAndComeBack)
{
    const Kernel kernel(gl(), R"(
#include "lib/froxel.glsl"
void kernel(int i)
{
    vec4 at = in_data[3 * i], range = in_data[3 * i + 1], spacing = in_data[3 * i + 2];
    SliceParams slices =
        SliceParams(range.x, range.y, range.z, at.y, int(spacing.x), spacing.y, spacing.z, 1.0);
    float z = slice_view_z(at.x, slices);
    out_data[i] = vec4(z, slice_at(z, slices), slices_before(z, slices), 0.0);
}
)",
                        3);
    constexpr int kSlices = 64;
    for (const Spacing& spacing : kSpacings)
        for (const glm::dvec2 range :
             {glm::dvec2(0.1, 40), glm::dvec2(6, 17), glm::dvec2(500, 501)}) {
            std::vector<glm::vec4> in;
            for (int k = 0; k <= 4 * kSlices; ++k) {
                in.emplace_back(k / (4.0 * kSlices), kSlices, 0, 0);
                in.emplace_back(range.x, range.y, range.y - range.x, 0);
                in.push_back(spacing.params);
            }
            const std::vector<glm::vec4> out = kernel(in);
            const double length = range.y - range.x;
            // A 32-bit depth of 500 m is 3e-5 m.
            const double rounding = 2e-6 * length + 1.2e-7 * range.y;
            for (int k = 0; k <= 4 * kSlices; ++k) {
                const double s = k / (4.0 * kSlices);
                ASSERT_NEAR(out[k].x, range.x + length * spacing.t(s), rounding)
                    << spacing.name << " at " << s;
                if (k > 0) {
                    ASSERT_GE(out[k].x, out[k - 1].x) << spacing.name;
                }
                // Backwards, an error of z counts by how thin the slices are.
                const double slope =
                    (spacing.t(std::min(s + 0.01, 1.0)) - spacing.t(std::max(s - 0.01, 0.0))) /
                    0.02;
                if (slope * length > 1e3 * rounding) {
                    ASSERT_NEAR(out[k].y, s, 1e-5 + 4 * rounding / (slope * length))
                        << spacing.name;
                }
            }
            EXPECT_NEAR(out.front().z, 0, 1e-6);
            EXPECT_NEAR(out.back().z, kSlices, 1e-6);
        }
}

// Depth counted in slices is linear in depth within a slice, whatever the spacing.
TEST_F(FroxelLib, HalfTheDepthOfASliceIsHalfASlice)
{
    const Kernel kernel(gl(), R"(
#include "lib/froxel.glsl"
void kernel(int i)
{
    vec4 spacing = in_data[2 * i + 1];
    SliceParams slices = SliceParams(2.0, 12.0, 10.0, 8.0, int(spacing.x), spacing.y, spacing.z, 1.0);
    float k = in_data[2 * i].x, f = in_data[2 * i].y;
    float z = mix(slice_view_z(k / 8.0, slices), slice_view_z((k + 1.0) / 8.0, slices), f);
    out_data[i] = vec4(slices_before(z, slices), slices_before(1.0, slices), slices_before(1e30, slices), 0.0);
}
)",
                        2);
    for (const Spacing& spacing : kSpacings) {
        if (std::string_view(spacing.name) == "steep")
            continue;  // its first slices are thinner than a 32-bit depth tells
        std::vector<glm::vec4> in;
        for (int k = 0; k < 8; ++k)
            for (const double f : {0.25, 0.5, 0.75}) {
                in.emplace_back(k, f, 0, 0);
                in.push_back(spacing.params);
            }
        const std::vector<glm::vec4> out = kernel(in);
        for (std::size_t i = 0; i < out.size(); ++i) {
            const double least = spacing.t(1.0 / 8) * 10;  // the thinnest slice [m]
            ASSERT_NEAR(out[i].x, in[2 * i].x + in[2 * i].y, 1e-5 + 2e-6 / least) << spacing.name;
            EXPECT_EQ(out[i].y, 0) << "before the grid";
            EXPECT_EQ(out[i].z, 8) << "behind it";
        }
    }
}

TEST_F(FroxelLib, TricubicInEightFetchesIsTheSumOfSixtyFour)
{
    constexpr glm::ivec3 kSize(6, 5, 7);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<float> texels(std::size_t{6} * 5 * 7 * 4);
    for (float& t : texels)
        t = uniform(random);
    gl::Texture volume =
        gl::Texture::make_3d(gl(), "volume", kSize, GL_RGBA32F, gl::Filter::linear);
    volume.upload(GL_RGBA, GL_FLOAT, texels.data());
    gl()->BindTextureUnit(0, volume.id());
    const Kernel kernel(gl(), R"(
#include "lib/tricubic.glsl"
layout(binding = 0) uniform sampler3D u_volume_tx;
void kernel(int i) { out_data[i] = texture_tricubic(u_volume_tx, in_data[i].xyz); }
)");
    std::vector<glm::vec4> in;
    for (int i = 0; i < 300; ++i)
        in.emplace_back(uniform(random), uniform(random), uniform(random), 0);
    const std::vector<glm::vec4> out = kernel(in);
    const auto weight = [](double x) {  // the cubic B-spline
        x = std::abs(x);
        return x < 1   ? (4 - 6 * x * x + 3 * x * x * x) / 6
               : x < 2 ? (2 - x) * (2 - x) * (2 - x) / 6
                       : 0;
    };
    for (std::size_t n = 0; n < in.size(); ++n) {
        const glm::dvec3 at = glm::dvec3(in[n]) * glm::dvec3(kSize) - 0.5;
        const glm::ivec3 base(glm::floor(at));
        double sum = 0, weights = 0;
        for (int k = 0; k < 64; ++k) {
            const glm::ivec3 texel = base + glm::ivec3(k & 3, (k >> 2) & 3, k >> 4) - 1;
            const glm::dvec3 d = at - glm::dvec3(texel);
            const double w = weight(d.x) * weight(d.y) * weight(d.z);
            const glm::ivec3 c = glm::clamp(texel, glm::ivec3(0), kSize - 1);
            sum += w * texels[std::size_t(((c.z * kSize.y + c.y) * kSize.x + c.x) * 4)];
            weights += w;
        }
        ASSERT_NEAR(weights, 1, 1e-12);
        // A GPU's filter weights have 8 bits.
        ASSERT_NEAR(out[n].x, sum, gl().capabilities().software ? 1e-5 : 8.0 / 256) << n;
    }
}

// glsl/lib/dithered_half.glsl: one of the two halves around a value, and the value on average,
// wherever it lies.
TEST_F(FroxelLib, ADitheredHalfIsTheValueOnAverage)
{
    const Kernel kernel(gl(), R"(
#include "lib/dithered_half.glsl"
void kernel(int i)
{
    const uint kFrames = 4096u;
    float value = in_data[i].x, reference = in_data[i].y;
    vec4 seen = vec4(0.0, 1e38, -1e38, 0.0);  // mean of the differences from a reference, least, most
    for (uint frame = 0u; frame < kFrames; ++frame) {
        float half_float = dithered_half(value, dither_of_frame(uvec2(12345u * uint(i), 0u), frame).x);
        seen.x += (half_float - reference) / float(kFrames);
        seen.y = min(seen.y, half_float);
        seen.z = max(seen.z, half_float);
    }
    out_data[i] = seen;
}
)");
    struct Place {
        float value, below, unit;  ///< unit in the last place of the half below
    };
    std::vector<Place> places;
    for (const float value : {1.0f, 1.0003f, 1.99999f, 0.1f, 3.3e4f, 6.5e4f, 6.2e-5f, 6.0976e-5f,
                              6.1e-5f, 1e-6f, 3e-8f, 1e-9f, 0.0f, -0.7f, -2e-7f}) {
        const double unit = std::exp2(
            std::max(std::floor(std::log2(std::max(std::abs(value), 1e-30f))), -14.0f) - 10);
        places.push_back(
            {value, static_cast<float>(std::floor(value / unit) * unit), static_cast<float>(unit)});
    }
    std::vector<glm::vec4> in;
    for (const Place& place : places)
        in.emplace_back(place.value, place.below, 0, 0);
    in.emplace_back(65519.0f, 65504.0f, 0, 0);
    in.emplace_back(1e30f, 65504.0f, 0, 0);
    const std::vector<glm::vec4> out = kernel(in);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Place& place = places[i];
        EXPECT_NEAR(out[i].x / place.unit, (place.value - place.below) / place.unit, 2e-3)
            << place.value << ": 4096 frames are spread to a few in 4096";
        EXPECT_GE(out[i].y, place.below) << place.value;
        EXPECT_LE(out[i].z, place.below + place.unit) << place.value;
        for (const float half_float : {out[i].y, out[i].z})
            EXPECT_EQ(glm::unpackHalf1x16(glm::packHalf1x16(half_float)), half_float)
                << place.value;
        EXPECT_EQ(out[i].z > out[i].y, place.value != place.below) << place.value;
    }
    for (std::size_t i = places.size(); i < in.size(); ++i)
        EXPECT_EQ(glm::vec3(out[i]), glm::vec3(0, 65504, 65504)) << "no infinity";
}

using pass::HistoryUse;

TEST(HistoryWeight, CountsEveryFrameTheSameWhileNothingMoves)
{
    pass::HistoryWeight weight;
    EXPECT_EQ(weight.next(HistoryUse::first, 0.95f), 0);
    for (int n = 2; n < 500; ++n)
        ASSERT_FLOAT_EQ(weight.next(HistoryUse::still, 0.95f), 1 - 1.0f / static_cast<float>(n));
    EXPECT_EQ(weight.next(HistoryUse::cut, 0.95f), 0) << "and starts over";
    EXPECT_FLOAT_EQ(weight.next(HistoryUse::still, 0.95f), 0.5f);
}

TEST(HistoryWeight, IsTheOneAskedForInMotionAndUntilMotionHasFaded)
{
    pass::HistoryWeight weight;
    weight.next(HistoryUse::first, 0.9f);
    float w = 0;
    for (int n = 2; n < 30; ++n) {
        w = weight.next(HistoryUse::moved, 0.9f);
        ASSERT_NEAR(w, std::min(1 - 1.0 / n, 0.9), 1e-6) << n;
    }
    // 0.9^44 < 1 %
    double left = 0.9;
    int frames = 0;
    while ((w = weight.next(HistoryUse::still, 0.9f)) < 0.9001f && frames < 1000) {
        left *= double(w);
        ++frames;
    }
    EXPECT_NEAR(frames, 44, 2);
    EXPECT_NEAR(left, 0.01, 0.002);
    for (int n = 1; n < 100; ++n)
        w = weight.next(HistoryUse::still, 0.9f);
    EXPECT_NEAR(w, 1 - 1.0 / 110, 1e-3) << "then frames count again";
}

}  // namespace
}  // namespace fumarole::test
