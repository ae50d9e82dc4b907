// What the media do between the eye and a depth: the face of scene/volume_at_*.glsl.
struct VolumeAt {
    vec3 scattering;     // radiance scattered and emitted towards the eye before it, as seen from the eye [W/m^2/sr]
    vec3 transmittance;  // from the eye to it, 0..1
};

// What a surface between them that adds a radiance, and keeps a share of what is behind, adds for the eye: light that is
// scattered in before it is no part of what it covers, and light behind it is dimmed once.
vec3 added_in_volume(VolumeAt at, vec3 radiance, vec3 kept)
{
    return at.transmittance * radiance + at.scattering * (1.0 - kept);
}

// As light behind a depth is there, of what the eye sees of it. Where next to nothing comes through, the rest of a
// difference of roundings is let go of.
vec3 at_depth(vec3 seen, vec3 transmittance)
{
    const float kFaint = 1e-4;
    return seen * transmittance / (transmittance * transmittance + kFaint * kFaint);
}

// What lies between two depths: as the nearer one sees the light, which is scattered in behind it. Where it sees
// nothing any more, at an optical depth of some 20, what is behind makes no difference to the eye and is left out.
VolumeAt volume_between(VolumeAt near, VolumeAt far)
{
    const float kFaint = 1e-9;
    vec3 passed = near.transmittance / (near.transmittance * near.transmittance + kFaint * kFaint);
    return VolumeAt(max(far.scattering - near.scattering, 0.0) * passed, clamp(far.transmittance * passed, 0.0, 1.0));
}
