// What is in glsl/shared means the same to C++ and to GLSL: every member of every uniform block, as
// the GL places it, against offsetof; and bits that one side packs are what the other takes apart.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <fmt/format.h>
#include <map>

#include "shared/brick_page.h"
#include "shared/display_params.h"
#include "shared/draw_params.h"
#include "shared/field_params.h"
#include "shared/frame_params.h"
#include "shared/froxel_params.h"
#include "shared/host_transparent_params.h"
#include "shared/inspect_params.h"
#include "shared/island_light_params.h"
#include "shared/light_fade_params.h"
#include "shared/light_filter_params.h"
#include "shared/light_params.h"
#include "shared/light_volume_params.h"
#include "shared/march_history_params.h"
#include "shared/medium_params.h"
#include "shared/pane_params.h"
#include "shared/probe_params.h"
#include "shared/sky_map_params.h"
#include "shared/split_params.h"
#include "shared/step_boxes.h"
#include "shared/step_tile.h"
#include "shared/tile_list.h"
#include "shared/transparent_params.h"
#include "shared/volume_at_params.h"
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
                     MEMBER(FrameParams, full_size),
                     MEMBER(FrameParams, inverse_full_size),
                     MEMBER(FrameParams, layer_size),
                     MEMBER(FrameParams, inverse_layer_size),
                     MEMBER(FrameParams, layer_offset),
                     MEMBER(FrameParams, layer_offset_pixels),
                     MEMBER(FrameParams, step_range),
                     MEMBER(FrameParams, media_range),
                     MEMBER(FrameParams, step_octaves),
                     MEMBER(FrameParams, media_depth),
                     MEMBER(FrameParams, steps),
                     MEMBER(FrameParams, distribution),
                     MEMBER(FrameParams, step_jitter),
                     MEMBER(FrameParams, shadow_steps),
                     MEMBER(FrameParams, min_transmittance),
                     MEMBER(FrameParams, min_extinction),
                     MEMBER(FrameParams, g_clamp),
                     MEMBER(FrameParams, radiance_limit),
                     MEMBER(FrameParams, depth_threshold),
                     MEMBER(FrameParams, sky_depth)};
const Offsets kDepth{MEMBER(ShadowDepth, origin), MEMBER(ShadowDepth, inverse_range),
                     MEMBER(ShadowDepth, travel), MEMBER(ShadowDepth, bias)};
const Offsets kInspect{
    MEMBER(InspectParams, clip_from_boxes),     MEMBER(InspectParams, plane_axis),
    MEMBER(InspectParams, plane_place),         MEMBER(InspectParams, bounds_min),
    MEMBER(InspectParams, scale_begin),         MEMBER(InspectParams, bounds_max),
    MEMBER(InspectParams, inverse_scale_width), MEMBER(InspectParams, slice)};
const Offsets kSlices{MEMBER(SliceParams, begin),       MEMBER(SliceParams, end),
                      MEMBER(SliceParams, depth),       MEMBER(SliceParams, count),
                      MEMBER(SliceParams, spacing),     MEMBER(SliceParams, rate),
                      MEMBER(SliceParams, exp2_rate_1), MEMBER(SliceParams, rescale)};
const Offsets kMarchHistory{MEMBER(MarchHistoryParams, clip_from_world),
                            MEMBER(MarchHistoryParams, view_z_from_world),
                            MEMBER(MarchHistoryParams, eye),
                            MEMBER(MarchHistoryParams, media_range),
                            MEMBER(MarchHistoryParams, layer_offset),
                            MEMBER(MarchHistoryParams, media_depth),
                            MEMBER(MarchHistoryParams, weight)};
const Offsets kTone{MEMBER(ToneParams, exposure), MEMBER(ToneParams, filmic)};
const Offsets kLight{MEMBER(LightParams, position),
                     MEMBER(LightParams, first_view),
                     MEMBER(LightParams, intensity),
                     MEMBER(LightParams, cube_view_scale),
                     {"own[0]", offsetof(LightParams, own)}};
const Offsets kSpot{MEMBER(SpotParams, axis), MEMBER(SpotParams, cos_half_cone),
                    MEMBER(SpotParams, inverse_edge_width)};
const Offsets kLattice{MEMBER(LatticeParams, node_from_world),
                       MEMBER(LatticeParams, world_from_node),
                       MEMBER(LatticeParams, last),
                       MEMBER(LatticeParams, layers),
                       MEMBER(LatticeParams, inverse_size),
                       MEMBER(LatticeParams, spacing)};
const Offsets kColumns{MEMBER(SunColumns, shear), MEMBER(SunColumns, axis),
                       MEMBER(SunColumns, normal), MEMBER(SunColumns, to_last)};
