#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// Times passes by name. On a software rasteriser, where timer queries lie, between two glFinish on
/// a steady clock; on hardware by timestamp queries. Switched off it does nothing at all.
class PassTimers {
public:
    explicit PassTimers(const Device& device) : device_{device} {}
    ~PassTimers();
    PassTimers(const PassTimers&) = delete;
    PassTimers& operator=(const PassTimers&) = delete;

    void enable(bool on) { enabled_ = on; }
    [[nodiscard]] const char* method() const;

    /// Times what is drawn while it lives.
    class Scope {
    public:
        Scope(PassTimers& timers, std::string name);
        ~Scope();
        Scope(const Scope&) = delete;
        Scope& operator=(const Scope&) = delete;

    private:
        PassTimers& timers_;
        std::string name_;
        std::chrono::steady_clock::time_point begin_{};
        GLuint begin_query_ = 0;
    };
    [[nodiscard]] Scope scope(std::string name) { return {*this, std::move(name)}; }

    /// Milliseconds of each pass since the last call, in the order in which they first ran. A name
    /// that ran twice stands once, with the sum. Waits for the GPU.
    std::vector<std::pair<std::string, double>> take();

private:
    struct Pending {
        std::string name;
        GLuint begin = 0, end = 0;
    };
    void add(const std::string& name, double ms);

    const Device& device_;
    bool enabled_ = false;
    std::vector<std::pair<std::string, double>> done_;
    std::vector<Pending> pending_;
};

}  // namespace fumarole::gl
