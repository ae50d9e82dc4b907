#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <fumarole/program_store.h>

namespace fumarole::gl {

/// Compiled programs as files of a folder, one each, by their keys. Any number of processes may
/// use one folder at a time: a file is written beside its place and then renamed, so that what is
/// there is whole. Nothing here fails: a folder that can't be read or written is done without.
class ProgramFiles : public std::enable_shared_from_this<ProgramFiles> {
public:
    static constexpr std::uintmax_t kMostBytes = 256u << 20;

    /// @param most_bytes that the folder's files may have in all; those that were used last stay
    explicit ProgramFiles(std::filesystem::path folder, std::uintmax_t most_bytes = kMostBytes)
        : folder_{std::move(folder)}, most_bytes_{most_bytes}
    {
    }

    /// For a Renderer; it keeps this alive.
    ProgramStore store();

    /// What was done so far.
    struct Account {
        int loaded = 0, stored = 0;
        std::string refusal;  ///< why nothing is stored any more; empty if it is
    };
    [[nodiscard]] Account account() const;
    [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

private:
    std::vector<std::byte> read(std::string_view key);
    void write(std::string_view key, const std::vector<std::byte>& program);
    /// Removes those that were not used for longest, and what a killed process left half written.
    void make_room();

    const std::filesystem::path folder_;
    const std::uintmax_t most_bytes_;
    mutable std::mutex lock_;
    Account account_;
    std::optional<std::uintmax_t>
        bytes_;  ///< bytes of the folder's files, as far as they are known
};

/// $XDG_CACHE_HOME/fumarole, or .cache/fumarole in the home; nothing if neither is known.
std::optional<std::filesystem::path> program_folder();

}  // namespace fumarole::gl
