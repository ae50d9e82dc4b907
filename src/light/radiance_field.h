#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/field_lattice.h"
#include "shared/draw_params.h"
#include "shared/field_params.h"
#include "surface/surface_set.h"
#include <fumarole/scene.h>

// Light that is not direct, at the nodes of a lattice: what media scatter a second time and on, and
// what they emit.

namespace fumarole::light {

/// What the field is carried through.
struct FieldMedium {
    gl::Defines defines;  ///< the media's, the lights' and those of the volumes that dim lights
    glm::vec3 albedo{1};  ///< where there is no medium
    bool glows = false;   ///< some medium emits
    bool dims = true;     ///< media dim light
    const World* world = nullptr;             ///< whose light comes in
    const gl::Texture* extinction = nullptr;  ///< of the marched media, where no volume dims lights
};

/// How far scattering is followed.
struct FieldOrders {
    int count = 0;      ///< after the first
    bool tail = false;  ///< and those after them are guessed from the last two
    bool operator==(const FieldOrders&) const = default;
};

/// Discrete ordinates (Chandrasekhar 1950): each order of scattering is carried along a few
/// directions through the whole lattice at once, in columns that light does not leave, and gathered
/// at the nodes as spherical harmonics, whose bands the phase function weighs for the next order.
/// The directions are Gauss and Legendre's in z, evenly spaced around it, so that they sum products
/// of the harmonics that are kept exactly, and no energy is made.
class RadianceField {
public:
    RadianceField(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}, block_{device, "field of light"},
          draw_block_{device, "surfaces in the field"}
    {
    }

    /// Coefficients, bands^2 layers of `field`, of the world's light, whose own are `world` if
    /// there is any, of what media emit, and of what they scatter again. Media, lights and their
    /// volumes are bound.
    void fill(const FieldLattice& lattice, const FieldMedium& medium,
              const surface::SurfaceSet& surfaces, int bands, FieldOrders orders,
              const gl::Texture* world, const gl::Texture& field);

    /// Mean radiance over what scatters that each order brought, the light that has not been
    /// scattered first [W/m^2/sr]. Waits for the GPU.
    [[nodiscard]] std::vector<glm::vec3> sums() const;

private:
    struct Volumes;
    struct Carried;
    gl::Texture draw(const FieldLattice& lattice, const surface::SurfaceSet& surfaces);
    void carry(const Volumes& volumes, const Carried& carried, const gl::Texture& to, bool adds);
    void dispatch(const char* file, const gl::Defines& defines, glm::ivec3 threads,
                  glm::ivec3 group) const;

    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::FieldParams> block_;
    gl::UniformBuffer<shared::DrawParams> draw_block_;
    gl::Framebuffer framebuffer_;
    shared::FieldParams params_{};
    gl::Texture sums_;
    int orders_ = 0;
};

}  // namespace fumarole::light
