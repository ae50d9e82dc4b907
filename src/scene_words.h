#pragma once

// What a scene does without, worded once for what explains a frame and for what plans one.

namespace fumarole::words {

inline constexpr const char* kColoredExtinction =
    "extinction: coloured: a target of its own for transmittance";
inline constexpr const char* kGreyExtinction =
    "extinction: grey: transmittance rides in the alpha of one target, one upsample instead of two";
inline constexpr const char* kNoEmission = "emission: none: no fetch";
inline constexpr const char* kIsotropic =
    "phase: g is 0 everywhere: a constant, no angle is worked out";
inline constexpr const char* kBlackWorld = "world: black: no ambient term";
inline constexpr const char* kNoSurfaces =
    "surfaces: none that could hide a light: no shadow map, no lookup";
inline constexpr const char* kNoLights = "lights: none: no loop over lights, no shadows";
inline constexpr const char* kHomogeneous =
    "light through media: closed form, no marching: all media are homogeneous";

}  // namespace fumarole::words
