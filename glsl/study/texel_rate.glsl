// How many trilinear texels a second this machine fetches from a volume: the limit of any pass that
// reads volumes. Neighbouring pixels walk side by side through it, as neighbouring rays do.
//   in   a volume of one channel
//   out  the sum of what was fetched, so that no fetch can be left out

// Variant
const int kFetches = 1;      // of each pixel
const int kTexelPixels = 1;  // along each edge of the picture

layout(binding = 0) uniform sampler3D u_volume_tx;

float sum_of_fetches(ivec2 pixel)
{
    vec2 uv = (vec2(pixel) + 0.5) / float(kTexelPixels);
    float sum = 0.0;
    for (int i = 0; i < kFetches; ++i)
        sum += textureLod(u_volume_tx, vec3(uv, (float(i) + 0.5) / float(kFetches)), 0.0).r;
    return sum;
}
