// The media of a scene. World space is eye-centred: see frame_params.h.
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// A grid's texture. Its index space counts voxels from the texture's first voxel centre.
struct GridParams {
    mat4 index_from_world;  // voxels from metres
    vec4 inverse_size;  // xyz: 1 / texels of the dense texture or of the atlas; w: value per stored
                        // unit
    vec4 pages;         // xyz: pages along each axis; 0 for a dense grid
};

// One octave of the noise profile: cell = cell_offset + floor(p * frequency + fraction).
struct NoiseOctave {
    ivec4 cell_offset;  // xyz: whole cells between the noise's origin and the eye; w: hash seed
    vec4 fraction;      // xyz: the rest, in cells, 0..1; w: cells per metre
};

struct MediumParams {
    mat4 bounds_from_world;  // to the space of bounds: voxels for a grid, metres for a box
    vec4 bounds_min;         // xyz: outside the bounds the medium is not there
    vec4 bounds_max;         // xyz
    vec4 sigma_s;            // rgb: 1/m, times the coefficient; a: g
    vec4 sigma_t;            // rgb: 1/m, times the coefficient; a: their mean
    vec4 emission;           // rgb: W/m^2/sr per m, times the emission coefficient
    vec4 profile;            // exp_height: x: 1 / scale_height [1/m], y: z0 - eye height [m];
                             // noise: x: threshold, y: gain, z: 1 / sum of amplitudes, w: octaves
};

struct MediaParams {
    GridParams grids[MAX_GRIDS];
    MediumParams media[MAX_MEDIA];
    NoiseOctave octaves[MAX_MEDIA * MAX_OCTAVES];
};

FUM_SHARED_END
