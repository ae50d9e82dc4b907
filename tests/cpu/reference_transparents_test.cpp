#include "study/reference_transparents.h"

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "study/reference.h"
#include "support/reference_scenes.h"

// Transparents in the reference, against closed forms of a fog that glows.

namespace fumarole::study {

namespace {

constexpr double kTight = 1e-8;
constexpr double kBegin = 2, kEnd = 5;  ///< of the fog, along the ray [m]
const glm::dvec3 kSigma(0.4, 2, 0.1);   ///< 1/m
const glm::dvec3 kGlow(1, 3, 0.5);      ///< W/m^2/sr per metre
const glm::dvec3 kSky(0.7, 0.2, 0.9);   ///< W/m^2/sr

Scene foggy()
{
    Scene scene = looking();
    BoxMedium slab = fog({-5, kBegin, -5}, {5, kEnd, 5}, glm::vec3(0), glm::vec3(kSigma));
    slab.emission = glm::vec3(kGlow);
    scene.media.emplace_back(slab);
    scene.world.radiance = glm::vec3(kSky);
    return scene;
}

/// From the eye to `far`.
glm::dvec3 passed(double far)
{
    return glm::exp(-kSigma * (std::clamp(far, kBegin, kEnd) - kBegin));
}
glm::dvec3 glowed(double far)
{
    return kGlow / kSigma * (1.0 - passed(far));
}

QuadTransparent pane(double y, Blend::Kind kind)
{
    QuadTransparent quad;
    quad.corner = {-1, y, -1};
    quad.edges = {glm::dvec3(2, 0, 0), glm::dvec3(0, 0, 2)};
    quad.look.blend.kind = kind;
    return quad;
}

glm::dvec3 seen(const Scene& scene)
{
    return Reference(scene, kTight, 0).sample({0.5, 0.5}, 0).composite;
}

void expect_near(glm::dvec3 value, glm::dvec3 expected, double relative = 1e-6)
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(value[c], expected[c], relative * std::max(std::abs(expected[c]), 1e-9))
            << "channel " << c;
}

}  // namespace

TEST(ReferenceTransparents, APaneOfEachBlendHidesTheFogBehindItAlone)
{
    const double y = 3.25;
    const glm::dvec3 behind =
        kSky * passed(kEnd) / passed(y) + (glowed(kEnd) - glowed(y)) / passed(y);  // at the pane
    const glm::vec3 radiance(0.3f, 0.2f, 0.6f), filter(0.5f, 1, 0.25f);
    const float alpha = 0.25f;
    using Kind = Blend::Kind;
    const std::vector<std::pair<Kind, glm::dvec3>> expected{
        {Kind::alpha, glm::dvec3(radiance) * 0.25 + behind * 0.75},
        {Kind::premultiplied, glm::dvec3(radiance) + behind * 0.75},
        {Kind::add, glm::dvec3(radiance) + behind},
        {Kind::multiply, behind * glm::dvec3(filter)},
    };
    for (const auto& [kind, in_front] : expected) {
        Scene scene = foggy();
        QuadTransparent quad = pane(y, kind);
        quad.look.radiance = radiance;
        quad.look.filter = filter;
        quad.look.alpha = alpha;
        scene.transparents = {quad};
        SCOPED_TRACE(static_cast<int>(kind));
        expect_near(seen(scene), in_front * passed(y) + glowed(y));
    }
}

