// `fumarole render --frames A..B`: moving pictures as a user makes them.

#include <fmt/format.h>
#include <future>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/run_program.h"
#include "support/make_vdb.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// A camera that passes by the sample smoke.
std::string passing_by()
{
    return fmt::format(
        R"({{"resolution": [48, 27], "frames_per_second": 8,
 "camera": [{{"time": 0, "position": [-2,-10,2.5], "look_at": [0,0,2], "vfov_deg": 32, "near": 0.1, "far": 60}},
            {{"time": 1, "position": [2,-10,2.5], "look_at": [0,0,2]}}],
 "lights": [{{"type": "sun", "direction_to_light": [-0.7,-0.2,0.7], "irradiance_W_per_m2": [5,5,4]}}],
 "media": [{{"type": "vdb", "file": "{}/smoke_plume.vdb", "sigma_s_per_density": [6,8,13]}}],
 "surfaces": [{{"type": "box", "min": [-60,-60,-1], "max": [60,60,0], "albedo": [0.2,0.2,0.2]}}]}})",
        FUM_TEST_DATA);
}

class Moving : public testing::Test {
protected:
    Outcome render(const Arguments& rest) const
    {
        Arguments all{"render"};
        all.insert(all.end(), rest.begin(), rest.end());
        const bool reference =
            std::find(rest.begin(), rest.end(), "--mode=reference") != rest.end();
        if (reference)
            all.emplace_back("--tolerance=0.3");
        return run_program(folder_.path(), reference ? all : with_little_light(std::move(all)));
    }
    [[nodiscard]] std::vector<float> picture(const std::string& name) const
    {
        return write::read_exr(folder_.path() / name, {"R", "G", "B"}).pixels;
    }
    TempFolder folder_;
};

TEST_F(Moving, EachFrameIsTheStillOfItsMoment)
{
    folder_.write("path.json", passing_by());
    const Outcome run =
        render({"path.json", "--frames=0..4", "--jitter=none", "-o", "x.##.exr", "--json"});
    ASSERT_EQ(run.code, 0) << run;
    const Json json = Json::parse(run.out);
    ASSERT_EQ(json["frames"].size(), 5u);
    EXPECT_EQ(json["frames"][4]["outputs"][0], "x.04.exr");
    EXPECT_GT(json["frames"][0]["setup_ms"].get<double>(), 0);
    EXPECT_EQ(json["frames"][3]["setup_ms"], 0) << "only the camera moves: nothing is uploaded";
    // Half way, from a scene file that has the camera there.
    folder_.write("still.json", [] {
        std::string text = passing_by();
        const auto from = text.find("[{\"time\""), to = text.find("\"lights\"");
        return text.replace(from, to - from,
                            R"({"position": [0,-10,2.5], "look_at": [0,0,2], "vfov_deg": 32,
                                "near": 0.1, "far": 60},)");
    }());
    const Outcome still = render({"still.json", "--jitter=none", "--aa=1", "-o", "still.exr"});
    ASSERT_EQ(still.code, 0) << still;
    EXPECT_EQ(picture("x.04.exr"), picture("still.exr"));
    EXPECT_NE(picture("x.00.exr"), picture("x.04.exr"));
}

