// The media of a scene. World space is eye-centred: see frame_params.h.
#include "shared/bindings.h"
#include "shared/types.h"
FUM_SHARED_BEGIN

// A grid's texture. Its index space counts voxels from the texture's first voxel centre.
struct FUM_STD140 GridParams {
    mat4 index_from_world;  // voxels from metres
    vec3 inverse_size;      // 1 / texels of the dense texture or of the atlas
    float unit;             // value per stored unit
    vec4 pages;             // xyz: pages along each axis; 0 for a dense grid
    ivec4 tree;  // of a tree of pages: xyz: the page where index space begins, near the eye; w:
                 // levels
};

// One octave of the noise profile: cell = cell_offset + floor(p * frequency + fraction).
struct FUM_STD140 NoiseOctave {
    ivec4 cell_offset;  // xyz: whole cells between the noise's origin and the eye; w: hash seed
    vec3 fraction;      // the rest, in cells, 0..1
    float frequency;    // cells per metre
};

struct FUM_STD140 MediumParams {
    mat4 bounds_from_world;  // to the space of bounds: voxels for a grid, metres for a box
    vec3 bounds_min;         // outside the bounds the medium is not there
    float noise_threshold;   // 0..1
    vec3 bounds_max;
    float noise_gain;            // amplitude of an octave over the one before
    vec3 sigma_s;                // 1/m, times the coefficient
    float g;                     // Henyey-Greenstein
    vec4 sigma_t;                // rgb: 1/m, times the coefficient; a: their mean
    vec3 emission;               // W/m^2/sr per m, times the emission coefficient
    float noise_scale;           // 1 / sum of the octaves' amplitudes
    float inverse_scale_height;  // of exp_height [1/m]
    float base_height;           // of exp_height: z0 - eye height [m]
    int noise_octaves;
    float kilokelvin_per_unit;  // of the temperature grid
    vec3 blackbody;             // W/m^2/sr per m, of what glows at 1000 K with a colour of 1
    // Share of its optical depth that dims a light which the media scatter: 1, or less what is
    // scattered straight on (light/forward_peak.glsl).
    float light_dimming;
};

// A part of a medium that lies far from its others.
struct FUM_STD140 Island {
    vec3 low;  // in the space of the medium's bounds
    int medium;
    vec3 high;
};

struct FUM_STD140 MediaParams {
    GridParams grids[MAX_GRIDS];
    MediumParams media[MAX_MEDIA];
    NoiseOctave octaves[MAX_MEDIA * MAX_OCTAVES];
    Island islands[MAX_ISLANDS];
    int island_count;
    float marched_light_dimming;  // likewise, of all media whose depth has no closed form
    float peak_g;                 // g of the medium of which most is scattered straight on
    float peak_straight;          // its optical depth that is, over that which dims lights
};

FUM_SHARED_END
