// The value of a voxel grid at a point, trilinear, from either layout (src/medium/grid_layout.h).
// q: voxels from the texture's first. Answers stored units times the grid's scale; scalar grids in .r.
#include "shared/medium_params.h"

// A dense texture carries a layer of zeros on each side, so clamping to its edge fades to 0 outside.
vec4 sample_dense(sampler3D texels, GridParams grid, vec3 q)
{
    return textureLod(texels, (q + 0.5) * grid.inverse_size.xyz, 0.0) * grid.inverse_size.w;
}

vec4 sample_bricks(sampler3D atlas, usampler3D pages, GridParams grid, vec3 q)
{
    const uint kBrick = 0x80000000u;
    const float kBrickDim = 8.0;
    const float kAtlasBrickDim = 9.0;
    vec3 page = floor(q * (1.0 / kBrickDim));
    if (any(lessThan(page, vec3(0.0))) || any(greaterThanEqual(page, grid.pages.xyz)))
        return vec4(0.0);
    uint entry = texelFetch(pages, ivec3(page), 0).r;
    if (entry < kBrick)  // a constant, 0 where nothing is
        return vec4(uintBitsToFloat(entry << 1u) * grid.inverse_size.w, 0.0, 0.0, 0.0);
    vec3 slot = vec3(entry & 255u, (entry >> 8u) & 255u, (entry >> 16u) & 255u);
    vec3 texel = slot * kAtlasBrickDim + (q - page * kBrickDim) + 0.5;
    float scale = uintBitsToFloat(0x3f800000u - ((entry >> 4u) & 0x07f00000u));
    return textureLod(atlas, texel * grid.inverse_size.xyz, 0.0) * (scale * grid.inverse_size.w);
}
