#include "pass/fine_tiles.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "light_fields.h"
#include "pass/step_tiles.h"

namespace fumarole::pass {

namespace {

/// Where the media's phase has a peak, towards a sun or away from it, and how far from there it
/// changes within a texel.
struct Lobe {
    glm::dvec3 axis;
    double reach;  ///< [rad]
};

/// The lobe is ((1 - g)^2 + g theta^2)^(-3/2), about: the root is what it changes within, of which
/// a texel may span a twentieth, as where a whole layer is made coarser.
constexpr double kOfLobe = 0.05;

std::vector<Lobe> steep_lobes(const Toolbox& tools, double texel)
{
    std::vector<Lobe> lobes;
    const medium::MediaTraits& media = tools.media.traits();
    const double g = media.most_g;
    if (!media.scatters || g <= 0)
        return lobes;
    const double reach2 = (texel / kOfLobe) * (texel / kOfLobe) - (1 - g) * (1 - g) / g;
    if (!(reach2 > 0))
        return lobes;
    for (const LightPosition& light : tools.lights.points()) {
        if (!light.far)
            continue;
        const glm::dvec3 to_light = glm::normalize(light.at);
        if (media.mixed_g || media.g > 0)
            lobes.push_back({to_light, std::sqrt(reach2)});
        if (media.mixed_g || media.g < 0)
            lobes.push_back({-to_light, std::sqrt(reach2)});
    }
    return lobes;
}

/// Points among the media, in pixels. What a ray sees of one is as one over its distance.
std::vector<glm::dvec2> lamps_in_view(const Toolbox& tools, const PreparedFrame& frame)
{
    std::vector<glm::dvec2> lamps;
    if (!tools.media.traits().scatters)
        return lamps;
    for (const Light& light : tools.lights.lights()) {
        // A spot's beam has edges, whose grain a texel's neighbours average.
        if (!std::holds_alternative<PointLight>(light))
            continue;
        const glm::dvec3 at = position_of(light).at;
        if (glm::any(glm::lessThan(at, frame.media.min)) ||
            glm::any(glm::greaterThan(at, frame.media.max)))
            continue;
        const glm::dvec4 view = frame.host.view_from_world * glm::dvec4(at, 1.0);
        const glm::dvec4 clip = frame.host.clip_from_view * view;
        const glm::dvec2 pixel =
            (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * glm::dvec2(frame.picture_size);
        if (frame.prepares || (-view.z > frame.eye.near && clip.w > 0))
            lamps.push_back(pixel);
    }
    return lamps;
}

}  // namespace

std::vector<bool> fine_tiles(const Toolbox& tools, const PreparedFrame& frame)
{
    const FrameSettings& s = frame.settings;
    const DepthsAsked& asked = frame.depths_asked;
    // What a history averages is the layer's, transparents ask it what is before them, and 2017
    // knew nothing of finer ones.
    if (s.mode != Settings::Mode::raymarch || s.keeps_history() ||
        s.range == Settings::Range::camera || frame.panes > 0 || !asked.areas.empty() ||
        !asked.view_z.empty())
        return {};
    const double pixel = 2 / (std::abs(frame.host.clip_from_view[1][1]) * frame.picture_size.y);
    std::vector<Lobe> lobes;
    if (frame.eye.perspective)  // of parallel rays all see one phase
        lobes = steep_lobes(tools, pixel * s.resolution);
    std::vector<glm::dvec2> lamps;
    if (s.falloff == Settings::Falloff::exact)
        lamps = lamps_in_view(tools, frame);
    const auto from_axis = [](const Lobe& lobe, glm::dvec3 direction) {
        return std::acos(std::clamp(glm::dot(lobe.axis, direction), -1.0, 1.0));
    };
    const auto direction = [&](glm::dvec2 ndc) {
        return glm::normalize(frame.rays.direction + frame.rays.direction_dx * ndc.x +
                              frame.rays.direction_dy * ndc.y);
    };
    const ViewCone cone = view_cone(frame.rays);
    if (!frame.prepares)
        std::erase_if(lobes, [&](const Lobe& lobe) {
            return from_axis(lobe, cone.axis) > lobe.reach + cone.half_angle;
        });
    constexpr double kNearTexels = 8;  // between a lamp and a ray whose neighbours are alike
    constexpr int kTile = StepTiles::kPictureTile;
    const double around = kNearTexels * s.resolution + 0.5 * std::sqrt(2.0) * kTile;
    if (!frame.prepares)
        std::erase_if(lamps, [&](glm::dvec2 lamp) {
            return glm::any(glm::lessThan(lamp, glm::dvec2(-around))) ||
                   glm::any(glm::greaterThan(lamp, glm::dvec2(frame.picture_size) + around));
        });
    if (lobes.empty() && lamps.empty())
        return {};
    const double half = 0.5 * std::sqrt(2.0) * kTile * pixel;  // from a tile's middle to its corner
    const glm::ivec2 count = (frame.picture_size + kTile - 1) / kTile;
    std::vector<bool> fine;
    fine.reserve(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y));
    for (int y = 0; y < count.y; ++y)
        for (int x = 0; x < count.x; ++x) {
            const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) * double{kTile};
            const glm::dvec3 ray = direction(at / glm::dvec2(frame.picture_size) * 2.0 - 1.0);
            fine.push_back(frame.prepares ||
                           std::ranges::any_of(lobes,
                                               [&](const Lobe& lobe) {
                                                   return from_axis(lobe, ray) <= lobe.reach + half;
                                               }) ||
                           std::ranges::any_of(lamps, [&](glm::dvec2 lamp) {
                               return glm::length(lamp - at) <= around;
                           }));
        }
    if (std::ranges::find(fine, true) == fine.end())
        fine.clear();
    return fine;
}

}  // namespace fumarole::pass
