// The structs of glsl/shared mean the same to C++ and to GLSL: every member of every uniform block,
// as the GL places it, against offsetof.

#include <cstddef>
#include <fmt/format.h>
#include <map>

#include "shared/draw_params.h"
#include "shared/frame_params.h"
#include "shared/froxel_params.h"
#include "shared/inspect_params.h"
#include "shared/light_params.h"
#include "shared/light_volume_params.h"
#include "shared/march_history_params.h"
#include "shared/medium_params.h"
#include "support/gl_test.h"
#include "support/kernel.h"

namespace fumarole::test {
namespace {

using namespace fumarole::shared;
using Offsets = std::map<std::string, std::size_t>;

/// A member of a struct: its name and where C++ keeps it.
#define MEMBER(type, name)                                                                         \
    {                                                                                              \
#name, offsetof(type, name)                                                                \
    }

const Offsets kFrame{MEMBER(FrameParams, ray_origin),
                     MEMBER(FrameParams, ray_origin_dx),
                     MEMBER(FrameParams, ray_origin_dy),
                     MEMBER(FrameParams, ray_direction),
                     MEMBER(FrameParams, ray_direction_dx),
                     MEMBER(FrameParams, ray_direction_dy),
                     MEMBER(FrameParams, view_z_from_depth),
                     MEMBER(FrameParams, sky_depth),
                     MEMBER(FrameParams, full_size),
                     MEMBER(FrameParams, layer_size),
                     MEMBER(FrameParams, layer_offset),
                     MEMBER(FrameParams, step_range),
                     MEMBER(FrameParams, media_range),
                     MEMBER(FrameParams, march),
                     MEMBER(FrameParams, resolve)};
const Offsets kDraw{MEMBER(DrawParams, clip_from_object), MEMBER(DrawParams, world_from_object),
                    MEMBER(DrawParams, albedo), MEMBER(DrawParams, shadow_origin),
                    MEMBER(DrawParams, shadow_axis)};
const Offsets kInspect{MEMBER(InspectParams, clip_from_boxes), MEMBER(InspectParams, scale),
                       MEMBER(InspectParams, plane), MEMBER(InspectParams, bounds_min),
                       MEMBER(InspectParams, bounds_max)};
const Offsets kFroxels{MEMBER(FroxelParams, grid),
                       MEMBER(FroxelParams, range),
                       MEMBER(FroxelParams, spacing),
                       MEMBER(FroxelParams, jitter),
                       MEMBER(FroxelParams, clip_from_world),
                       MEMBER(FroxelParams, view_z_from_world),
                       MEMBER(FroxelParams, history_clip_from_world),
                       MEMBER(FroxelParams, history_view_z_from_world),
                       MEMBER(FroxelParams, history_range),
                       MEMBER(FroxelParams, history_eye)};
const Offsets kMarchHistory{MEMBER(MarchHistoryParams, clip_from_world),
                            MEMBER(MarchHistoryParams, view_z_from_world),
                            MEMBER(MarchHistoryParams, media_range),
                            MEMBER(MarchHistoryParams, eye), MEMBER(MarchHistoryParams, layer)};
const Offsets kLight{MEMBER(LightParams, position), MEMBER(LightParams, intensity),
                     MEMBER(LightParams, axis), MEMBER(LightParams, edge)};
const Offsets kView{MEMBER(ShadowView, clip_from_world), MEMBER(ShadowView, origin),
                    MEMBER(ShadowView, axis)};
const Offsets kLattice{MEMBER(LatticeParams, node_from_world),
                       MEMBER(LatticeParams, world_from_node), MEMBER(LatticeParams, last),
                       MEMBER(LatticeParams, inverse_size)};
const Offsets kDirection{MEMBER(WorldDirection, wi), MEMBER(WorldDirection, power)};
const Offsets kGrid{MEMBER(GridParams, index_from_world), MEMBER(GridParams, inverse_size),
                    MEMBER(GridParams, pages)};
const Offsets kMedium{MEMBER(MediumParams, bounds_from_world),
                      MEMBER(MediumParams, bounds_min),
                      MEMBER(MediumParams, bounds_max),
                      MEMBER(MediumParams, sigma_s),
                      MEMBER(MediumParams, sigma_t),
                      MEMBER(MediumParams, emission),
                      MEMBER(MediumParams, profile)};
const Offsets kOctave{MEMBER(NoiseOctave, cell_offset), MEMBER(NoiseOctave, fraction)};

/// `array[i].member` of every element of an array of structs.
template <typename Element>
void add_array(Offsets& to, const char* array, std::size_t at, std::size_t count,
               const Offsets& members)
{
    for (std::size_t i = 0; i < count; ++i)
        for (const auto& [name, offset] : members)
            to[fmt::format("{}[{}].{}", array, i, name)] = at + i * sizeof(Element) + offset;
}

/// `name.member` of a struct within a struct.
void add_struct(Offsets& to, const char* name, std::size_t at, const Offsets& members)
{
    for (const auto& [member, offset] : members)
        to[fmt::format("{}.{}", name, member)] = at + offset;
}

class ParamLayout : public GlTest {
protected:
    /// Every uniform of the one block of a shader that declares it, without the block's own name.
    struct Block {
        Offsets members;
        std::size_t bytes = 0;
        bool row_major = false;
    };
    Block layout(const char* file, const char* type)
    {
        // One member is used, as a compiler may drop a block that is not.
        const Kernel kernel(gl(), fmt::format(R"(
#include "shared/{}"
layout(std140, binding = 0) uniform Params {{ {} u_params; }};
void kernel(int i) {{ out_data[i] = vec4({}); }}
)",
                                              file, type, kUse.at(type)));
        const GLuint program = kernel.program();
        const GLuint block = gl()->GetProgramResourceIndex(program, GL_UNIFORM_BLOCK, "Params");
        EXPECT_NE(block, GL_INVALID_INDEX);
        Block found;
        const auto get = [&](GLenum interface, GLuint index, GLenum what) {
            GLint value = 0;
            gl()->GetProgramResourceiv(program, interface, index, 1, &what, 1, nullptr, &value);
            return value;
        };
        found.bytes = static_cast<std::size_t>(get(GL_UNIFORM_BLOCK, block, GL_BUFFER_DATA_SIZE));
        GLint uniforms = 0;
        gl()->GetProgramInterfaceiv(program, GL_UNIFORM, GL_ACTIVE_RESOURCES, &uniforms);
        for (GLuint i = 0; i < static_cast<GLuint>(uniforms); ++i) {
            if (get(GL_UNIFORM, i, GL_BLOCK_INDEX) != static_cast<GLint>(block))
                continue;
            std::array<char, 128> name{};
            gl()->GetProgramResourceName(program, GL_UNIFORM, i, name.size(), nullptr, name.data());
            std::string path(name.data());
            EXPECT_EQ(path.rfind("u_params.", 0), 0u) << path;
            found.members[path.substr(9)] = static_cast<std::size_t>(get(GL_UNIFORM, i, GL_OFFSET));
            found.row_major |= get(GL_UNIFORM, i, GL_IS_ROW_MAJOR) != 0;
        }
        return found;
    }

