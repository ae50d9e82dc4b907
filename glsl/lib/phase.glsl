// Phase functions [1/sr]. cos_theta = dot(-wi, wo), wi to the light, wo to the eye: 1 is straight on,
// so g > 0 scatters forward. Henyey and Greenstein 1941; pbrt 4e, 11.3.1.

const float kPi = 3.14159265358979;
const float kInv4Pi = 0.0795774715459477;

float phase_isotropic() { return kInv4Pi; }

// Of the square of how far a direction is from the peak, 2 - 2 cos, about theta^2. 0 <= a < 1.
float phase_about_peak(float chord2, float a)
{
    float d = (1.0 - a) * (1.0 - a) + a * chord2;
    return kInv4Pi * (1.0 - a) * (1.0 + a) / (d * sqrt(d));
}

// By the directions themselves: a cosine near 1 has lost the digits that a lobe of |g| near 1 is made of.
float phase_henyey_greenstein(vec3 wi, vec3 wo, float g)
{
    vec3 chord = g < 0.0 ? wi - wo : wi + wo;
    return phase_about_peak(dot(chord, chord), abs(g));
}

float phase_henyey_greenstein(float cos_theta, float g)
{
    // 1 + g^2 - 2 g cos, written so that it does not cancel at the peak: near |g| = 1, cos = sign(g).
    float a = abs(g);
    // A dot of unit vectors may round to above 1, which at the peak would take d below 0.
    float one_minus_cos = max(1.0 - (g < 0.0 ? -cos_theta : cos_theta), 0.0);
    float d = (1.0 - a) * (1.0 - a) + 2.0 * a * one_minus_cos;
    return kInv4Pi * (1.0 - a) * (1.0 + a) / (d * sqrt(d));
}
