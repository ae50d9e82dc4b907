// The range of temperatures of media that glow as blackbodies do (docs/scene_files.md).
#pragma once
#include "shared/types.h"
FUM_SHARED_BEGIN

// Nothing is seen of what is colder, and what is hotter than the Draper point is seen in full. [kK]
const float kDarkKilokelvin = 0.5f;
const float kDraperKilokelvin = 0.798f;
// What is hotter is taken to be no hotter. [kK]
const float kHottestKilokelvin = 40.0f;

FUM_SHARED_END
