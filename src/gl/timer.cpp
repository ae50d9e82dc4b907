#include "gl/timer.h"

#include <algorithm>

namespace fumarole::gl {

namespace {

GLuint stamp(const Device& gl)
{
    GLuint query = 0;
    gl->CreateQueries(GL_TIMESTAMP, 1, &query);
    gl->QueryCounter(query, GL_TIMESTAMP);
    return query;
}

}  // namespace

PassTimers::~PassTimers()
{
    for (const Pending& pass : pending_) {
        device_->DeleteQueries(1, &pass.begin);
        device_->DeleteQueries(1, &pass.end);
    }
}

const char* PassTimers::method() const
{
    return device_.capabilities().software ? "glFinish and a steady clock" : "timestamp queries";
}

PassTimers::Scope::Scope(PassTimers& timers, std::string name)
    : timers_{timers}, name_{std::move(name)}
{
    if (!timers_.enabled_)
        return;
    if (timers_.device_.capabilities().software) {
        timers_.device_->Finish();
        begin_ = std::chrono::steady_clock::now();
    } else {
        begin_query_ = stamp(timers_.device_);
    }
}

PassTimers::Scope::~Scope()
{
    if (!timers_.enabled_)
        return;
    if (timers_.device_.capabilities().software) {
        timers_.device_->Finish();
        const std::chrono::duration<double, std::milli> ms =
            std::chrono::steady_clock::now() - begin_;
        timers_.add(name_, ms.count());
    } else {
        timers_.pending_.push_back({std::move(name_), begin_query_, stamp(timers_.device_)});
    }
}

void PassTimers::add(const std::string& name, double ms)
{
    const auto found = std::find_if(done_.begin(), done_.end(),
                                    [&](const auto& pass) { return pass.first == name; });
    if (found == done_.end())
        done_.emplace_back(name, ms);
    else
        found->second += ms;
}

std::vector<std::pair<std::string, double>> PassTimers::take()
{
    for (const Pending& pass : pending_) {
        GLuint64 begin = 0, end = 0;
        device_->GetQueryObjectui64v(pass.begin, GL_QUERY_RESULT, &begin);
        device_->GetQueryObjectui64v(pass.end, GL_QUERY_RESULT, &end);
        device_->DeleteQueries(1, &pass.begin);
        device_->DeleteQueries(1, &pass.end);
        add(pass.name, static_cast<double>(end - begin) * 1e-6);
    }
    pending_.clear();
    return std::exchange(done_, {});
}

}  // namespace fumarole::gl
