#pragma once

#include <cstdint>
#include <string>

#include <fumarole/export.h>

// GLSL for a host's own shaders (docs/library.md). It is of version 4.50, stands after `#version`
// and before what calls it, once in a shader, and is the same for every scene, mode and setting.
// All that it declares begins with fumarole_ or FUMAROLE_.

namespace fumarole {

/// Texture units that volume_at_glsl() reads, one after the other.
inline constexpr int kVolumeAtUnits = 5;

/// Where a host binds what View::volume_at() names: points that nothing of its own is bound to.
struct VolumeAtBindings {
    std::uint32_t block = 0;       ///< binding of a uniform block
    std::uint32_t first_unit = 0;  ///< first of kVolumeAtUnits texture units without samplers
};

/// What the media do between the eye and a depth of a pixel, for any stage:
///     struct fumarole_VolumeAt { vec3 scattering, transmittance; };
///     fumarole_VolumeAt fumarole_volume_at(vec2 pixel, float view_z);
/// scattering is the radiance [W/m^2/sr] that is sent towards the eye before it, as seen from the
/// eye; pixel is gl_FragCoord.xy, view_z in metres along the view's axis.
FUMAROLE_API std::string volume_at_glsl(const VolumeAtBindings& bindings);

/// Where Renderer::begin_transparents() binds what transparent_glsl() reads and writes: points that
/// nothing of the host's is bound to meanwhile.
struct TransparentBindings {
    std::uint32_t block = 0;         ///< binding of a uniform block
    std::uint32_t depth_unit = 0;    ///< texture unit for Frame::depth
    std::uint32_t lists_image = 0;   ///< image unit of the lists' heads
    std::uint32_t first_buffer = 0;  ///< first of two storage buffers, one after the other
};

/// A function that puts a fragment into the list of its pixel, for a fragment shader:
///     void fumarole_transparent(vec4 color, uint blend);
///     void fumarole_transparent(vec4 color, uint blend, uint draw);
///     void fumarole_transparent(vec4 color, uint blend, uint draw, float view_z);
/// color is radiance [W/m^2/sr], or what a filter lets through, and alpha. blend is
/// FUMAROLE_BLEND_ALPHA, _PREMULTIPLIED, _ADD or _MULTIPLY, or fumarole_blend_factors(source,
/// behind) of any two of OpenGL's factors, FUMAROLE_BLEND_ZERO .. _SRC_ALPHA_SATURATE. Of two
/// fragments at one depth that of the larger `draw` (0 to 4095, less the scene's transparents) is
/// in front, and within a draw that of the later triangle. view_z [m] is the fragment's own unless
/// it is given.
FUMAROLE_API std::string transparent_glsl(const TransparentBindings& bindings);

}  // namespace fumarole