TEST(ReferenceTransparents, EveryPairOfFactorsIsOpenGLs)
{
    const double y = 3.25;
    const glm::dvec4 behind(
        kSky * passed(kEnd) / passed(y) + (glowed(kEnd) - glowed(y)) / passed(y), 1);
    const glm::dvec4 source(0.25, 0.5, 2, 0.75);
    const std::vector<glm::dvec4> factors{
        glm::dvec4(0),
        glm::dvec4(1),
        source,
        1.0 - source,
        behind,
        1.0 - behind,
        glm::dvec4(source.a),
        glm::dvec4(1 - source.a),
        glm::dvec4(1),
        glm::dvec4(0),
        {0, 0, 0, 1},  // min(0.75, 1 - 1)
    };
    for (std::size_t s = 0; s < factors.size(); ++s)
        for (std::size_t d = 0; d < factors.size(); ++d) {
            Scene scene = foggy();
            QuadTransparent quad = pane(y, Blend::Kind::factors);
            quad.look.blend.source = static_cast<BlendFactor>(s);
            quad.look.blend.destination = static_cast<BlendFactor>(d);
            quad.look.radiance = glm::vec3(source);
            quad.look.alpha = 0.75f;
            scene.transparents = {quad};
            SCOPED_TRACE(testing::Message() << s << ", " << d);
            const glm::dvec3 in_front(source * factors[s] + behind * factors[d]);
            expect_near(seen(scene), in_front * passed(y) + glowed(y));
        }
}

TEST(ReferenceTransparents, InvisibleOnesChangeNothingInAnyOrder)
{
    Scene scene = foggy();
    const glm::dvec3 without = seen(scene);
    for (const int i : {3, 0, 11, 7, 1, 9, 2, 10, 5, 8, 4, 6}) {
        QuadTransparent quad = pane(0.5 + 0.5 * i, static_cast<Blend::Kind>(i % 4));
        quad.look.alpha = 0;
        scene.transparents.emplace_back(quad);
    }
    expect_near(seen(scene), without, 1e-12);
}

TEST(ReferenceTransparents, TheLaterOfTwoAtOneDepthIsInFront)
{
    Scene scene = looking();
    QuadTransparent red = pane(3, Blend::Kind::alpha), blue = red;
    red.look.radiance = {1, 0, 0};
    blue.look.radiance = {0, 0, 1};
    scene.transparents = {red, blue};
    expect_near(seen(scene), {0, 0, 1});
    scene.transparents = {blue, red};
    expect_near(seen(scene), {1, 0, 0});
}

TEST(ReferenceTransparents, FadesBeforeASurface)
{
    Scene scene = looking();
    scene.surfaces = {BoxSurface{{-9, 4, -9}, {9, 5, 9}, glm::vec3(0)}};
    QuadTransparent quad = pane(3.75, Blend::Kind::add);
    quad.look.radiance = {1, 2, 3};
    quad.look.depth_fade = 0.5f;
    scene.transparents = {quad};
    expect_near(seen(scene), {0.5, 1, 1.5});
    scene.transparents = {pane(4.5, Blend::Kind::add)};  // behind it
    expect_near(seen(scene), glm::dvec3(0));
}

TEST(ReferenceTransparents, AMeshIsMetOnceATriangle)
{
    auto mesh = std::make_shared<Mesh>();  // two sheets, at y = 1 and 2
    for (const float y : {1.0f, 2.0f}) {
        const auto first = static_cast<std::uint32_t>(mesh->positions.size());
        mesh->positions.insert(mesh->positions.end(), {{-1, y, -1}, {1, y, -1}, {0, y, 2}});
        mesh->normals.resize(mesh->positions.size(), glm::vec3(0, -1, 0));
        mesh->triangles.insert(mesh->triangles.end(), {first, first + 1, first + 2});
    }
    Scene scene = looking();
    scene.world.radiance = glm::vec3(1);
    MeshTransparent glass;
    glass.mesh = mesh;
    glass.look.blend.kind = Blend::Kind::multiply;
    glass.look.filter = {0.5f, 0.9f, 1};
    scene.transparents = {glass};
    expect_near(seen(scene), {0.25, 0.81, 1}, 1e-6);
}

TEST(ReferenceTransparents, ABillboardFacesTheCameraAndHasItsPictureUpright)
{
    auto image = std::make_shared<TransparentImage>();
    image->width = image->height = 2;
    image->texels = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 1, 1}};  // from the top
    Scene scene = looking();
    scene.resolution = {4, 4};
    scene.camera.position = {3, 0, 0};  // looks along -x
    scene.camera.look_at = {0, 0, 0};
    scene.camera.vfov_deg = 53.13010235;  // 3 m across at 3 m
    BillboardTransparent board;
    board.size = {3, 3};
    board.look.image = image;
    board.look.scale = 2;
    scene.transparents = {board};
    const Reference reference(scene, kTight, 0);
    expect_near(reference.sample({0.25, 0.25}, 0).composite, {2, 0, 0});
    expect_near(reference.sample({3.75, 0.25}, 0).composite, {0, 2, 0});
    expect_near(reference.sample({0.25, 3.75}, 0).composite, {0, 0, 2});
}

