// ray_box, step_lattice, depth, shadow and lat_long of glsl/lib against double.

#include <cmath>
#include <numbers>
#include <random>

#include "prepared_frame.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

using RayBox = GlTest;
using StepLattice = GlTest;
using Depth = GlTest;
using ShadowView = GlTest;
using LatLong = GlTest;

struct Interval {
    double begin, end;
    [[nodiscard]] bool empty() const { return begin > end; }
};

Interval ray_box(glm::dvec3 o, glm::dvec3 d, glm::dvec3 low, glm::dvec3 high)
{
    Interval t{-1e30, 1e30};
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0) {
            if (o[axis] < low[axis] || o[axis] > high[axis])
                return {1, -1};
            continue;
        }
        const double a = (low[axis] - o[axis]) / d[axis], b = (high[axis] - o[axis]) / d[axis];
        t = {std::max(t.begin, std::min(a, b)), std::min(t.end, std::max(a, b))};
    }
    return t;
}

TEST_F(RayBox, AgreesWithDouble)
{
    const Kernel kernel(gl(), R"(
#include "lib/ray_box.glsl"
void kernel(int i)
{
    out_data[i] = vec4(ray_box(in_data[4 * i].xyz, in_data[4 * i + 1].xyz, in_data[4 * i + 2].xyz,
                               in_data[4 * i + 3].xyz), 0.0, 0.0);
}
)",
                        4);
    std::vector<glm::vec4> rays;
    const auto add = [&](glm::vec3 o, glm::vec3 d, glm::vec3 low, glm::vec3 high) {
        for (const glm::vec3& v : {o, d, low, high})
            rays.emplace_back(v, 0.0f);
    };
    const glm::vec3 low(-1, -2, -3), high(1, 2, 3);
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f}) {
            glm::vec3 d(0), beside(0);
            d[axis] = sign;
            beside[(axis + 1) % 3] = 10;
            add(glm::vec3(0), d, low, high);        // inside
            add(-20.0f * d, d, low, high);          // in front
            add(20.0f * d, d, low, high);           // behind
            add(beside - 20.0f * d, d, low, high);  // past it
            add(low, d, low, high);                 // on a corner, along an edge
        }
    std::mt19937 random(7);
    std::uniform_real_distribution<float> position(-6, 6), unit(-1, 1);
    for (int i = 0; i < 5000; ++i) {
        glm::vec3 d(unit(random), unit(random), unit(random));
        if (i % 5 == 0)
            d[i % 3] = 0;
        if (i % 10 == 0)
            d[(i + 1) % 3] = 0;
        if (d != glm::vec3(0))
            add({position(random), position(random), position(random)}, d, low, high);
    }
    const std::vector<glm::vec4> t = kernel(rays);
    int hits = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const glm::dvec3 o(rays[4 * i]), d(rays[4 * i + 1]);
        const Interval expected =
            ray_box(o, d, glm::dvec3(rays[4 * i + 2]), glm::dvec3(rays[4 * i + 3]));
        const auto near = [&](double a, double b) {
            return std::abs(a - b) <= 4e-6 * (std::abs(b) + 1);
        };
        if (expected.empty()) {
            // Rounding may turn a near miss into a touch.
            ASSERT_TRUE(t[i].x > t[i].y || near(t[i].x, t[i].y)) << "ray " << i;
        } else if (expected.end - expected.begin > 1e-4) {
            ++hits;
            ASSERT_TRUE(near(t[i].x, expected.begin) && near(t[i].y, expected.end))
                << "ray " << i << ": " << t[i].x << ".." << t[i].y << ", not " << expected.begin
                << ".." << expected.end;
        }
    }
    EXPECT_GT(hits, 500);
}

