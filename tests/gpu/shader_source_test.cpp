// The shaders as text: every variant that a scene and its settings can ask for passes
// glslangValidator, which minds the specification where drivers are lenient; messages name our
// files and lines.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <set>
#include <sstream>

#include "gl/program.h"
#include "light/light_source.h"
#include "medium/media_set.h"
#include "support/gl_test.h"
#include "support/kernel.h"
#include "support/temp_folder.h"
#include <fumarole/errors.h>
#include <fumarole/host_glsl.h>

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

/// Two bricks so far apart that their pages are a tree.
std::shared_ptr<VoxelGrid> far_grid(int channels)
{
    auto grid = small_grid(channels);
    grid->bricks.push_back({25000, 25000, 25000});
    grid->values.resize(2 * grid->values.size(), 1.0f);
    grid->index_max = glm::ivec3(200007);
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
        GridMedium hot = grid_medium(1, 3, 0, 0);
        hot.temperature = small_grid(1);
        all.push_back({fmt::format("{}_hot_with_a_flame", kind), {hot}, layout});
        hot.emission = nullptr;
        all.push_back({fmt::format("{}_hot", kind), {hot}, layout});
        hot.density = nullptr;
        all.push_back({fmt::format("{}_only_hot", kind), {hot}, layout});
    }
    for (const int density : {1, 3}) {
        GridMedium far = grid_medium(density, 1, 3, 0.3f);
        far.density = far_grid(density);
        far.emission = far_grid(1);
        all.push_back({fmt::format("far_bricks{}", density), {far}});
        all.push_back({fmt::format("far_bricks{}_in_a_box", density),
                       {far, box_medium(HomogeneousProfile{}, grey, 0.1f, none)}});
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
    a += b;
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

/// Of some lights, with and without surfaces that throw shadows.
Defines lights(int suns, int points, int spots, int areas, bool shadows)
{
    std::vector<Light> all(static_cast<std::size_t>(suns), SunLight{});
    all.insert(all.end(), static_cast<std::size_t>(points), PointLight{});
    all.insert(all.end(), static_cast<std::size_t>(spots), SpotLight{});
    all.insert(all.end(), static_cast<std::size_t>(areas), RectLight{});
    all.insert(all.end(), static_cast<std::size_t>(areas), DiskLight{});
    return light::write_lights(all) + flags(shadows ? 1 : 0, {"kSurfaceShadows"});
}

/// The same with transparents that cast.
Defines filtered(Defines lights)
{
    lights.emplace_back("LIGHT_FILTERS", "");
    lights.emplace_back("kFilterLayers", "2");
    return lights;
}

const std::array kLights{lights(0, 0, 0, 0, false), lights(1, 0, 0, 0, false),
                         lights(0, 1, 0, 0, true), lights(2, 3, 4, 1, true),
                         filtered(lights(1, 1, 1, 1, true))};

/// 32 sets of up to 16 flags in which every three flags come in all eight ways: flag i is the
/// parity of the run's number masked by a word of its own, and words of an odd number of bits are
/// never sums of two others.
std::vector<unsigned> sets_of_every_three()
{
    std::vector<unsigned> sets;
    for (unsigned run = 0; run < 32; ++run) {
        unsigned set = 0, flag = 1;
        for (unsigned word = 1; word < 32; ++word)
            if (std::popcount(word) % 2 == 1) {
                set |= std::popcount(run & word) % 2 == 1 ? flag : 0;
                flag <<= 1;
            }
        sets.push_back(set);
    }
    return sets;
}

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
        auto& [length, name] = longest_[file];
        if (length >= text.size())
            return;
        length = text.size();
        name = fmt::format("{:04}{}", texts_.size(), extension);
    }
    [[nodiscard]] std::size_t count() const { return texts_.size(); }
    [[nodiscard]] const std::set<std::string>& files() const { return files_; }

    [[nodiscard]] std::pair<std::string, int> validate() const
    {
        return validate_shaders(folder_.path());
    }

    /// Of each file the longest variant, down to SPIR-V for OpenGL, which minds more and takes 15
    /// times as long. @returns what is said of those that don't pass
    [[nodiscard]] std::string validate_for_opengl() const
    {
        std::string names;
        for (const auto& [file, longest] : longest_)
            names += longest.second + "\n";
        folder_.write("longest", names);
        // OpenGL finds places for what goes from stage to stage by itself (--aml).
        const int code = std::system(
            fmt::format("cd '{}' && xargs -P $(nproc) -I {{}} -a longest sh -c 'glslangValidator "
                        "--target-env opengl --aml -o {{}}.spv {{}} > {{}}.said || "
                        "cat {{}}.said >> wrong'",
                        folder_.path().string())
                .c_str());
        return code != 0 || std::filesystem::exists(folder_.path() / "wrong")
                   ? fmt::format("code {}: {}", code, read_bytes(folder_.path() / "wrong"))
                   : "";
    }

