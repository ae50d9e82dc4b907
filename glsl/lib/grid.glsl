// The value of a voxel grid at a point, trilinear, from either layout (src/medium/grid_layout.h).
// q: voxels from the texture's first. Answers stored units times the grid's scale; scalar grids in .r.
#include "shared/brick_page.h"
#include "shared/medium_params.h"

// A dense texture carries a layer of zeros on each side, so clamping to its edge fades to 0 outside.
vec4 sample_dense(sampler3D texels, GridParams grid, vec3 q)
{
    return textureLod(texels, (q + 0.5) * grid.inverse_size, 0.0) * grid.unit;
}

const float kBrickDim = 8.0;
const float kAtlasBrickDim = 9.0;

// At a point of a page, in voxels from its corner.
vec4 sample_page(sampler3D atlas, uint entry, GridParams grid, vec3 in_page)
{
    if (!is_brick(entry))
        return vec4(uintBitsToFloat(page_constant_bits(entry)) * grid.unit, 0.0, 0.0, 0.0);
    vec3 slot = vec3(page_slot_x(entry), page_slot_y(entry), page_slot_z(entry));
    vec3 texel = slot * kAtlasBrickDim + in_page + 0.5;
    float scale = uintBitsToFloat(page_scale_bits(entry));
    return textureLod(atlas, texel * grid.inverse_size, 0.0) * (scale * grid.unit);
}

vec4 sample_bricks(sampler3D atlas, usampler3D pages, GridParams grid, vec3 q)
{
    vec3 page = floor(q * (1.0 / kBrickDim));
    if (any(lessThan(page, vec3(0.0))) || any(greaterThanEqual(page, grid.pages.xyz)))
        return vec4(0.0);
    return sample_page(atlas, texelFetch(pages, ivec3(page), 0).r, grid, q - page * kBrickDim);
}

// The same where the table is a tree of nodes of 8^3 entries, and voxels are counted from a page near the eye: a float
// would lose them.
vec4 sample_tree(sampler3D atlas, usampler3D nodes, GridParams grid, vec3 q)
{
    const float kFar = 1e9;  // pages: past all that there are
    vec3 from_eye = clamp(floor(q * (1.0 / kBrickDim)), -kFar, kFar);
    ivec3 page = ivec3(from_eye) + grid.tree.xyz;
    int shift = 3 * grid.tree.w;
    if (any(lessThan(page, ivec3(0))) || any(greaterThanEqual(page, ivec3(1 << shift))))
        return vec4(0.0);
    uint entry = kPageBrick;  // the root has the first place
    do {
        shift -= 3;
        ivec3 node = 8 * ivec3(page_slot_x(entry), page_slot_y(entry), page_slot_z(entry));
        entry = texelFetch(nodes, node + (page >> shift & 7), 0).r;
    } while (is_brick(entry) && shift > 0);
    return sample_page(atlas, entry, grid, q - from_eye * kBrickDim);
}
