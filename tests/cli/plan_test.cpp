// `fumarole plan` and what `render` makes of a plan, as a user runs them.

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/fog_scene.h"
#include "cli/run_program.h"

namespace fumarole::test {
namespace {

using Json = nlohmann::json;

/// Fog that thins out upwards, and a ball in it.
const std::string kScene = fog_scene("[96, 54]", R"(
    {"type": "box", "min": [-2, -1, 0], "max": [1, 1, 2], "profile": "exp_height",
     "scale_height": 0.7, "z0": 0, "sigma_s": [1, 1, 1], "sigma_a": [0.1, 0.1, 0.1], "g": 0.2})",
                                     R"(,
    {"type": "sphere", "center": [0.4, 0, 1], "radius": 0.5, "albedo": [0.4, 0.3, 0.3]})");

class PlanCommand : public testing::Test {
protected:
    PlanCommand() { folder_.write("fog.json", kScene); }

    [[nodiscard]] Outcome run(const Arguments& arguments) const
    {
        return run_program(folder_.path(), arguments);
    }
    [[nodiscard]] Json plan(Arguments arguments) const
    {
        arguments.insert(arguments.begin(), {"plan", "fog.json", "--json", "--bounces", "0"});
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome;
        EXPECT_EQ(outcome.err, "") << outcome;
        return Json::parse(outcome.out);
    }
    /// Root of relMSE of the composite that these settings draw.
    [[nodiscard]] double true_error(const std::string& settings) const
    {
        Arguments render{"render", "--aa=1", "fog.json", "-o", "a.exr"};
        std::istringstream words(settings);
        for (std::string word; words >> word;)
            render.push_back(word);
        EXPECT_EQ(run(render).code, 0) << settings;
        EXPECT_EQ(
            run({"render", "fog.json", "--mode", "reference", "--bounces", "0", "-o", "b.exr"})
                .code,
            0);
        const Outcome compared =
            run({"compare", "a.exr", "b.exr", "--target", "composite", "--json"});
        EXPECT_EQ(compared.code, 0) << compared;
        const Json targets = Json::parse(compared.out)["targets"];
        const Json& composite = targets.is_array() ? targets[0] : targets["composite"];
        return std::sqrt(composite["relmse"].get<double>());
    }

    TempFolder folder_;
};

TEST_F(PlanCommand, FindsSettingsAndPredictsTheirError)
{
    const Json found = plan({"--max-error", "0.03", "--time-limit", "20"});
    ASSERT_TRUE(found["met"]) << found;
    const Json& choice = found["choice"];
    EXPECT_LE(choice["predicted"], 0.03);
    EXPECT_GE(found["points"].size(), 3u);
    const auto& points = found["points"];
    const auto chosen = std::find_if(points.begin(), points.end(), [&](const Json& point) {
        return point["arguments"] == choice["arguments"];
    });
    ASSERT_NE(chosen, points.end());
    for (const Json& point : points)
        if (point["predicted_upper"] <= 0.03 && found["notes"].empty()) {
            EXPECT_LE((*chosen)["ms"].get<double>(), 1.04 * point["ms"].get<double>()) << point;
        }
    EXPECT_GT(found["pixels"], 100);
    const double truth = true_error(choice["arguments"]);
    for (const char* told : {"predicted", "verified"}) {
        EXPECT_LT(choice[told].get<double>(), 1.5 * truth) << told << choice;
        EXPECT_GT(choice[told].get<double>(), truth / 1.5) << told << choice;
    }
    bool grey = false;
    for (const Json& fact : found["facts"])
        grey = grey || fact["text"].get<std::string>().starts_with("extinction: grey");
    EXPECT_TRUE(grey) << found["facts"];
}

TEST_F(PlanCommand, KeepsToATimeAndToWhatWasGiven)
{
    const Json found =
        plan({"--budget", "1000ms", "--steps", "24", "--mode", "raymarch", "--time-limit", "4"});
    EXPECT_TRUE(found["met"]) << found;
    EXPECT_EQ(found["budget_ms"], 1000);
    double least = 1e300;
    for (const Json& point : found["points"]) {
        EXPECT_EQ(point["settings"]["steps"], "24");
        EXPECT_EQ(point["mode"], "raymarch");
        least = std::min(least, point["predicted"].get<double>());
    }
    EXPECT_LE(found["choice"]["predicted"].get<double>(), 1.1 * least);
}

TEST_F(PlanCommand, SaysItInWordsAlsoWhereNothingWillDo)
{
    const Outcome words = run({"plan", "fog.json", "--max-error", "1e-6", "--time-limit", "0.1"});
    EXPECT_EQ(words.code, 0) << words;
    for (const char* said :
         {"what this scene needs", "extinction: grey", "<- chosen",
          "nothing that was tried comes below that error", "ended the search before it was done",
          "\nfumarole render fog.json", "root of relMSE"})
        EXPECT_NE(words.out.find(said), std::string::npos) << said << words;
}

TEST_F(PlanCommand, RenderPlansFirstAndSaysWhatItChose)
{
    const Outcome drawn =
        run({"render", "fog.json", "--max-error", "0.05", "--upsample", "4x4", "-o", "x.png"});
    EXPECT_EQ(drawn.code, 0) << drawn;
    EXPECT_NE(drawn.out.find("planned for error 0.05: "), std::string::npos) << drawn;
    EXPECT_NE(drawn.out.find("upsample 4x4"), std::string::npos) << drawn;
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "x.png"));

    const Outcome json = run({"render", "fog.json", "--budget", "500", "--json", "-o", "y.exr"});
    EXPECT_EQ(json.code, 0) << json;
    EXPECT_NE(Json::parse(json.out)["plan"].get<std::string>().find("planned for 500 ms"),
              std::string::npos);
}

TEST_F(PlanCommand, RefusesWhatIsNoGoal)
{
    struct Case {
        Arguments arguments;
        std::string named;
    };
    const std::vector<Case> cases{
        {{"plan", "fog.json"}, "--max-error"},
        {{"plan", "fog.json", "--budget", "soon"}, "soon"},
        {{"plan", "fog.json", "--budget", "-3ms"}, "-3ms"},
        {{"plan", "fog.json", "--budget", "8fps"}, "8fps"},
        {{"plan", "fog.json", "--max-error", "0"}, "--max-error"},
        {{"plan", "fog.json", "--max-error", "0.01", "--budget", "8ms"}, "--budget"},
        {{"plan", "fog.json", "--max-error", "0.01", "--steps", "many"}, "many"},
        {{"render", "fog.json", "--mode", "reference", "--max-error", "0.01"}, "--max-error"},
        {{"render", "fog.json", "--show", "steps", "--budget", "8ms"}, "--budget"},
    };
    for (const Case& wrong : cases) {
        const Outcome refused = run(wrong.arguments);
        EXPECT_EQ(refused.code, 2) << joined(wrong.arguments) << "\n" << refused;
        EXPECT_NE(refused.err.find(wrong.named), std::string::npos)
            << joined(wrong.arguments) << "\n"
            << refused;
    }
    folder_.write("bare.json", R"({"resolution": [8, 8], "media": [], "surfaces": []})");
    const Outcome bare = run({"plan", "bare.json", "--max-error", "0.01"});
    EXPECT_EQ(bare.code, 1) << bare;
}

}  // namespace
}  // namespace fumarole::test
