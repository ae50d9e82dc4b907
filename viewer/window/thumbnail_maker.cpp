#include "window/thumbnail_maker.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "window/glfw_window.h"
#include <fumarole/errors.h>

extern char** environ;

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A file that takes longer would keep those behind it waiting.
constexpr std::chrono::seconds kMostTime{120};
constexpr int kNice = 10;  // the window goes before

/// A program whose standard error is read, and whose other streams are closed.
class Child {
public:
    /// @throws Error if it can't be started
    explicit Child(std::vector<std::string> words)
    {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0)
            throw Error(std::generic_category().message(errno));
        err_ = ends[0];
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
        std::vector<char*> argv;
        for (std::string& word : words)
            argv.push_back(word.data());
        argv.push_back(nullptr);
        const int error = posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        close(ends[1]);
        if (error != 0) {
            close(err_);
            throw Error(
                fmt::format("{}: {}", words.front(), std::generic_category().message(error)));
        }
        setpriority(PRIO_PROCESS, static_cast<id_t>(pid_), kNice);
        fcntl(err_, F_SETFL, O_NONBLOCK);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child()
    {
        if (!ended_) {
            kill(pid_, SIGKILL);
            waitpid(pid_, &status_, 0);
        }
        close(err_);
    }

    /// Reads what it has said. Returns whether it has ended.
    bool look()
    {
        ended_ = ended_ || waitpid(pid_, &status_, WNOHANG) == pid_;
        std::array<char, 4096> part{};
        for (ssize_t n = 0; (n = ::read(err_, part.data(), part.size())) > 0;)
            if (said_.size() < kMostSaid)
                said_.append(part.data(), static_cast<std::size_t>(n));
        return ended_;
    }
    [[nodiscard]] bool succeeded() const { return WIFEXITED(status_) && WEXITSTATUS(status_) == 0; }
    /// Its last line, or what ended it.
    [[nodiscard]] std::string reason() const
    {
        if (WIFSIGNALED(status_))
            return fmt::format("its small picture can't be made: {}",
                               strsignal(WTERMSIG(status_)));  // no other thread asks
        std::string line = said_;
        while (line.ends_with('\n'))
            line.pop_back();
        line.erase(0, line.find_last_of('\n') + 1);
        constexpr std::string_view kName = "fumarole: ";
        return line.starts_with(kName) ? line.substr(kName.size()) : line;
    }

private:
    static constexpr std::size_t kMostSaid = 65536;

    pid_t pid_ = -1;
    int err_ = -1, status_ = 0;
    bool ended_ = false;
    std::string said_;
};

}  // namespace

ThumbnailMaker::ThumbnailMaker(fs::path program, ThumbnailCache cache)
    : program_{std::move(program)}, cache_{std::move(cache)}, thread_{[this] { work(); }}
{
}

ThumbnailMaker::~ThumbnailMaker()
{
    {
        const std::lock_guard lock(lock_);
        stop_ = true;
    }
    wanted_.notify_all();
    thread_.join();
}

void ThumbnailMaker::want(std::vector<std::string> files)
{
    {
        const std::lock_guard lock(lock_);
        const auto is_there = [&](const std::string& file) {
            return file == current_ ||
                   std::any_of(made_.begin(), made_.end(),
                               [&](const Made& made) { return made.file == file; });
        };
        std::erase_if(files, is_there);
        queue_ = std::move(files);
    }
    wanted_.notify_all();
}

std::vector<ThumbnailMaker::Made> ThumbnailMaker::take()
{
    const std::lock_guard lock(lock_);
    return std::exchange(made_, {});
}

bool ThumbnailMaker::stopped()
{
    const std::lock_guard lock(lock_);
    return stop_;
}

void ThumbnailMaker::work()
{
    std::unique_lock lock(lock_);
    while (!stop_) {
        if (queue_.empty()) {
            wanted_.wait(lock);
            continue;
        }
        current_ = queue_.front();
        queue_.erase(queue_.begin());
        const std::string file = current_;
        lock.unlock();
        Thumbnail thumbnail = make(file);
        lock.lock();
        current_.clear();
        if (thumbnail.known())
            made_.push_back({file, std::move(thumbnail)});
        GlfwWindow::wake();
    }
}

Thumbnail ThumbnailMaker::make(const std::string& file)
{
    try {
        Thumbnail known = cache_.find(file);
        if (known.known())
            return known;
        const fs::path png = cache_.place_for(file);
        const std::string error = run(file, png);
        if (stopped())
            return {};
        if (!error.empty()) {
            cache_.keep_error(file, error);
            return {{}, error};
        }
        // They show what is in files that others need not see.
        std::error_code unchanged;
        fs::permissions(png, fs::perms::owner_read | fs::perms::owner_write, unchanged);
        known = cache_.find(file);
        return known.known() ? known : Thumbnail{{}, "its small picture is lost"};
    } catch (const std::exception& error) {
        return {{}, error.what()};
    }
}

std::string ThumbnailMaker::run(const std::string& file, const fs::path& png)
{
    Child child({program_.string(), "thumbnail", "--size", "256", "--", file, png.string()});
    const Clock::time_point end = Clock::now() + kMostTime;
    while (!child.look()) {
        if (stopped())
            return "stopped";
        if (Clock::now() > end)
            throw Error(fmt::format("it takes longer than {} s to draw", kMostTime.count()));
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (child.succeeded())
        return "";
    std::string reason = child.reason();
    // The name stands under it already.
    if (reason.starts_with(file + ": "))
        reason.erase(0, file.size() + 2);
    return reason.empty() ? "its small picture can't be made" : reason;
}

}  // namespace fumarole::window
