#include "kept_programs.h"

#include <fmt/format.h>

#include "context/program_files.h"

namespace fumarole::command {

namespace {

struct Kept {
    std::shared_ptr<gl::ProgramFiles> files;
    std::string refusal;
};

/// One for the process, for all its renderers: they know of each other what was stored.
Kept& kept()
{
    static Kept one = [] {
        const auto folder = gl::program_folder();
        return folder ? Kept{std::make_shared<gl::ProgramFiles>(*folder), ""}
                      : Kept{nullptr, "neither XDG_CACHE_HOME nor HOME is set"};
    }();
    return one;
}

}  // namespace

ProgramStore kept_programs()
{
    return kept().files != nullptr ? kept().files->store() : ProgramStore{};
}

void keep_no_programs()
{
    kept() = {nullptr, "--no-program-cache"};
}

std::string kept_programs_text()
{
    if (kept().files == nullptr)
        return "compiled programs: not kept: " + kept().refusal;
    const gl::ProgramFiles::Account account = kept().files->account();
    return fmt::format("compiled programs: {} of an earlier run, {} kept for the next in {}{}",
                       account.loaded, account.stored, kept().files->folder().string(),
                       account.refusal.empty() ? "" : "; no more: " + account.refusal);
}

}  // namespace fumarole::command
