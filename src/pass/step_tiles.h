#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "gl/program.h"
#include "gl/texture.h"
#include "pass/step_boxes.h"
#include "pass/step_slots.h"
#include "pass/step_view.h"
#include "pass/sun_shades.h"
#include "pass/tile_list.h"
#include "pass/volume_pass.h"

namespace fumarole::pass {

/// Which of the march's tiles a pass runs over.
struct TilePart {
    std::optional<bool> lit;  ///< those that no surface shades; the others; nothing: both
    std::optional<bool> far;  ///< likewise those that lights are far from
};

/// What of the picture and of the view's depth can hold a medium, tile by tile: the bricks that are
/// not empty, projected; and how long its steps may be, by the medium and by where shadows end.
/// Worked out for each frame, so that no ray looks for them; a tile that no brick reaches costs no
/// fragment. On the CPU, or, where the frame's passes are compute shaders and nothing that the CPU
/// alone has is asked for, by those of StepBoxes.
class StepTiles {
public:
    /// Texels of the layer, and pixels of the picture, along a tile's edge.
    static constexpr int kLayerTile = shared::kLayerTile, kPictureTile = shared::kPictureTile;

    explicit StepTiles(const Toolbox& tools) : tools_{tools}, boxes_{tools} {}

    /// For the frame's camera; all tiles and all depths where bricks are not to be skipped. Where
    /// the frame's passes are compute shaders, what earlier ones have read and stored is done with.
    void set(const PreparedFrame& frame);

    /// Runs a pass, `pass/ray_march`, over the texels that march, over those whose depth is asked
    /// for, or over the pixels that see a medium: its .frag, into the framebuffer that is bound,
    /// whose viewport is changed, or its .comp, into the images that are bound, as the frame has
    /// it.
    void run_tiles(const char* pass, const gl::Defines& defines) const;
    /// Likewise one that lights the media: where no surface hides a sun it is a variant that does
    /// not ask, and where all lights are far another, that takes 1/d^2 for a parabola.
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
    /// Whether the GPU has worked out the frame's tiles.
    [[nodiscard]] bool on_gpu() const { return on_gpu_; }
    /// The frame's tiles of the march, of its layer's depth and of the picture, a texel each.
    [[nodiscard]] std::array<const gl::Texture*, 3> textures() const
    {
        return {&march_.texture, &depth_.texture, &picture_.texture};
    }

private:
    /// A texel a tile, as StepSlots::tile() makes it. Where its first number is 0 it is not drawn.
    struct Tiles {
        explicit Tiles(int edge) : pixels{edge} {}
        int pixels;  ///< along a tile's edge
        glm::ivec2 count{0};
        std::vector<glm::uvec4> texels;
        gl::Texture texture;
    };
    /// What a tile of the march sees of the media.
    struct Seen {
        std::uint64_t slots = 0;
        float longest = std::numeric_limits<float>::infinity();  ///< step [m]
        float most = 0;                                          ///< extinction [1/m]
    };
    /// Those whose rays keep what they have met at the frame's depths.
    void mark_depths_asked(const PreparedFrame& frame);
    [[nodiscard]] StepView view_of(const PreparedFrame& frame);
    [[nodiscard]] bool is_there(const TilePart& which) const;
    void set_on_cpu(const PreparedFrame& frame, const StepView* view);
    void set_on_gpu(const PreparedFrame& frame, const StepView& view);
    void see_media(const StepView& view);
    void choose_steps(const StepView& view);
    void want_depths(const StepView& view);
    /// Leaves of the tiles those that the frame's fine layer has; of its main one's, whose march
    /// goes on over all, the picture's others.
    void part(const PreparedFrame& frame);
    void make_texture(const char* label, Tiles& tiles) const;
    void upload(const char* label, Tiles& tiles) const;
    void list();
    /// Over tiles of the march.
    void run(const TilePart& which, const char* pass, gl::Defines defines) const;
    void draw(const Tiles& tiles, const char* pass, gl::Defines defines,
              const std::string& vertex_file = "pass/tiles.vert") const;
    void dispatch(const Tiles& tiles, const TileList& list, const char* pass,
                  gl::Defines defines) const;

    const Toolbox& tools_;
    Tiles march_{kLayerTile}, depth_{kLayerTile}, picture_{kPictureTile};
    std::vector<Seen> seen_;
    std::vector<std::uint32_t> shaded_blocks_;  ///< points that surfaces may hide, of many tiles
    /// Whether there are tiles that no surface shades, [1], or others, of those that lights are far
    /// from, [.][1], and others.
    std::array<std::array<bool, 2>, 2> there_{};
    bool asks_suns_ = false;  ///< whether a sun's shadow may end in some tile
    bool computes_ = false, on_gpu_ = false;
    StepBoxes boxes_;
    bool tells_far_ = false;  ///< whether tiles that lights are far from are marched by themselves
    std::array<std::array<TileList, 2>, 2> lists_;  ///< as there_
    TileList depth_list_, picture_list_;
};

}  // namespace fumarole::pass
