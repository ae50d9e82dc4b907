// Adds one uniform slab of medium to a ray, front to back.
//   source   radiance that the slab adds per metre: sigma_s * in_scattering + emission  [L / m]
//   tau      optical depth of the slab, sigma_t * ds                                    [1]
//   ds       length of the ray inside the slab, >= 0                                    [m]
// Extinction inside the slab is integrated in closed form, so splitting a uniform slab into more steps
// leaves the result alone: Hillaire 2015, "Physically Based and Unified Volumetric Rendering in
// Frostbite", improved scattering integration. Here (S - S exp(-tau)) / sigma_t is written as
// S ds * slab_weight(tau), which has the right limit where sigma_t is 0.

// (1 - exp(-tau)) / tau. Below 1e-2 its series: the first term left out, tau^3/24, is 4e-8.
float slab_weight(float tau)
{
    return abs(tau) < 1e-2 ? 1.0 - tau * (0.5 - tau * (1.0 / 6.0)) : (1.0 - exp(-tau)) / tau;
}

vec3 slab_weight(vec3 tau) { return vec3(slab_weight(tau.r), slab_weight(tau.g), slab_weight(tau.b)); }
