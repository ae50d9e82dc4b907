// The scene's depth: it ends the medium, at every pixel its own, however the host keeps it, and the
// resolve of a small layer minds its edges.

#include <cmath>
#include <fmt/format.h>

#include "host_picture.h"

namespace fumarole::test {
namespace {

class SceneDepth : public ImageTest {
protected:
    /// The eye in fog that reaches 60 m ahead.
    static Scene fog_scene(int size, glm::vec3 sigma_a)
    {
        Scene scene = empty_scene(size);
        scene.camera.vfov_deg = 40;
        BoxMedium fog;
        fog.min = {-60, -60, -60};
        fog.max = {60, 2, 60};
        fog.sigma_a = sigma_a;
        scene.media = {fog};
        return scene;
    }
};

TEST_F(SceneDepth, ASphereEndsTheFog)
{
    constexpr glm::dvec3 kSigma(0.1, 0.2, 0.4);
    Scene scene = fog_scene(32, kSigma);
    const glm::dvec3 center(0.2, -6, 0.1);
    scene.surfaces = {SphereSurface{center, 1.2, glm::vec3(1)}};
    // Froxels of 4 pixels: uniform fog is exact whatever lies between their columns.
    for (const Settings& settings : {plain_settings(), plain_froxels(4)}) {
        const Still still = render(scene, settings);
        int on_sphere = 0;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                const PixelRay ray = ray_of(scene, x, y);
                const double b = glm::dot(center, ray.direction);
                const double root = b * b - glm::dot(center, center) + 1.2 * 1.2;
                if (root < 0.1)
                    continue;  // the silhouette's own pixels
                ++on_sphere;
                // Media begin at the near plane, 0.01 m ahead.
                const double length = b - std::sqrt(root) - 0.01 * ray.length_per_z;
                const glm::vec3 t = pixel(still.transmittance, 32, x, y);
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(t[c], std::exp(-kSigma[c] * length), 0.4 * 1.2e-3)
                        << "pixel " << x << ", " << y
                        << ": the sphere is made of 128 x 64 patches, "
                        << "3e-4 of its radius deep, 1 / cos(60 deg) of it along a ray";
            }
        EXPECT_GT(on_sphere, 150);
    }
}

TEST_F(SceneDepth, AWallEndsTheFogAtEachPixelsOwnDistance)
{
    constexpr glm::dvec3 kSigma(0.1, 0.2, 0.4);
    Scene scene = fog_scene(32, kSigma);
    scene.surfaces = {BoxSurface{{-40, -9, -40}, {40, -7, 40}, glm::vec3(1)}};
    for (const auto projection :
         {Camera::Projection::perspective, Camera::Projection::orthographic})
        for (const Settings& settings : {plain_settings(1), plain_settings(2), plain_settings(4),
                                         plain_froxels(1), plain_froxels(5)}) {
            const int resolution = settings.resolution;
            scene.camera.projection = projection;
            scene.camera.ortho_height = 4;
            const Still still = render(scene, settings);
            const Image truth = resolved(scene, resolution, [&](glm::dvec2 at) {
                return glm::exp(-kSigma * (6.99 * ray_at(scene, at).length_per_z));
            });
            EXPECT_TRUE(images_near(picture_of(still, still.transmittance), truth, 5e-6, 2e-6,
                                    "reversed 32-bit depth is 1e-7 of 7 m; 64 factors of exp"))
                << "resolution " << resolution << ", " << mode_name(settings.mode);
        }
}

TEST_F(SceneDepth, SurfacesBeforeAndBehindTheMediaAreLeftInPeace)
{
    Scene scene = empty_scene(16);
    BoxMedium fog;
    fog.min = {-60, -20, -60};
    fog.max = {60, -10, 60};
    fog.sigma_a = glm::vec3(0.1f);
    scene.media = {fog};
    for (const Settings& settings : {plain_settings(2), plain_froxels(2)}) {
        scene.surfaces = {BoxSurface{{-40, -9, -40}, {40, -7, 40}, glm::vec3(1)}};
        const Still before = render(scene, settings);
        for (const float t : before.transmittance)
            ASSERT_EQ(t, 1.0f) << "a wall before the fog hides it";
        scene.surfaces = {BoxSurface{{-90, -90, -90}, {90, -30, 90}, glm::vec3(1)}};
        const Still behind = render(scene, settings);
        scene.surfaces.clear();
        const Still none = render(scene, settings);
        EXPECT_TRUE(images_near(picture_of(behind, behind.transmittance),
                                picture_of(none, none.transmittance), 1e-6, 1e-6,
                                "a wall behind the fog is as good as the sky"));
    }
}

TEST_F(SceneDepth, AMediumBehindOrBesideTheEyeShadesWhatIsInView)
{
    Scene scene = fog_scene(16, glm::vec3(0));
    auto& fog = std::get<BoxMedium>(scene.media[0]);
    fog.sigma_s = glm::vec3(0.05f);
    fog.max.y = -2;  // away from the eye
    for (const Settings& settings : plain_siblings())
        for (const glm::dvec3 to_sun : {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0)}) {
            scene.lights = {SunLight{to_sun, glm::vec3(3)}};
            scene.media.resize(1);
            const Still open = render(scene, settings);
            BoxMedium cloud;  // behind the eye, or right of the fog
            cloud.min = to_sun.y == 1 ? glm::dvec3(-70, 10, -70) : glm::dvec3(100, -70, -70);
            cloud.max = to_sun.y == 1 ? glm::dvec3(70, 11.5, 70) : glm::dvec3(101.5, 10, 70);
            cloud.sigma_a = {0.5f, 1.0f, 2.0f};
            scene.media.emplace_back(cloud);
            const Still shaded = render(scene, settings);
            EXPECT_GT(pixel(open.scattering, 16, 8, 8).r, 1e-3f);
            for (const int at : {0, 8})
                for (int c = 0; c < 3; ++c) {
                    const double expected = std::exp(-1.5 * double(cloud.sigma_a[c]));
                    EXPECT_NEAR(pixel(shaded.scattering, 16, at, at)[c] /
                                    pixel(open.scattering, 16, at, at)[c],
                                expected, 1e-3 * expected)
                        << "the cloud is 1.5 m thick; it also widens the range that the steps are "
                           "spread over, and midpoints of other steps see the fog's own shadow "
                           "4e-4 "
                           "off";
                }
        }
}

