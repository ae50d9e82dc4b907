#pragma once

#include <limits>
#include <string>
#include <vector>

#include "gl/program.h"
#include "gl/texture.h"
#include "pass/step_slots.h"
#include "pass/sun_shades.h"
#include "pass/tile_list.h"
#include "pass/volume_pass.h"

namespace fumarole::pass {

/// What of the picture and of the view's depth can hold a medium, tile by tile: the bricks that are
/// not empty, projected; and how long its steps may be, by the medium and by where shadows end.
/// Worked out on the CPU for each frame, so that no ray looks for them; a tile that no brick
/// reaches costs no fragment.
class StepTiles {
public:
    /// Texels of the layer, and pixels of the picture, along a tile's edge.
    static constexpr int kLayerTile = 4, kPictureTile = 16;

    explicit StepTiles(const Toolbox& tools) : tools_{tools} {}

    /// For the frame's camera; all tiles and all depths where bricks are not to be skipped. Where
    /// the frame's passes are compute shaders, what earlier ones have read and stored is done with.
    void set(const PreparedFrame& frame);

    /// Runs a pass, `pass/ray_march`, over the texels that march, over those whose depth is asked
    /// for, or over the pixels that see a medium: its .frag, into the framebuffer that is bound,
    /// whose viewport is changed, or its .comp, into the images that are bound, as the frame has
    /// it.
    void run_tiles(const char* pass, const gl::Defines& defines) const;
    /// Likewise one that lights the media: where no surface hides a sun it is a variant that does
    /// not ask.
    void run_march(const char* pass, const gl::Defines& defines) const;
    void run_depth(const char* pass, const gl::Defines& defines) const;
    /// @param computes whether it is the .comp
    void run_picture(const char* pass, const gl::Defines& defines, bool computes) const;

    /// Draws a pass over texels whose depth is asked for: over those that keep what they meet at
    /// the frame's depths, or over the others.
    void draw_depth(const char* pass, gl::Defines defines, bool keeps) const;
    /// Draws a pass over pixels that see a medium, or over others, as its vertex shader has it,
    /// which stands in for pass/tiles.vert.
    void draw_picture(const char* pass, const gl::Defines& defines) const;

    /// Whether a tile of the march keeps what its rays meet at the frame's depths: one a tile.
    [[nodiscard]] std::vector<bool> keeps_depths() const;

    /// What the passes of the frame are.
    [[nodiscard]] bool computes() const { return computes_; }

private:
    /// A texel a tile, as StepSlots::tile() makes it. Where its first number is 0 it is not drawn.
    struct Tiles {
        explicit Tiles(int edge) : pixels{edge} {}
        int pixels;  ///< along a tile's edge
        glm::ivec2 count{0};
        std::vector<glm::uvec4> texels;
        gl::Texture texture;
    };
    /// Which of the march's tiles a pass runs over.
    enum class Which { all, lit, shaded };
    /// A frame, and what of it all steps ask for.
    struct View {
        explicit View(const PreparedFrame& of);
        const PreparedFrame& frame;
        StepSlots slots;
        double scale;       ///< pixels of a texel
        glm::dvec2 offset;  ///< of the layer's first texel from the picture's, in texels
        double reach;       ///< of the layer's texels that a pixel is made of, those on either side
    };
    /// What a tile of the march sees of the media.
    struct Seen {
        std::uint64_t slots = 0;
        double longest = std::numeric_limits<double>::infinity();  ///< step [m]
        double most = 0;                                           ///< extinction [1/m]
    };
    /// Those whose rays keep what they have met at the frame's depths.
    void mark_depths_asked(const PreparedFrame& frame);
    void see_media(const View& view);
    void choose_steps(const View& view);
    void want_depths(const View& view);
    void upload(const char* label, Tiles& tiles) const;
    void list();
    /// Over tiles of the march.
    void run(Which which, const char* pass, gl::Defines defines) const;
    void draw(const Tiles& tiles, const char* pass, gl::Defines defines,
              const std::string& vertex_file = "pass/tiles.vert") const;
    void dispatch(const Tiles& tiles, const TileList& list, const char* pass,
                  gl::Defines defines) const;

    const Toolbox& tools_;
    Tiles march_{kLayerTile}, depth_{kLayerTile}, picture_{kPictureTile};
    std::vector<Seen> seen_;
    bool lit_ = false, shaded_ = false;  ///< whether there are tiles that no surface shades; others
    bool computes_ = false;
    TileList lit_list_, shaded_list_, depth_list_, picture_list_;
};

}  // namespace fumarole::pass
