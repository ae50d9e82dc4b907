#include "light/filled_light.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "light/lattice_ways.h"
#include "light/surface_turns.h"
#include "light/volume_tools.h"

namespace fumarole::light {

namespace {

/// Surfaces that send light on: a face has their number in 12 bits (glsl/light/faces.glsl).
constexpr std::size_t kMostSenders = 4095;

/// About what one more turn of the surfaces would add.
std::string further_turn(const WorldLight& light)
{
    // What turns add falls by one ratio at last.
    std::vector<double> sums;
    for (const gl::Texture& mean : light.bounced_means) {
        const std::vector<float> values = mean.read(3);
        sums.push_back(std::accumulate(values.begin(), values.end(), 0.0));
    }
    if (light.plan.field.turns < static_cast<int>(light.bounced_means.size()) || sums.size() < 2)
        return "";
    if (sums.size() < std::size_t{kNotedTurns})
        sums.insert(sums.begin(), 0.0);
    const std::size_t n = sums.size();
    const double before = sums[n - 2] - sums[n - 3], now = sums[n - 1] - sums[n - 2];
    if (!(before > 0) || !(sums[n - 1] > 0))
        return "";
    const double last = std::max(now, 0.0),
                 next = last * std::pow(last / before, 1 + light.turns_after_noted);
    return fmt::format(", a further one would add {:.2g} % of it", 100 * next / sums[n - 1]);
}

}  // namespace

std::string describe_orders(const RadianceField& field, bool in_all)
{
    const std::vector<glm::vec3> sums = field.sums();
    const glm::vec3 all = std::accumulate(sums.begin(), sums.end(), glm::vec3(0));
    const auto mean = [](glm::vec3 rgb) { return (rgb.r + rgb.g + rgb.b) / 3; };
    std::string line;
    if (in_all) {
        line = fmt::format("mean of all orders over what scatters: {:.2e} W/m^2/sr", mean(all));
    } else {
        line = "mean of each order over what scatters [W/m^2/sr]:";
        for (const glm::vec3& sum : sums)
            line += fmt::format(" {:.2e}", mean(sum));
        if (sums.size() > 1)
            line += fmt::format("; the last is {:.1g} % of all",
                                100 * std::abs(mean(sums.back())) / std::max(mean(all), 1e-30f));
    }
    if (const std::optional<float> left = field.left_over())
        line += fmt::format("; one more would change {:.1g} % of the guess", 100 * *left);
    return line;
}

std::vector<std::string> WorldLight::describe(const PlanReasons& why) const
{
    std::vector<std::string> lines;
    if (in_media())
        lines.push_back(fmt::format("world's light in the media: {} for {} harmonic{}",
                                    size_of(in_media(), plan.bands * plan.bands, 8),
                                    plan.bands * plan.bands,
                                    plan.bands == 1 ? "" : "s, turned to the eye"));
    if (on_surfaces)
        lines.push_back(fmt::format("world's light on surfaces: {}{}, 9 harmonics",
                                    size_of(on_surfaces, kSurfaceBands * kSurfaceBands, 8),
                                    on_surfaces_dimmed ? ", and again through the media" : ""));
    if (in_media() || on_surfaces)
        lines.push_back(fmt::format(
            "world's light: filled from {} directions, on surfaces {}{}{}", plan.world.ways,
            plan.world.ways_on_surfaces,
            plan.world.sky_in_parts ? fmt::format(", of each what {} see ({})", SKY_MAPS, why.sky)
                                    : "",
            filled_in(ms)));
    if (plan.glow_on_surfaces > 0 && field_coefficients && plan.field.turns == 0)
        lines.push_back(fmt::format(
            "what media scatter onto surfaces: along {} (of what reaches those, {:.1g} comes from "
            "media){}",
            plan.along_rays() ? "rays to all of them" : fmt::format("{} directions", kNearWays),
            plan.glow_on_surfaces,
            plan.world.lit_beyond ? ", and beyond the nodes as from the media's middle" : ""));
    if (bounced)
        lines.push_back(fmt::format("light that surfaces send on: {} turn{} ({}){}{}",
                                    plan.field.turns, plan.field.turns == 1 ? "" : "s", why.turns,
                                    further_turn(*this),
                                    plan.field.surfaces.size() > kMostSenders
                                        ? fmt::format("; of {} surfaces the first {}",
                                                      plan.field.surfaces.size(), kMostSenders)
                                        : ""));
    else if (!why.turns.empty())
        lines.push_back(fmt::format("light that surfaces send on: none ({})", why.turns));
    const FieldOrders orders = orders_to_go(plan.field.orders, goes_on ? OrdersStart::From::arrived
                                                                       : OrdersStart::From::lights);
    if (!why.orders.empty())
        lines.push_back(fmt::format(
            "light that scatters again: {} order{}{}{} ({}){}", orders.count,
            orders.count == 1 ? "" : "s", orders.cycles > 0 ? " and a guess at the rest" : "",
            goes_on               ? ", from the light that was there before"
            : orders.coarse_first ? ", from where a coarser lattice gets"
                                  : "",
            why.orders,
            plan.field.orders.straight_on > 0
                ? fmt::format("; {:.0f} % of the extinction scatters straight on, and "
                              "counts as light that goes on",
                              100 * plan.field.orders.straight_on)
                : ""));
    return lines;
}

}  // namespace fumarole::light
