// What is kept of a view was scattered to where the eye was: seen from here it is brighter one way and darker
// the other. Needs scene/in_scattering.glsl.

// The source at p towards wo, were all light to arrive.
vec3 open_source_at(vec3 p, vec3 wo, vec3 sigma_s, vec3 emission, float g)
{
    vec3 in_scattering = kWorldLight ? u_lights.world_radiance.rgb : vec3(0.0);
    add_open_lights(in_scattering, p, wo, g);
    return emission + sigma_s * in_scattering;
}

// How much brighter a medium at p is from here than it was from where the eye was.
//   old_eye  xyz: that place, eye-centred as p [m]; w 0: orthographic, the direction to it
vec3 turned_to_eye(vec3 p, vec3 wo, vec4 old_eye, vec3 sigma_s, vec3 emission, float g)
{
    if (kIsotropic)
        return vec3(1.0);
    const float kMost = 4.0;  // of a change so steep the history knows nothing
    vec3 old_wo = old_eye.w == 0.0 ? old_eye.xyz : normalize(old_eye.xyz - p);
    vec3 now = open_source_at(p, wo, sigma_s, emission, g);
    vec3 then = open_source_at(p, old_wo, sigma_s, emission, g);
    return clamp((now + 1e-30) / (then + 1e-30), 1.0 / kMost, kMost);
}
