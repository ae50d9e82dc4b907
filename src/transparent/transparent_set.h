#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "gl/texture.h"
#include "light/light_filters.h"
#include "prepared_frame.h"
#include "shared/transparent_params.h"
#include "surface/gpu_mesh.h"
#include "transparent/convex.h"
#include <fumarole/scene.h>

namespace fumarole::transparent {

/// A transparent in a frame: where it stands, and what of the picture it may cover.
struct SeenTransparent {
    std::size_t index = 0;  ///< into the scene's
    glm::dmat4 world_from_object{1.0};
    glm::dvec2 view_z{0};  ///< nearest and farthest [m]
    DepthsAsked::Area area;
    /// Of what is a piece of it: lines of the picture along which it is cut off, z + x * NDC x +
    /// y * NDC y = 0, and w: 1 where it has the side below 0, else 0. No more than MAX_CUTS.
    std::vector<glm::vec4> cuts;
    int pane = 0;  ///< which of the frame's panes it is, or is a piece of
};

/// Those of a frame.
struct SeenTransparents {
    std::vector<SeenTransparent>
        list;                ///< transparents that may be in the picture, the nearest first
    bool in_order = false;   ///< each wholly before the next, wherever both are seen
    bool are_plain = false;  ///< then all of them are PlainPane, and no more than one pass takes
    /// Nearest and farthest [m] of all before the eye, in the picture or beside it: a part of a
    /// picture has the same.
    glm::dvec2 view_z{0};
};

/// A transparent that is flat and of one colour, and blends by factors of its own colour alone.
struct PlainPane {
    glm::vec4 source{0};  ///< radiance [W/m^2/sr] or filter, and alpha
    BlendFactor source_factor{}, destination_factor{};

    /// The factors of its source, whose colour is `color`, and of what is behind.
    [[nodiscard]] glm::vec3 of_source(glm::vec3 color) const;
    [[nodiscard]] glm::vec3 of_behind(glm::vec3 color) const;
};

/// The scene's transparents on the GPU: meshes and pictures, each once.
class TransparentSet {
public:
    explicit TransparentSet(const gl::Device& device) : device_{device} {}

    /// Uploads what is not there yet. @throws Error if there are too many
    void set(const std::vector<Transparent>& transparents);

    [[nodiscard]] bool empty() const { return items_.empty(); }
    [[nodiscard]] std::size_t size() const { return items_.size(); }
    /// How many need lists, and how many are a PlainPane.
    [[nodiscard]] std::size_t listed() const { return listed_; }
    [[nodiscard]] std::size_t plain_panes() const { return plain_panes_; }
    /// Whether a factor of one of them depends on what is behind it.
    [[nodiscard]] bool reads_picture() const { return reads_picture_; }

    /// Those that cast and let not all light through. Good until the next set().
    [[nodiscard]] std::vector<light::Caster> casters() const;

    [[nodiscard]] SeenTransparents look(const PreparedFrame& frame) const;

    /// Whether two of them may cross so that they are put in order by their pieces.
    [[nodiscard]] bool may_cross() const { return quads_ > 0 && flat_ > 1; }
    /// Whether it is a parallelogram, the first two edges of its box; else a mesh.
    [[nodiscard]] bool is_flat(const SeenTransparent& seen) const;
    /// From 0..1 to a box around it.
    [[nodiscard]] glm::dmat4 world_from_box(const SeenTransparent& seen) const;
    /// Whether it may lie before itself, other than by two sides of a convex mesh, or is blended by
    /// what is behind it, and not just in its source's factor by the colour.
    [[nodiscard]] bool needs_list(const SeenTransparent& seen) const;
    /// It as a pane; nothing if it is none.
    [[nodiscard]] std::optional<PlainPane> plain(const SeenTransparent& seen) const;

    /// What its draw's block holds.
    [[nodiscard]] shared::TransparentParams params(const SeenTransparent& seen,
                                                   const PreparedFrame& frame) const;
    /// What the colour behind it weighs in its source's factor.
    [[nodiscard]] float of_behind(const SeenTransparent& seen) const;
    /// Whether it fades before a surface.
    [[nodiscard]] bool fades(const SeenTransparent& seen) const;
    /// Its picture; empty where it has none.
    [[nodiscard]] gl::TextureView image(const SeenTransparent& seen) const;
    /// Issues its draw; program and state are the caller's.
    void draw(const SeenTransparent& seen) const;
    /// The same for what is laid over a picture: of a mesh its far sides first.
    void draw_in_order(const SeenTransparent& seen, const PreparedFrame& frame) const;

private:
    template <class Source, class Made> struct Held {
        std::shared_ptr<const Source> source;
        std::shared_ptr<Made> made;
    };
    struct TransparentMesh {
        surface::GpuMesh triangles;
        Winding winding = Winding::none;
    };
    struct Item {
        Transparent transparent;
        std::shared_ptr<TransparentMesh> mesh;  ///< null for the square
        std::shared_ptr<gl::Texture> image;     ///< null for none
    };
    [[nodiscard]] glm::dmat4 world_from_object(const Item& item, const Eye& eye) const;

    const gl::Device& device_;
    surface::GpuMesh square_;  ///< 0..1 along x and y
    bool has_square_ = false;
    std::vector<Item> items_;
    std::vector<Held<Mesh, TransparentMesh>> meshes_;
    std::vector<Held<TransparentImage, gl::Texture>> images_;
    std::size_t listed_ = 0, plain_panes_ = 0, flat_ = 0, quads_ = 0;
    bool reads_picture_ = false;
};

}  // namespace fumarole::transparent
