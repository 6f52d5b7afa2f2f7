// SPDX-License-Identifier: Apache-2.0
#include "wire/residual_planes.h"

namespace livegs {
namespace {

constexpr size_t kCostStride = 8;

uint32_t zigzag(uint32_t value) { return (value << 1) ^ (0u - (value >> 31)); }
uint32_t from_zigzag(uint32_t value) { return (value >> 1) ^ (0u - (value & 1u)); }
uint32_t bits(int32_t value) { return static_cast<uint32_t>(value); }

uint32_t line(int32_t last, int32_t earlier, int32_t ahead, int32_t behind) {
  const int64_t step = static_cast<int64_t>(last) - static_cast<int64_t>(earlier);
  return bits(last) + static_cast<uint32_t>(step * ahead / behind);
}

template <class Take>
uint32_t take_each(size_t count, uint32_t* left, const Take& take) {
  uint32_t any = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t value = zigzag(take(i));
    left[i] = value;
    any |= value;
  }
  return any;
}

}  // namespace

int take_residuals(Prediction prediction, const PredictionSource& source, const int32_t* values, size_t count,
                   uint32_t* left) {
  uint32_t any = 0;
  const int32_t* const last = source.last;
  const int32_t* const earlier = source.earlier;
  switch (prediction) {
    case Prediction::Intra:
      any = count > 0 ? (left[0] = zigzag(bits(values[0]))) : 0;
      if (count > 1)
        any |=
            take_each(count - 1, left + 1, [&](size_t i) { return bits(values[i + 1]) - bits(values[i]); });
      break;
    case Prediction::Last:
      any = take_each(count, left, [&](size_t i) { return bits(values[i]) - bits(last[i]); });
      break;
    case Prediction::Linear:
      if (source.ahead == source.behind) {
        any = take_each(count, left,
                        [&](size_t i) { return bits(values[i]) - (2u * bits(last[i]) - bits(earlier[i])); });
      } else {
        any = take_each(count, left, [&](size_t i) {
          return bits(values[i]) - line(last[i], earlier[i], source.ahead, source.behind);
        });
      }
      break;
  }
  return any == 0 ? 0 : any < 1u << 8 ? 1 : any < 1u << 16 ? 2 : any < 1u << 24 ? 3 : 4;
}

void add_residuals(Prediction prediction, const PredictionSource& source, const uint32_t* left, size_t count,
                   int32_t* values) {
  const int32_t* const last = source.last;
  const int32_t* const earlier = source.earlier;
  switch (prediction) {
    case Prediction::Intra: {
      uint32_t sum = 0;
      for (size_t i = 0; i < count; ++i) {
        sum += from_zigzag(left[i]);
        values[i] = static_cast<int32_t>(sum);
      }
      break;
    }
    case Prediction::Last:
      for (size_t i = 0; i < count; ++i)
        values[i] = static_cast<int32_t>(bits(last[i]) + from_zigzag(left[i]));
      break;
    case Prediction::Linear:
      if (source.ahead == source.behind) {
        for (size_t i = 0; i < count; ++i) {
          values[i] = static_cast<int32_t>(2u * bits(last[i]) - bits(earlier[i]) + from_zigzag(left[i]));
        }
      } else {
        for (size_t i = 0; i < count; ++i) {
          values[i] = static_cast<int32_t>(line(last[i], earlier[i], source.ahead, source.behind) +
                                           from_zigzag(left[i]));
        }
      }
      break;
  }
}

PredictionCost prediction_cost(const PredictionSource& source, const int32_t* values, size_t count) {
  PredictionCost cost{0, 0};
  const bool even = source.ahead == source.behind;
  for (size_t i = 0; even && i < count; i += kCostStride) {
    const uint32_t by_last = bits(values[i]) - bits(source.last[i]);
    cost.last += zigzag(by_last);
    cost.linear += zigzag(by_last - (bits(source.last[i]) - bits(source.earlier[i])));
  }
  for (size_t i = 0; !even && i < count; i += kCostStride) {
    cost.last += zigzag(bits(values[i]) - bits(source.last[i]));
    cost.linear +=
        zigzag(bits(values[i]) - line(source.last[i], source.earlier[i], source.ahead, source.behind));
  }
  return cost;
}

void write_plane(const uint32_t* left, size_t count, int plane, std::byte* bytes) {
  for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(left[i] >> (8 * plane));
}

void read_plane(const std::byte* bytes, size_t count, int plane, uint32_t* left) {
  for (size_t i = 0; i < count; ++i) left[i] |= static_cast<uint32_t>(bytes[i]) << (8 * plane);
}

}  // namespace livegs
