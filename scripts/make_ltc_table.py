#!/usr/bin/env python3
"""make_ltc_table.py : writes src/surface/ltc_table.cpp, by which area lights are seen in glossy surfaces. Needs numpy.

Linearly transformed cosines: Heitz, Dupuy, Hill and Neubelt 2016, Real-Time Polygonal-Light Shading with Linearly
Transformed Cosines. For each roughness and each cosine to the eye, the matrix M is fitted that turns a clamped cosine into
D V n.wi (docs/methods.md, Surfaces) over its integral, by the simplex method of Nelder and Mead 1965 on the third power of
the difference, as they have it. Kept of its inverse are the four elements that matter, the lower row over alpha, which
is what it falls with; and a and b, the directional albedos of D V (1 - Fresnel's fifth power) and of the rest.

Rows are roughness 0..1, columns sqrt(1 - sqrt(n.wo)) 0..1. The same file comes out each time: no random number is drawn.
"""
import pathlib

import numpy as np

ROWS, COLUMNS = 32, 48  # LTC_ROWS and LTC_COLUMNS of glsl/shared/bindings.h
MIN_ALPHA = 0.002  # kMinAlpha of glsl/lib/ggx.glsl
LEAST_COSINE = 1e-3  # of the last column, where D V has no integral of its own at 0
SAMPLES = 32  # along both edges of each of the two sets that a difference is summed over
ALBEDO_SAMPLES = 256


def grid(count):
    u = (np.arange(count) + 0.5) / count
    return (a.ravel() for a in np.meshgrid(u, u, indexing="ij"))


U1, U2 = grid(SAMPLES)


def brdf_cos(wi, wo, alpha):
    """D V n.wi of directions wi, 3 x N."""
    h = wi + wo[:, None]
    h /= np.linalg.norm(h, axis=0)
    a2 = alpha * alpha
    sine2 = h[0] ** 2 + h[1] ** 2
    d = a2 / (np.pi * (sine2 + a2 * h[2] ** 2) ** 2)
    n_wi, n_wo = np.maximum(wi[2], 0.0), wo[2]
    v = 0.5 / (n_wi * np.sqrt(a2 + (1 - a2) * n_wo**2) + n_wo * np.sqrt(a2 + (1 - a2) * n_wi**2) + 1e-300)
    return d * v * n_wi


def half_vectors(u1, u2, wo, alpha):
    """Spread as the normals that wo sees, D max(wo.h, 0) over its integral: Heitz 2018, Sampling the GGX Distribution of
    Visible Normals."""
    v = wo * np.array([alpha, alpha, 1])
    v /= np.linalg.norm(v)
    x = np.array([-v[1], v[0], 0]) / np.hypot(v[0], v[1]) if v[2] < 1 else np.array([1.0, 0, 0])
    y = np.cross(v, x)
    r, phi = np.sqrt(u1), 2 * np.pi * u2
    p1, p2 = r * np.cos(phi), r * np.sin(phi)
    s = 0.5 * (1 + v[2])
    p2 = (1 - s) * np.sqrt(1 - p1**2) + s * p2
    n = np.outer(x, p1) + np.outer(y, p2) + np.outer(v, np.sqrt(np.maximum(1 - p1**2 - p2**2, 0)))
    h = n * np.array([[alpha], [alpha], [1]])
    return h / np.linalg.norm(h, axis=0)


def lobe(u1, u2, wo, alpha):
    """Directions spread so that D V n.wi over their density is no more than 1, and their density."""
    h = half_vectors(u1, u2, wo, alpha)
    wi = 2 * (wo @ h) * h - wo[:, None]
    return wi, lobe_density(wi, wo, alpha)


def lobe_density(wi, wo, alpha):
    h = wi + wo[:, None]
    h /= np.linalg.norm(h, axis=0)
    a2 = alpha * alpha
    d = a2 / (np.pi * (h[0] ** 2 + h[1] ** 2 + a2 * h[2] ** 2) ** 2)
    seen = np.where(wo @ h > 0, 2 * wo[2] / (wo[2] + np.sqrt(a2 + (1 - a2) * wo[2] ** 2)), 0.0)
    return d * seen / (4 * wo[2])


