// Where the nodes of what arrives of a fire stand.
#include "shared/light_volume_params.h"

vec3 fire_node(FireParams fire, vec3 p)
{
    vec3 from = p - fire.middle;
    vec3 beyond = max(abs(from) - fire.core, vec3(0.0));
    vec3 even = min(abs(from), fire.core) + fire.growth * log(1.0 + beyond / fire.growth);
    return fire.first + sign(from) * even * fire.inverse_node;
}

vec3 fire_place(FireParams fire, vec3 node)
{
    vec3 from = (node - fire.first) / fire.inverse_node;
    vec3 beyond = max(abs(from) - fire.core, vec3(0.0));
    vec3 metres = min(abs(from), fire.core) + fire.growth * (exp(beyond / fire.growth) - 1.0);
    return fire.middle + sign(from) * metres;
}
