#!/usr/bin/env python3
"""fit_probe_lobes.py : prints the constants of glsl/scene/ambient_gloss.glsl, which reflect a probe. Needs numpy; takes minutes.

A metal shows the light about it by GGX's lobe, D V F n.wi (docs/methods.md, Surfaces). Seen at a slant that is none of the
round lobes that a probe's maps are filtered by, so four of those stand for it, along the plane of incidence: where each
lies (in slopes over alpha, away from the eye and towards it) and how wide it is (over alpha) are polynomials of the
roughness. They are fitted to the light of a lamp of some 15 degrees before a sky, at places all around and within the
lobe, from five slants and at nine roughnesses, by Levenberg's and Marquardt's method on the relative errors. The same
figures come out each time: no random number is drawn.
"""
import numpy as np

DEGREE = 2
F0 = 0.6
NARROWEST, WIDEST = 0.2, 1.0  # of a lobe: over alpha, and alpha (kNarrowest, and the last of a probe's maps)
# Where fits to one roughness after the other, and then to these, have come to: there are several minima about as deep.
START = [
    [-1.624, 0.0785, -0.6085, 1.6122, 1.1231, 1.708, -0.0679, 1.3534],
    [1.9876, -0.6717, 2.9043, -0.5197, 0.3012, -3.2854, 1.54, 1.6237],
    [-0.2931, 0.9957, -1.6436, 0.0507, -0.2789, 2.8936, 0.1818, -0.6425],
]
ALPHAS = [0.02, 0.0625, 0.1225, 0.2025, 0.3025, 0.4225, 0.5625, 0.75, 1.0]
WEIGHTS = {0.0625: 1.2, 0.1225: 1.9, 0.4225: 1.4, 0.5625: 1.3}  # so that none is much worse than the others
COSINES = [0.22, 0.4, 0.58, 0.76, 0.94]  # to the eye
WITHIN = 1.25  # weight of what lies within the lobe
ITERATIONS = 60


