#pragma once

#include <span>
#include <string>
#include <vector>

#include "study/bench.h"

namespace fumarole::study {

/// What this program sets itself, and what was measured.
struct BenchGoal {
    std::string text;  ///< `smoke: default is 10 times faster than eevee2017`
    double value = 0, bound = 0;
    bool at_least = false;  ///< else at most
    [[nodiscard]] bool held() const { return at_least ? value >= bound : value <= bound; }
};

/// The goals that these figures can answer, by medians: the default preset's time over eevee2017's
/// (10 where light is marched through the media, 3 where it has a closed form), its error not above
/// eevee2017's, 60 % of the texel rate in its march, a grid's bytes at most 1.5 times its values,
/// the first picture of a file within 1.5 s.
std::vector<BenchGoal> bench_goals(std::span<const BenchFigure> figures,
                                   std::span<const BenchScene> scenes);

inline constexpr std::string_view kMarchShare = "march, of the texel rate";
inline constexpr std::string_view kMarchLanes = "march, lanes at work of 4 x 4 rays";
inline constexpr std::string_view kMarchRate = "march, texels a second";
inline constexpr std::string_view kCompositeError = "composite's relMSE";
inline constexpr std::string_view kFirstPicture = "fumarole render, to the file written";

}  // namespace fumarole::study
