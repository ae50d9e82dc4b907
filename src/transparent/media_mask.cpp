#include "transparent/media_mask.h"

namespace fumarole::transparent {

MediaMask::MediaMask(const Toolbox& tools, const pass::StepTiles& media, gl::Texture& depth,
                     gl::Framebuffer& framebuffer, const PreparedFrame& frame)
    : gl_{tools.device}, framebuffer_{framebuffer}
{
    if (!depth || glm::ivec2(depth.size()) != frame.picture_size)
        depth = gl::Texture::make_2d(gl_, "where media are seen", frame.picture_size,
                                     GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    framebuffer_.attach_depth(depth.view());
    constexpr GLfloat kNone = 1;
    gl_->Enable(GL_DEPTH_TEST);
    gl_->DepthFunc(GL_LESS);
    gl_->DepthMask(GL_TRUE);
    gl_->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &kNone);
    gl_->ColorMaski(0, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    framebuffer_.bind(frame.picture_size);
    media.run_picture("transparent/media_mask", {}, false);
}

MediaMask::~MediaMask()
{
    gl_->Disable(GL_DEPTH_TEST);
    framebuffer_.attach_depth({});
}

void MediaMask::everywhere() const
{
    gl_->DepthFunc(GL_ALWAYS);
    gl_->DepthMask(GL_TRUE);
}

void MediaMask::where_none() const
{
    gl_->DepthFunc(GL_LESS);
    gl_->DepthMask(GL_FALSE);
}

void MediaMask::where_media() const
{
    gl_->DepthFunc(GL_EQUAL);
    gl_->DepthMask(GL_FALSE);
}

}  // namespace fumarole::transparent
