#include <fumarole/asset/load_limits.h>

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <unistd.h>

namespace fumarole::asset {

namespace {

// A signal's handler, and the threads that read, reach nothing else.
std::atomic<const std::atomic<bool>*> cancel_flag{nullptr};
std::atomic<std::uint64_t> asked_limit{0};  // 0: not set

std::uint64_t machine_memory()
{
    std::uint64_t bytes = static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PHYS_PAGES))) *
                          static_cast<std::uint64_t>(std::max(0L, sysconf(_SC_PAGESIZE)));
    // A container's, of control groups of version 2 and 1. "max", or no file, is no limit.
    for (const char* file :
         {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"})
        if (std::uint64_t most = 0; std::ifstream(file) >> most && most > 0)
            bytes = std::min(bytes, most);
    return bytes;
}

}  // namespace

std::uint64_t memory_limit()
{
    static const std::uint64_t own = machine_memory() / 4 * 3;
    return asked_limit != 0 ? asked_limit.load() : own;
}

void set_memory_limit(std::uint64_t bytes)
{
    asked_limit = std::max<std::uint64_t>(bytes, 1);
}

void set_load_cancel(const std::atomic<bool>* flag)
{
    cancel_flag = flag;
}

void check_cancelled(const std::filesystem::path& file)
{
    if (const std::atomic<bool>* flag = cancel_flag; flag != nullptr && *flag)
        throw LoadCancelled(
            fmt::format("interrupted while {} was read; nothing was written", file.string()));
}

void check_memory(const std::filesystem::path& file, std::uint64_t bytes)
{
    if (bytes > memory_limit())
        throw Error(
            fmt::format("{}: too large: reading it takes {:.3g} GB, and the limit is {:.3g} "
                        "GB; give a larger --max-memory, or resample it coarser",
                        file.string(), 1e-9 * static_cast<double>(bytes),
                        1e-9 * static_cast<double>(memory_limit())));
}

}  // namespace fumarole::asset
