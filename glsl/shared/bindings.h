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
#define SKY_MAPS_BLOCK FROXEL_BLOCK      // no froxels are filled while a field is
#define PROBE_FILTER_BLOCK FROXEL_BLOCK  // no froxels are filled meanwhile
#define TRANSPARENT_BLOCK DRAW_BLOCK     // no surface is drawn meanwhile
#define INSPECT_BLOCK DRAW_BLOCK         // no surface is drawn while a frame is inspected
#define STEP_VIEW_BLOCK PANES_BLOCK      // a frame with panes projects no boxes on the GPU
#define ISLAND_LIGHT_BLOCK FIELD_BLOCK   // no field is filled while a frame is drawn
#define LIGHT_FADE_BLOCK FIELD_BLOCK     // nor while light fades

// Texture units: each has one name, and each texture a unit of its own. GL promises 96 of them;
// what it promises 16 of are those that one shader samples. Of a frame, and of its march.
#define SCENE_DEPTH_UNIT 0
#define LAYER_DEPTH_UNIT 1
#define BLUE_NOISE_UNIT 2
#define STEP_TILES_UNIT 3
#define SCATTERING_UNIT 4
#define TRANSMITTANCE_UNIT 5
#define KEPT_UNIT 6
#define KEPT_MORE_UNIT 7
#define SPLIT_SCATTERING_UNIT 8
#define SPLIT_TRANSMITTANCE_UNIT 9
// Of lights and what light meets.
#define SHADOW_MAP_UNIT 10
#define LIGHT_FILTERS_UNIT 11
#define DEPTH_VOLUME_UNIT 12
#define WORLD_VOLUME_UNIT 13
#define AMID_VOLUME_UNIT 14
#define WORLD_ON_SURFACES_UNIT 15
#define WALLS_UNIT 16  // of a lattice: what stands between its nodes, or how far each sees
#define IRRADIANCE_UNIT 17
#define ENVIRONMENT_UNIT 18
#define LTC_UNIT 19
#define WORLD_PROBE_UNIT 20
#define PROBES_UNIT 21
// Of the froxels.
#define V_BUFFER_SIGMA_S_UNIT 22
#define V_BUFFER_SIGMA_T_UNIT 23
#define V_BUFFER_EMISSION_UNIT 24
#define V_BUFFER_PHASE_UNIT 25
#define FROXEL_HISTORY_UNIT 26
#define FROXEL_HISTORY_EXTINCTION_UNIT 27
#define FROXEL_COUNTS_UNIT 28
#define FROXEL_SOURCE_UNIT 29
#define FROXEL_EXTINCTION_UNIT 30
#define INTEGRATED_SCATTERING_UNIT 31
#define INTEGRATED_TRANSMITTANCE_UNIT 32
// Of transparents.
#define TRANSPARENT_IMAGE_UNIT 33
#define PICTURE_UNIT 34
#define PANE_LAYER_UNIT 35
// While the volumes of light and the field are filled.
#define EXTINCTION_VOLUME_UNIT 36
#define WORLD_COEFFICIENTS_UNIT 37
#define FIELD_LIGHT_UNIT 38
#define FIELD_SIGMA_T_UNIT 39
#define FIELD_ALBEDO_UNIT 40
#define FIELD_SOURCE_UNIT 41
#define FIELD_SUMS_UNIT 42
#define FIELD_CROSSED_UNIT 43
#define FIELD_WAYS_UNIT 44
#define FIELD_EMISSION_UNIT 45
#define FIELD_ORDER_UNIT 46
#define FIELD_WORLD_UNIT 47
#define FACES_UNIT 48
#define FACE_MATERIALS_UNIT 49
#define FACE_LIGHT_UNIT 50
#define BEYOND_UNIT 51
// While probes are filtered, a frame is inspected, a window shows pictures.
#define PROBE_SOURCE_UNIT 52
#define INSPECTED_UNIT 53
#define DISPLAY_A_UNIT 54
#define DISPLAY_B_UNIT 55
// Two for each grid of a scene: texels, and pages behind those of all grids if it has bricks.
#define GRID_UNIT 56
#define MOST_SAMPLED 11  // by one shader, besides grids and lights' filters

#define EXTENT_TILES 64  // along both edges of a picture whose values' ends are looked for

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
#define STEP_TILES_IMAGE LAYER_IMAGE
#define IMAGE_COUNT 4

// Storage buffers.
#define FRAGMENT_COUNT_BUFFER 0
#define FRAGMENTS_BUFFER 1
#define STORAGE_COUNT 2
#define TILE_LIST_BUFFER FRAGMENT_COUNT_BUFFER  // no transparents are listed meanwhile
#define FIELD_NODES_BUFFER FRAGMENT_COUNT_BUFFER
#define STEP_BOXES_BUFFER FRAGMENT_COUNT_BUFFER
#define STEP_SEEN_BUFFER FRAGMENTS_BUFFER

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
#define FIRE_POINTS 8        // that tell what surfaces hide of what glows
#define MAX_OCTAVES 16
#define MAX_ISLANDS 48  // of all media
#define MAX_PROBES 16
#define PROBE_MAPS 8  // of a probe at most, one a roughness
#define BLUE_NOISE_SIZE 64
#define LTC_ROWS 32  // of the table that scripts/make_ltc_table.py makes
#define LTC_COLUMNS 48
