#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

#include <fumarole/errors.h>
#include <fumarole/export.h>

// What reading files may take, and how it is stopped. For all files that this process reads, on
// whatever thread.

namespace fumarole::asset {

/// Thrown by whatever reads files, once it was told to stop.
class FUMAROLE_API LoadCancelled : public Error {
public:
    using Error::Error;
};

/// The most memory that reading one file may take, for its bytes and for what is made of them.
/// Unless it is set: three quarters of what this machine, or the container that it runs in, has.
/// [bytes]
FUMAROLE_API std::uint64_t memory_limit();
FUMAROLE_API void set_memory_limit(std::uint64_t bytes);

/// Reading stops soon after `flag` has become true; null: it does not stop. The flag must outlive
/// its use.
FUMAROLE_API void set_load_cancel(const std::atomic<bool>* flag);

/// @throws LoadCancelled naming the file, if it is to be read no further
FUMAROLE_API void check_cancelled(const std::filesystem::path& file);

/// @throws Error if reading a file takes more than memory_limit(), naming it, both sizes and the
/// remedy
FUMAROLE_API void check_memory(const std::filesystem::path& file, std::uint64_t bytes);

}  // namespace fumarole::asset
