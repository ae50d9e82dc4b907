// `fumarole render` and `fumarole info` as a user runs them: what they write and what they say.

#include <OpenImageIO/imageio.h>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "cli/fog_scene.h"
#include "cli/run_program.h"
#include "support/make_vdb.h"
#include <fumarole/settings.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr const char* kSmall = "--size=96x54";
const std::vector<std::string> kTargets{"composite", "scattering",  "transmittance",
                                        "surface",   "surface_lit", "depth"};

/// Channels of an EXR that `render` writes, as all_targets: a name to the picture's floats.
struct Channels {
    explicit Channels(const fs::path& file)
        : image{write::read_exr(file, {})}, names{image.channels.begin(), image.channels.end()}
    {
    }
    [[nodiscard]] std::vector<float> of(const std::string& name) const
    {
        const auto at = std::find(image.channels.begin(), image.channels.end(), name);
        EXPECT_NE(at, image.channels.end()) << "no channel " << name;
        std::vector<float> values;
        for (std::size_t i = std::size_t(at - image.channels.begin()); i < image.pixels.size();
             i += image.channels.size())
            values.push_back(image.pixels[i]);
        return values;
    }
    Image image;
    std::set<std::string> names;
};

struct Range {
    float min = std::numeric_limits<float>::infinity(), max = -min;
    double mean = 0;
    bool finite = true;
};
Range range_of(const std::vector<float>& values)
{
    Range range;
    for (const float v : values) {
        range.finite &= std::isfinite(v);
        range.min = std::min(range.min, v);
        range.max = std::max(range.max, v);
        range.mean += v / double(values.size());
    }
    return range;
}

/// Runs that must succeed, quietly.
Outcome must(const TempFolder& folder, const Arguments& arguments)
{
    Outcome run = run_program(folder.path(), arguments);
    EXPECT_EQ(run.code, 0) << joined(arguments) << '\n' << run;
    EXPECT_EQ(run.err, "") << joined(arguments);
    return run;
}

// Facts of vdb_samples, from the program that made them (pyopenvdb), in report.json beside them.
struct GridFacts {
    const char* file;
    const char* grid;
    double voxel;
    glm::ivec3 index_min, index_max;
    glm::dvec3 world_min, world_max;
    std::uint64_t active_voxels;
    double max, mean;
    std::uint64_t file_bytes;
};
const std::vector<GridFacts> kFacts{
    {"smoke_plume.vdb",
     "density",
     0.035714,
     {7, 5, 7},
     {110, 110, 150},
     {-1.75, -1.8214, 0.25},
     {1.9643, 1.9643, 5.3929},
     393196,
     1.13086,
     0.12788,
     1012810},
    {"fire_plume.vdb",
     "density",
     0.0625,
     {2, 1, 4},
     {58, 59, 104},
     {-1.875, -1.9375, 0.25},
     {1.6875, 1.75, 6.5625},
     76665,
     0.66943,
     0.07151,
     473765},
    {"fire_plume.vdb",
     "flame",
     0.0625,
     {20, 19, 4},
     {43, 40, 53},
     {-0.75, -0.8125, 0.25},
     {0.75, 0.5625, 3.375},
     4917,
     0.91309,
     0.38585,
     473765},
    {"fire_plume.vdb",
     "temperature",
     0.0625,
     {1, 1, 4},
     {58, 60, 104},
     {-1.9375, -1.9375, 0.25},
     {1.6875, 1.8125, 6.5625},
     85556,
     2.83984,
     0.32318,
     473765},
    {"cloud.vdb",
     "density",
     2.0,
     {13, 12, 31},
     {111, 114, 108},
     {-102, -104, 62},
     {96, 102, 218},
     176556,
     1.0,
     0.62801,
     370772},
};

TEST(Info, NumbersAreTheFiles)
{
    const TempFolder folder;
    std::map<std::string, Json> files;
    for (const GridFacts& facts : kFacts) {
        if (!files.contains(facts.file))
            files[facts.file] =
                Json::parse(must(folder, {"info", sample(facts.file), "--json"}).out);
        const Json& info = files[facts.file];
        EXPECT_EQ(info.at("file_bytes"), facts.file_bytes);
        const auto& grids = info.at("grids");
        const auto grid = std::find_if(grids.begin(), grids.end(),
                                       [&](const Json& g) { return g.at("name") == facts.grid; });
        ASSERT_NE(grid, grids.end()) << facts.file << ' ' << facts.grid;
        const std::string what = fmt::format("{} {}", facts.file, facts.grid);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto i = glm::length_t(axis);
            EXPECT_EQ(grid->at("index_min").at(axis), facts.index_min[i]) << what;
            EXPECT_EQ(grid->at("index_max").at(axis), facts.index_max[i]) << what;
            EXPECT_NEAR(grid->at("world_min_m").at(axis), facts.world_min[i], 6e-5) << what;
            EXPECT_NEAR(grid->at("world_max_m").at(axis), facts.world_max[i], 6e-5) << what;
            EXPECT_NEAR(grid->at("voxel_size_m").at(axis), facts.voxel, 1e-6) << what;
        }
        EXPECT_EQ(grid->at("active_voxels"), facts.active_voxels) << what;
        EXPECT_NEAR(grid->at("max"), facts.max, 1e-5) << what;
        EXPECT_NEAR(grid->at("mean"), facts.mean, 1e-5) << what;
        EXPECT_EQ(grid->at("nan"), 0) << what;
        EXPECT_EQ(grid->at("refusal"), "") << what;
        EXPECT_GT(grid->at("gpu_bytes"), facts.active_voxels) << what;
    }
    const std::string text = must(folder, {"info", sample("fire_plume.vdb")}).out;
    for (const char* said : {"'density'", "'flame'", "'temperature'", "76665", "0.0625"})
        EXPECT_NE(text.find(said), std::string::npos) << text;
}

