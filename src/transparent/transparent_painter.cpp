#include "transparent/transparent_painter.h"

#include <array>
#include <fmt/format.h>

#include "shared/bindings.h"
#include "transparent/media_mask.h"

namespace fumarole::transparent {

namespace {

/// What is drawn is laid over a picture: its factors are the second source of blending.
class BlendOver {
public:
    BlendOver(const Toolbox& tools, const Resolved& resolved, const PreparedFrame& frame)
        : gl_{tools.device}
    {
        resolved.framebuffer.bind(frame.picture_size);
        gl_->Enablei(GL_BLEND, 0);
        gl_->BlendEquationi(0, GL_FUNC_ADD);
        gl_->BlendFunci(0, resolved.of_added, GL_SRC1_COLOR);
        gl_->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    }
    ~BlendOver() { gl_->Disablei(GL_BLEND, 0); }
    BlendOver(const BlendOver&) = delete;
    BlendOver& operator=(const BlendOver&) = delete;

private:
    const gl::Device& gl_;
};

gl::Defines without_media(gl::Defines defines)
{
    defines.add_file("written/volume_at.glsl", "#include \"scene/volume_at_none.glsl\"\n");
    return defines;
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
                                 gl::Texture& mask, resolve::Layers* layers,
                                 const Resolved& resolved, const PreparedFrame& frame) const
{
    using Transparency = FrameSettings::Transparency;
    const gl::Device& gl = tools.device;
    const auto time = tools.timers.scope("transparent resolve");
    gl::Defines defines = lists.defines();
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
    const auto draw = [&](const gl::Defines& variant) {
        tools.draw_fullscreen("transparent/resolve.frag", variant);
    };
    if (layers == nullptr) {
        const BlendOver blend(tools, resolved, frame);
        draw(without_media(defines));
        return;
    }
    gl::Defines media = defines;
    media += layers->bind_volume_at(frame);
    if (layers->media_tiles() == nullptr) {
        const BlendOver blend(tools, resolved, frame);
        draw(media);
        return;
    }
    const MediaMask where(tools, *layers->media_tiles(), mask, resolved.framebuffer, frame);
    const BlendOver blend(tools, resolved, frame);
    where.where_none();
    draw(without_media(defines));
    where.where_media();
    draw(media);
}

void TransparentPainter::bind_panes(const gl::Device& device, const shared::PaneParams& panes) const
{
    panes_block_.write(panes);
    device->BindBufferBase(GL_UNIFORM_BUFFER, PANES_BLOCK, panes_block_.id());
}

void TransparentPainter::lay_panes(const Toolbox& tools, PaneLayer& layer, gl::Texture& mask,
                                   resolve::Layers* layers, const Resolved& resolved,
                                   const PreparedFrame& frame) const
{
    const gl::Defines places{{"kPaneCount", fmt::format("{}", frame.pane_places)}};
    gl::Defines none = without_media(places), media = places;
    none.emplace_back("kNoMedia", "");
    if (layers != nullptr)
        media += layers->bind_volume_at(frame);
    else
        media = none;
    const auto draw = [&](const gl::Defines& variant) {
        draw_panes(tools, "transparent/panes.frag", variant);
    };
    if (layers == nullptr || layers->media_tiles() == nullptr) {
        const auto time = tools.timers.scope("transparent panes");
        const BlendOver blend(tools, resolved, frame);
        draw(media);
        return;
    }
    const pass::StepTiles& tiles = *layers->media_tiles();
    {
        const auto time = tools.timers.scope("transparent layer");
        layer.resize(tools.device, frame.layer_size);
        layer.framebuffer.bind(frame.layer_size);
        tools.device->Disablei(GL_BLEND, 0);
        tools.device->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl::Defines bare = media;
        bare.emplace_back("kNoMedia", "");
        tiles.draw_depth("transparent/pane_layer", bare, false);
        tiles.draw_depth("transparent/pane_layer", media, true);
    }
    const auto time = tools.timers.scope("transparent panes");
    layer.added.bind(PANE_LAYER_UNIT);
    const MediaMask where(tools, tiles, mask, resolved.framebuffer, frame);
    const BlendOver blend(tools, resolved, frame);
    gl::Defines none_of_tiles = none;
    none_of_tiles.emplace_back("kLayerScale", fmt::format("{}", frame.settings.resolution));
    where.everywhere();
    tiles.draw_picture("transparent/pane_tiles", none_of_tiles);
    tiles.draw_picture("transparent/pane_tiles", media);
    resolved.framebuffer.bind(frame.picture_size);
    where.where_none();
    draw(none);
    where.where_media();
    media.emplace_back("kPaneLayer", "");
    draw(media);
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