// -- conventions ---------------------------------------------------------------------------------

struct Convention {
    const char* name;
    bool zero_to_one, reversed, infinite;
    GLenum format;
};

constexpr Convention kConventions[] = {
    {"zero_to_one_reversed", true, true, false, GL_DEPTH_COMPONENT32F},
    {"zero_to_one_reversed_infinite", true, true, true, GL_DEPTH_COMPONENT32F},
    {"zero_to_one", true, false, false, GL_DEPTH_COMPONENT32F},
    {"zero_to_one_infinite", true, false, true, GL_DEPTH_COMPONENT32F},
    {"opengl", false, false, false, GL_DEPTH_COMPONENT32F},
    {"opengl_infinite", false, false, true, GL_DEPTH_COMPONENT32F},
    {"opengl_reversed", false, true, false, GL_DEPTH_COMPONENT32F},
    {"opengl_reversed_infinite", false, true, true, GL_DEPTH_COMPONENT32F},
    {"opengl_24_bit", false, false, false, GL_DEPTH_COMPONENT24},
};

void PrintTo(const Convention& convention, std::ostream* out)
{
    *out << convention.name;
}

class HostDepth : public ImageTest, public testing::WithParamInterface<Convention> {
protected:
    /// NDC depth is (a z + b) / z for view_z z: `a` and `b` from its values at near and far.
    static glm::dmat4 projection(const Convention& c, double near, double far)
    {
        const double at_near = c.reversed ? 1 : (c.zero_to_one ? 0 : -1);
        const double at_far = c.reversed ? (c.zero_to_one ? 0 : -1) : 1;
        double a = at_far, b = (at_near - at_far) * near;
        if (!c.infinite) {
            b = (at_near - at_far) * near * far / (far - near);
            a = at_far - b / far;
        }
        const double tangent = std::tan(0.35);
        glm::dmat4 p(0);
        p[0][0] = p[1][1] = 1 / tangent;
        p[2][2] = -a;
        p[2][3] = -1;
        p[3][2] = b;
        return p;
    }
    static Image composite(const Convention& convention, const Settings& settings)
    {
        Scene scene = empty_scene(32);
        BoxMedium fog;
        // Past the far plane: the sky, that is where nothing was drawn, is farther than all of it.
        fog.min = {-200, -160, -200};
        fog.max = {200, -3, 200};
        fog.sigma_s = {0.005f, 0.01f, 0.02f};
        fog.g = 0.3f;
        scene.media = {fog};
        scene.lights = {SunLight{{0.5, 0.5, 0.7}, glm::vec3(3)}};
        scene.world.radiance = {0.1f, 0.2f, 0.4f};
        scene.surfaces = {SphereSurface{{0.3, -8, 0}, 1.2, {0.8f, 0.2f, 0.1f}},
                          BoxSurface{{-9, -30, -3}, {9, 0, -2}, glm::vec3(0.5f)}};
        HostPicture host(gl(), {32, 32}, convention.format);
        host.frame.view_from_world = view_from_world(scene.camera);
        host.frame.clip_from_view = projection(convention, 0.5, 100);
        host.frame.depth_convention = {convention.zero_to_one, convention.reversed};
        Renderer& renderer = scene_renderer().renderer();
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        renderer.draw_surfaces(host.frame, settings, true);
        renderer.composite(view, host.frame, settings);
        return host.read();
    }
};

