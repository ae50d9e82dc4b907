// `fumarole compare` as a user runs it: exit codes, what is printed, the picture.

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <string>
#include <sys/wait.h>
#include <vector>

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/temp_folder.h"
#include <fumarole/write/image_writer.h>

namespace fumarole::test {
namespace {

constexpr int kWidth = 48;
constexpr int kHeight = 27;

const std::vector<std::string> kRgb = {"R", "G", "B"};
const std::vector<std::string> kAll = {"R",
                                       "G",
                                       "B",
                                       "scattering.R",
                                       "scattering.G",
                                       "scattering.B",
                                       "transmittance.R",
                                       "transmittance.G",
                                       "transmittance.B",
                                       "depth.Z"};

/// A gradient, each channel in a shade of its own, times `gain`.
Image gradient(const std::vector<std::string>& channels, float gain = 1, int width = kWidth)
{
    Image image;
    image.width = width;
    image.height = kHeight;
    image.channels = channels;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < width; ++x) {
            for (std::size_t c = 0; c < channels.size(); ++c) {
                image.pixels.push_back(
                    gain * (0.1f + 0.01f * static_cast<float>(x) + 0.02f * static_cast<float>(c)));
            }
        }
    }
    return image;
}

class Compare : public testing::Test {
protected:
    struct Result {
        int exit_code;
        std::string out, err;
    };

    std::string write(const std::string& name, const Image& image) const
    {
        const std::filesystem::path file = folder_.path() / name;
        write::write_exr(image, file);
        return file.string();
    }

    /// write_exr refuses what is not finite, so another hand makes such a file.
    std::string write_raw(const std::string& name, const Image& image) const
    {
        const std::filesystem::path file = folder_.path() / name;
        OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channels.size()),
                             OIIO::TypeDesc::FLOAT);
        spec.channelnames = image.channels;
        const auto output = OIIO::ImageOutput::create(file.string());
        EXPECT_TRUE(output->open(file.string(), spec) &&
                    output->write_image(OIIO::TypeDesc::FLOAT, image.pixels.data()) &&
                    output->close());
        return file.string();
    }

    std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

    Result run(const std::vector<std::string>& arguments) const
    {
        std::string command = FUM_PROGRAM " compare";
        for (const std::string& argument : arguments) {
            command += " '" + argument + "'";
        }
        command += " >'" + path("out") + "' 2>'" + path("err") + "'";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(path("out")),
                read_bytes(path("err"))};
    }

    nlohmann::json run_json(std::vector<std::string> arguments, int exit_code = 0) const
    {
        arguments.emplace_back("--json");
        const Result result = run(arguments);
        EXPECT_EQ(result.exit_code, exit_code) << result.err;
        return nlohmann::json::parse(result.out);
    }

private:
    TempFolder folder_;
};

