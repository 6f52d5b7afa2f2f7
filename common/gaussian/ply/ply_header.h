// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

// The header of a PLY file (Turk 1994): elements, each a table of rows whose columns are typed properties.

namespace livegs {

enum class PlyScalar { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };
enum class PlyEncoding { Ascii, LittleEndian, BigEndian };

size_t size_of(PlyScalar type);

struct PlyProperty {
  std::string name;
  PlyScalar type = PlyScalar::Float32;
  std::optional<PlyScalar> list_count_type;  // set for a list; its entries have `type`
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  bool has_list() const;
  size_t min_row_bytes() const;  // binary: exact if there is no list
  std::optional<size_t> find(std::string_view property) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::LittleEndian;
  std::vector<std::string> comments;
  std::vector<PlyElement> elements;  // in the order of their rows
  size_t body_offset = 0;

  const PlyElement* find(std::string_view element) const;
};

// Postcondition: the body is long enough for the rows of every element (lists counted as empty), so memory
// for `count` rows may be allocated.
Result<PlyHeader> parse_ply_header(Bytes file, std::string_view name);

}  // namespace livegs
