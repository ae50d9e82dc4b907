// What the chart works out by itself: sweeps, the front, its words and its keys. Nothing is drawn.

#include "study/chart.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <set>

#include "study/chart_budget.h"
#include "study/chart_plot.h"
#include "study/chart_report.h"
#include "study/reference_cache.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

using namespace study;
using Plane = std::vector<std::pair<double, double>>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Chart, SweepsNameSettingsAndValuesThatAre)
{
    for (const Sweep& sweep : sweep_table()) {
        Settings settings = sweep.base();
        for (const Axis& axis : sweep.axes) {
            const SettingInfo& info = find_setting(axis.setting);
            EXPECT_GE(axis.values.size(), 2u) << axis.setting;
            for (const std::string_view value : axis.values) {
                info.set(settings, value);
                EXPECT_EQ(info.get(settings), value) << axis.setting;
            }
            for (const std::string_view value : axis.quick)
                EXPECT_NE(std::find(axis.values.begin(), axis.values.end(), value),
                          axis.values.end())
                    << axis.setting << ": " << value << " is quick and not in the whole";
        }
    }
}

TEST(Chart, EverySettingThatTradesSpeedIsSwept)
{
    // Two guard against extremes, on which a scene may need them, and buy no time; three are of
    // what moves, and one of probes while it does, and a chart's stand still; and what passes
    // run as makes no other picture, and is the device's choice.
    std::set<std::string_view> missing{"g-clamp",     "min-extinction", "shadow-fill", "field-fill",
                                       "field-start", "probe-update",   "passes"};
    for (const SettingInfo& info : setting_table()) {
        bool swept = false;
        for (const Sweep& sweep : sweep_table())
            swept = swept || (sweep.axes.size() == 1 && sweep.axes[0].setting == info.name);
        EXPECT_EQ(swept, missing.count(info.name) == 0) << info.name;
    }
}

TEST(Chart, PointsStandOnceAndSayHowTheyAreRendered)
{
    for (const bool quick : {false, true}) {
        std::set<std::string> names;
        const std::vector<ChartPoint> points = chart_points(quick);
        for (const ChartPoint& point : points) {
            EXPECT_TRUE(names.insert(point.name()).second) << point.name();
            Settings settings = find_preset(point.preset);
            for (const auto& [setting, value] : point.changes)
                find_setting(setting).set(settings, value);
            EXPECT_EQ(settings, point.settings) << point.arguments(5);
        }
        EXPECT_EQ(points[0].name(), "default");
        EXPECT_EQ(points[1].name(), "eevee2017");
        EXPECT_EQ(names.count("default steps=16"), 1u);
        EXPECT_EQ(names.count("froxel"), 1u);
        EXPECT_EQ(names.count("froxel tile=4 history=0"), 1u);
    }
    EXPECT_LT(chart_points(true).size(), chart_points(false).size() / 2);
}

TEST(Chart, OfLightThatScattersOnceHasNoPointWhereItScattersOn)
{
    std::set<std::string> names;
    for (const ChartPoint& point : chart_points(false, true)) {
        EXPECT_EQ(point.settings.bounces, 0) << point.name();
        EXPECT_TRUE(names.insert(point.name()).second) << point.name();
        EXPECT_EQ(point.is_preset, names.size() <= presets().size()) << point.name();
    }
    EXPECT_EQ(names.count("default steps=16 bounces=0"), 1u);
    EXPECT_EQ(names.count("eevee2017"), 1u);
}

TEST(Chart, ErrorIsWithoutTheReferencesNoise)
{
    // A picture that is off by a tenth everywhere, and a reference of 1 with noise of +-0.05, whose
    // halves differ by twice as much as it is off itself on the mean square.
    std::mt19937 random(7);
    std::normal_distribution<float> half(0, 0.05f * std::sqrt(2.0f));
    std::vector<float> reference, noise;
    for (int i = 0; i < 30000; ++i) {
        const float a = 1 + half(random), b = 1 + half(random);
        reference.push_back((a + b) / 2);
        noise.push_back((a - b) / 2);
    }
    const std::vector<float> picture(reference.size(), 1.1f);
    const NoiseShare share = noise_relmse(noise, reference);
    EXPECT_NEAR(share.relmse, 0.0025 / 1.1, 0.05 * 0.0025 / 1.1);
    const TargetError e = target_error({picture}, reference, share);
    EXPECT_GT(compare(picture, reference).relmse, 1.25 * 0.01 / 1.1);
    // What is left is the noise in relMSE's denominators, 4 * 0.1 * 0.05^2 first of all.
    EXPECT_NEAR(e.relmse, 0.01 / 1.1, 0.15 * 0.01 / 1.1);
    EXPECT_EQ(noise_relmse({}, reference).relmse, 0);
    EXPECT_EQ(target_error({reference}, reference, share).relmse, share.deviation)
        << "what is not told from nothing";
}

