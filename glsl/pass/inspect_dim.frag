// What the host's picture is multiplied by, so that what an inspection draws over it stands out.
layout(location = 0) out vec4 out_color;

void main() { out_color = vec4(0.25); }
