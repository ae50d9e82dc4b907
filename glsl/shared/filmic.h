// The constants of the filmic display transform: src/write/display_transform.cpp, which names its
// sources, and glsl/lib/display.glsl.
#ifdef __cplusplus
#pragma once
#endif

// Hable 2010, shoulder strength to toe denominator, his values.
#define HABLE_A 0.15f
#define HABLE_B 0.50f
#define HABLE_C 0.10f
#define HABLE_D 0.20f
#define HABLE_E 0.02f
#define HABLE_F 0.30f

// Exposed radiance that is a screen's white: 5.5 stops over middle grey, where fire still has form.
#define FILMIC_WHITE 8.0f

// Scales radiance into Hable's curve so that 0.18 is shown as 0.18: middle grey stays middle grey.
#define FILMIC_SCALE 3.4583109f

// Khronos 2024's own value: higher fades sooner.
#define FILMIC_DESATURATION 0.15f
