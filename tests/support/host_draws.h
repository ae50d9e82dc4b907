#pragma once

#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "support/gl_test.h"
#include <fumarole/errors.h>
#include <fumarole/host_glsl.h>

// What a host with a renderer of its own does, by its own programs.

namespace fumarole::test {

/// A host's program.
class HostProgram {
public:
    HostProgram(const gl::Device& gl, const std::string& vertex, const std::string& fragment)
        : gl_{gl}, id_{gl->CreateProgram()}
    {
        attach(GL_VERTEX_SHADER, vertex);
        attach(GL_FRAGMENT_SHADER, fragment);
        gl->LinkProgram(id_);
        GLint good = GL_FALSE;
        gl->GetProgramiv(id_, GL_LINK_STATUS, &good);
        std::array<char, 2000> log{};
        gl->GetProgramInfoLog(id_, GLsizei(log.size()), nullptr, log.data());
        if (good != GL_TRUE)
            throw Error(log.data());
    }
    HostProgram(const HostProgram&) = delete;
    HostProgram& operator=(const HostProgram&) = delete;
    ~HostProgram()
    {
        gl_->UseProgram(0);
        gl_->DeleteProgram(id_);
    }

    void use() const { gl_->UseProgram(id_); }
    void set(const char* name, const glm::mat4& m) const
    {
        gl_->ProgramUniformMatrix4fv(id_, at(name), 1, GL_FALSE, &m[0][0]);
    }
    void set(const char* name, glm::vec4 v) const
    {
        gl_->ProgramUniform4f(id_, at(name), v.x, v.y, v.z, v.w);
    }
    void set(const char* name, unsigned value) const
    {
        gl_->ProgramUniform1ui(id_, at(name), value);
    }

private:
    void attach(GLenum stage, const std::string& text) const
    {
        const GLuint shader = gl_->CreateShader(stage);
        const char* source = text.c_str();
        gl_->ShaderSource(shader, 1, &source, nullptr);
        gl_->CompileShader(shader);
        GLint good = GL_FALSE;
        gl_->GetShaderiv(shader, GL_COMPILE_STATUS, &good);
        std::array<char, 2000> log{};
        gl_->GetShaderInfoLog(shader, GLsizei(log.size()), nullptr, log.data());
        gl_->AttachShader(id_, shader);
        gl_->DeleteShader(shader);
        if (good != GL_TRUE)
            throw Error(log.data());
    }
    [[nodiscard]] GLint at(const char* name) const { return gl_->GetUniformLocation(id_, name); }

    const gl::Device& gl_;
    GLuint id_;
};

/// Parallelograms of the host's own, by way of the library's lists or over what it composited.
class HostPanes {
public:
    static constexpr TransparentBindings kLists{5, 6, 3, 2};
    static constexpr VolumeAtBindings kVolume{7, 9};

    explicit HostPanes(const gl::Device& gl)
        : gl_{gl}, nothing_{gl, "host's vertices"}, framebuffer_{gl, "host's picture"},
          listed_{gl, kVertex, kVersion + transparent_glsl(kLists) + R"(
in float own_view_z;
uniform vec4 color;
uniform uint blend, draw, gives_depth;
void main()
{
    if (gives_depth != 0u)
        fumarole_transparent(color, blend, draw, own_view_z);
    else
        fumarole_transparent(color, blend, draw);
}
)"},
          forward_{gl, kVertex, kVersion + volume_at_glsl(kVolume) + R"(
in float own_view_z;
uniform vec4 color;
uniform uint blend;
layout(location = 0, index = 0) out vec4 added;
layout(location = 0, index = 1) out vec4 kept;
void main()
{
    fumarole_VolumeAt media = fumarole_volume_at(gl_FragCoord.xy, own_view_z);
    vec3 own = blend == 0u ? color.rgb * color.a : blend == 3u ? vec3(0.0) : color.rgb;
    kept = vec4(blend < 2u ? vec3(1.0 - color.a) : blend == 2u ? vec3(1.0) : color.rgb, 1.0);
    added = vec4(media.transmittance * own + media.scattering * (1.0 - kept.rgb), 0.0);
}
)"}
    {
    }

    /// A pane's corner and edges, seen from a frame's camera as the library's own draws see it.
    struct Place {
        glm::dvec3 corner{0};
        std::array<glm::dvec3, 2> edges{};

