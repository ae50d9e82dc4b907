// Of the channels of a colour, or of what has one alone.
float mean(float v) { return v; }
float mean(vec3 v) { return dot(v, vec3(1.0 / 3.0)); }
float most(float v) { return v; }
float most(vec3 v) { return max(v.r, max(v.g, v.b)); }
