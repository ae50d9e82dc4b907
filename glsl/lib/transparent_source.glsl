// A transparent's source of blending where its colour and alpha are a picture's.

// scale: what multiplies a texel. is_filter: what the picture does not cover lets all through.
vec4 image_source(vec4 texel, vec4 scale, bool is_filter)
{
    vec4 source = texel * scale;
    if (is_filter)
        source.rgb += 1.0 - source.a;
    return source;
}