TEST(Info, GpuBytesAreThoseThatRenderingTakes)
{
    const TempFolder folder;
    const Json info = Json::parse(must(folder, {"info", sample("smoke_plume.vdb"), "--json"}).out);
    const Json& grid = info.at("grids").at(0);
    const Json render = Json::parse(must(folder, {"render", "--aa=1", sample("smoke_plume.vdb"),
                                                  kSmall, "--json", "-o", "x.png"})
                                        .out);
    EXPECT_GT(render.at("gpu_bytes"), grid.at("gpu_bytes"));
    const std::string said = fmt::format("{:.2f} MB", grid.at("gpu_bytes").get<double>() * 1e-6);
    EXPECT_NE(render.at("explain").dump().find(said), std::string::npos) << render.at("explain");
}

TEST(Render, ABareVdbGivesAPictureBesideAndSaysWhatItChose)
{
    const TempFolder folder;
    const Outcome run = must(folder, {"render", "--aa=1", sample("smoke_plume.vdb"), kSmall});
    EXPECT_EQ(list(folder.path()), std::vector<std::string>{"smoke_plume.png"});
    for (const char* said : {"coefficient", "ray march", "all that the volume adds", "samples",
                             "on the GPU", "wrote smoke_plume.png"})
        EXPECT_NE(run.out.find(said), std::string::npos) << said << '\n' << run.out;
    const auto png = OIIO::ImageInput::open((folder.path() / "smoke_plume.png").string());
    ASSERT_NE(png, nullptr);
    EXPECT_EQ(png->spec().width, 96);
    EXPECT_EQ(png->spec().height, 54);
    EXPECT_EQ(png->spec().nchannels, 3);
    std::vector<unsigned char> pixels(96 * 54 * 3);
    ASSERT_TRUE(png->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data()));
    EXPECT_GT(std::set<unsigned char>(pixels.begin(), pixels.end()).size(), 60u) << "a picture";
}

TEST(Render, ExrHasTheNamedChannelsAndTheyCompose)
{
    const TempFolder folder;
    must(folder, {"render", "--aa=1", sample("smoke_plume.vdb"), kSmall, "-o", "x.exr"});
    const Channels exr(folder.path() / "x.exr");
    std::set<std::string> expected{"R", "G", "B", "depth.Z"};
    for (const char* target : {"scattering", "transmittance", "surface", "surface_lit"})
        for (const char* c : {".R", ".G", ".B"})
            expected.insert(std::string(target) + c);
    EXPECT_EQ(exr.names, expected);
    EXPECT_EQ(exr.image.width, 96);
    EXPECT_EQ(exr.image.height, 54);
    for (const std::string& name : exr.names) {
        const Range range = range_of(exr.of(name));
        EXPECT_TRUE(range.finite) << name;
        EXPECT_GE(range.min, 0) << name;
        EXPECT_LT(range.min, range.max) << name << " is one constant";
    }
    EXPECT_LT(range_of(exr.of("transmittance.R")).min, 0.5f) << "smoke hides something";
    EXPECT_EQ(range_of(exr.of("transmittance.R")).max, 1);
    EXPECT_EQ(range_of(exr.of("depth.Z")).max, 1e10f) << "the sky";
    for (const char* c : {"R", "G", "B"}) {
        const auto of = [&](const char* target) { return exr.of(target + std::string(".") + c); };
        const std::vector<float> composite = exr.of(c), lit = of("surface_lit"),
                                 t = of("transmittance"), s = of("scattering");
        for (std::size_t i = 0; i < t.size(); ++i)
            ASSERT_NEAR(composite[i], lit[i] * t[i] + s[i], 1e-5 * (1 + composite[i]));
    }
}