// What a process leaves that is killed: a lock that no one holds, and, of a copy that did not end,
// half a file.
TEST_F(Moving, ProcessesShareFramesAndOneThatIsKilledIsNoLoss)
{
    folder_.write("path.json", passing_by());
    const auto args = [](const std::string& output) {
        return Arguments{"path.json", "--frames=0..3", "--aa=2", "--resume", "-o", output};
    };
    const Outcome alone = render(args("one.#.exr"));
    ASSERT_EQ(alone.code, 0) << alone;
    EXPECT_NE(alone.out.find("drew 4 of the 4 frames"), std::string::npos) << alone;

    folder_.write("two.0.exr.lock", "");
    const std::string bytes = read_bytes(folder_.path() / "one.1.exr");
    folder_.write("two.1.exr", bytes.substr(0, bytes.size() / 2));
    auto other = std::async(std::launch::async, [&] { return render(args("two.#.exr")); });
    const Outcome one = render(args("two.#.exr"));
    const Outcome two = other.get();
    ASSERT_EQ(one.code, 0) << one;
    ASSERT_EQ(two.code, 0) << two;
    for (int frame = 0; frame < 4; ++frame) {
        const auto name = [&](const char* of) { return fmt::format("{}.{}.exr", of, frame); };
        EXPECT_EQ(picture(name("one")), picture(name("two"))) << frame;
        EXPECT_FALSE(fs::exists(folder_.path() / (name("two") + ".lock")));
    }
    const auto written = fs::last_write_time(folder_.path() / "two.2.exr");
    const Outcome again = render(args("two.#.exr"));
    EXPECT_NE(again.out.find("drew 0 of the 4 frames; 4 were there and whole"), std::string::npos)
        << again;
    EXPECT_EQ(fs::last_write_time(folder_.path() / "two.2.exr"), written);

    for (const Arguments& wrong :
         {Arguments{"path.json", "--resume", "-o", "x.exr"},
          {"path.json", "--resume", "--frames=0..1", "-o", "x.#.png"},
          {"path.json", "--resume", "--frames=0..1", "--temporal=on", "-o", "x.#.exr"},
          {"path.json", "--resume", "--frames=0..1", "--missing-frames=hold", "-o", "x.#.exr"}}) {
        const Outcome refused = render(wrong);
        EXPECT_EQ(refused.code, 2) << refused;
        EXPECT_NE(refused.err.find("--resume"), std::string::npos) << refused;
    }
}

TEST_F(Moving, AHistoryIsKeptWhileTheCameraMoves)
{
    folder_.write("path.json", passing_by());
    for (const char* keeper : {"--mode=froxel", "--temporal=on"}) {
        const Outcome run =
            render({"path.json", "--frames=0..2", keeper, "-o", "x.#.exr", "--json"});
        ASSERT_EQ(run.code, 0) << run;
        const Json frames = Json::parse(run.out)["frames"];
        EXPECT_EQ(frames[0]["history"], "none: first frame") << keeper;
        EXPECT_EQ(frames[1]["history"], "reprojected") << keeper;
        EXPECT_EQ(frames[2]["history"], "reprojected") << keeper;
    }
    // A march keeps none unless asked, and none of a still.
    const Outcome plain = render({"path.json", "--frames=0..1", "-o", "y.#.exr", "--json"});
    ASSERT_EQ(plain.code, 0) << plain;
    EXPECT_EQ(Json::parse(plain.out)["frames"][1]["history"], "");
    EXPECT_EQ(picture("x.0.exr"), picture("y.0.exr")) << "the first frame is as it is without";
    EXPECT_NE(picture("x.1.exr"), picture("y.1.exr"));
    for (const char* temporal : {"on", "off"}) {
        const Outcome still = render({"path.json", "--temporal", temporal, "--explain", "-o",
                                      std::string(temporal) + ".exr"});
        ASSERT_EQ(still.code, 0) << still;
        EXPECT_EQ(still.out.find("reprojected") != std::string::npos, *(temporal + 1) == 'n')
            << still;
    }
    EXPECT_EQ(picture("on.exr"), picture("off.exr"));
}