TEST_F(StepLattice, IsMonotoneEndsExactlyAndIsInverted)
{
    const Kernel kernel(gl(), R"(
#include "lib/step_lattice.glsl"
// in: step (half steps), steps, lambda; range.x, range.y. out: z of it, step_at of that z, of before the range
void kernel(int i)
{
    vec2 range = in_data[2 * i + 1].xy;
    int steps = int(in_data[2 * i].y);
    float lambda = in_data[2 * i].z;
    float octaves = log2(range.y / range.x);
    float z = step_split(in_data[2 * i].x / in_data[2 * i].y, range, octaves, lambda);
    out_data[i] = vec4(z, step_at(z, steps, range, octaves, lambda), step_at(range.x * 0.5, steps, range, octaves, lambda),
                       step_at(range.y * 2.0, steps, range, octaves, lambda));
}
)",
                        2);
    for (const glm::vec2 range : {glm::vec2(0.1f, 1000), glm::vec2(3, 5), glm::vec2(0.01f, 1e5f)})
        for (const float lambda : {0.0f, 0.5f, 0.8f, 1.0f})
            for (const int steps : {1, 2, 7, 64, 1024}) {
                std::vector<glm::vec4> inputs;
                for (int half = 0; half <= 2 * steps; ++half) {
                    inputs.emplace_back(static_cast<float>(half) * 0.5f, steps, lambda, 0);
                    inputs.emplace_back(range, 0, 0);
                }
                const std::vector<glm::vec4> z = kernel(inputs);
                const auto where = [&](int half) {
                    return testing::Message() << range.x << ".." << range.y << ", lambda " << lambda
                                              << ", step " << half * 0.5 << " of " << steps;
                };
                EXPECT_FLOAT_EQ(z.front().x, range.x) << where(0);
                // The exponential end is as right as pow: llvmpipe's to 1e-5. The march ends its
                // last step at the range's end itself.
                EXPECT_NEAR(z.back().x, range.y, (lambda > 0 ? 5e-5 : 2e-7) * range.y)
                    << where(2 * steps);
                for (int half = 0; half <= 2 * steps; ++half) {
                    const double progress = 0.5 * half / steps;
                    const double ratio = double(range.y) / range.x;
                    const double expected =
                        (1 - lambda) * (range.x + progress * (double(range.y) - range.x)) +
                        lambda * range.x * std::pow(ratio, progress);
                    ASSERT_NEAR(z[half].x, expected, 5e-5 * expected) << where(half);
                    if (half > 0) {
                        ASSERT_GT(z[half].x, z[half - 1].x) << where(half);
                    }
                    ASSERT_EQ(z[half].y, std::min(half / 2, steps - 1)) << where(half);
                    ASSERT_EQ(z[half].z, 0) << where(half);
                    ASSERT_EQ(z[half].w, steps - 1) << where(half);
                }
            }
}

/// A host's projection for view_z near..far, in its convention. far 0: infinite.
glm::dmat4 projection(bool perspective, double near, double far, DepthConvention convention)
{
    // NDC depth at near and far.
    double at_near = convention.zero_to_one ? 0 : -1, at_far = 1;
    if (convention.reversed)
        std::swap(at_near, at_far);
    glm::dmat4 p(0.0);
    p[0][0] = p[1][1] = 1.5;
    if (perspective) {
        // n = (a z + b) / z with z = view depth; clip w = -view.z.
        const double b =
            far > 0 ? (at_near - at_far) * near * far / (far - near) : (at_near - at_far) * near;
        const double a = far > 0 ? at_far - b / far : at_far;
        p[2][2] = -a;
        p[3][2] = b;
        p[2][3] = -1;
    } else {
        const double slope = (at_far - at_near) / (far - near);
        p[2][2] = -slope;
        p[3][2] = at_near - slope * near;
        p[3][3] = 1;
    }
    return p;
}

