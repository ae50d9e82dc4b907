#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fumarole/asset/vdb_file.h>
#include <fumarole/export.h>
#include <fumarole/scene.h>

// What the files of a sequence hold, all of them: a simulation's first frames are often empty, and
// its fire is lit later.

namespace fumarole::asset {

struct SequenceFrame {
    int frame = 0;
    VdbInfo file;       ///< what read_vdb_headers() says of the file
    std::string error;  ///< "", or why it can't be read
};

/// The frames of a sequence that are there, ascending, from the files' headers alone.
/// @throws Error if there is none, or none that can be read
FUMAROLE_API std::vector<SequenceFrame> read_sequence(const std::filesystem::path& pattern);

/// All grids that any frame has, as of one file: voxels are counted over all frames. Beside a grid
/// stands what the first frame says that has it.
FUMAROLE_API VdbInfo all_grids(const std::vector<SequenceFrame>& frames);

/// Gives the sequences of a scene that leave their grid open the one that their frames together
/// suggest.
/// @throws Error if no frame has a grid that a medium names, saying what they have; as
/// read_sequence
FUMAROLE_API void settle_sequences(Scene& scene);

/// The first frame in which a sequence of the scene holds something, else the first; nothing if the
/// scene has no sequence.
/// @throws Error as read_sequence
FUMAROLE_API std::optional<int> first_frame_with_content(const Scene& scene);

}  // namespace fumarole::asset
