// The shaders as text: every variant that a scene and its settings can ask for passes
// glslangValidator, which minds the specification where drivers are lenient; messages name our
// files and lines.

#include <algorithm>
#include <array>
#include <cstdio>
#include <fmt/format.h>
#include <set>

#include "gl/program.h"
#include "medium/media_set.h"
#include "support/gl_test.h"
#include "support/kernel.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>

namespace fumarole::test {
namespace {

using gl::Defines;
using medium::Layout;
using medium::Storage;

std::shared_ptr<VoxelGrid> small_grid(int channels)
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "grid";
    grid->channels = channels;
    grid->bricks = {{0, 0, 0}};
    grid->values.assign(512 * std::size_t(channels), 1.0f);
    grid->index_min = {0, 0, 0};
    grid->index_max = {7, 7, 7};
    grid->active_voxels = 512;
    grid->max_value = 1;
    return grid;
}

GridMedium grid_medium(int density, int emission, int color, float g)
{
    GridMedium medium;
    medium.density = small_grid(density);
    if (emission > 0) {
        medium.emission = small_grid(emission);
        medium.emission_per_unit = {1, 2, 3};
    }
    if (color > 0)
        medium.color = small_grid(3);
    medium.g = g;
    return medium;
}

BoxMedium box_medium(const Profile& profile, glm::vec3 sigma_s, float g, glm::vec3 emission)
{
    BoxMedium medium;
    medium.profile = profile;
    medium.sigma_s = sigma_s;
    medium.g = g;
    medium.emission = emission;
    return medium;
}

struct NamedMedia {
    std::string name;
    std::vector<Medium> media;
    Layout layout = Layout::automatic;
};

/// Each kind alone, grey and coloured, glowing and not, and mixtures.
std::vector<NamedMedia> all_media()
{
    const glm::vec3 grey(1), colored(1, 2, 3), none(0);
    const NoiseProfile drifting{.drift = {1, 0, 0}};  // so it is not read from a grid
    std::vector<NamedMedia> all;
    for (const Layout layout : {Layout::dense, Layout::bricks}) {
        const char* kind = layout == Layout::dense ? "dense" : "bricks";
        for (const int density : {1, 3})
            for (const int emission : {0, 1, 3})
                for (const int color : {0, 3})
                    all.push_back(
                        {fmt::format("{}{}_emission{}_color{}", kind, density, emission, color),
                         {grid_medium(density, emission, color, 0.3f)},
                         layout});
        all.push_back(
            {fmt::format("{}_and_all_boxes", kind),
             {grid_medium(1, 1, 3, 0.3f), grid_medium(3, 0, 0, -0.5f),
              box_medium(HomogeneousProfile{}, colored, 0.1f, colored),
              box_medium(ExpHeightProfile{}, grey, 0.2f, none),
              box_medium(NoiseProfile{}, grey, 0, grey), box_medium(drifting, grey, 0, grey)},
             layout});
        GridMedium glow = grid_medium(1, 1, 0, 0);
        glow.sigma_s_per_density = none;
        all.push_back({fmt::format("{}_only_glows", kind), {glow}, layout});
    }
    for (const auto& [name, profile] : {std::pair{"homogeneous", Profile{HomogeneousProfile{}}},
                                        std::pair{"exp_height", Profile{ExpHeightProfile{}}},
                                        std::pair{"noise", Profile{NoiseProfile{}}},
                                        std::pair{"drifting_noise", Profile{drifting}}})
        for (const glm::vec3& sigma_s : {grey, colored})
            for (const glm::vec3& emission : {none, colored})
                for (const float g : {0.0f, 0.5f})
                    all.push_back(
                        {fmt::format("{}_{}_{}_g{}", name, sigma_s == grey ? "grey" : "colored",
                                     emission == none ? "dark" : "glows", g),
                         {box_medium(profile, sigma_s, g, emission)}});
    return all;
}

Defines operator+(Defines a, const Defines& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Defines flags(unsigned set, std::initializer_list<const char*> names)
{
    Defines defines;
    unsigned bit = 1;
    for (const char* name : names) {
        if ((set & bit) != 0)
            defines.emplace_back(name, "");
        bit <<= 1;
    }
    return defines;
}

/// Counts of lights, with and without surfaces that throw shadows.
const std::array kLights{
    Defines{{"SUN_COUNT", "0"}, {"POINT_COUNT", "0"}, {"SPOT_COUNT", "0"}},
    Defines{{"SUN_COUNT", "1"}, {"POINT_COUNT", "0"}, {"SPOT_COUNT", "0"}},
    Defines{{"SUN_COUNT", "0"}, {"POINT_COUNT", "1"}, {"SPOT_COUNT", "0"}, {"SURFACE_SHADOWS", ""}},
    Defines{
        {"SUN_COUNT", "2"}, {"POINT_COUNT", "3"}, {"SPOT_COUNT", "4"}, {"SURFACE_SHADOWS", ""}}};

/// Writes variants into a folder and has all of them validated in one call.
class Variants {
public:
    void add(const std::string& file, const Defines& defines)
    {
        files_.insert(file);
        const std::string text = gl::expand_shader(file, defines).text;
        if (!texts_.insert(text).second)
            return;
        const std::string extension = file.substr(file.rfind('.'));
        folder_.write(fmt::format("{:04}{}", texts_.size(), extension), text);
    }
    [[nodiscard]] std::size_t count() const { return texts_.size(); }
    [[nodiscard]] const std::set<std::string>& files() const { return files_; }

    /// @returns what the validator says and its exit code.
    [[nodiscard]] std::pair<std::string, int> validate() const
    {
        const std::string command = fmt::format(
            "cd '{}' && glslangValidator *.frag *.vert *.comp 2>&1 | grep -v '^[0-9]*[.]'; "
            "exit ${{PIPESTATUS[0]}}",
            folder_.path().string());
        FILE* pipe = popen(fmt::format("bash -c \"{}\"", escaped(command)).c_str(), "r");
        std::string output;
        std::array<char, 4096> part{};
        while (std::fgets(part.data(), part.size(), pipe) != nullptr)
            output += part.data();
        return {output, pclose(pipe)};
    }

private:
    static std::string escaped(const std::string& text)
    {
        std::string out;
        for (const char c : text)
            out += c == '$' ? std::string("\\$") : std::string(1, c);
        return out;
    }
    TempFolder folder_;
    std::set<std::string> texts_, files_;
};

class ShaderVariants : public GlTest {};

TEST_F(ShaderVariants, AllPassGlslangValidator)
{
    if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "glslangValidator is not in PATH (Debian: glslang-tools)";
    Variants variants;
    variants.add("pass/fullscreen.vert", {});
    variants.add("pass/accumulate.frag", {});
    for (const Defines& compared : {Defines{}, Defines{{"SPLIT", ""}}, Defines{{"DIFFERENCE", ""}}})
        variants.add("pass/display.frag", compared);
    variants.add("pass/tiles.vert", {{"TILE_PIXELS", "8"}});
    variants.add("pass/surface.vert", {});
    variants.add("study/texel_rate.frag", {{"FETCHES", "64"}, {"TEXEL_PIXELS", "512"}});
    variants.add("light/shadow_map.frag", {});
    variants.add("pass/sky.frag", {});
    variants.add("pass/sky.frag", {{"ENVIRONMENT", ""}});
    for (const char* scale : {"1", "2", "4"}) {
        const Defines at_scale{{"LAYER_SCALE", scale}};
        for (unsigned set = 0; set < 2; ++set)
            variants.add("pass/layer_depth.frag", at_scale + flags(set, {"CHECKERBOARD"}));
        variants.add("pass/inspect_rays.frag", at_scale);
        for (const unsigned history : {0u, 3u})
            for (unsigned set = 0; set < 2; ++set)
                variants.add("pass/march_history.frag",
                             at_scale + flags(set, {"MONOCHROME"}) +
                                 flags(history, {"HISTORY", "HISTORY_STILL"}));
        for (const char* taps : {"1", "2", "4"})
            for (unsigned set = 0; set < 2; ++set)
                for (const Defines& targets : {Defines{}, Defines{{"BOTH", ""}}})
                    variants.add("resolve/upsample.frag", at_scale + targets +
                                                              Defines{{"UPSAMPLE_TAPS", taps}} +
                                                              flags(set, {"BOX_2017"}));
    }
    for (const char* file : {"box.vert", "box.frag", "color.frag", "depth.frag", "dim.frag",
                             "extent.frag", "froxels.frag"})
        variants.add(fmt::format("pass/inspect_{}", file), {});
    variants.add("pass/inspect_froxels.frag", {{"SAMPLES", ""}});
    for (const Defines& lights : kLights)
        for (unsigned set = 0; set < 4; ++set)
            variants.add("pass/surface.frag", lights + flags(set, {"ENVIRONMENT", "TWO_SIDED"}) +
                                                  flags(set, {"WORLD_IRRADIANCE"}));

    const auto volumes = [&](const Defines& media, unsigned set) {
        const Defines stored = flags(set, {"VOLUME_RGB"});
        variants.add("light/extinction.comp", media + kLights[0] + stored);
        variants.add("light/depth.comp", media + kLights[0] + stored);
        for (const char* bands : {"1", "3", "4"}) {
            const Defines of_bands = media + kLights[0] + stored + Defines{{"BANDS", bands}};
            variants.add("light/world.comp",
                         of_bands + flags(set >> 1, {"WORLD_SHADOWS", "MARCHED", "CLEAR"}));
            variants.add("light/world_view.comp", of_bands);
        }
    };

    for (unsigned set = 0; set < 4; ++set)
        variants.add("pass/integrate.comp", flags(set, {"EXTINCTION_IN_ALPHA", "WRONSKI"}));
    for (unsigned set = 0; set < 8; ++set)
        variants.add("resolve/froxels.frag", flags(set, {"EXTINCTION_IN_ALPHA", "TRICUBIC",
                                                         set >= 4 ? "TRANSMITTANCE" : "BOTH"}));

    // The froxels that sample: as the march below, with what is theirs alone.
    const auto froxels = [&](const Defines& media, const Defines& lights, unsigned set) {
        const Defines sampling =
            flags(set, {"VOLUME_SHADOWS", "WORLD_LIGHT", "EXTINCTION_IN_ALPHA", "CAMERA_RANGE",
                        "SHADOW_TO_LIGHT", "LEAST_EXTINCTION"}) +
            flags(set >> 3, {"WORLD_VOLUME", "DEPTH_VOLUME"});
        variants.add("pass/v_buffer.comp", media + lights + sampling);
        variants.add("pass/scatter.comp", media + lights + sampling +
                                              flags(set >> 6, {"GRID_SHADOWS", "HISTORY",
                                                               "HISTORY_STILL", "COUNT_SAMPLES"}));
    };
    constexpr unsigned kFroxelSets = 1u << 10;

    // The march: every kind of medium with a few sets of flags, and every set with a few media.
    const auto march = [&](const Defines& media, const Defines& lights, unsigned set) {
        variants.add("pass/ray_march.frag",
                     media + lights +
                         flags(set, {"BLUE_NOISE", "VOLUME_SHADOWS", "WORLD_LIGHT", "CAMERA_RANGE",
                                     "SHADOW_TO_LIGHT", "LEAST_EXTINCTION", "MONOCHROME",
                                     "COUNT_SAMPLES", "DEPTH_VOLUME", "WORLD_VOLUME"}) +
                         flags(set ^ set >> 3, {"EXACT_FALLOFF", "MEDIA_DEPTH"}) +
                         Defines{{"LAYER_SCALE", "2"}});
        variants.add("pass/march_history.frag",
                     media + lights + flags(set, {"WORLD_LIGHT", "MONOCHROME", "VOLUME_SHADOWS"}) +
                         Defines{{"LAYER_SCALE", "2"}, {"HISTORY", ""}});
    };
    constexpr unsigned kDefault = 0b1100000111, kSets = 1u << 10;
    medium::MediaSet media(gl());
    const std::vector<NamedMedia> kinds = all_media();
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        Scene scene;
        scene.media = kinds[i].media;
        Settings settings;
        settings.layout = kinds[i].layout;
        media.set(scene, settings);
        const Defines of_media = media.defines();
        variants.add("pass/inspect_density.frag", of_media);
        for (const unsigned set : {kDefault, kDefault | 0b01000000u, 0b00111111u, 0u, 0b10000111u})
            march(of_media, kLights[(i + set) % kLights.size()], set);
        if (kinds[i].name == "bricks_and_all_boxes" || kinds[i].name == "homogeneous_grey_dark_g0")
            for (unsigned set = 0; set < kSets; set += 3)  // odd: every bit comes both ways
                march(of_media, kLights[set % kLights.size()], set);
        for (const unsigned set : {0b0000000111u, 0b0010000011u, 0b0111111011u})
            froxels(of_media, kLights[(i + set) % kLights.size()], set);
        if (kinds[i].name == "bricks_and_all_boxes" || kinds[i].name == "homogeneous_grey_dark_g0")
            for (unsigned set = 0; set < kFroxelSets; set += 5)  // odd: every bit comes both ways
                froxels(of_media, kLights[set % kLights.size()], set);
        for (unsigned set = 0; set < 4; ++set)
            variants.add("pass/surface.frag",
                         kLights[1 + (i + set) % 3] + of_media + Defines{{"THROUGH_MEDIA", ""}} +
                             flags(set, {"SHADOW_TO_LIGHT", "ENVIRONMENT"}) +
                             flags(set >> 1, {"DEPTH_VOLUME"}) + flags(set, {"WORLD_IRRADIANCE"}));
        // Three numbers are stored where extinction has a colour.
        const bool colored = media.traits().colored_extinction;
        for (unsigned set = 0; set < 16; ++set)
            if (colored || (set & 1) == 0)
                volumes(of_media, set);
    }

    EXPECT_GT(variants.count(), 500u);
    for (const auto& [file, text] : gl::shader_files()) {
        if (file.ends_with(".frag") || file.ends_with(".vert") || file.ends_with(".comp")) {
            EXPECT_TRUE(variants.files().contains(file)) << file << " has no variant in this test";
        }
    }
    const auto [output, code] = variants.validate();
    EXPECT_EQ(code, 0);
    EXPECT_EQ(output.substr(0, 4000), "");
}

TEST(ShaderText, IncludesEachFileOnceAndKnowsItsLines)
{
    const gl::ExpandedSource source = gl::expand_text(
        "mine", "#include \"lib/noise.glsl\"\n#include \"lib/noise.glsl\"\nint last;\n",
        {{"A", "1"}});
    EXPECT_EQ(source.text.find("uvec3 hash_pcg3d"), source.text.rfind("uvec3 hash_pcg3d"));
    EXPECT_EQ(source.text.rfind("#version 450 core\n#define A 1\n", 0), 0u);
    const auto lines =
        static_cast<std::size_t>(std::count(source.text.begin(), source.text.end(), '\n'));
    ASSERT_EQ(source.origin.size(), lines);
    EXPECT_EQ(source.origin.back(), (std::pair<std::string, int>{"mine", 3}));
    EXPECT_EQ(source.origin[2], (std::pair<std::string, int>{"lib/noise.glsl", 1}));
    // Mesa's way to tell a line, NVIDIA's, and one that is not ours.
    EXPECT_EQ(source.map_log("0:3(7): error: x"), "glsl/lib/noise.glsl:1(7): error: x");
    EXPECT_EQ(source.map_log("0(4) : error C1008"), "glsl/lib/noise.glsl:2 : error C1008");
    EXPECT_EQ(source.map_log("0:9999(1): error"), "0:9999(1): error");
}

TEST(ShaderText, NamesAMissingFile)
{
    for (const auto& expand :
         {+[] { gl::expand_shader("pass/no_such.frag", {}); },
          +[] { gl::expand_text("t", "#include \"pass/no_such.frag\"\n", {}); }})
        try {
            expand();
            FAIL() << "no error";
        } catch (const Error& error) {
            EXPECT_STREQ(error.what(), "glsl/pass/no_such.frag: no such shader file");
        }
}

/// A driver tells compile errors to the debug callback too, where they would fail the test.
class ShaderErrors : public GlTest {
protected:
    ShaderErrors() { gl()->Disable(GL_DEBUG_OUTPUT); }
    ~ShaderErrors() override { gl()->Enable(GL_DEBUG_OUTPUT); }

