// SPDX-License-Identifier: Apache-2.0
#include "gaussian/ply/ply_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "gaussian/asset/float_of.h"

namespace livegs {
namespace {

template <class T>
double load_as(const std::byte* at, bool swapped) {
  std::array<std::byte, sizeof(T)> raw;
  std::memcpy(raw.data(), at, sizeof(T));
  if (swapped) std::reverse(raw.begin(), raw.end());
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return static_cast<double>(value);
}

// Exact: every scalar type of PLY fits a double.
double load_scalar(const std::byte* at, PlyScalar type, bool swapped) {
  switch (type) {
    case PlyScalar::Int8:
      return load_as<int8_t>(at, swapped);
    case PlyScalar::Uint8:
      return load_as<uint8_t>(at, swapped);
    case PlyScalar::Int16:
      return load_as<int16_t>(at, swapped);
    case PlyScalar::Uint16:
      return load_as<uint16_t>(at, swapped);
    case PlyScalar::Int32:
      return load_as<int32_t>(at, swapped);
    case PlyScalar::Uint32:
      return load_as<uint32_t>(at, swapped);
    case PlyScalar::Float32:
      return load_as<float>(at, swapped);
    case PlyScalar::Float64:
      return load_as<double>(at, swapped);
  }
  return 0;
}

void store(const PlyColumn& column, size_t row, double value) {
  if (column.floats) column.floats[row * column.stride] = float_of(value);
  if (column.doubles) column.doubles[row * column.stride] = value;
  if (column.words)
    column.words[row * column.stride] = value >= 0 && value < 4294967296.0 ? static_cast<uint32_t>(value) : 0;
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

}  // namespace

Result<void> PlyRows::read(const PlyElement& element, std::span<const PlyColumn> columns) {
  if (element.properties.empty()) return {};
  return encoding_ == PlyEncoding::Ascii || element.has_list() ? read_varying(element, columns)
                                                               : read_fixed(element, columns);
}

Result<void> PlyRows::read_fixed(const PlyElement& element, std::span<const PlyColumn> columns) {
  const size_t row_bytes = element.min_row_bytes();
  if (element.count > left_.size() / row_bytes) {
    return invalid_data(name_ + ": ends within element " + element.name);
  }
  std::vector<size_t> offsets(element.properties.size(), 0);
  for (size_t p = 1; p < offsets.size(); ++p)
    offsets[p] = offsets[p - 1] + size_of(element.properties[p - 1].type);

  const bool swapped = encoding_ == PlyEncoding::BigEndian;
  const std::byte* row_start = left_.data();
  for (size_t row = 0; row < element.count; ++row, row_start += row_bytes) {
    for (const PlyColumn& column : columns) {
      const std::byte* at = row_start + offsets[column.property];
      const PlyScalar type = element.properties[column.property].type;
      if (type == PlyScalar::Float32 && !swapped && column.floats) {
        std::memcpy(column.floats + row * column.stride, at, sizeof(float));
      } else {
        store(column, row, load_scalar(at, type, swapped));
      }
    }
  }
  left_ = left_.subspan(element.count * row_bytes);
  return {};
}

Result<void> PlyRows::read_varying(const PlyElement& element, std::span<const PlyColumn> columns) {
  std::vector<const PlyColumn*> column_of(element.properties.size(), nullptr);
  for (const PlyColumn& column : columns) column_of[column.property] = &column;
  for (size_t row = 0; row < element.count; ++row) {
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      double value = 0;
      const bool good = property.list_count_type ? skip_list(property) : next_value(property.type, value);
      if (!good) {
        return invalid_data(name_ + ": row " + std::to_string(row) + " of element " + element.name +
                            " has an invalid " + property.name + "; copy or export it again");
      }
      if (column_of[p]) store(*column_of[p], row, value);
    }
  }
  return {};
}

bool PlyRows::next_value(PlyScalar type, double& value) {
  if (encoding_ == PlyEncoding::Ascii) return next_number_in_text(value);
  const size_t size = size_of(type);
  if (left_.size() < size) return false;
  value = load_scalar(left_.data(), type, encoding_ == PlyEncoding::BigEndian);
  left_ = left_.subspan(size);
  return true;
}

bool PlyRows::next_number_in_text(double& value) {
  const char* text = reinterpret_cast<const char*>(left_.data());
  const char* const end = text + left_.size();
  while (text != end && is_space(*text)) ++text;
  const char* stop = text;
  while (stop != end && !is_space(*stop)) ++stop;
  if (text == stop) return false;
  left_ = left_.subspan(static_cast<size_t>(stop - reinterpret_cast<const char*>(left_.data())));

  if (*text == '+') ++text;
  const auto [parsed, error] = std::from_chars(text, stop, value);
  if (parsed != stop) return false;
  if (error == std::errc::result_out_of_range) {
    // Underflow counts as zero, overflow as infinite.
    const std::string_view word(text, static_cast<size_t>(stop - text));
    const bool tiny = word.find("e-") != word.npos || word.find("E-") != word.npos;
    value = tiny ? 0 : std::numeric_limits<double>::infinity();
    return true;
  }
  return error == std::errc();
}

bool PlyRows::skip_list(const PlyProperty& property) {
  double count = 0;
  if (!next_value(*property.list_count_type, count) || !(count >= 0) || count != std::floor(count))
    return false;
  if (encoding_ == PlyEncoding::Ascii) {
    double ignored = 0;
    for (double i = 0; i < count; ++i) {
      if (!next_number_in_text(ignored)) return false;
    }
    return true;
  }
  const double bytes = count * static_cast<double>(size_of(property.type));
  if (bytes > static_cast<double>(left_.size())) return false;
  left_ = left_.subspan(static_cast<size_t>(bytes));
  return true;
}

}  // namespace livegs
