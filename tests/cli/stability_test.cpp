// `fumarole stability` as a user runs it: its list, its files, its memory of what held.

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "cli/run_program.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;

class StabilityCommand : public testing::Test {
protected:
    [[nodiscard]] Outcome run(Arguments arguments) const
    {
        arguments.insert(arguments.begin(), "stability");
        return run_program(folder_.path(), arguments);
    }
    [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }

    /// The csv of a few quick cases.
    [[nodiscard]] std::string measured() const
    {
        const Outcome first = run({"--case", "odd-sizes", "-o", "first"});
        EXPECT_EQ(first.code, 0) << first;
        return read_bytes(path("first/stability.csv"));
    }

    TempFolder folder_;
};

/// `text` with the first `from` after `after` replaced.
std::string doctored(std::string text, const std::string& after, const std::string& from,
                     const std::string& to)
{
    const std::size_t at = text.find(from, text.find(after));
    EXPECT_NE(at, std::string::npos) << text;
    return text.replace(at, from.size(), to);
}

TEST_F(StabilityCommand, ListsAllTwelveGroupsAndDrawsNothing)
{
    const Outcome list = run({"--list"});
    ASSERT_EQ(list.code, 0) << list;
    const std::string text = '\n' + list.out;
    for (int group = 1; group <= 12; ++group) {
        const std::string heading = fmt::format("\n{:>2}. ", group);
        ASSERT_NE(text.find(heading), std::string::npos) << heading;
        EXPECT_EQ(text.find(heading), text.rfind(heading)) << "once:" << heading;
    }
    EXPECT_FALSE(fs::exists(path("stability")));
    const Outcome few = run({"--list", "--quick"});
    EXPECT_LT(few.out.size(), list.out.size());
    const Outcome fifth = run({"--list", "--case", "5"});
    EXPECT_TRUE(fifth.out.starts_with(" 5. ")) << fifth;
    EXPECT_EQ(fifth.out.find("lobe-g-0.5"), std::string::npos) << "digits are a group's number";
}

TEST_F(StabilityCommand, WritesATableACsvAndPicturesOfWhatFallsShort)
{
    const Outcome table = run({"--case", "slab-transmittance", "--mode", "raymarch", "-o", "out"});
    ASSERT_EQ(table.code, 0) << "to fall short is no failure: " << table;
    EXPECT_EQ(table.err, "");
    for (const char* part : {"raymarch/default", "raymarch/eevee2017", "FALLS SHORT", "holds",
                             "1 of 1 hold", "wrote out/stability.csv and 1 pictures"})
        EXPECT_NE(table.out.find(part), std::string::npos) << part << '\n' << table;
    EXPECT_EQ(
        list(path("out")),
        (std::vector<std::string>{"slab-transmittance_raymarch_eevee2017.png", "stability.csv"}));

    const Outcome json =
        run({"--case", "slab-transmittance", "--mode", "raymarch", "-o", "out", "--json"});
    ASSERT_EQ(json.code, 0) << json;
    const auto parsed = nlohmann::json::parse(json.out);
    ASSERT_EQ(parsed["cases"].size(), 2u);
    for (const auto& one : parsed["cases"]) {
        EXPECT_EQ(one["group"], 1);
        EXPECT_EQ(one["holds"], one["figure"] <= one["bound"]);
        EXPECT_FALSE(one["reason"].get<std::string>().empty());
    }
    EXPECT_EQ(parsed["outputs"].size(), 2u);

    const std::string csv = read_bytes(path("out/stability.csv"));
    EXPECT_TRUE(csv.starts_with("group,case,mode,preset,figure,sense,bound,unit,holds,")) << csv;
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);

    const Outcome reasons = run({"--case", "odd-sizes", "--explain", "-o", "out"});
    EXPECT_NE(reasons.out.find("bound: 1/255"), std::string::npos) << reasons;
    EXPECT_EQ(
        run({"--case", "odd-sizes", "--preset", "default", "-o", "out"}).out.find("eevee2017"),
        std::string::npos);
}

