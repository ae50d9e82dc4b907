#pragma once

#include <array>

#include "gl/texture.h"
#include "shared/bindings.h"

namespace fumarole::surface {

/// What a glossy surface reflects, for one roughness and one cosine to the eye.
struct LtcEntry {
    /// The inverse of the matrix that makes the lobe D V n.wi (docs/methods.md, "Surfaces") out of
    /// a cosine, in axes of which z is the normal and the eye is above x:
    ///     (xx, 0, xz)  (0, 1, 0)  (alpha zx, 0, alpha zz)
    float xx, xz, zx, zz;
    /// Directional albedos of D V (1 - (1 - wo.h)^5) and of D V (1 - wo.h)^5.
    float a, b;
};

/// Rows of LTC_COLUMNS: roughness 0..1, and in a row sqrt(1 - sqrt(n.wo)) 0..1.
extern const std::array<LtcEntry, std::size_t{LTC_ROWS} * LTC_COLUMNS> kLtcTable;

/// The table as two layers: the matrix, and a and b. Texels' middles are its entries.
gl::Texture make_ltc_texture(const gl::Device& device);

}  // namespace fumarole::surface