// The same fire in kelvin and in thousands of them, with air around it: it is red hot where it is
// seen alone, and the corner of the picture, before the air, is the sky's.
TEST(Render, ABareFileGlowsByItsTemperature)
{
    const TempFolder folder;
    const auto with_heat = [&](const char* file, double unit, double air) {
        test::VdbGrid density, hot;
        hot.name = "Temperature";
        for (int z = 0; z < 24; ++z)
            for (int y = 0; y < 24; ++y)
                for (int x = 0; x < 24; ++x) {
                    const double r = glm::length(glm::dvec3(x, y, z) - 11.5) / 10;
                    if (r < 1)
                        density.voxels.push_back({{x, y, z}, glm::dvec3(0.05 + r)});
                    hot.voxels.push_back(
                        {{x, y, z}, glm::dvec3(unit * std::max(air, 1800 * (1 - r)))});
                }
        test::write_vdb(folder.path() / file, {density, hot});
    };
    with_heat("kelvin.vdb", 1, 293);
    with_heat("thousands.vdb", 1e-3, 0);
    const auto render = [&](const char* file, const char* picture) {
        return must(folder, with_little_light({"render", "--aa=1", file, kSmall, "-o", picture,
                                               "--save-scene", "s.json"}));
    };
    const Outcome run = render("thousands.vdb", "b.exr");
    EXPECT_NE(run.out.find("taken as thousands of kelvin"), std::string::npos) << run;
    EXPECT_NE(render("kelvin.vdb", "a.exr").out.find("taken as kelvin: "), std::string::npos);
    const Channels a(folder.path() / "a.exr"), b(folder.path() / "b.exr");
    const auto red = a.of("scattering.R"), blue = a.of("scattering.B"),
               other = b.of("scattering.R");
    const auto brightest =
        static_cast<std::size_t>(std::max_element(red.begin(), red.end()) - red.begin());
    EXPECT_GT(red[brightest], 4 * blue[brightest]);
    EXPECT_NEAR(red[brightest] / other[brightest], 1, 0.02);
    EXPECT_EQ(red.front(), 0);

    const std::string scene = read_bytes(folder.path() / "s.json");
    EXPECT_NE(scene.find(R"("temperature_grid": "Temperature")"), std::string::npos) << scene;
    EXPECT_NE(scene.find(R"("temperature_scale": 1,)"), std::string::npos) << scene;
    must(folder, with_little_light({"render", "--aa=1", "s.json", "-o", "c.exr"}));
    EXPECT_EQ(Channels(folder.path() / "c.exr").image.pixels, a.image.pixels);
    EXPECT_NE(
        must(folder, with_little_light({"render", "--aa=1", "s.json", "-o", "c.exr", "--explain"}))
            .out.find("emission: yes, of a temperature"),
        std::string::npos);

    const Outcome info = must(folder, {"info", "kelvin.vdb"});
    EXPECT_NE(info.out.find(" K at most, 1 taken for 1 K"), std::string::npos) << info;
    const Json json = Json::parse(must(folder, {"info", "thousands.vdb", "--json"}).out);
    EXPECT_EQ(json.at("grids").at(1).at("kelvin_per_unit"), 1000);
    EXPECT_TRUE(json.at("grids").at(0).at("kelvin_per_unit").is_null());
}

TEST(Render, SavedSceneRendersTheSameBits)
{
    const TempFolder folder;
    for (const char* name : {"smoke_plume", "fire_plume", "cloud"}) {
        const std::string scene = fmt::format("{}.json", name);
        must(folder, with_little_light({"render", "--aa=1", sample(name + std::string(".vdb")),
                                        kSmall, "-o", "a.exr", "--save-scene", scene}));
        must(folder, with_little_light({"render", "--aa=1", scene, "-o", "b.exr"}));
        const Channels a(folder.path() / "a.exr"), b(folder.path() / "b.exr");
        EXPECT_EQ(a.image.pixels, b.image.pixels) << name;
        // And a saved scene that is saved again says the same.
        must(folder, with_little_light(
                         {"render", "--aa=1", scene, "-o", "b.exr", "--save-scene", "again.json"}));
        EXPECT_EQ(read_bytes(folder.path() / scene), read_bytes(folder.path() / "again.json"));
    }
}

TEST(Render, TheSamplesScenesRender)
{
    const TempFolder folder;
    for (const auto& entry : fs::directory_iterator(FUM_TEST_DATA)) {
        if (entry.path().extension() != ".json")
            continue;
        must(folder, {"render", "--aa=1", entry.path().string(), kSmall, "-o", "x.exr"});
        const Range range = range_of(Channels(folder.path() / "x.exr").of("scattering.G"));
        EXPECT_TRUE(range.finite && range.max > 0) << entry.path();
    }
}