private:
    TempFolder folder_;
    std::set<std::string> texts_, files_;
    std::map<std::string, std::pair<std::size_t, std::string>> longest_;
};

/// As the layers write it, for a pass that looks up what media do before any depth.
std::string volume_at_text(const std::string& kind)
{
    std::string text = fmt::format("#include \"scene/volume_at_{}.glsl\"\n", kind);
    if (kind != "none")
        text += fmt::format("#define VolumeRay {}Ray\n#define volume_ray {}_ray\n",
                            kind == "froxels" ? "Froxel" : "Split",
                            kind == "froxels" ? "froxel" : "split");
    return text;
}

class ShaderVariants : public GlTest {};

TEST_F(ShaderVariants, AllPassGlslangValidator)
{
    if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "glslangValidator is not in PATH (Debian: glslang-tools)";
    Variants variants;
    const Defines kLayerTiles{{"kTilePixels", "4"}};
    // By compute shaders: each format of a picture, each way to blend.
    const std::array kPictures{"rgba16f", "rgba32f", "r11f_g11f_b10f",
                               "rgba8",   "rgba16",  "rgb10_a2"};
    std::size_t picture = 0;
    const auto resolve = [&](const char* file, const Defines& defines) {
        for (const char* factor : {"0", "1", "2", "3", "4"}) {
            picture = (picture + 1) % kPictures.size();
            variants.add(file, defines + Defines{{"PICTURE_FORMAT", kPictures.at(picture)},
                                                 {"kFactor", factor},
                                                 {"kAdds", picture % 2 == 0 ? "true" : "false"},
                                                 {"kNormalized", picture < 3 ? "false" : "true"}});
        }
    };
    variants.add("pass/fullscreen.vert", {});
    variants.add("pass/accumulate.frag", {});
    for (const Defines& compared :
         {Defines{}, Defines{{"kSplit", ""}}, Defines{{"kDifference", ""}}})
        variants.add("pass/display.frag", compared);
    variants.add("pass/tiles.vert", {{"kTilePixels", "8"}});
    variants.add("pass/tiles.vert", {{"kTilePixels", "16"}, {"FRAME_VARYINGS", ""}});
    for (const char* lit : {"true", "false"})
        for (const char* file : {"pass/tiles.vert", "pass/list_tiles.comp"})
            variants.add(file, {{"kAllTiles", "false"},
                                {"kLitTiles", lit},
                                {"kByDistance", "true"},
                                {"kFarTiles", lit}});
    variants.add("pass/list_tiles.comp", {{"kTilePixels", "16"}});
    for (const char* file :
         {"pass/see_boxes.comp", "pass/choose_steps.comp", "pass/want_depths.comp"})
        variants.add(file, {});
    variants.add("pass/surface.vert", {});
    variants.add("pass/surface.vert", {{"THROUGH_MEDIA", ""}});
    for (const char* file : {"study/texel_rate.frag", "study/texel_rate.comp"})
        variants.add(file, {{"kFetches", "64"}, {"kTexelPixels", "512"}});
    variants.add("light/shadow_map.frag", {});
    variants.add("light/shadow_map.frag", {{"kHalfway", ""}});
    variants.add("light/filter.vert", {});
    for (unsigned set = 0; set < 4; ++set)
        variants.add("light/filter.frag", flags(set, {"kImage", "kBehind"}));
    variants.add("pass/sky.frag", {});
    variants.add("pass/sky.frag", {{"kEnvironment", ""}});
    for (const char* scale : {"1", "2", "4"}) {
        const Defines at_scale{{"kLayerScale", scale}};
        for (unsigned set = 0; set < 2; ++set)
            for (const char* file : {"pass/layer_depth.frag", "pass/layer_depth.comp"})
                variants.add(file, at_scale + kLayerTiles + flags(set, {"kCheckerboard"}));
        variants.add("pass/inspect_rays.frag", at_scale);
        for (const unsigned history : {0b000u, 0b001u, 0b011u, 0b111u})
            for (unsigned set = 0; set < 2; ++set)
                for (const char* file : {"pass/march_history.frag", "pass/march_history.comp"})
                    variants.add(
                        file, at_scale + kLayerTiles + flags(set, {"MONOCHROME"}) +
                                  flags(history, {"kHistory", "kLightChanged", "kMediaChanged"}));
        for (const char* taps : {"1", "2", "4"})
            for (unsigned set = 0; set < 2; ++set)
                for (const Defines& targets : {Defines{}, Defines{{"BOTH", ""}}}) {
                    const Defines defines = at_scale + targets + Defines{{"kUpsampleTaps", taps}} +
                                            flags(set, {"kBox2017"});
                    variants.add("resolve/upsample.frag", defines);
                    resolve("resolve/upsample.comp", defines + Defines{{"kTilePixels", "16"}});
                }
    }
    for (const char* file : {"box.vert", "box.frag", "color.frag", "depth.frag", "dim.frag",
                             "extent.frag", "froxels.frag", "probe.frag"})
        variants.add(fmt::format("pass/inspect_{}", file), {});
    variants.add("pass/inspect_froxels.frag", {{"kSamples", ""}});
    variants.add("pass/probe_balls.frag", {});
    for (const Defines& lights : kLights)
        for (unsigned set = 0; set < 8; ++set) {
            const Defines of_set = lights + flags(set, {"kEnvironment", "kTwoSided", "GLOSSY"}) +
                                   flags(set, {"kWorldIrradiance"});
            variants.add("pass/surface.frag", of_set);
            variants.add("pass/surface.frag",
                         of_set + Defines{{"kWorldIrradiance", ""}, {"kFireOnSurfaces", ""}} +
                             flags(set, {"kLitBeyond"}));
            variants.add("pass/surface.frag",
                         of_set + Defines{{"kWorldIrradiance", ""}, {"kLitBeyond", ""}} +
                             flags(set, {"kAllBeyond", "kOneBox"}));
            for (const char* probes : {"kProbes", "kProbeIrradiance"})
                variants.add("pass/surface.frag", of_set + Defines{{"kProbes", ""}, {probes, ""}});
        }

    const auto volumes = [&](const Defines& media, unsigned set, bool all) {
        const Defines stored = flags(set, {"VOLUME_RGB"});
        variants.add("light/extinction.comp", media + kLights[0] + stored);
        variants.add("light/depth.comp", media + kLights[0] + stored);
        variants.add("light/pack_depths.comp", {});
        variants.add("light/columns.comp", media + kLights[0] + stored);
        const std::array kBands{"1", "3", "4"};
        for (std::size_t b = 0; b < kBands.size(); ++b) {
            const char* bands = kBands.at(b);
            if (!all && (set / 2 + b) % kBands.size() != 0)
                continue;
            const Defines of_bands = media + kLights[0] + stored + Defines{{"kBands", bands}};
            variants.add("light/world_view.comp", of_bands);
            variants.add("light/world_view.comp", of_bands + Defines{{"kFades", ""}});
            variants.add("light/world_view.comp", of_bands + Defines{{"kAmidVolume", ""}});
            variants.add("light/field_direct.comp",
                         media + kLights[set % kLights.size()] + stored +
                             Defines{{"kBands", bands}} +
                             flags(set >> 1, {"kDims", "kMarched", "kDepthVolume"}) +
                             flags(set, {"kListed", "kEnds", "kTaken", "kLeavesOut"}));
        }
        variants.add("light/field_medium.comp",
                     media + kLights[0] + stored +
                         flags(set >> 1, {"kGlows", "kMarched", "kSurfaces"}));
        variants.add("light/bounce.comp", media + kLights[0] + stored +
                                              flags(set >> 1, {"kMarched", "kClear", "kBeyond"}));
        variants.add("light/lamps.comp", media + kLights[0] + stored + Defines{{"kBands", "3"}} +
                                             flags(set >> 1, {"kMarched", "kClear"}));
        variants.add("light/face_gather.comp",
                     media + kLights[0] + stored + Defines{{"kBands", "3"}} +
                         flags(set >> 1, {"kMarched", "kBeyond", "kScatters"}) +
                         flags(set, {"kClear"}));
        for (const char* file : {"light/face_light.comp", "light/beyond.frag"})
            variants.add(
                file, media + kLights[set % kLights.size()] + stored +
                          flags(set >> 1, {"kDims", "kMarched", "kDepthVolume", "kEnvironment"}) +
                          Defines{{"kWorldIrradiance", ""}} + flags(set, {"kFireOnSurfaces"}));
        variants.add("light/fire_medium.comp",
                     media + kLights[0] + stored + flags(set >> 1, {"kGlows", "kOneColor"}));
        variants.add("light/face_light.comp",
                     media + kLights[set % kLights.size()] + stored + Defines{{"kEmits", ""}});
        variants.add("light/world.comp",
                     media + kLights[0] + stored +
                         flags(set >> 1, {"kMarched", "kSurfaces", "kMeans", "kClear", "kClosed"}) +
                         flags(set >> 2, {"kShares", "kEnds", "kLooked", "kTaken", "kAmid"}));
    };
    for (const Defines& source : {Defines{}, Defines{{"kSamples", "3"}}, Defines{{"FACES", ""}}})
        variants.add("probe/resolve.comp", source);
    for (const char* file :
         {"probe/shrink.comp", "probe/filter.comp", "probe/harmonics.comp", "probe/face.comp"})
        variants.add(file, {});
    variants.add("light/line.vert", {});
    variants.add("light/crossed.frag", {});
    variants.add("light/crossed.frag", {{"kBeyond", ""}});
    variants.add("light/crossed.frag", {{"kWalls", ""}});
    variants.add("light/walls.comp", {});
    for (const char* axis : {"0", "1", "2"}) {
        variants.add("light/clearance.comp", {{"kAxis", axis}});
        variants.add("light/even_out.comp", {{"kAxis", axis}, {"kBands", "3"}});
    }
    for (const char* file : {"light/sky_map.vert", "light/sky_map.frag", "light/sky_share.comp"})
        variants.add(file, {});
    variants.add("light/fire_cells.comp", {});
    variants.add("light/media_gather.comp", {{"kBands", "3"}});
    for (const char* kind : {"float", "vec3"})
        for (const char* file : {"light/fire_out.comp", "light/fire_light.comp"})
            variants.add(file, {{"extinction_t", kind}});
    variants.add("light/fire_seen.comp", {});
    variants.add("light/sights.comp", {});
    variants.add("light/fade.comp", {});
    variants.add("light/fade.comp", {{"kStays", ""}});
    variants.add("light/sights.comp", {{"kDims", ""}});
    variants.add("light/crossed.frag", {{"kFaces", ""}});
    variants.add("light/crossed.frag", {{"kFaces", ""}, {"kParts", ""}});
    variants.add("light/face_emission.comp", {});
    for (const char* bands : {"1", "3"})
        variants.add("light/field_other.comp", {{"kBands", bands}});
    for (const char* file : {"light/field_list.comp", "light/crossings.comp"})
        variants.add(file, {});
    variants.add("light/field_list.comp", {{"kHole", ""}});
    variants.add("light/field_sum.comp", {});
    variants.add("light/field_sum.comp", {{"kFinish", ""}});
    for (const char* type : {"float", "vec3"})
        variants.add("light/field_taken.comp", {{"extinction_t", type}, {"kListed", ""}});
    for (const char* bands : {"1", "3", "4"}) {
        const Defines of_bands{{"kBands", bands},
                               {"extinction_t", std::string_view(bands) == "3" ? "vec3" : "float"}};
        for (unsigned set = 0; set < 8; ++set)
            for (const char* ways : {"0", "26", "74"})
                variants.add("light/field_gather.comp",
                             of_bands + flags(set, {"kAdds", "kWorld", "kClear"}) +
                                 flags(set >> 2, {"kListed"}) +
                                 (set < 2 ? Defines{{"kTaken", ""}} : Defines{}) +
                                 Defines{{"kWays", ways}});
        for (unsigned set = 0; set < 2; ++set)
            for (const char* ways : {"0", "26", "74"})
                variants.add(
                    "light/field_gather.comp",
                    of_bands + flags(set, {"kAdds"}) + flags(set, {"kShares"}) +
                        Defines{{"kWorld", ""}, {"kClear", ""}, {"kDimmed", ""}, {"kWays", ways}});
        for (unsigned set = 0; set < 5; ++set)
            variants.add("light/field_scatter.comp",
                         of_bands +
                             flags(1u << set, {"kFirst", "kMean", "kTail", "kOwn", "kAhead"}) +
                             flags(set, {"kTaken"}) + Defines{{"kKeeps", ""}, {"kListed", ""}});
        variants.add("light/field_scatter.comp",
                     of_bands + Defines{{"kFirst", ""}, {"kListed", ""}});
        variants.add("light/field_scatter.comp",
                     of_bands +
                         Defines{{"kFirst", ""}, {"kMean", ""}, {"kKeeps", ""}, {"kListed", ""}});
        for (unsigned set = 0; set < 2; ++set)
            variants.add("light/field_finish.comp", of_bands +
                                                        Defines{{"kField", ""}, {"kListed", ""}} +
                                                        flags(set, {"kWorld", "kHole"}));
        for (unsigned set = 0; set < 2; ++set)
            variants.add("light/field_finish.comp", of_bands + flags(set, {"kListed"}));
        variants.add("light/field_scatter.comp", of_bands);
        variants.add("light/field_whole.comp", of_bands + Defines{{"kListed", ""}});
        variants.add("light/field_scatter.comp", of_bands + Defines{{"kListed", ""}});
        for (unsigned set = 0; set < 2; ++set)
            for (const char* ways : {"0", "26", "74"})
                variants.add("light/field_spread.comp",
                             of_bands + Defines{{"kWays", ways}} + flags(set, {"kListed"}));
    }
    variants.add("light/field_rest.comp", {});
    variants.add("light/field_rest.comp", {{"kFinish", ""}});
    for (unsigned set = 0; set < 2; ++set)
        for (const char* type : {"float", "vec3"})
            variants.add("light/field_own.comp",
                         flags(set, {"kSurfaces"}) +
                             Defines{{"extinction_t", type}, {"kListed", ""}});
    for (unsigned set = 0; set < 32; ++set)
        for (const char* type : {"float", "vec3"})
            variants.add("light/field_sweep.comp",
                         flags(set, {"kEmits", "kScatters", "kMeans", "kSurfaces", "kNear"}) +
                             flags(set >> 1, {"kEnds", "kLooked", "kTaken", "kComes"}) +
                             Defines{{"extinction_t", type}});

    for (const char* extinction : {"EXTINCTION_IN_ALPHA", "kRedInAlpha"})
        for (unsigned set = 0; set < 4; ++set)
            variants.add("pass/integrate.comp",
                         flags(set, {extinction, "kWronski"}) + flags(set >> 1, {"kTricubic"}));
    variants.add("pass/integrate.comp", {{"kOneColor", ""}, {"kRedInAlpha", ""}});
    for (unsigned set = 0; set < 8; ++set) {
        const Defines defines =
            flags(set, {"EXTINCTION_IN_ALPHA", "kTricubic", set >= 4 ? "kTransmittance" : "BOTH"});
        variants.add("resolve/froxels.frag", defines);
        variants.add("resolve/froxels.frag",
                     flags(set, {"kRedInAlpha", "kTricubic", "kTransmittance"}));
        resolve("resolve/froxels.comp", defines);
    }

    variants.add("transparent/fragment.vert", {});
    variants.add("transparent/fragment.vert", {{"kOver", ""}});
    variants.add("transparent/put_back.frag", {});
    for (unsigned set = 0; set < 8; ++set) {
        variants.add("transparent/fragment.frag", flags(set, {"kImage", "kHalfColor", "kFades"}));
        for (const char* volume : {"none", "froxels", "splits"}) {
            Defines defines = flags(set, {"kImage", "kFades", "kKeptAtPanes"});
            defines.emplace_back("kOver", "");
            if (volume[0] == 's')
                defines += flags(set, {"kMonochrome"}) +
                           Defines{{"kLayerScale", set % 2 == 0 ? "1" : "2"}, {"kSplitFours", "4"}};
            defines.add_file("written/volume_at.glsl", volume_at_text(volume));
            variants.add("transparent/over.frag", defines);
            defines.emplace_back("kCutFours", set % 2 == 0 ? "1" : "2");
            defines.emplace_back("kOfBehind", set % 2 == 0 ? "1.0" : "-1.0");
            variants.add("transparent/over.frag", defines);
        }
    }
    for (const char* way : {"kReadsPicture", "kTakesPicture", "kSingle", "kDoubled"})
        for (unsigned set = 0; set < 8; ++set)
            for (const char* volume : {"none", "froxels", "splits"}) {
                Defines defines =
                    flags(set, {way, "kHalfColor", volume[0] == 'f' ? "kTricubic" : "kHalfColor"});
                if (volume[0] == 'f')
                    defines += flags(set >> 1, {"EXTINCTION_IN_ALPHA"});
                if (volume[0] == 's')
                    defines += flags(set >> 2, {"kMonochrome"}) +
                               Defines{{"kLayerScale", set % 2 == 0 ? "1" : "2"},
                                       {"kSplitFours", set % 2 == 0 ? "4" : "16"}};
                defines.add_file("written/volume_at.glsl", volume_at_text(volume));
                variants.add("transparent/resolve.frag", defines);
            }
    variants.add("transparent/media_mask.frag", {});
    for (unsigned set = 0; set < 2; ++set)
        variants.add("transparent/layers.frag", flags(set, {"kHalfColor"}));
    for (const char* count : {"1", "8"}) {
        const Defines panes{{"kPaneCount", count}};
        variants.add("transparent/panes.vert", panes);
        for (unsigned set = 0; set < 2; ++set)
            for (const char* file : {"transparent/pane_tiles.vert", "transparent/pane_tiles.frag"})
                variants.add(file, panes + flags(set, {"kNoMedia"}) +
                                       Defines{{"kLayerScale", "2"}, {"kTilePixels", "16"}});
        for (const char* volume : {"none", "froxels", "splits"}) {
            Defines defines = panes;
            if (volume[0] == 'n')
                defines.emplace_back("kNoMedia", "");
            defines.add_file("written/volume_at.glsl", volume_at_text(volume));
            variants.add("transparent/panes.frag", defines);
            if (volume[0] != 's')
                continue;
            for (unsigned set = 0; set < 4; ++set) {
                const Defines of_march = flags(set, {"kMonochrome"}) +
                                         Defines{{"kLayerScale", set % 2 == 0 ? "1" : "2"}};
                variants.add("transparent/pane_layer.frag", panes + of_march);
                if (set == 0)
                    variants.add("transparent/pane_layer.frag",
                                 panes + of_march + Defines{{"kNoMedia", ""}});
                variants.add("transparent/panes.frag",
                             defines + of_march + flags(set >> 1, {"kPaneLayer"}));
            }
        }
    }

    // The froxels that sample: as the march below, with what is theirs alone.
    const auto froxels = [&](const Defines& media, const Defines& lights, unsigned set) {
        const bool colored = *media.value_of("extinction_t") == "vec3";
        const char* extinction = colored ? "kOneColor" : "EXTINCTION_IN_ALPHA";
        Defines sampling =
            flags(set, {"kVolumeShadows", "kWorldLight", extinction, "kCameraRange",
                        "kShadowToLight", "kMinExtinction"}) +
            flags(set >> 3, {"kWorldVolume", "kDepthVolume", "kWorldWalls", "kAmidVolume"}) +
            flags(set >> 2, {"kAmidFlames"});
        if (colored)
            sampling += flags(set >> 1, {"kRedInAlpha"});
        variants.add("pass/v_buffer.comp", media + lights + sampling);
        variants.add(
            "pass/scatter.comp",
            media + lights + sampling +
                flags(set >> 6, {"kGridShadows", "kHistory", "kHistoryStill", "kCountSamples"}) +
                flags(set >> 5, {"kMiddleLight"}) + flags(set, {"kPackedDepths"}));
        const unsigned changes[] = {0b000, 0b001, 0b011, 0b100, 0b101, 0b111};
        variants.add("pass/froxel_history.comp",
                     media + lights + sampling +
                         flags(changes[set % 6], {"kLightChanged", "kMediaChanged", "kCounted"}) +
                         flags(set >> 4, {"kGridShadows"}));
    };

    constexpr unsigned kDefault = 0b1100000111;
    // The march: every kind of medium with a few sets of flags, and every three flags in all ways
    // with two media.
    const auto march = [&](const Defines& media, const Defines& lights, unsigned set,
                           bool compute) {
        const Defines marched =
            media + lights +
            flags(set, {"kBlueNoise", "kVolumeShadows", "kWorldLight", "kCameraRange",
                        "kShadowToLight", "kMinExtinction", "kMonochrome", "kCountSamples",
                        "kDepthVolume", "kWorldVolume"}) +
            flags(set ^ set >> 3, {"kExactFalloff", "kMediaDepth", "kDepthAtPoint"}) +
            flags(set >> 2, {"kSplits", "kWorldWalls", "kAmidVolume"}) +
            flags(set >> 1, {"kAmidFlames"}) +
            flags(set >> 1, {"kFarPoints", "kPackedDepths", "kShadedPoints"}) +
            Defines{
                {"kLayerScale", "2"}, {"kShadowTaps", "4"}, {"kPanes", set % 3 == 0 ? "4" : "0"}};
        variants.add("pass/ray_march.frag", marched);
        const Defines kept =
            media + lights + flags(set, {"kWorldLight", "MONOCHROME", "kVolumeShadows"}) +
            Defines{{"kLayerScale", "2"}, {"kHistory", ""}, {"HISTORY_MOVED", ""}} +
            flags(set >> 3, {"kLightChanged"}) + flags(set >> 4, {"kMediaChanged"});
        variants.add("pass/march_history.frag", kept);
        // The same lines again: glslang has to see each of them once more only here and there.
        if (compute) {
            variants.add("pass/ray_march.comp",
                         marched + kLayerTiles + flags(set >> 6, {"kOneTarget"}));
            variants.add("pass/march_history.comp", kept + kLayerTiles);
        }
    };
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
        const std::array others{kDefault | 0b01000000u, 0b00111111u, 0u, 0b10000111u};
        for (const unsigned set : {kDefault, others.at(i % 4), others.at((i + 1) % 4)})
            march(of_media, kLights[(i + set) % kLights.size()], set, set == kDefault || set == 0);
        const bool every_three =
            kinds[i].name == "bricks_and_all_boxes" || kinds[i].name == "homogeneous_grey_dark_g0";
        std::size_t run = 0;
        for (const unsigned set : every_three ? sets_of_every_three() : std::vector<unsigned>{})
            for (const Defines& lights : {kLights[++run % kLights.size()], kLights[3]})
                march(of_media, lights, set, run % 4 == 0);
        for (const unsigned set : {0b0000000111u, 0b0010000011u, 0b0111111011u})
            froxels(of_media, kLights[(i + set) % kLights.size()], set);
        for (const unsigned set : every_three ? sets_of_every_three() : std::vector<unsigned>{})
            for (const Defines& lights : {kLights[++run % kLights.size()], kLights[3]})
                froxels(of_media, lights, set);
        for (unsigned set = every_three ? 0u : unsigned(i % 3); set < 8; set += every_three ? 1 : 3)
            variants.add("pass/surface.frag",
                         kLights[1 + (i + set) % 3] + of_media + Defines{{"THROUGH_MEDIA", ""}} +
                             flags(set, {"kShadowToLight", "kEnvironment", "GLOSSY"}) +
                             flags(set >> 1, {"kDepthVolume"}) + flags(set, {"kWorldIrradiance"}));
        // Three numbers are stored where extinction has a colour. Every set with two media, and of
        // the others four in turn.
        const bool colored = media.traits().colored_extinction;
        for (unsigned set = 0; set < 16; ++set)
            if ((colored || (set & 1) == 0) && (every_three || (set >> 1) % 4 == i % 4))
                volumes(of_media, set, every_three);
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
    EXPECT_EQ(variants.validate_for_opengl().substr(0, 4000), "");
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
        gl::Program(gl(), {"pass/fullscreen.vert", "pass/ray_march.frag"}, {{"kLayerScale", "2"}});
    });
    EXPECT_NE(march.find("glsl/scene/media.glsl:"), std::string::npos) << march;
    EXPECT_NE(march.find("this file needs the scene's media"), std::string::npos) << march;
    EXPECT_NE(march.find("written/scattering.glsl is written for a scene"), std::string::npos)
        << march;
}

