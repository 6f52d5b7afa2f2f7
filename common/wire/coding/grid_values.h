// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace livegs {

// The integers of one object. Filled once by their creator, then shared. Copies of large arrays share memory;
// small arrays (a single body has seven integers) are copied, because an allocation would cost more.
class GridValues {
 public:
  GridValues() = default;
  explicit GridValues(size_t count) : count_(count) {
    if (count > kMaxInlineValues) shared_values_ = std::make_shared_for_overwrite<int32_t[]>(count);
  }

  size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  const int32_t* data() const {
    return count_ > kMaxInlineValues ? shared_values_.get() : inline_values_.data();
  }
  // Only before the values are shared.
  int32_t* data() { return count_ > kMaxInlineValues ? shared_values_.get() : inline_values_.data(); }
  int32_t operator[](size_t i) const { return data()[i]; }
  bool operator==(const GridValues& other) const {
    return count_ == other.count_ &&
           (data() == other.data() || std::equal(data(), data() + count_, other.data()));
  }

 private:
  static constexpr size_t kMaxInlineValues = 8;
  size_t count_ = 0;
  std::array<int32_t, kMaxInlineValues> inline_values_{};
  std::shared_ptr<int32_t[]> shared_values_;
};

}  // namespace livegs
