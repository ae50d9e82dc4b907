// No medium is in view.
#include "lib/volume_at.glsl"
#include "scene/frame.glsl"

struct VolumeRay {
    float unused;
};

VolumeRay volume_ray(vec2 pixel) { return VolumeRay(0.0); }
VolumeAt volume_at_pane(VolumeRay ray, int k, float view_z) { return VolumeAt(vec3(0.0), vec3(1.0)); }
VolumeAt volume_at(VolumeRay ray, float view_z) { return VolumeAt(vec3(0.0), vec3(1.0)); }
