#pragma once

#include "study/reference.h"

// A chart has a time limit, and its reference is the one part whose time nobody knows beforehand.

namespace fumarole::study {

/// Tolerance beyond which a reference is none. Where light scatters on its pixels are noisy, and
/// their noise is known.
/// @param bounces of the media or of surfaces, whichever are more
constexpr double loosest_tolerance(int bounces)
{
    return bounces > 0 ? 0.3 : 0.1;
}

/// The next tolerance to try where one takes too long: four times as loose, or twice where light
/// scatters on, up to the loosest.
double looser(double tolerance, int bounces);

/// How long a reference takes [s], from one of an eighth of the size; infinity where that one alone
/// takes more than `patience` seconds.
/// @throws ReferenceCancelled as options.cancel asks
double guess_reference_seconds(const Scene& scene, const ReferenceOptions& options,
                               double patience);

/// The tolerance asked for, or the first looser one with which a reference takes about `seconds` at
/// most; the loosest if none does.
/// @throws ReferenceCancelled as options.cancel asks
double fit_tolerance(const Scene& scene, const ReferenceOptions& options, double seconds);

}  // namespace fumarole::study
