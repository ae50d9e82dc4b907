// Where a march keeps what it has met before the frame's depths.
#include "scene/split_depths.glsl"

layout(binding = SPLIT_SCATTERING_IMAGE) writeonly uniform image2DArray u_split_scattering_img;
layout(binding = SPLIT_TRANSMITTANCE_IMAGE) writeonly uniform image2DArray u_split_transmittance_img;
