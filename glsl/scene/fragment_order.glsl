// Puts a pixel's list of fragments in order.
#include "scene/fragment_lists.glsl"

void link_fragment(uint number, uint next)
{
    if (next_fragment(number) != next)
        u_fragments[fragment_word(number)] = next;
}

// Whether the first lies behind the second.
bool is_behind(float view_z, uint key, float other_view_z, uint other_key)
{
    return view_z > other_view_z || (view_z == other_view_z && key < other_key);
}

// Puts a list in order from the farthest to the nearest, by insertion: nothing is written to one that is in order,
// as lists are where draws come the nearest first and do not cross. @returns its first; 0 if there is none
uint sort_fragments(ivec2 pixel)
{
    uint first = first_fragment(pixel);
    if (first == 0u)
        return 0u;
    uint head = first, tail = first;
    float tail_z = fragment_view_z(tail);
    uint tail_key = fragment_key_at(tail);
    uint at = next_fragment(first);
    if (at != 0u)
        do {
            uint next = next_fragment(at);
            float view_z = fragment_view_z(at);
            uint key = fragment_key_at(at);
            if (!is_behind(view_z, key, tail_z, tail_key)) {
                link_fragment(tail, at);
                tail = at;
                tail_z = view_z;
                tail_key = key;
            } else {
                uint before = 0u, after = head;
                if (is_behind(fragment_view_z(after), fragment_key_at(after), view_z, key))
                    do {
                        before = after;
                        after = next_fragment(after);
                    } while (is_behind(fragment_view_z(after), fragment_key_at(after), view_z, key));
                link_fragment(at, after);
                if (before == 0u)
                    head = at;
                else
                    link_fragment(before, at);
            }
            at = next;
        } while (at != 0u);
    link_fragment(tail, 0u);
    if (head != first)
        imageStore(u_first_img, pixel, uvec4(head));
    return head;
}
