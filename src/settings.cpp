#include <fumarole/settings.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <type_traits>

#include <fumarole/errors.h>

namespace fumarole {

namespace {

/// How the library's errors name a setting: by the struct that holds it and its name in C++.
template <class T, typename V> std::string member_name(std::string_view name, V T::*)
{
    std::string member(name);
    std::replace(member.begin(), member.end(), '-', '_');
    constexpr bool kOfScene = std::is_same_v<T, SceneSettings>;
    static_assert(kOfScene || std::is_same_v<T, FrameSettings>);
    return fmt::format("{}::{}", kOfScene ? "SceneSettings" : "FrameSettings", member);
}

[[noreturn]] void refuse(std::string_view member, std::string_view text, std::string_view takes)
{
    throw Error(fmt::format("{}: '{}' is not one of its values; it takes {}", member, text, takes));
}

/// What to the library is a number, in [low, high].
template <typename V>
V parse_number(std::string_view member, std::string_view text, V low, V high,
               std::string_view takes)
{
    V value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() ||
        !(value >= low && value <= high))
        refuse(member, text, takes);
    return value;
}

struct Choice {
    std::string_view name;
    int value;
};

template <class T, typename V>
SettingInfo number(std::string_view name, std::string_view group, std::string_view values,
                   std::string_view unit, V T::*member, std::type_identity_t<V> low,
                   std::type_identity_t<V> high, std::string_view help)
{
    const std::string full_name = member_name(name, member);
    return {name,
            group,
            values,
            unit,
            help,
            full_name,
            [=](const Settings& s) { return fmt::format("{}", s.*member); },
            [=](Settings& s, std::string_view text) {
                s.*member = parse_number<V>(full_name, text, low, high, values);
            },
            [=](const Settings& s) { return s.*member >= low && s.*member <= high; }};
}

/// A setting of named values, or an integer that has names.
/// @param member_called the member's name where it is not the command line's
template <class T, typename V>
SettingInfo choice(std::string_view name, std::string_view group, std::string_view values,
                   V T::*member, const std::vector<Choice>& choices, std::string_view help,
                   std::string_view member_called = {})
{
    const std::string full_name = member_name(member_called.empty() ? name : member_called, member);
    return {name,
            group,
            values,
            "",
            help,
            full_name,
            [=](const Settings& s) {
                for (const Choice& c : choices)
                    if (c.value == static_cast<int>(s.*member))
                        return std::string(c.name);
                return fmt::format("{}", static_cast<int>(s.*member));
            },
            [=](Settings& s, std::string_view text) {
                for (const Choice& c : choices)
                    if (c.name == text) {
                        s.*member = static_cast<V>(c.value);
                        return;
                    }
                refuse(full_name, text, values);
            },
            [=](const Settings& s) {
                const int value = static_cast<int>(s.*member);
                return std::any_of(choices.begin(), choices.end(),
                                   [&](const Choice& c) { return c.value == value; });
            }};
}

/// A size that is chosen from the scene where it is auto.
SettingInfo automatic(std::string_view name, std::string_view values, std::string_view unit,
                      int SceneSettings::*member, int low, int high, std::string_view help)
{
    const std::string full_name = member_name(name, member);
    return {name,
            "light",
            values,
            unit,
            help,
            full_name,
            [=](const Settings& s) {
                return s.*member == kAutomatic ? "auto" : fmt::format("{}", s.*member);
            },
            [=](Settings& s, std::string_view text) {
                s.*member =
                    text == "auto" ? kAutomatic : parse_number(full_name, text, low, high, values);
            },
            [=](const Settings& s) {
                return s.*member == kAutomatic || (s.*member >= low && s.*member <= high);
            }};
}

/// What settings were called in 0.2. They are accepted by one release.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kOldNames{
    {{"skip", "empty-space-skipping"},
     {"early-end", "min-transmittance"},
     {"least-extinction", "min-extinction"},
     {"shadow-cache", "shadow-volume-size"},
     {"world-cache", "ambient-volume-size"}}};