TEST(Render, SameCommandSameBytesAndAnotherSeedAnother)
{
    const TempFolder folder;
    // What the header says of the time of day would differ.
    setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
    Arguments command{"render", sample("fire_plume.vdb"), kSmall, "--aa=2", "-o", "1.exr", "-o",
                      "1.png"};
    must(folder, command);
    const std::string exr = read_bytes(folder.path() / "1.exr");
    const std::string png = read_bytes(folder.path() / "1.png");
    must(folder, command);
    unsetenv("SOURCE_DATE_EPOCH");
    EXPECT_EQ(read_bytes(folder.path() / "1.exr"), exr);
    EXPECT_EQ(read_bytes(folder.path() / "1.png"), png);
    EXPECT_NE(exr.find("2023:11:14 22:13:20"), std::string::npos) << "the time in the header";
    EXPECT_NE(exr.find("fumarole render " + command[1] + " " + kSmall + " --aa=2 -o 1.exr"),
              std::string::npos)
        << "the command line in the header";
    command[5] = "3.exr";
    command.emplace_back("--seed=7");
    must(folder, command);
    const Channels one(folder.path() / "1.exr"), other(folder.path() / "3.exr");
    EXPECT_NE(one.of("scattering.R"), other.of("scattering.R"));
    EXPECT_EQ(one.of("surface.R"), other.of("surface.R"));
    const double mean = range_of(one.of("scattering.R")).mean;
    EXPECT_NEAR(range_of(other.of("scattering.R")).mean, mean, 0.03 * mean);
}

TEST(Render, HalfFloatsAreTheSamePictureInHalfTheBits)
{
    const TempFolder folder;
    must(folder, with_little_light(
                     {"render", "--aa=1", sample("fire_plume.vdb"), kSmall, "-o", "float.exr"}));
    must(folder, with_little_light({"render", "--aa=1", sample("fire_plume.vdb"), kSmall, "-o",
                                    "half.exr", "--half"}));
    const Channels all(folder.path() / "float.exr"), half(folder.path() / "half.exr");
    ASSERT_EQ(half.names, all.names);
    EXPECT_EQ(half.of("depth.Z"), all.of("depth.Z"));
    for (const std::string& name : all.names) {
        const std::vector<float> a = all.of(name), b = half.of(name);
        for (std::size_t i = 0; i < a.size(); ++i)  // 11 bits, and below 2^-14 a fixed step
            ASSERT_LE(std::abs(a[i] - b[i]), std::max(std::abs(a[i]) * 0x1p-11f, 0x1p-25f)) << name;
    }
    EXPECT_NE(half.of("R"), all.of("R"));
    const Outcome png = run_program(folder.path(), {"render", "--aa=1", sample("fire_plume.vdb"),
                                                    kSmall, "-o", "x.png", "--half"});
    EXPECT_EQ(png.code, 2);
    EXPECT_NE(png.err.find("--half: is for an .exr"), std::string::npos) << png;
}

TEST(Render, OneTargetIsThatOfAllTargets)
{
    const TempFolder folder;
    const std::string input = sample("smoke_plume.vdb");
    must(folder, with_little_light({"render", "--aa=1", input, kSmall, "-o", "all.exr"}));
    const Channels all(folder.path() / "all.exr");
    std::vector<Arguments> commands;
    for (const std::string& target : kTargets)
        commands.push_back(with_little_light({"render", "--aa=1", input, kSmall, "--target", target,
                                              "-o", target + ".exr", "-o", target + ".png"}));
    for (const Outcome& run : run_all(folder.path(), commands))
        EXPECT_EQ(run.code, 0) << run;
    for (const std::string& target : kTargets) {
        const Channels one(folder.path() / (target + ".exr"));
        EXPECT_EQ(one.names, (std::set<std::string>{"R", "G", "B"})) << target;
        for (const char* c : {"R", "G", "B"}) {
            const std::string name = target == "composite" ? c
                                     : target == "depth"   ? "depth.Z"
                                                           : target + "." + c;
            EXPECT_EQ(one.of(c), all.of(name)) << name;
        }
        EXPECT_GT(fs::file_size(folder.path() / (target + ".png")), 100u);
    }
}

TEST(Render, AlphaLeavesTheSkyOut)
{
    const TempFolder folder;
    const std::string input = sample("smoke_plume.vdb");
    must(folder, {"render", "--aa=1", input, kSmall, "--alpha", "-o", "x.exr", "-o", "x.png"});
    const Channels exr(folder.path() / "x.exr");
    ASSERT_TRUE(exr.names.contains("A"));
    const std::vector<float> alpha = exr.of("A"), depth = exr.of("depth.Z"), red = exr.of("R"),
                             transmittance = exr.of("transmittance.R"),
                             scattering = exr.of("scattering.R"), lit = exr.of("surface_lit.R");
    int sky = 0;
    for (std::size_t i = 0; i < alpha.size(); ++i) {
        const bool is_sky = depth[i] == 1e10f;
        sky += is_sky ? 1 : 0;
        ASSERT_NEAR(alpha[i], is_sky ? 1 - transmittance[i] : 1, 1e-5);
        ASSERT_NEAR(red[i], scattering[i] + (is_sky ? 0 : transmittance[i] * lit[i]), 1e-5);
    }
    EXPECT_GT(sky, 100);
    const auto png = OIIO::ImageInput::open((folder.path() / "x.png").string());
    ASSERT_NE(png, nullptr);
    EXPECT_EQ(png->spec().nchannels, 4);
}

