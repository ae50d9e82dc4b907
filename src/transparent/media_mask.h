#pragma once

#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "pass/step_tiles.h"
#include "prepared_frame.h"
#include "toolbox.h"

namespace fumarole::transparent {

/// A depth buffer that tells pixels apart by whether they may see a medium, so that what is laid
/// over the others looks nothing up, and by whether they are done with. It is attached to a
/// framebuffer, and depths are tested, as long as it lives. What is drawn with it lies at a clip
/// depth of 0; what is done with its pixels, at -0.5.
class MediaMask {
public:
    /// @param depth is made anew if it has another size
    MediaMask(const Toolbox& tools, const pass::StepTiles& media, gl::Texture& depth,
              gl::Framebuffer& framebuffer, const PreparedFrame& frame);
    ~MediaMask();
    MediaMask(const MediaMask&) = delete;
    MediaMask& operator=(const MediaMask&) = delete;

    /// Lets draw anywhere, and do with what is drawn.
    void everywhere() const;
    /// Lets draw where no medium is seen.
    void where_none() const;
    /// Lets draw where one may be. Neither draws where it is done.
    void where_media() const;

private:
    const gl::Device& gl_;
    gl::Framebuffer& framebuffer_;
};

}  // namespace fumarole::transparent
