#!/usr/bin/env python3
"""make_blue_noise.py : writes src/pass/blue_noise.cpp, a 64 x 64 tile of blue-noise ranks. Needs numpy.

Void-and-cluster: Ulichney 1993, The void-and-cluster method for dither array generation. Thresholding the ranks at any
level leaves points that keep their distance, also across the tile's edges. The same file comes out each time, anywhere:
energies are integers, so that no order of summation shows, and of Python's generator only random() is used, whose
sequence is promised not to change.
"""
import pathlib
import random

import numpy as np

SIZE = 64
SEED = 1993
SIGMA = 1.5  # pixels; Ulichney's value
INITIAL_ONES = SIZE * SIZE // 10  # his "no more than half"; a tenth settles sooner
FIXED_POINT = 1 << 40  # energies are sums of at most 4096 kernels of 2^40: far inside 64 bits


def gaussian_kernel():
    """How strongly a point at (0, 0) is felt at each pixel of the torus, in fixed point."""
    distance = np.minimum(np.arange(SIZE), SIZE - np.arange(SIZE))
    falloff = np.exp(-(distance**2) / (2.0 * SIGMA**2))
    return np.rint(np.outer(falloff, falloff) * FIXED_POINT).astype(np.int64)


class Points:
    """A binary pattern on the torus, with the energy that its ones spread over all pixels."""

    def __init__(self, kernel):
        self.kernel = kernel
        self.ones = np.zeros((SIZE, SIZE), dtype=bool)
        self.energy = np.zeros((SIZE, SIZE), dtype=np.int64)

    def set(self, pixel, one):
        self.ones[pixel] = one
        self.energy += (1 if one else -1) * np.roll(self.kernel, pixel, axis=(0, 1))

    def tightest_cluster(self):
        return self.pixel(np.argmax(np.where(self.ones, self.energy, -1)))

    def largest_void(self):
        return self.pixel(np.argmin(np.where(self.ones, np.iinfo(np.int64).max, self.energy)))

    @staticmethod
    def pixel(flat):
        return divmod(int(flat), SIZE)


def initial_points(kernel):
    """Scattered ones, moved from tightest cluster to largest void until that changes nothing."""
    points = Points(kernel)
    generator = random.Random(SEED)
    shuffled = sorted(range(SIZE * SIZE), key=lambda _: generator.random())
    for flat in shuffled[:INITIAL_ONES]:
        points.set(Points.pixel(flat), True)
    while True:
        cluster = points.tightest_cluster()
        points.set(cluster, False)
        void = points.largest_void()
        points.set(void, True)
        if void == cluster:
            return points


def blue_noise_ranks():
    kernel = gaussian_kernel()
    ranks = np.full((SIZE, SIZE), -1)

    # Phase I: the initial ones, last rank first.
    points = initial_points(kernel)
    initial = points.ones.copy()
    for rank in range(INITIAL_ONES - 1, -1, -1):
        cluster = points.tightest_cluster()
        points.set(cluster, False)
        ranks[cluster] = rank

    # Phases II and III: the voids in turn. Ulichney's phase III, past the half, looks for the tightest cluster of zeros;
    # the kernel's sum is the same everywhere, so that is the zero with the least energy of ones: the largest void again.
    for flat in np.flatnonzero(initial):
        points.set(Points.pixel(flat), True)
    for rank in range(INITIAL_ONES, SIZE * SIZE):
        void = points.largest_void()
        points.set(void, True)
        ranks[void] = rank

    assert np.array_equal(np.sort(ranks, axis=None), np.arange(SIZE * SIZE))
    return ranks


HEADER = f"""\
// Made by scripts/make_blue_noise.py; change that, not this. Void-and-cluster (Ulichney 1993) on a
// torus of {SIZE} x {SIZE} pixels, sigma {SIGMA} pixels, seed {SEED}.

#include "pass/blue_noise.h"

namespace fumarole::pass {{

// clang-format off
const std::array<std::uint16_t, kBlueNoiseSize * kBlueNoiseSize> kBlueNoise = {{
"""

FOOTER = """\
};
// clang-format on

}  // namespace fumarole::pass
"""


def main():
    ranks = blue_noise_ranks().ravel()
    lines = ["    " + ", ".join(f"{rank:4d}" for rank in row) + ",\n" for row in ranks.reshape(-1, 16)]
    target = pathlib.Path(__file__).resolve().parent.parent / "src" / "pass" / "blue_noise.cpp"
    target.write_text(HEADER + "".join(lines) + FOOTER)
    print(f"wrote {target}")


if __name__ == "__main__":
    main()
