// `fumarole view` in a real window, under Xvfb, with a script in a person's stead. OpenGL's errors
// end the program.

#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <poll.h>
#include <regex>
#include <sstream>

#include "cli/fog_scene.h"
#include "cli/run_program.h"
#include <fumarole/settings.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

/// A display of our own, on a number that is free.
class Xvfb {
public:
    Xvfb()
    {
        int pipe_ends[2];
        if (pipe(pipe_ends) != 0)
            return;
        child_ = fork();
        if (child_ == 0) {
            close(pipe_ends[0]);
            const int silence = open("/dev/null", O_WRONLY);
            dup2(silence, STDERR_FILENO);
            const std::string end = std::to_string(pipe_ends[1]);
            execlp("Xvfb", "Xvfb", "-displayfd", end.c_str(), "-screen", "0", "1280x800x24",
                   "-nolisten", "tcp", nullptr);
            _exit(127);
        }
        close(pipe_ends[1]);
        // To the end of the line: it writes in parts, and a pipe that is closed before kills it.
        std::string number;
        pollfd ready{pipe_ends[0], POLLIN, 0};
        for (char c = 0; c != '\n' && poll(&ready, 1, 30000) > 0 && read(pipe_ends[0], &c, 1) == 1;)
            number += c;
        if (number.ends_with('\n'))
            name_ = fmt::format(":{}", std::atoi(number.c_str()));
        close(pipe_ends[0]);
    }
    ~Xvfb()
    {
        if (child_ > 0) {
            kill(child_, SIGTERM);
            waitpid(child_, nullptr, 0);
        }
    }
    Xvfb(const Xvfb&) = delete;
    Xvfb& operator=(const Xvfb&) = delete;

    [[nodiscard]] const std::string& name() const { return name_; }

private:
    pid_t child_ = -1;
    std::string name_;
};

struct Pixels {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;

    /// A part as a picture of its own.
    /// @throws std::out_of_range if it is not within the picture, which may have failed to be taken
    [[nodiscard]] Pixels part(int left, int top, int w, int h) const
    {
        if (left + w > width || top + h > height)
            throw std::out_of_range(fmt::format("a picture of {} x {} has no part {} {} {} {}",
                                                width, height, left, top, w, h));
        Pixels out{w, h, {}};
        for (int y = top; y < top + h; ++y) {
            const auto row = rgb.begin() + (static_cast<std::ptrdiff_t>(y) * width + left) * 3;
            out.rgb.insert(out.rgb.end(), row, row + static_cast<std::ptrdiff_t>(w) * 3);
        }
        return out;
    }
};

Pixels read_png(const fs::path& file)
{
    const auto input = OIIO::ImageInput::open(file.string());
    if (input == nullptr)
        return {};
    const OIIO::ImageSpec& spec = input->spec();
    Pixels pixels{spec.width, spec.height,
                  std::vector<std::uint8_t>(static_cast<std::size_t>(spec.width) *
                                            static_cast<std::size_t>(spec.height) * 3)};
    input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.rgb.data());
    return pixels;
}

/// Mean difference of two pictures of one size, in steps of 8 bits; infinite if the sizes differ.
double distance(const Pixels& a, const Pixels& b)
{
    if (a.rgb.size() != b.rgb.size() || a.rgb.empty())
        return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i)
        sum += std::abs(static_cast<double>(a.rgb[i]) - b.rgb[i]);
    return sum / static_cast<double>(a.rgb.size());
}

class View : public testing::Test {
protected:
    static void SetUpTestSuite() { display().emplace(); }
    static void TearDownTestSuite() { display().reset(); }
    static std::optional<Xvfb>& display()
    {
        static std::optional<Xvfb> one;
        return one;
    }

    /// Where Mesa keeps compiled shaders by default.
    static const std::string& shader_cache()
    {
        static const std::string folder = [] {
            const char* cache = std::getenv("XDG_CACHE_HOME");
            const char* home = std::getenv("HOME");
            return cache != nullptr  ? std::string(cache)
                   : home != nullptr ? std::string(home) + "/.cache"
                                     : fs::temp_directory_path().string();
        }();
        return folder;
    }

