// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// What is left of integers after a prediction, as planes of bytes. Plain loops over arrays; arithmetic wraps,
// so that any integers can be written and any bytes read.

namespace livegs {

enum class Prediction : uint8_t {
  Intra = 0,   // the integer before it in the same array; 0 before the first
  Last = 1,    // the same place in the last frame
  Linear = 2,  // a straight line through the last two frames
};

// The last two frames of one array, and how far ahead to look: last + (last - earlier) * ahead / behind,
// towards zero.
struct PredictionSource {
  const int32_t* last = nullptr;
  const int32_t* earlier = nullptr;
  int32_t ahead = 1, behind = 1;  // ticks, above 0
};

// left[i] = zigzag(values[i] - predicted[i]). Returns how many of the low bytes hold them all, 0 … 4.
int take_residuals(Prediction prediction, const PredictionSource& source, const int32_t* values, size_t count,
                   uint32_t* left);
// The reverse.
void add_residuals(Prediction prediction, const PredictionSource& source, const uint32_t* left, size_t count,
                   int32_t* values);

// Sums of magnitudes that the two predictions from other frames leave, to choose between them; of each eighth integer, which
// says enough.
struct PredictionCost {
  uint64_t last, linear;
};
PredictionCost prediction_cost(const PredictionSource& source, const int32_t* values, size_t count);

// The `plane`th byte, 0 the lowest, of each.
void write_plane(const uint32_t* left, size_t count, int plane, std::byte* bytes);
// Sets that byte of each; the others stay.
void read_plane(const std::byte* bytes, size_t count, int plane, uint32_t* left);

}  // namespace livegs
