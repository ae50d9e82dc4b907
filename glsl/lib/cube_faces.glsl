// Six pictures that see all around, +x -x +y -y +z -z: the one that looks along axis a has a + 2 up, as light/probe_view.h has it.

// Texture coordinates and layer of the picture that sees a direction.
vec3 cube_face(vec3 d)
{
    vec3 size = abs(d);
    int a = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    vec3 turned = a == 0 ? d.xyz : a == 1 ? d.yzx : d.zxy;
    float side = turned.x < 0.0 ? -1.0 : 1.0;
    vec2 ndc = vec2(-side * turned.y, turned.z) / abs(turned.x);
    return vec3(0.5 + 0.5 * ndc, float(2 * a + (side < 0.0 ? 1 : 0)));
}