TEST(Chart, FrontIsWhatNothingBeats)
{
    EXPECT_EQ(pareto_front(Plane{{1, 9}, {2, 5}, {3, 6}, {4, 1}, {9, 1}}),
              (std::vector<bool>{true, true, false, true, false}));
    EXPECT_EQ(pareto_front(Plane{}), std::vector<bool>{});
    EXPECT_EQ(pareto_front(Plane{{3, 3}}), std::vector<bool>{true});
}

TEST(Chart, FrontHoldsTwinsAndNoTieThatIsBeaten)
{
    // Twins are both on it; of one cost the lower error, of one error the lower cost.
    EXPECT_EQ(pareto_front(Plane{{1, 2}, {1, 2}, {1, 3}, {2, 2}, {2, 1}}),
              (std::vector<bool>{true, true, false, false, true}));
    EXPECT_EQ(pareto_front(Plane{{1, kInfinity}, {kInfinity, 1}, {kInfinity, kInfinity}}),
              (std::vector<bool>{false, false, false}))
        << "what is not finite is out, though nothing beats it";
    EXPECT_EQ(pareto_front(Plane{{1, std::nan("")}, {2, 2}}), (std::vector<bool>{false, true}));
}

TEST(Chart, ErrorFallsApartInBiasAndVariance)
{
    // Reference 1 everywhere, so relMSE is the squared error / 1.1. Two seeds at 1.2 -+ 0.1.
    const std::vector<float> reference(64, 1.0f);
    const TargetError e =
        target_error({std::vector<float>(64, 1.1f), std::vector<float>(64, 1.3f)}, reference);
    EXPECT_NEAR(e.relmse, (0.01 + 0.09) / 2 / 1.1, 1e-6);
    EXPECT_NEAR(e.relmse_min, 0.01 / 1.1, 1e-6);
    EXPECT_NEAR(e.relmse_max, 0.09 / 1.1, 1e-6);
    EXPECT_NEAR(e.variance, 0.02 / 1.1, 1e-6) << "with n - 1";
    EXPECT_NEAR(e.bias_part, (0.04 - 0.01) / 1.1, 1e-6) << "less the mean's own variance";
    EXPECT_NEAR(e.bias_part + e.variance, e.relmse, 1e-6);
    EXPECT_NEAR(e.bias, 0.2, 1e-6);

    const TargetError one = target_error({std::vector<float>(64, 1.1f)}, reference);
    EXPECT_EQ(one.variance, 0);
    EXPECT_EQ(one.bias_part, one.relmse);
    const TargetError broken = target_error({std::vector<float>(64, std::nanf(""))}, reference);
    EXPECT_FALSE(std::isfinite(broken.relmse));
}

TEST(Chart, SaysWhatASettingBuysAndCosts)
{
    const auto point = [](double ms, double error, double spread) {
        MeasuredPoint p;
        p.min_ms = ms / spread;
        p.median_ms = ms;
        p.max_ms = ms * spread;
        p.errors.targets[0] = {
            .relmse = error, .relmse_min = error / spread, .relmse_max = error * spread};
        return p;
    };
    const MeasuredPoint base = point(10, 1, 1.1);
    const auto verdict = [&](const MeasuredPoint& p) {
        const SettingEffect effect{"steps", "32", &p, &base, 1, 1, false};
        return std::string(effect.verdict(Target::composite));
    };
    EXPECT_EQ(verdict(point(5, 2, 1.1)), "buys time, costs accuracy");
    EXPECT_EQ(verdict(point(20, 0.5, 1.1)), "buys accuracy, costs time");
    EXPECT_EQ(verdict(point(5, 0.5, 1.1)), "buys time and accuracy");
    EXPECT_EQ(verdict(point(20, 2, 1.1)), "costs time and accuracy");
    EXPECT_EQ(verdict(point(10.5, 1.05, 1.1)), "no difference seen");
    EXPECT_EQ(verdict(point(5, 0.5, 3)), "no difference seen") << "of a noisy point";
}

