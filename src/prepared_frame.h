#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <fumarole/bounds.h>
#include <fumarole/frame.h>
#include <fumarole/settings.h>

#include "shared/frame_params.h"

// From a host's matrices and depth convention to what every pass reads of a frame. It is worked out
// once for each frame, in double.

namespace fumarole {

/// A frame's camera, taken apart.
struct Eye {
    glm::dvec3 position{0};           ///< metres, world
    glm::dvec3 forward{0, 0, -1};     ///< unit length, world
    glm::dmat3 world_from_view{1.0};  ///< rotation
    double near = 0;                  ///< view_z of the near plane [m]
    double far = 0;                   ///< view_z of the far plane [m], may be infinite
    bool perspective = true;
};

/// A pixel's ray, p(view_z) = origin + direction * view_z in metres of eye-centred world; both are
/// affine in NDC: centre + x * dx + y * dy. Depth grows by 1 along a direction.
struct CameraRays {
    glm::dvec3 origin{0}, origin_dx{0}, origin_dy{0};
    glm::dvec3 direction{0}, direction_dx{0}, direction_dy{0};
};

/// A cone that has all of a picture's rays in it.
struct ViewCone {
    glm::dvec3 axis{0};     ///< unit length
    double half_angle = 0;  ///< [rad]
};
ViewCone view_cone(const CameraRays& rays);

/// What of a scene decides how its frames are drawn.
struct FrameScene {
    Bounds media;  ///< world bounds of all media [m]; empty where there are none
    /// Metres within which media that are no grid's change; infinite: nowhere, as without any.
    double detail = std::numeric_limits<double>::infinity();
    /// Metres within which what is seen of grids changes: a voxel, or less.
    double voxel = std::numeric_limits<double>::infinity();
    /// Metres within which a light has detail of its own in the media, as the edge of a beam; 0:
    /// one shines among them that has some at any distance.
    double beam_edge = std::numeric_limits<double>::infinity();
    bool has_outline = true;     ///< some medium ends at a face, and not in a grid's zeros
    double most_g = 0;           ///< the largest |g| of the media
    std::uint64_t id = 0;        ///< another whenever something of the scene changed
    std::uint64_t media_id = 0;  ///< another whenever that was how the media dim
    /// Another whenever there had been no media, or the scene's settings changed: nothing of what
    /// was gathered is what comes next.
    std::uint64_t life_id = 0;
};

/// Where in a frame it is asked what the media do before other depths than the surfaces'.
struct DepthsAsked {
    /// view_z [m], ascending, at which a march keeps what it has met, between which it is
    /// interpolated; empty: it is not asked.
    std::vector<float> view_z;
    /// A rectangle of the picture, pixels from the lower left.
    struct Area {
        glm::dvec2 low{0}, high{0};
    };
    std::vector<Area> areas;  ///< nowhere else
};

/// Why an automatic resolution is what it is.
enum class LayerReason : std::uint8_t {
    asked,     ///< it is not automatic
    no_layer,  ///< froxels have none
    history,   ///< one is kept, which another size would drop
    lobe,      ///< the media's phase changes within a quarter's texel
    beam,      ///< so does the edge of a light's beam, or an area light is amid a grid
    profile,   ///< so do media that are no grid's
    outline,   ///< a face of the media is in the picture
    voxels,    ///< it spans more of what a grid changes within than it may
    held,      ///< the frame before had half, and a quarter is all but one of these
    smooth,    ///< nothing changes much within it
};

/// The layer's size where that was left open.
struct LayerChoice {
    int scale = 0;  ///< pixels along a texel's edge; 0: none was chosen
    LayerReason reason = LayerReason::asked;
    /// How much of FrameScene::voxel a quarter's texel spans at the media's far end, and the most
    /// that it may; 0: there are no grids.
    double of_voxel = 0;
    static constexpr double kMostOfVoxel = 0.8;
};

/// What a view has of the frames before one.
struct ViewPast {
    bool keeps_history = false;  ///< it keeps what settings ask for
    /// What the last frame's layer was, if that was chosen and its picture was as large: pixels
    /// along a texel's edge; 0: there was none.
    int scale = 0;
};

/// A frame with all that follows from it, its settings and its scene.
struct PreparedFrame {
    Frame host;
    FrameSettings settings;      ///< nothing in them is automatic any more that a frame decides
    LayerChoice layer_choice;    ///< of settings.resolution
    bool keeps_history = false;  ///< something of the frame is kept for the next one of its view
    std::uint64_t scene_id = 0, media_id = 0, life_id = 0;  ///< FrameScene's

    Eye eye;
    CameraRays rays;
    Bounds media;               ///< world bounds of all media [m]
    bool sees_media = false;    ///< false: all media lie behind the eye, and nothing is drawn
    glm::dvec2 media_range{0};  ///< view_z within which media can be seen [m]; else near and far
    glm::dvec2 step_range{0};   ///< view_z of the first and the last step's or slice's end [m]: the
                               ///< media's as far as they are in view, or the camera's near and far

    glm::ivec2 picture_size{0};  ///< pixels
    /// Texels of the march's layer; half a texel at an odd edge counts whole.
    glm::ivec2 layer_size{0};
    /// Texels of it beyond the picture on each side, so that the upsample finds all its taps at the
    /// picture's edge; 2017 had none and repeated its last.
    int layer_guard = 0;

    /// Tiles of the picture that have a ray for each pixel, in a layer of their own: one a tile,
    /// as pass::fine_tiles() has them; empty: none. The frame of that layer is `fine`.
    std::vector<bool> fine_tiles;
    bool fine = false;

    DepthsAsked depths_asked;
    /// Panes in order, whose block is bound: a march keeps what it has met at their depths instead,
    /// and its transparents are in no list; 0: they are.
    int panes = 0;
    int pane_places = 0;  ///< what shaders are compiled for: a power of two, as many or more

    /// Drawn so that each variant of the shaders has been drawn with.
    bool prepares = false;

    shared::FrameParams params{};  ///< the frame's uniform block

    /// What the frame is composited into.
    [[nodiscard]] gl::TextureView picture() const { return host.target ? host.target : host.color; }
};

/// @throws Error if the projection is neither perspective nor orthographic or can't be inverted.
PreparedFrame prepare_frame(const Frame& frame, const FrameSettings& settings,
                            const FrameScene& scene, const ViewPast& past = {});

/// The frame of the layer that has a ray for each pixel of its fine_tiles alone.
PreparedFrame fine_frame(const PreparedFrame& frame);

/// What differences of depth are relative to [m]: the media's range where rays are parallel and
/// relative depth means nothing; 0: the depth itself.
double depth_reach(const Eye& eye, glm::dvec2 media_range);

}  // namespace fumarole
