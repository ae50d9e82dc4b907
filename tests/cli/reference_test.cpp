// `fumarole render --mode reference` as a user runs it.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/run_program.h"
#include "study/metrics.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

using Json = nlohmann::json;

constexpr const char* kSmall = "--size=48x27";

Arguments reference(const Arguments& more)
{
    Arguments all{"render", sample("smoke_plume_sun.json"), kSmall, "--mode=reference",
                  "--bounces=0"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

TEST(RenderReference, WritesTheTargetsOfARenderAndItsError)
{
    const TempFolder folder;
    const Outcome run = run_program(folder.path(), reference({"--json", "-o", "r.exr"}));
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_EQ(run.err, "") << "no progress where there is no terminal";
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json["size"], (std::vector<int>{48, 27}));
    EXPECT_EQ(json["mode"], "reference");
    EXPECT_EQ(json["tolerance"], 0.001);
    EXPECT_EQ(json["bounces"], 0);
    EXPECT_GT(json["seconds"], 0);

    ASSERT_EQ(run_program(folder.path(), {"render", "--aa=1", sample("smoke_plume_sun.json"),
                                          kSmall, "--resolution=full", "--steps=256",
                                          "--shadow-steps=64", "--bounces=0", "-o", "march.exr"})
                  .code,
              0);
    const auto channels_of = [&](const char* file) {
        std::vector<std::string> names = write::exr_channels(folder.path() / file);
        std::sort(names.begin(), names.end());
        return names;
    };
    std::vector<std::string> expected = channels_of("march.exr");
    expected.insert(std::lower_bound(expected.begin(), expected.end(), "error.Y"), "error.Y");
    EXPECT_EQ(channels_of("r.exr"), expected);

    const auto read = [&](const char* file, const std::vector<std::string>& names) {
        return write::read_exr(folder.path() / file, names).pixels;
    };
    for (const char* target : {"scattering", "transmittance", "surface"}) {
        const std::string name(target);
        const std::vector<std::string> rgb{name + ".R", name + ".G", name + ".B"};
        EXPECT_LT(study::compare(read("march.exr", rgb), read("r.exr", rgb)).relmse, 0.01) << name;
    }
    const std::vector<float> error = read("r.exr", {"error.Y"});
    EXPECT_EQ(static_cast<float>(json["error"]["worst"]),
              *std::max_element(error.begin(), error.end()));
    EXPECT_GT(json["error"]["worst"], 0);
    EXPECT_LT(json["error"]["mean"], json["error"]["worst"]);
    EXPECT_LT(json["error"]["above_tolerance"], 0.01);
}

TEST(RenderReference, BouncesBrightenSmoke)
{
    const TempFolder folder;
    const auto run = [&](const Arguments& more) {
        Arguments all{"render", sample("smoke_plume_sun.json"), kSmall, "--mode=reference"};
        all.insert(all.end(), more.begin(), more.end());
        return run_program(folder.path(), all);
    };
    double before = 0;
    for (const char* bounces : {"0", "1", "all", ""}) {
        Arguments words{"--json", "-o", "r.exr"};
        if (*bounces != 0)
            words.insert(words.end(), {"--bounces", bounces, "--tolerance", "0.2"});
        else
            words.insert(words.end(), {"--region", "20,8,2,2"});
        const Outcome outcome = run(words);
        ASSERT_EQ(outcome.code, 0) << outcome;
        const Json json = Json::parse(outcome.out);
        if (*bounces == 0) {
            EXPECT_EQ(json["bounces"], "all");
            EXPECT_EQ(json["tolerance"], 0.02);
            break;
        }
        EXPECT_EQ(json["bounces"], *bounces == 'a' ? Json("all") : Json(*bounces - '0'));
        double sum = 0;
        for (const float v : write::read_exr(folder.path() / "r.exr", {"scattering.G"}).pixels)
            sum += static_cast<double>(v);
        EXPECT_GT(sum, 1.05 * before) << bounces;
        before = sum;
    }
    for (const char* wrong : {"-1", "many", "2.5", "1x"}) {
        const Outcome outcome = run({std::string("--bounces=") + wrong});
        EXPECT_EQ(outcome.code, 2) << wrong;
        EXPECT_NE(outcome.err.find("--bounces"), std::string::npos) << outcome.err;
    }
}

TEST(RenderReference, SurfaceBouncesBrightenTheCorner)
{
    const TempFolder folder;
    folder.write("corner.json", R"({
        "resolution": [16, 9],
        "camera": {"position": [0, -6, 2], "look_at": [0, 0, 0.5], "vfov_deg": 30},
        "world_radiance": [0.1, 0.1, 0.1],
        "lights": [{"type": "sun", "direction_to_light": [0, -1, 1],
                    "irradiance_W_per_m2": [3, 3, 3]}],
        "media": [{"type": "box", "min": [-1, -1, 0.1], "max": [1, 0, 1], "profile": "homogeneous",
                   "sigma_s": [0.01, 0.01, 0.01], "sigma_a": [0, 0, 0], "g": 0}],
        "surfaces": [{"type": "box", "min": [-9, -9, -1], "max": [9, 9, 0],
                      "albedo": [0.8, 0.8, 0.8]},
                     {"type": "box", "min": [-9, 1, -1], "max": [9, 2, 9],
                      "albedo": [0.8, 0.8, 0.8]}]})");
    const auto run = [&](const Arguments& more) {
        Arguments all{"render", "corner.json", "--mode=reference", "--tolerance=0.1"};
        all.insert(all.end(), more.begin(), more.end());
        return run_program(folder.path(), all);
    };
    double before = 0;
    for (const char* bounces : {"0", "1", "all"}) {
        const Outcome outcome = run({"--json", "--surface-bounces", bounces, "-o", "r.exr"});
        ASSERT_EQ(outcome.code, 0) << outcome;
        EXPECT_EQ(Json::parse(outcome.out)["surface_bounces"],
                  *bounces == 'a' ? Json("all") : Json(*bounces - '0'));
        double sum = 0;
        for (const float v : write::read_exr(folder.path() / "r.exr", {"R"}).pixels)
            sum += static_cast<double>(v);
        EXPECT_GT(sum, 1.05 * before) << bounces;
        before = sum;
    }
    for (const Outcome& wrong :
         {run({"--surface-bounces=-1"}), run({"--surface-bounces=some"}),
          run_program(folder.path(), {"render", "corner.json", "--surface-bounces=17"}),
          run_program(folder.path(), {"compare", "corner.json", "--surface-bounces=1.5"})}) {
        EXPECT_EQ(wrong.code, 2) << wrong;
        EXPECT_NE(wrong.err.find("--surface-bounces"), std::string::npos) << wrong.err;
    }
    // By itself the truth has all of it here, since the picture has it about its small medium: the
    // walls beyond are as far from that truth as before.
    double off = 0;
    for (const char* bounces : {"0", "auto"}) {
        const Outcome outcome =
            run_program(folder.path(), {"compare", "corner.json", "--modes=raymarch", "--json",
                                        "--surface-bounces", bounces});
        ASSERT_EQ(outcome.code, 0) << outcome;
        const Json json = Json::parse(outcome.out);
        EXPECT_EQ(json["surface_bounces"], *bounces == 'a' ? Json("all") : Json(0));
        for (const Json& distance : json["distances"])
            if (distance["against"] == "reference" && distance["target"] == "composite") {
                EXPECT_GT(distance["relmse"], 2 * off);
                off = distance["relmse"];
            }
    }
    EXPECT_GT(off, 0.01);
}

