// Files that are not there, not what they say, damaged or not to be written: exit code 1, one line
// that names the file, and nothing half done.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "cli/run_program.h"
#include "study/handmade_vdb.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

void expect_refused(const Outcome& run, const std::string& what,
                    const std::vector<std::string>& named)
{
    EXPECT_EQ(run.code, 1) << what << '\n' << run;
    EXPECT_EQ(run.error_lines(), 1) << what << '\n' << run;
    EXPECT_EQ(run.err.rfind("fumarole: ", 0), 0u) << what << '\n' << run;
    for (const std::string& name : named)
        EXPECT_NE(run.err.find(name), std::string::npos) << what << ": no " << name << '\n' << run;
}

constexpr const char* kSmall = "--size=32x18";

/// A fog over nothing: the quickest scene there is.
std::string scene(const std::string& extra = "", const std::string& medium_extra = "")
{
    return fmt::format(R"({{
 "camera": {{"position": [0,-10,0], "look_at": [0,0,0], "vfov_deg": 30}},
 "lights": [{{"type": "sun", "direction_to_light": [0,0,1], "irradiance_W_per_m2": [3,3,3]}}],
 {}
 "media": [{{"type": "box", "min": [-1,-1,-1], "max": [1,1,1], "profile": "homogeneous",
            "sigma_s": [1,1,1], {} "sigma_a": [0,0,0]}}]
}})",
                       extra, medium_extra);
}

/// A file whose values are all there, 2 KB a brick.
std::string smoke_of(int bricks)
{
    study::HandmadeVdb made;
    for (int i = 0; i < bricks; ++i) {
        study::HandmadeBrick& brick = made.bricks.emplace_back();
        brick.brick = {i % 64, i / 64 % 64, i / 4096};
        for (std::size_t v = 0; v < brick.values.size(); ++v)
            brick.values[v] = 0.5f + 0.001f * static_cast<float>(v);
    }
    return study::handmade_vdb(made);
}

/// A scene of several files, each of which is read.
std::string scene_of_files(int files)
{
    std::string media;
    for (int i = 0; i < files; ++i)
        media += fmt::format(R"({}{{"type": "vdb", "file": "{}.vdb", "grid": "density",
  "sigma_s_per_density": [1,1,1], "sigma_a_per_density": [0,0,0]}})",
                             i == 0 ? "" : ",\n", i);
    return fmt::format(R"({{"camera": {{"position": [0,-10,0], "look_at": [0,0,0], "vfov_deg": 30}},
 "media": [{}]}})",
                       media);
}

TEST(Input, IsReadNoFurtherOnceInterrupted)
{
    // The same file under twelve names: seconds of reading.
    const TempFolder folder;
    folder.write("0.vdb", smoke_of(24000));
    for (int i = 1; i < 12; ++i)
        fs::create_hard_link(folder.path() / "0.vdb", folder.path() / fmt::format("{}.vdb", i));
    folder.write("scene.json", scene_of_files(12));
    const std::vector<std::string> before = list(folder.path());
    for (const Arguments& more :
         {Arguments{}, Arguments{"--mode=reference"}, Arguments{"--show=bricks"}}) {
        Arguments command{"render", "scene.json", kSmall, "-o", "x.png"};
        command.insert(command.end(), more.begin(), more.end());
        RunOptions soon;
        soon.interrupt_at_mb = 250;  // of them the program itself takes a hundred at most
        const Outcome run = run_program(folder.path(), command, soon);
        expect_refused(run, joined(command),
                       {"interrupted while ", ".vdb was read", "nothing was"});
        EXPECT_EQ(run.err.find("while 11.vdb"), std::string::npos) << "the last one";
        EXPECT_EQ(list(folder.path()), before) << joined(command);
    }
}

TEST(Input, ThatTakesMoreMemoryThanItMayIsNamed)
{
    const TempFolder folder;
    folder.write("smoke.vdb", smoke_of(2000));  // 4.4 MB, and as much again for tree and bricks
    const auto render = [&](const char* limit) {
        return run_program(folder.path(),
                           with_little_light({"render", "smoke.vdb", kSmall, "--aa=1", "-o",
                                              "x.png", "--max-memory", limit}));
    };
    for (const char* limit : {"1M", "6M", "10000000"}) {
        const Outcome run = render(limit);
        expect_refused(run, limit, {"smoke.vdb", "too large", "--max-memory"});
        EXPECT_FALSE(fs::exists(folder.path() / "x.png"));
    }
    EXPECT_EQ(render("20M").code, 0);
    EXPECT_TRUE(fs::exists(folder.path() / "x.png"));
    const Outcome first = run_program(folder.path(), {"--max-memory=1M", "info", "smoke.vdb"});
    expect_refused(first, "before the command", {"smoke.vdb", "too large"});
    const Outcome nonsense = run_program(folder.path(), {"info", "smoke.vdb", "--max-memory=much"});
    EXPECT_EQ(nonsense.code, 2) << nonsense;
}

