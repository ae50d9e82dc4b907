#pragma once

#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "shared/probe_params.h"

// What a probe has seen, made ready for surfaces of any roughness: glsl/probe,
// glsl/lib/probe_map.glsl.

namespace fumarole::light {

/// Where a probe's maps stand in their layer of a texture.
class ProbeLayout {
public:
    struct Map {
        glm::ivec2 first{0};  ///< texel, the border left out
        int size = 0;         ///< texels along its edge
        double alpha = 0;     ///< alpha of the GGX that it is reflected by; 0: not at all
    };

    /// @param size of the first map: a power of two, 64 to 1024
    explicit ProbeLayout(int size);

    [[nodiscard]] const std::vector<Map>& maps() const { return maps_; }
    [[nodiscard]] glm::ivec2 size() const { return size_; }  ///< size of the layer [texels]
    [[nodiscard]] int harmonics_row() const { return size_.y - 1; }
    [[nodiscard]] shared::ProbeLayoutParams params() const;

private:
    std::vector<Map> maps_;
    glm::ivec2 size_{0};
};

/// Fills layers of a texture of probes.
class ProbeFilter {
public:
    ProbeFilter(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}, block_{device, "probe filter"}
    {
    }

    /// A texture of probes of one layout.
    [[nodiscard]] gl::Texture make_maps(std::string_view label, const ProbeLayout& layout,
                                        int layers) const;

    /// From a latitude-longitude map. Changes GL state: call it under a StateGuard.
    void filter_environment(const gl::Texture& map, const gl::Texture& to,
                            const ProbeLayout& layout, int layer) const;
    /// From six square pictures in the order of glsl/lib/cube_faces.glsl.
    void filter_faces(const gl::Texture& faces, const gl::Texture& to, const ProbeLayout& layout,
                      int layer) const;

private:
    void filter(const gl::Texture& source, const gl::Defines& resolve, const gl::Texture& to,
                const ProbeLayout& layout, int layer) const;

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::ProbeFilterParams> block_;
    mutable gl::Texture pyramid_;  ///< pyramid of the size that was filtered last
};

}  // namespace fumarole::light