TEST_F(Depth, ViewZAgreesWithDoubleInEveryConvention)
{
    const Kernel kernel(gl(), R"(
#include "lib/depth.glsl"
void kernel(int i) { out_data[i] = vec4(view_z_of(in_data[2 * i].x, in_data[2 * i + 1], in_data[2 * i].y)); }
)",
                        2);
    for (const bool zero_to_one : {false, true})
        for (const bool reversed : {false, true})
            for (const bool perspective : {false, true})
                for (const double far : {0.0, 20.0, 1e4}) {
                    if (far == 0 && !perspective)
                        continue;
                    constexpr double kNear = 0.1;
                    Frame frame;
                    frame.color = {1, {64, 64, 1}};
                    frame.depth = {1, {64, 64, 1}};
                    frame.depth_convention = {zero_to_one, reversed};
                    frame.clip_from_view =
                        projection(perspective, kNear, far, frame.depth_convention);
                    const PreparedFrame prepared =
                        prepare_frame(frame, {}, {.media = {{-1, -1, -9}, {1, 1, -5}}});
                    const Eye& eye = prepared.eye;
                    EXPECT_NEAR(eye.near, kNear, 1e-9);
                    if (far > 0) {
                        EXPECT_NEAR(eye.far, far, 1e-6 * far);
                    } else {
                        EXPECT_GT(eye.far, 1e12);
                    }
                    const shared::FrameParams& params = prepared.params;
                    const glm::vec4 map = params.view_z_from_depth;

                    std::vector<glm::vec4> inputs;
                    std::vector<double> expected;
                    for (double z = kNear; z < (far > 0 ? far : 1e5); z *= 1.3) {
                        const glm::dvec4 clip = frame.clip_from_view * glm::dvec4(0, 0, -z, 1);
                        const double n = clip.z / clip.w;
                        const auto depth = static_cast<float>(zero_to_one ? n : n * 0.5 + 0.5);
                        if (depth == params.sky_depth)
                            continue;  // so far that a float buffer can't tell it from the sky
                        inputs.emplace_back(depth, params.sky_depth, 0, 0);
                        inputs.push_back(map);
                        // What the stored depth means, in double.
                        const double stored = zero_to_one ? depth : 2.0 * depth - 1.0;
                        const glm::dmat4& p = frame.clip_from_view;
                        expected.push_back((p[3][3] * stored - p[3][2]) /
                                           (p[2][3] * stored - p[2][2]));
                    }
                    inputs.emplace_back(params.sky_depth, params.sky_depth, 0, 0);
                    inputs.push_back(map);
                    const std::vector<glm::vec4> z = kernel(inputs);
                    for (std::size_t i = 0; i < expected.size(); ++i) {
                        // Each sum keeps a float's precision of its larger term.
                        const double depth = inputs[2 * i].x;
                        const auto loss = [&](double a, double b) {
                            const double sum = std::abs(a * depth + b);
                            return sum > 0 ? (std::abs(a * depth) + std::abs(b)) / sum : 1.0;
                        };
                        const double tolerance =
                            2.4e-7 * (1 + loss(map.x, map.y) + loss(map.z, map.w));
                        if (tolerance < 0.1) {
                            EXPECT_NEAR(z[i].x, expected[i], tolerance * expected[i])
                                << "zero_to_one " << zero_to_one << ", reversed " << reversed
                                << ", perspective " << perspective << ", far " << far;
                        }
                    }
                    EXPECT_EQ(z.back().x, 1e30f) << "the sky";
                }
}

TEST_F(ShadowView, CubeFaceIsTheLargestAxis)
{
    const Kernel kernel(gl(), R"(
#include "lib/shadow.glsl"
void kernel(int i) { out_data[i] = vec4(cube_face(in_data[i].xyz)); }
)");
    std::vector<glm::vec4> directions;
    for (const float x : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
        for (const float y : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
            for (const float z : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
                directions.emplace_back(x, y, z, 0);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (int i = 0; i < 1000; ++i)
        directions.emplace_back(unit(random), unit(random), unit(random), 0);
    const std::vector<glm::vec4> faces = kernel(directions);
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const int face = static_cast<int>(faces[i].x);
        ASSERT_GE(face, 0);
        ASSERT_LT(face, 6);
        // +x -x +y -y +z -z; an even split of a tie between neighbours is either's.
        const glm::vec3 d(directions[i]);
        const float along = (face % 2 == 0 ? 1.0f : -1.0f) * d[face / 2];
        EXPECT_EQ(along, std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}))
            << d.x << ' ' << d.y << ' ' << d.z << ": face " << face;
    }
}

