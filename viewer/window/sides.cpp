#include "window/sides.h"

#include "study/flag_names.h"

namespace fumarole::window {

Sides::Sides(gl::GetProc get_proc, Log log)
    : get_proc_{get_proc}, log_{std::move(log)}, a_{std::make_unique<Side>(get_proc, log_)}
{
}

bool Sides::draw(const SideRequest& a, const std::optional<SideRequest>& b)
{
    if (!error_.empty())
        return false;
    if (b && !b_)
        b_ = std::make_unique<Side>(get_proc_, log_);
    if (!b)
        b_.reset();
    bool drawn = draw(*a_, a);
    if (b)
        drawn |= draw(*b_, *b);
    return drawn;
}

bool Sides::draw(Side& side, const SideRequest& request)
{
    try {
        return side.draw(request);
    } catch (const std::exception& error) {
        error_ = study::with_flags(error.what());
        return false;
    }
}

}  // namespace fumarole::window