bool contains(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST_F(Compare, APictureIsNoDistanceFromItself)
{
    const std::string file = write("a.exr", gradient(kAll));
    const auto json = run_json({file, file, "--max-relmse", "0"});
    EXPECT_TRUE(json["ok"]);
    ASSERT_EQ(json["targets"].size(), 3u);  // depth is no picture
    for (const char* target : {"composite", "scattering", "transmittance"}) {
        for (const char* metric : {"relmse", "smape", "bias", "p999", "flip"}) {
            EXPECT_EQ(json["targets"][target][metric], 0) << target << ' ' << metric;
        }
        EXPECT_EQ(json["targets"][target]["finite"], true);
    }
}

TEST_F(Compare, MeasuresTheFirstAgainstTheSecond)
{
    const std::string bright = write("bright.exr", gradient(kRgb, 1.5f));
    const std::string plain = write("plain.exr", gradient(kRgb));
    const auto json = run_json({bright, plain});
    EXPECT_NEAR(json["targets"]["composite"]["bias"], 0.5, 1e-5);
    EXPECT_NEAR(run_json({plain, bright})["targets"]["composite"]["bias"], -1.0 / 3, 1e-5);
    EXPECT_NEAR(json["targets"]["composite"]["smape"], 0.4, 1e-5);
    EXPECT_GT(json["targets"]["composite"]["flip"], 0.05);
    EXPECT_EQ(json["size"], (std::vector<int>{kWidth, kHeight}));

    const Result text = run({bright, plain});
    EXPECT_EQ(text.exit_code, 0);
    EXPECT_TRUE(contains(text.out, "relMSE") && contains(text.out, "FLIP") &&
                contains(text.out, "composite") && contains(text.out, "+5.000e-01"))
        << text.out;
    EXPECT_EQ(text.err, "");
}

TEST_F(Compare, ExitsWithOneAboveTheBound)
{
    const std::string a = write("a.exr", gradient(kRgb, 1.1f));
    const std::string b = write("b.exr", gradient(kRgb));
    EXPECT_EQ(run({a, b, "--max-relmse", "0.1"}).exit_code, 0);
    const Result over = run({a, b, "--max-relmse", "0.001"});
    EXPECT_EQ(over.exit_code, 1);
    EXPECT_TRUE(contains(over.err, "composite: relMSE") && contains(over.err, "0.001")) << over.err;
    EXPECT_TRUE(contains(over.out, "composite")) << "the table is printed all the same";
    EXPECT_FALSE(run_json({a, b, "--max-relmse", "0.001"}, 1)["ok"]);
}

TEST_F(Compare, BoundIsForEveryTargetUnlessOneIsChosen)
{
    Image picture = gradient(kAll);
    for (std::size_t i = 3; i < picture.pixels.size(); i += kAll.size()) {
        picture.pixels[i] *= 2;  // scattering.R
    }
    const std::string a = write("a.exr", picture);
    const std::string b = write("b.exr", gradient(kAll));
    EXPECT_EQ(run({a, b, "--max-relmse", "1e-6"}).exit_code, 1);
    EXPECT_EQ(run({a, b, "--max-relmse", "1e-6", "--target", "scattering"}).exit_code, 1);
    const auto json = run_json({a, b, "--max-relmse", "1e-6", "--target", "transmittance"});
    EXPECT_EQ(json["targets"].size(), 1u);
}

TEST_F(Compare, TakesTheWordForAFileOfOneTarget)
{
    Image all = gradient(kAll);
    const std::string full = write("full.exr", all);
    Image lone = gradient(kRgb);
    for (std::size_t pixel = 0; pixel < lone.pixels.size() / 3; ++pixel) {
        for (std::size_t c = 0; c < 3; ++c) {
            lone.pixels[3 * pixel + c] = all.pixels[kAll.size() * pixel + 6 + c];
        }
    }
    const std::string transmittance = write("transmittance.exr", lone);
    for (const auto& [a, b] : {std::pair(full, transmittance), std::pair(transmittance, full)}) {
        const auto json = run_json({a, b, "--target", "transmittance"});
        EXPECT_EQ(json["targets"]["transmittance"]["relmse"], 0);
    }
    EXPECT_GT(run_json({full, transmittance})["targets"]["composite"]["relmse"], 0);
}

TEST_F(Compare, DrawsTheDifferenceWithItsScale)
{
    const std::string a = write("a.exr", gradient(kAll, 1.1f));
    const std::string b = write("b.exr", gradient(kAll));
    for (const std::vector<std::string>& more : {std::vector<std::string>{},
                                                 {"--target", "scattering"},
                                                 {"--difference", "sign"},
                                                 {"--scale", "0.5"}}) {
        std::vector<std::string> arguments = {a, b, "-o", path("difference.png")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Result result = run(arguments);
        EXPECT_EQ(result.exit_code, 0) << result.err;
        EXPECT_TRUE(contains(result.out, "wrote"));
        const auto png = OIIO::ImageInput::open(path("difference.png"));
        ASSERT_NE(png, nullptr);
        EXPECT_GE(png->spec().width, kWidth);
        EXPECT_GT(png->spec().height, kHeight);
        png->close();
        std::filesystem::remove(path("difference.png"));
    }
}

TEST_F(Compare, NotFiniteIsAFailureThatIsPlacedAndDrawn)
{
    Image broken = gradient(kRgb);
    broken.pixels[(5 * kWidth + 7) * 3 + 1] = std::numeric_limits<float>::quiet_NaN();
    const std::string a = write_raw("broken.exr", broken);
    const std::string b = write("b.exr", gradient(kRgb));
    const Result result = run({a, b, "-o", path("difference.png")});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_TRUE(contains(result.err, "broken.exr: composite: G of pixel 7, 5 is nan"))
        << result.err;
    EXPECT_TRUE(std::filesystem::exists(path("difference.png")));
    const auto json = run_json({a, b}, 1);
    EXPECT_EQ(json["targets"]["composite"]["finite"], false);
    EXPECT_TRUE(json["targets"]["composite"]["relmse"].is_null());

    const Result reference = run({b, a});
    EXPECT_EQ(reference.exit_code, 1);
    EXPECT_TRUE(contains(reference.err, "broken.exr") && contains(reference.err, "reference"))
        << reference.err;
}

TEST_F(Compare, SaysWhyTwoFilesCannotBeCompared)
{
    const std::string a = write("a.exr", gradient(kAll));
    const std::string wide = write("wide.exr", gradient(kAll, 1, kWidth + 1));
    const std::string depth = write("depth.exr", gradient({"depth.Z"}));

    const Result sizes = run({a, wide});
    EXPECT_EQ(sizes.exit_code, 1);
    EXPECT_TRUE(contains(sizes.err, "48 x 27") && contains(sizes.err, "49 x 27")) << sizes.err;

    const Result channels = run({a, depth});
    EXPECT_EQ(channels.exit_code, 1);
    EXPECT_TRUE(contains(channels.err, "no target in common")) << channels.err;

    const Result target = run({a, a, "--target", "emission"});
    EXPECT_EQ(target.exit_code, 1);
    EXPECT_TRUE(contains(target.err, "no target 'emission' (has: composite, scattering"))
        << target.err;

    const Result missing = run({a, path("missing.exr")});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_TRUE(contains(missing.err, "missing.exr")) << missing.err;
}

TEST_F(Compare, WrongUseExitsWithTwo)
{
    const std::string a = write("a.exr", gradient(kRgb));
    EXPECT_EQ(run({a}).exit_code, 2);
    EXPECT_EQ(run({a, a, a}).exit_code, 2);
    EXPECT_EQ(run({a, a, "-o", path("x.exr")}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--max-relmse", "-1"}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--max-relmse", "nan"}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--scale", "0"}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--exposure", "bright"}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--difference", "both"}).exit_code, 2);
    EXPECT_EQ(run({a, a, "--exposure", "-2.5"}).exit_code, 0);
}

// -- a scene and its modes -----------------------------------------------------------------------

std::string smoke()
{
    return std::string(FUM_TEST_DATA) + "/smoke_plume_sun.json";
}

TEST_F(Compare, AScenesModesAreHeldAgainstTheReferenceAndEachOther)
{
    const std::vector<std::string> small{
        smoke(),       "--size", "48x27", "--frames",       "3", "--bounces", "0",
        "--tolerance", "0.05",   "-o",    path("modes.png")};
    const Result text = run(small);
    ASSERT_EQ(text.exit_code, 0) << text.err;
    EXPECT_EQ(text.err, "") << "no progress where there is no terminal";
    for (const char* word : {"raymarch", "froxel", "reference", "composite", "scattering",
                             "transmittance", "relMSE", "FLIP", "kept: nothing moved", "wrote"})
        EXPECT_TRUE(contains(text.out, word)) << word << '\n' << text.out;
    const auto png = OIIO::ImageInput::open(path("modes.png"));
    ASSERT_NE(png, nullptr);
    EXPECT_GE(png->spec().width, 3 * 48);
    EXPECT_GT(png->spec().height, 2 * 27);
    png->close();

    const auto json = run_json(small);
    ASSERT_EQ(json["modes"].size(), 2u);
    EXPECT_EQ(json["modes"][1]["name"], "froxel");
    EXPECT_GT(json["modes"][0]["volume_ms"], 0);
    ASSERT_EQ(json["distances"].size(), 9u) << "two from the reference, one from the other";
    for (const auto& d : json["distances"]) {
        EXPECT_TRUE(d["finite"]) << d;
        EXPECT_GT(d["relmse"], 0) << d;
    }
    const auto& march = json["distances"][2];
    EXPECT_EQ(march["mode"], "raymarch");
    EXPECT_EQ(march["against"], "reference");
    EXPECT_EQ(march["target"], "transmittance");
    EXPECT_LT(march["relmse"], 0.05);
}

// The smoke's light scatters on in the truth, and a mode that does not follow it lacks that beside
// what it lacks of light that scatters once.
TEST_F(Compare, AScenesTruthHasAllBouncesUnlessAskedOtherwise)
{
    const auto bias = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{smoke(), "--size",  "24x14",    "--frames",
                                       "1",     "--modes", "eevee2017"};
        words.insert(words.end(), more.begin(), more.end());
        const auto json = run_json(words);
        EXPECT_EQ(json["tolerance"], more.empty() ? 0.2 : 0.01);
        return json["distances"][1]["bias"].get<double>();
    };
    EXPECT_LT(bias({}), bias({"--bounces", "0"}) - 0.1);
}

TEST_F(Compare, PresetsAreModesToo)
{
    const auto json = run_json({smoke(), "--modes", "eevee2017,default,raymarch", "--size", "32x18",
                                "--frames", "1", "--no-reference"});
    ASSERT_EQ(json["modes"].size(), 3u);
    EXPECT_TRUE(json["tolerance"].is_null());
    ASSERT_EQ(json["distances"].size(), 9u);
    for (const auto& d : json["distances"]) {
        const bool same = d["mode"] == "raymarch" && d["against"] == "default";
        EXPECT_EQ(d["relmse"] == 0, same) << d;
    }
}

TEST_F(Compare, AScenesMisuseExitsWithTwo)
{
    const std::string a = write("a.exr", gradient(kRgb));
    const std::vector<std::pair<std::vector<std::string>, std::string>> misuses{
        {{a}, "B.exr"},
        {{a, a, "--modes", "froxel"}, "--modes"},
        {{a, a, "--size", "8x8"}, "--size"},
        {{smoke(), a}, "B.exr"},
        {{smoke(), "--target", "scattering"}, "--target"},
        {{smoke(), "--modes", "froxels"}, "eevee2017-froxel"},
        {{smoke(), "--modes", "froxel,froxel"}, "twice"},
        {{smoke(), "--modes", "reference"}, "at least"},
        {{smoke(), "--modes", ""}, "no mode"},
        {{smoke(), "--modes", "froxel,reference", "--no-reference"}, "--no-reference"},
        {{smoke(), "--size", "8"}, "--size"},
        {{smoke(), "-o", path("x.exr")}, ".png"},
    };
    for (const auto& [arguments, word] : misuses) {
        const Result result = run(arguments);
        EXPECT_EQ(result.exit_code, 2) << word << '\n' << result.err;
        EXPECT_TRUE(contains(result.err, word)) << word << '\n' << result.err;
    }
    const Result missing = run({path("none.json")});
    EXPECT_EQ(missing.exit_code, 1);
    EXPECT_TRUE(contains(missing.err, "none.json")) << missing.err;
}

}  // namespace
}  // namespace fumarole::test
