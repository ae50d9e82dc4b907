#pragma once

#include <cstdint>

#include "gl/buffer.h"
#include "gl/counter_readback.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "shared/bindings.h"

namespace fumarole::transparent {

/// Lists of transparent fragments, one a pixel of a view: glsl/scene/fragment_lists.glsl. Their
/// memory follows what frames have asked for, which is known frames later; until then those that do
/// not fit are lost.
class FragmentLists {
public:
    explicit FragmentLists(const gl::Device& device);

    /// Empties them for a frame, and makes room for as many as a frame before had.
    /// @param half_color colours have 16 bits a channel
    void begin(glm::ivec2 size, bool half_color);

    /// Binds what shaders fill and read: an image, and two storage buffers.
    void bind(GLuint image, GLuint first_buffer) const;
    void bind() const { bind(FRAGMENT_LISTS_IMAGE, FRAGMENT_COUNT_BUFFER); }
    /// The framebuffer that has nothing but their size.
    void bind_framebuffer() const { framebuffer_.bind(size_); }
    /// Lets what was added be read, and more be added.
    void let_read() const;
    /// The same, when all has been.
    void end();

    /// The variant of the shaders that include the lists.
    [[nodiscard]] gl::Defines defines() const;

    /// Of all that it holds on the GPU.
    [[nodiscard]] std::uint64_t bytes() const;

    /// What of a frame is known last.
    struct Count {
        std::uint64_t fragments = 0;  ///< number of fragments that transparents had
        std::uint64_t lost = 0;       ///< number of those that were lost for want of room
    };
    /// Never waits.
    [[nodiscard]] Count count();

private:
    void look();
    void make_buffer(std::uint64_t fragments);

    const gl::Device& device_;
    gl::CounterReadback readback_;
    gl::Buffer counter_, fragments_;
    gl::Texture first_;
    gl::Framebuffer framebuffer_;
    glm::ivec2 size_{0};
    bool half_color_ = false;
    std::uint64_t room_ = 0;    ///< fragments
    std::uint64_t wanted_ = 0;  ///< the most that a frame had
    Count count_;
    bool told_ = false;  ///< true once it was told that the GL gives no more
};

}  // namespace fumarole::transparent
