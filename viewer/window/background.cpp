#include "window/background.h"

#include "window/glfw_window.h"

namespace fumarole::window {

Background::~Background()
{
    stop();
    reap(true);
}

void Background::run(std::function<void(const Stop&)> task)
{
    stop();
    reap(false);
    const auto stop = std::make_shared<Stop>(false), done = std::make_shared<Stop>(false);
    jobs_.push_back({stop, done, std::thread([task = std::move(task), stop, done] {
                         task(*stop);
                         *done = true;
                         GlfwWindow::wake();
                     })});
}

void Background::stop()
{
    for (Job& job : jobs_)
        *job.stop = true;
}

bool Background::busy() const
{
    return !jobs_.empty() && !*jobs_.back().done && !*jobs_.back().stop;
}

void Background::reap(bool all)
{
    for (auto job = jobs_.begin(); job != jobs_.end();)
        if (all || *job->done) {
            job->thread.join();
            job = jobs_.erase(job);
        } else {
            ++job;
        }
}

}  // namespace fumarole::window
