// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace livegs::sample {

// Reproducible random numbers on all platforms. The standard specifies the generator but not its
// distributions, so both conversions are implemented here.
class Random {
 public:
  explicit Random(uint64_t seed) : bits_(seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull) {}

  // Returns a value in [0, 1) with 53 bits.
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  // Normal distribution with mean 0 and variance 1 (Box and Muller 1958). The second value of the pair is
  // discarded, so a call has no state.
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace livegs::sample