TEST_P(HostDepth, GivesTheSamePictureAsReversedDepth)
{
    for (const int resolution : {1, 2}) {
        const Settings settings = plain_settings(resolution);
        const Image expected = composite(kConventions[0], settings);
        // 24 bits of depth resolve z^2 / near * 2^-24 = 1e-4 m at 30 m; times 0.02 / m and
        // radiances of about 1.
        EXPECT_TRUE(images_near(composite(GetParam(), settings), expected, 2e-5, 2e-6,
                                "24 bits of depth, z^2 / near apart"))
            << "resolution " << resolution;
        figure("max difference", max_difference(composite(GetParam(), settings), expected));
        EXPECT_GT(
            max_difference(expected, ideal(empty_scene(32),
                                           [](glm::dvec2) { return glm::dvec3(0.1, 0.2, 0.4); })),
            0.2)
            << "there is a picture";
    }
}

INSTANTIATE_TEST_SUITE_P(Conventions, HostDepth, testing::ValuesIn(kConventions),
                         [](const auto& convention) { return std::string(convention.param.name); });

// -- edges ---------------------------------------------------------------------------------------

/// Where the nearer of two depths is. And what it may cost a small layer, which keeps one depth a
/// texel, the nearest and the farthest in turns:
///   missed  share of the picture's pixels that show the other depth, since no texel around them
///           has theirs: lone pixels in a texel that took the farthest depth
struct Pattern {
    const char* name;
    std::function<bool(int x, int y)> is_near;
    double missed_half = 0;
};

std::vector<Pattern> patterns()
{
    return {
        {"wire", [](int x, int) { return x == 13; }},
        {"slanted wire", [](int x, int y) { return (3 * x + y) / 3 == 20; }},
        {"checkerboard", [](int x, int y) { return ((x ^ y) & 1) != 0; }},
        {"foliage", [](int x, int y) { return ((x * 7 + y * 13 + x * y) % 5) < 2; }},
        {"disc", [](int x, int y) { return (x - 15) * (x - 15) + (y - 17) * (y - 17) < 90; }},
        {"lone pixels", [](int x, int y) { return x % 9 == 4 && y % 7 == 3; }, 6 / 1024.0},
    };
}

/// Errors of T over a picture of both depths, in units of the step between them.
struct Halo {
    double energy = 0;  ///< mean of the absolute error
    double missed = 0;  ///< share of pixels that are off by more than a tenth
    double rest = 0;    ///< largest error of the other pixels
};

class DepthEdges : public SceneDepth {
protected:
    /// In fog of 0.2 / m: T is 0.67 and 0.018.
    static constexpr double kNear = 2, kFar = 20;

    static Halo halo(const Pattern& pattern, const Settings& settings)
    {
        Scene scene = fog_scene(32, glm::vec3(0.2f));
        HostPicture host(gl(), {32, 32});
        host.look(scene.camera);
        const auto view_z = [&](int x, int y) { return pattern.is_near(x, y) ? kNear : kFar; };
        host.fill(glm::vec3(1), scene.camera.near, view_z);
        Renderer& renderer = scene_renderer().renderer();
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        renderer.composite(view, host.frame, settings);
        const Image actual = host.read();
        const double step = std::exp(-0.2 * kNear) - std::exp(-0.2 * kFar);
        Halo halo;
        for (int y = 0; y < 32; ++y)
            for (int x = 0; x < 32; ++x) {
                const double length = (view_z(x, y) - 0.01) * ray_of(scene, x, y).length_per_z;
                const double error =
                    std::abs(double(actual.at(x, y, 0)) - std::exp(-0.2 * length)) / step;
                halo.energy += error / 1024;
                halo.missed += error > 0.1 ? 1.0 / 1024 : 0;
                if (error <= 0.1)
                    halo.rest = std::max(halo.rest, error);
            }
        return halo;
    }
};

