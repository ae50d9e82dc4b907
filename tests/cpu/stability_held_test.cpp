// How far a figure of the stability cases may drift from an earlier run's.

#include <array>
#include <cmath>
#include <gmock/gmock.h>

#include "study/plan_search.h"
#include "study/shard.h"
#include "study/stability_held.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole::study {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kInfinity = HUGE_VAL;

StabilityCase bounded(StabilityCase::Bound sense, double bound)
{
    StabilityCase one;
    one.sense = sense;
    one.bound = bound;
    return one;
}

TEST(HeldLimit, HalfTheMarginOfWhatHeldAndAQuarterMoreOfWhatFellShort)
{
    const StabilityCase most = bounded(StabilityCase::Bound::at_most, 0.01);
    const auto limit = [](const StabilityCase& one, double figure) {
        HeldCase before;
        before.figure = figure;
        before.held = one.holds(figure);
        return held_limit(one, before);
    };
    EXPECT_DOUBLE_EQ(limit(most, 0.002), 0.006);
    EXPECT_DOUBLE_EQ(limit(most, 0), 0.005);
    EXPECT_DOUBLE_EQ(limit(most, 0.01), 0.01);
    EXPECT_DOUBLE_EQ(limit(most, 0.04), 0.05);
    EXPECT_EQ(limit(most, kInfinity), kInfinity) << "nothing is worse";
    EXPECT_EQ(limit(most, std::nan("")), kInfinity);
    // Pixels that are not finite: none may become one.
    EXPECT_EQ(limit(bounded(StabilityCase::Bound::at_most, 0), 0), 0);

    const StabilityCase least = bounded(StabilityCase::Bound::at_least, 2);
    EXPECT_DOUBLE_EQ(limit(least, 3), 2.5);
    EXPECT_DOUBLE_EQ(limit(least, 1.6), 1.5);
    EXPECT_DOUBLE_EQ(limit(least, -0.4), -1) << "a figure under 0 has a limit that is worse too";
    EXPECT_EQ(limit(least, kInfinity), 2) << "an order that can't be told";
}

class HeldRun : public testing::Test {
protected:
    HeldRun()
    {
        StabilityChoice choice;
        choice.pattern = "odd-sizes";
        choice.preset = "default";
        for (const StabilityRun& run : stability_runs(choice))
            now_.push_back({run, {}, true, "", 0});
    }
    /// A run whose one figure is `figure`, compared with one whose figure was `before`.
    HeldChanges compare(double before, double figure)
    {
        set(before);
        const std::vector<HeldCase> held = read_held(stability_csv(now_), "held.csv");
        set(figure);
        return compare_held(held, now_);
    }
    void set(double figure)
    {
        StabilityResult& one = now_.at(0);
        one.figure.value = figure;
        one.holds = one.run.what->holds(figure);
    }

    std::vector<StabilityResult> now_;
};

// The bound is 1/255 = 0.00392.
TEST_F(HeldRun, SaysWhatIsWorseThanItsLimit)
{
    ASSERT_EQ(now_.size(), 1u);
    EXPECT_THAT(compare(0.001, 0.0024).worse, IsEmpty());
    const HeldChanges margin = compare(0.001, 0.0025);
    EXPECT_THAT(margin.worse, ElementsAre(HasSubstr("0.001 then, 0.0025 now")));
    EXPECT_THAT(margin.lost, IsEmpty());
    EXPECT_THAT(compare(0.1, 0.125).worse, IsEmpty());
    EXPECT_THAT(compare(0.1, 0.126).worse, testing::SizeIs(1));
    EXPECT_THAT(compare(0.1, std::nan("")).worse, testing::SizeIs(1));
    EXPECT_THAT(compare(std::nan(""), std::nan("")).worse, IsEmpty());
    EXPECT_THAT(compare(0.1, 0.001).gained, testing::SizeIs(1));
    const HeldChanges lost = compare(0.001, 0.1);
    EXPECT_THAT(lost.lost, testing::SizeIs(1));
    EXPECT_THAT(lost.worse, IsEmpty()) << "said once";
    EXPECT_THAT(compare_held({}, now_).added, testing::SizeIs(1));
}

