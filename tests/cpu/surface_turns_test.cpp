// How often surfaces send light on by themselves.

#include <gmock/gmock.h>

#include "light/surface_turns.h"
#include "study/reference.h"

namespace fumarole::test {
namespace {

using light::surface_turns;
using testing::HasSubstr;

BoxSurface wall(glm::dvec3 min, glm::dvec3 max, glm::vec3 albedo)
{
    BoxSurface box;
    box.min = min;
    box.max = max;
    box.albedo = albedo;
    return box;
}

/// A floor, a back, a red and a green wall, with smoke between them, and nothing that is glossy.
Scene plain_room(float brightness)
{
    Scene scene;
    BoxMedium smoke;
    smoke.min = {-1, -1, 0.5};
    smoke.max = {1, 1, 3};
    smoke.sigma_s = glm::vec3(0.5f);
    scene.media = {smoke};
    const glm::vec3 grey(0.6f * brightness);
    scene.surfaces = {wall({-4, -3, -0.3}, {4, 3, 0}, grey), wall({-4, 3, 0}, {4, 3.3, 4}, grey),
                      wall({-4.3, -3, 0}, {-4, 3, 4}, brightness * glm::vec3(0.7f, 0.1f, 0.1f)),
                      wall({4, -3, 0}, {4.3, 3, 4}, brightness * glm::vec3(0.1f, 0.6f, 0.1f))};
    return scene;
}

TEST(SurfaceTurns, AreAsMuchAsSurfacesSeeOfEachOther)
{
    const SceneSettings settings;
    const Scene room = plain_room(1);
    EXPECT_GE(surface_turns(room, settings).turns, 2);
    EXPECT_THAT(surface_turns(room, settings).why, HasSubstr("of a white picture"));
    // A hundredth of the light, and a wall far away, are not seen.
    EXPECT_EQ(surface_turns(plain_room(0.1f), settings).turns, 0);
    Scene ground = room;
    ground.surfaces = {wall({-50, -50, -1}, {50, 50, 0}, glm::vec3(0.6f))};
    EXPECT_EQ(surface_turns(ground, settings).turns, 0);
    EXPECT_THAT(surface_turns(ground, settings).why, HasSubstr("less than 0.01"));
    ground.surfaces.emplace_back(wall({20, 20, 0}, {22, 22, 2}, glm::vec3(0.6f)));
    EXPECT_EQ(surface_turns(ground, settings).turns, 0);
    // The same room as a mesh, whose triangles are one surface that sees itself.
    auto mesh = std::make_shared<Mesh>();
    mesh->positions = {{-4, -3, 0}, {4, -3, 0}, {4, 3, 0}, {-4, 3, 0},
                       {-4, -3, 4}, {4, -3, 4}, {4, 3, 4}, {-4, 3, 4}};
    mesh->triangles = {0, 1, 2, 0, 2, 3, 2, 3, 7, 2, 7, 6, 0, 3, 7, 0, 7, 4, 1, 2, 6, 1, 6, 5};
    MeshSurface walls;
    walls.mesh = mesh;
    walls.albedo = glm::vec3(0.5f);
    Scene as_mesh = room;
    as_mesh.surfaces = {walls};
    EXPECT_GE(surface_turns(as_mesh, settings).turns, 2);
    // The truth of such a picture has all of them, of another none.
    EXPECT_EQ(study::measured_surface_bounces(room), study::kAllBounces);
    EXPECT_EQ(study::measured_surface_bounces(ground), 0);

    SceneSettings asked;
    asked.surface_bounces = 3;
    EXPECT_EQ(surface_turns(ground, asked).turns, 3);
    Scene glossy = ground;
    std::get<BoxSurface>(glossy.surfaces[1]).gloss = Gloss{};
    EXPECT_GE(surface_turns(glossy, settings).turns, 2);
    // Seen from elsewhere it is as it was.
    Scene turned = room;
    turned.camera.position = {100, 0, 0};
    EXPECT_EQ(surface_turns(turned, settings).why, surface_turns(room, settings).why);
}

}  // namespace
}  // namespace fumarole::test
