#pragma once

#include "gl/framebuffer.h"
#include "gl/texture.h"

namespace fumarole::transparent {

/// What sums are drawn to, in 32 bits a channel.
struct FineTarget {
    const char* label;
    gl::Texture texture;
    gl::Framebuffer framebuffer;

    void resize(const gl::Device& device, glm::ivec2 size)
    {
        if (texture && glm::ivec2(texture.size()) == size)
            return;
        texture = gl::Texture::make_2d(device, label, size, GL_RGBA32F, gl::Filter::linear);
        framebuffer = {device, label};
        framebuffer.attach_color({texture.view()});
    }
    void drop()
    {
        texture = {};
        framebuffer = {};
    }
};

}  // namespace fumarole::transparent
