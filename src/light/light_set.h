#pragma once

#include <optional>
#include <span>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/transfer.h"
#include "light/depth_pyramid.h"
#include "light/flames.h"
#include "light/light_filters.h"
#include "light/shadow_views.h"
#include "light_fields.h"
#include "shared/light_params.h"
#include "surface/surface_set.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// The lights of a scene on the GPU, the shadow map of its surfaces, what transparents filter of
// them, and the world's light.

namespace fumarole::light {

/// What surfaces hide of a sun from the media, as the CPU asks it: the view that holds all of them.
struct SunShadow {
    View view;
    DepthPyramid depths;  ///< depths of its shadow map
};

class LightSet {
public:
    LightSet(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, block_{device, "lights"}, painter_{device, programs}, filters_{device,
                                                                                          programs}
    {
    }

    /// Sorts the lights, and draws those views of the surfaces' shadow map, if there are any, that
    /// it has not from before. Changes GL state: call it under a StateGuard.
    /// @param media what the media fill, so that their shadows get the map's detail
    /// @param map_size texels along an edge of each view, or kAutomatic
    /// @param detailed whether the media have detail of their own
    /// @param through_gaps whether light comes to them through gaps in surfaces
    /// @param flames the media's own light, as far as lights stand for it
    /// @throws Error if the scene has more lights than the block holds.
    void set(const Scene& scene, const surface::SurfaceSet& surfaces, const Bounds& media,
             int map_size, bool detailed, bool through_gaps = false,
             std::span<const FlameLight> flames = {});

    /// Draws what transparents filter of the lights, likewise: after set().
    /// @param of_grids as LightFilters::set() has it
    void set_filters(const Scene& scene, std::span<const Caster> casters, int map_size,
                     int of_grids);

    /// Leaves no light: what is right after set() has thrown.
    void clear();

    /// The lines that glsl/scene/lights.glsl needs.
    [[nodiscard]] gl::Defines defines() const;

    /// Binds block and shadow map for an eye at `eye` (metres, world).
    void bind(glm::dvec3 eye);
    void bind_irradiance() const { irradiance_.bind(IRRADIANCE_UNIT); }
    void bind_environment() const { environment_.bind(ENVIRONMENT_UNIT); }

    /// The world's map, times its scale; empty where it is one colour.
    [[nodiscard]] const gl::Texture& environment() const { return environment_; }
    [[nodiscard]] bool has_environment() const { return environment_source_ != nullptr; }
    /// Those that shine, in the order of Light's types.
    [[nodiscard]] std::span<const Light> lights() const { return lights_; }
    [[nodiscard]] int suns() const { return suns_; }
    /// Those of them that stand for flames.
    [[nodiscard]] int flames() const { return flames_; }
    /// Their points: the first, and the one after the last.
    [[nodiscard]] glm::ivec2 flame_points() const;
    /// The points that stand for them, in their order.
    [[nodiscard]] std::span<const LightPosition> points() const { return points_; }
    [[nodiscard]] int count() const { return static_cast<int>(points_.size()); }
    /// Whether a light's beam has an edge where the medium has none.
    [[nodiscard]] bool has_edges() const;
    /// Metres within which such an edge fades, the finest where it may meet the media: 0 if a light
    /// that has one is among them; infinite if none has.
    [[nodiscard]] double edge_width(const Bounds& media) const;
    /// Whether a rectangle or a disk shines from among them.
    [[nodiscard]] bool has_area_in(const Bounds& media) const;
    [[nodiscard]] int shadow_views() const { return static_cast<int>(views_.size()); }
    /// Views of the shadow map drawn so far, and of what transparents filter.
    [[nodiscard]] int views_drawn() const { return views_drawn_ + filters_.views_drawn(); }
    [[nodiscard]] const LightFilters& filters() const { return filters_; }
    /// Of the surfaces that the shadow map shows, metres, world.
    [[nodiscard]] std::span<const Bounds> caster_bounds() const { return caster_bounds_; }
    /// Texels along an edge of each of its views.
    [[nodiscard]] int shadow_map_size() const { return shadow_map_.size().x; }
    /// Whether a surface can stand between a light and the media.
    [[nodiscard]] bool shaded_media() const { return shaded_media_; }
    [[nodiscard]] glm::vec3 world_radiance() const { return world_radiance_; }

    /// Of sun i, once its shadow map is back from the GPU, which the first call asks for; null
    /// until then. Never waits. Only where there are shadow views; good until the next set().
    [[nodiscard]] const SunShadow* sun_shadow(int i) const;
    /// Waits until those of all suns are there.
    void wait_for_sun_shadows() const;

private:
    [[nodiscard]] int automatic_map_size(bool detailed, bool through_gaps) const;
    void set_world(const World& world);
    void clear_lights();

    struct SunReadback {
        gl::Readback depths;
        std::optional<SunShadow> shadow;
        std::size_t layer = 0;  ///< layer in the shadow map
    };
    SunReadback& sun_readback(int i) const;
    /// A shadow map, what it shows, and what of it is known to the CPU.
    struct ShadowMap {
        std::vector<View> views;  ///< a layer each
        gl::Texture texture;
        std::vector<SunReadback> readbacks;
    };
    /// Draws views_, but for those that a map of the same surfaces shows already.
    void draw_shadow_map(ShadowMap old, const surface::SurfaceSet& surfaces, int map_size);
    [[nodiscard]] std::size_t sun_view(int i) const
    {
        return spans_[static_cast<std::size_t>(i)].first_layer;
    }

    /// What belongs to a light.
    struct Span {
        std::size_t first_point = 0, points = 0;
        std::size_t first_layer = 0;            ///< first layer of views_ and the shadow map
        std::size_t first_view = 0, views = 0;  ///< first view and views of those in the block
    };

    const gl::Device& device_;
    int suns_ = 0, flames_ = 0;
    std::vector<Light> lights_;  ///< lights in the order of Light's types
    std::vector<Span> spans_;    ///< spans of each light
    std::vector<double> radii_;  ///< radii of each [m]: 0 but of flames
    std::vector<LightPosition> points_;
    std::vector<View> views_;  ///< a layer of the shadow map each
    std::vector<Surface>
        casters_;  ///< surfaces that the shadow map shows, their materials left out
    std::vector<Bounds> caster_bounds_;
    int views_drawn_ = 0;
    bool shaded_media_ = false;
    bool throws_shadows_ = false;  ///< a surface may on what is seen, or might have
    mutable std::vector<SunReadback> sun_readbacks_;  ///< readbacks of each sun, as it is asked for
    gl::Texture shadow_map_, irradiance_, environment_;
    gl::UniformBuffer<shared::LightsParams> block_;
    ShadowPainter painter_;
    LightFilters filters_;
    std::shared_ptr<const Environment> environment_source_;
    float environment_scale_ = 0;
    glm::vec3 world_radiance_{0};
};

}  // namespace fumarole::light
