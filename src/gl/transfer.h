#pragma once

#include <array>
#include <span>

#include "gl/device.h"
#include "gl/texture.h"

// Texels on their way between the CPU and textures.

namespace fumarole::gl {

/// While it lives, texels go tightly packed to and from our own memory, or a buffer of ours,
/// whatever packing and pixel buffer the host has bound.
class TightTransfer {
public:
    enum class Direction { pack, unpack };

    /// @param buffer that pointers are offsets into; 0: they point into memory
    TightTransfer(const Device& device, Direction direction, GLuint buffer = 0);
    ~TightTransfer();
    TightTransfer(const TightTransfer&) = delete;
    TightTransfer& operator=(const TightTransfer&) = delete;

private:
    static constexpr std::size_t kNames = 7;
    [[nodiscard]] GLenum target() const;
    [[nodiscard]] const std::array<GLenum, kNames>& names() const;

    const Device& gl_;
    bool pack_;
    GLint buffer_ = 0;
    std::array<GLint, kNames> values_{};
};

/// Texels that come back from the GPU while it works on: copied to a buffer when the GPU gets to
/// it, and read by the CPU when a fence says that they are there. (llvmpipe copies them at once.)
class Readback {
public:
    Readback() = default;
    ~Readback() { forget(); }
    Readback(Readback&& other) noexcept;
    Readback& operator=(Readback&& other) noexcept;
    Readback(const Readback&) = delete;
    Readback& operator=(const Readback&) = delete;

    /// Asks for a texture or one layer of an array, as floats.
    /// @param format GL_DEPTH_COMPONENT or GL_RGB
    Readback(const Device& device, TextureView texture, int layer, GLenum format);

    explicit operator bool() const { return buffer_ != 0; }
    /// Whether they are there; does not wait for them.
    [[nodiscard]] bool ready();
    /// Waits until they are; not at all where none are asked for.
    void wait();
    /// The depths, 0..1, or colours, first row first, once ready() has said so.
    [[nodiscard]] std::span<const float> texels() const { return {mapped_, count_}; }

private:
    bool poll(GLuint64 timeout_ns);
    void forget();
    void swap(Readback& other) noexcept;

    const Device* device_ = nullptr;
    GLuint buffer_ = 0;
    GLsync fence_ = nullptr;
    const float* mapped_ = nullptr;
    std::size_t count_ = 0;
};

}  // namespace fumarole::gl
