// `fumarole bench` as a user runs it.

#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/run_program.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

class BenchCommand : public testing::Test {
protected:
    [[nodiscard]] Outcome run(const Arguments& arguments) const
    {
        Arguments all{"bench"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        return run_program(folder_.path(), all);
    }
    TempFolder folder_;
};

TEST_F(BenchCommand, WritesItsFilesAndTellsWhatGrows)
{
    const Outcome run_json =
        run({"--quick", "--group", "lights", "--rounds", "1", "--frames", "1", "--json",
             "--time-limit", "3600"});  // or a busy machine leaves out what it takes for slow
    ASSERT_EQ(run_json.code, 0) << run_json;
    EXPECT_EQ(list(folder_.path() / "bench"),
              (std::vector<std::string>{"bench.csv", "bench.png", "smoke.vdb"}));
    const auto json = nlohmann::json::parse(run_json.out);
    EXPECT_EQ(json["growth"].size(), 1u);
    std::set<std::string> quantities;
    for (const auto& figure : json["figures"]) {
        quantities.insert(figure["quantity"]);
        EXPECT_LE(figure["min"], figure["median"]);
        EXPECT_LE(figure["median"], figure["max"]);
    }
    for (const char* quantity :
         {"volume time", "pass ray march", "GPU memory", "trilinear texels a second"})
        EXPECT_TRUE(quantities.contains(quantity)) << quantity;
    const std::string csv = read_bytes(folder_.path() / "bench/bench.csv");
    EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')),
              json["figures"].size() + 1);
}

TEST_F(BenchCommand, NamesWhatThereWasNoTimeFor)
{
    const Outcome cut =
        run({"--group", "sizes", "--preset", "default", "--time-limit", "3", "-o", "cut"});
    ASSERT_EQ(cut.code, 0) << cut;
    EXPECT_NE(cut.out.find("default at 8294400 pixels"), std::string::npos) << cut;
    // One point of a curve is no curve: a picture only where two sizes fitted.
    const std::vector<std::string> files = list(folder_.path() / "cut");
    EXPECT_EQ(files.front(), "bench.csv");
    EXPECT_EQ(files.back(), "smoke.vdb");
}

TEST_F(BenchCommand, TimesLoadingAndWholePrograms)
{
    const Outcome load = run({"--quick", "--group", "load", "--json", "-o", "load"});
    const auto json = nlohmann::json::parse(load.out);
    double sum = 0, all = 0;
    for (const auto& figure : json["figures"])
        if (figure["group"] == "load")
            (figure["case"] == "all" ? all : sum) += figure["min"].get<double>();
    EXPECT_GT(sum, 0);
    EXPECT_GE(all, sum * 0.999);

    // vdb_render out of sight is no failure of the bench.
    const std::string command = "cd '" + folder_.path().string() +
                                "' && PATH=/nowhere " FUM_PROGRAM
                                " bench --quick --group programs --json -o p >out 2>err";
    [[maybe_unused]] const int code = std::system(command.c_str());
    const auto programs = nlohmann::json::parse(read_bytes(folder_.path() / "out"));
    EXPECT_NE(programs["notes"].dump().find("libopenvdb-tools"), std::string::npos);
    EXPECT_TRUE(std::any_of(programs["goals"].begin(), programs["goals"].end(), [](const auto& g) {
        return g["goal"].template get<std::string>().find("first picture") != std::string::npos;
    })) << programs["goals"];
}

TEST_F(BenchCommand, SaysWhatIsWrongAndListsWithoutWriting)
{
    EXPECT_EQ(run({"--group", "speed"}).code, 2);
    EXPECT_EQ(run({"--preset", "eevee2016"}).code, 2);
    EXPECT_EQ(run({"--time-limit", "0"}).code, 2);
    const Outcome missing = run({"none.vdb"});
    EXPECT_EQ(missing.code, 1);
    EXPECT_NE(missing.err.find("none.vdb"), std::string::npos) << missing;
    const Outcome listed = run({"--list"});
    EXPECT_EQ(listed.code, 0);
    for (const char* part : {"presets, noise: eevee2017\n", "ablation, fog: all but upsample",
                             "sizes, smoke: default at 8294400 pixels", "grids:", "load:"})
        EXPECT_NE(listed.out.find(part), std::string::npos) << part << '\n' << listed;
    EXPECT_EQ(list(folder_.path()), std::vector<std::string>{});
}

}  // namespace
}  // namespace fumarole::test
