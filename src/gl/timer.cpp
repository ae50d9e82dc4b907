#include "gl/timer.h"

#include <algorithm>

namespace fumarole {

const char* timing_name(Timing timing)
{
    switch (timing) {
    case Timing::queries:
        return "timestamp queries";
    case Timing::finish:
        return "glFinish and a steady clock";
    default:
        return "not timed";
    }
}

}  // namespace fumarole

namespace fumarole::gl {

namespace {

void add(PassTimes& times, const std::string& name, double ms)
{
    const auto found = std::find_if(times.begin(), times.end(),
                                    [&](const auto& pass) { return pass.first == name; });
    if (found == times.end())
        times.emplace_back(name, ms);
    else
        found->second += ms;
}

}  // namespace

Timing measuring_timing(const Device& device)
{
    return device.capabilities().software ? Timing::finish : Timing::queries;
}

PassTimers::~PassTimers()
{
    drop();
}

void PassTimers::set_timing(Timing timing)
{
    if (timing == Timing::off)
        drop();
    timing_ = timing;
}

/// Back to nothing, no query kept.
void PassTimers::drop()
{
    const auto free = [&](const std::vector<Queried>& passes) {
        for (const Queried& pass : passes) {
            spare_.push_back(pass.begin);
            spare_.push_back(pass.end);
        }
    };
    for (const Pending& frame : pending_)
        free(frame.passes);
    free(queried_);
    if (!spare_.empty())
        device_->DeleteQueries(static_cast<GLsizei>(spare_.size()), spare_.data());
    spare_.clear();
    pending_.clear();
    queried_.clear();
    current_ = {};
    known_.reset();
}

GLuint PassTimers::stamp()
{
    if (spare_.empty())
        device_->CreateQueries(GL_TIMESTAMP, 1, &spare_.emplace_back());
    const GLuint query = spare_.back();
    spare_.pop_back();
    device_->QueryCounter(query, GL_TIMESTAMP);
    return query;
}

PassTimers::Scope::Scope(PassTimers& timers, std::string name)
    : timers_{timers}, name_{std::move(name)}
{
    if (timers_.timing_ == Timing::finish) {
        timers_.device_->Finish();
        begin_ = std::chrono::steady_clock::now();
    } else if (timers_.timing_ == Timing::queries && timers_.pending_.size() < kMostPending &&
               timers_.queried_.size() < kMostPasses) {
        begin_query_ = timers_.stamp();
    }
}

PassTimers::Scope::~Scope()
{
    if (timers_.timing_ == Timing::finish) {
        timers_.device_->Finish();
        const std::chrono::duration<double, std::milli> ms =
            std::chrono::steady_clock::now() - begin_;
        add(timers_.current_.passes, name_, ms.count());
    } else if (begin_query_ != 0) {
        timers_.queried_.push_back({std::move(name_), begin_query_, timers_.stamp()});
    }
}

void PassTimers::end_frame(std::uint64_t index)
{
    if (timing_ == Timing::finish) {
        current_.index = index;
        known_ = std::exchange(current_, {});
    } else if (timing_ == Timing::queries) {
        if (!queried_.empty())
            pending_.push_back({index, std::exchange(queried_, {})});
        look();
    }
}

/// Takes what the GPU has written, of the oldest frames first: timestamps come in order, so that
/// once a frame's last one is there all others are.
void PassTimers::look()
{
    while (!pending_.empty()) {
        const Pending& frame = pending_.front();
        GLuint available = GL_FALSE;
        device_->GetQueryObjectuiv(frame.passes.back().end, GL_QUERY_RESULT_AVAILABLE, &available);
        if (available == GL_FALSE)
            return;
        known_ = {frame.index, {}};
        for (const Queried& pass : frame.passes) {
            GLuint64 begin = 0, end = 0;
            device_->GetQueryObjectui64v(pass.begin, GL_QUERY_RESULT, &begin);
            device_->GetQueryObjectui64v(pass.end, GL_QUERY_RESULT, &end);
            add(known_->passes, pass.name, static_cast<double>(end - begin) * 1e-6);
            spare_.push_back(pass.begin);
            spare_.push_back(pass.end);
        }
        pending_.pop_front();
    }
}

std::optional<PassTimers::FrameTimes> PassTimers::take()
{
    look();
    return std::exchange(known_, std::nullopt);
}

}  // namespace fumarole::gl
