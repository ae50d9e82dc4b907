#pragma once

#include <filesystem>
#include <string_view>

namespace fumarole::study {

/// A name beside `file` under which another program, or we, write; then it is renamed to `file`, or
/// removed. So `file` is whole or not there.
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

/// Writes beside, then renames. @throws Error naming the file.
void write_whole(const std::filesystem::path& file, std::string_view bytes);

/// All of a file. @throws Error naming the file.
std::string read_whole(const std::filesystem::path& file);

}  // namespace fumarole::study
