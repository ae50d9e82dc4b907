#include "explain.h"

#include <algorithm>
#include <fmt/format.h>
#include <span>

#include "light_fields.h"
#include "pass/froxels.h"
#include "pass/ray_march.h"
#include "scene_words.h"

namespace fumarole {

namespace {

/// `1 sun, 2 spot`
std::string counts_of(std::span<const Light> lights)
{
    std::string text;
    for (const Light& type : light_types()) {
        const auto same = [&](const Light& light) { return light.index() == type.index(); };
        if (const auto count = std::count_if(lights.begin(), lights.end(), same); count > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, light_name(type));
    }
    return text;
}

std::string reason_text(const LayerChoice& layer)
{
    constexpr std::string_view kOfGrids = "a voxel, or less where it is thick or glows";
    switch (layer.reason) {
    case LayerReason::history:
        return "as another would drop the history";
    case LayerReason::lobe:
        return "as the phase changes within a texel of a quarter";
    case LayerReason::beam:
        return "as a quarter would blur the edge of a beam, or what is beside a lamp in the media";
    case LayerReason::profile:
        return "as media that are no grid's change within a texel of a quarter";
    case LayerReason::outline:
        return "as the media's outline is in the picture";
    case LayerReason::voxels:
        return fmt::format("as a quarter's texels would be {:.2f} times as wide as what a grid "
                           "changes within ({}), {} at most",
                           layer.of_voxel, kOfGrids, LayerChoice::kMostOfVoxel);
    case LayerReason::held:
        return "as the view had in the frame before, until a quarter would do by a tenth more";
    default:
        return layer.of_voxel > 0
                   ? fmt::format("as its texels are {:.2f} times as wide as what a grid changes "
                                 "within ({})",
                                 layer.of_voxel, kOfGrids)
                   : "as a texel of it spans little of what the media, and the light that they "
                     "scatter, change within";
    }
}

std::string layer_text(const FrameSettings& settings, const LayerChoice& layer)
{
    const auto name = [](int scale) {
        return scale == 1 ? "full" : scale == 2 ? "half" : "a quarter";
    };
    if (settings.resolution == kAutomatic && layer.scale > 0)
        return fmt::format("{} in the last frame, {}", name(layer.scale), reason_text(layer));
    if (settings.resolution == kAutomatic)
        return "half, or a quarter where a texel of that spans little of what the media, and the "
               "light that they scatter, change within";
    if (layer.scale == 0)
        return name(settings.resolution);
    if (layer.scale == settings.resolution)
        return fmt::format("{}, {}", name(layer.scale), reason_text(layer));
    return fmt::format("{}, where frames are averaged; one by itself has {}, {}",
                       name(settings.resolution), name(layer.scale), reason_text(layer));
}

}  // namespace

std::vector<std::string> explain(const Toolbox& tools, int surfaces, const FrameSettings& settings,
                                 const LayerChoice& layer)
{
    const medium::MediaTraits& media = tools.media.traits();
    const light::LightSet& lights = tools.lights;
    std::vector<std::string> lines;
    const auto say = [&]<typename... T>(fmt::format_string<T...> text, T&&... arguments) {
        lines.push_back(fmt::format(text, std::forward<T>(arguments)...));
    };
    if (media.media == 0) {
        say("no medium scatters, absorbs or emits: nothing is drawn, the picture keeps its bits");
        if (surfaces > 0 && tools.scene_settings.surface_bounces != 0)
            say("light that surfaces send on: none: the volume that carries it is that of media");
        return lines;
    }
    say("media: {}, of which {} change from place to place; others need no fetch and no shadow "
        "steps",
        media.media, media.heterogeneous);
    const bool froxel = settings.mode == Settings::Mode::froxel;
    if (froxel)
        for (const std::string& line : pass::explain_froxels(tools, settings))
            lines.push_back(line);
    else if (tools.monochrome(settings))
        say("{}{}", words::kGreyExtinction,
            media.colored_extinction ? "; it is coloured, and its mean was asked for" : "");
    else if (media.colored_extinction)
        say("{}, {}", words::kColoredExtinction,
            settings.resolve_passes == 1 ? "blended at once with the scattering" : "two upsamples");
    else
        say("extinction: grey, but two targets were asked for: one of its own for transmittance, "
            "{}",
            settings.resolve_passes == 1 ? "blended at once with the scattering" : "two upsamples");
    if (!froxel && pass::march_format(tools, settings) != settings.format)
        say("target format: rgba16f, since r11g11b10f has no alpha");
    say("passes: {}, {}", tools.computes(settings) ? "compute shaders" : "fragments",
        settings.passes != Settings::Passes::automatic ? "as asked"
        : tools.device.capabilities().software ? "as on a software rasteriser compute is slower"
                                               : "as GPUs compute faster than they draw");
    if (!froxel)
        say("resolution: {}", layer_text(settings, layer));
    if (!froxel && settings.keeps_history())
        say("history: a view's layer is reprojected and weighs {} while the view moves, and is the "
            "mean of all frames while it stands; a frame of no view has none",
            settings.history);
    say("{}", media.isotropic ? words::kIsotropic
              : media.mixed_g
                  ? "phase: media differ in g: its mean, weighted by sigma_s, per sample"
                  : "phase: one g for all media");
    say("{}", media.blackbody  ? "emission: yes, of a temperature by Stefan and Boltzmann in the "
                                 "colour of Planck's law"
              : media.emission ? "emission: yes"
                               : words::kNoEmission);
    if (lights.count() == 0)
        say("{}", words::kNoLights);
    else
        say("lights: {}{}", counts_of(lights.lights()),
            lights.flames() == 0 ? ""
            : lights.flames() == 1
                ? ", of which one is a flame's light"
                : fmt::format(", of which {} are the light of flames", lights.flames()));
    if (lights.count() > 0 && lights.shadow_views() == 0)
        say("{}", words::kNoSurfaces);
    else if (lights.count() > 0)
        say("surfaces: {} in {} views of the shadow map, {}", surfaces, lights.shadow_views(),
            froxel || !settings.empty_space_skipping || settings.range == Settings::Range::camera
                ? "looked up at each sample"
            : !lights.shaded_media() ? "but none can stand between a light and the media: no lookup"
                                     : "looked up where tiles are not lit all along");
    if (const light::LightFilters& filters = lights.filters(); filters.any())
        say("transparents that cast: {} view{} of what they let through of the lights, {} "
            "layer{} each, looked up at each sample",
            filters.views(), filters.views() == 1 ? "" : "s", filters.layers(),
            filters.layers() == 1 ? "" : "s");
    if (lights.count() > 0) {
        if (!tools.scene_settings.volume_shadows)
            say("light through media: undimmed, as asked");
        else if (froxel && settings.froxel_shadows == Settings::FroxelShadows::grid)
            say("light through media: {} steps a froxel and light through the V-buffer; what is "
                "out "
                "of view throws no shadow",
                settings.shadow_steps);
        else if (media.heterogeneous == 0)
            say("{}", words::kHomogeneous);
        else if (tools.volumes.depths())
            say("light through media: from a volume for marched media; closed form where a medium "
                "is homogeneous or falls off with height");
        else
            say("light through media: {} steps a sample, light and marched medium; closed form "
                "where "
                "a medium is homogeneous or falls off with height",
                settings.shadow_steps);
    }
    const bool world = lights.world_radiance() != glm::vec3(0.0f);
    say("{}", !world ? words::kBlackWorld
              : tools.volumes.has_world()
                  ? "world: scatters from all around, dimmed by media and hidden by surfaces"
              : tools.scene_settings.world_light
                  ? "world: its mean radiance scatters, isotropic and undimmed"
                  : "world: left out of the media, as asked");
    for (const auto& more : {tools.volumes.describe(), tools.media.describe()})
        lines.insert(lines.end(), more.begin(), more.end());
    return lines;
}

}  // namespace fumarole