// What C++ writes is in no file that a reader could open: a message quotes its line.
TEST_F(ShaderErrors, ALineThatIsWrittenForASceneIsQuoted)
{
    const std::string error = error_of([] {
        gl::Defines scene;
        scene.add_file("written/media.glsl", "int sound;\nfloat medium_7 = nonsense;\n");
        Kernel(gl(), "#include \"written/media.glsl\"\nvoid kernel(int i) {}\n", 1, 1, scene);
    });
    EXPECT_NE(error.find("glsl/written/media.glsl:2("), std::string::npos) << error;
    EXPECT_NE(error.find("glsl/written/media.glsl:2: float medium_7 = nonsense;"),
              std::string::npos)
        << error;
}

TEST(ShaderText, GivesConstantsTheVariantsValues)
{
    const std::string_view text = "const bool kExactFalloff = false;  // why\n"
                                  "const int kLayerScale = 1;\nconst float kPi = 3.0;\n";
    const auto expanded = [&](const gl::Defines& variant) {
        return gl::expand_text("mine", text, variant).text;
    };
    EXPECT_EQ(expanded({}), "#version 450 core\n" + std::string(text));
    gl::Defines variant{{"kExactFalloff", ""}, {"kLayerScale", "4"}};
    EXPECT_EQ(expanded(variant), "#version 450 core\nconst bool kExactFalloff = true;  // why\n"
                                 "const int kLayerScale = 4;\nconst float kPi = 3.0;\n");
    variant += {{"kExactFalloff", "false"}};  // the last one counts
    EXPECT_NE(expanded(variant).find("kExactFalloff = false"), std::string::npos);
    try {
        gl::expand_text("mine", text, {{"kNoSuchThing", ""}});
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(), "no file of glsl/ declares a constant kNoSuchThing");
    }
}

