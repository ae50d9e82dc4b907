#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "medium/grid_layout.h"

namespace fumarole {

/// What trades speed for accuracy. The defaults are the preset `default`.
struct Settings {
    enum class Jitter { none, blue };
    enum class Range {
        media,   ///< march where media are; the first and last step are cut exactly
        camera,  ///< 2017: from near to far, sampled at each step's end, past the scene's depth
    };
    enum class ShadowRange {
        media,  ///< shadow rays end where the medium or the light is
        light,  ///< 2017: all the way to a light that has a place, as if the medium filled it
    };
    enum class Targets { automatic, two, mono };
    enum class Format { r11g11b10f, rgba16f, rgba32f };
    enum class Upsample { tent4x4, bilinear2x2, box4x4 };
    enum class LayerDepth { checkerboard, corner };

    // the march
    int steps = 64;             ///< along the whole range, 1..4096
    float distribution = 0.8f;  ///< lambda: 0 linear .. 1 exponential
    Jitter jitter = Jitter::blue;
    Range range = Range::media;
    float g_clamp = 0.999f;      ///< |g| is held to this, 0..0.9999
    bool world_light = true;     ///< the world's mean radiance scatters too
    float least_extinction = 0;  ///< 1/m, a floor under sigma_t; 2017 had 1e-4

    // light through media
    bool volume_shadows = true;
    int shadow_steps = 16;  ///< midpoints on the way to a light, 1..1024
    ShadowRange shadow_range = ShadowRange::media;
    int shadow_map = 1024;  ///< texels along an edge of each view, 16..8192

    // the layer and the resolve
    int resolution = 2;  ///< pixels along a texel's edge: 1 full, 2 half, 4 quarter
    Upsample upsample = Upsample::bilinear2x2;
    float depth_threshold = 0.05f;  ///< relative to depth; metres with box4x4
    LayerDepth layer_depth = LayerDepth::checkerboard;
    Targets targets = Targets::automatic;
    Format format = Format::rgba16f;

    // the medium on the GPU
    medium::Storage storage = medium::Storage::automatic;
    medium::Layout layout = medium::Layout::automatic;

    bool operator==(const Settings&) const = default;
};

/// One setting as data: the command line, the files and the chart all read this table, so adding a
/// setting is adding a row.
struct SettingInfo {
    std::string_view name;    ///< as the command line spells it, without dashes
    std::string_view group;   ///< `march`, `light`, `resolve`, `medium`
    std::string_view values;  ///< `1..4096`, `none|blue`
    std::string_view unit;    ///< `1/m`, ..., or ""
    std::string_view help;    ///< one line
    std::function<std::string(const Settings&)> get;
    /// @throws Error naming the setting and what it takes.
    std::function<void(Settings&, std::string_view)> set;
};

const std::vector<SettingInfo>& setting_table();

/// @throws Error listing the names if there is no such setting.
const SettingInfo& find_setting(std::string_view name);

/// Settings by name: `default`, `eevee2017`.
const std::vector<std::pair<std::string_view, Settings>>& presets();

/// @throws Error listing the presets if there is no such one.
Settings find_preset(std::string_view name);

}  // namespace fumarole
