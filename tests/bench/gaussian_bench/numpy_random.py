# SPDX-License-Identifier: Apache-2.0
"""Random numbers of numpy's default generator (PCG64, SeedSequence, ziggurat normals), for its published seeds.

The benchmark's generators draw positions and variants with numpy.random.default_rng(seed), so the same numbers are
needed here. Algorithms: O'Neill 2014 (PCG XSL-RR 128/64, seed_seq), Marsaglia and Tsang 2000 (ziggurat).
"""
import math

MASK_32 = (1 << 32) - 1
MASK_64 = (1 << 64) - 1
MASK_128 = (1 << 128) - 1
MULTIPLIER = 0x2360ED051FC65DA44385DF649FCCF645

LAYERS = 256
TAIL = 3.6541528853610087963519472518  # start of the tail
AREA = 0.0049286732339746519  # of one layer
MANTISSA = 2.0**52


def _seed_words(seed):
    """Four words of 64 bits for a seed below 2^128."""
    constant = 0x43B0D7E5

    def hashed(value):
        nonlocal constant
        value ^= constant
        constant = constant * 0x931E8875 & MASK_32
        value = value * constant & MASK_32
        return value ^ value >> 16

    def mixed(x, y):
        result = (0xCA01F9DD * x - 0x4973F715 * y) & MASK_32
        return result ^ result >> 16

    pool = [hashed(seed >> 32 * i & MASK_32) for i in range(4)]
    for source in range(4):
        for target in range(4):
            if source != target:
                pool[target] = mixed(pool[target], hashed(pool[source]))
    constant = 0x8B51F9DD
    words = []
    for i in range(8):
        value = pool[i % 4] ^ constant
        constant = constant * 0x58F38DED & MASK_32
        value = value * constant & MASK_32
        words.append(value ^ value >> 16)
    return [words[2 * i] | words[2 * i + 1] << 32 for i in range(4)]


def _layers():
    """Scales, thresholds and densities of the layers."""
    scale, threshold, density = [0.0] * LAYERS, [0] * LAYERS, [1.0] * LAYERS
    x = TAIL
    density[-1] = math.exp(-0.5 * x * x)
    scale[-1] = x / MANTISSA
    threshold[0] = int(x * density[-1] / AREA * MANTISSA)
    scale[0] = AREA / density[-1] / MANTISSA
    for i in range(LAYERS - 2, 0, -1):
        narrower = math.sqrt(-2.0 * math.log(AREA / x + density[i + 1]))
        threshold[i + 1] = int(narrower / x * MANTISSA)
        scale[i] = narrower / MANTISSA
        density[i] = math.exp(-0.5 * narrower * narrower)
        x = narrower
    return scale, threshold, density


class Generator:
    def __init__(self, seed):
        words = _seed_words(seed)
        self._increment = ((words[2] << 64 | words[3]) << 1 | 1) & MASK_128
        self._state = (self._increment + (words[0] << 64 | words[1])) & MASK_128
        self._step()
        self._scale, self._threshold, self._density = _layers()

    def _step(self):
        self._state = (self._state * MULTIPLIER + self._increment) & MASK_128

    def bits_64(self):
        self._step()
        folded = (self._state >> 64 ^ self._state) & MASK_64
        turn = self._state >> 122
        return (folded >> turn | folded << (64 - turn)) & MASK_64

    def unit(self):
        """Uniform in 0 to 1."""
        return (self.bits_64() >> 11) * 2.0**-53

    def uniform(self, low, high):
        return low + (high - low) * self.unit()

    def normal(self, scale):
        """Normal about 0 with the standard deviation `scale`."""
        return 0.0 + scale * self._standard_normal()

    def _standard_normal(self):
        while True:
            bits = self.bits_64()
            layer = bits & 0xFF
            bits >>= 8
            magnitude = bits >> 1 & 0x000FFFFFFFFFFFFF
            x = magnitude * self._scale[layer]
            if bits & 1:
                x = -x
            if magnitude < self._threshold[layer]:
                return x
            if layer == 0:
                while True:
                    beyond = -math.log1p(-self.unit()) / TAIL
                    height = -math.log1p(-self.unit())
                    if height + height > beyond * beyond:
                        return -(TAIL + beyond) if magnitude >> 8 & 1 else TAIL + beyond
            above, here = self._density[layer - 1], self._density[layer]
            if (above - here) * self.unit() + here < math.exp(-0.5 * x * x):
                return x
