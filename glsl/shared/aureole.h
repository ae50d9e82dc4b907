// How far around a sun the light of many scatterings is told from that of one, lib/aureole.glsl:
// cosines.
#pragma once
#define AUREOLE_ALL 0.9   // within: all of it
#define AUREOLE_NONE 0.8  // beyond: nothing