    View()
    {
        setenv("DISPLAY", display()->name().c_str(), 1);
        setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
        setenv("XDG_CONFIG_HOME", (folder_.path() / "config").c_str(), 1);
        // Mesa keeps compiled shaders where all tests find them again: LLVM takes a second or two
        // for each program.
        setenv("MESA_SHADER_CACHE_DIR", shader_cache().c_str(), 1);
        setenv("XDG_CACHE_HOME", (folder_.path() / "cache").c_str(), 1);
    }
    void SetUp() override
    {
        ASSERT_NE(display()->name(), "") << "Xvfb did not start; packages.txt lists it";
    }

    [[nodiscard]] Outcome view(const std::string& script, const Arguments& more = {},
                               const std::string& size = "320x240") const
    {
        folder_.write("script.json", script);
        Arguments all{"view",       "--script", "script.json", "--frames", "1",
                      "--gl-debug", "--json",   "--size",      size};
        all.insert(all.end(), more.begin(), more.end());
        return run_program(folder_.path(), all);
    }
    [[nodiscard]] Pixels shot(const std::string& name) const
    {
        return read_png(folder_.path() / name);
    }
    TempFolder folder_;
};

// The window is too narrow for its panel: all of it is picture.
TEST_F(View, ThePictureIsTheOneThatItsCommandLineMakes)
{
    // A sun that was dragged by its handle, a camera that was, a setting that was changed.
    const Outcome run = view(R"([{"wait": "loaded"}, {"set": {"steps": 24}},
        {"key": "L"}, {"frames": 2}, {"drag": [[71, 49], [200, 40]], "frames": 3}, {"key": "L"},
        {"drag": [[160, 60], [200, 80]], "frames": 3}, {"wheel": 1, "at": [160, 120]},
        {"wait": "settled"}, {"screenshot": "window.png"},
        {"key": "Ctrl+C"}, {"frames": 2}, {"clipboard": "command.txt"}])",
                             {sample("smoke_plume_sun.json"), "--aa=2"});
    ASSERT_EQ(run.code, 0) << run;
    std::istringstream words(read_bytes(folder_.path() / "command.txt"));
    Arguments command{std::istream_iterator<std::string>(words), {}};
    ASSERT_GT(command.size(), 3u);
    EXPECT_EQ(command[0], "fumarole");
    command.erase(command.begin());
    const std::string output = command.back();
    const Json was = Json::parse(read_bytes(sample("smoke_plume_sun.json"))),
               now = Json::parse(read_bytes(command[1]));
    EXPECT_LT(was["lights"][0]["direction_to_light"][0].get<double>(), -0.2) << "from the left";
    EXPECT_GT(now["lights"][0]["direction_to_light"][0].get<double>(), 0.2) << "from the right";
    EXPECT_THAT(joined(command), HasSubstr("--steps 24"));
    const Outcome headless = run_program(folder_.path(), command);
    ASSERT_EQ(headless.code, 0) << joined(command) << headless;
    Pixels window = shot("window.png"), picture = shot(output);
    // The mode's name stands in the corner; what is left is the same, rounded by two ways to a
    // screen's values.
    EXPECT_LT(distance(window.part(0, 40, 320, 160), picture.part(0, 40, 320, 160)), 0.02);
    EXPECT_GT(distance(window.part(0, 0, 320, 40), picture.part(0, 0, 320, 40)), 0.02)
        << "where is the label?";
}

TEST_F(View, ModesSplitByAWipeThatIsDragged)
{
    const Outcome run = view(R"([{"wait": "settled"}, {"screenshot": "a.png"},
        {"key": "2"}, {"wait": "settled"}, {"screenshot": "b.png"},
        {"key": "1"}, {"key": "S"}, {"wait": "settled"},
        {"drag": [[160, 120], [96, 120]]}, {"frames": 2}, {"screenshot": "split.png"},
        {"key": "D"}, {"wait": "settled"}, {"screenshot": "difference.png"},
        {"key": "D"}, {"key": "V"}, {"frames": 2}, {"wait": "settled"}, {"screenshot": "inside.png"}])",
                             {sample("smoke_plume_sun.json"), "--aa=1", "--exposure=0",
                              "--steps=16", "--tile=16", "--slices=8"});
    ASSERT_EQ(run.code, 0) << run;
    const Pixels a = shot("a.png"), b = shot("b.png"), split = shot("split.png");
    EXPECT_GT(distance(a.part(100, 40, 220, 200), b.part(100, 40, 220, 200)), 0.5)
        << "the modes ought to differ, or this test sees nothing";
    EXPECT_EQ(distance(a.part(0, 40, 94, 200), split.part(0, 40, 94, 200)), 0);
    // The other side is eevee2017, the default to compare with.
    EXPECT_GT(distance(a.part(100, 40, 220, 200), split.part(100, 40, 220, 200)), 0.5);
    EXPECT_GT(distance(a, shot("difference.png")), 5);
    EXPECT_GT(distance(a, shot("inside.png")), 5);
}

