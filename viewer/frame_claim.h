#pragma once

#include <filesystem>
#include <optional>

namespace fumarole::command {

/// The right to draw one frame, among processes on any machines that share a folder: a lock on a
/// file beside the frame's picture. Whoever is killed lets go of it; the file goes with the claim.
class FrameClaim {
public:
    /// Nothing where another process holds it. @throws Error if no lock can be had there
    static std::optional<FrameClaim> take(const std::filesystem::path& picture);

    FrameClaim(FrameClaim&& other) noexcept;
    FrameClaim& operator=(FrameClaim&&) = delete;
    ~FrameClaim();

private:
    FrameClaim(std::filesystem::path file, int descriptor);
    std::filesystem::path file_;
    int descriptor_;
};

}  // namespace fumarole::command
