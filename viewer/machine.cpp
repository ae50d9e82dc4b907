#include "machine.h"

#include <fmt/format.h>
#include <fstream>
#include <sys/utsname.h>
#include <thread>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace fumarole::command {

namespace {

std::string model_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            if (const std::size_t colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return "unknown";
}

}  // namespace

std::string processor_name()
{
    return fmt::format("{}, {} cores", model_name(), std::thread::hardware_concurrency());
}

std::string system_name()
{
    utsname system{};
    ::uname(&system);
    return fmt::format("{} {}, {}", system.sysname, system.release, system.machine);
}

void keep_freed_memory()
{
#ifdef __GLIBC__
    constexpr int kOfItsOwn = 32 << 20;  // bytes: larger blocks are handed back; glibc's most
    constexpr int kMostKept = 256 << 20, kAhead = 16 << 20;
    mallopt(M_MMAP_THRESHOLD, kOfItsOwn);
    mallopt(M_TRIM_THRESHOLD, kMostKept);
    mallopt(M_TOP_PAD, kAhead);
#endif
}

}  // namespace fumarole::command
