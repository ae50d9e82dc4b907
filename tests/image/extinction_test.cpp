// Transmittance and emission against closed forms: what a pixel sees is a matter of its own ray's
// length in the medium, at the middle of the picture and at its corners, at every layer size.

#include <cmath>
#include <fmt/format.h>

#include "image_test.h"

namespace fumarole::test {
namespace {

using Projection = Camera::Projection;

struct View {
    const char* name;
    Projection projection;
    int resolution;
    Settings::Format format;
    Settings::Mode mode = Settings::Mode::raymarch;
};

constexpr View kViews[] = {
    {"perspective_full", Projection::perspective, 1, Settings::Format::rgba32f},
    {"perspective_half", Projection::perspective, 2, Settings::Format::rgba32f},
    {"perspective_quarter", Projection::perspective, 4, Settings::Format::rgba32f},
    {"orthographic_full", Projection::orthographic, 1, Settings::Format::rgba32f},
    {"orthographic_half", Projection::orthographic, 2, Settings::Format::rgba32f},
    {"perspective_half_f16", Projection::perspective, 2, Settings::Format::rgba16f},
    {"froxel_perspective", Projection::perspective, 1, Settings::Format::rgba32f,
     Settings::Mode::froxel},
    {"froxel_orthographic", Projection::orthographic, 1, Settings::Format::rgba32f,
     Settings::Mode::froxel},
};

std::string name_of(const testing::TestParamInfo<View>& info)
{
    return info.param.name;
}

void PrintTo(const View& view, std::ostream* out)
{
    *out << view.name;
}

/// Looks along -y through a slab that is wider than the picture. 40 degrees high: the corner's ray
/// is 1.13 times as long as the middle's.
Scene slab_scene(Projection projection, int size = 32)
{
    Scene scene = empty_scene(size);
    scene.camera.vfov_deg = 40;
    scene.camera.projection = projection;
    scene.camera.ortho_height = 3;
    return scene;
}

constexpr glm::dvec3 kSlabMin(-10, -6, -10), kSlabMax(10, -4, 10);

BoxMedium slab(glm::vec3 sigma_a)
{
    BoxMedium box;
    box.min = kSlabMin;
    box.max = kSlabMax;
    box.sigma_a = sigma_a;
    return box;
}

class Extinction : public ImageTest, public testing::WithParamInterface<View> {
protected:
    static Settings settings()
    {
        Settings s = plain_settings(GetParam().resolution);
        s.format = GetParam().format;
        s.mode = GetParam().mode;
        s.tile = 1;
        return s;
    }
    /// What the format itself may take, relative to values of about 1, over `rounding` of 32-bit
    /// arithmetic.
    static double tolerance(double rounding)
    {
        return GetParam().format == Settings::Format::rgba16f ? rounding + std::ldexp(1, -11)
                                                              : rounding;
    }
    /// `exact` is how near the picture must come to exact samples, interpolated as the resolve
    /// does. Against the truth at each pixel, the interpolation itself is allowed: at a corner no
    /// texel lies further out, so the pixel takes the value of the last one, (resolution - 1) / 2
    /// pixels further in along each axis; elsewhere the field's curvature costs less than that
    /// here.
    static void expect_field(const Scene& scene, const Image& actual, const PictureField& field,
                             double exact, std::string_view why)
    {
        const int resolution = GetParam().resolution;
        const Image samples = resolved(scene, resolution, field);
        EXPECT_TRUE(images_near(actual, samples, tolerance(exact), tolerance(exact), why));
        const Image truth = ideal(scene, field);
        double corner = 0;
        for (const bool right : {false, true})
            for (const bool bottom : {false, true}) {
                const auto in_from_corner = [&](double pixels) {
                    return field({right ? actual.width - pixels : pixels,
                                  bottom ? actual.height - pixels : pixels});
                };
                const glm::dvec3 d =
                    glm::abs(in_from_corner(0.5) - in_from_corner(0.5 * resolution));
                corner = std::max({corner, d.x, d.y, d.z});
            }
        const double allowed = tolerance(exact) + 1.1 * corner;
        EXPECT_TRUE(images_near(actual, truth, allowed, tolerance(exact) + corner / 3,
                                "the above, and what the first texel of a corner is off"));
        const int middle = actual.width / 2;
        figure("error at the middle",
               std::abs(actual.at(middle, middle, 0) - truth.at(middle, middle, 0)));
        figure("error at the corner", std::abs(actual.at(0, 0, 0) - truth.at(0, 0, 0)));
        figure("error against resolved samples", max_difference(actual, samples));
    }
};

TEST_P(Extinction, UniformSlabIsBeerLambertAlongTheRay)
{
    Scene scene = slab_scene(GetParam().projection);
    constexpr glm::dvec3 kSigma(0.05, 0.4, 2.0);
    scene.media = {slab(kSigma)};
    const PictureField truth = [&](glm::dvec2 at) {
        return glm::exp(-kSigma * box_segment(ray_at(scene, at), kSlabMin, kSlabMax).length());
    };
    const Still still = render(scene, settings());
    expect_field(scene, picture_of(still, still.transmittance), truth, 5e-6,
                 "64 factors of exp in 32-bit floats");
    // The corner's ray is longer, and that shows: a corner that forgets it is 0.04 too bright.
    EXPECT_LT(pixel(still.transmittance, 32, 0, 0).g,
              pixel(still.transmittance, 32, 16, 16).g + 1e-4f);
    for (const float s : still.scattering)
        ASSERT_EQ(s, 0.0f) << "a medium that only absorbs adds no light";
}

TEST_P(Extinction, LinearRampOfAGrid)
{
    // density k * (j + 1) along y, 0.25 m a voxel: linear between voxels and on their outside too,
    // up to the last layer, past which it falls to 0 within a voxel.
    constexpr int kVoxels = 16;
    constexpr double kVoxel = 0.25, kSlope = 0.05;
    const glm::dmat4 world_from_index(kVoxel, 0, 0, 0, 0, kVoxel, 0, 0, 0, 0, kVoxel, 0,
                                      -23.5 * kVoxel, -8, -23.5 * kVoxel, 1);
    GridMedium ramp;
    ramp.density =
        make_grid({6, 2, 6}, world_from_index, [](glm::ivec3 v) { return kSlope * (v.y + 1); });
    ramp.sigma_s_per_density = glm::vec3(0);
    ramp.sigma_a_per_density = {1.0f, 0.5f, 0.0f};
    Scene scene = slab_scene(GetParam().projection);
    scene.media = {ramp};
    // The triangle's area: base kVoxels + 1 voxels, height kSlope * kVoxels.
    const double column = kVoxel * kSlope * kVoxels * (kVoxels + 1) / 2.0;
    const PictureField truth = [&](glm::dvec2 at) {
        const double slant = 1 / std::abs(ray_at(scene, at).direction.y);
        return glm::exp(-glm::dvec3(ramp.sigma_a_per_density) * column * slant);
    };
    const Still still = render(scene, settings());
    // Midpoints are exact on a linear field but for the step that holds the kink, whose slopes
    // differ by kSlope * 17 a voxel: at most that over kVoxel, * ds^2 / 8. The longest of 64 steps
    // over 4..8 m is 4.25 / 64 * (0.2 + 0.8 * 1.4) = 0.09 m.
    const double kink = kSlope * 17 / kVoxel * 0.09 * 0.09 / 8 * 1.13;
    expect_field(scene, picture_of(still, still.transmittance), truth, kink,
                 "one step holds the ramp's kink; texel coordinates have 8 bits between voxels");
    for (std::size_t i = 2; i < still.transmittance.size(); i += 3)
        ASSERT_EQ(still.transmittance[i], 1.0f) << "a channel of zero extinction stays as it is";
}

TEST_P(Extinction, EmissionAloneIsItsLength)
{
    Scene scene = slab_scene(GetParam().projection);
    BoxMedium glow = slab(glm::vec3(0));
    glow.emission = {0.3f, 0.1f, 0.02f};
    scene.media = {glow};
    const PictureField truth = [&](glm::dvec2 at) {
        return glm::dvec3(glow.emission) *
               box_segment(ray_at(scene, at), kSlabMin, kSlabMax).length();
    };
    const Still still = render(scene, settings());
    expect_field(scene, picture_of(still, still.scattering), truth, 3e-6,
                 "64 sums in 32-bit floats");
    for (const float t : still.transmittance)
        ASSERT_EQ(t, 1.0f) << "nothing is absorbed";
}

TEST_P(Extinction, EmissionWithAbsorptionAndAChannelWithout)
{
    Scene scene = slab_scene(GetParam().projection);
    BoxMedium glow = slab({0.0f, 0.5f, 3.0f});
    glow.emission = {0.3f, 0.3f, 0.3f};
    scene.media = {glow};
    const PictureField truth = [&](glm::dvec2 at) {
        const double length = box_segment(ray_at(scene, at), kSlabMin, kSlabMax).length();
        glm::dvec3 radiance;
        for (int c = 0; c < 3; ++c) {
            const double sigma = glow.sigma_a[c];
            radiance[c] =
                glow.emission[c] * (sigma == 0 ? length : -std::expm1(-sigma * length) / sigma);
        }
        return radiance;
    };
    const Still still = render(scene, settings());
    expect_field(scene, picture_of(still, still.scattering), truth, 5e-6,
                 "the integral of a step is a closed form, its sums are 32-bit floats");
}

/// Optical depth per metre at z0 = 0 of a segment of fog that falls off with height.
double fog_depth(const PixelRay& ray, Segment inside, double scale_height)
{
    const double z = ray.origin.z + ray.direction.z * inside.begin;
    const double fall = ray.direction.z * inside.length() / scale_height;
    const double mean = std::abs(fall) < 1e-9 ? 1 : -std::expm1(-fall) / fall;
    return std::exp(-z / scale_height) * mean * inside.length();
}

TEST_P(Extinction, FogThatFallsOffWithHeight)
{
    Scene scene = slab_scene(GetParam().projection);
    BoxMedium fog = slab({0.5f, 1.0f, 2.0f});
    fog.profile = ExpHeightProfile{.scale_height = 0.6, .z0 = 0};
    scene.media = {fog};
    const PictureField truth = [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        return glm::exp(-glm::dvec3(fog.sigma_a) *
                        fog_depth(ray, box_segment(ray, kSlabMin, kSlabMax), 0.6));
    };
    const Still still = render(scene, settings());
    // Midpoints: tau * (slope * ds / scale_height)^2 / 24 with slope 0.36, ds < 0.05: 4e-5 of tau,
    // and tau exp(-tau) < 0.37.
    expect_field(scene, picture_of(still, still.transmittance), truth, 2e-5,
                 "midpoint rule over 64 steps");
}

INSTANTIATE_TEST_SUITE_P(Views, Extinction, testing::ValuesIn(kViews), name_of);

using March = ImageTest;

// Seen from its side a box ends at its own faces and edges: no step reaches over them.
TEST_F(March, BoxAskewEndsAtItsFaces)
{
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
        Scene scene = slab_scene(projection, 48);
        scene.camera.position = {4, 3, 2.5};
        BoxMedium box;
        box.min = {-0.5, -0.7, -0.6};
        box.max = {0.6, 0.4, 0.5};
        box.sigma_a = {0.3f, 1.0f, 3.0f};
        scene.camera.look_at = (box.min + box.max) / 2.0;
        scene.media = {box};
        const Still still = render(scene, plain_settings());
        EXPECT_TRUE(images_near(
            picture_of(still, still.transmittance),
            ideal(scene,
                  [&](glm::dvec2 at) {
                      return glm::exp(-glm::dvec3(box.sigma_a) *
                                      box_segment(ray_at(scene, at), box.min, box.max).length());
                  }),
            2e-5, 1e-6, "where a ray meets a face, in 32-bit floats, 1e-6 m at 5 m, times sigma"));
    }
}

// A sample in the middle of its step is a midpoint rule: twice the steps, a quarter of the error.
TEST_F(March, ErrorFallsWithTheSquareOfTheStep)
{
    Scene scene = slab_scene(Projection::perspective, 16);
    scene.camera.vfov_deg = 80;
    BoxMedium fog = slab(glm::vec3(1));
    fog.profile = ExpHeightProfile{.scale_height = 0.6, .z0 = 0};
    scene.media = {fog};
    const Image truth = ideal(scene, [&](glm::dvec2 at) {
        const PixelRay ray = ray_at(scene, at);
        return glm::exp(-glm::dvec3(fog.sigma_a) *
                        fog_depth(ray, box_segment(ray, kSlabMin, kSlabMax), 0.6));
    });
    double before = 0;
    for (const int steps : {4, 8, 16, 32}) {
        Settings settings = plain_settings();
        settings.steps = steps;
        const Still still = render(scene, settings);
        const double error = rms_difference(picture_of(still, still.transmittance), truth);
        figure(fmt::format("rms error at {} steps", steps), error);
        if (before > 0) {
            EXPECT_NEAR(std::log2(before / error), 2.0, 0.35)
                << "order of convergence from " << steps / 2 << " to " << steps
                << " steps; 32-bit rounding is a hundredth of the last error";
        }
        before = error;
    }
}

// Jitter only moves samples within steps, so a uniform medium does not notice it.
TEST_F(March, JitterAndSpacingDoNotTouchAUniformMedium)
{
    Scene scene = slab_scene(Projection::perspective);
    BoxMedium box = slab({0.5f, 1.0f, 2.0f});
    box.emission = glm::vec3(1);
    scene.media = {box};
    Settings settings = plain_settings();
    const Still plain = render(scene, settings);
    settings.jitter = Settings::Jitter::blue;
    for (const int steps : {1, 7, 64})
        for (const float distribution : {0.0f, 1.0f}) {
            settings.steps = steps;
            settings.distribution = distribution;
            const Still other = render(scene, settings);
            EXPECT_TRUE(images_near(picture_of(other, other.composite),
                                    picture_of(plain, plain.composite), 1e-5, 1e-5,
                                    "32-bit sums in another order"))
                << steps << " steps, distribution " << distribution;
        }
}

// Steps are cut at the first entry and the last exit alone. At faces between, a step counts as a
// whole for the medium that its sample is in: half a step of it too much or too little at each such
// face. Jitter makes noise of that, with no bias.
TEST_F(March, MediaWithAGapBetween)
{
    Scene scene = slab_scene(Projection::perspective, 64);
    BoxMedium near_slab = slab(glm::vec3(0.4f)), far_slab = near_slab;
    far_slab.min.y -= 5;
    far_slab.max.y -= 5;
    scene.media = {near_slab, far_slab};
    Settings settings = plain_settings();
    double before = 1;
    for (const int steps : {64, 256}) {
        settings.steps = steps;
        for (const auto jitter : {Settings::Jitter::none, Settings::Jitter::blue}) {
            settings.jitter = jitter;
            const Still still = render(scene, settings);
            double worst = 0, mean = 0;
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 64; ++x) {
                    const double slant = ray_of(scene, x, y).length_per_z;
                    const double off =
                        -std::log(double(pixel(still.transmittance, 64, x, y).r)) / slant - 0.4 * 4;
                    worst = std::max(worst, std::abs(off));
                    mean += off / 4096;
                }
            const bool jittered = jitter == Settings::Jitter::blue;
            figure(fmt::format("optical depth off at most, {} steps{}", steps,
                               jittered ? ", jitter" : ""),
                   worst);
            // 7 m of steps of 0.2 + 0.8 * 1.1 at the longest; two inner faces, by half a step each,
            // or by a whole one where the sample is anywhere in it.
            EXPECT_LT(worst, 0.4 * 2 * (jittered ? 1 : 0.5) * 7.0 / steps * 1.3);
            if (jittered) {
                EXPECT_LT(std::abs(mean), 0.1 * 0.4 * 7.0 / steps) << "a bias in place of noise";
                EXPECT_LT(worst, before) << "more steps, less noise";
                before = worst;
            }
        }
    }
}

