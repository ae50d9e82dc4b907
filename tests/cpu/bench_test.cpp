#include "study/bench.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "study/bench_goals.h"
#include "study/bench_grids.h"
#include "study/bench_plot.h"
#include "study/bench_scenes.h"
#include "study/child_process.h"
#include "support/temp_folder.h"
#include <fumarole/asset/vdb_file.h>

namespace fumarole::test {
namespace {

using namespace study;

std::vector<BenchScene> two_scenes()
{
    return {{"smoke", plume_scene(std::make_shared<VoxelGrid>())}, {"fog", fog_scene()}};
}

std::set<std::string> changed(const Settings& a, const Settings& b)
{
    std::set<std::string> names;
    for (const SettingInfo& info : setting_table())
        if (info.get(a) != info.get(b))
            names.emplace(info.name);
    return names;
}

TEST(BenchPlan, HoldsEachPresetOfEachScene)
{
    const auto scenes = two_scenes();
    const auto cases = plan_bench(scenes, {}, "presets", false);
    ASSERT_EQ(cases.size(), scenes.size() * presets().size());
    for (const BenchCase& c : cases) {
        EXPECT_EQ(c.settings, find_preset(c.name));
        EXPECT_EQ(c.base, c.name == "eevee2017" ? "" : "eevee2017");
        EXPECT_EQ(c.scene.resolution, glm::uvec2(480, 270));
    }
    const std::vector<std::string> one{"froxel"};
    EXPECT_EQ(plan_bench(scenes, one, "presets", false).size(), scenes.size());
}

TEST(BenchPlan, AblatesEachStepAloneAndAllButIt)
{
    std::set<std::string> steps;
    for (const AblatedStep& step : ablated_steps())
        steps.emplace(step.setting);
    const Settings all = find_preset("default");
    std::set<std::string> alone, without;
    for (const BenchCase& c : plan_bench(two_scenes(), {}, "ablation", true)) {
        const std::set<std::string> off = changed(c.settings, all);
        EXPECT_TRUE(std::includes(steps.begin(), steps.end(), off.begin(), off.end())) << c.text();
        if (c.name == "none") {
            EXPECT_EQ(off, steps);
        } else if (c.name == "all") {
            EXPECT_TRUE(off.empty());
        } else if (c.name.starts_with("all but ")) {
            EXPECT_EQ(off, std::set{c.name.substr(8)});
            without.merge(std::set(off));
        } else {
            const std::string step = c.name.substr(0, c.name.find(" alone"));
            std::set<std::string> others = steps;
            others.erase(step);
            EXPECT_EQ(off, others) << c.text();
            alone.insert(step);
        }
        EXPECT_EQ(c.base, c.name == "none" ? "" : "none");
    }
    EXPECT_EQ(alone, steps);
    EXPECT_EQ(without, steps);
}

TEST(BenchPlan, QuickIsAPartOfTheWhole)
{
    const auto scenes = two_scenes();
    std::set<std::string> whole;
    for (const BenchCase& c : plan_bench(scenes, {}, "", false))
        EXPECT_TRUE(whole.insert(c.text()).second) << c.text() << " twice";
    const auto quick = plan_bench(scenes, {}, "", true);
    EXPECT_LT(quick.size(), whole.size());
    for (const BenchCase& c : quick) {
        EXPECT_TRUE(whole.contains(c.text())) << c.text();
        if (!c.base.empty()) {
            EXPECT_TRUE(std::any_of(quick.begin(), quick.end(), [&](const BenchCase& other) {
                return other.same_place(c) && other.name == c.base;
            })) << c.text();
        }
    }
    for (const std::string_view group : {"presets", "ablation", "steps", "lights", "sizes"})
        EXPECT_FALSE(plan_bench(scenes, {}, std::string(group), true).empty()) << group;
}

TEST(BenchFit, FindsAPowerAndALine)
{
    std::vector<std::pair<double, double>> power, line;
    for (const double x : {1.0, 3.0, 10.0, 50.0}) {
        power.emplace_back(x, 2 * std::pow(x, 1.5));
        line.emplace_back(x, 7 + 0.25 * x);
    }
    EXPECT_NEAR(fit_growth(power).exponent, 1.5, 1e-12);
    EXPECT_NEAR(fit_growth(line).fixed, 7, 1e-10);
    EXPECT_NEAR(fit_growth(line).slope, 0.25, 1e-12);
}

MeasuredCase measured(const std::string& name, const std::string& base,
                      std::vector<std::pair<int, double>> rounds)
{
    MeasuredCase one;
    one.bench_case.group = "presets";
    one.bench_case.scene_name = "smoke";
    one.bench_case.name = name;
    one.bench_case.base = base;
    for (const auto& [round, ms] : rounds) {
        one.volume.emplace_back(round, PassTime{"volume", ms - 1, ms, ms + 2});
        one.passes.push_back({{"ray march", ms / 2, ms / 2, ms / 2}});
        one.machine.push_back(1000 / ms);
    }
    return one;
}

TEST(BenchFigures, CompareWithinARound)
{
    // The machine is half as fast in round 1, and the base was not visited in round 2.
    const std::vector<MeasuredCase> cases{
        measured("eevee2017", "", {{0, 100}, {1, 200}}),
        measured("default", "eevee2017", {{0, 10}, {1, 20}, {2, 90}})};
    const auto figures = case_figures(cases);
    const BenchFigure* faster =
        find_figure(figures, "presets", "smoke", "default", "times faster than eevee2017");
    ASSERT_NE(faster, nullptr);
    EXPECT_EQ(faster->value.count, 2);
    EXPECT_DOUBLE_EQ(faster->value.min, 10);
    EXPECT_DOUBLE_EQ(faster->value.max, 10);
    const BenchFigure* time = find_figure(figures, "presets", "smoke", "default", "volume time");
    ASSERT_NE(time, nullptr);
    EXPECT_DOUBLE_EQ(time->value.min, 9);
    EXPECT_DOUBLE_EQ(time->value.median, 20);
    EXPECT_DOUBLE_EQ(time->value.max, 92);
    EXPECT_EQ(find_figure(figures, "presets", "smoke", "eevee2017", "times faster than "), nullptr);

    // Likewise a rate is held against the machine's own at that time.
    const auto [rate, share] = fetch_rates(cases[0], "ray march", 1);
    EXPECT_DOUBLE_EQ(rate.max, 20);
    EXPECT_DOUBLE_EQ(rate.min, 10);
    EXPECT_DOUBLE_EQ(share.min, 2);
    EXPECT_DOUBLE_EQ(share.max, 2);
    EXPECT_EQ(fetch_rates(cases[0], "no such pass", 1).first.count, 0);
}

TEST(BenchFigures, AreWrittenAsARowEach)
{
    const std::vector<BenchFigure> figures{
        {"sizes",
         "a, \"b\"",
         "default",
         "pixels",
         129600,
         "volume time",
         "ms",
         {1, 2, 3, 4},
         {480, 270}},
        {"machine", "", "", "", 0, "rate", "1/s", {1, 1, 1, 1}, {}}};
    EXPECT_EQ(bench_csv(figures),
              "group,scene,case,width,height,axis,at,quantity,unit,min,median,max,count\r\n"
              "sizes,\"a, \"\"b\"\"\",default,480,270,pixels,129600,volume time,ms,1,2,3,4\r\n"
              "machine,,,,,,,rate,1/s,1,1,1,1\r\n");
}

TEST(BenchFigures, MakeCurvesOfWhatGrows)
{
    std::vector<BenchFigure> figures;
    for (const double x : {1.0, 2.0, 4.0})
        figures.push_back({"lights",
                           "smoke",
                           "default",
                           "lights",
                           x,
                           "volume time",
                           "ms",
                           {3 * x, 3 * x, 3 * x, 1},
                           {480, 270}});
    figures.push_back(
        {"steps", "smoke", "default", "steps", 64, "volume time", "ms", {1, 1, 1, 1}, {480, 270}});
    const auto curves = growth_curves(figures, kVolumeTime);
    ASSERT_EQ(curves.size(), 1u) << "one point is no curve";
    EXPECT_EQ(curves[0].points.size(), 3u);
    EXPECT_NEAR(curves[0].growth.exponent, 1, 1e-12);
}

TEST(BenchGoals, AskTenfoldWhereLightIsMarchedAndThreefoldElsewhere)
{
    std::vector<BenchFigure> figures;
    for (const char* scene : {"smoke", "fog"})
        figures.push_back({"presets",
                           scene,
                           "default",
                           "",
                           0,
                           "times faster than eevee2017",
                           "1",
                           {5, 5, 5, 1},
                           {480, 270}});
    figures.push_back({"programs",
                       "smoke.vdb",
                       std::string(kFirstPicture),
                       "",
                       0,
                       "time",
                       "ms",
                       {1400, 1450, 1600, 5},
                       {480, 270}});
    const auto goals = bench_goals(figures, two_scenes());
    ASSERT_EQ(goals.size(), 3u);
    EXPECT_FALSE(goals[0].held()) << goals[0].text;
    EXPECT_TRUE(goals[1].held()) << goals[1].text;
    EXPECT_TRUE(goals[2].held()) << goals[2].text;
}

TEST(BenchPlot, DrawsWhatThereIs)
{
    std::vector<BenchFigure> figures{
        {"presets", "it's", "default", "", 0, "volume time", "ms", {1, 2, 3, 3}, {480, 270}}};
    const std::string program = bench_plot_program(figures, "title", "out.png");
    EXPECT_NE(program.find("'it''s'"), std::string::npos) << program;
    EXPECT_NE(program.find("layout 1,1"), std::string::npos) << program;
    figures.clear();
    EXPECT_EQ(bench_plot_program(figures, "title", "out.png"), "");
}

TEST(BenchPlume, IsTheSameSmokeHoweverFine)
{
    const VoxelGrid coarse = make_plume(32), fine = make_plume(64);
    ASSERT_FALSE(coarse.empty());
    EXPECT_NEAR(static_cast<double>(fine.active_voxels) / static_cast<double>(coarse.active_voxels),
                8, 1);
    EXPECT_EQ(fine.values.size(), fine.bricks.size() * VoxelGrid::kBrickVoxels);
    EXPECT_LE(fine.max_value, 1);
    EXPECT_TRUE(std::is_sorted(fine.bricks.begin(), fine.bricks.end(), [](auto a, auto b) {
        return std::tie(a.z, a.y, a.x) < std::tie(b.z, b.y, b.x);
    }));
    // Lines of sight through both are as dense.
    const auto mass = [](const VoxelGrid& grid) {
        double sum = 0;
        for (const float v : grid.values)
            sum += v;
        return sum * glm::determinant(grid.world_from_index);
    };
    EXPECT_NEAR(mass(fine) / mass(coarse), 1, 0.02);
}

TEST(BenchPlume, IsReadBackAsItWasMade)
{
    const TempFolder folder;
    const VoxelGrid made = make_plume(64);
    write_plume(made, folder.path() / "smoke.vdb");
    const VoxelGrid read = asset::load_grid(folder.path() / "smoke.vdb", "").grid;
    EXPECT_EQ(read.bricks, made.bricks);
    EXPECT_EQ(read.values, made.values);
    EXPECT_EQ(read.world_from_index, made.world_from_index);
}

TEST(BenchMemory, CountsBytesAgainstActiveVoxels)
{
    const VoxelGrid grid = make_plume(64);
    const auto figures = memory_figures(grid, "smoke");
    for (const char* layout : {"auto", "bricks", "dense"}) {
        const auto of = [&](const char* quantity) {
            return find_figure(figures, "memory", "smoke", layout, quantity)->value.median;
        };
        EXPECT_NEAR(of("bytes per active voxel") * static_cast<double>(grid.active_voxels),
                    of("grid on the GPU"), 1);
        EXPECT_EQ(of("bytes of a stored value"), 4) << "made and written as floats";
        EXPECT_NEAR(of("times the stored values") * 4, of("bytes per active voxel"), 1e-9)
            << "whatever the GPU stores";
        EXPECT_NEAR(of("times half floats") * 2, of("bytes per active voxel"), 1e-9);
    }
    VoxelGrid halves = grid;
    halves.stored_as_half = true;
    EXPECT_EQ(find_figure(memory_figures(halves, "smoke"), "memory", "smoke", "auto",
                          "bytes of a stored value")
                  ->value.median,
              2);
    EXPECT_GT(free_memory(), 1e6);
    EXPECT_TRUE(memory_figures(VoxelGrid{}, "empty").empty());
}

TEST(ChildProcess, TellsHowAProgramEnded)
{
    const TempFolder folder;
    const auto log = folder.path() / "log";
    EXPECT_FALSE(run_child({"no-such-program-here"}, log).found);
    const ChildResult said = run_child({"sh", "-c", "echo one; echo two >&2; exit 3"}, log);
    EXPECT_EQ(said.code, 3);
    EXPECT_EQ(said.said, "one\ntwo\n");
    EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}, log).code, 128 + 9);
    // One that is asked about while it runs, and one that is ended.
    EXPECT_EQ(run_child({"sh", "-c", "exit 3"}, log, {.stops = [] { return false; }}).code, 3);
    int asked = 0;
    EXPECT_EQ(run_child({"sleep", "1000"}, log, {.stops = [&] { return ++asked == 3; }}).code,
              128 + 9);
    EXPECT_EQ(asked, 3);
    EXPECT_GE(run_child({"sleep", "0.05"}, log).seconds, 0.05);
    EXPECT_FALSE(std::filesystem::exists(log));
}

}  // namespace
}  // namespace fumarole::test