/// 8-bit values of a PNG as they stand in it.
std::vector<std::uint8_t> png_bytes(const fs::path& file)
{
    OIIO::ImageSpec ask;
    ask.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(file.string(), &ask);
    std::vector<std::uint8_t> bytes(input->spec().image_pixels() *
                                    std::size_t(input->spec().nchannels));
    input->read_image(0, 0, 0, -1, OIIO::TypeDesc::UINT8, bytes.data());
    return bytes;
}

TEST(Render, AlphaOfAPngShowsWhatOnlyGlows)
{
    const TempFolder folder;
    const auto scene = [&](const char* name, const char* medium) {
        folder.write(name, fmt::format(R"({{"resolution": [32, 18],
 "camera": {{"position": [0,-10,0], "look_at": [0,0,0], "vfov_deg": 30}},
 "world_radiance": [0.2,0.3,0.5],
 "media": [{{"type": "box", "min": [-1,-1,-1], "max": [1,1,1], {}}}]}})",
                                       medium));
    };
    scene("glow.json", R"("sigma_s": [0,0,0], "emission": [3,1,0.2])");
    scene("smoke.json", R"("sigma_s": [0.4,0.4,0.4])");
    for (const char* mode : {"raymarch", "froxel"}) {
        const std::string word = fmt::format("--mode={}", mode);
        const Outcome run =
            must(folder, {"render", "--aa=1", "glow.json", word, "--alpha", "--tile=1",
                          "--exposure=-2", "-o", "a.png", "-o", "a.exr"});
        EXPECT_NE(run.out.find("alpha is raised where media glow"), std::string::npos) << run;
        EXPECT_EQ(range_of(Channels(folder.path() / "a.exr").of("A")).max, 0)
            << "an EXR needs none";
        // Over black it is the picture without a sky.
        std::string black = read_bytes(folder.path() / "glow.json");
        black.replace(black.find("[0.2,0.3,0.5]"), 13, "[0,0,0]");
        folder.write("black.json", black);
        must(folder,
             {"render", "--aa=1", "black.json", word, "--tile=1", "--exposure=-2", "-o", "b.png"});
        const auto a = png_bytes(folder.path() / "a.png"), b = png_bytes(folder.path() / "b.png");
        ASSERT_EQ(a.size() / 4, b.size() / 3);
        int most = 0;
        for (std::size_t i = 0; i < a.size() / 4; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_NEAR(a[4 * i + c] * a[4 * i + 3] / 255.0, b[3 * i + c], 1.5);
                most = std::max<int>(most, b[3 * i + c]);
            }
        EXPECT_GT(most, 60);

        // Smoke that does not glow is what it was.
        const Outcome smoke = must(folder, {"render", "--aa=1", "smoke.json", word, "--alpha", "-o",
                                            "s.png", "-o", "s.exr"});
        EXPECT_EQ(smoke.out.find("alpha is raised"), std::string::npos) << smoke;
        const std::vector<float> alpha = Channels(folder.path() / "s.exr").of("A");
        const auto s = png_bytes(folder.path() / "s.png");
        for (std::size_t i = 0; i < alpha.size(); ++i)
            ASSERT_EQ(s[4 * i + 3], std::lround(alpha[i] * 255)) << i;
    }
}

TEST(Render, SizeOfASceneCanBeAsked)
{
    const TempFolder folder;
    for (const char* size : {"1x1", "7x31", "33x2"}) {
        must(folder, with_little_light({"render", "--aa=1", sample("smoke_plume.json"), "--size",
                                        size, "-o", "x.exr"}));
        const Image image = write::read_exr(folder.path() / "x.exr", {"R"});
        EXPECT_EQ(fmt::format("{}x{}", image.width, image.height), size);
        EXPECT_TRUE(range_of(image.pixels).finite);
    }
}

TEST(Render, AaAveragesFrames)
{
    const TempFolder folder;
    const std::string input = sample("fire_plume.vdb");
    must(folder, with_little_light({"render", "--aa=1", input, kSmall, "-o", "1.exr"}));
    must(folder, with_little_light({"render", input, kSmall, "--aa", "16", "-o", "16.exr"}));
    const std::vector<float> one = Channels(folder.path() / "1.exr").of("surface.G");
    const std::vector<float> many = Channels(folder.path() / "16.exr").of("surface.G");
    EXPECT_NE(one, many);
    // A hard edge has values between only where frames are averaged.
    EXPECT_GT(std::set<float>(many.begin(), many.end()).size(),
              std::set<float>(one.begin(), one.end()).size());
    const double mean = range_of(one).mean;
    EXPECT_NEAR(range_of(many).mean, mean, 0.03 * mean);
}