def moments(wo, alpha):
    """a, b and the mean direction of D V n.wi."""
    u1, u2 = grid(ALBEDO_SAMPLES)
    wi, density = lobe(u1, u2, wo, alpha)
    h = wi + wo[:, None]
    h /= np.linalg.norm(h, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where((wi[2] > 0) & (wo @ h > 0), brdf_cos(wi, wo, alpha) / density, 0.0) / len(u1)
    fresnel = (1 - np.clip(wo @ h, 0, 1)) ** 5
    mean = wi @ weight
    mean[1] = 0
    return np.sum(weight * (1 - fresnel)), np.sum(weight * fresnel), mean / np.linalg.norm(mean)


class Cosine:
    """A clamped cosine turned by M = frame [[m11, 0, m13], [0, m22, 0], [0, 0, 1]]."""

    def __init__(self, frame, m11, m22, m13):
        self.m = frame @ np.array([[m11, 0, m13], [0, m22, 0], [0, 0, 1]])
        self.inverse = np.linalg.inv(self.m)
        self.det = abs(np.linalg.det(self.m))

    def density(self, wi):
        w = self.inverse @ wi
        length = np.linalg.norm(w, axis=0)
        return np.maximum(w[2], 0) / (np.pi * length**4 * self.det)

    def sample(self, u1, u2):
        sine, phi = np.sqrt(u1), 2 * np.pi * u2
        w = self.m @ np.array([sine * np.cos(phi), sine * np.sin(phi), np.sqrt(1 - u1)])
        return w / np.linalg.norm(w, axis=0)


def difference(cosine, wo, alpha, norm, of_lobe):
    wi_lobe, density_lobe, target_lobe = of_lobe
    wi = cosine.sample(U1, U2)
    total = 0.0
    for w, by_lobe, target in ((wi_lobe, density_lobe, target_lobe),
                               (wi, lobe_density(wi, wo, alpha), brdf_cos(wi, wo, alpha) / norm)):
        by_cosine = cosine.density(w)
        total += np.sum(np.abs(target - by_cosine) ** 3 / (by_lobe + by_cosine))
    return total / len(U1)


def nelder_mead(f, start, size, evaluations=400, tolerance=1e-7):
    n = len(start)
    points = [np.array(start, float)] + [np.array(start, float) + size * np.eye(n)[i] for i in range(n)]
    values = [f(p) for p in points]
    count = n + 1
    while count < evaluations:
        order = np.argsort(values, kind="stable")
        points, values = [points[i] for i in order], [values[i] for i in order]
        if abs(values[-1] - values[0]) <= tolerance * (abs(values[0]) + abs(values[-1])):
            break
        middle = np.mean(points[:-1], axis=0)

        def at(t):
            return middle + t * (points[-1] - middle)

        p = at(-1.0)
        v = f(p)
        count += 1
        if v < values[0]:
            q = at(-2.0)
            w = f(q)
            count += 1
            points[-1], values[-1] = (q, w) if w < v else (p, v)
        elif v < values[-2]:
            points[-1], values[-1] = p, v
        else:
            q = at(-0.5) if v < values[-1] else at(0.5)
            w = f(q)
            count += 1
            if w < min(v, values[-1]):
                points[-1], values[-1] = q, w
            else:
                for i in range(1, n + 1):
                    points[i] = 0.5 * (points[0] + points[i])
                    values[i] = f(points[i])
                count += n
    return points[int(np.argmin(values))]


def fit(roughness, column, start):
    """The row of the table, and what the next column starts from."""
    alpha = max(roughness**2, MIN_ALPHA)
    n_wo = max((1 - (column / (COLUMNS - 1)) ** 2) ** 2, LEAST_COSINE)
    wo = np.array([np.sqrt(1 - n_wo**2), 0, n_wo])
    a, b, mean = moments(wo, alpha)
    wi, density = lobe(U1, U2, wo, alpha)
    of_lobe = (wi, density, brdf_cos(wi, wo, alpha) / (a + b))
    if column == 0:  # the same all around
        frame = np.eye(3)

        def cosine_of(p):
            s = max(p[0], 1e-7)
            return Cosine(frame, s, s, 0)

        best = nelder_mead(lambda p: difference(cosine_of(p), wo, alpha, a + b, of_lobe), start[:1], 0.05 * alpha)
        best = np.array([best[0], best[0], 0.0])
        cosine = cosine_of(best)
    else:
        frame = np.array([[mean[2], 0, mean[0]], [0, 1, 0], [-mean[0], 0, mean[2]]])

        def cosine_of(p):
            return Cosine(frame, max(p[0], 1e-7), max(p[1], 1e-7), p[2])

        best = nelder_mead(lambda p: difference(cosine_of(p), wo, alpha, a + b, of_lobe), start, 0.05 * min(1, alpha * 5))
        cosine = cosine_of(best)
    inverse = cosine.inverse / cosine.inverse[1, 1]
    return (inverse[0, 0], inverse[0, 2], inverse[2, 0] / alpha, inverse[2, 2] / alpha, a, b), best


def table():
    rows = [None] * ROWS
    scale = 1.0  # of M over alpha, looked straight down on, in the row before
    for r in reversed(range(ROWS)):
        roughness = r / (ROWS - 1)
        alpha = max(roughness**2, MIN_ALPHA)
        start = np.array([scale * alpha, scale * alpha, 0])
        rows[r] = []
        for column in range(COLUMNS):
            entry, start = fit(roughness, column, start)
            if column == 0:
                scale = start[0] / alpha
            rows[r].append(entry)
    return rows


HEAD = """// Made by scripts/make_ltc_table.py; change that, not this.

#include "surface/ltc_table.h"

#include <vector>

namespace fumarole::surface {

// clang-format off
const std::array<LtcEntry, LTC_ROWS * LTC_COLUMNS> kLtcTable = {{
"""

TAIL = """}};
// clang-format on

gl::Texture make_ltc_texture(const gl::Device& device)
{
    gl::Texture texture =
        gl::Texture::make_2d_array(device, "linearly transformed cosines",
                                   {LTC_COLUMNS, LTC_ROWS, 2}, GL_RGBA32F, gl::Filter::linear);
    std::vector<glm::vec4> texels;
    for (const LtcEntry& e : kLtcTable)
        texels.emplace_back(e.xx, e.xz, e.zx, e.zz);
    for (const LtcEntry& e : kLtcTable)
        texels.emplace_back(e.a, e.b, 0, 0);
    texture.upload(GL_RGBA, GL_FLOAT, texels.data());
    return texture;
}

}  // namespace fumarole::surface
"""


def number(value):
    text = f"{value:.5g}"
    return (text if "." in text or "e" in text else text + ".0") + "f"


def main():
    lines = []
    for row in table():
        entries = ["{" + ", ".join(number(v) for v in e) + "}" for e in row]
        lines += ["    " + ", ".join(entries[i : i + 2]) + "," for i in range(0, COLUMNS, 2)]
    root = pathlib.Path(__file__).resolve().parent.parent
    (root / "src" / "surface" / "ltc_table.cpp").write_text(HEAD + "\n".join(lines) + "\n" + TAIL)


if __name__ == "__main__":
    main()
