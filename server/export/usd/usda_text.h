// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <string>
#include <string_view>

namespace livegs {

// Appends values to the text of a .usda: shortest forms that read back as the same bits.
class UsdaText {
 public:
  // One statement a line, indented by the open prims.
  void line(std::string_view text);
  // `head`: 'def Xform "box" (…)'.
  void open(std::string_view head);
  void close();

  const std::string& text() const { return text_; }
  std::string take() { return std::move(text_); }

  // `name` with its type: "point3f[] positions".
  void floats(std::string_view name, std::span<const float> values, size_t components);
  void integers(std::string_view name, std::span<const int64_t> values, size_t components = 1);
  static void append_floats(std::string& text, std::span<const float> values, size_t components);

 private:
  std::string text_;
  size_t depth_ = 0;
};

std::string usda_number(double value);
std::string usda_number(float value);
std::string usda_tuple(const Eigen::Vector3d& v);
std::string usda_tuple(const Eigen::Quaterniond& q);  // w first
// In double quotes; control characters and quotes as escapes. Invalid UTF-8 becomes U+FFFD.
std::string usda_string(std::string_view text);
// A prim name: letters, digits and underscores, not beginning with a digit.
std::string usda_identifier(std::string_view text);

}  // namespace livegs