const Offsets kFire{MEMBER(FireParams, middle),
                    MEMBER(FireParams, inverse_node),
                    MEMBER(FireParams, core),
                    MEMBER(FireParams, growth),
                    MEMBER(FireParams, first),
                    MEMBER(FireParams, is_seen),
                    MEMBER(FireParams, last),
                    MEMBER(FireParams, rays),
                    MEMBER(FireParams, extinction_color),
                    MEMBER(FireParams, unused)};
const Offsets kSunLookup{MEMBER(SunLookup, column_from_world), MEMBER(SunLookup, per_period),
                         MEMBER(SunLookup, first_z),           MEMBER(SunLookup, enters),
                         MEMBER(SunLookup, unused_1),          MEMBER(SunLookup, across),
                         MEMBER(SunLookup, unused_2),          MEMBER(SunLookup, towards),
                         MEMBER(SunLookup, unused_3),          MEMBER(SunLookup, first),
                         MEMBER(SunLookup, unused_4)};
const Offsets kGrid{MEMBER(GridParams, index_from_world), MEMBER(GridParams, inverse_size),
                    MEMBER(GridParams, unit), MEMBER(GridParams, pages), MEMBER(GridParams, tree)};
const Offsets kMedium{MEMBER(MediumParams, bounds_from_world),
                      MEMBER(MediumParams, bounds_min),
                      MEMBER(MediumParams, noise_threshold),
                      MEMBER(MediumParams, bounds_max),
                      MEMBER(MediumParams, noise_gain),
                      MEMBER(MediumParams, sigma_s),
                      MEMBER(MediumParams, g),
                      MEMBER(MediumParams, sigma_t),
                      MEMBER(MediumParams, emission),
                      MEMBER(MediumParams, kilokelvin_per_unit),
                      MEMBER(MediumParams, blackbody),
                      MEMBER(MediumParams, light_dimming),
                      MEMBER(MediumParams, noise_scale),
                      MEMBER(MediumParams, inverse_scale_height),
                      MEMBER(MediumParams, base_height),
                      MEMBER(MediumParams, noise_octaves)};
const Offsets kIsland{MEMBER(Island, low), MEMBER(Island, medium), MEMBER(Island, high)};
const Offsets kOctave{MEMBER(NoiseOctave, cell_offset), MEMBER(NoiseOctave, fraction),
                      MEMBER(NoiseOctave, frequency)};

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

Offsets view_members()
{
    Offsets members{MEMBER(ShadowView, clip_from_world)};
    add_struct(members, "depth", offsetof(ShadowView, depth), kDepth);
    return members;
}

Offsets split_members()
{
    Offsets members{MEMBER(SplitParams, count), MEMBER(SplitParams, unused_x),
                    MEMBER(SplitParams, unused_y), MEMBER(SplitParams, unused_z)};
    members["view_z[0]"] = offsetof(SplitParams, view_z);
    return members;
}

Offsets froxel_members()
{
    Offsets members{MEMBER(FroxelParams, columns),
                    MEMBER(FroxelParams, tile_pixels),
                    MEMBER(FroxelParams, guard_columns),
                    MEMBER(FroxelParams, jitter),
                    MEMBER(FroxelParams, history_weight),
                    MEMBER(FroxelParams, clip_from_world),
                    MEMBER(FroxelParams, view_z_from_world),
                    MEMBER(FroxelParams, history_clip_from_world),
                    MEMBER(FroxelParams, history_view_z_from_world),
                    MEMBER(FroxelParams, history_eye),
                    MEMBER(FroxelParams, extinction_color),
                    MEMBER(FroxelParams, dithered_frame)};
    add_struct(members, "slices", offsetof(FroxelParams, slices), kSlices);
    add_struct(members, "history_slices", offsetof(FroxelParams, history_slices), kSlices);
    return members;
}

