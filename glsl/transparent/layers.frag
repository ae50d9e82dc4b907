// How many transparent fragments a pixel has; kNothing where it has none.
#include "scene/fragment_lists.glsl"
#include "lib/false_color.glsl"

layout(location = 0) out float out_count;

void main()
{
    uint number = first_fragment(ivec2(gl_FragCoord.xy));
    float count = 0.0;
    if (number != 0u)
        do {
            count += 1.0;
            number = next_fragment(number);
        } while (number != 0u);
    out_count = count > 0.0 ? count : kNothing;
}
