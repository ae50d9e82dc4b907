// Where each pass finds its blocks and textures: the one place for both sides.
#ifdef __cplusplus
#pragma once
#endif

// Uniform blocks.
#define FRAME_BLOCK 0
#define MEDIA_BLOCK 1
#define LIGHTS_BLOCK 2
#define DRAW_BLOCK 3
#define BLOCK_COUNT 4

// Texture units.
#define SCENE_DEPTH_UNIT 0
#define LAYER_DEPTH_UNIT 1
#define SCATTERING_UNIT 2
#define TRANSMITTANCE_UNIT 3
#define BLUE_NOISE_UNIT 4
#define SHADOW_MAP_UNIT 5
#define IRRADIANCE_UNIT 6
#define GRID_UNIT 7  // the first of two units a grid: texels, and pages if it has bricks

// How many of each a scene may hold: uniform blocks are at least 16 KiB and fragment shaders have
// at least 16 texture units, so 4 bricked grids always fit, more where the driver has more.
#define MAX_MEDIA 16
#define MAX_GRIDS 12
#define MAX_LIGHTS 16
#define MAX_SHADOW_VIEWS 96  // 16 points, 6 each
#define MAX_OCTAVES 16
#define BLUE_NOISE_SIZE 64