TEST(Input, ThatIsNoVdbIsNamed)
{
    const TempFolder folder;
    folder.write("empty.vdb", "");
    folder.write("text.vdb", "this is no volume\n");
    fs::create_directory(folder.path() / "folder.vdb");
    const std::string whole = read_bytes(sample("fire_plume.vdb"));
    std::vector<std::string> names{"none.vdb", "empty.vdb", "text.vdb", "folder.vdb",
                                   "no/where.vdb"};
    for (const std::size_t bytes : {4u, 30u, 200u, 3000u, 60000u, 470000u}) {
        names.push_back(fmt::format("cut_at_{}.vdb", bytes));
        folder.write(names.back(), whole.substr(0, bytes));
    }
    std::vector<Arguments> arguments;
    for (const std::string& name : names) {
        arguments.push_back({"render", name, kSmall, "--aa=1", "-o", "x.png"});
        arguments.push_back({"info", name});
    }
    const std::vector<Outcome> runs = run_all(folder.path(), arguments);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        expect_refused(runs[i], joined(arguments[i]), {arguments[i][1]});
        EXPECT_EQ(runs[i].out, "") << joined(arguments[i]);
    }
    EXPECT_FALSE(fs::exists(folder.path() / "x.png"));
}

TEST(Input, WhoseNameWouldEndTheLineIsNamedInOne)
{
    const TempFolder folder;
    folder.write("a\nb.vdb", "this is no volume\n");
    folder.write("a\nb.json", "[");
    for (const Arguments& command :
         std::vector<Arguments>{{"info", "a\nb.vdb"},
                                {"info", "none\nb.vdb"},
                                {"render", "--aa=1", "a\nb.json", kSmall},
                                {"compare", "a\nb.exr", "c.exr"}})
        expect_refused(run_program(folder.path(), command), joined(command), {"\\x0ab."});
}

TEST(Input, DamagedAnywhereNeverCrashes)
{
    const TempFolder folder;
    const std::string whole = read_bytes(sample("fire_plume.vdb"));
    std::vector<Arguments> arguments;
    for (std::size_t i = 0; i < 12; ++i) {
        std::string damaged = whole;
        // Heads and trees lie at the file's beginning, compressed values all over.
        const std::size_t at = i < 6 ? 20 + i * 131 : whole.size() * (i - 5) / 7;
        for (std::size_t k = 0; k < 4; ++k)
            damaged[at + k] = static_cast<char>(damaged[at + k] ^ (0x5a + 37 * k));
        const std::string name = fmt::format("damaged_at_{}.vdb", at);
        folder.write(name, damaged);
        arguments.push_back(
            with_little_light({"render", name, kSmall, "--aa=1", "-o", name + ".png"}));
    }
    const std::vector<Outcome> runs = run_all(folder.path(), arguments);
    int refused = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const bool written = fs::exists(folder.path() / (arguments[i][1] + ".png"));
        EXPECT_EQ(written, runs[i].code == 0) << joined(arguments[i]) << '\n' << runs[i];
        if (runs[i].code == 0)
            continue;  // a value or a comment: nothing to notice
        ++refused;
        expect_refused(runs[i], joined(arguments[i]), {arguments[i][1]});
    }
    EXPECT_GT(refused, 0);
}

TEST(Input, WithAHashInItsNameIsThatFile)
{
    const TempFolder folder;
    fs::copy_file(sample("fire_plume.vdb"), folder.path() / "take#2.vdb");
    const Outcome run = run_program(folder.path(), {"render", "--aa=1", "take#2.vdb", kSmall});
    EXPECT_EQ(run.code, 0) << run;
    EXPECT_TRUE(fs::exists(folder.path() / "take#2.png")) << run;
    EXPECT_EQ(run_program(folder.path(), {"info", "take#2.vdb"}).code, 0);
}