TEST_F(StabilityCommand, EachPresetRunsInItsMode)
{
    const Outcome both = run({"--case", "slab-transmittance", "-o", "out"});
    ASSERT_EQ(both.code, 0) << both;
    for (const char* subject :
         {"raymarch/default", "raymarch/eevee2017", "froxel/froxel", "froxel/eevee2017-froxel"})
        EXPECT_NE(both.out.find(subject), std::string::npos) << subject << '\n' << both;
    EXPECT_EQ(both.out.find("raymarch/froxel"), std::string::npos) << both;
    EXPECT_EQ(both.out.find("froxel/default"), std::string::npos) << both;
    // Two shares of the same, merged: the very file.
    for (const char* share : {"1", "2"})
        ASSERT_EQ(run({"--case", "slab-transmittance", "--shard", std::string(share) + "/2", "-o",
                       std::string("out") + share})
                      .code,
                  0);
    const Outcome merged = run({"--case", "slab-transmittance", "--merge", "out1/stability.csv",
                                "out2/stability.csv", "-o", "merged"});
    EXPECT_EQ(merged.code, 0) << merged;
    EXPECT_EQ(read_bytes(path("merged/stability.csv")), read_bytes(path("out/stability.csv")));
    EXPECT_LT(read_bytes(path("out1/stability.csv")).size(),
              read_bytes(path("merged/stability.csv")).size());
    // The layer's resolution is the march's, a history the froxels'.
    const Outcome edge = run({"--list", "--case", "wire-half", "--mode", "froxel"});
    EXPECT_EQ(edge.code, 2) << edge;
    const Outcome history =
        run({"--list", "--case", "changing-sizes-history", "--mode", "raymarch"});
    EXPECT_EQ(history.code, 2) << history;
}

TEST_F(StabilityCommand, FailsWhereWhatHeldNoLongerDoes)
{
    const std::string csv = measured();
    folder_.write("same.csv", csv);
    const Outcome same = run({"--case", "odd-sizes", "-o", "second", "--held", "same.csv"});
    EXPECT_EQ(same.code, 0) << same;

    // As if the 2017 preset had held once: it does not, so it is named with both figures.
    const std::string better = doctored(csv, "eevee2017", "no", "yes");
    folder_.write("better.csv", better);
    const Outcome lost = run({"--case", "odd-sizes", "-o", "second", "--held", "better.csv"});
    EXPECT_EQ(lost.code, 1) << lost;
    EXPECT_NE(lost.err.find("odd-sizes (raymarch, eevee2017)"), std::string::npos) << lost;
    EXPECT_NE(lost.err.find("then"), std::string::npos) << lost;
    EXPECT_TRUE(fs::exists(path("second/stability.csv"))) << "written all the same";

    // As if the default had fallen short.
    folder_.write("worse.csv", doctored(csv, "default", "yes", "no"));
    const Outcome gained = run({"--case", "odd-sizes", "-o", "second", "--held", "worse.csv"});
    EXPECT_EQ(gained.code, 0) << gained;
    EXPECT_NE(gained.out.find("newly holds: odd-sizes"), std::string::npos) << gained;

    // A case that is gone is not forgotten; one that was not asked for is.
    folder_.write("renamed.csv", doctored(csv, "\n", "odd-sizes", "old-sizes"));
    const Outcome gone = run({"--case", "odd-sizes", "-o", "second", "--held", "renamed.csv"});
    EXPECT_EQ(gone.code, 1) << gone;
    EXPECT_NE(gone.err.find("old-sizes"), std::string::npos) << gone;
    const Outcome other = run({"--case", "changing-sizes", "-o", "second", "--held", "same.csv"});
    EXPECT_EQ(other.code, 0) << other;
}

