#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <fumarole/export.h>

namespace fumarole::medium {

/// How a grid's values are kept on the GPU.
enum class Storage { automatic, r32f, r16f, r8 };
/// And where: in one dense 3-D texture, or in bricks.
enum class Layout { automatic, dense, bricks };

}  // namespace fumarole::medium

namespace fumarole {

/// What is chosen from the scene, or from a frame, where it stands for a number.
inline constexpr int kAutomatic = -1;

/// What trades speed for accuracy and lasts as long as a scene: what Renderer::set_scene() fills
/// and keeps by it. Another value takes another set_scene().
struct SceneSettings {
    enum class ShadowRange {
        media,  ///< shadow rays end where the medium or the light is
        light,  ///< 2017: all the way to a light that has a place, as if the medium filled it
    };

    // light through media
    bool volume_shadows = true;  ///< true: media dim the light that reaches media and surfaces
    ShadowRange shadow_range = ShadowRange::media;
    /// Texels along an edge of each shadow view, 16..8192; kAutomatic: 512 where no sun shines,
    /// 1024 in media that have detail of their own, 2048 in others.
    int shadow_map = kAutomatic;
    /// Nodes along the longest edge of the volume of optical depth towards each light, 0..512; 0:
    /// none, shadows are marched; kAutomatic: one to two a voxel, 96 at most, and
    /// up to 192 where much would lie between two.
    int shadow_volume_size = kAutomatic;
    int shadow_fill = 1;  ///< frames over which a moved light's volume is refilled, 1..256
    /// Frames over which light that is not direct is filled again, 1..256, while they show what was
    /// filled before, and those after them fade from it; 1: set_scene() fills it.
    int field_fill = 1;
    /// true: where only what grids hold is another than in the scene before, as from frame to frame
    /// of a sequence, light that scatters again starts from what it was there; within a relMSE of
    /// about 1e-6 of what it is by itself, in half the time. Not over frames (field_fill).
    bool field_from_before = false;
    bool world_light = true;  ///< true: the world's light scatters in the media too
    /// Nodes along the longest edge of the volume of the world's light, 0..128; 0: none, media
    /// don't dim it nor surfaces hide it; kAutomatic: one for 3 voxels, 32 at most.
    int ambient_volume_size = kAutomatic;
    /// Directions that the world's light is summed over, 26 or 74; kAutomatic: 26 where suns
    /// outshine a sky of one colour, and 74 on surfaces that send light on.
    int world_directions = kAutomatic;
    /// Orders of scattering after the first, 0..64; 0: light scatters once; kAutomatic: as many as
    /// the media's albedo and optical depth ask for. Those that are left out are guessed from the
    /// last two.
    int bounces = kAutomatic;
    /// Times that surfaces send light on, onto each other and into the media, 0..16; kAutomatic:
    /// as often as their albedo asks for where some are glossy or shine or there are probes, else
    /// 0. Needs an ambient_volume_size.
    int surface_bounces = kAutomatic;

    // light from all around on surfaces
    enum class Probes { automatic, off };
    /// The scene's probes light its surfaces. Where it names none and its glossy surfaces reflect
    /// enough of other surfaces and media, some are placed in them and amid them.
    Probes probes = Probes::automatic;
    enum class ProbeUpdate {
        still,   ///< a probe a frame, while neither the scene nor the camera moves
        always,  ///< a probe a frame that is out of date
        never,   ///< none, but by Renderer::update_probes()
    };
    ProbeUpdate probe_update = ProbeUpdate::still;

    // the medium on the GPU
    medium::Storage storage = medium::Storage::automatic;
    medium::Layout layout = medium::Layout::automatic;
    bool noise_grid = true;  ///< true: noise that does not drift is read from a grid if it fits

    bool operator==(const SceneSettings&) const = default;
};

/// What trades speed for accuracy and is every frame's own.
struct FrameSettings {
    enum class Mode {
        raymarch,  ///< a ray for each texel of a layer
        froxel,    ///< a grid in the view's frustum, kept from frame to frame
    };
    enum class Jitter { none, blue };
    enum class Range {
        media,   ///< march where media are; the first and last step are cut exactly
        camera,  ///< 2017: from near to far, sampled at each step's end, past the scene's depth;
                 ///< froxels: slices from near to far, none of them cut
    };
    enum class Targets { automatic, two, mono };
    enum class Format {
        r11g11b10f,
        rgba16f,
        rgba32f,
        automatic,  ///< of a history alone
    };
    enum class Upsample { tent4x4, bilinear2x2, box4x4 };
    enum class LayerDepth { checkerboard, corner };
    enum class SliceSpacing { exponential, power, linear };
    enum class FroxelShadows {
        media,  ///< the media themselves, in view or not
        grid,   ///< 2017: the V-buffer; what is out of view throws no shadow
    };
    enum class Lookup { trilinear, tricubic };
    enum class Integration { hillaire, wronski };
    enum class Spacing {
        fixed,   ///< the same along every ray
        medium,  ///< longer where little of the medium can lie in a ray's way
    };
    enum class Transparency {
        split,    ///< light scattered in before a transparent is kept apart from its blend
        single,   ///< one sum, whose scattered light is dimmed anew before each: dark edges
        doubled,  ///< two, each of which is given what a transparent emits: too bright
    };
    /// What the march, the layer's depth, the march's history and the resolve run as: the same
    /// pictures, but for rounding.
    enum class Passes {
        automatic,  ///< fragments on a software rasteriser (llvmpipe), compute on a GPU
        fragment,
        compute,  ///< the resolve where the picture's format is one that images may have
    };
    enum class Falloff {
        sampled,  ///< light is that at a step's sample, as in 2017
        exact,    ///< 1/d^2 is its mean over the step; other light is looked up where it counts
    };

