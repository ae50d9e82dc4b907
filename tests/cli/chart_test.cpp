// `fumarole chart` as a user runs it: its files, its second run, what it refuses.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/fog_scene.h"
#include "cli/run_program.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

/// Uniform fog.
const std::string kScene = fog_scene("[48, 27]", R"(
    {"type": "box", "min": [-1, -1, 0], "max": [1, 1, 2], "profile": "homogeneous",
     "sigma_s": [0.5, 0.5, 0.5], "sigma_a": [0.1, 0.2, 0.3], "g": 0.2})");

class ChartCommand : public testing::Test {
protected:
    struct Result {
        int exit_code;
        std::string out, err;
    };

    [[nodiscard]] std::string path(const std::string& name) const
    {
        return (folder_.path() / name).string();
    }
    [[nodiscard]] std::string write(const std::string& name, std::string_view text) const
    {
        return folder_.write(name, text).string();
    }

    [[nodiscard]] Result run(const std::vector<std::string>& arguments,
                             const std::string& environment = "") const
    {
        std::string command = environment + " " FUM_PROGRAM " chart";
        for (const std::string& argument : arguments)
            command += " '" + argument + "'";
        command += " >'" + path("out.txt") + "' 2>'" + path("err.txt") + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(path("out.txt")),
                read_bytes(path("err.txt"))};
    }

    /// Names in a folder, the reference's without its key.
    [[nodiscard]] static std::set<std::string> names_in(const std::string& folder)
    {
        std::set<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            names.insert(name.starts_with("reference_") ? "reference" : name);
        }
        return names;
    }

    TempFolder folder_;
};

std::vector<std::vector<std::string>> parse_csv(const std::string& text)
{
    std::vector<std::vector<std::string>> rows{{""}};
    bool quoted = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '"' && quoted && i + 1 < text.size() && text[i + 1] == '"')
            rows.back().back() += text[++i];
        else if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            rows.back().emplace_back();
        else if (c == '\n' && !quoted)
            rows.push_back({""});
        else if (c != '\r' || quoted)
            rows.back().back() += c;
    }
    rows.pop_back();
    return rows;
}

TEST_F(ChartCommand, WritesAllGoesOnFromWhatIsThereAndMergesShares)
{
    const std::string scene = write("fog.json", kScene);
    const std::string folder = path("a chart");
    // A busy machine must not leave points to the second run.
    const Arguments command{"chart",  "fog.json", "--quick", "--tolerance=0.2", "--time-limit=900",
                            "--json", "-o",       "a chart"};
    RunOptions options;
    options.interrupt_at = "a chart/chart.partial.jsonl";
    const Outcome cut = run_program(folder_.path(), command, options);
    EXPECT_EQ(cut.code, 1) << cut;
    EXPECT_EQ(cut.error_lines(), 1) << cut;
    for (const char* part : {"interrupted", "fumarole chart fog.json --quick", "-o 'a chart'"})
        EXPECT_NE(cut.err.find(part), std::string::npos) << part << '\n' << cut;
    EXPECT_EQ(names_in(folder), (std::set<std::string>{"chart.partial.jsonl", "reference"}));

    const Outcome first = run_program(folder_.path(), command);
    ASSERT_EQ(first.code, 0) << first;
    EXPECT_EQ(first.err, "") << "no progress where there is no terminal";
    const auto json = nlohmann::json::parse(first.out);
    const std::size_t points = json["points"].size();
    EXPECT_GT(points, 10u);
    EXPECT_EQ(json["reference"]["reused"], true);
    EXPECT_LT(json["visits_made"], 2 * points);
    EXPECT_EQ(json["size"], (std::vector<int>{48, 27}));

    const std::set<std::string> files{"chart.csv", "chart.partial.jsonl", "chart.png",
                                      "chart.svg", "report.html",         "reference"};
    EXPECT_EQ(names_in(folder), files) << "all of them, and nothing unfinished";

    const auto csv = parse_csv(read_bytes(folder + "/chart.csv"));
    ASSERT_EQ(csv.size(), points + 1);
    const auto column = [&](const std::string& name) {
        return static_cast<std::size_t>(std::find(csv[0].begin(), csv[0].end(), name) -
                                        csv[0].begin());
    };
    std::size_t front = 0;
    for (std::size_t i = 1; i < csv.size(); ++i) {
        ASSERT_EQ(csv[i].size(), csv[0].size());
        EXPECT_GT(std::stod(csv[i][column("volume_ms_median")]), 0);
        EXPECT_GE(std::stod(csv[i][column("composite_relmse")]), 0);
        front += csv[i][column("front")] == "yes" ? 1 : 0;
    }
    EXPECT_GE(front, 1u);

    const std::string html = read_bytes(folder + "/report.html");
    EXPECT_EQ(html.find("http://"), std::string::npos);
    EXPECT_EQ(html.find("https://"), std::string::npos);
    EXPECT_NE(html.find("fumarole render"), std::string::npos);
    for (std::size_t at = html.find("src="); at != std::string::npos;
         at = html.find("src=", at + 1))
        EXPECT_EQ(html.substr(at, 9), "src=\"data");
    EXPECT_EQ(read_bytes(folder + "/chart.png").substr(1, 3), "PNG");

    // A line that was torn by a crash spoils neither the others nor what is added.
    std::ofstream(folder + "/chart.partial.jsonl", std::ios::app) << "{\"key\": \"torn";
    const Result second =
        run({scene, "--quick", "--tolerance=0.2", "--time-limit=900", "--json", "-o", folder});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    const auto again = nlohmann::json::parse(second.out);
    EXPECT_EQ(again["reference"]["reused"], true);
    EXPECT_EQ(again["visits_made"], 0);
    EXPECT_EQ(again["points"], json["points"]);
    EXPECT_EQ(names_in(folder), files);

    // Two shares in one folder, and the run that merges them and measures nothing.
    const std::string shared = path("shared");
    std::size_t visits = 0;
    for (const char* share : {"1/2", "2/2", ""}) {
        std::vector<std::string> one{
            scene, "--quick", "--tolerance=0.2", "--time-limit=900", "--json", "-o", shared};
        if (*share != '\0')
            one.push_back(std::string("--shard=") + share);
        const Result part = run(one);
        ASSERT_EQ(part.exit_code, 0) << part.err;
        const auto now = nlohmann::json::parse(part.out);
        EXPECT_EQ(now["visits_made"] == 0, *share == '\0') << share;
        EXPECT_EQ(now["points"].size() < points, *share == '1') << "a folder's points are shown";
        visits += now["visits_made"].get<std::size_t>();
        if (*share != '\0')
            continue;
        EXPECT_GE(visits, points);
        for (std::size_t i = 0; i < points; ++i)
            for (const char* same : {"point", "targets", "samples", "flip", "settings"})
                EXPECT_EQ(now["points"][i][same], json["points"][i][same]) << same;
    }

    const Result table = run({scene, "--quick", "-o", folder, "--target", "transmittance"});
    ASSERT_EQ(table.exit_code, 0) << table.err;
    for (const char* part : {"the front, by the transmittance", "eevee2017", "floor:", "wrote"})
        EXPECT_NE(table.out.find(part), std::string::npos) << part << '\n' << table.out;

    // gnuplot out of sight: all but the pictures, and a word on what to install.
    fs::remove(folder + "/chart.png");
    const Result bare = run({scene, "--quick", "-o", folder}, "PATH=/nowhere");
    EXPECT_EQ(bare.exit_code, 1);
    EXPECT_NE(bare.err.find("gnuplot-nox"), std::string::npos) << bare.err;
    EXPECT_FALSE(fs::exists(folder + "/chart.png"));
    EXPECT_TRUE(fs::exists(folder + "/report.html"));
}

