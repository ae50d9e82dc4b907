#!/usr/bin/env python3
"""Makes spark.png: a soft glow with an alpha, for the billboards of smoke_glass.json."""
import struct
import zlib

SIZE = 64


def row(y):
    texels = bytearray([0])
    for x in range(SIZE):
        u, v = ((x + 0.5) / SIZE * 2 - 1), ((y + 0.5) / SIZE * 2 - 1)
        d = min(1.0, (u * u + v * v) ** 0.5)
        glow = (1 - d) ** 2
        heat = min(1.0, 1.6 * glow + 0.2)
        texels += bytes([255, round(255 * heat), round(255 * heat * heat * 0.8), round(255 * glow)])
    return bytes(texels)


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


with open("spark.png", "wb") as f:
    f.write(b"\x89PNG\r\n\x1a\n")
    f.write(chunk(b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 6, 0, 0, 0)))
    f.write(chunk(b"IDAT", zlib.compress(b"".join(row(y) for y in range(SIZE)), 9)))
    f.write(chunk(b"IEND", b""))