    Mode mode = Mode::raymarch;
    Passes passes = Passes::automatic;

    // the march, and the froxels but for the number of steps
    int steps = 48;             ///< number of steps along the whole range, 1..4096
    float distribution = 0.8f;  ///< spacing of steps, lambda: 0 linear .. 1 exponential
    Jitter jitter = Jitter::blue;
    Range range = Range::media;
    float g_clamp = 0.999f;            ///< upper bound of |g|, 0..0.9999
    float min_extinction = 0;          ///< lower bound of sigma_t [1/m]; 2017 had 1e-4
    bool empty_space_skipping = true;  ///< true: no steps are taken in empty bricks
    float min_transmittance = 0;       ///< early termination below this transmittance, 0..0.5
    Spacing spacing = Spacing::medium;
    Falloff falloff = Falloff::exact;
    /// Midpoints on the way to a light, 1..1024, of each heterogeneous medium; where a volume of
    /// optical depth is (SceneSettings::shadow_volume_size) none are taken.
    int shadow_steps = 16;
    /// Temporal reprojection: a view's last frames are averaged with the next.
    bool temporal = false;

    // the layer and the resolve
    /// Pixels along a texel's edge: 1 full, 2 half, 4 quarter; kAutomatic: half, or a quarter where
    /// nothing of the media changes much within a texel of it.
    int resolution = kAutomatic;
    Upsample upsample = Upsample::bilinear2x2;
    float depth_threshold = 0.05f;  ///< depth difference that the upsample takes for an edge,
                                    ///< relative to depth; metres with box4x4
    LayerDepth layer_depth = LayerDepth::checkerboard;
    int resolve_passes = 1;  ///< 2: one for transmittance, then one for scattering, as in 2017
    Targets targets = Targets::automatic;
    Format format = Format::rgba16f;
    /// Depths, 2..64, at which a march keeps what it has met, where a scene has transparents.
    int splits = 16;
    /// How transparents are blended through the media; all but `split` are wrong, to be measured.
    Transparency transparency = Transparency::split;

    // the froxels
    int tile = 8;     ///< edge of a froxel [pixels], 1..64
    int slices = 64;  ///< number of slices along the whole range, 1..1024
    SliceSpacing slice_spacing = SliceSpacing::exponential;
    float history = 0.95f;  ///< weight of the history while the view moves, 0 for none
    /// Of what is kept from frame to frame. automatic: 16 bits, rounded by a dither, of froxels
    /// whose `format` has no more; 32 else.
    Format history_format = Format::automatic;
    FroxelShadows froxel_shadows = FroxelShadows::media;
    Lookup lookup = Lookup::trilinear;
    Integration integration = Integration::hillaire;

    /// Whether a view's frames build on those before them.
    [[nodiscard]] bool keeps_history() const
    {
        return history > 0 && (mode == Mode::froxel || temporal);
    }

    bool operator==(const FrameSettings&) const = default;
};

/// Both, for those who choose a scene's and a frame's in one: presets, the command line, studies.
/// The defaults are the preset `default`.
struct Settings : SceneSettings, FrameSettings {
    static constexpr int kAutomatic = fumarole::kAutomatic;
    bool operator==(const Settings&) const = default;
};

/// One setting as data: the command line, the files and the chart all read this table, so adding a
/// setting is adding a row.
struct SettingInfo {
    std::string_view name;    ///< as the command line spells it, without dashes
    std::string_view group;   ///< `march`, `light`, `resolve`, `froxel`, `medium`
    std::string_view values;  ///< `1..4096`, `none|blue`
    std::string_view unit;    ///< `1/m`, ..., or ""
    std::string_view help;    ///< one line
    std::string member;       ///< as the library's errors name it: `FrameSettings::steps`
    std::function<std::string(const Settings&)> get;
    /// @throws Error naming the setting and what it takes.
    std::function<void(Settings&, std::string_view)> set;
    /// True if the setting has one of its values.
    std::function<bool(const Settings&)> holds;
};

FUMAROLE_API const std::vector<SettingInfo>& setting_table();

/// @throws Error naming the first setting that is not one of its values, and what it takes. The
/// Renderer asks before it draws.
FUMAROLE_API void check(const SceneSettings& settings);
FUMAROLE_API void check(const FrameSettings& settings);

/// The name that a setting has now, of one that it had in the release before this (`skip`:
/// `empty-space-skipping`); any other word is returned as it is.
FUMAROLE_API std::string_view present_name(std::string_view name);

/// Takes a setting's present name, or the one that it had in the release before this.
/// @throws Error listing the names if there is no such setting.
FUMAROLE_API const SettingInfo& find_setting(std::string_view name);

/// A mode as `--mode` spells it, and back. @throws Error listing the modes if there is no such one.
FUMAROLE_API std::string_view mode_name(Settings::Mode mode);
FUMAROLE_API Settings::Mode find_mode(std::string_view name);

/// Settings by name: `default`, `eevee2017`, and both in froxels.
FUMAROLE_API const std::vector<std::pair<std::string_view, Settings>>& presets();

/// @throws Error listing the presets if there is no such one.
FUMAROLE_API Settings find_preset(std::string_view name);

}  // namespace fumarole