TEST_F(ChartCommand, FitsItsTimeAndSaysWhatItLeftOut)
{
    const std::string scene = write("fog.json", kScene);
    const Result short_run = run({scene, "--json", "--time-limit", "6", "-o", path("a")});
    ASSERT_EQ(short_run.exit_code, 0) << short_run.err;
    const auto json = nlohmann::json::parse(short_run.out);
    EXPECT_GT(json["left_out"], 0);
    std::set<std::string> names;
    for (const auto& point : json["points"])
        names.insert(point["point"]);
    EXPECT_TRUE(names.contains("default") && names.contains("eevee2017"));
    EXPECT_NE(read_bytes(path("a") + "/report.html").find("The time limit left"),
              std::string::npos);
}

TEST_F(ChartCommand, SaysWhatIsWrong)
{
    const std::string scene = write("fog.json", kScene);
    const std::string file = write("file", "");
    const Result folder = run({scene, "--quick", "-o", file + "/below"});
    EXPECT_EQ(folder.exit_code, 1);
    EXPECT_NE(folder.err.find("below"), std::string::npos) << folder.err;
    EXPECT_EQ(run({scene, "--quick", "-o", file}).exit_code, 1);

    const Result missing = run({path("none.vdb"), "--quick", "-o", path("x")});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_NE(missing.err.find("none.vdb"), std::string::npos) << missing.err;
    EXPECT_FALSE(fs::exists(path("x"))) << "no folder for nothing";

    const Result empty = run({write("bare.json", fog_scene("[48, 27]", "")), "-o", path("x")});
    EXPECT_EQ(empty.exit_code, 1);
    EXPECT_NE(empty.err.find("no media"), std::string::npos) << empty.err;

    EXPECT_EQ(run({scene, "--target", "surface"}).exit_code, 2);
    EXPECT_EQ(run({scene, "--size", "48"}).exit_code, 2);
    EXPECT_EQ(run({scene, "--tolerance", "0"}).exit_code, 2);
    EXPECT_EQ(run({scene, "--time-limit", "0"}).exit_code, 2);
    EXPECT_EQ(run({}).exit_code, 2);
}

}  // namespace
}  // namespace fumarole::test
