#pragma once

#include <cstddef>

namespace fumarole::study {

/// A share of a list of work: every `count`th item, of which the first is `index`, from 1.
struct Shard {
    std::size_t index = 1, count = 1;

    [[nodiscard]] bool has(std::size_t item) const { return item % count + 1 == index; }
};

}  // namespace fumarole::study