TEST(Render, AStillIsAveragedUntilItsGrainIsGone)
{
    const TempFolder folder;
    const std::string input = sample("cloud.json");
    const auto run = [&](Arguments more) {
        more.insert(more.begin(), {"render", input, kSmall});
        return must(folder, with_little_light(more)).out;
    };
    const Json json = Json::parse(run({"--json", "-o", "a.png", "-o", "a.exr"}));
    const int frames = json.at("aa");
    EXPECT_GE(frames, 8);
    EXPECT_LE(frames, 64);
    EXPECT_TRUE(frames == 64 || json.at("grain") < 1) << json.at("grain");
    const std::string same = fmt::format("--aa={}", frames);
    EXPECT_EQ(Json::parse(run({"--json", same, "-o", "b.exr"})).at("grain"), Json());
    EXPECT_EQ(Channels(folder.path() / "a.exr").image.pixels,
              Channels(folder.path() / "b.exr").image.pixels);
    // A .png alone: steps of 1/255 are coarser than the .exr's, and it says what was done.
    const std::string said = run({"-o", "c.png"});
    const auto at = said.find(" frames averaged; grain left: 0.");
    ASSERT_NE(at, std::string::npos) << said;
    EXPECT_LE(std::stoi(said.substr(said.rfind('\n', at) + 1)), frames);
    // Timed, planned: of as many frames as are asked for.
    for (const char* asked : {"--frames=3", "--budget=500"})
        EXPECT_EQ(Json::parse(run({"--json", asked, "-o", "c.png"})).at("aa"), 1) << asked;
}

TEST(Render, ARegionIsThatPartOfThePicture)
{
    const TempFolder folder;
    const std::string input = sample("smoke_plume_sun.json");
    must(folder, with_little_light({"render", input, kSmall, "--aa=2", "-o", "all.exr"}));
    must(folder, with_little_light({"render", input, kSmall, "--aa=2", "--region=30,10,41,23", "-o",
                                    "part.exr"}));
    const Image part = write::read_exr(folder.path() / "part.exr", {});
    EXPECT_EQ(glm::ivec2(part.width, part.height), glm::ivec2(41, 23));
    EXPECT_EQ(part.whole, glm::ivec2(96, 54));
    EXPECT_EQ(part.origin, glm::ivec2(30, 10));
    must(folder, {"compare", "part.exr", "all.exr",
                  "--max-relmse=1e-8"});  // rounding: Tiles of tests/image
    const Outcome outside =
        run_program(folder.path(), {"render", input, kSmall, "--region=60,10,41,23"});
    EXPECT_EQ(outside.code, 1);
    EXPECT_NE(outside.err.find("lies not within the picture of 96 x 54"), std::string::npos)
        << outside;
}

TEST(Render, JsonHasWhatTheTableHas)
{
    const TempFolder folder;
    const Outcome run =
        must(folder, {"render", sample("smoke_plume.vdb"), kSmall, "--json", "--frames", "3",
                      "--steps", "17", "--target-format", "rgba32f", "-o", "x.exr", "-o", "y.png"});
    const Json json = Json::parse(run.out);
    EXPECT_EQ(json.at("size"), Json({96, 54}));
    EXPECT_EQ(json.at("outputs"), Json({"x.exr", "y.png"}));
    EXPECT_EQ(json.at("frames"), 3);
    EXPECT_EQ(json.at("preset"), "default");
    EXPECT_EQ(json.at("settings").at("steps"), "17");
    EXPECT_EQ(json.at("settings").at("target-format"), "rgba32f");
    for (const SettingInfo& setting : setting_table())
        EXPECT_TRUE(json.at("settings").contains(std::string(setting.name))) << setting.name;
    EXPECT_GT(json.at("volume_ms"), 0);
    EXPECT_GT(json.at("samples"), 1000);
    EXPECT_GT(json.at("gpu_bytes"), 1000000);
    EXPECT_GT(json.at("setup_ms"), 0);
    EXPECT_FALSE(json.at("timing").get<std::string>().empty());
    EXPECT_GE(json.at("passes").size(), 3u);
    std::set<std::string> names;
    for (const Json& pass : json.at("passes")) {
        names.insert(pass.at("name"));
        EXPECT_LE(pass.at("min_ms"), pass.at("median_ms"));
        EXPECT_LE(pass.at("median_ms"), pass.at("max_ms"));
    }
    EXPECT_TRUE(names.contains("ray march"));
    EXPECT_EQ(json.at("volume_ms"), json.at("volume").at("median_ms"));
}

TEST(Render, WhatTheLibrarySaysIsSaidOnceBesideTheOutput)
{
    const TempFolder folder;
    folder.write("fine.json", fog_scene("[8, 6]", R"({"type": "box", "min": [-1, -1, 0],
        "max": [1, 1, 2], "profile": "noise", "noise": {"feature_size": 0.002, "octaves": 1},
        "sigma_s": [1, 1, 1], "sigma_a": [0, 0, 0]})"));
    const Outcome run = run_program(
        folder.path(), {"render", "fine.json", "--json", "--aa=2", "--frames=2", "--bounces=0",
                        "--shadow-volume-size=0", "--shadow-steps=1", "--steps=4", "-o", "x.png"});
    ASSERT_EQ(run.code, 0) << run;
    EXPECT_EQ(Json::parse(run.out).at("settings").at("noise-grid"), "on");
    EXPECT_EQ(run.err, "fumarole: --noise-grid: the noise of medium 0 is worked out at each "
                       "sample, as a grid of it would be too large\n");
}

