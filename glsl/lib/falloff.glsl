// 1/d^2 of a light over a piece of a line: it has a pole that steps of a march miss, or hit by chance.
// Kulla and Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media", 4.1.
//   s  begin and end of the piece, from the place nearest to the light [m]
//   d  the light's distance from the line [m], > 0
struct Falloff {
    float mean;   // of 1 / (d^2 + s^2) [1/m^2], from the angle that the light sees the piece under
    float place;  // before which `share` of that angle lies [m]
    float begin;  // where that angle begins, 0 at the place nearest to the light [rad]
    float angle;  // that the piece is seen under [rad]
    float ahead;  // how far the mean place of its light lies beyond the piece's middle [m]
};

Falloff falloff_over(vec2 s, float d, float share)
{
    float ds = max(s.y - s.x, 1e-20);
    float tangent = ds * d / (d * d + s.x * s.y);
    float angle = atan(tangent) + (tangent < 0.0 ? kPi : 0.0);
    float c = cos(share * angle);
    float n = sin(share * angle);
    float place = d * (s.x * c + d * n) / max(d * c - s.x * n, 1e-30);
    // Of s over 1 / (d^2 + s^2). Seen under less it is the middle, and d / angle loses its digits.
    float mean = 0.5 * d / angle * log((d * d + s.y * s.y) / (d * d + s.x * s.x));
    float ahead = angle > 0.01 ? clamp(mean, s.x, s.y) - 0.5 * (s.x + s.y) : 0.0;
    return Falloff(angle / (d * ds), clamp(place, s.x, s.y), atan(s.x / d), angle, ahead);
}

// 1 / distance, which is what a line through fog sees of a light beside it, has a pole that an average over lines
// holds and any one of them misses or hits. Of the lines through a disc, about one that passes the light at
// sqrt(d2), the mean of it is 1 over this. [m]
//   4 / (pi R) E(d / R) inside and its like outside (the potential of a charged disc in its plane): the first terms
//   of their series, and a power for the rim, where the slope has a pole; within 0.4 %.
float distance_of_disc(float d2, float radius)
{
    float r2 = radius * radius;
    float s = min(d2, r2) / max(d2, max(r2, 1e-30));  // (d / R)^2, or its inverse outside
    float s2 = s * s;
    float rim = s2 * s2 * s2 * s2 * s2;
    float within = radius / (2.0 - s * (0.5 + s * (0.09375 + 0.05 * s)) - 0.083 * rim);
    float beyond = sqrt(d2) / (1.0 + s * (0.125 + 0.07 * s) + 0.0782 * rim);
    return d2 < r2 ? within : beyond;
}