class ParamLayout : public GlTest {
protected:
    /// Every member of the one block of a shader that declares it, without the block's own name.
    struct Block {
        Offsets members;
        std::size_t bytes = 0;
        bool row_major = false;
    };
    Block layout(const char* file, const char* type)
    {
        return layout(file, type, "layout(std140, binding = 0) uniform", GL_UNIFORM_BLOCK,
                      GL_UNIFORM);
    }
    /// Of a storage buffer.
    Block storage_layout(const char* file, const char* type)
    {
        return layout(file, type, "layout(std430, binding = 2) readonly buffer",
                      GL_SHADER_STORAGE_BLOCK, GL_BUFFER_VARIABLE);
    }
    Block layout(const char* file, const char* type, const char* declared, GLenum blocks,
                 GLenum variables)
    {
        // One member is used, as a compiler may drop a block that is not.
        const Kernel kernel(gl(), fmt::format(R"(
#include "shared/{}"
{} Params {{ {} u_params; }};
void kernel(int i) {{ out_data[i] = vec4({}); }}
)",
                                              file, declared, type, kUse.at(type)));
        const GLuint program = kernel.program();
        const GLuint block = gl()->GetProgramResourceIndex(program, blocks, "Params");
        EXPECT_NE(block, GL_INVALID_INDEX);
        Block found;
        const auto get = [&](GLenum interface, GLuint index, GLenum what) {
            GLint value = 0;
            gl()->GetProgramResourceiv(program, interface, index, 1, &what, 1, nullptr, &value);
            return value;
        };
        found.bytes = static_cast<std::size_t>(get(blocks, block, GL_BUFFER_DATA_SIZE));
        GLint count = 0;
        gl()->GetProgramInterfaceiv(program, variables, GL_ACTIVE_RESOURCES, &count);
        for (GLuint i = 0; i < static_cast<GLuint>(count); ++i) {
            if (get(variables, i, GL_BLOCK_INDEX) != static_cast<GLint>(block))
                continue;
            std::array<char, 128> name{};
            gl()->GetProgramResourceName(program, variables, i, name.size(), nullptr, name.data());
            std::string path(name.data());
            EXPECT_EQ(path.rfind("u_params.", 0), 0u) << path;
            found.members[path.substr(9)] = static_cast<std::size_t>(get(variables, i, GL_OFFSET));
            found.row_major |= get(variables, i, GL_IS_ROW_MAJOR) != 0;
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
        {"FrameParams", "u_params.steps"},
        {"DrawParams", "u_params.roughness"},
        {"FroxelParams", "u_params.history_weight"},
        {"InspectParams", "u_params.scale_begin"},
        {"MarchHistoryParams", "u_params.weight"},
        {"LightsParams", "u_params.world_radiance"},
        {"SpotParams", "u_params.cos_half_cone"},
        {"LightVolumesParams", "u_params.layer"},
        {"IslandLightParams", "float(u_params.count)"},
        {"FieldParams", "u_params.order"},
        {"LightFadeParams", "u_params.share"},
        {"SkyMapParams", "float(u_params.way)"},
        {"MediaParams", "u_params.media[1].g"},
        {"DisplayParams", "u_params.wipe"},
        {"TransparentParams", "float(u_params.pane)"},
        {"LightFiltersParams", "u_params.points[0].first_layer"},
        {"LightFilterDrawParams", "u_params.unused"},
        {"PaneParams", "u_params.view_z.x"},
        {"SplitParams", "float(u_params.count)"},
        {"StepViewParams", "float(u_params.slot_count)"},
        {"StepBox", "vec4(u_params.low)"},
        {"SeenTile", "float(u_params.most)"},
        {"TileListHead", "float(u_params.groups)"},
        {"ProbesParams", "u_params.world.last"},
        {"ProbeFilterParams", "u_params.alpha"},
        {"VolumeAtParams", "float(u_params.kind)"},
        {"HostTransparentParams", "u_params.sky_depth"}};
};

TEST_F(ParamLayout, Frame)
{
    expect_same(layout("frame_params.h", "FrameParams"), kFrame, sizeof(FrameParams));
}

TEST_F(ParamLayout, Draw)
{
    Offsets expected{MEMBER(DrawParams, clip_from_object), MEMBER(DrawParams, world_from_object),
                     MEMBER(DrawParams, albedo),           MEMBER(DrawParams, roughness),
                     MEMBER(DrawParams, emission),         MEMBER(DrawParams, metallic),
                     MEMBER(DrawParams, number),           MEMBER(DrawParams, is_open)};
    add_struct(expected, "shadow_depth", offsetof(DrawParams, shadow_depth), kDepth);
    expect_same(layout("draw_params.h", "DrawParams"), expected, sizeof(DrawParams));
}

TEST_F(ParamLayout, Froxels)
{
    expect_same(layout("froxel_params.h", "FroxelParams"), froxel_members(), sizeof(FroxelParams));
}

TEST_F(ParamLayout, MarchHistory)
{
    expect_same(layout("march_history_params.h", "MarchHistoryParams"), kMarchHistory,
                sizeof(MarchHistoryParams));
}

