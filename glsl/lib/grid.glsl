// The value of a voxel grid at a point, trilinear, from either layout (src/medium/grid_layout.h).
// q: voxels from the texture's first. Answers stored units times the grid's scale; scalar grids in .r.
#include "shared/brick_page.h"
#include "shared/medium_params.h"

// A dense texture carries a layer of zeros on each side, so clamping to its edge fades to 0 outside.
vec4 sample_dense(sampler3D texels, GridParams grid, vec3 q)
{
    return textureLod(texels, (q + 0.5) * grid.inverse_size, 0.0) * grid.unit;
}

vec4 sample_bricks(sampler3D atlas, usampler3D pages, GridParams grid, vec3 q)
{
    const float kBrickDim = 8.0;
    const float kAtlasBrickDim = 9.0;
    vec3 page = floor(q * (1.0 / kBrickDim));
    if (any(lessThan(page, vec3(0.0))) || any(greaterThanEqual(page, grid.pages.xyz)))
        return vec4(0.0);
    uint entry = texelFetch(pages, ivec3(page), 0).r;
    if (!is_brick(entry))
        return vec4(uintBitsToFloat(page_constant_bits(entry)) * grid.unit, 0.0, 0.0, 0.0);
    vec3 slot = vec3(page_slot_x(entry), page_slot_y(entry), page_slot_z(entry));
    vec3 texel = slot * kAtlasBrickDim + (q - page * kBrickDim) + 0.5;
    float scale = uintBitsToFloat(page_scale_bits(entry));
    return textureLod(atlas, texel * grid.inverse_size, 0.0) * (scale * grid.unit);
}
