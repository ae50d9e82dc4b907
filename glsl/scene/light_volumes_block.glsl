// Where the volumes of light lie.
#include "shared/light_volume_params.h"

layout(std140, binding = LIGHT_VOLUMES_BLOCK) uniform LightVolumes { LightVolumesParams u_volumes; };