TEST_F(View, TheReferenceComesAndErrorsAreMeasuredAgainstIt)
{
    const Outcome run =
        view(R"([{"wait": "loaded"}, {"key": "3"}, {"wait": "reference", "seconds": 300},
                 {"frames": 2}, {"screenshot": "reference.png"}])",
             {sample("smoke_plume_sun.json"), "--aa=1", "--exposure=0", "--bounces=0"}, "240x180");
    ASSERT_EQ(run.code, 0) << run;
    const Json errors = Json::parse(run.out)["errors"];
    ASSERT_EQ(errors.size(), 1u) << run;
    EXPECT_LT(errors[0]["relmse"].get<double>(), 2e-2);
    EXPECT_GT(errors[0]["relmse"].get<double>(), 0);
    EXPECT_EQ(shot("reference.png").width, 240);
}

TEST_F(View, ErrorsAreThoseOfThePictureThatIsShown)
{
    const auto error = [&](const std::string& change) {
        const Outcome run = view(
            R"([{"wait": "loaded"}, {"key": "3"}, {"wait": "reference"},
                                     {"frames": 2}, )" +
                change + R"({"wait": "settled"}, {"frames": 2}])",
            {sample("smoke_plume_sun.json"), "--aa=1", "--exposure=0", "--bounces=0"}, "120x90");
        EXPECT_EQ(run.code, 0) << run;
        const Json errors = Json::parse(run.out)["errors"];
        EXPECT_EQ(errors.size(), 1u) << run;
        return errors.empty() ? 0 : errors[0]["relmse"].get<double>();
    };
    EXPECT_GT(error(R"({"set": {"steps": 3}}, {"frames": 2}, )"), 1.5 * error(""))
        << "the reference is the same, the picture is not";
}

// The same word as for `render`, and the same file.
TEST_F(View, SavesTheSceneThatItOpensAndNotItsEdits)
{
    for (const int frame : {1, 2})
        fs::copy_file(sample("smoke_plume.vdb"), folder_.path() / fmt::format("s_{}.vdb", frame));
    const Outcome render =
        run_program(folder_.path(), with_little_light({"render", "s_#.vdb", "--size=32x18",
                                                       "--aa=1", "--frames=1..2", "-o", "x.#.png",
                                                       "--save-scene", "render.json"}));
    ASSERT_EQ(render.code, 0) << render;
    const Outcome run =
        view(R"([{"wait": "loaded"}, {"drag": [[160, 60], [200, 80]], "frames": 2}])",
             with_little_light({"s_#.vdb", "--aa=1", "--steps=4", "--save-scene=view.json"}));
    ASSERT_EQ(run.code, 0) << run;
    Json ours = Json::parse(read_bytes(folder_.path() / "view.json")),
         theirs = Json::parse(read_bytes(folder_.path() / "render.json"));
    for (Json* json : {&ours, &theirs})
        json->erase("resolution");  // of the picture there, of the scene here
    EXPECT_EQ(ours, theirs);
    EXPECT_THAT(ours.dump(), HasSubstr("s_#.vdb"));

    const Outcome none = view("[]", {"--save-scene=none.json"});
    EXPECT_EQ(none.code, 2) << none;
    EXPECT_THAT(none.err, HasSubstr("--save-scene"));
    const Outcome nowhere =
        view(R"([{"wait": "loaded"}])",
             with_little_light({"s_#.vdb", "--aa=1", "--steps=4", "--save-scene=no/view.json"}));
    EXPECT_EQ(nowhere.code, 1) << nowhere;
    EXPECT_THAT(nowhere.err, HasSubstr("no such folder 'no'"));
    folder_.write("torn.vdb", "no grid");
    const Outcome unread =
        view(R"([{"wait": "loaded"}])", {"torn.vdb", "--save-scene=unread.json"});
    EXPECT_EQ(unread.code, 1) << unread;
    EXPECT_THAT(unread.err, HasSubstr("unread.json: not written"));
    EXPECT_FALSE(fs::exists(folder_.path() / "unread.json"));
}

