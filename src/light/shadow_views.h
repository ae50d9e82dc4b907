#pragma once

#include <span>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light_fields.h"
#include "shared/draw_params.h"
#include "shared/light_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// Depth pictures of a scene's surfaces as lights see them: what hides a light from a point.

namespace fumarole::light {

/// One layer of a shadow map; ShadowView in double.
struct View {
    glm::dmat4 clip_from_world{1.0};
    glm::dvec3 origin{0};  ///< metres, world; depth 0
    glm::dvec3 axis{0};    ///< a sun's direction of travel, else 0
    double range = 1;      ///< metres
    double bias = 0;       ///< metres, or metres per metre of distance

    bool operator==(const View&) const = default;
};

/// Right, up and the direction of travel of parallel light: z grows on its way.
struct LightAxes {
    explicit LightAxes(glm::dvec3 to_light);
    glm::dvec3 right, up, travel;
    glm::dmat4 light_from_world{1.0};
};

/// True if the surface is small enough for the inner, detailed shadow view: a ground plane would
/// stretch it.
bool is_detail(const surface::SurfaceSet::Instance& instance, const Bounds& media);

/// Whether a surface within `surface` can stand between the media and a light: false is certain.
bool can_shade(const LightPosition& light, const Bounds& surface, const Bounds& media);

/// What of the media lies outside of boxes that cut off an end of them, as a ground does: what is
/// in a solid is not seen.
Bounds outside_of_boxes(Bounds media, std::span<const surface::SurfaceSet::Instance> surfaces);

/// Whether one of the surfaces can stand between one of the lights and another, or itself: false is
/// certain.
bool can_shade_surfaces(std::span<const LightPosition> lights,
                        std::span<const surface::SurfaceSet::Instance> surfaces);

/// A view along `axes` that shows `covered` and keeps the depth of all `casters`, both in the
/// light's axes. map_size: texels along its edge.
View parallel_view(const LightAxes& axes, const Bounds& covered, const Bounds& casters,
                   int map_size);

/// Half a view's width of a light that shines all around, over its distance: more than the 1 of a
/// right angle by a rim of two texels, so that filtering at a face's edge stays within it.
double point_view_tangent(int map_size);

/// Six views round a point. range: metres to the farthest caster.
std::vector<View> point_views(glm::dvec3 position, double range, int map_size);

/// One view down a spot's cone.
View spot_view(const SpotLight& spot, double range, int map_size);

/// A view for an eye at `eye` (metres, world).
shared::ShadowView to_shared(const View& view, glm::dvec3 eye);

/// Draws surfaces into a shadow map.
class ShadowPainter {
public:
    ShadowPainter(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}, block_{device, "shadow draw"}
    {
    }

    /// A texture array of map_size^2 texels, one layer a view, with nothing drawn yet.
    [[nodiscard]] gl::Texture make_map(std::size_t views, int map_size) const;

    /// Draws surfaces as one view sees them, into its layer of the map: an open one where it is, a
    /// solid halfway through, so that neither its lit side nor what touches its far side is near to
    /// what the map holds (Woo 1992, "The Shadow Depth Map Revisited"). Changes GL state: call it
    /// under a StateGuard.
    void draw(const gl::Texture& map, std::size_t layer, const View& view,
              const surface::SurfaceSet& surfaces);
    /// Frees what it draws with: no map is wanted for now.
    void release() { backs_ = {}; }

private:
    void clear(glm::ivec2 size);
    void draw_surfaces(const View& view, const surface::SurfaceSet& surfaces, bool closed,
                       const gl::Defines& variant);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::Framebuffer framebuffer_;
    gl::Texture backs_;  ///< of solids, the depths of their nearest far sides in a view
    gl::UniformBuffer<shared::DrawParams> block_;
};

}  // namespace fumarole::light