TEST_F(ParamLayout, StepTiles)
{
    Offsets expected{{"view_from_boxes[0]", offsetof(StepViewParams, view_from_boxes)},
                     {"ends[0]", offsetof(StepViewParams, ends)},
                     {"lengths[0]", offsetof(StepViewParams, lengths)},
                     {"parts[0]", offsetof(StepViewParams, parts)},
                     MEMBER(StepViewParams, clip_from_view),
                     MEMBER(StepViewParams, picture),
                     MEMBER(StepViewParams, offset),
                     MEMBER(StepViewParams, near),
                     MEMBER(StepViewParams, scale),
                     MEMBER(StepViewParams, reach),
                     MEMBER(StepViewParams, slack),
                     MEMBER(StepViewParams, depth_rounding),
                     MEMBER(StepViewParams, shaft),
                     MEMBER(StepViewParams, far_share),
                     MEMBER(StepViewParams, tile_radius),
                     MEMBER(StepViewParams, march_tiles),
                     MEMBER(StepViewParams, picture_tiles),
                     MEMBER(StepViewParams, slot_count),
                     MEMBER(StepViewParams, slot_width),
                     MEMBER(StepViewParams, light_count),
                     MEMBER(StepViewParams, spaced),
                     MEMBER(StepViewParams, lit),
                     MEMBER(StepViewParams, shafts_anywhere),
                     MEMBER(StepViewParams, unused_a),
                     MEMBER(StepViewParams, unused_b)};
    add_array<StepLight>(expected, "lights", offsetof(StepViewParams, lights), MAX_LIGHT_POINTS,
                         {MEMBER(StepLight, pixel), MEMBER(StepLight, metres),
                          MEMBER(StepLight, least), MEMBER(StepLight, view_z),
                          MEMBER(StepLight, unused)});
    expect_same(layout("step_boxes.h", "StepViewParams"), expected, sizeof(StepViewParams));
    expect_same(storage_layout("step_boxes.h", "StepBox"),
                {MEMBER(StepBox, low), MEMBER(StepBox, high)}, sizeof(StepBox));
    expect_same(storage_layout("step_boxes.h", "SeenTile"),
                {MEMBER(SeenTile, slots_low), MEMBER(SeenTile, slots_high),
                 MEMBER(SeenTile, not_longest), MEMBER(SeenTile, most)},
                sizeof(SeenTile));
    EXPECT_GE(MAX_STEP_PARTS, 3 * MAX_MEDIA) << "density, emission and temperature";
}

TEST_F(ParamLayout, TileList)
{
    expect_same(storage_layout("tile_list.h", "TileListHead"),
                {MEMBER(TileListHead, groups_x),
                 MEMBER(TileListHead, groups_y),
                 MEMBER(TileListHead, groups_z),
                 MEMBER(TileListHead, groups),
                 {"tiles[0]", offsetof(TileListHead, tiles)}},
                sizeof(TileListHead));
    // As glDispatchComputeIndirect reads it.
    EXPECT_EQ(offsetof(TileListHead, groups_x), 0u);
    EXPECT_EQ(offsetof(TileListHead, groups_y), sizeof(GLuint));
    EXPECT_EQ(offsetof(TileListHead, groups_z), 2 * sizeof(GLuint));
}

TEST_F(ParamLayout, Display)
{
    Offsets expected{MEMBER(DisplayParams, lower_left), MEMBER(DisplayParams, size),
                     MEMBER(DisplayParams, wipe), MEMBER(DisplayParams, largest_difference),
                     MEMBER(DisplayParams, tenth_mean_square)};
    add_struct(expected, "tone_a", offsetof(DisplayParams, tone_a), kTone);
    add_struct(expected, "tone_b", offsetof(DisplayParams, tone_b), kTone);
    expect_same(layout("display_params.h", "DisplayParams"), expected, sizeof(DisplayParams));
}

TEST_F(ParamLayout, Inspect)
{
    expect_same(layout("inspect_params.h", "InspectParams"), kInspect, sizeof(InspectParams));
}

TEST_F(ParamLayout, Lights)
{
    Offsets expected{MEMBER(LightsParams, world_radiance)};
    add_array<LightParams>(expected, "lights", offsetof(LightsParams, lights), MAX_LIGHT_POINTS,
                           kLight);
    add_array<ShadowView>(expected, "views", offsetof(LightsParams, views), MAX_SHADOW_VIEWS,
                          view_members());
    expect_same(layout("light_params.h", "LightsParams"), expected, sizeof(LightsParams));
}

TEST_F(ParamLayout, LightsOfOneType)
{
    expect_same(layout("light_params.h", "SpotParams"), kSpot, sizeof(SpotParams));
}

