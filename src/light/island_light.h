#pragma once

#include <vector>

#include "gl/buffer.h"
#include "gl/texture.h"
#include "light/lattice.h"
#include "shared/island_light_params.h"

namespace fumarole::light {

/// The world's light of media whose parts lie far apart, as one frame looks it up: that of each
/// part, turned to the eye, one behind the other in one texture.
class IslandLight {
public:
    explicit IslandLight(const gl::Device& device) : device_{device} {}

    /// The light of one part, at the nodes of its lattice.
    struct Part {
        const gl::Texture& light;  ///< empty: it has none
        const Lattice& lattice;
        int turns_to_eye = 0;  ///< number of times that it was turned to the eye
    };

    /// Makes room for them, of which one has light at least.
    void set(const std::vector<Part>& parts);
    void drop() { light_ = {}; }

    explicit operator bool() const { return static_cast<bool>(light_); }
    [[nodiscard]] const gl::Texture& light() const { return light_; }
    /// Copies what was turned to the eye since, and binds all.
    void bind(const std::vector<Part>& parts, glm::dvec3 eye);

private:
    void copy(std::size_t part, const Part& from);

    const gl::Device& device_;
    gl::Texture light_;
    std::vector<int> first_;  ///< texel along z where each part begins; -1 if it has none
    std::vector<int> turns_;  ///< Part::turns_to_eye when they were copied
    gl::UniformBuffer<shared::IslandLightParams> block_;
};

}  // namespace fumarole::light
