#pragma once

#include <span>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "resolve/layers.h"
#include "toolbox.h"
#include "transparent/fine_target.h"
#include "transparent/fragment_lists.h"
#include "transparent/panes.h"
#include "transparent/transparent_set.h"

namespace fumarole::transparent {

/// Where lists of fragments are laid over a picture.
struct Resolved {
    gl::Framebuffer& framebuffer;  ///< its alpha stays
    gl::TextureView picture;       ///< picture that already has the media
    GLenum of_added = GL_ONE;      ///< factor of what is added, when it is blended
    bool reads_picture = false;    ///< a factor depends on what is behind
    bool is_done = false;          ///< the picture has the transparents already
    bool is_fine = false;          ///< the framebuffer's colour has 32 bits a channel
};

/// Lays a scene's transparents over a picture that has the media already, from lists that it draws
/// them into, or one after the other: glsl/transparent.
class TransparentPainter {
public:
    explicit TransparentPainter(const gl::Device& device)
        : block_{device, "transparent draw"}, panes_block_{device, "panes"}
    {
    }

    /// Adds to the lists. The frame's block is bound.
    void fill(const Toolbox& tools, const TransparentSet& transparents,
              std::span<const SeenTransparent> seen, const FragmentLists& lists,
              const PreparedFrame& frame) const;

    /// Blends over the framebuffer's colour.
    /// @param mask the view's, for MediaMask
    /// @param layers what the media do before any depth; null: no medium is in view
    void resolve(const Toolbox& tools, const FragmentLists& lists, gl::Texture& mask,
                 resolve::Layers* layers, const Resolved& resolved,
                 const PreparedFrame& frame) const;

    /// Blends transparents in order over the framebuffer's colour.
    /// @param sum the view's: where the picture lies meanwhile if it has less than 32 bits a
    /// channel
    /// @param mask, layers as resolve()
    void lay_in_order(const Toolbox& tools, const TransparentSet& transparents,
                      std::span<const SeenTransparent> seen, FineTarget& sum, gl::Texture& mask,
                      resolve::Layers* layers, const Resolved& resolved,
                      const PreparedFrame& frame) const;

    /// Binds panes in order for a march and for lay_panes().
    void bind_panes(const gl::Device& device, const shared::PaneParams& panes) const;
    /// Blends the panes that are bound over the framebuffer's colour.
    /// @param layer the view's: what they add to each ray of a march
    /// @param mask, layers as resolve()
    void lay_panes(const Toolbox& tools, FineTarget& layer, gl::Texture& mask,
                   resolve::Layers* layers, const Resolved& resolved,
                   const PreparedFrame& frame) const;

    /// Draws how many fragments each pixel of the bound framebuffer has. @param lists null: 0
    void draw_counts(const Toolbox& tools, const FragmentLists* lists) const;

private:
    /// Sets one up to be drawn by transparent/fragment.vert.
    void set(const Toolbox& tools, const TransparentSet& transparents, const SeenTransparent& one,
             const char* fragment_file, gl::Defines defines, const PreparedFrame& frame) const;

    gl::UniformBuffer<shared::TransparentParams> block_;
    gl::UniformBuffer<shared::PaneParams> panes_block_;
};

}  // namespace fumarole::transparent
