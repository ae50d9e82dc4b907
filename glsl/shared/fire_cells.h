// How a fire is told from afar: see src/light/fire_light.h.
#pragma once
#include "shared/bindings.h"

#define FIRE_CELLS_BUFFER FRAGMENTS_BUFFER  // no transparents are listed meanwhile

#define FIRE_CELLS 16        // of a box that glows, along its longest edge at most
#define FIRE_CELL_GROUP 128  // that lists them
#define FIRE_TILE 12         // texels of a cell's octahedral map, with one more along each edge
#define FIRE_TILES 32        // maps beside each other