TEST(Chart, LooserTolerancesEndAtTheLoosest)
{
    for (const int bounces : {0, kAllBounces}) {
        const double loosest = loosest_tolerance(bounces);
        EXPECT_DOUBLE_EQ(looser(1e-3, bounces), bounces == 0 ? 4e-3 : 2e-3);
        EXPECT_EQ(looser(0.9 * loosest, bounces), loosest);
        EXPECT_EQ(looser(loosest, bounces), loosest);
        EXPECT_EQ(looser(0.5, bounces), 0.5) << "never a closer one";
    }
}

TEST(Chart, ToleranceFitsTheTime)
{
    Scene scene;
    scene.resolution = {16, 16};
    scene.lights = {SunLight{.direction_to_light = {0, 0, 1}, .irradiance = {1, 1, 1}}};
    ReferenceOptions asked;
    EXPECT_EQ(fit_tolerance(scene, asked, 1e6), asked.tolerance);
    EXPECT_EQ(fit_tolerance(scene, asked, 0), loosest_tolerance(asked.bounces));
    const std::atomic<bool> cancel{true};
    asked.cancel = &cancel;
    EXPECT_THROW(fit_tolerance(scene, asked, 1e6), ReferenceCancelled);
}

TEST(Chart, CsvQuotesWhatItMust)
{
    EXPECT_EQ(csv_field("default steps=16"), "default steps=16");
    EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
    EXPECT_EQ(csv_field("say \"x\""), "\"say \"\"x\"\"\"");
    EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
    EXPECT_EQ(csv_field(""), "");
}

TEST(Chart, HtmlIsHarmless)
{
    EXPECT_EQ(html_text("<a href=\"x\">'&'"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;");
}

TEST(Chart, TicksAreRoundAndEnough)
{
    EXPECT_EQ(log_ticks(3, 30), (std::vector<double>{5, 10, 20}));
    const std::vector<double> many = log_ticks(1e-6, 1e2);
    EXPECT_EQ(many.size(), 9u);
    EXPECT_NEAR(many.front(), 1e-6, 1e-12);
}

TEST(Chart, PlotKeepsHostileTitlesInQuotes)
{
    Chart chart;
    MeasuredPoint p;
    p.point = chart_points(true)[0];
    p.visits = 1;
    p.min_ms = p.median_ms = p.max_ms = 2;
    for (TargetError& e : p.errors.targets)
        e.relmse = e.relmse_min = e.relmse_max = 1e-3;
    p.front = true;
    chart.points = {p};
    chart.floor = 1e-3;
    const std::string program = plot_program(chart, "it's\n`id`", "a.svg", "a.png");
    EXPECT_NE(program.find("'it''s\\x0a`id`'"), std::string::npos) << program;
    chart.points[0].median_ms = 0;
    EXPECT_THROW(plot_program(chart, "", "a.svg", "a.png"), Error);
}

TEST(ReferenceKey, FollowsTheContentAndNotTheName)
{
    const TempFolder folder;
    Scene scene;
    GridMedium grid;
    grid.grid = "density";
    grid.file = folder.write("a.vdb", "one").string();
    scene.media = {grid};
    const auto key = [&](double tolerance = 1e-3, const char* version = "1") {
        ReferenceOptions options;
        options.tolerance = tolerance;
        return reference_key(scene, options, version);
    };
    const std::string first = key();
    EXPECT_EQ(first.size(), 16u);
    EXPECT_EQ(key(), first);

    std::get<GridMedium>(scene.media[0]).file = folder.write("b.vdb", "one").string();
    EXPECT_EQ(key(), first) << "another name of the same content";
    folder.write("b.vdb", "two");
    EXPECT_NE(key(), first) << "another content under the same name";
    folder.write("b.vdb", "one");
    EXPECT_NE(key(1e-2), first);
    EXPECT_NE(key(1e-3, "2"), first);
    scene.resolution.x += 1;
    EXPECT_NE(key(), first);
    scene.resolution.x -= 1;
    EXPECT_EQ(key(), first);
    scene.time = 1;
    EXPECT_NE(key(), first);
    std::get<GridMedium>(scene.media[0]).file = (folder.path() / "none.vdb").string();
    EXPECT_THROW(key(), Error);
}

TEST(ReferenceKey, HashIsFnv1a)
{
    // Of the authors' published test vectors.
    EXPECT_EQ(text_hash(""), "cbf29ce484222325");
    EXPECT_EQ(text_hash("a"), "af63dc4c8601ec8c");
    EXPECT_EQ(text_hash("foobar"), "85944171f73967e8");
}

}  // namespace
}  // namespace fumarole::test
