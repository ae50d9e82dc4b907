#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "prepared_frame.h"
#include "shared/step_boxes.h"
#include "shared/step_tile.h"

namespace fumarole::pass {

/// The march's step lattice, cut into up to 64 slots of a power of two of its splits. A set of
/// them is 64 bits. Where the GPU works out the tiles, glsl/pass/step_view.glsl is a copy of
/// between(), joined() and tile(), which tests/gpu/step_tiles_test.cpp holds equal to them.
class StepSlots {
public:
    /// What a tile has to know of them.
    struct Held {
        std::uint64_t slots = 0;   ///< one bit for each slot that contains medium
        std::uint64_t shafts = 0;  ///< one bit for each slot in which a surface's shadow may end
        double longest = 0;        ///< step [m]; 0: as they are
        double longest_in_shaft = 0;
        double far_from = 0;  ///< step [m] that each light is far from; 0: none is
        /// Points and spots that a surface may hide from a part of them, a bit each in their order.
        std::uint32_t shaded = ~std::uint32_t{0};
        bool lit = false;  ///< no surface hides a light from any of them
    };

    explicit StepSlots(const PreparedFrame& frame);

    /// Those that view_z from low to high lies in. Outside the range the first and the last.
    [[nodiscard]] std::uint64_t between(double low, double high) const;
    [[nodiscard]] std::uint64_t all() const { return between(ends_.front(), ends_.back()); }
    [[nodiscard]] static std::uint64_t row(int first, int last)
    {
        return last > first ? ~std::uint64_t{0} >> (64 - (last - first)) << first : 0;
    }

    [[nodiscard]] int count() const { return static_cast<int>(ends_.size()) - 1; }
    /// Slots of the longest step.
    [[nodiscard]] int unit() const { return std::max(1, kMostJoined / width_); }
    /// Splits of a slot.
    [[nodiscard]] int width() const { return width_; }
    /// view_z [m] where a slot begins; the last ends at begin(count()).
    [[nodiscard]] double begin(int slot) const { return ends_[static_cast<std::size_t>(slot)]; }
    /// Of a slot's splits [m].
    [[nodiscard]] double length(int slot) const { return lengths_[static_cast<std::size_t>(slot)]; }

    /// The texel of a tile, in slots of its own: shared/step_tile.h.
    [[nodiscard]] glm::uvec4 tile(const Held& held) const;
    [[nodiscard]] static bool is_lit(const glm::uvec4& tile) { return shared::tile_is_lit(tile.w); }

private:
    static constexpr int kMost = STEP_SLOTS;
    static_assert(kMost == 64);
    static constexpr int kMostJoined = 4;

    /// Those whose splits, so many in one, are no longer than `longest`: splits grow with depth.
    [[nodiscard]] std::uint64_t joined(int many, double longest) const;

    int steps_, width_;
    std::vector<double> ends_;     ///< view_z [m], from the first slot's begin
    std::vector<double> lengths_;  ///< lengths of a slot's splits [m]
};

}  // namespace fumarole::pass
