#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "study/reference.h"

// A reference costs minutes, and what it depends on seldom changes: it is kept in a file that is
// named after all that it depends on.

namespace fumarole::study {

/// 16 hexadecimal digits of the text: FNV-1a (Fowler, Noll, Vo 1991), 64 bits. Against chance, not
/// against malice.
std::string text_hash(std::string_view text);

/// The same of a file's content. @throws Error naming the file.
std::string file_hash(const std::filesystem::path& file);

/// The scene as a file of JSON has it, with the content of each file that it names for its name.
/// Every grid of the scene comes from a file. @throws Error if a file can't be read.
std::string scene_by_content(const Scene& scene);

/// The version of a program and of the reference in it, which may give another answer to the same
/// question from one revision to the next.
std::string reference_version(std::string_view version);

/// Of all that a reference depends on: the scene, the content of the files that it names (not their
/// names), size, tolerance, samples of a pixel, bounces of both kinds, version.
/// @throws Error if a file can't be read.
std::string reference_key(const Scene& scene, const ReferenceOptions& options,
                          std::string_view version);

struct KeptReference {
    ReferenceStill still;
    std::filesystem::path file;  ///< an EXR with the channels of `fumarole render` and `error.Y`
    std::string key;
    bool reused = false;
    double seconds = 0;  ///< seconds that it took now
};

/// The file in `folder` of the reference of this key.
std::filesystem::path kept_reference_file(const std::filesystem::path& folder,
                                          std::string_view key);

/// The reference of a scene out of `folder`, or rendered and left there. A file that can't be read
/// or doesn't fit is made anew, and an unfinished one is gone on with (resume_reference).
/// @param tell is told of an unfinished one, a line at a time
/// @throws as render_reference, and Error if it can't be written.
KeptReference keep_reference(const Scene& scene, const ReferenceOptions& options,
                             const std::filesystem::path& folder, std::string_view version,
                             const std::function<void(const std::string&)>& tell);

}  // namespace fumarole::study