TEST_F(ParamLayout, LightFilters)
{
    Offsets point{MEMBER(LightFilterParams, clip_from_world),
                  MEMBER(LightFilterParams, first_layer),
                  MEMBER(LightFilterParams, cube_view_scale), MEMBER(LightFilterParams, unused_a),
                  MEMBER(LightFilterParams, unused_b)};
    add_struct(point, "depth", offsetof(LightFilterParams, depth), kDepth);
    Offsets expected;
    add_array<LightFilterParams>(expected, "points", offsetof(LightFiltersParams, points),
                                 MAX_LIGHT_POINTS, point);
    expect_same(layout("light_filter_params.h", "LightFiltersParams"), expected,
                sizeof(LightFiltersParams));
    Offsets draw{MEMBER(LightFilterDrawParams, clip_from_object),
                 MEMBER(LightFilterDrawParams, light_from_object),
                 MEMBER(LightFilterDrawParams, source),
                 MEMBER(LightFilterDrawParams, factor),
                 MEMBER(LightFilterDrawParams, is_filter),
                 MEMBER(LightFilterDrawParams, layer_before),
                 MEMBER(LightFilterDrawParams, unused)};
    add_struct(draw, "depth", offsetof(LightFilterDrawParams, depth), kDepth);
    expect_same(layout("light_filter_params.h", "LightFilterDrawParams"), draw,
                sizeof(LightFilterDrawParams));
}
TEST_F(ParamLayout, LightVolumes)
{
    Offsets expected{MEMBER(LightVolumesParams, extinction_color),
                     MEMBER(LightVolumesParams, view_axis),
                     MEMBER(LightVolumesParams, orthographic),
                     MEMBER(LightVolumesParams, depth_period),
                     MEMBER(LightVolumesParams, packed_scale),
                     MEMBER(LightVolumesParams, light),
                     MEMBER(LightVolumesParams, layer),
                     MEMBER(LightVolumesParams, first_slice),
                     MEMBER(LightVolumesParams, samples),
                     MEMBER(LightVolumesParams, first_flame),
                     MEMBER(LightVolumesParams, beyond_flame),
                     MEMBER(LightVolumesParams, amid_per_low_rim),
                     MEMBER(LightVolumesParams, amid_per_high_rim),
                     MEMBER(LightVolumesParams, unused_1),
                     MEMBER(LightVolumesParams, unused_2),
                     MEMBER(LightVolumesParams, media_middle),
                     MEMBER(LightVolumesParams, media_radius),
                     MEMBER(LightVolumesParams, period_size),
                     MEMBER(LightVolumesParams, packed_period_z)};
    add_struct(expected, "extinction", offsetof(LightVolumesParams, extinction), kLattice);
    add_struct(expected, "depth", offsetof(LightVolumesParams, depth), kLattice);
    add_struct(expected, "world", offsetof(LightVolumesParams, world), kLattice);
    add_struct(expected, "surfaces", offsetof(LightVolumesParams, surfaces), kLattice);
    add_struct(expected, "amid", offsetof(LightVolumesParams, amid), kLattice);
    add_struct(expected, "filled", offsetof(LightVolumesParams, filled), kColumns);
    add_struct(expected, "fire", offsetof(LightVolumesParams, fire), kFire);
    expected["fire.points[0]"] = offsetof(LightVolumesParams, fire.points);
    add_struct(expected, "fire.flame", offsetof(LightVolumesParams, fire.flame), kLattice);
    add_struct(expected, "fire.media", offsetof(LightVolumesParams, fire.media), kLattice);
    add_array<SunLookup>(expected, "suns", offsetof(LightVolumesParams, suns), MAX_LIGHTS,
                         kSunLookup);
    expect_same(layout("light_volume_params.h", "LightVolumesParams"), expected,
                sizeof(LightVolumesParams));
}

TEST_F(ParamLayout, IslandLight)
{
    const Offsets lattice{MEMBER(IslandLattice, node_from_world), MEMBER(IslandLattice, last),
                          MEMBER(IslandLattice, first)};
    Offsets expected{MEMBER(IslandLightParams, inverse_size), MEMBER(IslandLightParams, count)};
    add_array<IslandLattice>(expected, "lattices", offsetof(IslandLightParams, lattices),
                             MAX_ISLANDS + 1, lattice);
    expect_same(layout("island_light_params.h", "IslandLightParams"), expected,
                sizeof(IslandLightParams));
}

TEST_F(ParamLayout, Field)
{
    const Offsets way{
        MEMBER(FieldWay, entry),       MEMBER(FieldWay, axis),       MEMBER(FieldWay, wi),
        MEMBER(FieldWay, metres),      MEMBER(FieldWay, slope),      MEMBER(FieldWay, forward),
        MEMBER(FieldWay, solid_angle), MEMBER(FieldWay, first_line), MEMBER(FieldWay, beside)};
    Offsets expected{MEMBER(FieldParams, albedo),     MEMBER(FieldParams, count),
                     MEMBER(FieldParams, media_low),  MEMBER(FieldParams, first),
                     MEMBER(FieldParams, media_high), MEMBER(FieldParams, order),
                     MEMBER(FieldParams, ends_low),   MEMBER(FieldParams, in_plane),
                     MEMBER(FieldParams, ends_high),  MEMBER(FieldParams, slot),
                     MEMBER(FieldParams, lines),      MEMBER(FieldParams, tilt),
                     MEMBER(FieldParams, slots),      MEMBER(FieldParams, straight_on),
                     MEMBER(FieldParams, apart),      MEMBER(FieldParams, left_out),
                     MEMBER(FieldParams, hole_low),   MEMBER(FieldParams, hole_high),
                     MEMBER(FieldParams, unused_1),   MEMBER(FieldParams, unused_2)};
    add_struct(expected, "nodes", offsetof(FieldParams, nodes), kLattice);
    add_struct(expected, "other", offsetof(FieldParams, other), kLattice);
    add_array<FieldWay>(expected, "ways", offsetof(FieldParams, ways), FIELD_BATCH, way);
    expect_same(layout("field_params.h", "FieldParams"), expected, sizeof(FieldParams));
}

