// Parts of a scene that come, change and go by ids.

#include <gtest/gtest.h>
#include <string>

#include <fumarole/errors.h>
#include <fumarole/live_scene.h>

namespace fumarole {
namespace {

template <class F> std::string message_of(F&& call)
{
    try {
        call();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

TEST(LiveScene, HasIdsForThePartsItIsMadeOf)
{
    Scene scene;
    scene.lights = {SunLight{}, PointLight{{1, 2, 3}}};
    scene.media = {BoxMedium{}};
    scene.surfaces = {SphereSurface{}};
    const LiveScene live(scene);
    ASSERT_EQ(live.lights().size(), 2u);
    ASSERT_EQ(live.media().size(), 1u);
    ASSERT_EQ(live.surfaces().size(), 1u);
    EXPECT_EQ(live.at(live.lights()[1]), scene.lights[1]);
    EXPECT_TRUE(same_content(live.scene(), scene));
}

TEST(LiveScene, IdsOutliveWhatIsRemovedBeforeThem)
{
    LiveScene live;
    BoxMedium tall;
    tall.max = {4, 4, 4};
    const LightId sun = live.add(SunLight{});
    const LightId lamp = live.add(PointLight{{1, 2, 3}});
    const MediumId first = live.add(BoxMedium{}), second = live.add(tall);
    const SurfaceId ball = live.add(SphereSurface{}), box = live.add(BoxSurface{});
    live.remove(sun);
    live.remove(first);
    live.remove(ball);
    EXPECT_EQ(live.at(lamp), Light(PointLight{{1, 2, 3}}));
    EXPECT_EQ(live.at(second), Medium(tall));
    live.update(lamp, SpotLight{});
    live.update(second, GridMedium{});
    live.update(box, SphereSurface{{7, 7, 7}});
    EXPECT_EQ(live.scene().lights, std::vector<Light>{SpotLight{}});
    EXPECT_EQ(live.scene().media, std::vector<Medium>{GridMedium{}});
    EXPECT_EQ(live.scene().surfaces, (std::vector<Surface>{SphereSurface{{7, 7, 7}}}));
    EXPECT_NE(live.add(SunLight{}), sun) << "a number is given once";
}

TEST(LiveScene, ASurfacesGlossAndEmissionAreContent)
{
    Scene scene;
    scene.surfaces = {SphereSurface{}};
    LiveScene live(scene);
    const SurfaceId ball = live.surfaces().front();
    SphereSurface other;
    other.gloss = Gloss{.roughness = 0.5f};
    live.update(ball, other);
    EXPECT_FALSE(same_content(live.scene(), scene));
    live.update(ball, SphereSurface{.emission = {1, 0, 0}});
    EXPECT_FALSE(same_content(live.scene(), scene));
    live.update(ball, SphereSurface{});
    EXPECT_TRUE(same_content(live.scene(), scene));
}

TEST(LiveScene, TransparentsComeAndGoByIdsToo)
{
    Scene scene;
    scene.transparents = {QuadTransparent{}};
    LiveScene live(scene);
    const TransparentId quad = live.transparents().front();
    const TransparentId board = live.add(BillboardTransparent{});
    live.remove(quad);
    BillboardTransparent bright;
    bright.look.radiance = glm::vec3(3);
    live.update(board, bright);
    EXPECT_EQ(live.at(board), Transparent(bright));
    EXPECT_EQ(live.scene().transparents, std::vector<Transparent>{bright});
    EXPECT_FALSE(same_content(live.scene(), scene));
    EXPECT_EQ(message_of([&] { live.remove(quad); }),
              "LiveScene::remove: transparent 1 is no part of this scene: it was removed, or is "
              "another scene's; add() it anew");
}

TEST(LiveScene, ProbesHaveIds)
{
    Scene scene;
    scene.probes = {LightProbe{}};
    LiveScene live(scene);
    const ProbeId first = live.probes().front();
    const ProbeId second = live.add(LightProbe{.position = {1, 0, 0}});
    live.remove(first);
    live.update(second, LightProbe{.position = {2, 0, 0}});
    EXPECT_EQ(live.at(second), (LightProbe{.position = {2, 0, 0}}));
    EXPECT_EQ(live.scene().probes.size(), 1u);
    EXPECT_FALSE(same_content(live.scene(), scene));
    EXPECT_EQ(message_of([&] { live.remove(first); }),
              "LiveScene::remove: probe 1 is no part of this scene: it was removed, or is "
              "another scene's; add() it anew");
}

TEST(LiveScene, AnIdThatIsNoneIsNamedAndChangesNothing)
{
    LiveScene live;
    const LightId lamp = live.add(PointLight{});
    const LightId sun = live.add(SunLight{});
    live.remove(lamp);
    EXPECT_EQ(message_of([&] { live.update(lamp, SunLight{}); }),
              "LiveScene::update: light 1 is no part of this scene: it was removed, or is another "
              "scene's; add() it anew");
    EXPECT_EQ(message_of([&] { live.remove(lamp); }).find("LiveScene::remove: light 1 "), 0u);
    EXPECT_EQ(message_of([&] { (void)live.at(lamp); }).find("LiveScene::at: light 1 "), 0u);
    EXPECT_EQ(message_of([&] { live.remove(MediumId{}); }).find("LiveScene::remove: medium 0 "),
              0u);
    EXPECT_EQ(message_of([&] {
                  live.update(SurfaceId{9}, BoxSurface{});
              }).find("LiveScene::update: surface 9 "),
              0u);
    EXPECT_EQ(live.scene().lights, std::vector<Light>{SunLight{}});
    EXPECT_EQ(live.at(sun), Light(SunLight{}));
}

}  // namespace
}  // namespace fumarole
