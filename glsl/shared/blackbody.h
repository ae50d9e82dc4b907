// The light of media that glow as blackbodies do (docs/scene_files.md): Stefan and Boltzmann's
// brightness in the colour of Planck's law.
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

#ifdef __cplusplus
using glm::clamp;
using glm::max;
using glm::min;
using glm::smoothstep;
#endif

// Nothing is seen of what is colder, and what is hotter than the Draper point is seen in full. [kK]
const float kDarkKilokelvin = 0.5f;
const float kDraperKilokelvin = 0.798f;
// What is hotter is taken to be no hotter. [kK]
const float kHottestKilokelvin = 40.0f;

// The colour of a blackbody in linear Rec. 709, of luminance 1, channels outside of its gamut 0:
// polynomials of the inverse temperature that follow Planck's law, seen by the CIE 1931 observer,
// to within 0.0014 from 800 K to 40,000 K.
FUM_SHARED_FUNCTION vec3 blackbody_color(float kilokelvin)
{
    const float kZeroOfBlue =
        0.56f;  // from there on blue is outside, and its polynomial is not meant for it
    float u = 1.0f / clamp(kilokelvin, 0.8f, kHottestKilokelvin);
    float v = min(u, kZeroOfBlue);
    vec3 x = vec3(u, u, v);
    vec3 color = vec3(2.027156f, 0.5930692f, -349.494f);
    color = color * x + vec3(-9.315036f, -1.677791f, 728.8388f);
    color = color * x + vec3(17.80499f, 0.5204357f, -597.1049f);
    color = color * x + vec3(-18.94378f, 3.038618f, 230.5105f);
    color = color * x + vec3(11.24236f, -4.041054f, -30.66845f);
    color = color * x + vec3(1.119352f, 0.639078f, -6.704182f);
    color = color * x + vec3(0.6655312f, 0.9685335f, 2.229595f);
    return max(color, vec3(0.0f));
}

// Its radiance over that of 1000 K. [kK^4]
FUM_SHARED_FUNCTION vec3 blackbody(float kilokelvin)
{
    if (!(kilokelvin > kDarkKilokelvin))
        return vec3(0.0f);
    float t = min(kilokelvin, kHottestKilokelvin);
    float seen = smoothstep(kDarkKilokelvin, kDraperKilokelvin, t);
    return t * t * t * t * seen * blackbody_color(t);
}

FUM_SHARED_END
