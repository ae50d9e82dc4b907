// What a resolve makes of a pixel: resolve_pixel().

// Variant. BOTH: scattering, and transmittance as the second source of blending; else one of them.
#ifdef BOTH
const bool kBoth = true;
#else
const bool kBoth = false;
#endif

struct Resolved {
    vec4 color;
    vec3 transmittance;  // kBoth
};
