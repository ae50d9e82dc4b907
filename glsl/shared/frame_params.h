// What all passes of a frame know of its camera and its steps.
//
// World space on the GPU is the world's axes and metres with the origin at the eye: a scene a
// thousand kilometres from the world's origin keeps its precision. Matrices are composed in double.
#include "shared/types.h"
FUM_SHARED_BEGIN

struct FrameParams {
    // A pixel's ray: p(view_z) = origin + direction * view_z. Both are affine in NDC x, y:
    // centre + x * dx + y * dy. The direction's view depth is 1, so its length is metres of ray per
    // metre of view depth; it is 0 0 -1 turned to the world for an orthographic camera.
    vec4 ray_origin;
    vec4 ray_origin_dx;
    vec4 ray_origin_dy;
    vec4 ray_direction;
    vec4 ray_direction_dx;
    vec4 ray_direction_dy;

    // view_z = (x * depth + y) / (z * depth + w), of the depth that the host's buffer holds, from
    // its projection's own matrix: any convention, finite or infinite.
    vec4 view_z_from_depth;
    vec4 sky_depth;  // x: what the buffer holds where nothing was drawn

    vec4 full_size;   // x, y: pixels of the scene; z, w: 1 / pixels
    vec4 layer_size;  // x, y: texels of the volume layer; z, w: 1 / texels
    // x, y: from the middle of texel i to its sample at (i + 1/2 + offset) texels of the picture:
    // less the layer's guard band, plus what varies from frame to frame where frames are averaged;
    // z, w: the same in whole pixels.
    vec4 layer_offset;

    vec4 step_range;   // view_z [m] of the first and the last step's end; z: log2(last / first);
                       // w: the march ends once less than this is transmitted
    vec4 media_range;  // view_z [m] within which media can be: nearest, farthest; z: their
                       // difference if orthographic, else 0
    // x: steps; y: lambda, 0 linear .. 1 exponential; z: shadow steps; w: jitter offset
    vec4 march;
    vec4 resolve;  // x: depth threshold; y: largest value the layer's format holds; z: g clamp; w:
                   // least sigma_t [1/m]
};

FUM_SHARED_END
