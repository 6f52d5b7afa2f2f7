// SPDX-License-Identifier: Apache-2.0
// Adaptive Rice codes. As in LOCO-I (Weinberger, Seroussi and Sapiro 2000), the residuals at the neighbours
// select the parameter. Layout: proto/frame_format.md, "Integers".
//
// A lattice node is predicted from its own past (fitted curve), then corrected by the residuals at the three
// neighbours below it. This needs any order that ascends along the axes, so nodes keep the order of the
// lattice. Predicting nodes between coarser ones on all sides gains little more. The Laplacian of the
// velocities as a third term would gain more, but costs six further accesses per node.
#include "wire/grid_coder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace livegs {
namespace {

// Four integers that are added at once: the residuals of x, y and z before the neighbour correction, and
// their magnitude.
using Lanes = uint32_t __attribute__((vector_size(16)));

constexpr uint32_t kMaxMagnitude = 1u << 20;             // limit of the counted magnitude of an integer
constexpr uint64_t kPart[4] = {0, 65536, 32768, 21845};  // 1 / neighbour count, times 65536
constexpr uint64_t kMagnitudeAlone = 255;  // replaces four times the mean if there is no neighbour
constexpr uint32_t kCoordinateStep = 4;    // initial estimate for the sum of three coordinate steps of a node
constexpr size_t kFitStride = 5, kCostStride = 8, kFewDrivers = 16;

uint32_t bits_of(int32_t value) { return static_cast<uint32_t>(value); }
uint32_t zigzag(uint32_t value) { return (value << 1) ^ (0u - (value >> 31)); }
uint32_t from_zigzag(uint32_t value) { return (value >> 1) ^ (0u - (value & 1u)); }
uint32_t magnitude(uint32_t zigzagged) {
  return std::min((zigzagged >> 1) + (zigzagged & 1u), kMaxMagnitude);
}

// Class of the mean neighbour magnitude: half octaves of four times the mean.
size_t magnitude_class(uint64_t sum, uint32_t count) {
  const uint64_t at = (count == 0 ? kMagnitudeAlone : (sum * kPart[count]) >> 14) + 4;
  const int top = std::bit_width(at) - 1;
  return static_cast<size_t>(2 * top + static_cast<int>(at >> (top - 1) & 1) - 4);
}

// Initial estimate of the residual of a class.
uint32_t expected_of(size_t magnitude_class) {
  return ((2u + (magnitude_class & 1)) << (magnitude_class / 2)) / 2;
}

uint32_t line(int32_t last, int32_t earlier, const GridPast& past) {
  const int64_t step = static_cast<int64_t>(last) - static_cast<int64_t>(earlier);
  return bits_of(last) + static_cast<uint32_t>(step * past.ahead / past.behind);
}

uint32_t curve(int32_t last, int32_t earlier, int32_t earliest, const GridPast& past) {
  const uint32_t v = bits_of(last) - bits_of(earlier), a = v - (bits_of(earlier) - bits_of(earliest));
  const uint32_t sum = v * bits_of(past.weight_v) + a * bits_of(past.weight_a);
  return bits_of(last) + static_cast<uint32_t>(static_cast<int32_t>(sum) >> 8);
}

void predict(Prediction prediction, const GridPast& past, size_t count, int32_t* to) {
  switch (prediction) {
    case Prediction::Intra:
      std::fill_n(to, count, 0);
      break;
    case Prediction::Last:
      std::copy_n(past.last, count, to);
      break;
    case Prediction::Linear:
      if (past.ahead == past.behind) {
        for (size_t i = 0; i < count; ++i)
          to[i] = static_cast<int32_t>(2u * bits_of(past.last[i]) - bits_of(past.earlier[i]));
      } else {
        for (size_t i = 0; i < count; ++i)
          to[i] = static_cast<int32_t>(line(past.last[i], past.earlier[i], past));
      }
      break;
    case Prediction::Curve:
      for (size_t i = 0; i < count; ++i)
        to[i] = static_cast<int32_t>(curve(past.last[i], past.earlier[i], past.earliest[i], past));
      break;
  }
}

// Codes one integer, given its prediction. Returns the zigzag of the residual.
template <class Bits>
uint32_t code_integer(Bits& bits, uint32_t predicted, int k, int32_t& value) {
  if constexpr (Bits::kReads) {
    const uint32_t left = bits.code(0, k);
    value = static_cast<int32_t>(predicted + from_zigzag(left));
    return left;
  } else {
    return bits.code(zigzag(bits_of(value) - predicted), k);
  }
}

template <class Bits>
bool failed(const Bits& bits) {
  if constexpr (Bits::kReads) return bits.failed();
  return false;
}

template <class Bits>
bool code_nodes(Bits& stream, DriverGrid& grid, Prediction prediction, const GridPast& past,
                GridScales& scales, GridScratch& scratch) {
  Bits bits = stream;
  const size_t n = grid.count;
  scratch.predicted.resize(3 * n);
  scratch.neighbours.resize(4 * n + 8);
  predict(prediction, past, 3 * n, scratch.predicted.data());
  const int least = prediction == Prediction::Intra ? kMinIntraBits : 0;
  const int32_t* const p = scratch.predicted.data();
  int32_t* const x = grid.values.data();
  const NodeNeighbours::Before* const before = grid.neighbours->before.data();
  uint32_t* const neighbours = scratch.neighbours.data();
  const auto at = [&](size_t node) {
    Lanes lanes;
    std::memcpy(&lanes, neighbours + 4 * node, sizeof lanes);
    return lanes;
  };
  const Lanes none = {0, 0, 0, 0};
  std::memcpy(neighbours + 4 * n, &none, sizeof none);  // added for a missing neighbour
  Lanes here = none;  // the node before, usually the first neighbour; a register avoids a memory round trip
  for (size_t i = 0; i < n; ++i) {
    const NodeNeighbours::Before& b = before[i];
    const Lanes others = at(b.nodes[1]) + at(b.nodes[2]);
    const Lanes sum = (b.nodes[0] + 1 == i ? here : at(b.nodes[0])) + others;
    const auto part = static_cast<int64_t>(kPart[b.count]);
    RiceScale& scale = scales.nodes[magnitude_class(sum[3], b.count)];
    const int k = std::max(least, scale.k());
    std::array<uint32_t, 3> expected, left;
    for (size_t c = 0; c < 3; ++c) {
      const auto mean =
          static_cast<uint32_t>((static_cast<int64_t>(static_cast<int32_t>(sum[c])) * part) >> 16);
      expected[c] = bits_of(p[c * n + i]) + mean;
      if constexpr (!Bits::kReads) left[c] = zigzag(bits_of(x[c * n + i]) - expected[c]);
    }
    bits.three(left, k);
    uint32_t magnitudes = 0;
    for (size_t c = 0; c < 3; ++c) {
      if constexpr (Bits::kReads) x[c * n + i] = static_cast<int32_t>(expected[c] + from_zigzag(left[c]));
      here[c] = bits_of(x[c * n + i]) - bits_of(p[c * n + i]);
      magnitudes += magnitude(left[c]);
    }
    here[3] = magnitudes;
    std::memcpy(neighbours + 4 * i, &here, sizeof here);
    scale.add(magnitudes);
    if (failed(bits)) return false;
  }
  stream = bits;
  return true;
}

// Prediction of one integer. `turned`: number of frames back, 1 to 3, at which the quaternion left out
// another component; 0: in none of them.
uint32_t predicted_at(Prediction prediction, const GridPast& past, size_t at, int turned) {
  if (turned == 1) return 0;
  const bool as_last = prediction == Prediction::Last || turned > 1;
  if (as_last) return bits_of(past.last[at]);
  if (prediction == Prediction::Linear) return line(past.last[at], past.earlier[at], past);
  return curve(past.last[at], past.earlier[at], past.earliest[at], past);
}

template <class Bits>
void code_left_out(Bits& bits, Prediction prediction, int32_t was, int32_t& left_out) {
  if (prediction != Prediction::Intra) {
    uint32_t same = 0;
    if constexpr (!Bits::kReads) same = left_out == was ? 1 : 0;
    if (bits.bits(same, 1)) {
      left_out = was;
      return;
    }
  }
  uint32_t number = 0;
  if constexpr (!Bits::kReads) number = bits_of(left_out) & 3u;
  left_out = static_cast<int32_t>(bits.bits(number, 2));
}

template <class Bits>
bool code_drivers(Bits& bits, DriverGrid& grid, Prediction prediction, const GridPast& past,
                  GridScales& scales) {
  const size_t n = grid.count;
  int32_t* const x = grid.values.data();
  const bool turns = grid.channels() > 3, intra = prediction == Prediction::Intra;
  const int least = intra ? kMinIntraBits : 0;
  std::array<uint32_t, 2> before{};
  for (size_t i = 0; i < n; ++i) {
    int turned = 0;
    if (turns) {
      const size_t at = 6 * n + i;
      code_left_out(bits, prediction, intra ? 0 : past.last[at], x[at]);
      if (!intra && x[at] != past.last[at])
        turned = 1;
      else if (prediction >= Prediction::Linear && x[at] != past.earlier[at])
        turned = 2;
      else if (prediction == Prediction::Curve && x[at] != past.earliest[at])
        turned = 3;
    }
    for (size_t group = 0; group < (turns ? 2u : 1u); ++group) {
      RiceScale& scale = i == 0 ? scales.first[group][static_cast<size_t>(prediction)]
                                : scales.drivers[group][magnitude_class(before[group], 1)];
      const int k = std::max(least, scale.k());
      uint32_t magnitudes = 0;
      for (size_t c = 3 * group; c < 3 * group + 3; ++c) {
        const size_t at = c * n + i;
        const uint32_t predicted = !intra  ? predicted_at(prediction, past, at, group == 1 ? turned : 0)
                                   : i > 0 ? bits_of(x[at - 1])
                                           : 0u;
        magnitudes += magnitude(code_integer(bits, predicted, k, x[at]));
      }
      scale.add(magnitudes);
      before[group] = magnitudes;
    }
    if (failed(bits)) return false;
  }
  return true;
}

}  // namespace

