#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// Binding points that a host chose for what is ours, while it draws with it: notes what is bound
/// there, the draw framebuffer and the viewport, and puts it back when it dies.
class BindingGuard {
public:
    struct Points {
        std::uint32_t block = 0, texture_unit = 0, image = 0;
        std::vector<std::uint32_t> storages;
    };
    /// @throws Error if the GL has not so many of a kind
    BindingGuard(const Device& device, const Points& points);
    ~BindingGuard();
    BindingGuard(const BindingGuard&) = delete;
    BindingGuard& operator=(const BindingGuard&) = delete;

private:
    struct Block {
        GLint buffer = 0;
        GLint64 offset = 0, size = 0;
    };
    void put_back(GLenum target, std::uint32_t point, const Block& block) const;

    const Device& gl_;
    Points points_;
    Block block_;
    std::vector<Block> storages_;
    GLint uniform_buffer_ = 0, storage_buffer_ = 0, texture_ = 0, sampler_ = 0;
    GLint image_ = 0, level_ = 0, layer_ = 0, access_ = 0, format_ = 0;
    GLboolean layered_ = GL_FALSE;
    GLint draw_framebuffer_ = 0;
    std::array<GLfloat, 4> viewport_{};
};

}  // namespace fumarole::gl