TEST_F(View, APlanIsMadeBesideThePictureAndTaken)
{
    // Fog in a box, of which many settings are tried in a plan's ten seconds.
    folder_.write("fog.json", fog_scene("[320, 240]", R"({"type": "box", "min": [-1, -1, 0],
        "max": [1, 1, 2], "profile": "homogeneous", "sigma_s": [0.5, 0.5, 0.5],
        "sigma_a": [0.1, 0.2, 0.3], "g": 0.2})"));
    const Outcome run = view(R"([{"wait": "settled"}, {"wait": "plan", "seconds": 120},
        {"wait": "settled"}, {"key": "Ctrl+C"}, {"frames": 2}, {"clipboard": "command.txt"}])",
                             {"fog.json", "--aa=1", "--preset=eevee2017", "--max-error=0.5"});
    ASSERT_EQ(run.code, 0) << run;
    const std::string command = read_bytes(folder_.path() / "command.txt"),
                      plan = Json::parse(run.out)["plan"].get<std::string>();
    EXPECT_THAT(plan, testing::StartsWith("planned for error 0.5: "));
    int settings = 0;  // that it finds; which ones depends on the load
    for (const SettingInfo& setting : setting_table()) {
        const std::regex words(fmt::format(" --{} ([^ ,]+)", setting.name));
        std::smatch planned, taken;
        if (std::regex_search(plan, planned, words)) {
            ++settings;
            EXPECT_TRUE(std::regex_search(command, taken, words)) << plan << '\n' << command;
            EXPECT_EQ(planned.str(1), taken.str(1)) << plan << '\n' << command;
        }
    }
    if (settings == 0)
        GTEST_SKIP() << "this machine had no time for a try: " << plan;
}

TEST_F(View, ASequencePlaysAndIsScrubbed)
{
    const Outcome run =
        view(R"([{"wait": "settled"}, {"screenshot": "first.png"},
        {"key": "Right"}, {"wait": {"frame": 2}}, {"wait": "settled"}, {"screenshot": "second.png"},
        {"key": "Home"}, {"wait": {"frame": 1}}, {"wait": "settled"}, {"screenshot": "again.png"},
        {"key": "Space"}, {"wait": {"frame": 3}}, {"key": "Space"}])",
             {std::string(FUM_TEST_DATA) + "/smoke_seq/smoke_####.vdb", "--aa=1", "--exposure=0"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_GT(distance(shot("first.png"), shot("second.png")), 0.1);
    EXPECT_EQ(distance(shot("first.png"), shot("again.png")), 0);
}