TEST_F(DepthEdges, AFullSizeLayerHasNoHalo)
{
    for (const Pattern& pattern : patterns()) {
        const Halo full = halo(pattern, plain_settings(1));
        EXPECT_EQ(full.missed, 0) << pattern.name;
        EXPECT_LT(full.rest, 2e-5) << pattern.name << ": each pixel has a ray of its own";
    }
}

TEST_F(DepthEdges, HaloEnergyOfSmallLayers)
{
    for (const int resolution : {2, 4})
        for (const Pattern& pattern : patterns()) {
            Settings settings = plain_settings(resolution);
            const Halo ours = halo(pattern, settings);
            settings.upsample = Settings::Upsample::tent4x4;
            const Halo tent = halo(pattern, settings);
            settings.upsample = Settings::Upsample::box4x4;
            settings.layer_depth = Settings::LayerDepth::corner;
            const Halo of_2017 = halo(pattern, settings);
            const auto keep = [&](const char* filter, const Halo& h) {
                const std::string name =
                    fmt::format("{} at 1/{}, {}: ", pattern.name, resolution, filter);
                figure(name + "energy", h.energy);
                figure(name + "pixels missed", h.missed * 1024);
                figure(name + "rest", h.rest);
            };
            keep("2x2", ours);
            keep("4x4", tent);
            keep("2017", of_2017);

            const double missed = resolution == 2 ? pattern.missed_half : 0;
            EXPECT_LE(ours.missed, missed + 1e-9)
                << pattern.name << " at 1/" << resolution << ": pixels " << ours.missed * 1024;
            // Where a texel fits in depth the others weigh 1 / (1 + (0.9 / 0.05)^4) = 1e-5 or less
            // each; what is left is the ray's own shift by half a texel.
            EXPECT_LT(ours.rest, 0.02) << pattern.name << " at 1/" << resolution;
            EXPECT_LE(ours.energy, missed + 1.5e-3) << pattern.name << " at 1/" << resolution;
            // The wider tent finds more texels, and so what fits.
            EXPECT_LE(tent.energy, ours.energy + 5e-4) << pattern.name << " at 1/" << resolution;
        }
}

TEST_F(DepthEdges, SilhouettesAreBetterThanIn2017)
{
    for (const Pattern& pattern : patterns()) {
        if (std::string(pattern.name) != "disc" && std::string(pattern.name) != "checkerboard" &&
            std::string(pattern.name) != "wire")
            continue;
        Settings settings = plain_settings(2);
        const Halo ours = halo(pattern, settings);
        settings.upsample = Settings::Upsample::box4x4;
        settings.layer_depth = Settings::LayerDepth::corner;
        EXPECT_LT(ours.energy, 0.3 * halo(pattern, settings).energy) << pattern.name;
    }
}

// A wire at the near plane before fog that reaches to the horizon: the relative difference is so
// large that its fourth power has no 32-bit value, and no texel may fit.
TEST_F(DepthEdges, AsFarApartAsDepthsCanBe)
{
    for (const float threshold : {0.05f, 1e-6f})
        for (const double far : {1e3, 1e7})
            for (const auto upsample :
                 {Settings::Upsample::bilinear2x2, Settings::Upsample::tent4x4}) {
                Scene scene = fog_scene(16, glm::vec3(0.2f));
                auto& fog = std::get<BoxMedium>(scene.media[0]);
                fog.min = glm::dvec3(-far);
                fog.max = glm::dvec3(far);
                HostPicture host(gl(), {16, 16});
                host.look(scene.camera);
                host.fill(glm::vec3(1), scene.camera.near, [&](int x, int y) {
                    return x % 5 == 2 && y % 5 == 2 ? scene.camera.near : far * 0.9;
                });
                Settings settings = plain_settings(2);
                settings.upsample = upsample;
                settings.depth_threshold = threshold;
                Renderer& renderer = scene_renderer().renderer();
                View view = renderer.make_view();
                renderer.set_scene(scene, settings);
                renderer.wait_until_ready();
                renderer.composite(view, host.frame, settings);
                for (const float v : host.read().pixels) {
                    ASSERT_TRUE(v >= 0 && v <= 1.0001f)
                        << v << ": threshold " << threshold << ", fog to " << far << " m";
                }
            }
}

}  // namespace
}  // namespace fumarole::test
