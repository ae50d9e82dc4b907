#include "interruption.h"

#include <fumarole/asset/load_limits.h>

namespace fumarole::command {

namespace {

// The one global: a signal's handler reaches nothing else.
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "or a handler may not touch it");

}  // namespace

Interruption::Interruption()
{
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    ::sigaction(SIGINT, &action, &int_);
    ::sigaction(SIGTERM, &action, &term_);
    asset::set_load_cancel(&interrupted);
}

Interruption::~Interruption()
{
    asset::set_load_cancel(nullptr);
    ::sigaction(SIGINT, &int_, nullptr);
    ::sigaction(SIGTERM, &term_, nullptr);
}

const std::atomic<bool>* Interruption::flag()
{
    return &interrupted;
}

}  // namespace fumarole::command