TEST_F(View, AFileThatIsLostWhilePlayingIsNamed)
{
    for (const char* name : {"smoke_0001.vdb", "smoke_0003.vdb"})
        fs::copy_file(sample("smoke_plume.vdb"), folder_.path() / name);
    const Outcome run = view(R"([{"wait": "loaded"}, {"key": "Space"}, {"wait": "message"}])",
                             {"smoke_####.vdb", "--aa=1"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_THAT(Json::parse(run.out)["message"].get<std::string>(),
                HasSubstr("smoke_0002.vdb: frame 2 is missing"));
}

TEST_F(View, WhatCannotBeOpenedIsSaidAndWhatWasThereStays)
{
    const Outcome run = view(R"([{"wait": "settled"}, {"screenshot": "before.png"},
        {"drop": ["none.vdb"]}, {"wait": "message"}, {"frames": 2}, {"screenshot": "message.png"},
        {"key": "Esc"}, {"wait": "settled"}, {"screenshot": "after.png"},
        {"open": "none.vdb"}, {"wait": "message"}])",
                             {sample("smoke_plume_sun.json"), "--aa=1"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_THAT(Json::parse(run.out)["message"].get<std::string>(), HasSubstr("none.vdb"));
    EXPECT_EQ(distance(shot("before.png"), shot("after.png")), 0);
    EXPECT_GT(distance(shot("before.png"), shot("message.png")), 1);
}

TEST_F(View, SmallLargeAndMinimisedWindowsAreWindowsToo)
{
    const Outcome run = view(R"([{"wait": "settled"}, {"resize": [120, 90]}, {"frames": 3},
        {"screenshot": "small.png"}, {"minimise": true}, {"frames": 3}, {"minimise": false},
        {"resize": [700, 400]}, {"frames": 2}, {"wait": "settled"}, {"key": "?"}, {"frames": 2},
        {"screenshot": "large.png"}])",
                             {sample("smoke_plume_sun.json"), "--aa=1"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_EQ(shot("small.png").width, 120);
    EXPECT_EQ(shot("large.png").width, 700);
    EXPECT_EQ(Json::parse(run.out)["message"], "");
}

TEST_F(View, SettingsAreKeptFromOneTimeToTheNext)
{
    const std::string copy =
        R"([{"wait": "loaded"}, {"key": "Ctrl+C"}, {"frames": 2}, {"clipboard": "command.txt"}])";
    ASSERT_EQ(view(R"([{"wait": "loaded"}, {"set": {"preset": "eevee2017", "steps": 19}}])",
                   {sample("smoke_plume_sun.json")})
                  .code,
              0);
    ASSERT_EQ(view(copy, {sample("smoke_plume_sun.json")}).code, 0);
    EXPECT_THAT(read_bytes(folder_.path() / "command.txt"),
                HasSubstr("--preset eevee2017 --steps 19"));
    const Json kept = Json::parse(read_bytes(folder_.path() / "config/fumarole/view.json"));
    EXPECT_EQ(kept["recent"].size(), 1u);
    // What is typed now goes before.
    ASSERT_EQ(view(copy, {sample("smoke_plume_sun.json"), "--steps=33"}).code, 0);
    EXPECT_THAT(read_bytes(folder_.path() / "command.txt"), HasSubstr("--steps 33"));
}

/// The rows of a report that have a name.
Json named(const Json& rows, const std::string& name)
{
    for (const Json& row : rows)
        if (row["name"] == name)
            return row;
    return Json::object();
}

TEST_F(View, GridsAreSwitchedAndTheSavedSceneKeepsIt)
{
    fs::copy_file(sample("fire_plume.vdb"), folder_.path() / "fire.vdb");
    const Arguments quick{"fire.vdb",    "--aa=1",     "--exposure=0",
                          "--bounces=0", "--steps=16", "--resolution=quarter"};
    const Outcome run = view(R"([{"wait": "grids"}, {"wait": "settled"}, {"screenshot": "fire.png"},
        {"grid": {"flame": "off"}}, {"wait": "grids"}, {"wait": "settled"},
        {"screenshot": "smoke.png"},
        {"grid": {"temperature": "temperature", "density": "off"}}, {"wait": "grids"},
        {"wait": "settled"}, {"screenshot": "heat.png"}, {"key": "Ctrl+S"}, {"frames": 2},
        {"grid": {"temperature": "colour"}}, {"frames": 2}])",
                             quick);
    ASSERT_EQ(run.code, 0) << run;
    const Json grids = Json::parse(run.out)["grids"];
    ASSERT_EQ(grids.size(), 3u) << run;
    EXPECT_EQ(named(grids, "density")["role"], "off");
    EXPECT_EQ(named(grids, "flame")["role"], "off");
    EXPECT_EQ(named(grids, "temperature")["role"], "temperature") << "as it was";
    EXPECT_EQ(named(grids, "temperature")["voxels"], 85556);
    EXPECT_THAT(named(grids, "temperature")["error"].get<std::string>(),
                HasSubstr("'temperature' can't be the colour"));
    EXPECT_EQ(Json::parse(run.out)["message"], "") << "it is said where it was asked for";
    const Pixels fire = shot("fire.png"), smoke = shot("smoke.png"), heat = shot("heat.png");
    EXPECT_GT(distance(fire, smoke), 0.2);
    EXPECT_GT(distance(smoke, heat), 1);
    const Json medium = Json::parse(read_bytes(folder_.path() / "fire.json"))["media"][0];
    ASSERT_TRUE(medium.contains("temperature_grid")) << medium;
    EXPECT_EQ(medium["temperature_grid"], "temperature");
    EXPECT_EQ(medium.value("temperature_scale", 0), 1000);
    EXPECT_EQ(medium["sigma_s_per_density"], Json({0, 0, 0}));
    EXPECT_FALSE(medium.contains("emission_grid"));
    // The scene that was saved is what was seen.
    const Outcome again = run_program(
        folder_.path(), {"render", "fire.json", "--size=320x240", "--aa=1", "--exposure=0",
                         "--bounces=0", "--steps=16", "--resolution=quarter", "-o", "again.png"});
    ASSERT_EQ(again.code, 0) << again;
    EXPECT_LT(distance(shot("again.png").part(0, 40, 320, 200), heat.part(0, 40, 320, 200)), 0.1);
    // By hand: the box of the first grid, and the first line of what it offers.
    const Outcome chosen = view(R"([{"wait": "grids"}, {"frames": 3}, {"click": [260, 601]},
        {"frames": 3}, {"click": [210, 499]}, {"frames": 2}, {"wait": "grids"}])",
                                quick, "640x720");
    EXPECT_EQ(named(Json::parse(chosen.out)["grids"], "density")["role"], "off") << chosen;
    EXPECT_EQ(named(Json::parse(chosen.out)["grids"], "flame")["role"], "emission") << chosen;
    const Outcome wrong = view(R"([{"wait": "grids"}, {"grid": {"flame": "glow"}},
                                   {"wait": "message"}])",
                               quick);
    EXPECT_THAT(Json::parse(wrong.out)["message"].get<std::string>(),
                HasSubstr("'glow' (there are: off, density, temperature, emission, colour)"));
}

