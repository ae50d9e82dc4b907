#include "transparent/transparent_painter.h"

#include <array>
#include <fmt/format.h>
#include <functional>

#include "shared/bindings.h"

namespace fumarole::transparent {

namespace {

void blend_over(const Toolbox& tools, const Resolved& resolved, const PreparedFrame& frame,
                const std::function<void()>& draw)
{
    const gl::Device& gl = tools.device;
    resolved.framebuffer.bind(frame.picture_size);
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->BlendFunci(0, resolved.of_added, GL_SRC1_COLOR);
    gl->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    draw();
    gl->Disablei(GL_BLEND, 0);
}

void draw_panes(const Toolbox& tools, const char* fragment_file, const gl::Defines& defines)
{
    tools.device->UseProgram(
        tools.programs.get({"transparent/panes.vert", fragment_file}, defines).id());
    tools.device->BindVertexArray(tools.fullscreen.id());
    tools.device->DrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

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
    blend_over(tools, resolved, frame,
               [&] { tools.draw_fullscreen("transparent/resolve.frag", defines); });
}

void TransparentPainter::bind_panes(const gl::Device& device, const shared::PaneParams& panes) const
{
    panes_block_.write(panes);
    device->BindBufferBase(GL_UNIFORM_BUFFER, PANES_BLOCK, panes_block_.id());
}

void TransparentPainter::lay_panes(const Toolbox& tools, PaneLayer& layer, resolve::Layers* layers,
                                   const Resolved& resolved, const PreparedFrame& frame) const
{
    gl::Defines defines;
    if (layers != nullptr)
        defines = layers->bind_volume_at(frame);
    else
        defines.add_file("written/volume_at.glsl", "#include \"scene/volume_at_none.glsl\"\n");
    defines.emplace_back("kPaneCount", fmt::format("{}", frame.pane_places));
    if (layers == nullptr || frame.settings.mode != FrameSettings::Mode::raymarch) {
        const auto time = tools.timers.scope("transparent panes");
        blend_over(tools, resolved, frame,
                   [&] { draw_panes(tools, "transparent/panes.frag", defines); });
        return;
    }
    gl::Defines of_layer = defines;
    {
        const auto time = tools.timers.scope("transparent layer");
        of_layer.emplace_back("kOfLayer", "");
        layer.resize(tools.device, frame.layer_size);
        layer.framebuffer.bind(frame.layer_size);
        tools.device->Disablei(GL_BLEND, 0);
        tools.device->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        draw_panes(tools, "transparent/pane_layer.frag", of_layer);
    }
    const auto time = tools.timers.scope("transparent panes");
    layer.added.bind(PANE_LAYER_UNIT);
    layer.resize_left(tools.device, frame.picture_size);
    gl::Framebuffer& framebuffer = resolved.framebuffer;
    framebuffer.attach_depth(layer.left.view());
    const gl::Device& gl = tools.device;
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LESS);
    gl->DepthMask(GL_TRUE);
    constexpr GLfloat kLeft = 1;
    gl->ClearNamedFramebufferfv(framebuffer.id(), GL_DEPTH, 0, &kLeft);
    blend_over(tools, resolved, frame, [&] {
        gl::Defines at_once = defines;
        at_once.emplace_back("kPaneLayer", "");
        draw_panes(tools, "transparent/panes.frag", at_once);
        gl->DepthMask(GL_FALSE);
        draw_panes(tools, "transparent/panes.frag", defines);
    });
    gl->Disable(GL_DEPTH_TEST);
    framebuffer.attach_depth({});
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
