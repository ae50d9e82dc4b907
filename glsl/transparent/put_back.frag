// What was summed up in 32 bits a channel, into the picture.
#include "shared/bindings.h"

layout(binding = PICTURE_UNIT) uniform sampler2D u_picture_tx;
layout(location = 0) out vec4 out_color;

void main() { out_color = texelFetch(u_picture_tx, ivec2(gl_FragCoord.xy), 0); }
