#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

// Files that are whole or not there: the one place that writes what a person asked for.

namespace fumarole::write {

/// A name beside `file` under which another program, or we, write; then it is renamed to `file`, or
/// removed.
class UnfinishedFile {
public:
    explicit UnfinishedFile(std::filesystem::path file);
    ~UnfinishedFile();
    UnfinishedFile(const UnfinishedFile&) = delete;
    UnfinishedFile& operator=(const UnfinishedFile&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    /// Takes the name. @throws Error naming the file.
    void finish();

private:
    std::filesystem::path file_, path_;
};

/// Writes beside, then renames. A link is written through and keeps to be one, a file that is
/// replaced keeps its rights, and one that is write-protected is left as it is; a device or a pipe
/// takes the bytes themselves. @throws Error naming the file, what is wrong and the remedy
void write_whole(const std::filesystem::path& file, std::string_view bytes);
void write_whole(const std::filesystem::path& file, std::span<const unsigned char> bytes);

/// All of a file. @throws Error naming the file.
std::string read_whole(const std::filesystem::path& file);

}  // namespace fumarole::write
