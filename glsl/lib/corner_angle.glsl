// Of a rectangle from its corner under a point to one that is `to` from there, so far away [sr]. The sum of those of its
// corners, by turns with either sign, is the solid angle of any.
float corner_angle(vec2 to, float away) { return atan(to.x * to.y, away * sqrt(dot(to, to) + away * away)); }
