# SPDX-License-Identifier: Apache-2.0
"""Comparison of two PNG pictures of 8 bits per channel."""
import math
import struct
import zlib

from runs import Failure


def read_png(path):
    """Width, height, channels and bytes, row by row."""
    data = path.read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise Failure(f"{path.name}: not a PNG file; render it again")
    place, packed = 8, b""
    width = height = channels = 0
    while place < len(data):
        size, kind = struct.unpack(">I4s", data[place : place + 8])
        chunk = data[place + 8 : place + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", chunk[:10])
            if depth != 8 or colour not in (2, 6) or chunk[12]:
                raise Failure(f"{path.name}: not 8-bit RGB; render it again")
            channels = 3 if colour == 2 else 4
        elif kind == b"IDAT":
            packed += chunk
        place += size + 12
    raw, stride = zlib.decompress(packed), width * channels
    rows, above = [], bytearray(stride)
    for y in range(height):
        kind = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left = row[i - channels] if i >= channels else 0
            up = above[i]
            corner = above[i - channels] if i >= channels else 0
            if kind == 1:
                guess = left
            elif kind == 2:
                guess = up
            elif kind == 3:
                guess = (left + up) // 2
            else:
                plane = left + up - corner
                guess = min((left, up, corner), key=lambda v: abs(plane - v))
            row[i] = row[i] + guess & 0xFF
        rows.append(row)
        above = row
    return width, height, channels, rows


def colours(picture):
    _, _, channels, rows = picture
    return [v for row in rows for i, v in enumerate(row) if i % channels < 3]


def psnr_db(first, second):
    one, two = colours(first), colours(second)
    mean = sum((a - b) ** 2 for a, b in zip(one, two)) / len(one)
    return math.inf if mean == 0 else 10.0 * math.log10(255.0**2 / mean)


def luminance(picture):
    width, _, channels, rows = picture
    return [
        [0.299 * r[channels * x] + 0.587 * r[channels * x + 1] + 0.114 * r[channels * x + 2] for x in range(width)]
        for r in rows
    ]


def _blurred_rows(rows, weights):
    reach = len(weights) // 2
    result = []
    for row in rows:
        count = len(row)
        padded = row[:reach][::-1] + row + row[count - reach :][::-1]  # mirrored at the edge
        sums = [0.0] * count
        for k, weight in enumerate(weights):
            sums = [s + weight * v for s, v in zip(sums, padded[k : k + count])]
        result.append(sums)
    return result


def blurred(rows, sigma):
    """Gaussian blur, cut at four sigma."""
    reach = int(4.0 * sigma + 0.5)
    weights = [math.exp(-0.5 * (k / sigma) ** 2) for k in range(-reach, reach + 1)]
    weights = [w / sum(weights) for w in weights]
    across = _blurred_rows(rows, weights)
    down = _blurred_rows([list(column) for column in zip(*across)], weights)
    return [list(column) for column in zip(*down)]


def ssim(first, second):
    """Mean structural similarity of the luminance (Wang et al. 2004): sigma 1.5, K1 0.01, K2 0.03, range 255."""
    x, y = luminance(first), luminance(second)
    c1, c2 = (0.01 * 255.0) ** 2, (0.03 * 255.0) ** 2

    def product(a, b):
        return [[p * q for p, q in zip(r, s)] for r, s in zip(a, b)]

    means_x, means_y = blurred(x, 1.5), blurred(y, 1.5)
    squares = [blurred(product(a, b), 1.5) for a, b in ((x, x), (y, y), (x, y))]
    total = count = 0
    for mx, my, xx, yy, xy in zip(means_x, means_y, *squares):
        for a, b, p, q, r in zip(mx, my, xx, yy, xy):
            top = (2.0 * a * b + c1) * (2.0 * (r - a * b) + c2)
            total += top / ((a * a + b * b + c1) * (p - a * a + q - b * b + c2))
            count += 1
    return total / count
