// Real spherical harmonics of bands 0 to 2, orthonormal over the sphere; d: unit length. Order: 0; y z x;
// xy yz 3z^2-1 xz x^2-y^2. Sloan 2008, "Stupid Spherical Harmonics Tricks", appendix A2.
const int kHarmonics[3] = int[3](1, 4, 9);  // of bands 0 .. l

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
    default:
        return 0.546274215296040 * (d.x * d.x - d.y * d.y);
    }
}