TEST(RenderReference, RegionIsThatPartOfThePicture)
{
    const TempFolder folder;
    const std::vector<Outcome> runs = run_all(
        folder.path(),
        {reference({"-o", "all.exr"}), reference({"-o", "part.exr", "--region", "20,8,10,6"}),
         reference({"-o", "error.exr", "-o", "error.png", "--target", "error"}),
         reference({"-o", "out.exr", "--region", "40,8,10,6"})});
    for (int i = 0; i < 3; ++i)
        ASSERT_EQ(runs[static_cast<std::size_t>(i)].code, 0) << runs[static_cast<std::size_t>(i)];
    const std::vector<std::string> names{"R", "scattering.G", "depth.Z", "error.Y"};
    const Image all = write::read_exr(folder.path() / "all.exr", names);
    const Image part = write::read_exr(folder.path() / "part.exr", names);
    ASSERT_EQ(part.width, 10);
    ASSERT_EQ(part.height, 6);
    EXPECT_EQ(part.whole, glm::ivec2(all.width, all.height));
    EXPECT_EQ(part.origin, glm::ivec2(20, 8));
    // It is compared with where it lies.
    const Outcome same =
        run_program(folder.path(), {"compare", "part.exr", "all.exr", "--max-relmse=0"});
    EXPECT_EQ(same.code, 0) << same;
    EXPECT_NE(same.out.find("10 x 6"), std::string::npos) << same;
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 10; ++x)
            for (int c = 0; c < 4; ++c)
                ASSERT_EQ(part.at(x, y, c), all.at(20 + x, 8 + y, c)) << x << ' ' << y << ' ' << c;

    const Image error = write::read_exr(folder.path() / "error.exr", {"R", "B"});
    for (int x = 0; x < 48; ++x) {
        EXPECT_EQ(error.at(x, 13, 0), all.at(x, 13, 3));
        EXPECT_EQ(error.at(x, 13, 1), all.at(x, 13, 3));
    }

    EXPECT_EQ(runs[3].code, 1) << runs[3];
    EXPECT_NE(runs[3].err.find("48 x 27"), std::string::npos) << runs[3];
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.exr"));
}

