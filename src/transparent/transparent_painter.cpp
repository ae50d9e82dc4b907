#include "transparent/transparent_painter.h"

#include <array>

#include "shared/bindings.h"

namespace fumarole::transparent {

void TransparentPainter::fill(const Toolbox& tools, const TransparentSet& transparents,
                              std::span<const SeenTransparent> seen, const FragmentLists& lists,
                              const PreparedFrame& frame) const
{
    const gl::Device& gl = tools.device;
    const auto time = tools.timers.scope("transparent fragments");
    lists.bind();
    lists.bind_framebuffer();
    gl->ClipControl(GL_LOWER_LEFT, frame.host.depth_convention.zero_to_one
                                       ? GL_ZERO_TO_ONE
                                       : GL_NEGATIVE_ONE_TO_ONE);
    gl->BindBufferBase(GL_UNIFORM_BUFFER, TRANSPARENT_BLOCK, block_.id());
    for (const SeenTransparent& one : seen) {
        gl::Defines defines = lists.defines();
        const gl::TextureView image = transparents.image(one);
        if (image)
            defines.emplace_back("kImage", "");
        gl::bind_texture(gl, TRANSPARENT_IMAGE_UNIT, image);
        block_.write(transparents.params(one, frame));
        gl->UseProgram(
            tools.programs.get({"transparent/fragment.vert", "transparent/fragment.frag"}, defines)
                .id());
        transparents.draw(one);
    }
    gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void TransparentPainter::resolve(const Toolbox& tools, const FragmentLists& lists,
                                 resolve::Layers* layers, const Resolved& resolved,
                                 const PreparedFrame& frame) const
{
    using Transparency = FrameSettings::Transparency;
    const gl::Device& gl = tools.device;
    const auto time = tools.timers.scope("transparent resolve");
    gl::Defines defines = lists.defines();
    if (layers != nullptr)
        defines += layers->bind_volume_at(frame);
    else
        defines.add_file("written/volume_at.glsl", "#include \"scene/volume_at_none.glsl\"\n");
    const Transparency way = frame.settings.transparency;
    if (way == Transparency::single)
        defines.emplace_back("kSingle", "");
    if (way == Transparency::doubled)
        defines.emplace_back("kDoubled", "");
    if (resolved.reads_picture || way != Transparency::split) {
        defines.emplace_back(resolved.is_done ? "kTakesPicture" : "kReadsPicture", "");
        gl::bind_texture(gl, PICTURE_UNIT, resolved.picture);
        // Each fragment reads the one texel that it then blends over.
        gl->TextureBarrier();
    }
    lists.bind();
    resolved.framebuffer.bind(frame.picture_size);
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->BlendFunci(0, resolved.of_added, GL_SRC1_COLOR);
    gl->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    tools.draw_fullscreen("transparent/resolve.frag", defines);
    gl->Disablei(GL_BLEND, 0);
}

void TransparentPainter::draw_counts(const Toolbox& tools, const FragmentLists* lists) const
{
    if (lists == nullptr) {
        constexpr std::array<GLfloat, 4> kNothing{1e30f, 0, 0, 0};  // glsl/scene/inspect.glsl
        tools.device->ClearBufferfv(GL_COLOR, 0, kNothing.data());
        return;
    }
    lists->bind();
    tools.draw_fullscreen("transparent/layers.frag", lists->defines());
}

}  // namespace fumarole::transparent