def normalized(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def sky(d, lamp):
    return 0.5 * (1.3 + d[..., 2] + 0.3 * np.sin(4 * d[..., 0])) + 16 * np.exp(30 * (d @ lamp - 1))


def visibility(n_wo, n_wi, alpha):
    a2 = alpha * alpha
    return 0.5 / (n_wi * np.sqrt(a2 + (1 - a2) * n_wo**2) + n_wo * np.sqrt(a2 + (1 - a2) * n_wi**2))


def fresnel(wo_h):
    return F0 + (1 - F0) * (1 - np.clip(wo_h, 0, 1)) ** 5


def reflected(wo, alpha, lamp, count=40):
    """The mean over the lobe, by half vectors as wo sees them (Heitz 2018)."""
    a2 = alpha * alpha
    v = normalized(np.array([alpha * wo[0], alpha * wo[1], wo[2]]))
    x = normalized(np.array([-v[1], v[0], 0]))
    y = np.cross(v, x)
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    r, phi = np.sqrt((i + 0.5) / count), 2 * np.pi * (j + 0.5) / count
    s = 0.5 * (1 + v[2])
    p1 = r * np.cos(phi)
    p2 = (1 - s) * np.sqrt(1 - p1 * p1) + s * r * np.sin(phi)
    n = p1[..., None] * x + p2[..., None] * y + np.sqrt(np.maximum(1 - p1**2 - p2**2, 0))[..., None] * v
    h = normalized(n * [alpha, alpha, 1])
    wi = 2 * (h @ wo)[..., None] * h - wo
    above = wi[..., 2] > 0
    n_wi = np.where(above, wi[..., 2], 1)
    weight = np.where(above, visibility(wo[2], n_wi, alpha) * n_wi * fresnel(h @ wo), 0)
    # D and what half vectors are spread by have D in common.
    return (weight * sky(wi, lamp)).sum() / weight.sum()


def round_lobe(d, alpha, lamp, rings=16, turns=20):
    """Of a probe's map: GGX about d as a surface that faces it has it."""
    x = normalized(np.cross(d, [1.0, 0, 0] if abs(d[0]) < 0.5 else [0, 1.0, 0]))
    y = np.cross(d, x)
    u = (np.arange(rings) + 0.5) / rings
    angle = 2 * np.arctan(alpha * np.sqrt(u / (1 - u)))
    angle = angle[angle < np.pi / 2]
    phi = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    around = np.cos(phi)[None, :, None] * x + np.sin(phi)[None, :, None] * y
    cosine = np.cos(angle)[:, None]
    wi = cosine[..., None] * d + np.sin(angle)[:, None, None] * around
    return (cosine * sky(wi, lamp)).sum() / (cosine.sum() * turns)


def by_lobes(wo, alpha, lamp, numbers):
    n = np.array([0, 0, 1.0])
    light = weights = 0
    for slope, width in zip(numbers[:4], numbers[4:]):
        h = normalized(n + (wo - n * wo[2]) * (alpha * slope))
        wo_h = wo @ h
        d = 2 * wo_h * h - wo
        if wo_h <= 0 or d[2] <= 0:
            continue
        weight = fresnel(wo_h) * visibility(wo[2], d[2], alpha) * d[2] * wo_h / h[2]
        light += weight * round_lobe(d, min(alpha * max(width * wo_h, NARROWEST), WIDEST), lamp)
        weights += weight
    return light / weights


def all_around(count=14):
    z = 0.05 + 0.95 * (np.arange(count) + 0.5) / count
    phi = 2.399963 * np.arange(count)  # the golden angle
    r = np.sqrt(1 - z * z)
    return list(np.stack([r * np.cos(phi), r * np.sin(phi), z], -1))


def within(wo, alpha):
    mirror = np.array([-wo[0], -wo[1], wo[2]])
    x = np.array([1.0, 0, 0])
    y = np.cross(mirror, x)
    places = []
    for u, v in ((0, 0), (0.6, 0), (1.3, 0), (0, 0.6), (0, -0.6), (0, 1.3), (0, -1.3), (0.7, 0.7), (0.7, -0.7)):
        t, phi = 2 * np.arctan(alpha * np.hypot(u, v)), np.arctan2(v, u)
        d = np.cos(t) * mirror + np.sin(t) * (np.cos(phi) * x + np.sin(phi) * y)
        if d[2] > 0.02:
            places.append(d)
    return places


def cases():
    for alpha in ALPHAS:
        for cosine in COSINES:
            wo = np.array([0, -np.sqrt(1 - cosine * cosine), cosine])
            for weight, lamps in ((1.0, all_around()), (WITHIN, within(wo, alpha))):
                for lamp in lamps:
                    yield alpha, wo, lamp, weight * WEIGHTS.get(alpha, 1.0), reflected(wo, alpha, lamp)


CASES = list(cases())


def errors(coefficients):
    polynomials = coefficients.reshape(DEGREE + 1, 8)
    numbers = {a: np.sqrt(a) ** np.arange(DEGREE + 1) @ polynomials for a in ALPHAS}
    return np.array([w * (by_lobes(wo, a, lamp, numbers[a]) / truth - 1) for a, wo, lamp, w, truth in CASES])


def fit():
    c = np.array(START).ravel()
    r = errors(c)
    damping = 1e-3
    for _ in range(ITERATIONS):
        steps = 1e-3 * np.maximum(1, np.abs(c))
        jacobian = np.stack([(errors(c + s * np.eye(len(c))[k]) - r) / s for k, s in enumerate(steps)], -1)
        hessian, gradient = jacobian.T @ jacobian, jacobian.T @ r
        before = r @ r
        while damping < 1e6:
            new = c - np.linalg.solve(hessian + damping * np.diag(np.diag(hessian) + 1e-9), gradient)
            found = errors(new)
            if found @ found < before:
                c, r, damping = new, found, damping / 3
                break
            damping *= 4
        print(f"{np.mean(r * r):.3e}", flush=True)
        if before - r @ r < 2e-3 * before:
            break
    return c.reshape(DEGREE + 1, 8)


def main():
    polynomials = fit()
    for name, columns in (("kSlopes", slice(0, 4)), ("kWidths", slice(4, 8))):
        for row in polynomials[:, columns]:
            print(name, ", ".join(f"{number:.4f}" for number in row))


if __name__ == "__main__":
    main()