// order-step-edge is at least 0.9: the default's order is 1.046, the 2017 preset's 0.828.
TEST_F(StabilityCommand, FailsWhereAFigureGrowsThoughItsCaseHoldsOrFallsShortAsBefore)
{
    const Arguments measure{"--case", "order-step-edge", "--mode", "raymarch", "-o", "out"};
    const auto against = [&](const std::string& file, bool accept = false) {
        Arguments all = measure;
        all.insert(all.end(), {"--held", file});
        if (accept)
            all.emplace_back("--accept");
        return run(all);
    };
    ASSERT_EQ(run(measure).code, 0);
    const std::string csv = read_bytes(path("out/stability.csv"));
    ASSERT_NE(csv.find("default,1.046"), std::string::npos) << csv;
    ASSERT_NE(csv.find("eevee2017,0.8278"), std::string::npos) << csv;
    const auto then = [&](const std::string& preset, const std::string& now,
                          const std::string& figure) {
        return doctored(csv, preset, preset + ',' + now, preset + ',' + figure);
    };
    folder_.write("held.csv", then("default", "1.046", "1.18"));  // half way to 0.9 is 1.04
    EXPECT_EQ(against("held.csv").code, 0);
    folder_.write("held.csv", then("default", "1.046", "1.21"));  // 1.055
    const Outcome margin = against("held.csv");
    EXPECT_EQ(margin.code, 1) << margin;
    EXPECT_NE(margin.err.find("order-step-edge (raymarch, default): 1.21 then, 1.046 now"),
              std::string::npos)
        << margin;
    EXPECT_NE(margin.err.find("0 cases no longer hold and 1 are worse"), std::string::npos)
        << margin;
    EXPECT_NE(margin.err.find("--accept"), std::string::npos) << margin;
    folder_.write("held.csv", then("eevee2017", "0.8278", "0.838"));  // 1.16 times as short
    EXPECT_EQ(against("held.csv").code, 0);
    folder_.write("held.csv", then("eevee2017", "0.8278", "0.846"));  // 1.34 times
    const Outcome grown = against("held.csv");
    EXPECT_EQ(grown.code, 1) << grown;
    EXPECT_NE(grown.err.find("order-step-edge (raymarch, eevee2017)"), std::string::npos) << grown;

    // What is accepted is what was measured; cases that were not stay as they were.
    const std::string other = "\n1,slab-emission,raymarch,default,0.5,at most,0.01,,no,s,r\r\n";
    folder_.write("held.csv", then("default", "1.046", "1.5") + other.substr(1));
    EXPECT_EQ(run({"--case", "order-step-edge", "--accept"}).code, 2) << "into which file?";
    const Outcome accepted = against("held.csv", true);
    EXPECT_EQ(accepted.code, 0) << accepted;
    const std::string now = read_bytes(path("held.csv"));
    EXPECT_NE(now.find("default,1.046"), std::string::npos) << now;
    EXPECT_NE(now.find(other), std::string::npos) << now;
    EXPECT_EQ(now.size(), csv.size() + other.size() - 1);
    EXPECT_EQ(against("held.csv").code, 0);
}

TEST_F(StabilityCommand, SaysWhatIsWrong)
{
    const std::vector<std::pair<Arguments, std::string>> misuses{
        {{"--case", "no-such-case"}, "no-such-case"},
        {{"--case", "13"}, "13"},
        {{"--preset", "eevee"}, "eevee2017"},
        {{"--mode", "froxels"}, "raymarch, froxel"},
        {{"--held", "nowhere.csv"}, "nowhere.csv"},
        {{"--backend", "glx"}, "osmesa"},
        {{"extra"}, "extra"},
    };
    for (const auto& [arguments, word] : misuses) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 2) << joined(arguments) << '\n' << outcome;
        EXPECT_NE((outcome.err + outcome.out).find(word), std::string::npos)
            << joined(arguments) << '\n'
            << outcome;
    }
    EXPECT_FALSE(fs::exists(path("stability")));

    folder_.write("text.csv", "what,is,this\r\n1,2,3\r\n");
    folder_.write("short.csv", "case,mode,preset,figure,holds\r\nodd-sizes,raymarch\r\n");
    folder_.write("word.csv", "case,mode,preset,figure,holds\r\na,b,c,much,yes\r\n");
    for (const char* file : {"text.csv", "short.csv", "word.csv"}) {
        const Outcome outcome = run({"--case", "odd-sizes", "--held", file});
        EXPECT_EQ(outcome.code, 1) << outcome;
        EXPECT_NE(outcome.err.find(file), std::string::npos) << outcome;
        EXPECT_EQ(outcome.error_lines(), 1) << outcome;
    }
    folder_.write("file", "");
    EXPECT_EQ(run({"--case", "odd-sizes", "-o", "file"}).code, 1);
}

}  // namespace
}  // namespace fumarole::test
