// SPDX-License-Identifier: Apache-2.0
#include "gaussian/sog/codebook.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <span>

namespace livegs {

// Entry k is the mean of the numbers whose place is in [k, k + 1) / 256. The place of a number is the middle
// of its rank among all numbers and its position in the range: the second half bounds the error, the first
// makes it small where the numbers are.
Codebook::Codebook(std::vector<float> values) {
  std::sort(values.begin(), values.end());
  const double low = values.front(), range = static_cast<double>(values.back()) - low;
  std::array<double, 256> sums{};
  std::array<size_t, 256> counts{};
  for (size_t i = 0; i < values.size(); ++i) {
    const double rank = (static_cast<double>(i) + 0.5) / static_cast<double>(values.size());
    const double share = range > 0 ? (static_cast<double>(values[i]) - low) / range : 0.5;
    const auto cell = std::min<size_t>(static_cast<size_t>(128 * (rank + share)), 255);
    sums[cell] += values[i];
    ++counts[cell];
  }
  float before = values.front();
  for (size_t k = 0; k < 256; ++k) {
    if (counts[k] > 0) before = static_cast<float>(sums[k] / static_cast<double>(counts[k]));
    entries_[k] = before;  // an empty cell repeats the entry before it
  }
}

uint8_t Codebook::nearest(float value) const {
  const auto above = std::lower_bound(entries_.begin(), entries_.end(), value);
  if (above == entries_.begin()) return 0;
  if (above == entries_.end()) return 255;
  const auto k = static_cast<uint8_t>(above - entries_.begin());
  return *above - value < value - entries_[k - 1u] ? k : static_cast<uint8_t>(k - 1);
}

std::vector<uint32_t> cut_into_groups(const std::vector<float>& rows, size_t width, size_t max_entries) {
  const size_t count = rows.size() / width;
  std::vector<uint32_t> order(count), group_of(count);
  std::iota(order.begin(), order.end(), 0u);
  if (count <= max_entries) return order;  // each row is its own group

  struct Group {
    double error = 0;  // squared, of the widest number
    double mean = 0;   // of it
    size_t begin = 0, end = 0, widest = 0;
    bool operator<(const Group& other) const {
      return error != other.error ? error < other.error : begin > other.begin;
    }
  };
  const auto measured = [&](size_t begin, size_t end) {
    Group group{0, 0, begin, end, 0};
    std::vector<double> sums(width, 0), squares(width, 0);
    for (size_t i = begin; i < end; ++i) {
      const float* row = &rows[order[i] * width];
      for (size_t k = 0; k < width; ++k) {
        sums[k] += static_cast<double>(row[k]);
        squares[k] += static_cast<double>(row[k]) * static_cast<double>(row[k]);
      }
    }
    const auto size = static_cast<double>(end - begin);
    for (size_t k = 0; k < width; ++k) {
      const double error = squares[k] - sums[k] * sums[k] / size;
      if (error > group.error) group.error = error, group.mean = sums[k] / size, group.widest = k;
    }
    return group;
  };
  std::priority_queue<Group> open;
  open.push(measured(0, count));
  std::vector<Group> done;
  while (!open.empty() && open.size() + done.size() < max_entries) {
    const Group group = open.top();
    open.pop();
    const auto begin = order.begin() + static_cast<ptrdiff_t>(group.begin),
               end = order.begin() + static_cast<ptrdiff_t>(group.end);
    const auto middle = std::stable_partition(begin, end, [&](uint32_t i) {
      return static_cast<double>(rows[i * width + group.widest]) < group.mean;
    });
    if (!(group.error > 0) || middle == begin || middle == end) {
      done.push_back(group);  // equal rows
      continue;
    }
    const auto cut = static_cast<size_t>(middle - order.begin());
    open.push(measured(group.begin, cut));
    open.push(measured(cut, group.end));
  }
  for (; !open.empty(); open.pop()) done.push_back(open.top());
  for (uint32_t g = 0; g < done.size(); ++g) {
    for (size_t i = done[g].begin; i < done[g].end; ++i) group_of[order[i]] = g;
  }
  return group_of;
}

}  // namespace livegs
