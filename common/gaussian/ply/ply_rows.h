// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "gaussian/ply/ply_header.h"

namespace livegs {

// Destination of the values of one property: row r is written to first[r * stride], as a float, as a 32-bit
// integer or as a double.
struct PlyColumn {
  size_t property = 0;  // index in the element; not a list
  float* floats = nullptr;
  uint32_t* words = nullptr;
  size_t stride = 1;
  double* doubles = nullptr;
};

// The body of a PLY file, read element by element in the order of the header.
class PlyRows {
 public:
  // Both references outlive the reader.
  PlyRows(const PlyHeader& header, Bytes file, std::string_view name)
      : encoding_(header.encoding), left_(file.subspan(header.body_offset)), name_(name) {}

  // Reads all rows of the next element, or skips them if there are no columns.
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
