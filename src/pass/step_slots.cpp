#include "pass/step_slots.h"

#include <algorithm>
#include <bit>

namespace fumarole::pass {

namespace {

int power_of_two(int least)
{
    return static_cast<int>(std::bit_ceil(static_cast<unsigned>(least)));
}

}  // namespace

StepSlots::StepSlots(const PreparedFrame& frame)
    : steps_{frame.settings.steps}, width_{power_of_two((steps_ + kMost - 1) / kMost)}
{
    const glm::dvec2 range = frame.step_range;
    const double lambda = frame.eye.perspective ? frame.settings.distribution : 0;
    for (int i = 0; i < steps_ + width_; i += width_) {
        // glsl/lib/step_lattice.glsl
        const double progress = std::min(1.0, static_cast<double>(i) / steps_);
        const double bent = range.x * std::pow(range.y / range.x, lambda > 0 ? progress : 0);
        ends_.push_back(glm::mix(glm::mix(range.x, range.y, progress), bent, lambda));
        if (i > 0)
            lengths_.push_back((ends_.back() - ends_.end()[-2]) /
                               std::min(width_, steps_ - i + width_));
    }
}

std::uint64_t StepSlots::between(double low, double high) const
{
    const auto first = std::upper_bound(ends_.begin() + 1, ends_.end() - 1, low);
    const auto last = std::lower_bound(first, ends_.end() - 1, high);
    return row(static_cast<int>(first - ends_.begin()) - 1, static_cast<int>(last - ends_.begin()));
}

std::uint64_t StepSlots::joined(int many, double longest) const
{
    const auto end = std::partition_point(lengths_.begin(), lengths_.end(),
                                          [&](double length) { return many * length <= longest; });
    const int splits = static_cast<int>(end - lengths_.begin()) * width_ & -many;
    return row(0, splits / width_);
}

glm::uvec4 StepSlots::tile(const Held& held) const
{
    if (held.slots == 0)
        return glm::uvec4(0);
    const auto taken = [&](int many) {
        return (joined(many, held.longest) & ~held.shafts) |
               (joined(many, held.longest_in_shaft) & held.shafts);
    };
    const std::uint64_t fours = taken(4), twos = taken(2);
    const int first = std::countr_zero(held.slots), end = 64 - std::countl_zero(held.slots);
    int width = std::max(width_, (fours & held.slots) != 0 ? 4 : (twos & held.slots) != 0 ? 2 : 1);
    const auto base = [&] { return first * width_ & -width; };
    while (end * width_ - base() > shared::kTileSlots * width)
        width *= 2;
    const int slots = width / width_;
    const std::uint64_t one = row(0, slots);
    const int log2_width = std::countr_zero(static_cast<unsigned>(width));
    glm::uvec4 texel(0, 0, 0,
                     shared::tile_place(base(), log2_width, held.lit) |
                         shared::tile_shaded(held.shaded | held.shaded >> shared::kTilePoints));
    const int most_joined = (fours & held.slots) != 0 ? 4 : (twos & held.slots) != 0 ? 2 : 1;
    if (most_joined * length(end - 1) <= held.far_from)
        texel.w |= shared::kTileIsFar;
    std::uint32_t bit = 1;
    for (int i = base() / width_; i < end; i += slots, bit <<= 1) {
        const std::uint64_t these = one << i;
        if ((held.slots & these) == 0)
            continue;
        texel.x |= bit;
        // A lattice ends where it does: what is left of a slot may be taken as one.
        const std::uint64_t real = these & all();
        if ((fours & real) == real)
            texel.y |= bit;
        else if ((twos & real) == real)
            texel.z |= bit;
    }
    return texel;
}

}  // namespace fumarole::pass
