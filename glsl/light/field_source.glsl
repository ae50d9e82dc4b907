// Between two nodes along a way, a source that is linear in optical depth: Olson and Kunasz 1987, "Short characteristic
// solution of the non-LTE line transfer problem", sec. 3. extinction_t: a vec3 where the scene has coloured extinction,
// else one number.
#include "lib/slab.glsl"

// `thick`, or `thin` where tau is less than `end`.
float chosen(float thick, float thin, float tau, float end) { return tau < end ? thin : thick; }
vec3 chosen(vec3 thick, vec3 thin, float tau, float end) { return tau < end ? thin : thick; }
vec3 chosen(vec3 thick, vec3 thin, vec3 tau, float end) { return mix(thick, thin, lessThan(tau, vec3(end))); }

struct Piece {
    extinction_t tau;
    extinction_t weight;   // slab_weight(tau)
    extinction_t through;  // of what comes
    extinction_t of_end;   // of the source at its end, and at its beginning, what gets to the end
    extinction_t of_begin;
};

Piece piece_of(extinction_t tau)
{
    Piece piece;
    piece.tau = tau;
    piece.weight = slab_weight(tau);
    piece.through = exp(-tau);
    extinction_t series = tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0 - tau * (1.0 / 120.0))));
    piece.of_end = chosen(1.0 - piece.weight, series, tau, 0.1);
    piece.of_begin = 1.0 - piece.through - piece.of_end;
    return piece;
}

// Mean radiance in it, by what dims there: what is lost to the way is what the medium takes in.
//   emitted   in all
//   source    the mean of the sources at its ends
vec3 mean_in(Piece piece, vec3 came, vec3 left, vec3 emitted, vec3 source)
{
    vec3 taken = (came - left + emitted) / max(piece.tau, 1e-6) + source;
    return chosen(taken, 0.5 * (came + left), piece.tau, 0.05);
}