    template <typename Call> static std::string error_of(const Call& call)
    {
        try {
            call();
        } catch (const Error& error) {
            return error.what();
        }
        ADD_FAILURE() << "no error";
        return "";
    }
};

TEST_F(ShaderErrors, CompileErrorsNameOurFileAndLine)
{
    // Line 2 of the kernel's own text, which stands behind its head of 3 lines.
    const std::string own =
        error_of([] { Kernel(gl(), "#include \"lib/noise.glsl\"\nint x = nonsense;\n"); });
    EXPECT_NE(own.find("glsl/kernel: does not compile on"), std::string::npos) << own;
    EXPECT_NE(own.find("glsl/kernel:5"), std::string::npos) << own;

    // A march without its media stops at the #error that says so.
    const std::string march = error_of([] {
        gl::Program(gl(), {"pass/fullscreen.vert", "pass/ray_march.frag"}, {{"LAYER_SCALE", "2"}});
    });
    EXPECT_NE(march.find("glsl/scene/media.glsl:"), std::string::npos) << march;
    EXPECT_NE(march.find("this file needs the scene's media"), std::string::npos) << march;
}

TEST_F(ShaderErrors, LinkErrorsNameTheFile)
{
    const std::string error = error_of([] {
        gl::Program(gl(), {"pass/fullscreen.vert", "light/shadow_map.frag"}, {});
    });
    EXPECT_NE(error.find("glsl/light/shadow_map.frag: does not link on"), std::string::npos)
        << error;
}

}  // namespace
}  // namespace fumarole::test
