// What transparent/over.frag needs of its blocks, the same all over a draw: one instruction a number, where llvmpipe has
// twenty for one of a block.
//   OVER_VARYING  out or in
flat OVER_VARYING vec4 over_depths;  // view_z_from_depth
flat OVER_VARYING vec3 over_limits;  // the end of media_range, sky_depth, radiance_limit
flat OVER_VARYING vec4 over_layer;   // layer_offset, inverse_layer_size
flat OVER_VARYING vec4 over_sizes;   // inverse_full_size, layer_size
flat OVER_VARYING vec2 over_view_z;  // and of TransparentParams
flat OVER_VARYING vec4 over_source;
flat OVER_VARYING vec3 over_of_source, over_of_behind;
flat OVER_VARYING vec4 over_faded, over_fades;
flat OVER_VARYING float over_inverse_depth_fade;
flat OVER_VARYING int over_pane;
flat OVER_VARYING vec4 over_splits[4];  // depths that a march kept, unless they are more
flat OVER_VARYING int over_split_count;