TEST_F(ParamLayout, LightFade)
{
    const Offsets expected{MEMBER(LightFadeParams, before_from_node),
                           MEMBER(LightFadeParams, last_before), MEMBER(LightFadeParams, share),
                           MEMBER(LightFadeParams, inverse_size), MEMBER(LightFadeParams, layers)};
    expect_same(layout("light_fade_params.h", "LightFadeParams"), expected,
                sizeof(LightFadeParams));
}

TEST_F(ParamLayout, SkyMaps)
{
    Offsets expected{MEMBER(SkyMapParams, low), MEMBER(SkyMapParams, way),
                     MEMBER(SkyMapParams, high), MEMBER(SkyMapParams, texels)};
    add_array<SkyMap>(expected, "maps", offsetof(SkyMapParams, maps), SKY_MAPS,
                      {MEMBER(SkyMap, across), MEMBER(SkyMap, up), MEMBER(SkyMap, toward)});
    expect_same(layout("sky_map_params.h", "SkyMapParams"), expected, sizeof(SkyMapParams));
}

TEST_F(ParamLayout, Probes)
{
    const Offsets map{MEMBER(ProbeMap, first), MEMBER(ProbeMap, size), MEMBER(ProbeMap, layer)};
    Offsets filter{MEMBER(ProbeFilterParams, alpha)};
    add_struct(filter, "from", offsetof(ProbeFilterParams, from), map);
    add_struct(filter, "to", offsetof(ProbeFilterParams, to), map);
    expect_same(layout("probe_params.h", "ProbeFilterParams"), filter, sizeof(ProbeFilterParams));

    const Offsets place{{"maps[0]", offsetof(ProbeLayoutParams, maps)},
                        MEMBER(ProbeLayoutParams, last),
                        MEMBER(ProbeLayoutParams, harmonics)};
    Offsets probes;
    probes.emplace("count", offsetof(ProbesParams, count));
    add_struct(probes, "world", offsetof(ProbesParams, world), place);
    add_struct(probes, "placed", offsetof(ProbesParams, placed), place);
    const Offsets placed{MEMBER(PlacedProbe, position),  MEMBER(PlacedProbe, radius),
                         MEMBER(PlacedProbe, box_min),   MEMBER(PlacedProbe, edge),
                         MEMBER(PlacedProbe, box_max),   MEMBER(PlacedProbe, parallax),
                         MEMBER(PlacedProbe, layer),     MEMBER(PlacedProbe, old_layer),
                         MEMBER(PlacedProbe, newness),   MEMBER(PlacedProbe, weight),
                         MEMBER(PlacedProbe, seen_from), MEMBER(PlacedProbe, old_seen_from),
                         MEMBER(PlacedProbe, fog),       MEMBER(PlacedProbe, fog_albedo)};
    add_array<PlacedProbe>(probes, "probes", offsetof(ProbesParams, probes), MAX_PROBES, placed);
    expect_same(layout("probe_params.h", "ProbesParams"), probes, sizeof(ProbesParams));
}

TEST_F(ParamLayout, Media)
{
    Offsets expected;
    add_array<GridParams>(expected, "grids", offsetof(MediaParams, grids), MAX_GRIDS, kGrid);
    add_array<MediumParams>(expected, "media", offsetof(MediaParams, media), MAX_MEDIA, kMedium);
    add_array<NoiseOctave>(expected, "octaves", offsetof(MediaParams, octaves),
                           MAX_MEDIA * MAX_OCTAVES, kOctave);
    add_array<Island>(expected, "islands", offsetof(MediaParams, islands), MAX_ISLANDS, kIsland);
    expected.emplace("island_count", offsetof(MediaParams, island_count));
    expected.emplace("marched_light_dimming", offsetof(MediaParams, marched_light_dimming));
    expected.emplace("peak_g", offsetof(MediaParams, peak_g));
    expected.emplace("peak_straight", offsetof(MediaParams, peak_straight));
    expect_same(layout("medium_params.h", "MediaParams"), expected, sizeof(MediaParams));
}

TEST_F(ParamLayout, Transparent)
{
    Offsets expected{MEMBER(TransparentParams, clip_from_object),
                     MEMBER(TransparentParams, view_z_from_object),
                     MEMBER(TransparentParams, source),
                     MEMBER(TransparentParams, faded),
                     MEMBER(TransparentParams, fades),
                     MEMBER(TransparentParams, of_source),
                     MEMBER(TransparentParams, is_filter),
                     MEMBER(TransparentParams, of_behind),
                     MEMBER(TransparentParams, key),
                     MEMBER(TransparentParams, view_z),
                     MEMBER(TransparentParams, inverse_depth_fade),
                     MEMBER(TransparentParams, pane)};
    for (const auto& [name, offset] :
         Offsets{MEMBER(TransparentParams, cut), MEMBER(TransparentParams, cut_dx),
                 MEMBER(TransparentParams, cut_dy), MEMBER(TransparentParams, cut_sign)})
        expected.emplace(name + "[0]", offset);
    expect_same(layout("transparent_params.h", "TransparentParams"), expected,
                sizeof(TransparentParams));
}

