#include "study/child_process.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "write/whole_file.h"
#include <fumarole/errors.h>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace fumarole::study {

namespace {

/// Waits for the end of a program, or ends it. @returns its status
int wait_for(pid_t child, const std::function<bool()>& stops)
{
    int status = 0;
    while (stops && waitpid(child, &status, WNOHANG) == 0) {
        if (stops()) {
            kill(child, SIGKILL);
            break;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    // One that has been waited for is no child any more, and keeps its status.
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return status;
}

}  // namespace

ChildResult run_child(std::vector<std::string> arguments, const std::filesystem::path& log,
                      const ChildOptions& options)
{
    const write::UnfinishedFile output(log);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.path().c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments)
        pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const auto begin = std::chrono::steady_clock::now();
    pid_t child = 0;
    const int failed =
        posix_spawnp(&child, pointers.front(), &actions, nullptr, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed == ENOENT)
        return {.found = false};
    if (failed != 0)
        throw Error(
            fmt::format("{} can't be started: {}", arguments.front(), std::strerror(failed)));
    if (options.nice > 0)
        setpriority(PRIO_PROCESS, static_cast<id_t>(child), options.nice);
    const int status = wait_for(child, options.stops);
    ChildResult result;
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.said = write::read_whole(output.path());
    return result;
}

}  // namespace fumarole::study
