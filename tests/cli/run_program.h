#pragma once

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <future>
#include <pty.h>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "support/temp_folder.h"

namespace fumarole::test {

using Arguments = std::vector<std::string>;

/// What a run of the program left.
struct Outcome {
    int code = -1;  ///< exit code, or 1000 + the signal that ended it
    std::string out, err;

    /// Lines of what it said on stderr.
    [[nodiscard]] long error_lines() const { return std::count(err.begin(), err.end(), '\n'); }
};

inline std::ostream& operator<<(std::ostream& to, const Outcome& run)
{
    return to << "exit code " << run.code << "\nstdout: " << run.out.substr(0, 2000)
              << "\nstderr: " << run.err.substr(0, 2000);
}

struct RunOptions {
    std::string out;           ///< file for stdout instead of Outcome::out, e.g. /dev/full
    long file_limit = -1;      ///< bytes that it may write to a file, as if the disk were full then
    std::string interrupt_at;  ///< file; once something is in it, the signal is sent
    int signal = SIGINT;
    long interrupt_at_mb = 0;  ///< of memory that it holds SIGINT is sent; 0: it is not
    bool terminal = false;     ///< stderr is one
};

/// Waits until a child has written to `file`, or has ended, and sends it a signal.
inline void interrupt(pid_t child, const std::filesystem::path& file, int signal)
{
    std::error_code error;
    siginfo_t ended{};
    while (ended.si_pid == 0 && (std::filesystem::file_size(file, error) == 0 || error)) {
        usleep(5000);
        waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    kill(child, signal);
}

/// Waits until a child holds so much memory, or has ended, and sends it SIGINT.
inline void interrupt(pid_t child, long megabytes)
{
    const std::string statm = "/proc/" + std::to_string(child) + "/statm";
    siginfo_t ended{};
    long pages = 0, resident = 0;
    while (ended.si_pid == 0 && resident * sysconf(_SC_PAGESIZE) < megabytes << 20) {
        usleep(2000);
        std::ifstream(statm) >> pages >> resident;
        waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    }
    kill(child, SIGINT);
}

/// Whether a terminal is to be had: a container may have no /dev/pts.
inline bool has_terminals()
{
    int ours = -1, theirs = -1;
    if (openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0)
        return false;
    close(ours);
    close(theirs);
    return true;
}

/// What was written to a terminal whose other end is closed. Its buffer holds a few kilobytes.
inline std::string read_terminal(int terminal)
{
    std::string text;
    char part[4096];
    for (ssize_t n = 0; (n = read(terminal, part, sizeof part)) > 0;)
        text.append(part, static_cast<std::size_t>(n));
    close(terminal);
    return text;
}

/// Runs fumarole as a user does, with `folder` as its working directory.
inline Outcome run_program(const std::filesystem::path& folder, const Arguments& arguments,
                           const RunOptions& options = {})
{
    std::string out = (folder / "stdout.XXXXXX").string();
    std::string err = (folder / "stderr.XXXXXX").string();
    const int out_file =
        options.out.empty() ? mkstemp(out.data()) : open(options.out.c_str(), O_WRONLY | O_CLOEXEC);
    int err_file = mkstemp(err.data()), terminal = -1;
    if (options.terminal) {
        close(err_file);
        if (openpty(&terminal, &err_file, nullptr, nullptr, nullptr) != 0)
            throw std::runtime_error("no pseudo-terminal to be had: is /dev/pts mounted?");
        fcntl(terminal, F_SETFD, FD_CLOEXEC);
    }
    std::vector<char*> argv{const_cast<char*>(FUM_PROGRAM)};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
        // Only what is safe after fork in a program of many threads.
        if (options.file_limit >= 0) {
            const auto limit = static_cast<rlim_t>(options.file_limit);
            const rlimit limits{limit, limit};
            setrlimit(RLIMIT_FSIZE, &limits);
            std::signal(SIGXFSZ, SIG_IGN);  // else the signal ends it, where a full disk would not
        }
        dup2(out_file, STDOUT_FILENO);
        dup2(err_file, STDERR_FILENO);
        if (chdir(folder.c_str()) == 0)
            execv(FUM_PROGRAM, argv.data());
        _exit(127);
    }
    if (!options.interrupt_at.empty())
        interrupt(child, folder / options.interrupt_at, options.signal);
    if (options.interrupt_at_mb > 0)
        interrupt(child, options.interrupt_at_mb);
    int status = 0;
    waitpid(child, &status, 0);
    close(out_file);
    close(err_file);
    Outcome run;
    run.code = WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
    if (options.out.empty()) {
        run.out = read_bytes(out);
        std::filesystem::remove(out);
    }
    run.err = options.terminal ? read_terminal(terminal) : read_bytes(err);
    std::filesystem::remove(err);
    return run;
}

/// A command whose picture is not looked at for its light: light's volumes are small and hold what
/// is scattered once, which takes half of a small picture's time.
inline Arguments with_little_light(Arguments command)
{
    command.insert(command.end(),
                   {"--bounces=0", "--ambient-volume-size=8", "--shadow-volume-size=16"});
    return command;
}

/// Several at a time; answers in the order of the arguments.
inline std::vector<Outcome> run_all(const std::filesystem::path& folder,
                                    const std::vector<Arguments>& all)
{
    constexpr std::size_t kAtOnce = 4;
    std::vector<Outcome> runs(all.size());
    std::vector<std::future<void>> workers;
    for (std::size_t first = 0; first < kAtOnce; ++first)
        workers.push_back(std::async(std::launch::async, [&, first] {
            for (std::size_t i = first; i < all.size(); i += kAtOnce)
                runs[i] = run_program(folder, all[i]);
        }));
    for (std::future<void>& worker : workers)
        worker.get();
    return runs;
}

/// Names in a folder, sorted.
inline std::vector<std::string> list(const std::filesystem::path& folder)
{
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

inline std::string joined(const Arguments& arguments)
{
    std::string line = "fumarole";
    for (const std::string& argument : arguments)
        line += " " + argument;
    return line;
}

/// A sample of vdb_samples/, by its file name.
inline std::string sample(const std::string& name)
{
    return std::string(FUM_TEST_DATA) + "/" + name;
}

}  // namespace fumarole::test
