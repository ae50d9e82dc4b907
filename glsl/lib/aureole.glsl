// What a medium with a strong forward lobe scatters of a sun around the sun's own direction, where
// light/forward_peak.glsl takes f = g^4 of it for light that goes straight on. For the four bands that the field of light
// has it does. The others widen with each of these scatterings: Henyey-Greenstein's l-th band is g^l, so after n of them
// and the one towards the eye it is g^(l (n + 1)) / f^n, a lobe of g^(n + 1) without its own four bands. Taken to be as
// narrow as after one, light around a sun is half as bright again as it is at an optical depth of 6. After Nakajima and
// Tanaka 1988, "Algorithms for radiative intensity calculations in moderately thick atmospheres using a truncation
// approximation", whose correction goes as far as the second.
#include "lib/phase.glsl"
#include "shared/aureole.h"

#define AUREOLE_ORDERS 6  // what comes after them is taken for the next

// Of one direction [1/sr].
struct Aureole {
    float once;                    // what it has after no more scattering
    float low;                     // does not widen
    float orders[AUREOLE_ORDERS];  // of n of these scatterings, less `last`, over n!
    float last;                    // of more
};

// Bands 0 to 3 of a lobe.
float four_bands(float cos_theta, float g)
{
    float square = cos_theta * cos_theta;
    float p2 = 1.5 * square - 0.5, p3 = cos_theta * (2.5 * square - 1.5);
    return kInv4Pi * (1.0 + g * (3.0 * cos_theta + g * (5.0 * p2 + g * 7.0 * p3)));
}

// Its others, over g^4. 0 < g < 1.
float other_bands(float chord2, float g)
{
    const float kNarrow = 0.25;  // below, four bands are nearly all of it, and bands 4 to 7 nearly all of the rest
    float c = 1.0 - 0.5 * chord2, square = c * c;
    float p4 = 0.375 + square * (-3.75 + square * 4.375);
    float p5 = c * (1.875 + square * (-8.75 + square * 7.875));
    float p6 = -0.3125 + square * (6.5625 + square * (-19.6875 + square * 14.4375));
    float p7 = c * (-2.1875 + square * (19.6875 + square * (-43.3125 + square * 26.8125)));
    float first = kInv4Pi * (9.0 * p4 + g * (11.0 * p5 + g * (13.0 * p6 + g * 15.0 * p7)));
    float g2 = g * g;
    return g < kNarrow ? first : (phase_about_peak(chord2, g) - four_bands(c, g)) / (g2 * g2);
}

// chord2: 2 - 2 cos. 0 < g < 1.
Aureole aureole_of(float chord2, float g)
{
    // Angles that add up to a large one lead elsewhere than one such angle: there they are held for none, as the field
    // holds them. What is sent back comes nearer to the reference's for a slab with all of them, and farther for smoke.
    float c = 1.0 - 0.5 * chord2;
    float part = smoothstep(AUREOLE_NONE, AUREOLE_ALL, c);
    Aureole aureole;
    aureole.once = phase_about_peak(chord2, g);
    aureole.low = mix(aureole.once, four_bands(c, g), part);
    float scale = part * g * g * g * g;
    aureole.last = scale * other_bands(chord2, pow(g, float(AUREOLE_ORDERS + 1))) / float(AUREOLE_ORDERS + 1);
    float lobe = g, factorial = 1.0;
    for (int n = 0; n < AUREOLE_ORDERS; ++n) {
        // Each of the n + 1 scatterings stands for the one by which the way is broken into two.
        float order = scale * other_bands(chord2, lobe) / float(n + 1);
        aureole.orders[n] = (order - aureole.last) / factorial;
        lobe *= g;
        factorial *= float(n + 1);
    }
    return aureole;
}

// The phase of what is left of a sun's light without what is scattered straight on, whose optical depth is `from_sun` on
// its way to where it is scattered, and `to_eye` from there.
float aureole_phase(Aureole aureole, float from_sun, float to_eye)
{
    float ahead = min(to_eye, 60.0);  // what lies behind is not seen, and must not be infinite
    float straight = from_sun + ahead;
    float sum = 0.0;
    for (int n = AUREOLE_ORDERS - 1; n >= 0; --n)
        sum = aureole.orders[n] + sum * straight;
    return max(aureole.low + aureole.last * exp(ahead) + exp(-from_sun) * sum, 0.0);
}
