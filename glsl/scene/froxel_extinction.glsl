// How the extinction of a froxel is kept: where one number is enough for it, in the alpha of the froxel's source; else
// as three, of which red is in that alpha where the format has one. Needs scene/froxels.glsl.
#include "lib/channels.glsl"

// Variant
const bool kOneColor = false;  // all media's extinction has one colour; what is integrated has three numbers

bool has_one_extinction() { return kExtinctionInAlpha || kOneColor; }

// The number, of an extinction.
float extinction_number(vec3 extinction) { return kOneColor ? most(extinction) : extinction.r; }

vec3 extinction_of_number(float number) { return kOneColor ? u_froxels.extinction_color * number : vec3(number); }

// What the alpha of a froxel's source has of its extinction, and what a volume of its own has, if there is one.
float extinction_in_source(vec3 extinction)
{
    if (has_one_extinction())
        return extinction_number(extinction);
    return kRedInAlpha ? extinction.r : 0.0;
}

vec4 extinction_apart(vec3 extinction) { return kRedInAlpha ? vec4(extinction.gb, 0.0, 0.0) : vec4(extinction, 0.0); }

// The extinction, of both.
vec3 extinction_of_kept(vec4 source, vec4 apart)
{
    if (has_one_extinction())
        return extinction_of_number(source.a);
    return kRedInAlpha ? vec3(source.a, apart.rg) : apart.rgb;
}