TEST(Render, SamplesGrowWithTheSteps)
{
    const TempFolder folder;
    const auto samples = [&](const Arguments& more) {
        Arguments command{"render", "--aa=1",      sample("smoke_plume.vdb"), kSmall,
                          "--json", "--bounces=0", "--ambient-volume-size=8", "-o",
                          "x.png"};
        command.insert(command.end(), more.begin(), more.end());
        return Json::parse(must(folder, command).out).at("samples").get<double>();
    };
    const double base = samples({});
    const double half = samples({"--steps=64", "--step-spacing=fixed"});
    EXPECT_NEAR(samples({"--steps=128", "--step-spacing=fixed"}) / half, 2, 0.2);
    const double marched = samples({"--shadow-volume-size=0"});
    EXPECT_GT(marched, 3 * base) << "a volume of shadows spares their steps";
    EXPECT_LT(samples({"--volume-shadows=off"}), 0.3 * marched);
    EXPECT_GT(samples({"--resolution=full"}), 3 * base);
}

TEST(Render, ExplainSaysWhatWasChosen)
{
    const TempFolder folder;
    const Outcome run = must(folder, {"render", "--aa=1", sample("smoke_plume.vdb"), kSmall,
                                      "--explain", "-o", "x.png"});
    for (const char* said : {"what this scene needs:", "media: 1", "extinction:", "phase:",
                             "emission: none", "lights: 1 sun", "grid 'density'"})
        EXPECT_NE(run.out.find(said), std::string::npos) << said << '\n' << run.out;
}

TEST(Render, EveryValueOfEverySettingWorks)
{
    const TempFolder folder;
    // Run i takes value i of every setting at once; then the ends of the numbers.
    constexpr std::size_t kMostValues = 4;
    std::vector<Arguments> commands(kMostValues);
    for (const SettingInfo& setting : setting_table()) {
        if (setting.values.find("..") != std::string_view::npos)
            continue;
        std::vector<std::string> values;
        std::istringstream names{std::string(setting.values)};
        for (std::string name; std::getline(names, name, '|');)
            values.push_back(name);
        ASSERT_LE(values.size(), kMostValues) << setting.name;
        for (std::size_t i = 0; i < kMostValues; ++i)
            commands[i].push_back(fmt::format("--{}={}", setting.name, values[i % values.size()]));
    }
    for (std::size_t i = 0; i < kMostValues; ++i) {
        commands.push_back(commands[i]);
        commands.back().insert(commands.back().end(), {"--mode=froxel", "--frames=3"});
    }
    commands.push_back({"--mode=froxel", "--tile=1", "--slices=1", "--history=0"});
    commands.push_back({"--mode=froxel", "--tile=64", "--slices=1024", "--history=0.999",
                        "--frames=3", "--distribution=1"});
    commands.push_back({"--steps=1", "--shadow-steps=1", "--distribution=0", "--g-clamp=0",
                        "--shadow-map=16", "--depth-threshold=1e-6"});
    commands.push_back({"--steps=1000", "--shadow-steps=64", "--distribution=1", "--g-clamp=0.9999",
                        "--shadow-map=8192", "--depth-threshold=1e6", "--min-extinction=1e-3"});
    commands.push_back({"--preset=eevee2017"});
    commands.push_back({"--preset=default"});
    commands.push_back({"--preset=froxel"});
    commands.push_back({"--preset=eevee2017-froxel"});
    for (std::size_t i = 0; i < commands.size(); ++i) {
        const Arguments common{"render",       "--aa=1", sample("fire_plume.vdb"),
                               "--size=48x27", "-o",     fmt::format("{}.exr", i)};
        commands[i].insert(commands[i].begin(), common.begin(), common.end());
    }
    const std::vector<Outcome> runs = run_all(folder.path(), commands);
    ASSERT_EQ(runs.back().code, 0) << runs.back();
    const double plain = range_of(Channels(folder.path() / commands.back()[5]).of("G")).mean;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        ASSERT_EQ(runs[i].code, 0) << joined(commands[i]) << '\n' << runs[i];
        const Range range = range_of(Channels(folder.path() / commands[i][5]).of("G"));
        EXPECT_TRUE(range.finite) << joined(commands[i]);
        // The same scene: no setting makes it night.
        EXPECT_GT(range.mean, 0.3 * plain) << joined(commands[i]);
        EXPECT_LT(range.mean, 3 * plain) << joined(commands[i]);
    }
}

