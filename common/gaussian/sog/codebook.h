// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace livegs {

// A table of 256 values that stands for a set of numbers, ascending. No number is farther than a 128th of
// the whole range from its entry; where many numbers are, entries are denser.
class Codebook {
 public:
  // Precondition: not empty, finite.
  explicit Codebook(std::vector<float> values);

  const std::array<float, 256>& entries() const { return entries_; }
  uint8_t nearest(float value) const;

 private:
  std::array<float, 256> entries_;
};

// Divides rows of `width` numbers into at most `max_entries` groups of similar rows: the group with the
// largest squared error is cut at the mean of its widest number, until there are enough (median cut, Heckert
// 1982). Returns the group of each row. The order of groups depends only on the rows.
std::vector<uint32_t> cut_into_groups(const std::vector<float>& rows, size_t width, size_t max_entries);

}  // namespace livegs
