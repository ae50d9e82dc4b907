// The field of light: radiance from all around at the nodes of a lattice, order by order of
// scattering. See src/light/radiance_field.h. World space is eye-centred: see frame_params.h.
#ifdef __cplusplus
#pragma once
#endif
#include "shared/light_volume_params.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

#define FIELD_BATCH 8         // directions that are swept at once
#define FIELD_MOST_ORDERS 64  // of scattering

// A direction that light is carried along, in columns that go through the lattice slice by slice
// along the axis that the direction is nearest to, so that each column meets one place of each
// slice. A place is written along that axis and the next two in turn.
struct FUM_STD140 FieldDirection {
    vec3 wi;            // to where light comes from, unit length
    float solid_angle;  // that it stands for [sr]
    vec2 slope;         // nodes across, from a slice to the next
    vec2 first;         // of column 0, across, in the first slice
    int axis;           // 0: x
    float forward;      // 1 where light goes up along the axis, else -1
    float metres;       // of a column from a slice to the next
    int first_word;     // of its layers in the picture of what surfaces cross
    vec3 entry;         // the world's radiance from there [W/m^2/sr]
    float unused;
};

struct FUM_STD140 FieldParams {
    LatticeParams nodes;
    FieldDirection directions[FIELD_BATCH];
    int count;    // of the directions
    int columns;  // across a slice, along each edge, that there is room for
    int slices;   // that there is room for
    int order;    // of scattering that is summed up: 0 the lights' and the world's own light
    vec3 albedo;  // of places that have no medium
    float unused;
};

FUM_SHARED_END
