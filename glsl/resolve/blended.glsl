// A resolve by fragments: the blending stage lays it over the picture.
#ifdef BOTH
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_transmittance;
#else
layout(location = 0) out vec4 out_color;
#endif

void main()
{
    Resolved resolved = resolve_pixel(ivec2(gl_FragCoord.xy));
    out_color = resolved.color;
#ifdef BOTH
    out_transmittance = vec4(resolved.transmittance, 1.0);
#endif
}