TEST_F(ParamLayout, Panes)
{
    Offsets expected{MEMBER(PaneParams, view_z), MEMBER(PaneParams, count),
                     MEMBER(PaneParams, unused)};
    for (const auto& [name, offset] :
         Offsets{MEMBER(PaneParams, at), MEMBER(PaneParams, at_dx), MEMBER(PaneParams, at_dy),
                 MEMBER(PaneParams, emitted), MEMBER(PaneParams, kept)})
        expected.emplace(name + "[0]", offset);
    expect_same(layout("pane_params.h", "PaneParams"), expected, sizeof(PaneParams));
}

TEST_F(ParamLayout, Splits)
{
    expect_same(layout("split_params.h", "SplitParams"), split_members(), sizeof(SplitParams));
}

TEST_F(ParamLayout, HostsVolumeAt)
{
    Offsets expected{MEMBER(VolumeAtParams, kind), MEMBER(VolumeAtParams, layer_scale),
                     MEMBER(VolumeAtParams, transmittance), MEMBER(VolumeAtParams, tricubic)};
    add_struct(expected, "frame", offsetof(VolumeAtParams, frame), kFrame);
    add_struct(expected, "froxels", offsetof(VolumeAtParams, froxels), froxel_members());
    add_struct(expected, "splits", offsetof(VolumeAtParams, splits), split_members());
    expect_same(layout("volume_at_params.h", "VolumeAtParams"), expected, sizeof(VolumeAtParams));
}

TEST_F(ParamLayout, HostsTransparents)
{
    const Offsets expected{MEMBER(HostTransparentParams, view_z_from_depth),
                           MEMBER(HostTransparentParams, view_z_per_w),
                           MEMBER(HostTransparentParams, view_z_at_w),
                           MEMBER(HostTransparentParams, sky_depth),
                           MEMBER(HostTransparentParams, radiance_limit),
                           MEMBER(HostTransparentParams, first_draw),
                           MEMBER(HostTransparentParams, half_color),
                           MEMBER(HostTransparentParams, unused_x),
                           MEMBER(HostTransparentParams, unused_y)};
    expect_same(layout("host_transparent_params.h", "HostTransparentParams"), expected,
                sizeof(HostTransparentParams));
}

TEST_F(ParamLayout, EveryBlockFitsTheSmallestLimit)
{
    // GL 4.5 promises 16 KiB a block.
    EXPECT_LE(sizeof(FrameParams), 16384u);
    EXPECT_LE(sizeof(DrawParams), 16384u);
    EXPECT_LE(sizeof(LightsParams), 16384u);
    EXPECT_LE(sizeof(MediaParams), 16384u);
    EXPECT_LE(sizeof(LightVolumesParams), 16384u);
    EXPECT_LE(sizeof(IslandLightParams), 16384u);
    EXPECT_LE(sizeof(FieldParams), 16384u);
    EXPECT_LE(sizeof(TransparentParams), 16384u);
    EXPECT_LE(sizeof(SplitParams), 16384u);
    EXPECT_LE(sizeof(VolumeAtParams), 16384u);
}

/// Numbers that a float holds, and whole 32 bits in two of them.
std::array<float, 2> halves(std::uint32_t bits)
{
    return {static_cast<float>(bits >> 16), static_cast<float>(bits & 0xffffu)};
}

class SharedBits : public GlTest {};

TEST_F(SharedBits, ABrickPageIsTheSameOnBothSides)
{
    const Kernel kernel(gl(), R"(
#include "shared/brick_page.h"
void kernel(int i)
{
    uvec4 fields = uvec4(in_data[2 * i]);
    uint page = brick_page(fields.x, fields.y, fields.z, fields.w);
    uint given = uint(in_data[2 * i + 1].x) << 16u | uint(in_data[2 * i + 1].y);
    uint scale = page_scale_bits(given);
    out_data[3 * i] = vec4(page >> 16u, page & 0xffffu, is_brick(given), is_brick(page_constant_bits(given) >> 1u));
    out_data[3 * i + 1] = vec4(page_slot_x(given), page_slot_y(given), page_slot_z(given), scale >> 16u);
    out_data[3 * i + 2] = vec4(scale & 0xffffu, scale_step_above(scale), constant_page(scale) >> 16u,
                               constant_page(scale) & 0xffffu);
}
)",
                        2, 3);
    std::vector<glm::vec4> in;
    std::vector<glm::uvec4> all;
    for (const unsigned x : {0u, 1u, 127u, 255u})
        for (const unsigned y : {0u, 128u, 255u})
            for (const unsigned z : {0u, 85u, 255u})
                for (const unsigned step : {0u, 1u, 8u, 127u}) {
                    all.emplace_back(x, y, z, step);
                    const auto [high, low] = halves(brick_page(x, y, z, step));
                    in.emplace_back(all.back());
                    in.emplace_back(high, low, 0, 0);
                }
    const std::vector<glm::vec4> out = kernel(in);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const glm::uvec4 f = all[i];
        const auto [high, low] = halves(brick_page(f.x, f.y, f.z, f.w));
        const std::uint32_t scale = std::bit_cast<std::uint32_t>(1.0f) - (f.w << 20);
        const auto [scale_high, scale_low] = halves(scale);
        const auto [constant_high, constant_low] = halves(constant_page(scale));
        EXPECT_EQ(out[3 * i], glm::vec4(high, low, 1, 0));
        EXPECT_EQ(out[3 * i + 1], glm::vec4(f.x, f.y, f.z, scale_high));
        EXPECT_EQ(out[3 * i + 2], glm::vec4(scale_low, f.w, constant_high, constant_low));
    }
}

