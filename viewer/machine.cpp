#include "machine.h"

#include <fmt/format.h>
#include <fstream>
#include <sys/utsname.h>
#include <thread>

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

}  // namespace fumarole::command