template <typename T> constexpr int as_int(T value)
{
    return static_cast<int>(value);
}

std::vector<SettingInfo> make_table()
{
    using S = Settings;
    using medium::Layout;
    using medium::Storage;
    return {
        number("steps", "march", "1..4096", "", &S::steps, 1, 4096,
               "number of steps along the whole range of view depth"),
        number("distribution", "march", "0..1", "", &S::distribution, 0.0f, 1.0f,
               "spacing of steps and slices, from 0, linear, to 1, exponential; for perspective "
               "views only"),
        choice("jitter", "march", "none|blue", &S::jitter,
               {{"none", as_int(S::Jitter::none)}, {"blue", as_int(S::Jitter::blue)}},
               "where a step samples: at its middle, or offset by blue noise; froxels take "
               "Halton's points"),
        choice("range", "march", "media|camera", &S::range,
               {{"media", as_int(S::Range::media)}, {"camera", as_int(S::Range::camera)}},
               "where steps and slices are: where media are, cut exactly, or from near to far as "
               "in 2017"),
        number("g-clamp", "march", "0..0.9999", "", &S::g_clamp, 0.0f, 0.9999f,
               "largest |g| of the phase function"),
        choice("world-light", "march", "on|off", &S::world_light, {{"on", 1}, {"off", 0}},
               "whether the world's light scatters in the media"),
        number("min-extinction", "march", "0..1", "1/m", &S::min_extinction, 0.0f, 1.0f,
               "lower bound of the extinction; 2017 had 1e-4, everywhere"),
        choice(
            "empty-space-skipping", "march", "on|off", &S::empty_space_skipping,
            {{"on", 1}, {"off", 0}},
            "whether steps are left out in empty bricks, and the pass where no medium is in view"),
        number("min-transmittance", "march", "0..0.5", "", &S::min_transmittance, 0.0f, 0.5f,
               "early termination: a ray ends once less than this is transmitted"),
        choice("step-spacing", "march", "fixed|medium", &S::spacing,
               {{"fixed", as_int(S::Spacing::fixed)}, {"medium", as_int(S::Spacing::medium)}},
               "whether two or four steps become one where majorants are low", "spacing"),
        choice("falloff", "march", "exact|sampled", &S::falloff,
               {{"exact", as_int(S::Falloff::exact)}, {"sampled", as_int(S::Falloff::sampled)}},
               "light along a step: the mean of 1/d^2 over it, or its value at the step's sample"),
        choice("temporal", "march", "on|off", &S::temporal, {{"on", 1}, {"off", 0}},
               "temporal reprojection: whether a view's frames are averaged, by --history; a still "
               "gains nothing"),
        choice("passes", "march", "auto|fragment|compute", &S::passes,
               {{"auto", as_int(S::Passes::automatic)},
                {"fragment", as_int(S::Passes::fragment)},
                {"compute", as_int(S::Passes::compute)}},
               "whether march and resolve run as fragments or as compute shaders; auto: compute on "
               "a GPU"),
        choice("volume-shadows", "light", "on|off", &S::volume_shadows, {{"on", 1}, {"off", 0}},
               "whether media dim the light that reaches media and surfaces"),
        number("shadow-steps", "light", "1..1024", "", &S::shadow_steps, 1, 1024,
               "number of midpoint steps from a sample to a light, through each heterogeneous "
               "medium, where there is no --shadow-volume-size"),
        choice("shadow-range", "light", "media|light", &S::shadow_range,
               {{"media", as_int(S::ShadowRange::media)}, {"light", as_int(S::ShadowRange::light)}},
               "where shadow steps are spread: within the medium, or all the way to the light as "
               "in 2017"),
        automatic("shadow-map", "auto|16..8192", "texels", &S::shadow_map, 16, 8192,
                  "edge of each view of the surfaces' shadow map"),
        automatic("shadow-volume-size", "auto|0..512", "nodes", &S::shadow_volume_size, 0, 512,
                  "longest edge of the volume of optical depth for each light; 0: shadows are "
                  "marched at each sample"),
        number("shadow-fill", "light", "1..256", "frames", &S::shadow_fill, 1, 256,
               "number of frames over which a moved light's shadow volume is filled; the last one "
               "serves until then"),
        number("field-fill", "light", "1..256", "frames", &S::field_fill, 1, 256,
               "number of frames over which light that scatters again, the world's and that of "
               "flames and surfaces are filled after a change; the last serve until then, and fade "
               "over as many"),
        choice("field-start", "light", "first|before", &S::field_from_before,
               {{"first", 0}, {"before", 1}},
               "what light that scatters again starts from: what scatters first, or, in a playing "
               "sequence, what there was in the frame before"),
        automatic("ambient-volume-size", "auto|0..128", "nodes", &S::ambient_volume_size, 0, 128,
                  "longest edge of the volume of the world's light; 0: that light reaches media "
                  "undimmed"),
        choice("world-directions", "light", "auto|26|74", &S::world_directions,
               {{"auto", kAutomatic}, {"26", 26}, {"74", 74}},
               "number of directions that the world's light is summed over; auto: 26 where suns "
               "outshine a sky of one colour, else 74, as on surfaces that send light on"),
        automatic("bounces", "auto|0..64", "", &S::bounces, 0, 64,
                  "number of times that light scatters again in the media; auto: as often as the "
                  "scene asks for; the reference takes N or all, which is its default"),
        automatic("surface-bounces", "auto|0..16", "", &S::surface_bounces, 0, 16,
                  "number of times that surfaces send light on, onto each other and into the "
                  "media; auto: where some are glossy or shine or there are probes; the reference "
                  "takes N, all or auto, by which it has all or none"),
        choice("probes", "light", "auto|off", &S::probes,
               {{"auto", as_int(S::Probes::automatic)}, {"off", as_int(S::Probes::off)}},
               "whether a scene's probes light its surfaces; where it names none, some are "
               "placed in glossy balls and amid what else is glossy, if it pays"),
        choice("probe-update", "light", "still|always|never", &S::probe_update,
               {{"still", as_int(S::ProbeUpdate::still)},
                {"always", as_int(S::ProbeUpdate::always)},
                {"never", as_int(S::ProbeUpdate::never)}},
               "when a probe that is out of date is captured again, one a frame: while nothing "
               "moves, always, or never"),
        choice("resolution", "resolve", "auto|full|half|quarter", &S::resolution,
               {{"auto", S::kAutomatic}, {"full", 1}, {"half", 2}, {"quarter", 4}},
               "size of the march's layer; auto: half, or a quarter where media are smooth"),
        choice("upsample", "resolve", "4x4|2x2|4x4-box", &S::upsample,
               {{"4x4", as_int(S::Upsample::tent4x4)},
                {"2x2", as_int(S::Upsample::bilinear2x2)},
                {"4x4-box", as_int(S::Upsample::box4x4)}},
               "depth-aware filter of the layer: a tent, bilinear, or 2017's equal weights"),
        number("depth-threshold", "resolve", "1e-6..1e6", "", &S::depth_threshold, 1e-6f, 1e6f,
               "depth difference that the upsample takes for an edge: relative, or in metres with "
               "4x4-box"),
        choice("layer-depth", "resolve", "checkerboard|corner", &S::layer_depth,
               {{"checkerboard", as_int(S::LayerDepth::checkerboard)},
                {"corner", as_int(S::LayerDepth::corner)}},
               "which pixel's depth a half-size texel takes: nearest and farthest in turns, or one "
               "corner's"),
        number("resolve-passes", "resolve", "1|2", "", &S::resolve_passes, 1, 2,
               "whether transmittance and scattering are blended at once, or one after the other "
               "as in 2017"),
        choice("targets", "resolve", "auto|two|mono", &S::targets,
               {{"auto", as_int(S::Targets::automatic)},
                {"two", as_int(S::Targets::two)},
                {"mono", as_int(S::Targets::mono)}},
               "whether coloured transmittance has a target of its own, or its mean stands beside "
               "the scattering"),
        choice("target-format", "resolve", "r11g11b10f|rgba16f|rgba32f", &S::format,
               {{"r11g11b10f", as_int(S::Format::r11g11b10f)},
                {"rgba16f", as_int(S::Format::rgba16f)},
                {"rgba32f", as_int(S::Format::rgba32f)}},
               "format of the layer's targets and of the froxels' volumes", "format"),
        number("splits", "resolve", "2..64", "", &S::splits, 2, 64,
               "number of depths at which the march keeps what it has met, for transparents; a "
               "scene without has none"),
        choice("transparency", "resolve", "split|single|doubled", &S::transparency,
               {{"split", as_int(S::Transparency::split)},
                {"single", as_int(S::Transparency::single)},
                {"doubled", as_int(S::Transparency::doubled)}},
               "how transparents are blended through the media; all but split are wrong, kept as "
               "measures"),
        number("tile", "froxel", "1..64", "pixels", &S::tile, 1, 64, "edge of a froxel"),
        number("slices", "froxel", "1..1024", "", &S::slices, 1, 1024,
               "number of froxels along the whole range of view depth"),
        choice("slice-spacing", "froxel", "exponential|power|linear", &S::slice_spacing,
               {{"exponential", as_int(S::SliceSpacing::exponential)},
                {"power", as_int(S::SliceSpacing::power)},
                {"linear", as_int(S::SliceSpacing::linear)}},
               "spacing of slices, by --distribution; orthographic views have them linear"),
        number("history", "froxel", "0..0.999", "", &S::history, 0.0f, 0.999f,
               "weight of the last frame's froxels, and of the march's layer with --temporal, "
               "while the view moves; 0: no history is kept"),
        choice("history-format", "froxel", "auto|r11g11b10f|rgba16f|rgba32f", &S::history_format,
               {{"auto", as_int(S::Format::automatic)},
                {"r11g11b10f", as_int(S::Format::r11g11b10f)},
                {"rgba16f", as_int(S::Format::rgba16f)},
                {"rgba32f", as_int(S::Format::rgba32f)}},
               "format of what is kept from frame to frame; auto: rgba16f, which is dithered, of "
               "froxels unless --target-format is rgba32f, and rgba32f of the march"),
        choice(
            "froxel-shadows", "froxel", "media|grid", &S::froxel_shadows,
            {{"media", as_int(S::FroxelShadows::media)}, {"grid", as_int(S::FroxelShadows::grid)}},
            "what dims light: the media, or what the view's grid holds of them, as in 2017"),
        choice("lookup", "froxel", "trilinear|tricubic", &S::lookup,
               {{"trilinear", as_int(S::Lookup::trilinear)},
                {"tricubic", as_int(S::Lookup::tricubic)}},
               "interpolation between froxels: linear, or a cubic B-spline in 8 fetches"),
        choice("integration", "froxel", "hillaire|wronski", &S::integration,
               {{"hillaire", as_int(S::Integration::hillaire)},
                {"wronski", as_int(S::Integration::wronski)}},
               "how a slice is integrated: in closed form, or as Wronski did, which gains energy"),
        choice("storage", "medium", "auto|r32f|r16f|r8", &S::storage,
               {{"auto", as_int(Storage::automatic)},
                {"r32f", as_int(Storage::r32f)},
                {"r16f", as_int(Storage::r16f)},
                {"r8", as_int(Storage::r8)}},
               "format of a grid's values on the GPU; auto: bytes, in bricks with a scale of each, "
               "where they err little, else halves, or floats for a range that halves cannot hold"),
        choice("layout", "medium", "auto|dense|bricks", &S::layout,
               {{"auto", as_int(Layout::automatic)},
                {"dense", as_int(Layout::dense)},
                {"bricks", as_int(Layout::bricks)}},
               "where a grid's values are on the GPU: in one texture, or in an atlas of 8^3 bricks "
               "with a page table"),
        choice("noise-grid", "medium", "on|off", &S::noise_grid, {{"on", 1}, {"off", 0}},
               "whether noise that does not drift is read from a grid, where that takes at most 12 "
               "million voxels"),
    };
}

