#pragma once

#include <cassert>
#include <string_view>

#include "gl/device.h"
#include "gl/label.h"

namespace fumarole::gl {

/// A buffer of fixed size.
class Buffer {
public:
    Buffer() = default;
    Buffer(const Device& gl, std::string_view label, std::size_t bytes, const void* data = nullptr)
        : bytes_{bytes}
    {
        GLuint id = 0;
        gl->CreateBuffers(1, &id);
        handle_ = {gl, id};
        set_label(gl, GL_BUFFER, id, label);
        gl->NamedBufferStorage(id, static_cast<GLsizeiptr>(bytes), data, GL_DYNAMIC_STORAGE_BIT);
        gl.account(static_cast<std::int64_t>(bytes));
    }

    void write(const void* data, std::size_t bytes) const
    {
        assert(bytes <= bytes_);
        handle_.device()->NamedBufferSubData(id(), 0, static_cast<GLsizeiptr>(bytes), data);
    }

    /// Sets all to 0.
    void clear() const
    {
        handle_.device()->ClearNamedBufferData(id(), GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT,
                                               nullptr);
    }

    void invalidate() const { handle_.device()->InvalidateBufferData(id()); }

    [[nodiscard]] GLuint id() const { return handle_.id(); }
    [[nodiscard]] std::size_t bytes() const { return bytes_; }
    explicit operator bool() const { return static_cast<bool>(handle_); }

private:
    static void destroy(const Device& gl, GLuint id)
    {
        GLint64 bytes = 0;
        gl->GetNamedBufferParameteri64v(id, GL_BUFFER_SIZE, &bytes);
        gl.account(-bytes);
        gl->DeleteBuffers(1, &id);
    }
    Handle<&Buffer::destroy> handle_;
    std::size_t bytes_ = 0;
};

/// A uniform block of one struct (a header of glsl/shared).
template <typename Params> class UniformBuffer {
    static_assert(sizeof(Params) % 16 == 0, "std140 rounds a block up to 16 bytes");

public:
    UniformBuffer() = default;
    UniformBuffer(const Device& gl, std::string_view label) : buffer_{gl, label, sizeof(Params)} {}
    /// Lets go of what is in it first: a GPU that has not read that yet keeps it, and the driver
    /// gives the block other memory instead of waiting. A ring of blocks would need a fence each,
    /// as some are written once a surface, not once a frame.
    void write(const Params& params) const
    {
        buffer_.invalidate();
        buffer_.write(&params, sizeof(Params));
    }
    [[nodiscard]] GLuint id() const { return buffer_.id(); }

private:
    Buffer buffer_;
};

}  // namespace fumarole::gl
