// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace livegs {

// The number at the nearest rank, without interpolation: of n sorted numbers the one at index round(share (n
// - 1)), halves up. 0 is the smallest, 1 the largest, 0.5 of an even count the upper one of the middle two. 0
// for no numbers.
template <class Number>
Number percentile(std::vector<Number> numbers, double share) {
  if (numbers.empty()) return Number{};
  const auto rank = numbers.begin() +
                    static_cast<std::ptrdiff_t>(std::lround(share * static_cast<double>(numbers.size() - 1)));
  std::nth_element(numbers.begin(), rank, numbers.end());
  return *rank;
}

// The median of statistics: of an even count the mean of the middle two. Precondition: there are numbers.
inline double median(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return 0.5 * (numbers[(numbers.size() - 1) / 2] + numbers[numbers.size() / 2]);
}

}  // namespace livegs
