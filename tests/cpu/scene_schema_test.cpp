// docs/scene.schema.json says of scene files what the reader does: the same keys, names, ranges and
// defaults of what may be left out.

#include <fumarole/asset/scene_file.h>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <regex>

#include "asset/json_reader.h"
#include "support/scene_schema.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const fs::path kRoot = fs::path(FUM_TEST_DATA).parent_path();

/// Where in a scene an object stands, as a JSON pointer into kScene.
struct Place {
    const char* definition;  ///< of the schema
    const char* at;
    const char* unread = "foreign";  ///< the definition of keys that it may have and nobody reads
};

constexpr Place kPlaces[] = {
    {"scene", ""},
    {"camera", "/camera"},
    {"camera_key", "/camera/0"},
    {"world", "/world_radiance"},
    {"sun", "/lights/0", "light_foreign"},
    {"point", "/lights/0", "light_foreign"},
    {"spot", "/lights/0", "light_foreign"},
    {"rect", "/lights/0", "light_foreign"},
    {"disk", "/lights/0"},
    {"grid", "/media/0"},
    {"homogeneous_box", "/media/0"},
    {"exp_height_box", "/media/0"},
    {"noise_box", "/media/0"},
    {"noise", "/media/0/noise"},
    {"sphere", "/surfaces/0"},
    {"box", "/surfaces/0"},
    {"mesh", "/surfaces/0"},
    {"quad", "/transparents/0"},
    {"billboard", "/transparents/0"},
    {"transparent_mesh", "/transparents/0"},
    {"blend_factors", "/transparents/0/blend"},
    {"plain_probe", "/probes/0"},
    {"box_probe", "/probes/0"},
};

const JsonSchema& schema()
{
    return JsonSchema::of_scenes();
}

/// A scene with the definition's example in its place.
Json example(const Place& place)
{
    const auto example_of = [](const std::string& definition) {
        return schema().definitions().at(definition).at("examples").at(0);
    };
    Json scene{{"camera", example_of("camera")}};
    const std::string at = place.at;
    if (at.starts_with("/media/0/"))
        scene["media"] = Json::array({example_of("noise_box")});
    if (at.starts_with("/transparents/0/"))
        scene["transparents"] = Json::array({example_of("quad")});
    if (at == "/camera/0" || at.ends_with("s/0") || at == "/media/0")
        scene[Json::json_pointer(at).parent_pointer()] = Json::array({nullptr});
    if (!at.empty())
        scene[Json::json_pointer(at)] = example_of(place.definition);
    return scene;
}

