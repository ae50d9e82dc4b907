// Where steps end along view depth: a mix of a linear and an exponential split of [range.x, range.y],
// Eevee's of July 2017. progress in 0..1 (beyond 1 overshoots the range); lambda = 0 is linear,
// 1 exponential. octaves = log2(range.y / range.x), used where lambda > 0.
float step_split(float progress, vec2 range, float octaves, float lambda)
{
    float linear_split = mix(range.x, range.y, progress);
    if (lambda == 0.0)
        return linear_split;
    // Not mix(): many drivers work that out as a difference, which loses a small split beside a large one.
    return linear_split * (1.0 - lambda) + range.x * exp2(octaves * progress) * lambda;
}

// The last of `steps` steps whose start is not past z.
int step_at(float z, int steps, vec2 range, float octaves, float lambda)
{
    int low = 0;
    int high = steps;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (step_split(float(middle) / float(steps), range, octaves, lambda) <= z)
            low = middle;
        else
            high = middle;
    }
    return low;
}
