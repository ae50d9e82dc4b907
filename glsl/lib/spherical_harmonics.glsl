// Real spherical harmonics of bands 0 to 3, orthonormal over the sphere; d: unit length; in each band from
// m = -l to l. Sloan 2008, "Stupid Spherical Harmonics Tricks", appendix A2.
const int kHarmonics[4] = int[4](1, 4, 9, 16);  // of bands 0 .. l

float spherical_harmonic(int i, vec3 d)
{
    switch (i) {
    case 0:
        return 0.282094791773878;
    case 1:
        return 0.488602511902920 * d.y;
    case 2:
        return 0.488602511902920 * d.z;
    case 3:
        return 0.488602511902920 * d.x;
    case 4:
        return 1.09254843059208 * d.x * d.y;
    case 5:
        return 1.09254843059208 * d.y * d.z;
    case 6:
        return 0.315391565252520 * (3.0 * d.z * d.z - 1.0);
    case 7:
        return 1.09254843059208 * d.x * d.z;
    case 8:
        return 0.546274215296040 * (d.x * d.x - d.y * d.y);
    case 9:
        return 0.590043589926644 * d.y * (3.0 * d.x * d.x - d.y * d.y);
    case 10:
        return 2.89061144264055 * d.x * d.y * d.z;
    case 11:
        return 0.457045799464466 * d.y * (5.0 * d.z * d.z - 1.0);
    case 12:
        return 0.373176332590115 * d.z * (5.0 * d.z * d.z - 3.0);
    case 13:
        return 0.457045799464466 * d.x * (5.0 * d.z * d.z - 1.0);
    case 14:
        return 1.44530572132028 * d.z * (d.x * d.x - d.y * d.y);
    default:
        return 0.590043589926644 * d.x * (d.x * d.x - 3.0 * d.y * d.y);
    }
}
