// Where each pass finds its blocks and textures: the one place for both sides.
#ifdef __cplusplus
#pragma once
#endif

// Uniform blocks.
#define FRAME_BLOCK 0
#define MEDIA_BLOCK 1
#define LIGHTS_BLOCK 2
#define DRAW_BLOCK 3
#define FROXEL_BLOCK 4
#define MARCH_HISTORY_BLOCK FROXEL_BLOCK  // either froxels or a march
#define LIGHT_VOLUMES_BLOCK 5
#define FIELD_BLOCK 6
#define SPLITS_BLOCK 7
#define PROBES_BLOCK 8
#define LIGHT_FILTERS_BLOCK 9
#define PANES_BLOCK 10
#define BLOCK_COUNT 11
#define PROBE_FILTER_BLOCK FROXEL_BLOCK  // no froxels are filled meanwhile
#define TRANSPARENT_BLOCK DRAW_BLOCK     // no surface is drawn meanwhile
#define INSPECT_BLOCK DRAW_BLOCK         // no surface is drawn while a frame is inspected

// Texture units.
#define SCENE_DEPTH_UNIT 0
#define LAYER_DEPTH_UNIT 1
#define SCATTERING_UNIT 2
#define TRANSMITTANCE_UNIT 3
#define BLUE_NOISE_UNIT 4
#define SHADOW_MAP_UNIT 5
#define IRRADIANCE_UNIT 6
#define STEP_TILES_UNIT 6  // no surface is drawn meanwhile
#define WALLS_UNIT 7       // of surfaces as they are drawn
#define LTC_UNIT 1         // nor is a layer there yet
#define DEPTH_VOLUME_UNIT 8
#define WORLD_VOLUME_UNIT 9
#define GRID_UNIT                                                                                  \
    10  // the first of two units a grid: texels, and pages if it has bricks
        // (LIGHT_FILTERS_UNIT, where transparents cast, is the one behind them)

// Of the march's history, when the march is done with its jitter.
#define KEPT_UNIT 4
#define KEPT_MORE_UNIT 7

// The froxels' steps meet neither a layer nor the world's pictures: they take their units.
#define V_BUFFER_SIGMA_S_UNIT 1
#define V_BUFFER_SIGMA_T_UNIT 2
#define V_BUFFER_EMISSION_UNIT 3
#define V_BUFFER_PHASE_UNIT 4
#define FROXEL_HISTORY_UNIT 6
#define FROXEL_HISTORY_EXTINCTION_UNIT 7
#define FROXEL_FRAME_SOURCE_UNIT DEPTH_VOLUME_UNIT  // what froxels keep is added when they are lit
#define FROXEL_COUNTS_UNIT WORLD_VOLUME_UNIT
#define FROXEL_SOURCE_UNIT 1
#define FROXEL_EXTINCTION_UNIT 2
#define INTEGRATED_SCATTERING_UNIT 1
#define INTEGRATED_TRANSMITTANCE_UNIT 2

// Transparents, once the march or the froxels are done. What is looked up at a depth has the
// froxels' units or these.
#define SPLIT_SCATTERING_UNIT SCATTERING_UNIT
#define SPLIT_TRANSMITTANCE_UNIT TRANSMITTANCE_UNIT
#define TRANSPARENT_IMAGE_UNIT 4
#define PICTURE_UNIT 5
#define PANE_LAYER_UNIT PICTURE_UNIT  // panes in order read no picture
#define LIGHT_FILTERS_DRAWN_UNIT 5    // as lights' filters are drawn, which reads no shadow map

// An inspection's steps read one texture that no other of theirs does.
#define INSPECTED_UNIT 1
#define EXTENT_TILES 64  // along both edges of a picture whose values' ends are looked for

// While the volumes of light are filled none of them is read but this one.
#define EXTINCTION_VOLUME_UNIT DEPTH_VOLUME_UNIT

