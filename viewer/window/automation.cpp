#include "window/automation.h"

#include <fmt/format.h>

#include <fumarole/errors.h>

namespace fumarole::window {

Automation::Automation(Script script, int frames, std::string last_screenshot)
    : script_{std::move(script)}, counts_frames_{frames > 0}, frames_left_{frames},
      last_screenshot_{std::move(last_screenshot)}
{
}

bool Automation::ends(bool finished)
{
    if (!script_.done())
        return false;
    return counts_frames_ ? --frames_left_ <= 0 : !last_screenshot_.empty() && finished;
}

bool Automation::request_last_screenshot()
{
    if (last_screenshot_.empty())
        return false;
    request_screenshot(last_screenshot_);
    return true;
}

void Automation::check_screenshots() const
{
    if (!screenshots_.empty())
        throw Error(fmt::format("{}: not written: the window is minimised", screenshots_.front()));
}

}  // namespace fumarole::window