TEST(Input, GridsThatAreNotThereAreNamedWithThoseThatAre)
{
    const TempFolder folder;
    const Outcome run = run_program(folder.path(), {"render", "--aa=1", sample("fire_plume.vdb"),
                                                    "--grid", "smoke", kSmall, "-o", "x.png"});
    expect_refused(run, "--grid smoke", {"fire_plume.vdb", "smoke", "density", "flame"});
}

TEST(SceneFile, ATemperatureThatIsNotThereOrWrongIsNamed)
{
    const TempFolder folder;
    const auto refused = [&](const char* name, const std::string& keys,
                             const std::vector<std::string>& named) {
        folder.write(name, fmt::format(R"({{"camera": {{"position": [0,-10,0], "look_at": [0,0,0],
 "vfov_deg": 30}}, "media": [{{"type": "vdb", "file": "{}", "grid": "density",
 "sigma_s_per_density": [1,1,1], {}}}]}})",
                                       sample("fire_plume.vdb"), keys));
        expect_refused(
            run_program(folder.path(), {"render", "--aa=1", name, kSmall, "-o", "x.png"}), name,
            named);
    };
    refused("missing.json", R"("temperature_grid": "hot")",
            {"fire_plume.vdb", "no grid 'hot' (has: ", "'temperature'"});
    refused("alone.json", R"("blackbody_intensity": 2)",
            {"alone.json", "media[0]", "'blackbody_intensity' needs 'temperature_grid'"});
    refused("cold.json", R"("temperature_grid": "temperature", "temperature_scale": -1)",
            {"cold.json", "media[0].temperature_scale", "kelvin per unit", "got -1"});
}

TEST(SceneFile, ThatIsWrongIsNamedWithThePlace)
{
    const TempFolder folder;
    struct Case {
        std::string file, text;
        std::vector<std::string> named;
    };
    const std::vector<Case> cases{
        {"unknown_key.json", scene("\"fog\": 1,"), {"fog"}},
        {"unknown_medium_key.json", scene("", "\"sigma_x\": 1,"), {"media[0]", "sigma_x"}},
        {"negative.json", scene("", "\"g\": 1.5,"), {"media[0]", "g"}},
        {"no_json.json", "{ \"media\": [ }", {"line 1"}},
        {"empty.json", "", {}},
        {"list.json", "[1, 2]", {}},
        {"no_file.json",
         R"({"camera": {"position": [0,-10,0], "look_at": [0,0,0], "vfov_deg": 30},
             "media": [{"type": "vdb", "file": "not_there.vdb", "grid": "density",
             "sigma_s_per_density": [1,1,1], "sigma_a_per_density": [0,0,0]}]})",
         {"not_there.vdb"}},
    };
    std::vector<Arguments> arguments;
    for (const Case& c : cases) {
        folder.write(c.file, c.text);
        arguments.push_back({"render", "--aa=1", c.file, kSmall, "-o", "x.png"});
    }
    arguments.push_back({"render", "none.json", "-o", "x.png"});
    const std::vector<Outcome> runs = run_all(folder.path(), arguments);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        std::vector<std::string> named = cases[i].named;
        if (cases[i].file != "no_file.json")
            named.push_back(cases[i].file);
        expect_refused(runs[i], joined(arguments[i]), named);
    }
    expect_refused(runs.back(), "none.json", {"none.json"});
    EXPECT_FALSE(fs::exists(folder.path() / "x.png"));
}

TEST(Output, ThatCantBeWrittenIsNamedAndLeavesNothing)
{
    const TempFolder folder;
    folder.write("fog.json", scene());
    folder.write("file", "");
    fs::create_directory(folder.path() / "folder.png");
    for (const std::string output :
         {"no_folder/x.png", "no_folder/x.exr", "file/x.png", "folder.png"}) {
        const std::vector<std::string> before = list(folder.path());
        expect_refused(
            run_program(folder.path(), {"render", "--aa=1", "fog.json", kSmall, "-o", output}),
            output, {output});
        EXPECT_EQ(list(folder.path()), before);
    }
    expect_refused(run_program(folder.path(), {"render", "--aa=1", "fog.json", kSmall, "-o",
                                               "x.png", "--save-scene", "no_folder/s.json"}),
                   "--save-scene", {"no_folder/s.json"});
}

