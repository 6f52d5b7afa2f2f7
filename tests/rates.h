// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

// The size of the test sets. The gate uses one tick rate and few seeds; `deploy/test nightly` sets both
// variables.

namespace livegs {

// Tick rates in Hz from LIVEGS_TEST_RATES, for example "60,90"; default 90. For parameterised tests, which
// are created before main.
inline std::vector<double> rates_hz() {
  const char* text = std::getenv("LIVEGS_TEST_RATES");
  std::vector<double> rates;
  while (text && *text) {
    char* end = nullptr;
    const double rate = std::strtod(text, &end);
    if (end == text || rate <= 0.0) std::abort();  // not a list of rates
    rates.push_back(rate);
    text = *end == ',' ? end + 1 : end;
  }
  return rates.empty() ? std::vector<double>{90.0} : rates;
}
// The same, for test bodies.
inline const std::vector<double> kRates_hz = rates_hz();

// Multiplier of seeds and repetitions from LIVEGS_TEST_SEEDS: 1 by default, 10 nightly.
inline int seeds_factor() {
  const char* text = std::getenv("LIVEGS_TEST_SEEDS");
  return text ? std::max(1, std::atoi(text)) : 1;
}
// Number of seeds of a test that uses `gate` seeds in the gate.
inline int seed_count(int gate) { return gate * seeds_factor(); }

// True if the nightly run uses the full set of settings instead of the gate's part.
inline bool full_sets() { return seeds_factor() > 1; }
template <typename T>
std::vector<T> gate_or_full(std::vector<T> gate, std::vector<T> full) {
  return full_sets() ? std::move(full) : std::move(gate);
}

// Name of a parameterised test by its rate: "90Hz".
inline std::string rate_name(double rate_hz) {
  return std::to_string(static_cast<int>(rate_hz + 0.5)) + "Hz";
}

}  // namespace livegs
