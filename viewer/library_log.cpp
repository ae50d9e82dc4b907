#include "library_log.h"

#include <mutex>
#include <set>
#include <string>

#include "progress.h"
#include "study/flag_names.h"

namespace fumarole::command {

Log library_log()
{
    return [](LogLevel, std::string_view line) {
        static std::mutex lock;
        static std::set<std::string> told;
        const std::lock_guard hold(lock);
        if (const auto [text, anew] = told.insert(study::with_flags(line)); anew)
            print_over_progress(*text);
    };
}

}  // namespace fumarole::command
