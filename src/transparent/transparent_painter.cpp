#include "transparent/transparent_painter.h"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <optional>

#include "shared/bindings.h"
#include "transparent/media_mask.h"

namespace fumarole::transparent {

namespace {

/// What is drawn is laid over a picture: its factors are the second source of blending.
class BlendOver {
public:
    BlendOver(const Toolbox& tools, const gl::Framebuffer& framebuffer, GLenum of_added,
              const PreparedFrame& frame)
        : gl_{tools.device}
    {
        framebuffer.bind(frame.picture_size);
        gl_->Enablei(GL_BLEND, 0);
        gl_->BlendEquationi(0, GL_FUNC_ADD);
        gl_->BlendFunci(0, of_added, GL_SRC1_COLOR);
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

/// Blends over a framebuffer what `draw` draws in a variant, by what the media do where they are
/// seen. The rest is as TransparentPainter::resolve() has it.
template <class Draw>
void blend_through_media(const Toolbox& tools, gl::Texture& mask, resolve::Layers* layers,
                         gl::Framebuffer& framebuffer, GLenum of_added, const PreparedFrame& frame,
                         const gl::Defines& defines, const Draw& draw)
{
    if (layers == nullptr) {
        const BlendOver blend(tools, framebuffer, of_added, frame);
        draw(without_media(defines));
        return;
    }
    gl::Defines media = defines;
    media += layers->bind_volume_at(frame);
    if (layers->media_tiles() == nullptr) {
        const BlendOver blend(tools, framebuffer, of_added, frame);
        draw(media);
        return;
    }
    const MediaMask where(tools, *layers->media_tiles(), mask, framebuffer, frame);
    const BlendOver blend(tools, framebuffer, of_added, frame);
    where.where_none();
    draw(without_media(defines));
    where.where_media();
    draw(media);
}

/// Lets pieces be drawn within their part of the picture alone.
class WithinParts {
public:
    explicit WithinParts(const gl::Device& gl) : gl_{gl}
    {
        gl_->GetIntegeri_v(GL_SCISSOR_BOX, 0, box_.data());
    }
    ~WithinParts()
    {
        gl_->Disablei(GL_SCISSOR_TEST, 0);
        gl_->ScissorIndexed(0, box_[0], box_[1], box_[2], box_[3]);
    }
    WithinParts(const WithinParts&) = delete;
    WithinParts& operator=(const WithinParts&) = delete;

    /// @returns whether it has any
    [[nodiscard]] bool let(const SeenTransparent& one, const PreparedFrame& frame) const
    {
        if (one.cuts.empty()) {
            gl_->Disablei(GL_SCISSOR_TEST, 0);
            return true;
        }
        constexpr double kAround = 1;  // a line is not where corners are to the last bit
        const glm::dvec2 size(frame.picture_size);
        const glm::ivec2 low(glm::clamp(glm::floor(one.area.low - kAround), glm::dvec2(0), size));
        const glm::ivec2 high(
            glm::clamp(glm::ceil(one.area.high + kAround), glm::dvec2(low), size));
        gl_->Enablei(GL_SCISSOR_TEST, 0);
        gl_->ScissorIndexed(0, low.x, low.y, high.x - low.x, high.y - low.y);
        return glm::all(glm::lessThan(low, high));
    }

private:
    const gl::Device& gl_;
    std::array<GLint, 4> box_{};
};

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
    for (const SeenTransparent& one : seen) {
        set(tools, transparents, one, "transparent/fragment.frag", lists.defines(), frame);
        transparents.draw(one);
    }
    gl->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
}

void TransparentPainter::set(const Toolbox& tools, const TransparentSet& transparents,
                             const SeenTransparent& one, const char* fragment_file,
                             gl::Defines defines, const PreparedFrame& frame) const
{
    const gl::Device& gl = tools.device;
    const gl::TextureView image = transparents.image(one);
    if (image)
        defines.emplace_back("kImage", "");
    if (transparents.fades(one))
        defines.emplace_back("kFades", "");
    gl::bind_texture(gl, TRANSPARENT_IMAGE_UNIT, image);
    block_.write(transparents.params(one, frame));
    gl->BindBufferBase(GL_UNIFORM_BUFFER, TRANSPARENT_BLOCK, block_.id());
    gl->UseProgram(tools.programs.get({"transparent/fragment.vert", fragment_file}, defines).id());
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
    blend_through_media(tools, mask, layers, resolved.framebuffer, resolved.of_added, frame,
                        defines, [&](const gl::Defines& variant) {
                            tools.draw_fullscreen("transparent/resolve.frag", variant);
                        });
}

void TransparentPainter::lay_in_order(const Toolbox& tools, const TransparentSet& transparents,
                                      std::span<const SeenTransparent> seen, FineTarget& sum,
                                      gl::Texture& mask, resolve::Layers* layers,
                                      const Resolved& resolved, const PreparedFrame& frame) const
{
    const gl::Device& gl = tools.device;
    const auto time = tools.timers.scope("transparents in order");
    glm::dvec2 low(frame.picture_size), high(0);
    for (const SeenTransparent& one : seen) {
        low = glm::min(low, one.area.low);
        high = glm::max(high, one.area.high);
    }
    const glm::ivec2 first = glm::max(glm::floor(low), 0.0);
    const glm::ivec2 end = glm::min(glm::ceil(high), glm::dvec2(frame.picture_size));
    if (!glm::all(glm::lessThan(first, end)))
        return;
    if (!resolved.is_fine) {
        sum.resize(gl, frame.picture_size);
        sum.framebuffer.copy_color_of(resolved.framebuffer, first, end);
    }
    const bool has_pieces = std::any_of(
        seen.begin(), seen.end(), [](const SeenTransparent& one) { return !one.cuts.empty(); });
    const auto draw_all = [&](const gl::Defines& variant) {
        std::optional<WithinParts> within;
        if (has_pieces)
            within.emplace(gl);
        for (std::size_t i = seen.size(); i-- > 0;) {
            if (within && !within->let(seen[i], frame))
                continue;
            gl::Defines own = variant;
            if (const float weight = transparents.of_behind(seen[i]); weight != 0)
                own.emplace_back("kOfBehind", fmt::format("{:.1f}", weight));
            if (!seen[i].cuts.empty())
                own.emplace_back("kCutFours", fmt::format("{}", (seen[i].cuts.size() + 3) / 4));
            set(tools, transparents, seen[i], "transparent/over.frag", std::move(own), frame);
            transparents.draw_in_order(seen[i], frame);
        }
    };
    gl::Defines defines{{"kOver", ""}};
    if (frame.panes > 0)
        defines.emplace_back("kKeptAtPanes", "");
    blend_through_media(tools, mask, layers,
                        resolved.is_fine ? resolved.framebuffer : sum.framebuffer,
                        resolved.of_added, frame, defines, draw_all);
    if (resolved.is_fine)
        return;
    resolved.framebuffer.bind(frame.picture_size);
    gl->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    gl->ViewportIndexedf(0, static_cast<GLfloat>(first.x), static_cast<GLfloat>(first.y),
                         static_cast<GLfloat>(end.x - first.x),
                         static_cast<GLfloat>(end.y - first.y));
    gl::bind_texture(gl, PICTURE_UNIT, sum.texture.view());
    tools.draw_fullscreen("transparent/put_back.frag", {});
}

void TransparentPainter::bind_panes(const gl::Device& device, const shared::PaneParams& panes) const
{
    panes_block_.write(panes);
    device->BindBufferBase(GL_UNIFORM_BUFFER, PANES_BLOCK, panes_block_.id());
}

void TransparentPainter::lay_panes(const Toolbox& tools, FineTarget& layer, gl::Texture& mask,
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
        const BlendOver blend(tools, resolved.framebuffer, resolved.of_added, frame);
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
    layer.texture.bind(PANE_LAYER_UNIT);
    const MediaMask where(tools, tiles, mask, resolved.framebuffer, frame);
    const BlendOver blend(tools, resolved.framebuffer, resolved.of_added, frame);
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