TEST_F(Moving, SequencesOfFilesAreFollowed)
{
    for (int frame : {3, 4})
        fs::copy_file(fs::path(FUM_TEST_DATA) / (frame == 3 ? "smoke_plume.vdb" : "fire_plume.vdb"),
                      folder_.path() / fmt::format("s_{:03}.vdb", frame));
    const Outcome run =
        render({"s_###.vdb", "--size=48x27", "--frames=3..4", "-o", "x.#.exr", "-o", "x.#.png"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_NE(run.out.find("wrote frames 3..4"), std::string::npos) << run;
    EXPECT_NE(run.out.find("fitted to 2 frames, 3 to 4"), std::string::npos) << run;
    EXPECT_NE(picture("x.3.exr"), picture("x.4.exr"));
    EXPECT_TRUE(fs::exists(folder_.path() / "x.4.png"));

    const Outcome one = render({"s_###.vdb", "--size=48x27", "-o", "one.exr"});
    ASSERT_EQ(one.code, 0) << one;
    EXPECT_NE(one.out.find("frame 3 of s_###.vdb"), std::string::npos) << one;
}

TEST_F(Moving, FramesBeforeZeroStepsAndOtherPatternsAreFollowed)
{
    for (const char* name : {"s.-002.vdb", "s.-001.vdb", "s.0000.vdb", "s.0001.vdb", "s.0002.vdb"})
        fs::copy_file(sample("smoke_plume.vdb"), folder_.path() / name);
    for (const char* pattern : {"s.####.vdb", "s.%04d.vdb", "s.$F4.vdb", "s.@@@@.vdb"}) {
        const Outcome run = render(
            {pattern, "--size=16x9", "--steps=8", "--frames", "-2..2x2", "-o", "x.%03d.png"});
        ASSERT_EQ(run.code, 0) << run;
        for (const char* output : {"x.-02.png", "x.000.png", "x.002.png"})
            EXPECT_TRUE(fs::remove(folder_.path() / output)) << pattern << ' ' << output;
        EXPECT_FALSE(fs::exists(folder_.path() / "x.001.png"));
        const Outcome info = run_program(folder_.path(), {"info", pattern});
        EXPECT_NE(info.out.find("frames -2..2\n"), std::string::npos) << info;
    }
}

TEST_F(Moving, AMissingFrameIsHeldOrLeftOutIfTold)
{
    for (const int frame : {1, 3})
        fs::copy_file(sample("smoke_plume.vdb"), folder_.path() / fmt::format("s_{}.vdb", frame));
    folder_.write("s_4.vdb", "no VDB");
    const Arguments words{"s_#.vdb", "--size=16x9", "--jitter=none", "--frames=1..4"};
    Arguments hold = words, skip = words;
    hold.insert(hold.end(), {"--missing-frames=hold", "-o", "h.#.exr"});
    skip.insert(skip.end(), {"--missing-frames=skip", "-o", "s.#.exr"});
    const Outcome held = render(hold), skipped = render(skip);
    ASSERT_EQ(held.code, 0) << held;
    ASSERT_EQ(skipped.code, 0) << skipped;
    EXPECT_NE(held.out.find("frame 2 is missing"), std::string::npos) << held;
    EXPECT_EQ(picture("h.2.exr"), picture("h.1.exr"));
    EXPECT_EQ(picture("h.4.exr"), picture("h.1.exr"));
    EXPECT_FALSE(fs::exists(folder_.path() / "s.2.exr"));
    EXPECT_FALSE(fs::exists(folder_.path() / "s.4.exr"));
    EXPECT_EQ(picture("s.3.exr"), picture("h.1.exr"));
}

TEST_F(Moving, AnEmptyFrameShowsTheEmptyScene)
{
    write_vdb(folder_.path() / "s_1.vdb", {VdbGrid{}});
    fs::copy_file(sample("smoke_plume.vdb"), folder_.path() / "s_2.vdb");
    write_vdb(folder_.path() / "s_3.vdb", {});
    const Outcome run = render({"s_#.vdb", "--size=32x18", "--jitter=none", "--frames=1..3", "-o",
                                "x.#.exr", "--save-scene=s.json"});
    ASSERT_EQ(run.code, 0) << run;
    for (const char* empty : {"x.1.exr", "x.3.exr"}) {
        EXPECT_EQ(
            picture(empty),
            write::read_exr(folder_.path() / empty, {"surface.R", "surface.G", "surface.B"}).pixels)
            << empty;
    }
    EXPECT_NE(picture("x.2.exr"), picture("x.1.exr"));
    // The still of a sequence is the first frame that there is something to see in.
    const Outcome still =
        render({"s_#.vdb", "--size=32x18", "--jitter=none", "--aa=1", "-o", "y.exr"});
    ASSERT_EQ(still.code, 0) << still;
    EXPECT_NE(still.out.find("frame 2 of s_#.vdb"), std::string::npos) << still;
    EXPECT_EQ(picture("y.exr"), picture("x.2.exr"));
}

TEST_F(Moving, AFlameThatIsEmptyOrMissingLeavesTheSmokeDark)
{
    VdbGrid smoke, flame;
    for (int i = 0; i < 512; ++i)
        smoke.voxels.push_back({{i % 8, i / 8 % 8, i / 64}, glm::dvec3(0.5)});
    flame.name = "flame";
    write_vdb(folder_.path() / "f_1.vdb", {smoke, flame});
    write_vdb(folder_.path() / "f_2.vdb", {smoke});
    flame.voxels = smoke.voxels;
    write_vdb(folder_.path() / "f_3.vdb", {smoke, flame});
    const auto scene = [&](const std::string& file, const std::string& emission) {
        return fmt::format(
            R"({{"resolution": [32, 18],
 "camera": {{"position": [3.5,-20,3.5], "look_at": [3.5,3.5,3.5], "vfov_deg": 40}},
 "lights": [{{"type": "sun", "direction_to_light": [-0.7,-0.2,0.7], "irradiance_W_per_m2": [5,5,4]}}],
 "media": [{{"type": "vdb", "file": "{}", "grid": "density", {} "sigma_s_per_density": [0.4,0.4,0.4]}}]}})",
            file, emission);
    };
    const std::string glow = R"("emission_grid": "flame", "emission_per_unit": [3,1,0.2],)";
    folder_.write("empty.json", scene("f_1.vdb", glow));
    folder_.write("dark.json", scene("f_1.vdb", ""));
    folder_.write("moving.json", scene("f_#.vdb", glow));
    for (const char* mode : {"raymarch", "froxel", "reference"}) {
        const std::string word = fmt::format("--mode={}", mode);
        for (const char* name : {"empty", "dark"}) {
            const Outcome run =
                render({fmt::format("{}.json", name), word, "-o", fmt::format("{}.exr", name)});
            ASSERT_EQ(run.code, 0) << run;
        }
        EXPECT_EQ(picture("empty.exr"), picture("dark.exr")) << mode;
    }
    const Outcome run = render({"moving.json", "--jitter=none", "--frames=1..3", "-o", "m.#.exr"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_EQ(picture("m.1.exr"), picture("m.2.exr"));
    EXPECT_NE(picture("m.1.exr"), picture("m.3.exr"));
}

TEST_F(Moving, AMissingFrameEndsItAndThoseBeforeStay)
{
    fs::copy_file(fs::path(FUM_TEST_DATA) / "smoke_plume.vdb", folder_.path() / "s_1.vdb");
    const Outcome run = render({"s_#.vdb", "--size=48x27", "--frames=1..2", "-o", "x.#.png"});
    EXPECT_EQ(run.code, 1) << run;
    EXPECT_EQ(run.error_lines(), 1) << run;
    for (const char* part : {"s_2.vdb", "frame 2 is missing", "the last 1"})
        EXPECT_NE(run.err.find(part), std::string::npos) << part << '\n' << run;
    EXPECT_TRUE(fs::exists(folder_.path() / "x.1.png"));
    EXPECT_FALSE(fs::exists(folder_.path() / "x.2.png"));
}

TEST_F(Moving, WrongWordsAreRefused)
{
    folder_.write("path.json", passing_by());
    for (const auto& [arguments, named] : std::vector<std::pair<Arguments, const char*>>{
             {{"path.json", "--frames=2..1"}, "--frames"},
             {{"path.json", "--frames=1..9x0"}, "--frames"},
             {{sample("smoke_plume.vdb"), "--frames=1..2"}, "is one file"},
             {{"path.json", "--frames=1..x"}, "--frames"},
             {{"path.json", "--frames=0"}, "--frames"},
             {{"path.json", "--frames=1..2", "-o", "x.png"}, "has no #"}}) {
        const Outcome run = render(arguments);
        EXPECT_EQ(run.code, 2) << run;
        EXPECT_NE(run.err.find(named), std::string::npos) << run;
    }
}

}  // namespace
}  // namespace fumarole::test
