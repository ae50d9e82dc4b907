#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// A guest's manners: notes the state that our passes change, sets what they rely on, and puts
/// everything back when it dies. Buffers, textures and programs of the host are left alone.
///
/// Our passes rely on: no test, no mask, no blending, both faces drawn, lines a pixel wide, clip
/// space of OpenGL's default ([-1,1] depth, lower left), no sampler object on our texture units.
/// They draw through viewport 0 to two attachments at most: set state by index, as what lies past
/// them is not noted. They bind textures of two dimensions, of three, and arrays of two, by
/// bind_texture(): so of a unit's eleven targets only those three are noted and put back.
///
/// A host's program pipeline needs no note: it is hidden while a program is in use, and back when
/// the host's own use of none is put back. The one host's object that can't come back is a program
/// that it deleted, or linked anew in vain, while it is in use: GL lets go of it when ours is used.
class StateGuard {
public:
    /// Uniform blocks 0..blocks-1, image units 0..images-1 and storage buffers 0..storages-1 are
    /// ours while it lives, and each texture unit from when bind_texture() first takes it. Guards
    /// of a device die in the reverse order of their making.
    StateGuard(const Device& device, int blocks, int images, int storages = 0);
    ~StateGuard();
    StateGuard(const StateGuard&) = delete;
    StateGuard& operator=(const StateGuard&) = delete;

    /// Notes a texture unit, unless it has, and lets no sampler object lie on it.
    void take_unit(GLuint unit);

private:
    struct Unit {
        GLuint number = 0;
        GLint texture_2d = 0, texture_3d = 0, texture_2d_array = 0, sampler = 0;
    };
    struct Block {
        GLint buffer = 0;
        GLint64 offset = 0, size = 0;
    };
    struct Image {
        GLint texture = 0, level = 0, layer = 0, access = 0, format = 0;
        GLboolean layered = GL_FALSE;
    };
    struct Blend {
        GLint src_rgb = 0, dst_rgb = 0, src_alpha = 0, dst_alpha = 0, equation_rgb = 0,
              equation_alpha = 0;
        GLboolean enabled = GL_FALSE;
        std::array<GLboolean, 4> color_mask{};
    };
    /// The attachments that we draw to: never more than two, and depth.
    static constexpr int kDrawBuffers = 2;

    const Device& gl_;
    StateGuard* const outer_;  ///< the guard of the same device whose turn it is again afterwards
    std::uint64_t taken_[2] = {};  ///< a bit for each unit that is noted
    std::vector<GLboolean> enabled_;
    std::vector<Unit> units_;
    std::vector<Block> blocks_, storages_;
    std::vector<Image> images_;
    std::array<Blend, kDrawBuffers> blend_{};
    GLint draw_framebuffer_ = 0, program_ = 0, vertex_array_ = 0, active_texture_ = 0;
    GLint uniform_buffer_ = 0, storage_buffer_ = 0, dispatch_buffer_ = 0, provoking_vertex_ = 0;
    GLint cull_mode_ = 0, front_face_ = 0, depth_func_ = 0, clip_origin_ = 0, clip_depth_ = 0;
    std::array<GLint, 2> polygon_mode_{};
    std::array<GLint, 4> scissor_box_{};
    std::array<GLfloat, 4> viewport_{};
    std::array<GLfloat, 4> blend_color_{};
    std::array<GLdouble, 2> depth_range_{};
    GLfloat offset_factor_ = 0, offset_units_ = 0, line_width_ = 1;
    GLboolean depth_mask_ = GL_FALSE, scissor_ = GL_FALSE;
};

}  // namespace fumarole::gl
