#include "pass/volume_pass.h"

namespace fumarole::pass {

namespace {

GLenum gl_format(Settings::Format format)
{
    switch (format) {
    case Settings::Format::r11g11b10f:
        return GL_R11F_G11F_B10F;
    case Settings::Format::rgba16f:
        return GL_RGBA16F;
    default:
        return GL_RGBA32F;
    }
}

}  // namespace

void LayerTargets::resize(glm::ivec2 texels, Settings::Format format, bool monochrome)
{
    if (texels == size_ && format == format_ && monochrome == monochrome_)
        return;
    size_ = texels;
    format_ = format;
    monochrome_ = monochrome;
    const GLenum color = gl_format(format);
    depth_ = gl::Texture::make_2d(device_, "layer depth", texels, GL_R32F, gl::Filter::nearest);
    scattering_ =
        gl::Texture::make_2d(device_, "layer scattering", texels, color, gl::Filter::nearest);
    transmittance_ = {};
    depth_framebuffer_ = {device_, "layer depth"};
    depth_framebuffer_.attach_color({depth_.view()});
    framebuffer_ = {device_, "layer"};
    if (monochrome) {
        framebuffer_.attach_color({scattering_.view()});
    } else {
        transmittance_ = gl::Texture::make_2d(device_, "layer transmittance", texels, color,
                                              gl::Filter::nearest);
        framebuffer_.attach_color({scattering_.view(), transmittance_.view()});
    }
}

}  // namespace fumarole::pass
