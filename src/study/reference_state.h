#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "study/reference.h"

// A reference may take hours, and be interrupted or killed. The pixels that it has finished are
// kept in a file beside what it is for, and the next run of the same goes on from them. A pixel
// depends on no other, so the picture has the same bits as one that was never interrupted.

namespace fumarole::study {

/// What a reference depends on, by names that a person knows: `--tolerance`, `the scene's camera`.
using ReferenceFacts = std::map<std::string, std::string>;

/// Of the scene, the content of the files that it names (not their names), the options and the
/// version. @throws Error if a file can't be read.
ReferenceFacts reference_facts(const Scene& scene, const ReferenceOptions& options,
                               std::string_view version);

/// Where a reference is kept while it is unfinished, and what it is a reference of.
struct ReferenceState {
    std::filesystem::path file;
    ReferenceFacts facts;
    /// Is told what is gone on from, and why a file that is there is not: a line each.
    std::function<void(const std::string&)> tell;
};

/// The file of an unfinished reference, beside the file that the whole one will be in.
std::filesystem::path reference_state_file(const std::filesystem::path& output);

struct ResumedReference {
    ReferenceStill still;
    double resumed = 0;  ///< share of the pixels that an earlier run had finished, 0..1
};

/// As render_reference, and goes on from the file of `state` if that is whole and of the same
/// facts. The file is written anew every few seconds and when the work is cancelled; it stays, so
/// that it can be removed once the picture is safe. A file of other facts is left as it is for the
/// first 10 s. That it can't be written is told and ends nothing.
ResumedReference resume_reference(const Scene& scene, const ReferenceOptions& options,
                                  const ReferenceState& state);

}  // namespace fumarole::study
