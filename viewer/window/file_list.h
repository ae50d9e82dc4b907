#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fumarole::window {

/// A line of a folder: a folder in it, or something that can be opened.
struct FileEntry {
    enum class Kind { folder, volume, scene, sequence };

    Kind kind = Kind::volume;
    std::string name;  ///< as it is shown: a sequence's is smoke_####.vdb
    std::string path;  ///< to be opened
    /// Of a sequence: first and last frame, and how many are there.
    int first = 0, last = 0, frames = 0;
    std::uint64_t bytes = 0;  ///< of all of its files
    std::string pictured;     ///< the file whose small picture stands for it; "" for a folder

    bool operator==(const FileEntry&) const = default;
};

/// Folders, .vdb and .nvdb files, and scenes among .json files; numbered files of one name are one
/// entry. Folders come first, then all by their names, numbers in them by their size. What is
/// hidden is left out.
/// @throws Error if the folder can't be read
std::vector<FileEntry> list_folder(const std::filesystem::path& folder);

/// Puts numbered files together, and leaves the others as they are. @param files of one folder
std::vector<FileEntry> with_sequences(const std::vector<FileEntry>& files);

/// Whether `a` comes before `b`: letters whatever their case, numbers by their size.
bool comes_before(const std::string& a, const std::string& b);

/// A line of text about an entry: its size, or its frames.
std::string describe(const FileEntry& entry);

}  // namespace fumarole::window
