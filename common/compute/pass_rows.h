// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "compute/pass.h"

// Typed access to the buffers of a CPU function.

namespace livegs {

// Rows are read and written with memcpy, which compiles to plain moves.
template <class Row>
Row row_at(std::span<const std::byte> buffer, size_t index) {
  Row row;
  std::memcpy(&row, buffer.data() + index * sizeof(Row), sizeof(Row));
  return row;
}

template <class Row>
void set_row(std::span<std::byte> buffer, size_t index, const Row& row) {
  std::memcpy(buffer.data() + index * sizeof(Row), &row, sizeof(Row));
}

// Valid because buffers are aligned to 16 bytes and come from operator new as plain bytes.
inline std::span<uint32_t> words_of(std::span<std::byte> buffer) {
  return {reinterpret_cast<uint32_t*>(buffer.data()), buffer.size() / 4};
}

}  // namespace livegs
