#include "transparent/split_depths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace fumarole::transparent {

namespace {

constexpr std::size_t kBins = 256;

/// The largest majorant [1/m] in each of the bins that [begin, end] is cut into.
std::array<double, kBins> majorants(std::span<const medium::Occupied> occupied,
                                    const PreparedFrame& frame, double begin, double end)
{
    std::array<double, kBins> bins{};
    const double per_metre = kBins / (end - begin);
    double finite = 0;
    for (const medium::Occupied& part : occupied)
        for (const medium::OccupiedBox& box : part.boxes)
            if (std::isfinite(box.most))
                finite = std::max(finite, static_cast<double>(box.most));
    for (const medium::Occupied& part : occupied) {
        const glm::dmat4 view_from_box = frame.host.view_from_world * part.world_from_box;
        const glm::dvec3 across(view_from_box[0].z, view_from_box[1].z, view_from_box[2].z);
        for (const medium::OccupiedBox& box : part.boxes) {
            const glm::dvec3 middle = (box.bounds.min + box.bounds.max) / 2.0;
            const double z = -(glm::dot(across, middle) + view_from_box[3].z);
            const double half = glm::dot(glm::abs(across), (box.bounds.max - box.bounds.min) / 2.0);
            // What glows has no majorant: it counts as the thickest.
            const double most =
                std::isfinite(box.most) ? static_cast<double>(box.most) : std::max(finite, 1e-30);
            const double first = std::floor((z - half - begin) * per_metre);
            const double last = std::floor((z + half - begin) * per_metre);
            if (last < 0 || first >= kBins)
                continue;
            for (auto i = static_cast<std::size_t>(std::max(first, 0.0));
                 i <= static_cast<std::size_t>(std::min(last, kBins - 1.0)); ++i)
                bins.at(i) = std::max(bins.at(i), most);
        }
    }
    return bins;
}

}  // namespace

std::vector<float> split_depths(std::span<const medium::Occupied> occupied,
                                const PreparedFrame& frame, glm::dvec2 asked, int count)
{
    const double begin = std::max(asked.x, frame.media_range.x);
    const double end = std::min(asked.y, frame.media_range.y);
    std::vector<float> depths;
    if (!(begin < end)) {
        // All of it lies before the media, or behind them.
        const auto at =
            static_cast<float>(std::clamp(asked.x, frame.media_range.x, frame.media_range.y));
        return {at, std::nextafter(at, 3e38f)};
    }
    std::array<double, kBins> bins = majorants(occupied, frame, begin, end);
    const double sum = std::accumulate(bins.begin(), bins.end(), 0.0);
    constexpr double kByMajorant = 0.5;
    for (double& bin : bins)
        bin = (sum > 0 ? kByMajorant * bin / sum : 0.0) + (1 - kByMajorant) / kBins;
    const double all = std::accumulate(bins.begin(), bins.end(), 0.0);
    double before = 0;
    std::size_t bin = 0;
    for (int k = 0; k < count; ++k) {
        const double wanted = all * k / (count - 1);
        while (bin + 1 < kBins && before + bins.at(bin) < wanted)
            before += bins.at(bin++);
        const double share = std::clamp((wanted - before) / bins.at(bin), 0.0, 1.0);
        depths.push_back(
            static_cast<float>(glm::mix(begin, end, (static_cast<double>(bin) + share) / kBins)));
    }
    return depths;
}

}  // namespace fumarole::transparent