        [[nodiscard]] glm::dmat4 world_from_object() const
        {
            return {glm::dvec4(edges[0], 0), glm::dvec4(edges[1], 0), glm::dvec4(0),
                    glm::dvec4(corner, 1)};
        }
        /// Nearest and farthest view_z [m].
        [[nodiscard]] TransparentExtent extent(const Frame& frame) const
        {
            TransparentExtent extent;
            extent.view_z = {1e300, -1e300};
            for (const glm::dvec2 at : {glm::dvec2(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
                const double z =
                    -(frame.view_from_world * world_from_object() * glm::dvec4(at, 0, 1)).z;
                extent.view_z = {std::min(extent.view_z.x, z), std::max(extent.view_z.y, z)};
            }
            return extent;
        }
    };

    /// Between begin_transparents() and end_transparents(), which are the caller's.
    void list(const Frame& frame, const Place& place, glm::vec4 color, unsigned blend,
              unsigned draw, bool gives_depth = true) const
    {
        set_place(listed_, frame, place);
        listed_.set("color", color);
        listed_.set("blend", blend);
        listed_.set("draw", draw);
        listed_.set("gives_depth", gives_depth ? 1u : 0u);
        gl_->BindVertexArray(nothing_.id());
        gl_->ClipControl(GL_LOWER_LEFT, frame.depth_convention.zero_to_one
                                            ? GL_ZERO_TO_ONE
                                            : GL_NEGATIVE_ONE_TO_ONE);
        gl_->DrawArrays(GL_TRIANGLES, 0, 6);
        gl_->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    }

    /// Over a picture that composite() has been at; no depth is tested.
    /// @param blend 0: alpha, 1: premultiplied, 2: add, 3: multiply
    void shade(const Frame& frame, const VolumeAtNames& media, const Place& place, glm::vec4 color,
               unsigned blend)
    {
        framebuffer_.attach_color({frame.color});
        framebuffer_.bind(glm::ivec2(frame.color.size));
        gl_->BindBufferBase(GL_UNIFORM_BUFFER, kVolume.block, media.block);
        gl_->BindTextures(kVolume.first_unit, kVolumeAtUnits, media.textures.data());
        set_place(forward_, frame, place);
        forward_.set("color", color);
        forward_.set("blend", blend);
        gl_->Enable(GL_BLEND);
        gl_->BlendFunc(GL_ONE, GL_SRC1_COLOR);
        gl_->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
        gl_->BindVertexArray(nothing_.id());
        gl_->DrawArrays(GL_TRIANGLES, 0, 6);
        gl_->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl_->BlendFunc(GL_ONE, GL_ZERO);
        gl_->Disable(GL_BLEND);
        for (int i = 0; i < kVolumeAtUnits; ++i)
            gl_->BindTextureUnit(kVolume.first_unit + GLuint(i), 0);
        framebuffer_.detach_color();
        gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    }

private:
    inline static const std::string kVersion = "#version 450 core\n";
    inline static const std::string kVertex = R"(#version 450 core
uniform mat4 clip_from_object;
uniform vec4 view_z_from_object;
out float own_view_z;
void main()
{
    const vec2 corners[6] = vec2[](vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 0), vec2(1, 1), vec2(0, 1));
    vec4 p = vec4(corners[gl_VertexID], 0, 1);
    own_view_z = dot(view_z_from_object, p);
    gl_Position = clip_from_object * p;
}
)";

    static void set_place(const HostProgram& program, const Frame& frame, const Place& place)
    {
        // From the eye, as the library has it: a rotation, and a difference of places in double.
        const glm::dmat3 rotation(frame.view_from_world);
        const glm::dvec3 eye = -(glm::transpose(rotation) * glm::dvec3(frame.view_from_world[3]));
        glm::dmat4 from_eye(1.0);
        from_eye[3] = glm::dvec4(-eye, 1);
        const glm::dmat4 view_from_object =
            glm::dmat4(rotation) * from_eye * place.world_from_object();
        program.set("clip_from_object", glm::mat4(frame.clip_from_view * view_from_object));
        program.set("view_z_from_object", glm::vec4(-glm::transpose(view_from_object)[2]));
        program.use();
    }

    const gl::Device& gl_;
    gl::VertexArray nothing_;
    gl::Framebuffer framebuffer_;
    HostProgram listed_, forward_;
};

/// The key's two factors, as FUMAROLE_BLEND_* name them in GLSL.
inline unsigned host_blend(unsigned source, unsigned behind)
{
    return source << 4u | behind;
}

}  // namespace fumarole::test