// A texture that a pass leaves bound is then never another pass's.
TEST(ShaderText, EachTextureUnitHasOneName)
{
    constexpr int kOfGlslang = 80;  // which knows no driver: OpenGL 4.5 promises 96
    const std::string text(gl::shader_files().find("shared/bindings.h")->second);
    std::istringstream words(text);
    std::map<std::string, std::string> names;
    for (std::string word, name, number; words >> word;) {
        if (word != "#define" || !(words >> name) || !name.ends_with("_UNIT"))
            continue;
        words >> number;
        EXPECT_EQ(number.find_first_not_of("0123456789"), std::string::npos)
            << name << " is a second name of " << number;
        EXPECT_EQ(names.emplace(number, name).first->second, name);
    }
    EXPECT_EQ(names.size(), std::size_t{GRID_UNIT} + 1) << "and none is left out";
    EXPECT_LE(GRID_UNIT + 2 * MAX_GRIDS, kOfGlslang);
}

// A host's own names, before and after, are what the text's would be without their prefix.
TEST(ShaderText, WhatAHostIncludesCollidesWithNothingOfItsOwn)
{
    const std::string before = R"(#version 450 core
#define FRAME_BLOCK oops!
#define VOLUME_AT_BLOCK oops!
#define TRANSPARENT_BLOCK oops!
#define SCENE_DEPTH_UNIT oops!
#define BLEND_ALPHA oops!
#define EXTINCTION_IN_ALPHA
#define u_frame oops!
#define u_splits oops!
#define kLayerScale oops!
#define MAX_SPLITS oops!
#define FUM_SHARED_BEGIN oops!
)";
    const std::string after = R"(
