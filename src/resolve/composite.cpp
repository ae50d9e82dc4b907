#include "resolve/composite.h"

#include <array>
#include <fmt/format.h>

#include "shared/bindings.h"

namespace fumarole::resolve {

namespace {

/// The factor as the blending stage has it: of the picture, with what is laid over it as source.
GLenum blend_factor(const LayerBlend& blend)
{
    constexpr std::array kFactors{GL_ZERO, GL_ONE, GL_SRC_ALPHA, GL_SRC_COLOR, GL_SRC1_COLOR};
    return static_cast<GLenum>(kFactors.at(static_cast<std::size_t>(blend.factor)));
}

/// The framebuffer, or the image, is bound.
void lay_over(const Toolbox& tools, Layers& layers, const Canvas& canvas,
              const PreparedFrame& frame, const LayerBlend& blend)
{
    const gl::Device& gl = tools.device;
    if (!canvas.image) {
        const bool blends = blend.factor != FACTOR_ZERO;
        if (blends) {
            gl->Enablei(GL_BLEND, 0);
            gl->BlendEquationi(0, GL_FUNC_ADD);
            gl->BlendFunci(0, blend.adds ? GL_ONE : GL_ZERO, blend_factor(blend));
        }
        layers.resolve(frame, blend.layer, canvas, {});
        if (blends)
            gl->Disablei(GL_BLEND, 0);
        return;
    }
    gl->BindImageTexture(PICTURE_IMAGE, canvas.texture.id, 0, GL_FALSE, 0, GL_READ_WRITE,
                         canvas.image->format);
    gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);  // after whoever read or stored it
    layers.resolve(frame, blend.layer, canvas,
                   {{"PICTURE_FORMAT", canvas.image->name},
                    {"kAdds", blend.adds ? "true" : "false"},
                    {"kFactor", fmt::format("{}", blend.factor)},
                    {"kNormalized", canvas.image->normalized ? "true" : "false"}});
}

/// A picture that was stored to may be drawn to, sampled, stored to and read back by its host.
void let_host_have(const Toolbox& tools, const Canvas& canvas)
{
    if (canvas.image)
        tools.device->MemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT |
                                    GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                                    GL_TEXTURE_UPDATE_BARRIER_BIT);
}

}  // namespace

Canvas make_canvas(const Toolbox& tools, const gl::Framebuffer& framebuffer,
                   gl::TextureView texture, const FrameSettings& settings)
{
    Canvas canvas{framebuffer, texture, {}};
    if (tools.computes(settings))
        canvas.image = gl::image_format(tools.device, texture);
    return canvas;
}

void composite(const Toolbox& tools, Layers& layers, const Canvas& canvas,
               const PreparedFrame& frame)
{
    const auto lay = [&](const LayerBlend& blend, const char* what) {
        const auto time = tools.timers.scope(fmt::format("{} {}", layers.resolve_name(), what));
        lay_over(tools, layers, canvas, frame, blend);
    };
    if (!canvas.image) {
        canvas.framebuffer.bind(frame.picture_size);
        tools.device->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    }
    if (tools.monochrome(frame.settings)) {
        lay({Layer::scattering, true, FACTOR_ALPHA}, "both");
    } else if (frame.settings.resolve_passes == 1) {
        lay({Layer::both, true, FACTOR_TRANSMITTANCE}, "both");
    } else {
        lay({Layer::transmittance, false, FACTOR_COLOR}, "transmittance");
        lay({Layer::scattering, true, FACTOR_ONE}, "scattering");
    }
    let_host_have(tools, canvas);
}

void draw_layer(const Toolbox& tools, Layers& layers, const Canvas& canvas,
                const PreparedFrame& frame, Layer layer)
{
    if (layer == Layer::scattering)
        lay_over(tools, layers, canvas, frame, {layer, true, FACTOR_ZERO});
    else if (tools.monochrome(frame.settings))  // what is 1 times an alpha
        lay_over(tools, layers, canvas, frame, {Layer::scattering, false, FACTOR_ALPHA});
    else
        lay_over(tools, layers, canvas, frame, {layer, false, FACTOR_COLOR});
    let_host_have(tools, canvas);
}

}  // namespace fumarole::resolve