TEST_F(View, AFolderIsLookedThroughByPictures)
{
    const fs::path data = folder_.path() / "data";
    fs::create_directories(data / "more");
    for (const int frame : {1, 2, 3})
        fs::copy_file(sample(fmt::format("smoke_seq/smoke_000{}.vdb", frame + 4)),
                      data / fmt::format("smoke_000{}.vdb", frame));
    fs::copy_file(sample("fire_plume.vdb"), data / "fire_plume.vdb");
    fs::copy_file(sample("fire_plume.json"), data / "fire.json");
    folder_.write("data/torn.vdb", read_bytes(sample("cloud.vdb")).substr(0, 5000));
    folder_.write("data/notes.json", R"({"name": "no scene"})");
    const Outcome run = view(R"([{"browse": "data"}, {"wait": "thumbnails", "seconds": 300},
                                 {"frames": 4}, {"screenshot": "files.png"}])",
                             {}, "900x600");
    ASSERT_EQ(run.code, 0) << run;
    const Json files = Json::parse(run.out)["files"];
    ASSERT_EQ(files.size(), 5u) << run;
    EXPECT_EQ(files[0]["name"], "more");
    EXPECT_EQ(named(files, "smoke_####.vdb")["frames"], 3);
    for (const char* name : {"smoke_####.vdb", "fire_plume.vdb", "fire.json"})
        EXPECT_EQ(named(files, name)["picture"], true) << name << run;
    EXPECT_THAT(named(files, "torn.vdb")["error"].get<std::string>(),
                HasSubstr("damaged or cut short"));
    EXPECT_EQ(list(folder_.path() / "cache/thumbnails/large").size(), 3u);
    EXPECT_EQ(list(folder_.path() / "cache/thumbnails/fail/fumarole").size(), 1u);
    const Pixels window = shot("files.png");
    ASSERT_EQ(window.width, 900);

    // By keys: into the folder and back, then the last file by its first letter.
    const std::string keys = R"([{"browse": "data"}, {"wait": "thumbnails", "seconds": 300},
        {"key": "Enter"}, {"wait": "thumbnails"}, {"key": "Backspace"}, {"wait": "thumbnails"},
        {"key": "S"}, {"key": "Enter"}, {"wait": "loaded"}, {"frames": 2}])";
    const Arguments quick{"--aa=1", "--bounces=0", "--steps=8", "--resolution=quarter"};
    const Outcome opened = view(keys, quick, "900x600");
    ASSERT_EQ(opened.code, 0) << opened;
    EXPECT_EQ(Json::parse(opened.out)["files"].size(), 0u) << "it closes";
    const Json kept = Json::parse(read_bytes(folder_.path() / "config/fumarole/view.json"));
    EXPECT_EQ(kept["folder"], data.string());
    EXPECT_EQ(kept["recent"][0], (data / "smoke_####.vdb").string());

    // By a double click on the second one, and what is wrong with it is said as of any file.
    const Outcome clicked = view(R"([{"key": "Ctrl+O"}, {"wait": "thumbnails", "seconds": 300},
        {"frames": 2}, {"click": [300, 170], "double": true}, {"wait": "loaded"}])",
                                 quick, "900x600");
    ASSERT_EQ(clicked.code, 0) << clicked;
    const Json recent = Json::parse(read_bytes(folder_.path() / "config/fumarole/view.json"));
    EXPECT_EQ(recent["recent"][0], (data / "fire.json").string());
}

