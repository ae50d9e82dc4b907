// One surface as the lines along a way meet it: marks the node that each line comes to next. What lies beyond the
// lattice hides the line's first node.
#include "light/faces.glsl"
#include "light/line.glsl"
#include "lib/walls.glsl"
#include "shared/draw_params.h"

// Variant
const bool kBeyond = false;  // what lies beyond the lattice is asked for, else what lies in it
const bool kWalls = false;   // twice how far before the node it lies is kept instead; odd: it is seen from within
const bool kFaces = false;   // and what lies there
const bool kParts = false;   // as FACE_PARTS lines on each side of a node's own part have it

layout(std140, binding = DRAW_BLOCK) uniform Draw { DrawParams u_draw; };
layout(r32ui, binding = 0) uniform uimage3D u_crossed_img;
in vec3 p_world;
in vec3 normal;
flat in int k;

void main()
{
    FieldWay way = u_field.ways[k];
    ivec2 line = ivec2(gl_FragCoord.xy) - ivec2(first_pixel(k), 0);
    Meeting meeting = meeting_at(way, p_world, kParts ? line / FACE_PARTS : line);
    if (meeting.beyond != kBeyond || !meeting.is_met)
        return;
    float before = max(meeting.before, 0.0);
    if (kWalls || kFaces) {
        if (before > 1.0)
            return;
        bool is_inside = dot(normal, way.wi) > 0.0;
        bool is_open = u_draw.is_open != 0;
        uint word = uint(before * float(WALL_STEPS)) << 1 | uint(is_inside && !is_open);
        if (kFaces) {
            word = pack_face(before, is_inside ? -normal : normal, is_inside && !is_open ? kNoSurface : u_draw.number);
        }
        ivec3 at = meeting.node + (kFaces ? layer_of(k) : way_of(k));
        if (kParts)
            at += part_of_face(line);
        imageAtomicMin(u_crossed_img, at, word);
        return;
    }
    int number = u_field.first + k;
    ivec3 word = meeting.node + layer_of(number >> 5);
    uint bit = 1u << uint(number & 31);
    imageAtomicOr(u_crossed_img, word, bit);
    if (!kBeyond && dot(normal, way.wi) < 0.0)  // light goes the other way
        imageAtomicOr(u_crossed_img, word + layer_of(3 * FIELD_CROSSED_WORDS), bit);
}
