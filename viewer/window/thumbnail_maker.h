#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "window/thumbnail_files.h"

namespace fumarole::window {

/// Finds small pictures of files, or has them made by `fumarole thumbnail`, one after the other: a
/// program of its own, with a GL of its own, that a damaged file may bring down. The window waits
/// for none of it.
class ThumbnailMaker {
public:
    struct Made {
        std::string file;
        Thumbnail thumbnail;
    };

    /// @param program that is run as `PROGRAM thumbnail --size 256 -- FILE PNG`
    ThumbnailMaker(std::filesystem::path program, ThumbnailCache cache);
    /// Ends a program that runs.
    ~ThumbnailMaker();
    ThumbnailMaker(const ThumbnailMaker&) = delete;
    ThumbnailMaker& operator=(const ThumbnailMaker&) = delete;

    /// The files whose pictures are wanted now, the first one first; others are not any more.
    void want(std::vector<std::string> files);
    /// What has come since the last call.
    std::vector<Made> take();

private:
    void work();
    [[nodiscard]] Thumbnail make(const std::string& file);
    /// Runs the program. Returns "", or why it failed.
    [[nodiscard]] std::string run(const std::string& file, const std::filesystem::path& png);
    [[nodiscard]] bool stopped();

    const std::filesystem::path program_;
    const ThumbnailCache cache_;
    std::mutex lock_;
    std::condition_variable wanted_;
    bool stop_ = false;
    std::vector<std::string> queue_;
    std::string current_;  ///< file that is being worked on, or ""
    std::vector<Made> made_;
    std::thread thread_;
};

}  // namespace fumarole::window
