// Axes whose third is n, of unit length. Duff and others 2017, "Building an Orthonormal Basis, Revisited".
mat3 basis_about(vec3 n)
{
    float side = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (side + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x), vec3(b, side + n.y * n.y * a, -n.y), n);
}