    static void expect_same(const Block& gl_side, const Offsets& cpp_side, std::size_t bytes)
    {
        EXPECT_EQ(gl_side.bytes, bytes);
        EXPECT_FALSE(gl_side.row_major) << "glm keeps columns";
        for (const auto& [name, offset] : gl_side.members) {
            const auto found = cpp_side.find(name);
            if (found == cpp_side.end())
                ADD_FAILURE() << name << " is in GLSL and not in this test's list: add it";
            else
                EXPECT_EQ(offset, found->second) << name;
        }
        for (const auto& [name, offset] : cpp_side)
            EXPECT_TRUE(gl_side.members.contains(name)) << name << " is not active in GLSL";
    }

private:
    const std::map<std::string, std::string> kUse{
        {"FrameParams", "u_params.resolve"},         {"DrawParams", "u_params.shadow_axis"},
        {"FroxelParams", "u_params.jitter"},         {"InspectParams", "u_params.scale"},
        {"MarchHistoryParams", "u_params.layer"},    {"LightsParams", "u_params.world_radiance"},
        {"LightVolumesParams", "u_params.fill"},     {"WorldParams", "u_params.views[1].origin"},
        {"MediaParams", "u_params.media[1].sigma_s"}};
};

TEST_F(ParamLayout, Frame)
{
    expect_same(layout("frame_params.h", "FrameParams"), kFrame, sizeof(FrameParams));
}

TEST_F(ParamLayout, Draw)
{
    expect_same(layout("draw_params.h", "DrawParams"), kDraw, sizeof(DrawParams));
}

TEST_F(ParamLayout, Froxels)
{
    expect_same(layout("froxel_params.h", "FroxelParams"), kFroxels, sizeof(FroxelParams));
}

TEST_F(ParamLayout, Inspect)
{
    expect_same(layout("inspect_params.h", "InspectParams"), kInspect, sizeof(InspectParams));
}

TEST_F(ParamLayout, Lights)
{
    Offsets expected{MEMBER(LightsParams, world_radiance)};
    add_array<LightParams>(expected, "lights", offsetof(LightsParams, lights), MAX_LIGHTS, kLight);
    add_array<ShadowView>(expected, "views", offsetof(LightsParams, views), MAX_SHADOW_VIEWS,
                          kView);
    expect_same(layout("light_params.h", "LightsParams"), expected, sizeof(LightsParams));
}

TEST_F(ParamLayout, LightVolumes)
{
    Offsets expected{MEMBER(LightVolumesParams, extinction_color), MEMBER(LightVolumesParams, view),
                     MEMBER(LightVolumesParams, fill), MEMBER(LightVolumesParams, light)};
    add_struct(expected, "extinction", offsetof(LightVolumesParams, extinction), kLattice);
    add_struct(expected, "depth", offsetof(LightVolumesParams, depth), kLattice);
    add_struct(expected, "world", offsetof(LightVolumesParams, world), kLattice);
    add_struct(expected, "surfaces", offsetof(LightVolumesParams, surfaces), kLattice);
    expect_same(layout("light_volume_params.h", "LightVolumesParams"), expected,
                sizeof(LightVolumesParams));
}

TEST_F(ParamLayout, World)
{
    Offsets expected;
    add_array<WorldDirection>(expected, "directions", offsetof(WorldParams, directions),
                              MAX_WORLD_DIRECTIONS, kDirection);
    add_array<ShadowView>(expected, "views", offsetof(WorldParams, views), MAX_WORLD_DIRECTIONS,
                          kView);
    expect_same(layout("light_volume_params.h", "WorldParams"), expected, sizeof(WorldParams));
}

TEST_F(ParamLayout, Media)
{
    Offsets expected;
    add_array<GridParams>(expected, "grids", offsetof(MediaParams, grids), MAX_GRIDS, kGrid);
    add_array<MediumParams>(expected, "media", offsetof(MediaParams, media), MAX_MEDIA, kMedium);
    add_array<NoiseOctave>(expected, "octaves", offsetof(MediaParams, octaves),
                           MAX_MEDIA * MAX_OCTAVES, kOctave);
    expect_same(layout("medium_params.h", "MediaParams"), expected, sizeof(MediaParams));
}

TEST_F(ParamLayout, EveryBlockFitsTheSmallestLimit)
{
    // GL 4.5 promises 16 KiB a block.
    EXPECT_LE(sizeof(FrameParams), 16384u);
    EXPECT_LE(sizeof(DrawParams), 16384u);
    EXPECT_LE(sizeof(LightsParams), 16384u);
    EXPECT_LE(sizeof(MediaParams), 16384u);
    EXPECT_LE(sizeof(LightVolumesParams), 16384u);
    EXPECT_LE(sizeof(WorldParams), 16384u);
}

}  // namespace
}  // namespace fumarole::test
