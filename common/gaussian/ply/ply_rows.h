// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "gaussian/ply/ply_header.h"

namespace livegs {

// Where the values of one property go: row r to first[r * stride], as a float or as a whole number of 32
// bits.
struct PlyColumn {
  size_t property = 0;  // index in the element; not a list
  float* floats = nullptr;
  uint32_t* words = nullptr;
  size_t stride = 1;
};

// The body of a PLY file, read element by element in the order of the header.
class PlyRows {
 public:
  // Both outlive the reader.
  PlyRows(const PlyHeader& header, Bytes file, std::string_view name)
      : encoding_(header.encoding), left_(file.subspan(header.body_offset)), name_(name) {}

  // Reads (or, with no columns, skips) all rows of the next element.
  Result<void> read(const PlyElement& element, std::span<const PlyColumn> columns);

  size_t bytes_left() const { return left_.size(); }

 private:
  Result<void> read_fixed(const PlyElement& element, std::span<const PlyColumn> columns);
  Result<void> read_varying(const PlyElement& element, std::span<const PlyColumn> columns);
  bool next_value(PlyScalar type, double& value);
  bool next_number_in_text(double& value);
  bool skip_list(const PlyProperty& property);

  PlyEncoding encoding_;
  Bytes left_;
  std::string name_;
};

}  // namespace livegs
