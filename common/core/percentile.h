// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace livegs {

// The nearest-rank value, without interpolation: index round(share (n - 1)) of the n sorted numbers, halves
// rounded up. A share of 0 is the smallest, 1 the largest. A share of 0.5 of an even count is the upper
// middle value. Returns 0 for an empty list.
template <class Number>
Number percentile(std::vector<Number> numbers, double share) {
  if (numbers.empty()) return Number{};
  const auto rank = numbers.begin() +
                    static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(numbers.size() - 1)));
  std::nth_element(numbers.begin(), rank, numbers.end());
  return *rank;
}

// The statistical median: the mean of the two middle values for an even count. Precondition: not empty.
inline double median(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return 0.5 * (numbers[(numbers.size() - 1) / 2] + numbers[numbers.size() / 2]);
}

}  // namespace livegs
