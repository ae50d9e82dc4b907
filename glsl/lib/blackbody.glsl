// The light of a blackbody: Stefan and Boltzmann's brightness in the colour of Planck's law.
#include "shared/blackbody.h"

// The colour of a blackbody in linear Rec. 709, of luminance 1, channels outside of its gamut 0: polynomials of the
// inverse temperature that follow Planck's law, seen by the CIE 1931 observer, to within 0.0014 from 800 K to 40,000 K.
vec3 blackbody_color(float kilokelvin)
{
    const float kZeroOfBlue = 0.56;  // from there on blue is outside, and its polynomial is not meant for it
    float u = 1.0 / clamp(kilokelvin, 0.8, kHottestKilokelvin);
    float v = min(u, kZeroOfBlue);
    vec3 x = vec3(u, u, v);
    vec3 color = vec3(2.027156, 0.5930692, -349.494);
    color = color * x + vec3(-9.315036, -1.677791, 728.8388);
    color = color * x + vec3(17.80499, 0.5204357, -597.1049);
    color = color * x + vec3(-18.94378, 3.038618, 230.5105);
    color = color * x + vec3(11.24236, -4.041054, -30.66845);
    color = color * x + vec3(1.119352, 0.639078, -6.704182);
    color = color * x + vec3(0.6655312, 0.9685335, 2.229595);
    return max(color, vec3(0.0));
}

// Its radiance over that of 1000 K. [kK^4]
vec3 blackbody(float kilokelvin)
{
    if (!(kilokelvin > kDarkKilokelvin))
        return vec3(0.0);
    float t = min(kilokelvin, kHottestKilokelvin);
    float seen = smoothstep(kDarkKilokelvin, kDraperKilokelvin, t);
    return t * t * t * t * seen * blackbody_color(t);
}
