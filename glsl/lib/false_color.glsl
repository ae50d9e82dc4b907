// Numbers in colours: the palette of src/study/false_color.cpp, from the same table.
#include "shared/magma.h"

// What a picture of values holds where there is nothing to show: no value is as large.
const float kNothing = 1e30;

// IEC 61966-2-1.
vec3 srgb_decode(vec3 encoded)
{
    return mix(pow((encoded + 0.055) / 1.055, vec3(2.4)), encoded / 12.92, lessThanEqual(encoded, vec3(0.04045)));
}

// Linear colour of t in 0..1, what is outside at the end's colour. Between the table's colours as they are
// encoded, where equal steps look equal.
vec3 magma(float t)
{
    const ivec3 table[MAGMA_COUNT] = ivec3[](MAGMA(ivec3));
    float position = clamp(t, 0.0, 1.0) * float(MAGMA_COUNT - 1);
    int below = min(int(position), MAGMA_COUNT - 2);
    return srgb_decode(mix(vec3(table[below]), vec3(table[below + 1]), position - float(below)) / 255.0);
}
