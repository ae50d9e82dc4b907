// A surface's way to the first sun through the columns of the depth volume (scene/light_volumes.glsl), worked out at the
// corners of its triangles: what grows evenly over them, and what is the same all over. A fragment has each of these
// numbers in an instruction, and one of a uniform block in twenty on llvmpipe.
//   SUN_VARYING  out or in
SUN_VARYING vec4 way_column;
SUN_VARYING vec3 way_enters;
flat SUN_VARYING vec3 way_across, way_towards;
flat SUN_VARYING vec3 way_first, way_period;
flat SUN_VARYING vec4 way_color;  // of extinction
