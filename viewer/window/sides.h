#pragma once

#include <memory>
#include <optional>
#include <string>

#include "window/side.h"

namespace fumarole::window {

/// Side A, which is always there, and side B while something is compared: each a renderer of its
/// own, so that neither refills what the other has.
class Sides {
public:
    /// @param log as Side takes it
    explicit Sides(gl::GetProc get_proc, Log log = {});

    /// Draws a frame more of side A, and of side B where `b` asks for it. Returns whether there is
    /// another picture. What goes wrong stands in error(), and nothing is drawn until retry().
    bool draw(const SideRequest& a, const std::optional<SideRequest>& b);

    /// Why the last drawing failed, or "".
    [[nodiscard]] const std::string& error() const { return error_; }
    void retry() { error_.clear(); }

    [[nodiscard]] Side& a() { return *a_; }
    [[nodiscard]] const Side& a() const { return *a_; }
    /// Side B, or null.
    [[nodiscard]] const Side* b() const { return b_.get(); }

private:
    bool draw(Side& side, const SideRequest& request);

    gl::GetProc get_proc_;
    Log log_;
    std::unique_ptr<Side> a_, b_;
    std::string error_;
};

}  // namespace fumarole::window