TEST(Output, InAFolderThatTakesNoneIsNotCalledMissing)
{
    const TempFolder folder;
    folder.write("fog.json", scene());
    fs::create_directory(folder.path() / "locked");
    fs::permissions(folder.path() / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    std::vector<std::string> outputs{"/proc/x.png"};
    if (geteuid() != 0)  // whom no right is missing
        outputs.emplace_back("locked/x.png");
    for (const std::string& output : outputs) {
        const Outcome run =
            run_program(folder.path(), {"render", "--aa=1", "fog.json", kSmall, "-o", output});
        expect_refused(run, output, {output, fs::path(output).parent_path().string()});
        EXPECT_EQ(run.err.find("no such folder"), std::string::npos) << run;
    }
    const Outcome missing =
        run_program(folder.path(), {"render", "--aa=1", "fog.json", kSmall, "-o", "none/x.png"});
    expect_refused(missing, "none/x.png", {"no such folder 'none'; create it first"});
}

TEST(Output, EndsInAnyCase)
{
    const TempFolder folder;
    folder.write("fog.JSON", scene());
    const Outcome run = run_program(folder.path(), {"render", "--aa=1", "fog.JSON", kSmall, "-o",
                                                    "x.PNG", "-o", "x.Exr", "-o", "y.png"});
    EXPECT_EQ(run.code, 0) << run;
    EXPECT_EQ(read_bytes(folder.path() / "x.PNG"), read_bytes(folder.path() / "y.png"));
    EXPECT_TRUE(fs::exists(folder.path() / "x.Exr"));
}

TEST(Output, OnAFullDiskKeepsTheOldFileWhole)
{
    const TempFolder folder;
    folder.write("fog.json", scene());
    for (const std::string output : {"x.png", "x.exr"}) {
        const Arguments command{"render", "--aa=1", "fog.json", "--size=160x90", "-o", output};
        RunOptions full;
        full.file_limit = 500;
        const std::vector<std::string> before = list(folder.path());
        expect_refused(run_program(folder.path(), command, full), output, {output});
        EXPECT_EQ(list(folder.path()), before) << "nothing half written";

        ASSERT_EQ(run_program(folder.path(), command).code, 0);
        const std::string old = read_bytes(folder.path() / output);
        EXPECT_GT(old.size(), 500u);
        const std::vector<std::string> with_old = list(folder.path());
        expect_refused(run_program(folder.path(), command, full), output, {output});
        EXPECT_EQ(list(folder.path()), with_old);
        EXPECT_EQ(read_bytes(folder.path() / output), old);
    }
}

TEST(Output, StdoutThatIsFullIsAnError)
{
    if (!fs::exists("/dev/full"))
        GTEST_SKIP() << "no /dev/full here";
    const TempFolder folder;
    folder.write("fog.json", scene());
    for (const Arguments& command :
         {Arguments{"info", sample("smoke_plume.vdb"), "--json"}, Arguments{"--help"},
          Arguments{"render", "--aa=1", "fog.json", kSmall, "-o", "x.png", "--json"}}) {
        RunOptions full;
        full.out = "/dev/full";
        const Outcome run = run_program(folder.path(), command, full);
        expect_refused(run, joined(command), {"standard output"});
    }
}

TEST(Output, NamesMayHaveSpacesAndAnyLetters)
{
    const TempFolder folder;
    const fs::path odd = folder.path() / "Rauch \xc3\xbc\x62\x65r 'allem' $x";
    fs::create_directory(odd);
    fs::copy_file(sample("fire_plume.vdb"), odd / "f\xc3\xa9u 1.vdb");
    const Outcome run = run_program(
        odd, {"render", "--aa=1", "f\xc3\xa9u 1.vdb", kSmall, "--save-scene", "sc\xc3\xa8ne.json"});
    EXPECT_EQ(run.code, 0) << run;
    EXPECT_EQ(list(odd), (std::vector<std::string>{"f\xc3\xa9u 1.png", "f\xc3\xa9u 1.vdb",
                                                   "sc\xc3\xa8ne.json"}));
    const Outcome again =
        run_program(odd, {"render", "--aa=1", "sc\xc3\xa8ne.json", kSmall, "-o", "2.png"});
    EXPECT_EQ(again.code, 0) << again;
    EXPECT_EQ(read_bytes(odd / "2.png"), read_bytes(odd / "f\xc3\xa9u 1.png"));
}

}  // namespace
}  // namespace fumarole::test
