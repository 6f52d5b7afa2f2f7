# SPDX-License-Identifier: Apache-2.0
"""Small matrices (nine numbers row by row), spectra and percentiles."""
import cmath
import math


def times(a, b):
    return [sum(a[3 * i + k] * b[3 * k + j] for k in range(3)) for i in range(3) for j in range(3)]


def transposed(a):
    return [a[3 * j + i] for i in range(3) for j in range(3)]


def norm(a):
    return math.sqrt(math.fsum(v * v for v in a))


def minus(a, b):
    return [x - y for x, y in zip(a, b)]


def determinant(a):
    return (
        a[0] * (a[4] * a[8] - a[5] * a[7])
        - a[1] * (a[3] * a[8] - a[5] * a[6])
        + a[2] * (a[3] * a[7] - a[4] * a[6])
    )


def inverse(a):
    scale = 1.0 / determinant(a)
    return [
        scale * (a[4] * a[8] - a[5] * a[7]),
        scale * (a[2] * a[7] - a[1] * a[8]),
        scale * (a[1] * a[5] - a[2] * a[4]),
        scale * (a[5] * a[6] - a[3] * a[8]),
        scale * (a[0] * a[8] - a[2] * a[6]),
        scale * (a[2] * a[3] - a[0] * a[5]),
        scale * (a[3] * a[7] - a[4] * a[6]),
        scale * (a[1] * a[6] - a[0] * a[7]),
        scale * (a[0] * a[4] - a[1] * a[3]),
    ]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def pushed_forward(gradient, covariance):
    """F Sigma F^T."""
    return times(times(gradient, covariance), transposed(gradient))


def symmetric(six):
    xx, xy, xz, yy, yz, zz = six
    return [xx, xy, xz, xy, yy, yz, xz, yz, zz]


def eigenvalues(a):
    """Of a symmetric matrix, ascending (Smith 1961)."""
    mean = (a[0] + a[4] + a[8]) / 3.0
    apart = minus(a, [mean, 0, 0, 0, mean, 0, 0, 0, mean])
    spread = norm(apart) / math.sqrt(6.0)
    if spread <= 1e-15 * abs(mean):
        return [mean] * 3
    half = determinant([v / spread for v in apart]) / 2.0
    angle = math.acos(max(-1.0, min(1.0, half))) / 3.0
    most = mean + 2.0 * spread * math.cos(angle)
    least = mean + 2.0 * spread * math.cos(angle + 2.0 * math.pi / 3.0)
    return [least, 3.0 * mean - most - least, most]


def fitted_gradient(rest, now):
    """F that maps the differences `rest` to `now` with the least squares."""
    outer, inner = [0.0] * 9, [0.0] * 9
    for before, after in zip(rest, now):
        for i in range(3):
            for j in range(3):
                outer[3 * i + j] += after[i] * before[j]
                inner[3 * i + j] += before[i] * before[j]
    return times(outer, inverse(inner))


def percentile(values, part):
    """Linear between the two nearest ranks."""
    ranked = sorted(values)
    place = part * (len(ranked) - 1)
    low = int(place)
    high = min(low + 1, len(ranked) - 1)
    return ranked[low] + (ranked[high] - ranked[low]) * (place - low)


def median(values):
    return percentile(values, 0.5)


def line_fit(xs, ys):
    """Slope and value at 0 of the straight line of least squares."""
    x_mean, y_mean = math.fsum(xs) / len(xs), math.fsum(ys) / len(ys)
    over = math.fsum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys))
    slope = over / math.fsum((x - x_mean) ** 2 for x in xs)
    return slope, y_mean - slope * x_mean


def spectrum(signal):
    """Discrete Fourier transform; the length is a power of two."""
    count = len(signal)
    if count == 1:
        return [complex(signal[0])]
    even, odd = spectrum(signal[::2]), spectrum(signal[1::2])
    turned = [cmath.exp(-2j * math.pi * k / count) * odd[k] for k in range(count // 2)]
    return [a + b for a, b in zip(even, turned)] + [a - b for a, b in zip(even, turned)]


def dominant_frequency_hz(signal, rate_hz):
    """Highest peak of the spectrum with a Hann window and eightfold padding; a parabola through the logarithms."""
    count = len(signal)
    window = [0.5 - 0.5 * math.cos(2.0 * math.pi * i / (count - 1)) for i in range(count)]
    padded = 8 << math.ceil(math.log2(count))
    values = [v * w for v, w in zip(signal, window)] + [0.0] * (padded - count)
    sizes = [abs(v) for v in spectrum(values)[: padded // 2 + 1]]
    peak = max(range(1, len(sizes)), key=sizes.__getitem__)
    shift = 0.0
    if peak < len(sizes) - 1 and min(sizes[peak - 1 : peak + 2]) > 0.0:
        low, here, high = (math.log(v) for v in sizes[peak - 1 : peak + 2])
        bend = low - 2.0 * here + high
        if bend:
            shift = max(-0.5, min(0.5, 0.5 * (low - high) / bend))
    return (peak + shift) * rate_hz / padded