TEST(RenderReference, EndsSoonWhenInterruptedAndLeavesNoPicture)
{
    const TempFolder folder;
    RunOptions options;
    options.interrupt_at = "scene.json";  // written when the work begins
    const Outcome run = run_program(folder.path(),
                                    {"render", sample("smoke_plume_sun.json"), "--mode=reference",
                                     "--tolerance=1e-6", "--aa=64", "--save-scene=scene.json", "-o",
                                     "x.exr", "-o", "x.png"},
                                    options);
    EXPECT_EQ(run.code, 1) << run;
    EXPECT_NE(run.err.find("interrupted"), std::string::npos) << run;
    EXPECT_EQ(run.error_lines(), 1) << run;
    for (const std::string& name : list(folder.path()))  // pixels of the sky take no time
        EXPECT_TRUE(name == "scene.json" || name == "x.exr.unfinished") << name;
}

TEST(RenderReference, OneThatWasKilledGoesOnToTheSameBits)
{
    const TempFolder folder;
    const auto command = [](const std::string& output, const Arguments& more = {}) {
        Arguments all{"render",
                      sample("smoke_plume_sun.json"),
                      "--size=128x72",
                      "--mode=reference",
                      "--bounces=0",
                      "--tolerance=1e-4",
                      "-o",
                      output};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    ASSERT_EQ(run_program(folder.path(), command("whole.exr")).code, 0);
    EXPECT_EQ(list(folder.path()), std::vector<std::string>{"whole.exr"});

    RunOptions killed;
    killed.interrupt_at = "x.exr.unfinished";
    killed.signal = SIGKILL;
    const Outcome first = run_program(folder.path(), command("x.exr"), killed);
    ASSERT_EQ(first.code, 1000 + SIGKILL) << first;
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "x.exr"));

    // Another pixel square: it says so, ends before it takes the file's place, and is no more.
    const Outcome other =
        run_program(folder.path(), command("x.exr", {"--aa=16", "--time-limit=0.3"}));
    EXPECT_EQ(other.code, 1) << other;
    for (const char* part : {"x.exr.unfinished: is of another reference: --aa was 1 and is 16",
                             "the time limit of 0.3 s is over", "no picture was written"})
        EXPECT_NE(other.err.find(part), std::string::npos) << part << '\n' << other;

    const Outcome last = run_program(folder.path(), command("x.exr", {"--json"}));
    ASSERT_EQ(last.code, 0) << last;
    EXPECT_NE(last.err.find("x.exr.unfinished: goes on from "), std::string::npos) << last;
    const Json json = Json::parse(last.out);
    EXPECT_GT(json["resumed"], 0);
    EXPECT_LT(json["resumed"], 1);
    std::vector<std::string> channels = write::exr_channels(folder.path() / "x.exr");
    EXPECT_EQ(write::read_exr(folder.path() / "x.exr", channels).pixels,
              write::read_exr(folder.path() / "whole.exr", channels).pixels);
    EXPECT_EQ(list(folder.path()), (std::vector<std::string>{"whole.exr", "x.exr"}));
}

TEST(RenderReference, ATimeLimitKeepsWhatIsDone)
{
    const TempFolder folder;
    const Outcome run = run_program(
        folder.path(), {"render", sample("smoke_plume_sun.json"), "--mode=reference", "--bounces=0",
                        "--tolerance=1e-5", "--time-limit=2", "-o", "x.exr"});
    EXPECT_EQ(run.code, 1) << run;
    for (const char* part : {"the time limit of 2 s is over", "x.exr.unfinished keeps ",
                             "the same command line goes on"})
        EXPECT_NE(run.err.find(part), std::string::npos) << part << '\n' << run;
    EXPECT_EQ(list(folder.path()), std::vector<std::string>{"x.exr.unfinished"});
}

TEST(RenderReference, ATerminalSeesHowFarItIs)
{
    if (!has_terminals())
        GTEST_SKIP() << "needs a pseudo-terminal, and there is no /dev/pts";
    const TempFolder folder;
    RunOptions options;
    options.terminal = true;
    const Outcome run =
        run_program(folder.path(), reference({"--tolerance=1e-4", "-o", "x.png"}), options);
    ASSERT_EQ(run.code, 0) << run;
    for (const char* part : {"reference [", " %", " left"})
        EXPECT_NE(run.err.find(part), std::string::npos) << part << '\n' << run;
    EXPECT_EQ(run.err.find('\n'), std::string::npos) << "one line, drawn over";
    EXPECT_EQ(run.err.substr(run.err.size() - 2), " \r") << "and wiped";
}

}  // namespace
}  // namespace fumarole::test
