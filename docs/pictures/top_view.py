#!/usr/bin/env python3
"""Draws the map.ply of a result from above, one colour a sensor. Standard library only.

Usage: docs/pictures/top_view.py RESULT/map.ply OUT.png [--half-width M] [--low M --high M] [--size PX]
Points between --low and --high (height in the world frame) are drawn; x points up, y to the left.
"""
import argparse
import struct
import zlib

COLOURS = [(235, 235, 235), (242, 142, 43), (78, 190, 160), (105, 150, 230), (225, 87, 120), (190, 160, 90)]


def read_ply(path):
    """Yields (x, y, z, sensor) of a binary little-endian PLY with the properties that rigcal writes."""
    sizes = {"float": ("f", 4), "uchar": ("B", 1), "double": ("d", 8), "ushort": ("H", 2), "int": ("i", 4)}
    with open(path, "rb") as file:
        count, names, layout = 0, [], "<"
        while True:
            words = file.readline().decode("ascii").split()
            if words[:2] == ["element", "vertex"]:
                count = int(words[2])
            elif words[:1] == ["property"]:
                layout += sizes[words[1]][0]
                names.append(words[2])
            elif words == ["end_header"]:
                break
        at = [names.index(name) for name in ("x", "y", "z", "sensor")]
        record = struct.Struct(layout)
        while count > 0:
            block = min(count, 65536)
            for values in record.iter_unpack(file.read(block * record.size)):
                yield values[at[0]], values[at[1]], values[at[2]], values[at[3]]
            count -= block


def write_png(path, size, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    body = zlib.compress(b"".join(b"\0" + bytes(row) for row in rows), 9)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)))
        file.write(chunk(b"IDAT", body) + chunk(b"IEND", b""))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ply")
    parser.add_argument("png")
    parser.add_argument("--half-width", type=float, default=24.0)
    parser.add_argument("--low", type=float, default=-0.6)
    parser.add_argument("--high", type=float, default=2.5)
    parser.add_argument("--size", type=int, default=900)
    options = parser.parse_args()
    size, scale = options.size, options.size / (2.0 * options.half_width)
    hits = [[0, 0.0, 0.0, 0.0] for _ in range(size * size)]
    for x, y, z, sensor in read_ply(options.ply):
        if not options.low < z < options.high:
            continue
        column = int(size / 2 - y * scale)
        row = int(size / 2 - x * scale)
        if 0 <= column < size and 0 <= row < size:
            pixel = hits[row * size + column]
            colour = COLOURS[sensor % len(COLOURS)]
            pixel[0] += 1
            for k in range(3):
                pixel[k + 1] += colour[k]
    rows = []
    for row in range(size):
        line = bytearray()
        for n, *sums in hits[row * size : (row + 1) * size]:
            # Walls gather many points in a pixel; single hits are faint.
            light = 0.0 if n == 0 else min(1.0, 0.25 + 0.09 * n)
            line += bytes(int(18 + light * (s / n - 18)) if n else 18 for s in sums)
        rows.append(line)
    write_png(options.png, size, rows)


if __name__ == "__main__":
    main()
