#include "interruption.h"

#include <cmath>
#include <sys/time.h>

#include <fumarole/asset/load_limits.h>

namespace fumarole::command {

namespace {

// The only globals: a signal's handler reaches nothing else.
std::atomic<bool> interrupted{false}, out_of_time{false};
static_assert(std::atomic<bool>::is_always_lock_free, "or a handler may not touch it");

/// Sets the process's clock to raise SIGALRM after so many seconds; 0: not any more.
void set_alarm(double seconds)
{
    itimerval timer{};
    timer.it_value.tv_sec = static_cast<time_t>(seconds);
    timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * std::fmod(seconds, 1.0));
    ::setitimer(ITIMER_REAL, &timer, nullptr);
}

}  // namespace

Interruption::Interruption(std::optional<double> time_limit)
{
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    ::sigaction(SIGINT, &action, &int_);
    ::sigaction(SIGTERM, &action, &term_);
    action.sa_handler = [](int) { interrupted = out_of_time = true; };
    ::sigaction(SIGALRM, &action, &alarm_);
    if (time_limit)
        set_alarm(*time_limit);
    asset::set_load_cancel(&interrupted);
}

Interruption::~Interruption()
{
    set_alarm(0);
    ::sigaction(SIGALRM, &alarm_, nullptr);
    asset::set_load_cancel(nullptr);
    ::sigaction(SIGINT, &int_, nullptr);
    ::sigaction(SIGTERM, &term_, nullptr);
}

const std::atomic<bool>* Interruption::flag()
{
    return &interrupted;
}

bool Interruption::timed_out()
{
    return out_of_time;
}

}  // namespace fumarole::command