class SceneSchema : public testing::Test {
protected:
    /// The reader's complaint, "" if it has none.
    std::string complaint(const Json& scene)
    {
        try {
            (void)asset::parse_scene(folder_.write("s.json", scene.dump()));
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }

    /// Whether both take a scene, or both refuse it.
    void expect_agreement(const Json& scene)
    {
        const std::string by_schema = schema().problem(scene), by_reader = complaint(scene);
        if (by_schema.empty() && !by_reader.empty())
            EXPECT_TRUE(is_beyond_a_schema(by_reader)) << by_reader << '\n' << scene;
        else
            EXPECT_EQ(by_schema.empty(), by_reader.empty()) << by_schema << by_reader << '\n'
                                                            << scene;
    }

    /// What stands in single quotes, or between commas, in a part of a complaint.
    std::set<std::string> names_in(const std::string& complaint, const std::string& part)
    {
        std::set<std::string> names;
        std::smatch list;
        EXPECT_TRUE(std::regex_search(complaint, list, std::regex(part))) << complaint;
        const std::string text = list.size() > 1 ? list.str(1) : "";
        const std::regex name("[^', ]+");
        for (std::sregex_iterator it(text.begin(), text.end(), name), end; it != end; ++it)
            names.insert(it->str());
        return names;
    }

    TempFolder folder_;
};

TEST_F(SceneSchema, HasEveryKeyOfTheReaderAndNoOther)
{
    std::set<std::string> placed;
    for (const Place& place : kPlaces) {
        SCOPED_TRACE(place.definition);
        placed.insert(place.definition);
        Json scene = example(place);
        EXPECT_EQ(complaint(scene), "");
        scene[Json::json_pointer(place.at)]["no_key"] = 0;
        EXPECT_EQ(names_in(complaint(scene), "unknown key 'no_key' \\(known: (.*)\\)"),
                  schema().keys(place.definition, place.unread));
        EXPECT_NE(schema().problem(scene), "");
    }
    for (const auto& [name, definition] : schema().definitions().items())
        if (definition.contains("unevaluatedProperties")) {
            EXPECT_TRUE(placed.contains(name)) << name << " has no place in this test";
        }
    const auto foreign = asset::foreign_keys();
    EXPECT_EQ(std::set<std::string>(foreign.begin(), foreign.end()), schema().keys("foreign"));
    Json light = example(kPlaces[4]);
    light["lights"][0]["radius"] = "any";
    EXPECT_EQ(complaint(light), "");
}

TEST_F(SceneSchema, HasEveryNameThatAKeyMayHave)
{
    std::map<std::string, std::set<std::string>> of_schema, of_reader;
    const std::function<void(const Json&, std::set<std::string>&)> add =
        [&](const Json& said, std::set<std::string>& names) {
            if (said.contains("anyOf"))
                for (const Json& way : said["anyOf"])
                    add(way, names);
            if (said.contains("$ref"))
                if (const std::string name = said["$ref"]; name.ends_with("blend_factor"))
                    add(schema().definitions().at("blend_factor"), names);
            if (said.contains("const") && said["const"].is_string())
                names.insert(said["const"]);
            if (said.contains("enum"))
                names.insert(said["enum"].begin(), said["enum"].end());
        };
    for (const Place& place : kPlaces)
        for (const std::string& key : schema().keys(place.definition, "foreign")) {
            std::set<std::string> names;
            if (const Json& said = schema().key(place.definition, key); said.is_object())
                add(said, names);
            if (names.empty())
                continue;
            const std::string where = fmt::format("{}/{}", place.at, key);
            of_schema[where].merge(names);
            Json scene = example(place);
            scene[Json::json_pointer(place.at)][key] = "?";
            of_reader[where] = names_in(complaint(scene), "expected one of ('.*'), got");
        }
    EXPECT_GE(of_schema.size(), 10u);
    EXPECT_EQ(of_schema, of_reader);
}

TEST_F(SceneSchema, TakesAndRefusesTheSameValues)
{
    const std::vector<Json> values{nullptr,
                                   true,
                                   false,
                                   "",
                                   "text",
                                   -1e13,
                                   -1,
                                   0,
                                   0.5,
                                   1,
                                   1.5,
                                   16,
                                   17,
                                   100,
                                   180,
                                   512,
                                   1e6,
                                   2e6,
                                   1e13,
                                   Json::array(),
                                   Json::object(),
                                   {1, 1},
                                   {1.5, 2},
                                   {16384, 16384},
                                   {16385, 1},
                                   {0, 0},
                                   {1, 1, 1},
                                   {-1, 2, 3},
                                   {2, 0.5, 0},
                                   {0.5, 0, 0},
                                   {1, 1, 1, 1},
                                   {"a", 1, 1},
                                   {1e13, 1, 1},
                                   {{1, 0, 0}, {0, 1, 0}},
                                   {{1, 0, 0}, {0, 1}},
                                   {{1, 0, 0}}};
    for (const Place& place : kPlaces) {
        const Json whole = example(place);
        const Json::json_pointer at(place.at);
        for (const std::string& key : schema().keys(place.definition)) {
            Json scene = whole;
            for (const Json& value : values) {
                scene[at][key] = value;
                expect_agreement(scene);
            }
            if (whole[at].contains(key)) {
                scene[at].erase(key);
                expect_agreement(scene);
            }
            if (HasFailure())
                return;  // one case says enough
        }
    }
}

TEST_F(SceneSchema, HasTheDefaultsOfTheReader)
{
    // Written out they are left out again: a scene with the default is the scene without.
    for (const Place& place : kPlaces) {
        const Json whole = example(place);
        const auto text = [&](const Json& scene) {
            return asset::scene_to_json(asset::parse_scene(folder_.write("s.json", scene.dump())),
                                        folder_.path());
        };
        for (const std::string& key : schema().keys(place.definition)) {
            const Json& said = schema().key(place.definition, key);
            Json scene = whole;
            if (!said.is_object() || !said.contains("default") ||
                scene[Json::json_pointer(place.at)].contains(key))
                continue;
            scene[Json::json_pointer(place.at)][key] = said["default"];
            if (complaint(scene).empty()) {
                EXPECT_EQ(text(scene), text(whole)) << place.definition << ' ' << key;
            }
        }
    }
}

TEST_F(SceneSchema, TakesTheScenesThatComeWithUs)
{
    int found = 0;
    for (const char* folder : {"vdb_samples", "tests/reference"})
        for (const auto& entry : fs::directory_iterator(kRoot / folder))
            if (entry.path().extension() == ".json") {
                EXPECT_EQ(problem_of_accepted(read_bytes(entry.path())), "") << entry.path();
                ++found;
            }
    EXPECT_GE(found, 11);
    // All keys, as docs/scene_files.md has them.
    const std::string page = read_bytes(kRoot / "docs" / "scene_files.md");
    const std::size_t begin = page.find("```json\n") + 8;
    EXPECT_EQ(problem_of_accepted(page.substr(begin, page.find("```", begin) - begin)), "");
}

}  // namespace
}  // namespace fumarole::test