Settings eevee2017()
{
    Settings s;
    s.steps = 64;
    s.distribution = 0.8f;
    s.shadow_steps = 16;
    s.g_clamp = 0.999f;
    s.min_extinction = 1e-4f;
    s.empty_space_skipping = false;
    s.min_transmittance = 0;
    s.spacing = Settings::Spacing::fixed;
    s.falloff = Settings::Falloff::sampled;
    s.resolve_passes = 2;
    s.range = Settings::Range::camera;
    s.shadow_range = Settings::ShadowRange::light;
    s.shadow_map = 1024;
    s.shadow_volume_size = 0;
    s.ambient_volume_size = 0;
    s.bounces = 0;
    s.resolution = 2;
    s.upsample = Settings::Upsample::box4x4;
    s.depth_threshold = 0.05f;
    s.layer_depth = Settings::LayerDepth::corner;
    s.targets = Settings::Targets::two;
    s.format = Settings::Format::r11g11b10f;
    s.noise_grid = false;
    s.storage = medium::Storage::r16f;  // a baseline does not change with what automatic chooses
    return s;
}

Settings froxel()
{
    Settings s;
    s.mode = Settings::Mode::froxel;
    return s;
}

Settings eevee2017_froxel()
{
    Settings s = eevee2017();
    s.mode = Settings::Mode::froxel;
    s.tile = 8;
    s.slices = 64;
    s.history = 0.95f;
    s.history_format = Settings::Format::r11g11b10f;
    s.froxel_shadows = Settings::FroxelShadows::grid;
    return s;
}

}  // namespace

