#include "window/thumbnail_maker.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <system_error>
#include <utility>

#include "study/child_process.h"
#include "window/glfw_window.h"
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// A file that takes longer would keep those behind it waiting.
constexpr std::chrono::seconds kMostTime{120};
constexpr int kNice = 10;  // the window goes before

/// The last line that a program said, or what ended it.
std::string reason_of(const study::ChildResult& run)
{
    constexpr int kSignal = 128;
    if (run.code > kSignal)
        return fmt::format("its small picture can't be made: {}",
                           strsignal(run.code - kSignal));  // no other thread asks
    std::string line = run.said;
    while (line.ends_with('\n'))
        line.pop_back();
    line.erase(0, line.find_last_of('\n') + 1);
    constexpr std::string_view kName = "fumarole: ";
    return line.starts_with(kName) ? line.substr(kName.size()) : line;
}

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
    const Clock::time_point end = Clock::now() + kMostTime;
    bool late = false;
    const study::ChildResult run = study::run_child(
        {program_.string(), "thumbnail", "--size", "256", "--", file, png.string()},
        png.parent_path() / "fumarole.log",
        {.nice = kNice, .stops = [&] { return stopped() || (late = Clock::now() > end); }});
    if (late)
        throw Error(fmt::format("it takes longer than {} s to draw", kMostTime.count()));
    if (!run.found)
        throw Error(fmt::format("{}: is not there", program_.string()));
    if (run.code == 0)
        return "";
    std::string reason = reason_of(run);
    // The name stands under it already.
    if (reason.starts_with(file + ": "))
        reason.erase(0, file.size() + 2);
    return reason.empty() ? "its small picture can't be made" : reason;
}

}  // namespace fumarole::window
