// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

// .ply files with any columns, as other tools write them.

namespace livegs {

// A property of a file: its type, name and value of kernel i.
struct Column {
  std::string type, name;
  std::function<double(size_t)> value;
};

template <class T>
void append_value(std::string& row, double value) {
  const auto typed = static_cast<T>(value);
  row.append(reinterpret_cast<const char*>(&typed), sizeof(typed));
}

inline std::vector<std::byte> ply_of(const std::vector<Column>& columns, size_t count,
                                     const std::string& comments = "", bool text = false) {
  std::string file = "ply\nformat " + std::string(text ? "ascii" : "binary_little_endian") + " 1.0\n" +
                     comments + "element vertex " + std::to_string(count) + "\n";
  for (const Column& column : columns) file += "property " + column.type + " " + column.name + "\n";
  file += "end_header\n";
  for (size_t i = 0; i < count; ++i) {
    for (const Column& column : columns) {
      const double value = column.value(i);
      char number[40];
      std::snprintf(number, sizeof number, "%.17g ", value);
      if (text) {
        file += number;
      } else if (column.type == "uchar") {
        append_value<uint8_t>(file, value);
      } else if (column.type == "ushort") {
        append_value<uint16_t>(file, value);
      } else if (column.type == "double") {
        append_value<double>(file, value);
      } else {
        append_value<float>(file, value);
      }
    }
    if (text) file += "\n";
  }
  const auto bytes = std::as_bytes(std::span(file));
  return {bytes.begin(), bytes.end()};
}

// The columns of an asset without harmonics; tests replace some.
inline std::vector<Column> columns_of(const GaussianAsset& a) {
  std::vector<Column> columns;
  const auto add = [&](const std::string& name, auto value) {
    columns.push_back({"float", name, [value](size_t i) { return static_cast<double>(value(i)); }});
  };
  for (int k = 0; k < 3; ++k) add(std::string(1, "xyz"[k]), [&a, k](size_t i) { return a.positions[i][k]; });
  for (int k = 0; k < 3; ++k) add("f_dc_" + std::to_string(k), [&a, k](size_t i) { return a.sh_dc[i][k]; });
  add("opacity", [&a](size_t i) { return a.opacity_logits[i]; });
  for (int k = 0; k < 3; ++k)
    add("scale_" + std::to_string(k), [&a, k](size_t i) { return a.log_scales[i][k]; });
  for (int k = 0; k < 4; ++k)
    add("rot_" + std::to_string(k), [&a, k](size_t i) { return a.rotations[i].coeffs()[(k + 3) % 4]; });
  return columns;
}

inline Column& named(std::vector<Column>& columns, const std::string& name) {
  return *std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
}

inline void remove(std::vector<Column>& columns, const std::string& name) {
  std::erase_if(columns, [&](const Column& c) { return c.name == name; });
}

// Kernels on a ball of radius 1.
inline GaussianAsset ball_asset(size_t count, double deviation, double opacity) {
  GaussianAsset asset;
  asset.resize(count);
  for (size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double turn = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    asset.positions[i] = Eigen::Vector3d(r * std::cos(turn), r * std::sin(turn), z).cast<float>();
    asset.log_scales[i].setConstant(static_cast<float>(std::log(deviation)));
    asset.rotations[i].setIdentity();
    asset.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
    asset.sh_dc[i].setZero();
  }
  return asset;
}

}  // namespace livegs
