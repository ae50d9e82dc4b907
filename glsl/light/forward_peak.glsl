// The part of what is scattered that four bands of harmonics cannot tell from light that goes straight on, f = g^4, is
// taken for that: extinction and albedo are those of the rest, as are the phase function's bands. Joseph, Wiscombe and
// Weinman 1976, "The delta-Eddington approximation for radiative flux transfer"; for any number of bands, Wiscombe 1977,
// "The delta-M method". Of the extinction it is the same share in every channel, where that is no more than g^4 of what
// is scattered: lights are dimmed by all that is left, MediumParams::light_dimming.

// f of a medium, where `straight_on` of the extinction is scattered straight on.
vec3 forward_peak(vec3 albedo, float g, float straight_on)
{
    float square = g * max(g, 0.0);
    return min(vec3(straight_on) / max(albedo, vec3(1e-9)), vec3(square * square));
}

// sigma_t times this is the extinction of the rest.
vec3 rest_of_extinction(vec3 albedo, vec3 peak) { return 1.0 - peak * albedo; }
vec3 rest_of_albedo(vec3 albedo, vec3 peak) { return albedo * (1.0 - peak) / rest_of_extinction(albedo, peak); }
// Henyey-Greenstein's l-th band, power: g^l.
vec3 rest_of_band(float power, vec3 peak) { return (power - peak) / (1.0 - peak); }

// f from the albedo of the rest.
vec3 forward_peak_by_rest(vec3 albedo, float g, float straight_on)
{
    return forward_peak(straight_on + albedo * (1.0 - straight_on), g, straight_on);
}
// The whole's extinction is that of the rest over this.
vec3 rest_of_extinction_by_rest(vec3 albedo, vec3 peak) { return (1.0 - peak) / (1.0 - peak + peak * albedo); }