GridScales::GridScales() {
  for (size_t c = 0; c < kMagnitudeClasses; ++c) {
    const RiceScale scale(expected_of(c));
    nodes[c] = drivers[0][c] = drivers[1][c] = scale;
  }
}

template <class Bits>
bool code_values(Bits& bits, DriverGrid& grid, Prediction prediction, const GridPast& past,
                 GridScales& scales, GridScratch& scratch) {
  if (grid.neighbours) return code_nodes(bits, grid, prediction, past, scales, scratch);
  return code_drivers(bits, grid, prediction, past, scales);
}

template <class Bits>
bool code_coordinates(Bits& bits, std::vector<Eigen::Vector3i>& coordinates) {
  Eigen::Vector3i expected = Eigen::Vector3i::Zero();
  RiceScale scale(kCoordinateStep);
  for (Eigen::Vector3i& place : coordinates) {
    const int k = scale.k();
    uint32_t magnitudes = 0;
    for (int d = 0; d < 3; ++d)
      magnitudes += magnitude(code_integer(bits, bits_of(expected[d]), k, place[d]));
    scale.add(magnitudes);
    // Nodes are in rows along x.
    expected = place;
    expected[0] = static_cast<int32_t>(bits_of(place[0]) + 1);
    if (failed(bits)) return false;
  }
  return true;
}

