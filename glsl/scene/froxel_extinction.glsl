// A froxel's extinction, where one number is enough for it: in the alpha of a colour that the froxel has anyway.
// Needs scene/froxels.glsl.
// Variant
const bool kOneColor = false;  // all media's extinction has one colour; what is integrated has three numbers

bool has_one_extinction() { return kExtinctionInAlpha || kOneColor; }

// The number, of an extinction.
float extinction_number(vec3 extinction)
{
    return kOneColor ? max(extinction.r, max(extinction.g, extinction.b)) : extinction.r;
}

// The extinction, of what has the number in its alpha, and in alpha the number.
vec4 extinction_of_number(vec4 color)
{
    return kOneColor ? vec4(u_froxels.extinction_color * color.a, color.a) : color.aaaa;
}