TEST(ReferenceTransparents, ScatteredLightIsSplitAsWell)
{
    // A pane that lets all through but for a factor f: what scatters before it, and f of the rest.
    Scene scene = looking();
    scene.media.emplace_back(fog({-5, 2, -5}, {5, 5, 5}, glm::vec3(0.5f), glm::vec3(0.1f)));
    scene.lights = {PointLight{{1, 3, 2}, glm::vec3(20)}};
    scene.world.radiance = glm::vec3(0.3f);
    const auto with = [&](float filter) {
        QuadTransparent quad = pane(3.25, Blend::Kind::multiply);
        quad.look.filter = glm::vec3(filter);
        Scene filtered = scene;
        filtered.transparents = {quad};
        return Reference(filtered, 1e-3, 3).sample({0.5, 0.5}, 0);
    };
    const ReferenceSample whole = Reference(scene, 1e-3, 3).sample({0.5, 0.5}, 0);
    const ReferenceSample clear = with(1), half = with(0.5f), opaque = with(0);
    for (int c = 0; c < 3; ++c) {
        // Each is sampled by itself; an error is two of its standard errors.
        EXPECT_NEAR(clear.composite[c], whole.composite[c], 1.5 * (clear.error + whole.error));
        EXPECT_NEAR(half.composite[c], (clear.composite[c] + opaque.composite[c]) / 2,
                    1.5 * (half.error + clear.error / 2 + opaque.error / 2));
        EXPECT_LT(opaque.composite[c], 0.8 * whole.composite[c]);
    }
    EXPECT_LT(whole.error, 0.05 * whole.composite.x);
}

namespace {

/// Two triangles a face of a box, as a mesh of glass.
MeshTransparent box_of(glm::vec3 low, glm::vec3 high, glm::vec3 filter)
{
    auto mesh = std::make_shared<Mesh>();
    for (int i = 0; i < 8; ++i)
        mesh->positions.emplace_back((i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                                     (i & 4) != 0 ? high.z : low.z);
    mesh->normals.assign(8, glm::vec3(0, 0, 1));
    for (const std::array<std::uint32_t, 4>& face : {std::array{0u, 1u, 3u, 2u},
                                                     {4u, 5u, 7u, 6u},
                                                     {0u, 1u, 5u, 4u},
                                                     {2u, 3u, 7u, 6u},
                                                     {0u, 2u, 6u, 4u},
                                                     {1u, 3u, 7u, 5u}})
        mesh->triangles.insert(mesh->triangles.end(),
                               {face[0], face[1], face[2], face[0], face[2], face[3]});
    MeshTransparent glass;
    glass.mesh = mesh;
    glass.look.blend.kind = Blend::Kind::multiply;
    glass.look.filter = filter;
    glass.look.casts = true;
    return glass;
}

/// Level, above or below the ray of looking(), from y = 3 to 4.
QuadTransparent level_pane(double z, glm::vec3 filter)
{
    QuadTransparent quad;
    quad.corner = {-1, 3, z};
    quad.edges = {glm::dvec3(2, 0, 0), glm::dvec3(0, 1, 0)};
    quad.look.blend.kind = Blend::Kind::multiply;
    quad.look.filter = filter;
    quad.look.casts = true;
    return quad;
}

}  // namespace

TEST(ReferenceTransparents, OnesThatCastFilterABeam)
{
    constexpr double kTop = 5;  // of the fog above the ray [m]
    const glm::dvec3 sun(4, 5, 6), red(0.85, 0.45, 0.25), blue(0.2, 0.5, 0.75);
    const double sigma_s = 0.25, sigma_t = 0.375;  // that floats hold
    Scene scene = looking();
    scene.media = {fog({-5, kBegin, -5}, {5, kEnd, kTop}, glm::vec3(static_cast<float>(sigma_s)),
                       glm::vec3(static_cast<float>(sigma_t - sigma_s)))};
    QuadTransparent grey = level_pane(2.5, glm::vec3(1));
    grey.look.blend.kind = Blend::Kind::alpha;
    grey.look.alpha = 0.25f;
    QuadTransparent glow = level_pane(3, glm::vec3(1));
    glow.look.blend.kind = Blend::Kind::add;
    glow.look.radiance = glm::vec3(9);
    // One below the ray filters nothing on it.
    scene.transparents = {level_pane(1, glm::vec3(red)), level_pane(2, glm::vec3(blue)), grey, glow,
                          level_pane(-1, glm::vec3(0.5f))};
    const auto until = [&](double y) { return (1 - std::exp(-sigma_t * (y - kBegin))) / sigma_t; };
    const auto beam = [&](glm::dvec3 from_above) {
        return from_above * std::exp(-sigma_t * kTop) * sigma_s / (4 * std::numbers::pi) *
               ((until(kEnd) - until(4) + until(3)) + (until(4) - until(3)) * 0.75 * red * blue);
    };
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(sun)}};
    expect_near(seen(scene), beam(sun));
    // As far away as a sun, all but a billionth.
    const double far = 1e7;
    scene.lights = {PointLight{{0, 3.5, far}, glm::vec3(sun * far * far)}};
    expect_near(seen(scene), beam(sun), 1e-5);
    // Of a mesh a ray meets both sides.
    scene.lights = {SunLight{{0, 0, 1}, glm::vec3(sun)}};
    scene.transparents = {box_of({-1, 3, 1}, {1, 4, 2}, glm::vec3(glm::sqrt(0.75 * red * blue)))};
    expect_near(seen(scene), beam(sun));
}

