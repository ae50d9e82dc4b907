// Real spherical harmonics of bands 0 to 3, orthonormal over the sphere; d: unit length; in each
// band from m = -l to l. Sloan 2008, "Stupid Spherical Harmonics Tricks", appendix A2.
#ifdef __cplusplus
#pragma once
#else
const int kHarmonics[4] = int[4](1, 4, 9, 16);  // of bands 0 .. l
#endif
#include "shared/types.h"
FUM_SHARED_BEGIN

FUM_SHARED_FUNCTION float spherical_harmonic(int i, vec3 d)
{
    switch (i) {
    case 0:
        return 0.282094791773878f;
    case 1:
        return 0.488602511902920f * d.y;
    case 2:
        return 0.488602511902920f * d.z;
    case 3:
        return 0.488602511902920f * d.x;
    case 4:
        return 1.09254843059208f * d.x * d.y;
    case 5:
        return 1.09254843059208f * d.y * d.z;
    case 6:
        return 0.315391565252520f * (3.0f * d.z * d.z - 1.0f);
    case 7:
        return 1.09254843059208f * d.x * d.z;
    case 8:
        return 0.546274215296040f * (d.x * d.x - d.y * d.y);
    case 9:
        return 0.590043589926644f * d.y * (3.0f * d.x * d.x - d.y * d.y);
    case 10:
        return 2.89061144264055f * d.x * d.y * d.z;
    case 11:
        return 0.457045799464466f * d.y * (5.0f * d.z * d.z - 1.0f);
    case 12:
        return 0.373176332590115f * d.z * (5.0f * d.z * d.z - 3.0f);
    case 13:
        return 0.457045799464466f * d.x * (5.0f * d.z * d.z - 1.0f);
    case 14:
        return 1.44530572132028f * d.z * (d.x * d.x - d.y * d.y);
    default:
        return 0.590043589926644f * d.x * (d.x * d.x - 3.0f * d.y * d.y);
    }
}

FUM_SHARED_END
