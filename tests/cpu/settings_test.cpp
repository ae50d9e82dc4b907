#include <fumarole/errors.h>
#include <fumarole/settings.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <type_traits>

#include "study/flag_names.h"

namespace fumarole {
namespace {

// A host can't hand to a frame what only a scene takes, nor the other way round.
static_assert(!std::is_convertible_v<SceneSettings, FrameSettings>);
static_assert(!std::is_convertible_v<FrameSettings, SceneSettings>);

std::string message_of(const auto& settings)
{
    try {
        check(settings);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(SettingTable, RoundTripsEveryPreset)
{
    for (const auto& [name, preset] : presets()) {
        Settings copy;
        for (const SettingInfo& info : setting_table()) {
            EXPECT_TRUE(info.holds(preset)) << name << ' ' << info.name;
            info.set(copy, info.get(preset));
        }
        copy.mode = preset.mode;
        EXPECT_EQ(copy, preset) << name;
    }
}

TEST(SettingTable, NamesEachMemberOnce)
{
    std::set<std::string> members;
    for (const SettingInfo& info : setting_table()) {
        EXPECT_TRUE(members.insert(info.member).second) << info.member;
        EXPECT_EQ(study::with_flags(info.member), "--" + std::string(info.name));
    }
}

TEST(Settings, AreCheckedByTheNamesOfTheirMembers)
{
    EXPECT_EQ(message_of(SceneSettings{}), "");
    EXPECT_EQ(message_of(FrameSettings{}), "");
    FrameSettings frame;
    frame.steps = 0;
    EXPECT_EQ(message_of(frame),
              "FrameSettings::steps: '0' is not one of its values; it takes 1..4096");
    frame = {};
    frame.min_transmittance = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(message_of(frame),
              "FrameSettings::min_transmittance: 'nan' is not one of its values; it takes 0..0.5");
    frame = {};
    frame.resolution = 3;
    EXPECT_NE(message_of(frame).find("FrameSettings::resolution: '3'"), std::string::npos);
    frame = {};
    frame.format = static_cast<FrameSettings::Format>(9);
    EXPECT_NE(message_of(frame).find("FrameSettings::format: '9'"), std::string::npos);
    SceneSettings scene;
    scene.shadow_map = 15;
    EXPECT_EQ(message_of(scene),
              "SceneSettings::shadow_map: '15' is not one of its values; it takes auto|16..8192");
}

TEST(SettingTable, TakesTheNamesOfTheReleaseBefore)
{
    const std::map<std::string_view, std::string_view> renamed{
        {"skip", "empty-space-skipping"},
        {"early-end", "min-transmittance"},
        {"least-extinction", "min-extinction"},
        {"shadow-cache", "shadow-volume-size"},
        {"world-cache", "ambient-volume-size"}};
    for (const auto& [old, present] : renamed) {
        EXPECT_EQ(present_name(old), present);
        EXPECT_EQ(find_setting(old).name, present);
        EXPECT_EQ(find_setting(present).name, present);
    }
    for (const SettingInfo& info : setting_table())
        EXPECT_EQ(present_name(info.name), info.name) << "an old name hides it";
    EXPECT_EQ(present_name("no-such"), "no-such");
}

TEST(FlagNames, StandInTheCommandLinesMessages)
{
    EXPECT_EQ(study::with_flags("FrameSettings::steps: '0' is not; SceneSettings::shadow_map"),
              "--steps: '0' is not; --shadow-map");
    EXPECT_EQ(study::with_flags("(FrameSettings::spacing, FrameSettings::format)"),
              "(--step-spacing, --target-format)");
    EXPECT_EQ(study::with_flags("use FrameSettings::mode froxel; Scene::resolution."),
              "use --mode froxel; --size.");
    const std::string plain = "smoke::old.vdb: no grid 'a::b' (has: 'c'): x:y ::";
    EXPECT_EQ(study::with_flags(plain), plain);
    EXPECT_EQ(study::with_flags(""), "");
}

}  // namespace
}  // namespace fumarole