TEST(Render, OtherBackendsDrawTheSameOrSayWhyNot)
{
    const TempFolder folder;
    const std::string input = sample("smoke_plume.vdb");
    must(folder, with_little_light(
                     {"render", "--aa=1", input, kSmall, "--backend=osmesa", "-o", "osmesa.exr"}));
    const Outcome egl = run_program(
        folder.path(),
        with_little_light({"render", "--aa=1", input, kSmall, "--backend=egl", "-o", "egl.exr"}));
    if (egl.code != 0) {
        EXPECT_EQ(egl.code, 1) << egl;
        EXPECT_NE(egl.err.find("EGL"), std::string::npos) << egl;
        GTEST_SKIP() << "no EGL here: " << egl.err;
    }
    const std::vector<float> a = Channels(folder.path() / "osmesa.exr").of("G");
    const std::vector<float> b = Channels(folder.path() / "egl.exr").of("G");
    double difference = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        difference += std::abs(a[i] - b[i]) / double(a.size());
    EXPECT_LT(difference, 2e-3 * range_of(a).mean);
}

/// Our cache in a folder of the test, Mesa's where it is, for all that is run while this lives.
class CacheIn {
public:
    explicit CacheIn(const fs::path& folder)
    {
        const char* cache = std::getenv("XDG_CACHE_HOME");
        const char* home = std::getenv("HOME");
        had_ = cache != nullptr;
        old_ = had_ ? cache : "";
        const fs::path mesa = had_ ? fs::path(old_) : fs::path(home ? home : ".") / ".cache";
        setenv("MESA_SHADER_CACHE_DIR", mesa.c_str(), 0);
        setenv("XDG_CACHE_HOME", folder.c_str(), 1);
    }
    ~CacheIn()
    {
        if (had_)
            setenv("XDG_CACHE_HOME", old_.c_str(), 1);
        else
            unsetenv("XDG_CACHE_HOME");
    }
    CacheIn(const CacheIn&) = delete;
    CacheIn& operator=(const CacheIn&) = delete;

private:
    bool had_ = false;
    std::string old_;
};

TEST(Render, KeepsCompiledProgramsAndDoesWithoutThem)
{
    const TempFolder folder;
    const fs::path cache = folder.path() / "cache";
    const CacheIn of_test(cache);
    const auto programs = [&](const Arguments& more) {
        Arguments command = with_little_light(
            {"render", "--aa=1", sample("smoke_plume.vdb"), "--size=16x9", "--explain"});
        command.insert(command.end(), more.begin(), more.end());
        const std::string text = must(folder, command).out;
        const std::size_t at = text.find("compiled programs: ");
        return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
    };
    EXPECT_EQ(programs({"--no-program-cache"}), "compiled programs: not kept: --no-program-cache");
    EXPECT_FALSE(fs::exists(cache));
    const std::string first = programs({});
    int kept = 0;
    if (std::sscanf(first.c_str(), "compiled programs: 0 of an earlier run, %d kept", &kept) != 1 ||
        kept == 0)
        GTEST_SKIP() << "this driver gives no program away: " << first;
    EXPECT_EQ(kept, static_cast<int>(list(cache / "fumarole").size()));
    EXPECT_NE(programs({}).find(fmt::format("{} of an earlier run, 0 kept", kept)),
              std::string::npos);
    // What was cut off is written anew.
    for (const std::string& name : list(cache / "fumarole"))
        fs::resize_file(cache / "fumarole" / name, 100);
    EXPECT_NE(programs({}).find(fmt::format(", {} kept", kept)), std::string::npos);
}

TEST(Render, TakesTheDeviceThatInfoNamesAndSaysWhy)
{
    const TempFolder folder;
    const std::string input = sample("smoke_plume.vdb");
    const Json info = Json::parse(must(folder, {"info", "--devices", "--json"}).out);
    const Json& automatic = info.at("automatic");
    // All that EGL lists, and OSMesa.
    ASSERT_GE(info.at("devices").size(), 1u);
    EXPECT_EQ(info.at("devices").back().at("backend"), "osmesa");
    const Json still = Json::parse(
        must(folder,
             with_little_light({"render", "--aa=1", input, kSmall, "-o", "a.png", "--json"}))
            .out);
    EXPECT_EQ(still.at("backend"), automatic.at("backend"));
    EXPECT_EQ(still.at("device_reason"), automatic.at("reason"));
    const std::string table =
        must(folder, with_little_light({"render", "--aa=1", input, kSmall, "-o", "a.png"})).out;
    EXPECT_NE(table.find(" by " + automatic.at("reason").get<std::string>()), std::string::npos)
        << table;

    const Outcome missing = run_program(folder.path(), {"render", input, "--device", "99"});
    EXPECT_EQ(missing.code, 2) << missing;
    EXPECT_EQ(missing.error_lines(), 1) << missing;
    const Json& first = info.at("devices").front();
    const std::string named =
        first.at("device").is_null() ? "no device" : first.at("name").get<std::string>();
    EXPECT_NE(missing.err.find(named), std::string::npos) << missing;
}

}  // namespace
}  // namespace fumarole::test