TEST_F(View, NamesOfAnyScriptHaveTheirLetters)
{
    // A row of files, each named by one letter, in their order; the first one is marked as chosen.
    const auto letters = [&](const std::vector<std::string>& names) {
        fs::remove_all(folder_.path() / "data");
        fs::create_directory(folder_.path() / "data");
        for (const std::string& name : names)
            folder_.write("data/" + name + ".vdb", "no volume");
        const Outcome run = view(R"([{"browse": "data"}, {"wait": "thumbnails", "seconds": 300},
                                     {"frames": 2}, {"screenshot": "names.png"}])",
                                 {}, "900x600");
        EXPECT_EQ(run.code, 0) << run;
        const Pixels window = shot("names.png");
        std::vector<Pixels> shown;
        for (std::size_t i = 0; i < names.size(); ++i)
            shown.push_back(window.part(41 + static_cast<int>(i) * 166, 193, 8, 16));
        return std::pair{shown, run};
    };
    // Latin beyond our own font, Greek, Cyrillic, kana; kanji, Korean, and a code that is no
    // letter.
    const auto [shown, run] = letters({"0", "ő", "λ", "д", "か"});
    const auto [more, more_run] = letters({"0", "?", "\u0378", "煙", "연"});
    for (std::size_t i = 2; i < 5; ++i)
        for (std::size_t j = 1; j < i; ++j) {
            EXPECT_GT(distance(shown[i], shown[j]), 5) << i << ' ' << j << run;
            EXPECT_EQ(distance(more[i], more[j]) < 5, i == 2) << i << ' ' << j << more_run;
        }
    EXPECT_EQ(distance(more[2], more[1]), 0);
    EXPECT_THAT(more_run.out, HasSubstr("no font of this computer has U+0378, and a question"));

    // Where there are no fonts at all, each is a question mark.
    folder_.write("none.conf", "<fontconfig></fontconfig>");
    setenv("FONTCONFIG_FILE", (folder_.path() / "none.conf").c_str(), 1);
    const auto [none, bare_run] = letters({"0", "ő", "д", "か", "煙"});
    unsetenv("FONTCONFIG_FILE");
    for (std::size_t i = 1; i < none.size(); ++i)
        EXPECT_EQ(distance(none[i], more[1]), 0) << i << bare_run;
    EXPECT_THAT(bare_run.out, HasSubstr("has U+0151 or 3 more"));
}

TEST_F(View, WithoutADisplayOrWithAnOldOpenGLItSaysWhatToDo)
{
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    const Outcome old = view("[]", {sample("smoke_plume_sun.json")});
    unsetenv("MESA_GL_VERSION_OVERRIDE");
    EXPECT_EQ(old.code, 1) << old;
    EXPECT_THAT(old.err, HasSubstr("OpenGL 4.5"));
    EXPECT_EQ(old.error_lines(), 1) << old;
    unsetenv("DISPLAY");
    const Outcome none = view("[]", {sample("smoke_plume_sun.json")});
    EXPECT_EQ(none.code, 1) << none;
    EXPECT_THAT(none.err, HasSubstr("fumarole render"));
    EXPECT_EQ(none.error_lines(), 1) << none;
}

TEST_F(View, ScriptsAndWordsThatAreWrongEndIt)
{
    const Outcome unknown = view(R"([{"key": "Hyper"}])");
    EXPECT_EQ(unknown.code, 1);
    EXPECT_THAT(unknown.err, HasSubstr("script.json: action 1: no key is called 'Hyper'"));
    const Outcome vain = view(R"([{"wait": "loaded", "seconds": 0.2}])");
    EXPECT_EQ(vain.code, 1) << "nothing was opened, nothing is loaded";
    EXPECT_EQ(run_program(folder_.path(), {"view", "--compare=cinema"}).code, 2);
    EXPECT_EQ(run_program(folder_.path(), {"view", "--size=big"}).code, 2);
    const Outcome help = run_program(folder_.path(), {"view", "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, HasSubstr("split screen: drag the line"));
}

}  // namespace
}  // namespace fumarole::test
