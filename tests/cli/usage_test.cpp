// The command line itself: help, versions, and what it refuses with exit code 2.

#include <array>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sstream>

#include "cli/run_program.h"
#include <fumarole/settings.h>

namespace fumarole::test {
namespace {

TEST(Help, GoesToStdoutAndNamesTheCommands)
{
    const TempFolder folder;
    const auto runs =
        run_all(folder.path(),
                {{"--help"}, {"-h"}, {"render", "--help"}, {"info", "--help"}, {"--version"}});
    for (const Outcome& run : runs) {
        EXPECT_EQ(run.code, 0) << run;
        EXPECT_EQ(run.err, "") << run;
    }
    for (const char* command : {"info", "render"})
        EXPECT_NE(runs[0].out.find(command), std::string::npos) << runs[0];
    EXPECT_EQ(runs[0].out, runs[1].out);
    for (const SettingInfo& setting : setting_table()) {
        EXPECT_NE(runs[2].out.find("--" + std::string(setting.name) + " "), std::string::npos)
            << setting.name;
        EXPECT_NE(runs[2].out.find(setting.get(Settings{})), std::string::npos)
            << setting.name << " without its default";
    }
    EXPECT_EQ(std::count(runs[4].out.begin(), runs[4].out.end(), '.'), 2) << runs[4];
    EXPECT_EQ(list(folder.path()).size(), 0u);
}

/// As CLI11 has it, `--size TEXT` says nothing of what is asked for.
TEST(Help, SaysWhatKindOfValueEachOptionTakes)
{
    const TempFolder folder;
    const std::vector<Arguments> commands{
        {"info", "--help"}, {"render", "--help"},    {"compare", "--help"}, {"chart", "--help"},
        {"plan", "--help"}, {"stability", "--help"}, {"bench", "--help"},   {"view", "--help"}};
    std::string all;
    for (const Outcome& run : run_all(folder.path(), commands)) {
        EXPECT_EQ(run.code, 0) << run;
        std::istringstream lines(run.out);
        for (std::string line; std::getline(lines, line);)
            EXPECT_LE(line.size(), 100u) << line;
        all += run.out;
    }
    for (const char* kind : {"TEXT", "INT", "FLOAT", "REQUIRED", "Excludes", "Needs"})
        EXPECT_EQ(all.find(kind), std::string::npos) << kind;
    for (const char* row :
         {"\n  --size WxH ", "\n  --up auto|y|z ", "\n  --frames N|A..B|A..BxS ",
          "\n  -o, --output FOLDER ", "\n  --save-scene FILE.json ", "\n  --time-limit SECONDS ",
          "\n  --held FILE.csv ", "\n  --shard I/N ", "\n  --json    ",
          "surface_lit, transparents, transparents_kept, depth, error\n", "(needs --held)",
          "(not with --held, --shard)"})
        EXPECT_NE(all.find(row), std::string::npos) << row;
    for (const SettingInfo& setting : setting_table())
        EXPECT_NE(all.find(fmt::format("\n  --{} {}", setting.name, setting.values)),
                  std::string::npos)
            << setting.name;
}

TEST(Usage, IsRefusedWithTwoAndTheNameOfWhatIsWrong)
{
    struct Case {
        Arguments arguments;
        std::string named;
    };
    const std::vector<Case> cases{
        {{}, "subcommand"},
        {{"smoke"}, "no command 'smoke'; commands are info, render"},
        {{"rendr"}, "did you mean 'render'?"},
        {{"veiw", "x.vdb"}, "did you mean 'view'?"},
        {{"render", "x.vdb", "--expousre=1"}, "did you mean --exposure?"},
        {{"info"}, "FILE"},
        {{"render"}, "INPUT"},
        {{"render", "--no-such-option", "x.vdb"}, "--no-such-option"},
        {{"render", "x.vdb", "-o", "x.jpg"}, "x.jpg"},
        {{"render", "x.vdb", "-o", "good.png", "-o", "bad"}, "bad"},
        {{"render", "x.vdb", "--time-limit", "9"}, "--time-limit: is for --mode reference"},
        {{"render", "x.vdb", "-o", "x.deep.exr", "--target", "scattering"}, ".deep.exr"},
        {{"render", "x.vdb", "--size", "480"}, "--size"},
        {{"render", "x.vdb", "--size", "0x270"}, "--size"},
        {{"render", "x.vdb", "--size", "-4x270"}, "--size"},
        {{"render", "x.vdb", "--size", "480x270x3"}, "--size"},
        {{"render", "x.vdb", "--size", "99999x9"}, "--size"},
        {{"render", "x.vdb", "--aa", "0"}, "--aa"},
        {{"render", "x.vdb", "--aa", "many"}, "--aa"},
        {{"render", "x.vdb", "--frames", "0"}, "--frames"},
        {{"render", "x.vdb", "--seed", "-1"}, "--seed"},
        {{"render", "x.vdb", "--target", "albedo"}, "--target"},
        {{"render", "x.vdb", "--display", "hdr"}, "--display"},
        {{"render", "x.vdb", "--exposure", "bright"}, "--exposure"},
        {{"render", "x.vdb", "--exposure", "nan"}, "--exposure"},
        {{"render", "x.vdb", "--backend", "vulkan"}, "--backend"},
        {{"render", "x.vdb", "--backend=osmesa", "--device=0"}, "--device"},
        {{"stability", "--backend=osmesa", "--device=0"}, "--device"},
        {{"info"}, "FILE"},
        {{"info", "x.vdb", "--devices"}, "--devices"},
        {{"render", "x.vdb", "--up", "x"}, "--up"},
        {{"render", "x.vdb", "--mode", "magic"}, "--mode"},
        {{"render", "x.vdb", "--preset", "eevee2016"}, "--preset"},
        {{"render", "x.vdb", "--alpha", "--target", "depth"}, "--alpha"},
        {{"render", "x.json", "--grid", "density"}, "--grid"},
        {{"render", "x.vdb", "--size"}, "--size"},
        {{"render", "x.vdb", "--tolerance", "0.1"}, "--tolerance"},
        {{"render", "x.vdb", "--region", "0,0,8,0"}, "--region"},
        {{"render", "x.vdb", "--show=steps", "--region", "0,0,8,8"}, "--region"},
        {{"render", "x.vdb", "--target", "error"}, "--target"},
        {{"render", "x.vdb", "--mode=reference", "--tolerance", "0"}, "--tolerance"},
        {{"render", "x.vdb", "--mode=reference", "--region", "0,0,8"}, "--region"},
        {{"render", "x.vdb", "--mode=reference", "--region", "0,0,8,0"}, "--region"},
        {{"render", "x.vdb", "--mode=reference", "--region", "0,-1,8,8"}, "--region"},
        {{"render", "x.vdb", "--mode=reference", "--region", "0,0,8,8,8"}, "--region"},
        {{"render", "x.vdb", "--mode=reference", "--steps", "64"}, "--steps"},
        {{"render", "x.vdb", "--mode=reference", "--preset", "default"}, "--preset"},
        {{"render", "x.vdb", "--mode=reference", "--frames", "3"}, "--frames"},
        {{"render", "x.vdb", "--mode=reference", "--seed", "3"}, "--seed"},
        {{"render", "x.vdb", "--mode=reference", "--backend", "egl"}, "--backend"},
        {{"render", "x.vdb", "--mode=reference", "--device", "0"}, "--device"},
        {{"render", "x.vdb", "--mode=reference", "--alpha"}, "--alpha"},
        {{"render", "x.vdb", "--mode=reference", "--explain"}, "--explain"},
        {{"view", "x.vdb", "--screenshot", "x.jpg"}, "--screenshot: 'x.jpg'"},
        {{"render", "x.vdb", "no\nsuch word"}, "no\\x0asuch word"},
        {{"render", ""}, "INPUT: names no file"},
        {{"render", "a_1.vdb", "a_2.vdb"}, "in quotes, e.g. 'smoke_####.vdb'"},
        {{"render", "x.vdb", "--max-error", "nan"}, "--max-error: 'nan'"},
    };
    const TempFolder folder;
    std::vector<Arguments> arguments;
    for (const Case& c : cases)
        arguments.push_back(c.arguments);
    const std::vector<Outcome> runs = run_all(folder.path(), arguments);
    for (std::size_t i = 0; i < cases.size(); ++i) {
        EXPECT_EQ(runs[i].code, 2) << joined(arguments[i]) << '\n' << runs[i];
        EXPECT_NE(runs[i].err.find(cases[i].named), std::string::npos)
            << joined(arguments[i]) << '\n'
            << runs[i];
        EXPECT_EQ(runs[i].out, "") << joined(arguments[i]);
        EXPECT_EQ(runs[i].error_lines(), 1) << joined(arguments[i]) << '\n' << runs[i];
        EXPECT_EQ(runs[i].err.find("fumarole: "), 0u) << joined(arguments[i]);
    }
    EXPECT_EQ(list(folder.path()).size(), 0u) << "nothing is written";
}

TEST(Usage, EverySettingNamesItselfAndWhatItTakes)
{
    const TempFolder folder;
    std::vector<Arguments> arguments;
    std::vector<const SettingInfo*> settings;
    for (const SettingInfo& setting : setting_table()) {
        // A number is refused for each reason in turns.
        constexpr std::array kBad{"nonsense", "-1", "1e9", "nan"};
        const bool number = setting.values.find("..") != std::string_view::npos;
        arguments.push_back(
            {"render", "x.vdb",
             "--" + std::string(setting.name) + "=" + kBad.at(number ? settings.size() % 4 : 0)});
        settings.push_back(&setting);
    }
    const std::vector<Outcome> runs = run_all(folder.path(), arguments);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const std::string& err = runs[i].err;
        EXPECT_EQ(runs[i].code, 2) << joined(arguments[i]) << '\n' << runs[i];
        EXPECT_EQ(runs[i].error_lines(), 1) << joined(arguments[i]) << '\n' << runs[i];
        EXPECT_NE(err.find("--" + std::string(settings[i]->name) + ":"), std::string::npos) << err;
        EXPECT_NE(err.find(settings[i]->values), std::string::npos) << err;
    }
}

TEST(Usage, TellsOfASettingsOldName)
{
    const TempFolder folder;
    const Outcome old =
        run_program(folder.path(), {"render", "x.vdb", "--skip=nonsense", "--world-cache", "8"});
    EXPECT_EQ(old.code, 2) << old;
    EXPECT_EQ(old.err.find("fumarole: --skip is now called --empty-space-skipping; the old name is "
                           "accepted by this release only\n"
                           "fumarole: --world-cache is now called --ambient-volume-size;"),
              0u)
        << old;
    EXPECT_NE(old.err.find("--empty-space-skipping: 'nonsense'"), std::string::npos) << old;
    EXPECT_EQ(old.error_lines(), 3) << old;
    // What is no option is left as it is.
    const Outcome file = run_program(folder.path(), {"info", "--", "--skip"});
    EXPECT_EQ(file.error_lines(), 1) << file;
    EXPECT_NE(file.err.find("--skip: "), std::string::npos) << file;
    const Outcome help = run_program(folder.path(), {"render", "--help"});
    EXPECT_EQ(help.out.find("--skip"), std::string::npos) << "only the present name is shown";
}

}  // namespace
}  // namespace fumarole::test
