#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gl/device.h"

namespace fumarole::gl {

/// Numbers that shaders count up, known frames later: each is copied to a place of its own where
/// the GPU gets to it, and read by the CPU when a fence says that it is there. Never waits.
class CounterReadback {
public:
    explicit CounterReadback(const Device& device);
    ~CounterReadback();
    CounterReadback(const CounterReadback&) = delete;
    CounterReadback& operator=(const CounterReadback&) = delete;

    /// Asks for the first number of a buffer, as the GPU will have it. Not where many are asked for
    /// already that are not there.
    void ask(GLuint buffer);

    /// The last of those asked for that has come since the last call.
    std::optional<std::uint32_t> take();

private:
    struct Asked {
        GLsync fence = nullptr;
        std::uint64_t turn = 0;  ///< the larger the later
    };
    static constexpr std::size_t kMost = 8;

    const Device& device_;
    GLuint buffer_ = 0;
    const volatile std::uint32_t* mapped_ = nullptr;
    std::array<Asked, kMost> asked_;
    std::uint64_t turn_ = 0;
};

}  // namespace fumarole::gl
