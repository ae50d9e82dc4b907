// `fumarole render --show`: a frame's insides as files and as words.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/run_program.h"
#include <fumarole/inspection.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

using Json = nlohmann::json;

Arguments show(const std::string& kind, const Arguments& more = {})
{
    Arguments all{"render", sample("smoke_plume.json"), "--size=96x54", "--show=" + kind};
    all.insert(all.end(), more.begin(), more.end());
    // The reference has no such settings, and is refused for itself.
    return std::find(more.begin(), more.end(), "--mode=reference") == more.end()
               ? with_little_light(std::move(all))
               : all;
}

TEST(Show, EveryKindIsDrawnAndSaysWhatItsColoursMean)
{
    const TempFolder folder;
    std::vector<Arguments> calls;
    for (const InspectionInfo& info : inspection_table()) {
        const std::string name(info.name);
        calls.push_back(show(name, {"-o", name + ".png", "-o", name + ".exr", "--json"}));
        if (info.kind == Inspection::Kind::froxel_slice)
            calls.back().emplace_back("--mode=froxel");
    }
    const std::vector<Outcome> runs = run_all(folder.path(), calls);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const InspectionInfo& info = inspection_table()[i];
        ASSERT_EQ(runs[i].code, 0) << joined(calls[i]) << '\n' << runs[i];
        EXPECT_EQ(runs[i].err, "");
        const Json json = Json::parse(runs[i].out);
        EXPECT_EQ(json["show"], info.name);
        const Json& legend = json["legend"];
        EXPECT_LT(legend["low"], legend["high"]) << info.name;
        EXPECT_NE(legend["caption"], "") << info.name;
        const bool raw = info.kind == Inspection::Kind::scattering ||
                         info.kind == Inspection::Kind::transmittance ||
                         info.kind == Inspection::Kind::probe;
        EXPECT_EQ(legend["false_color"], !raw) << info.name;
        EXPECT_EQ(json["exposure_ev"].is_null(), info.kind != Inspection::Kind::scattering &&
                                                     info.kind != Inspection::Kind::probe);
        const Image exr = write::read_exr(folder.path() / (std::string(info.name) + ".exr"), {});
        EXPECT_EQ(exr.width, 96);
        EXPECT_EQ(exr.height, 54) << "no bar in numbers";
        EXPECT_GT(*std::max_element(exr.pixels.begin(), exr.pixels.end()), 0) << info.name;
    }
}

TEST(Show, TheLayersAreTheTargetsOfARender)
{
    const TempFolder folder;
    const std::vector<Outcome> runs = run_all(
        folder.path(), {show("scattering", {"-o", "s.exr"}), show("transmittance", {"-o", "t.exr"}),
                        with_little_light({"render", "--aa=1", sample("smoke_plume.json"),
                                           "--size=96x54", "-o", "all.exr"})});
    for (const Outcome& run : runs)
        ASSERT_EQ(run.code, 0) << run;
    for (const auto& [file, target] :
         {std::pair{"s.exr", "scattering"}, std::pair{"t.exr", "transmittance"}}) {
        const std::string name(target);
        EXPECT_EQ(
            write::read_exr(folder.path() / file, {"R", "G", "B"}).pixels,
            write::read_exr(folder.path() / "all.exr", {name + ".R", name + ".G", name + ".B"})
                .pixels)
            << target;
    }
}

TEST(Show, AScaleAndASliceAreTaken)
{
    const TempFolder folder;
    const std::vector<Outcome> runs = run_all(
        folder.path(), {show("density-slice", {"--slice=x=0.25", "--scale=7", "-o", "a.exr"}),
                        show("density-slice", {"--slice=0.75", "-o", "b.exr"}),
                        show("froxel-slice", {"--slice=1", "--mode=froxel", "-o", "c.exr"}),
                        show("density-slice", {"--slice=x=0.25", "-o", "d.exr"})});
    for (const Outcome& run : runs)
        ASSERT_EQ(run.code, 0) << run;
    EXPECT_TRUE(runs[0].out.starts_with("density-slice: 0 .. 7 1/m, extinction at x = "))
        << runs[0];
    EXPECT_NE(runs[1].out.find("extinction at z = "), std::string::npos) << runs[1];
    EXPECT_NE(runs[2].out.find("slice 64 of 64"), std::string::npos) << runs[2];
    const auto pixels = [&](const char* file) {
        return write::read_exr(folder.path() / file, {}).pixels;
    };
    EXPECT_NE(pixels("a.exr"), pixels("d.exr")) << "another scale";
    EXPECT_NE(pixels("b.exr"), pixels("d.exr")) << "another place";
}

