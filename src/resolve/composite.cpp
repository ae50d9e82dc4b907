#include "resolve/composite.h"

#include <fmt/format.h>

namespace fumarole::resolve {

void composite(const Toolbox& tools, Layers& layers, const gl::Framebuffer& picture,
               const PreparedFrame& frame)
{
    const gl::Device& gl = tools.device;
    const auto blend = [&](GLenum source, GLenum destination, Layer layer, const char* what) {
        const auto time = tools.timers.scope(fmt::format("{} {}", layers.resolve_name(), what));
        gl->BlendFunci(0, source, destination);
        layers.resolve(frame, layer);
    };
    picture.bind(frame.picture_size);
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    if (tools.monochrome(frame.settings)) {
        blend(GL_ONE, GL_SRC_ALPHA, Layer::scattering, "both");
    } else if (frame.settings.resolve_passes == 1) {
        blend(GL_ONE, GL_SRC1_COLOR, Layer::both, "both");
    } else {
        blend(GL_ZERO, GL_SRC_COLOR, Layer::transmittance, "transmittance");
        blend(GL_ONE, GL_ONE, Layer::scattering, "scattering");
    }
}

void draw_layer(const Toolbox& tools, Layers& layers, const PreparedFrame& frame, Layer layer)
{
    const gl::Device& gl = tools.device;
    if (layer == Layer::scattering) {
        layers.resolve(frame, layer);
        return;
    }
    // White times transmittance, which may be in an alpha that the picture has no place for.
    const bool in_alpha = tools.monochrome(frame.settings);
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->BlendFunci(0, GL_ZERO, in_alpha ? GL_SRC_ALPHA : GL_SRC_COLOR);
    layers.resolve(frame, in_alpha ? Layer::scattering : layer);
    gl->Disablei(GL_BLEND, 0);
}

}  // namespace fumarole::resolve
