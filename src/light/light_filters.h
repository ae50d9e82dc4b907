#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/shadow_views.h"
#include "light_fields.h"
#include "shared/light_filter_params.h"
#include "surface/gpu_mesh.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>

// What transparents that cast let through of the lights, as maps of the lights' views:
// glsl/scene/light_filters.glsl.

namespace fumarole::light {

/// Those of a scene's transparents that cast, as they stand in it.
std::vector<Transparent> casters_of(const std::vector<Transparent>& transparents);

/// A transparent that casts, on the GPU.
struct Caster {
    glm::dmat4 world_from_object{1.0};
    const surface::GpuMesh* mesh = nullptr;
    gl::TextureView image;         ///< empty for none
    glm::vec4 source{0};           ///< source of its blending; of an image, what multiplies it
    std::uint32_t factor = 0;      ///< factor of what is behind: shared/transparent_params.h
    bool is_filter = false;        ///< what its image does not cover lets all through
    bool overlaps_itself = false;  ///< a ray may meet it twice

    [[nodiscard]] Bounds bounds() const { return mesh->bounds().transformed(world_from_object); }
};

/// What of a sun's light a transparent may filter: all that lies behind a rectangle of a view.
struct FilteredSun {
    View view;
    glm::dvec2 low{0}, high{0};  ///< low and high of the view, 0..1
    double first = 0;            ///< depth in it, 0..1
};

class LightFilters {
public:
    LightFilters(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs},
          draw_block_{device, "light filter draw"}, block_{device, "light filters"}
    {
    }

    /// Draws the maps, if there are casters and any is another one than before or a light is.
    /// Changes GL state: call it under a StateGuard.
    /// @param kept casters_of() the scene: by which it is known whether they are the same
    /// @param map_size texels along an edge of each view
    /// @param of_grids textures that a shader samples of the media's grids
    /// @throws Error if this GL lets it sample no more
    void set(std::span<const Light> lights, std::span<const Caster> casters,
             std::vector<Transparent> kept, int map_size, int of_grids);
    void clear();

    [[nodiscard]] bool any() const { return static_cast<bool>(map_); }
    [[nodiscard]] std::span<const FilteredSun> filtered_suns() const { return filtered_suns_; }
    [[nodiscard]] int views() const { return static_cast<int>(views_.size()); }
    /// Of each view.
    [[nodiscard]] int layers() const { return layers_; }
    /// Views drawn so far.
    [[nodiscard]] int views_drawn() const { return views_drawn_; }

    /// The lines that glsl/scene/lights.glsl needs.
    [[nodiscard]] gl::Defines defines() const;
    void bind(glm::dvec3 eye) const;

private:
    void add_light(const Light& light, std::span<const Caster> casters, int map_size);
    void add_sun(const SunLight& sun, std::span<const Caster> casters, int map_size);
    /// Of one of its points.
    void add_views(std::span<const View> views);
    void draw(std::span<const Caster> casters, int map_size);
    void draw_casters(std::span<const Caster> casters, const View& view, const gl::Defines& defines,
                      int layer_before);

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::Framebuffer framebuffer_;
    gl::UniformBuffer<shared::LightFilterDrawParams> draw_block_;
    gl::UniformBuffer<shared::LightFiltersParams> block_;
    gl::Texture map_;
    std::vector<View> views_;
    std::vector<std::size_t> points_;  ///< the first view of each of the lights' points
    std::vector<FilteredSun> filtered_suns_;
    std::vector<Transparent> kept_;
    Bounds bounds_;
    int layers_ = 0, views_drawn_ = 0;
};

}  // namespace fumarole::light