const std::vector<SettingInfo>& setting_table()
{
    static const std::vector<SettingInfo> table = make_table();
    return table;
}

namespace {

void check(const Settings& settings)
{
    for (const SettingInfo& info : setting_table())
        if (!info.holds(settings))
            refuse(info.member, info.get(settings), info.values);
}

}  // namespace

void check(const SceneSettings& settings)
{
    Settings all;
    static_cast<SceneSettings&>(all) = settings;
    check(all);
}

void check(const FrameSettings& settings)
{
    Settings all;
    static_cast<FrameSettings&>(all) = settings;
    check(all);
}

std::string_view present_name(std::string_view name)
{
    for (const auto& [old, present] : kOldNames)
        if (old == name)
            return present;
    return name;
}

const SettingInfo& find_setting(std::string_view given)
{
    const std::string_view name = present_name(given);
    std::vector<std::string_view> names;
    for (const SettingInfo& info : setting_table()) {
        if (info.name == name)
            return info;
        names.push_back(info.name);
    }
    throw Error(fmt::format("no setting '{}' (there are: {})", name, fmt::join(names, ", ")));
}

std::string_view mode_name(Settings::Mode mode)
{
    return mode == Settings::Mode::froxel ? "froxel" : "raymarch";
}

Settings::Mode find_mode(std::string_view name)
{
    for (const auto mode : {Settings::Mode::raymarch, Settings::Mode::froxel})
        if (mode_name(mode) == name)
            return mode;
    throw Error(
        fmt::format("FrameSettings::mode: no mode '{}' (there are: raymarch, froxel)", name));
}

const std::vector<std::pair<std::string_view, Settings>>& presets()
{
    static const std::vector<std::pair<std::string_view, Settings>> table{
        {"default", Settings{}},
        {"eevee2017", eevee2017()},
        {"froxel", froxel()},
        {"eevee2017-froxel", eevee2017_froxel()}};
    return table;
}

Settings find_preset(std::string_view name)
{
    std::vector<std::string_view> names;
    for (const auto& [preset, settings] : presets()) {
        if (preset == name)
            return settings;
        names.push_back(preset);
    }
    throw Error(fmt::format("no preset '{}' (there are: {})", name, fmt::join(names, ", ")));
}

}  // namespace fumarole