template bool code_values(RiceWriter&, DriverGrid&, Prediction, const GridPast&, GridScales&, GridScratch&);
template bool code_values(RiceReader&, DriverGrid&, Prediction, const GridPast&, GridScales&, GridScratch&);
template bool code_coordinates(RiceWriter&, std::vector<Eigen::Vector3i>&);
template bool code_coordinates(RiceReader&, std::vector<Eigen::Vector3i>&);

void fit_curve(const DriverGrid& grid, GridPast& past) {
  double vv = 0, va = 0, aa = 0, vt = 0, at = 0;
  const size_t count = 3 * static_cast<size_t>(grid.count);
  for (size_t i = 0; i < count; i += kFitStride) {
    const double v = static_cast<double>(past.last[i]) - past.earlier[i];
    const double a = v - (static_cast<double>(past.earlier[i]) - past.earliest[i]);
    const double t = static_cast<double>(grid.values[i]) - past.last[i];
    vv += v * v;
    va += v * a;
    aa += a * a;
    vt += v * t;
    at += a * t;
  }
  // A small weight towards the straight line prevents a division by zero.
  const double pull = 1.0 + 1e-6 * (vv + aa);
  vv += pull;
  aa += pull;
  vt += pull;
  const double determinant = vv * aa - va * va;
  const auto weight = [](double value) {
    constexpr double kMaxWeight = (1 << (kWeightBits - 1)) - 1;
    return static_cast<int32_t>(std::lround(std::clamp(256.0 * value, -kMaxWeight, kMaxWeight)));
  };
  past.weight_v = weight((vt * aa - at * va) / determinant);
  past.weight_a = weight((at * vv - vt * va) / determinant);
}

PredictionCosts prediction_costs(const DriverGrid& grid, const GridPast& past, bool has_linear,
                                 bool has_curve) {
  constexpr uint64_t kNever = std::numeric_limits<uint64_t>::max();
  PredictionCosts costs{0, has_linear ? 0 : kNever, has_curve ? 0 : kNever};
  const size_t n = grid.count, stride = n > kFewDrivers ? kCostStride : 1;
  const size_t channels = grid.channels() > 3 ? 6 : 3;
  for (size_t c = 0; c < channels; ++c) {
    for (size_t i = c * n; i < (c + 1) * n; i += stride) {
      const uint32_t value = bits_of(grid.values[i]);
      costs.last += zigzag(value - bits_of(past.last[i]));
      if (has_linear) costs.linear += zigzag(value - line(past.last[i], past.earlier[i], past));
      if (has_curve)
        costs.curve += zigzag(value - curve(past.last[i], past.earlier[i], past.earliest[i], past));
    }
  }
  return costs;
}

}  // namespace livegs