TEST(Show, WhatDoesNotGoWithItIsRefused)
{
    const TempFolder folder;
    const std::vector<std::pair<Arguments, std::string>> cases{
        {show("everything"), "--show: there is nothing called 'everything'"},
        {show("bricks", {"--target=depth"}), "--target: "},
        {show("bricks", {"--alpha"}), "--alpha: "},
        {show("bricks", {"--aa=4"}), "--aa: "},
        {show("bricks", {"--frames=4"}), "--frames: "},
        {show("bricks", {"--frames=1..4"}), "--frames: "},
        {show("bricks", {"--explain"}), "--explain: "},
        {show("bricks", {"--mode=reference"}), "not for --mode reference"},
        {show("bricks", {"--exposure=1"}), "--exposure: --show bricks has colours of its own"},
        {show("depth", {"--display=srgb"}), "--display: "},
        {show("depth", {"--slice=0.5"}), "--slice: is for"},
        {show("depth", {"--scale=0"}), "--scale"},
        {show("transmittance", {"--scale=1"}), "--scale: is for false colours"},
        {show("froxel-slice"), "goes with --mode froxel"},
        {show("froxel-slice", {"--mode=froxel", "--slice=x=0.5"}), "give POSITION in 0..1"},
        {show("density-slice", {"--slice=w=0.5"}), "give [AXIS=]POSITION in 0..1"},
        {show("density-slice", {"--slice=x=1.5"}), "'x=1.5' is no slice"},
        {show("density-slice", {"--slice=x="}), "'x=' is no slice"},
        {{"render", sample("smoke_plume.json"), "--slice=0.5"}, "--slice: is for --show"},
        {{"render", sample("smoke_plume.json"), "--scale=2"}, "--scale: is for --show"}};
    std::vector<Arguments> calls;
    for (const auto& one : cases)
        calls.push_back(one.first);
    const std::vector<Outcome> runs = run_all(folder.path(), calls);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        EXPECT_EQ(runs[i].code, 2) << joined(calls[i]) << '\n' << runs[i];
        EXPECT_EQ(runs[i].error_lines(), 1) << joined(calls[i]) << '\n' << runs[i];
        EXPECT_NE(runs[i].err.find(cases[i].second), std::string::npos) << joined(calls[i]) << '\n'
                                                                        << runs[i];
        EXPECT_EQ(runs[i].out, "") << joined(calls[i]);
    }
    EXPECT_TRUE(list(folder.path()).empty()) << "nothing was written";
}

TEST(Show, ABarOfColoursStandsUnderAPicture)
{
    const TempFolder folder;
    Outcome run = run_program(folder.path(), show("bricks", {"-o", "x.png"}));
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_NE(run.out.find("wrote x.png\n"), std::string::npos) << "no exposure: " << run;
    run = run_program(folder.path(), show("scattering", {"-o", "y.png", "--exposure=2"}));
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_NE(run.out.find("wrote y.png (exposure +2.00 stops)\n"), std::string::npos) << run;
    const auto height = [&](const char* file) {  // IHDR's, big-endian
        const std::string bytes = read_bytes(folder.path() / file);
        int value = 0;
        for (int i = 20; i < 24; ++i)
            value = value * 256 + static_cast<unsigned char>(bytes.at(static_cast<std::size_t>(i)));
        return value;
    };
    EXPECT_GT(height("x.png"), 54);
    EXPECT_EQ(height("y.png"), 54);
}

}  // namespace
}  // namespace fumarole::test