TEST_F(ShadowView, DepthIsLinearInMetres)
{
    const Kernel kernel(gl(), R"(
#include "lib/shadow.glsl"
void kernel(int i)
{
    vec4 origin = in_data[3 * i], axis = in_data[3 * i + 1];
    ShadowDepth view = ShadowDepth(origin.xyz, origin.w, axis.xyz, axis.w);
    vec3 p = in_data[3 * i + 2].xyz;
    out_data[i] = vec4(shadow_depth(view, p), shadow_bias(view, p), is_sun_view(view), 0.0);
}
)",
                        3);
    const glm::vec4 origin(1, 2, 3, 1.0f / 8);
    const glm::vec4 sun(0, 0, -1, 0.25f), lamp(0, 0, 0, 0.01f);
    const auto values = kernel({origin,
                                sun,
                                {5, 5, 1, 0},  // 2 m on
                                origin,
                                sun,
                                {5, 5, 9, 0},  // before the origin
                                origin,
                                sun,
                                {5, 5, -90, 0},  // past the range
                                origin,
                                lamp,
                                {4, 6, 3, 0},  // 5 m off
                                origin,
                                lamp,
                                {1, 2, 3, 0}});  // on the lamp
    EXPECT_FLOAT_EQ(values[0].x, 0.25f);
    EXPECT_FLOAT_EQ(values[1].x, 0);
    EXPECT_FLOAT_EQ(values[2].x, 1);
    EXPECT_FLOAT_EQ(values[3].x, 0.625f);
    EXPECT_FLOAT_EQ(values[4].x, 0);
    EXPECT_FLOAT_EQ(values[0].y, 0.25f);
    EXPECT_FLOAT_EQ(values[3].y, 0.05f);
    EXPECT_EQ(values[0].z, 1);
    EXPECT_EQ(values[3].z, 0);
}

TEST_F(LatLong, CoordinatesAreBlenders)
{
    const Kernel kernel(gl(), R"(
#include "lib/lat_long.glsl"
void kernel(int i) { out_data[i] = vec4(lat_long_uv(in_data[i].xyz), 0.0, 0.0); }
)");
    std::vector<glm::vec4> directions{
        {0, 0, 1, 0}, {0, 0, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, -1, 0, 0}};
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (int i = 0; i < 500; ++i)
        directions.emplace_back(glm::normalize(glm::vec3(unit(random), unit(random), unit(random))),
                                0);
    const std::vector<glm::vec4> uv = kernel(directions);
    EXPECT_NEAR(uv[0].y, 0, 1e-6);
    EXPECT_NEAR(uv[1].y, 1, 1e-6);
    EXPECT_NEAR(uv[2].x, 0.5, 1e-6);
    EXPECT_NEAR(uv[3].x, 0.25, 1e-6);
    EXPECT_NEAR(uv[4].x, 0.75, 1e-6);
    for (std::size_t i = 2; i < uv.size(); ++i) {
        const glm::dvec3 d(directions[i]);
        EXPECT_NEAR(uv[i].x, 0.5 - std::atan2(d.y, d.x) / (2 * std::numbers::pi), 2e-5);
        // GL promises acos to a few thousandths of a radian near its ends on some GPUs; a texel of
        // a map 1024 rows high is 1e-3.
        EXPECT_NEAR(uv[i].y, std::acos(d.z) / std::numbers::pi, 1e-4);
    }
}

}  // namespace
}  // namespace fumarole::test