TEST_F(SharedBits, AStepTileIsTheSameOnBothSides)
{
    const Kernel kernel(gl(), R"(
#include "shared/probe_params.h"
#include "shared/split_params.h"
#include "shared/step_tile.h"
#include "shared/transparent_params.h"
void kernel(int i)
{
    ivec4 fields = ivec4(in_data[i]);
    uint place = tile_place(fields.x, fields.y, fields.z != 0);
    out_data[3 * i] = vec4(place >> 16u, place & 0xffffu, tile_first_split(place), tile_log2_width(place));
    uint keeps = place | kTileKeepsDepths;
    out_data[3 * i + 1] = vec4(tile_is_lit(keeps), tile_slot(keeps, fields.w), tile_keeps_depths(place),
                               tile_keeps_depths(keeps));
    uint shaded = place | tile_shaded(0x1a05u);
    out_data[3 * i + 2] = vec4(tile_stride(5u, 7u, place, fields.w), tile_stride(0x80000000u, 0u, place, fields.w),
                               tile_stride(0u, 8u, place, fields.w),
                               tile_shaded_points(shaded) + tile_slot(shaded, fields.w));
}
)",
                        1, 3);
    std::vector<glm::vec4> in;
    for (const int first : {0, 4, 4095})
        for (const int width : {0, 3, 12})
            for (const int lit : {0, 1})
                for (const int past : {-9, 0, 1, 7, 8, 40, 100000})
                    in.emplace_back(first, width, lit, first + past);
    const std::vector<glm::vec4> out = kernel(in);
    for (std::size_t i = 0; i < in.size(); ++i) {
        const glm::ivec4 f(in[i]);
        const std::uint32_t place = tile_place(f.x, f.y, f.z != 0);
        const auto [high, low] = halves(place);
        const int slot = std::clamp((f.w - f.x) >> f.y, 0, 31);
        EXPECT_EQ(out[3 * i], glm::vec4(high, low, f.x, f.y));
        EXPECT_EQ(out[3 * i + 1], glm::vec4(f.z, slot, 0, 1));
        EXPECT_EQ(tile_slot(place, f.w), slot);
        EXPECT_EQ(out[3 * i + 2],
                  glm::vec4(tile_stride(5, 7, place, f.w), tile_stride(0x80000000u, 0, place, f.w),
                            tile_stride(0, 8, place, f.w), 0x1a05 + slot));
        EXPECT_EQ(tile_shaded_points(place), 0u);
        EXPECT_EQ(tile_stride(5, 7, place, f.w), slot == 0 || slot == 2 ? 4 : slot == 1 ? 2 : 1);
    }
}

TEST_F(SharedBits, AFragmentsKeyIsTheSameOnBothSides)
{
    const Kernel kernel(gl(), R"(
#include "shared/transparent_params.h"
void kernel(int i)
{
    uvec4 fields = uvec4(in_data[i]);
    uint key = fragment_key_of_triangle(fragment_key(fields.x, fields.y, fields.z), fields.w);
    out_data[i] = vec4(key >> 16u, key & 0xffffu, fragment_source_factor(key), fragment_destination_factor(key));
}
)",
                        1, 1);
    std::vector<glm::vec4> in;
    for (const int draw : {0, 1, kMostDraws - 1})
        for (const int source : {0, 7, 10})
            for (const int destination : {0, 3, 10})
                for (const int triangle : {0, 5, 4095, 4096})
                    in.emplace_back(draw, source, destination, triangle);
    const std::vector<glm::vec4> out = kernel(in);
    for (std::size_t i = 0; i < in.size(); ++i) {
        const glm::uvec4 f(in[i]);
        const std::uint32_t key = fragment_key_of_triangle(fragment_key(f.x, f.y, f.z), f.w);
        const auto [high, low] = halves(key);
        EXPECT_EQ(out[i], glm::vec4(high, low, f.y, f.z));
        EXPECT_EQ(key >> 20, f.x);
    }
}

}  // namespace
}  // namespace fumarole::test
