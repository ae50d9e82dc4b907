// Adds one uniform slab of medium to a ray, front to back.
//   source   radiance that the slab adds per metre: sigma_s * in_scattering + emission  [L / m]
//   tau      optical depth of the slab, sigma_t * ds                                    [1]
//   ds       length of the ray inside the slab, >= 0                                    [m]
// Extinction inside the slab is integrated in closed form, so splitting a uniform slab into more steps
// leaves the result alone: Hillaire 2015, "Physically Based and Unified Volumetric Rendering in
// Frostbite", improved scattering integration. Here (S - S exp(-tau)) / sigma_t is written as
// S ds * slab_weight(tau), which has the right limit where sigma_t is 0.

// (1 - exp(-tau)) / tau. Below 0.1 its series: the first term left out, tau^5/720, is 1.4e-8, where the
// difference 1 - exp(-tau) would already have lost 6e-7.
float slab_weight(float tau)
{
    return abs(tau) < 0.1 ? 1.0 - tau * (1.0 / 2.0 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))))
                          : (1.0 - exp(-tau)) / tau;
}

vec3 slab_weight(vec3 tau) { return vec3(slab_weight(tau.r), slab_weight(tau.g), slab_weight(tau.b)); }

// How far before the middle of a step of optical depth tau the light lies that it scatters, in parts of its length.
// Its near side is dimmed less by itself, which comes to tau / 12 where light changes evenly along it. The midpoints
// before it sum up h^2 / 24 of the extinction's slope too little, which in a medium that dims its own light makes up
// for a quarter of that.
float light_ahead(float tau) { return min(tau, 2.0) / 16.0; }

// The radiance that a slab adds to a ray which crosses it `slant` times as far as the one that it adds
// `radiance` to, of optical depth tau: exact where the slab is uniform.
vec3 seen_at_slant(vec3 radiance, float tau, float slant)
{
    return radiance * (slant * slab_weight(tau * slant) / slab_weight(tau));
}

vec3 seen_at_slant(vec3 radiance, vec3 tau, float slant)
{
    return radiance * (slant * slab_weight(tau * slant) / slab_weight(tau));
}