TEST_F(HeldRun, RoundingToFourDigitsMakesNoFigureWorse)
{
    const double bound = now_.at(0).run.what->bound;
    for (const double figure : {bound, 0.00039214999, 1.23449e-7, 0.00392145}) {
        const HeldChanges same = compare(figure, figure);
        EXPECT_THAT(same.worse, IsEmpty()) << figure;
        EXPECT_THAT(same.lost, IsEmpty()) << figure;
    }
}

TEST_F(HeldRun, WhatIsAcceptedTakesThePlaceOfItsOwnRecordAlone)
{
    set(0.001);
    std::string csv = stability_csv(now_);
    const std::string other =
        "1,slab-emission,raymarch,default,0.5,at most,0.01,of it,no,\"a, b\",r\r\n";
    csv += other + "1,gone,raymarch,default,0.5,at most,0.01,,yes,s,r\r\n";
    const std::vector<HeldCase> held = read_held(csv, "held.csv");
    set(0.002);
    const std::string record = stability_csv(now_);
    const std::size_t header = record.find('\n') + 1;
    EXPECT_EQ(accepted_csv(held, now_, "held.csv"),
              record.substr(0, header) + other + record.substr(header))
        << "in the table's order, without what is no case any more";
    const std::vector<HeldCase> narrow = read_held(
        "case,mode,preset,figure,holds\r\nslab-emission,raymarch,default,1,no\r\n", "n.csv");
    EXPECT_THROW(accepted_csv(narrow, now_, "n.csv"), Error);
}

TEST(StabilityHeld, SharesAreMergedInTheTablesOrder)
{
    const std::vector<StabilityRun> runs = stability_runs({false, "slab", {}, {}});
    ASSERT_GT(runs.size(), 3u);
    std::vector<StabilityResult> all;
    std::array<std::vector<StabilityResult>, 2> shares;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        StabilityResult one;
        one.run = runs[i];
        one.figure.value = 1e-3 * static_cast<double>(i + 1);
        all.push_back(one);
        for (std::size_t share = 0; share < 2; ++share)
            if (Shard{share + 1, 2}.has(i))
                shares.at(share).push_back(one);
    }
    const test::TempFolder folder;
    const auto first = folder.write("first.csv", stability_csv(shares[0]));
    const auto second = folder.write("second.csv", stability_csv(shares[1]));
    EXPECT_EQ(merged_csv(runs, {second, first}), stability_csv(all));
    const auto said = [&](const std::vector<std::filesystem::path>& files) -> std::string {
        try {
            return merged_csv(runs, files);
        } catch (const Error& error) {
            return error.what();
        }
    };
    EXPECT_NE(said({first}).find("a shard is missing"), std::string::npos);
    EXPECT_NE(said({first, second, second}).find("give each shard once"), std::string::npos);
    EXPECT_THROW(merged_csv(stability_runs({false, "furnace", {}, {}}), {first, second}), Error);
}

// A way that is known to be wrong is no failure of the preset that it is asked of.
TEST(StabilityRuns, WhatIsAskedForByHandHasRowsOfItsOwn)
{
    int asked = 0;
    for (const StabilityRun& run : stability_runs({})) {
        const StabilitySubject& subject = *run.subject;
        if (subject.asked.empty()) {
            EXPECT_EQ(differences(subject.settings, find_preset(subject.preset)).size(), 0u);
            continue;
        }
        ++asked;
        EXPECT_EQ(subject.asked, run.what->asks) << run.what->name;
        EXPECT_EQ(find_setting(subject.asked).get(subject.settings), subject.preset);
        const Settings preset = find_preset(marches(subject) ? "default" : "froxel");
        EXPECT_EQ(differences(subject.settings, preset).size(), 1u) << subject.preset;
    }
    EXPECT_GT(asked, 0);
}

TEST(StabilityRuns, OfOnePresetHaveItsSettingsAlone)
{
    StabilityChoice choice;
    choice.pattern = "panes";
    choice.preset = "default";
    for (const StabilityRun& run : stability_runs(choice)) {
        EXPECT_EQ(run.subject->preset, "default");
        EXPECT_NE(run.what->name, "glowing-panes");
    }
    choice.preset = "single";
    EXPECT_EQ(stability_runs(choice).size(), 4u) << "two cases, two modes";
}

}  // namespace
}  // namespace fumarole::study