// A colour for a density, a grid that only glows, and a colour grid that tints what is scattered.
TEST_F(March, GridsOfColours)
{
    Scene scene = slab_scene(Projection::orthographic, 8);
    scene.world.radiance = glm::vec3(1);
    const glm::dmat4 world_from_index(0.25, 0, 0, 0, 0, 0.25, 0, 0, 0, 0, 0.25, 0, -1.875, -7,
                                      -1.875, 1);
    const auto color_of = [&](glm::vec3 value, int bricks = 2, int first = 0) {
        auto grid = make_grid(
            glm::ivec3(bricks), world_from_index, [](glm::ivec3) { return 1.0; },
            glm::ivec3(first));
        grid->channels = 3;
        std::vector<float> values;
        for (std::size_t i = 0; i < grid->values.size(); ++i)
            for (int c = 0; c < 3; ++c)
                values.push_back(value[c]);
        grid->values = values;
        grid->max_value = std::max({value.r, value.g, value.b});
        return grid;
    };
    const double length = 4;  // 16 voxels; half a voxel's worth of fade at each end makes 16 whole
    scene.camera.ortho_height = 2;
    for (const auto layout : {medium::Layout::dense, medium::Layout::bricks}) {
        Settings settings = plain_settings();
        settings.layout = layout;
        settings.steps = 256;
        settings.ambient_volume_size = 0;  // the world is what tells the scattering
        const auto expect = [&](const std::vector<float>& layer, glm::dvec3 expected,
                                const char* what) {
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(pixel(layer, 8, 4, 4)[c], expected[c], 3e-4 * (1 + expected[c]))
                    << what << ", channel " << c << ", layout " << static_cast<int>(layout)
                    << ": 256 midpoints, kinks at both ends";
        };
        GridMedium smoke;
        smoke.density = color_of({0.1f, 0.2f, 0.4f});
        smoke.sigma_s_per_density = glm::vec3(0.5f);
        smoke.sigma_a_per_density = glm::vec3(0.5f);
        scene.media = {smoke};
        const glm::dvec3 t = glm::exp(-glm::dvec3(0.1, 0.2, 0.4) * length);
        Still still = render(scene, settings);
        expect(still.transmittance, t, "transmittance of a colour for a density");
        expect(still.scattering, 0.5 * (1.0 - t), "half of what is taken is scattered");

        smoke.color = color_of({1.0f, 0.5f, 0.0f}, 4, -1);  // wider: it must not fade as well
        scene.media = {smoke};
        still = render(scene, settings);
        expect(still.transmittance, t, "a tint leaves extinction alone");
        EXPECT_NEAR(pixel(still.scattering, 8, 4, 4).g, 0.25 * (1 - t.g), 3e-4);
        EXPECT_EQ(pixel(still.scattering, 8, 4, 4).b, 0.0f);

        GridMedium flame;
        flame.emission = color_of({1.0f, 0.5f, 0.25f});
        flame.emission_per_unit = {0.2f, 0.2f, 0.4f};
        scene.media = {flame};
        still = render(scene, settings);
        expect(still.scattering, glm::dvec3(0.2, 0.1, 0.1) * length, "a flame with no smoke");
        expect(still.transmittance, glm::dvec3(1), "which hides nothing");

        flame.density = make_grid({2, 2, 2}, world_from_index, [](glm::ivec3) { return 0.3; });
        flame.sigma_s_per_density = glm::vec3(0);
        flame.sigma_a_per_density = glm::vec3(1);
        scene.media = {flame};
        still = render(scene, settings);
        // Emission and density fade alike at the ends, so the ratio is constant along the ray.
        expect(still.scattering, glm::dvec3(0.2, 0.1, 0.1) / 0.3 * -std::expm1(-0.3 * length),
               "a flame in smoke that only absorbs");
    }
}

TEST_F(March, LayerFormatsHoldTheirPrecision)
{
    Scene scene = slab_scene(Projection::perspective);
    BoxMedium box = slab({0.5f, 1.0f, 2.0f});
    box.emission = glm::vec3(1);
    scene.media = {box};
    Settings settings;
    const Still exact = render(scene, plain_settings(2));
    const Still half = render(scene, settings);
    EXPECT_TRUE(images_near(picture_of(half, half.transmittance),
                            picture_of(exact, exact.transmittance), 2.5e-4, 2.5e-4,
                            "rgba16f rounds values under 1 by 2^-12 at most"));
    settings.format = Settings::Format::r11g11b10f;
    const Still small = render(scene, settings);
    EXPECT_TRUE(images_near(picture_of(small, small.transmittance),
                            picture_of(exact, exact.transmittance), 1.0 / 64, 1.0 / 128,
                            "r11g11b10f has 5 bits behind the point in blue, and may truncate"));
}

}  // namespace
}  // namespace fumarole::test