TEST(ReferenceTransparents, OnesThatCastFilterAllLightThatComesThrough)
{
    // A floor that shines back, and smoke over it: what comes from above the pane is filtered,
    // however often it is scattered below.
    const glm::vec3 filter(0.75f, 0.5f, 0.25f);
    Scene scene = looking();
    scene.camera.look_at = {0, 1, -0.4};
    scene.surfaces = {BoxSurface{{-2, 0, -2}, {2, 6, -1}, glm::vec3(0.8f)}};
    scene.media = {fog({-1, kBegin, -1}, {1, kEnd, 1}, glm::vec3(0.5f), glm::vec3(0.1f))};
    const auto lit = [&](const Scene& by) {
        return Reference(by, 0.02, 3, 2).sample({0.5, 0.5}, 1e-6).composite;
    };
    scene.lights = {SunLight{{0, 0, 1}, filter}, SunLight{{0.1, 0, 1}, filter}};
    const glm::dvec3 dimmed = lit(scene);
    for (Light& light : scene.lights)
        std::get<SunLight>(light).irradiance = glm::vec3(1);
    const glm::dvec3 bright = lit(scene);
    QuadTransparent roof = level_pane(2, filter);
    roof.corner = {-90, -90, 2};
    roof.edges = {glm::dvec3(180, 0, 0), glm::dvec3(0, 180, 0)};
    scene.transparents = {roof};
    const glm::dvec3 through = lit(scene);
    EXPECT_GT(bright.g, 1.9 * dimmed.g);
    expect_near(through, dimmed, 0.03);

    // The world's, and what surfaces emit, from all around into a box of glass.
    Scene room = looking();
    room.surfaces = {BoxSurface{{-1, 2, -1}, {1, 3, 1}, glm::vec3(0.5f)}};
    room.world.radiance = glm::vec3(2);
    room.transparents = {box_of({-3, 1, -3}, {3, 4, 3}, filter)};
    expect_near(seen(room), 0.5 * 2.0 * glm::dvec3(filter) * glm::dvec3(filter), 1e-3);
}

}  // namespace fumarole::study
