// What the upsample needs of the frame's block, the same all over a tile: one instruction a number, where llvmpipe has
// twenty for one of a block.
//   FRAME_VARYING  out or in
flat FRAME_VARYING vec4 frame_depths;  // view_z_from_depth
flat FRAME_VARYING vec4 frame_limits;  // media_range, sky_depth, depth_threshold
flat FRAME_VARYING vec3 frame_layer;   // layer_offset, media_depth