// While the field of light is filled.
#define FIELD_LIGHT_UNIT 1
#define FIELD_SIGMA_T_UNIT 2
#define FIELD_ALBEDO_UNIT 3
#define FIELD_SOURCE_UNIT 4
#define FIELD_SUMS_UNIT 5
#define FIELD_CROSSED_UNIT 6
#define FIELD_WAYS_UNIT 7
#define FIELD_EMISSION_UNIT FIELD_ALBEDO_UNIT
#define FIELD_ORDER_UNIT FIELD_SIGMA_T_UNIT
#define FIELD_WORLD_UNIT FIELD_WAYS_UNIT
#define FACES_UNIT FIELD_LIGHT_UNIT
#define FACE_MATERIALS_UNIT FIELD_ALBEDO_UNIT
#define FACE_LIGHT_UNIT FIELD_ALBEDO_UNIT
#define BEYOND_UNIT FIELD_SOURCE_UNIT

// While a probe is filtered.
#define PROBE_SOURCE_UNIT 1

// When surfaces are drawn, which read no layer.
#define WORLD_PROBE_UNIT 2
#define PROBES_UNIT 3

// A window shows pictures when no pass runs.
#define DISPLAY_A_UNIT 0
#define DISPLAY_B_UNIT 1

// Image units of the froxels' steps: never more than four at once.
#define V_BUFFER_SIGMA_S_IMAGE 0
#define V_BUFFER_SIGMA_T_IMAGE 1
#define V_BUFFER_EMISSION_IMAGE 2
#define V_BUFFER_PHASE_IMAGE 3
#define FROXEL_SOURCE_IMAGE 0
#define FROXEL_EXTINCTION_IMAGE 1
#define FROXEL_COUNTS_IMAGE 2
#define INTEGRATED_SCATTERING_IMAGE 0
#define INTEGRATED_TRANSMITTANCE_IMAGE 1
#define SPLIT_SCATTERING_IMAGE 0
#define SPLIT_TRANSMITTANCE_IMAGE 1
#define FRAGMENT_LISTS_IMAGE 0
#define LAYER_IMAGE 2  // of the march's steps, whose split layers are 0 and 1
#define LAYER_MORE_IMAGE 3
#define PICTURE_IMAGE 2
#define IMAGE_COUNT 4

// Storage buffers.
#define FRAGMENT_COUNT_BUFFER 0
#define FRAGMENTS_BUFFER 1
#define STORAGE_COUNT 2
#define TILE_LIST_BUFFER FRAGMENT_COUNT_BUFFER  // no transparents are listed meanwhile

// What a picture is multiplied by when something is laid over it.
#define FACTOR_ZERO 0
#define FACTOR_ONE 1
#define FACTOR_ALPHA 2  // of what is laid over it
#define FACTOR_COLOR 3
#define FACTOR_TRANSMITTANCE 4

// Froxels, and columns of them along an edge, that a work group takes.
#define FROXEL_GROUP_X 8
#define FROXEL_GROUP_Y 4
#define FROXEL_GROUP_Z 2
#define FROXEL_COLUMNS 8
#define PICTURE_GROUP 8  // pixels along both edges
#define VOLUME_GROUP 4   // nodes along each edge, in the volumes of light
#define COLUMN_GROUP 8   // columns of nodes along each edge

// How many of each a scene may hold: uniform blocks are at least 16 KiB and fragment shaders have
// at least 16 texture units, so 3 bricked grids always fit, more where the driver has more.
#define MAX_MEDIA 16
#define MAX_GRIDS 12
#define MAX_LIGHTS 16
#define MAX_LIGHT_POINTS 64  // that stand for them
#define MAX_SHADOW_VIEWS 96  // 16 points, 6 each
#define MAX_OCTAVES 16
#define MAX_ISLANDS 48  // of all media
#define MAX_PROBES 16
#define PROBE_MAPS 8  // of a probe at most, one a roughness
#define BLUE_NOISE_SIZE 64
#define LTC_ROWS 32  // of the table that scripts/make_ltc_table.py makes
#define LTC_COLUMNS 48