struct Ray { int x; };
struct VolumeAt { int x; };
struct FroxelRay { int x; };
struct Fragment { int x; };
struct FrameParams { int x; };
struct SliceParams { int x; };
const int kMostDraws = 3, kSkyViewZ = 4, kMonochrome = 5;
uniform float u_volume_at, u_froxels, u_transparent, u_fragments, u_fragment_count, u_first_img;
uniform Frame { float mine; };
uniform Froxels { float mine_too; };
float lookup, before, camera_ray, columns_at, slab_weight, view_z_of, blend_factors;
int volume_at(float x) { return 1; }
int transparent(float x) { return 2; }
int add_fragment(float x) { return 3; }
out vec4 color;
void main() { color = vec4(volume_at(0.0), transparent(0.0), add_fragment(0.0), CALLS); }
)";
    const std::string volume = volume_at_glsl({7, 9}), lists = transparent_glsl({5, 6, 3, 2});
    const auto with_calls = [&](const char* calls) {
        std::string text = after;
        return text.replace(text.find("CALLS"), 5, calls);
    };
    EXPECT_EQ(volume.find("#ifdef EXTINCTION_IN_ALPHA"), std::string::npos)
        << "a host may define it";
    TempFolder folder;
    folder.write("volume.frag", before + volume +
                                    with_calls("fumarole_volume_at(gl_FragCoord.xy, 1.0)"
                                               ".scattering.x"));
    folder.write("lists.frag", before + lists +
                                   "void put() { fumarole_transparent(vec4(1.0), "
                                   "FUMAROLE_BLEND_ALPHA); }\n" +
                                   with_calls("1.0"));
    // Both in one shader.
    folder.write("both.frag", "#version 450 core\n" + volume + lists +
                                  "void main() { fumarole_transparent(vec4(fumarole_volume_at("
                                  "gl_FragCoord.xy, 1.0).transmittance, 1.0), "
                                  "fumarole_blend_factors(FUMAROLE_BLEND_DST_COLOR, "
                                  "FUMAROLE_BLEND_ZERO), 3u, 1.0); }\n");
    if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "glslangValidator is not in PATH (Debian: glslang-tools)";
    const auto [output, code] = validate_shaders(folder.path());
    EXPECT_EQ(code, 0);
    EXPECT_EQ(output.substr(0, 4000), "");
}

// With all that it includes. Macros of glsl/shared are numbers of C++ too.
TEST(ShaderText, AnEntryHasFewMacrosAndConditionals)
{
    for (const auto& [file, text] : gl::shader_files()) {
        if (!file.starts_with("pass/") && !file.starts_with("resolve/"))
            continue;
        const gl::ExpandedSource source = gl::expand_shader(file, {});
        int conditionals = 0, macros = 0;
        std::istringstream lines(source.text);
        std::string line;
        for (std::size_t i = 0; std::getline(lines, line); ++i) {
            conditionals += line.starts_with("#if") || line.starts_with("#elif");
            macros += line.starts_with("#define") && !source.origin[i].first.starts_with("shared/");
        }
        EXPECT_LE(conditionals, 12) << file;
        EXPECT_LE(macros, 10) << file;
    }
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
