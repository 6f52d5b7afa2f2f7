// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset_frame.h"

#include <charconv>
#include <cmath>

#include "core/text/format_text.h"
#include "core/text/path_ending.h"
#include "core/text/shown_text.h"
#include "gaussian/asset/words.h"

namespace livegs {
namespace {

// An origin beyond this is damage: the circumference of the solar system in metres is below it.
constexpr double kMaxOrigin = 1e15;
constexpr double kMinMetresPerUnit = 1e-9, kMaxMetresPerUnit = 1e9;

struct Unit {
  std::string_view word;
  double metres;
};
constexpr Unit kUnits[] = {{"m", 1},
                           {"metre", 1},
                           {"metres", 1},
                           {"meter", 1},
                           {"meters", 1},
                           {"cm", 0.01},
                           {"centimetre", 0.01},
                           {"centimetres", 0.01},
                           {"centimeter", 0.01},
                           {"centimeters", 0.01},
                           {"mm", 0.001},
                           {"millimetre", 0.001},
                           {"millimetres", 0.001},
                           {"millimeter", 0.001},
                           {"millimeters", 0.001},
                           {"km", 1000},
                           {"in", 0.0254},
                           {"inch", 0.0254},
                           {"inches", 0.0254},
                           {"ft", 0.3048},
                           {"foot", 0.3048},
                           {"feet", 0.3048}};

bool read_up(const std::vector<std::string_view>& words, AssetFrame& frame) {
  if (words.empty()) return false;
  std::string_view axis = words[0];
  if (axis.ends_with("-up")) axis.remove_suffix(3);
  if (axis.starts_with('+')) axis.remove_prefix(1);
  const bool minus = axis.starts_with('-');
  if (minus) axis.remove_prefix(1);
  if (axis != "x" && axis != "y" && axis != "z") return false;
  frame.up_axis = (minus ? "-" : "") + std::string(axis);
  return true;
}

bool read_unit(std::vector<std::string_view> words, AssetFrame& frame) {
  double factor = 1;
  if (!words.empty()) {
    if (const auto number = number_of(words[0])) {
      factor = *number;
      words.erase(words.begin());
      if (words.empty()) return false;
    }
  }
  if (words.size() != 1) return false;
  if (words[0] == "unknown") {
    frame.metres_per_unit = 0;
    frame.unit_of_format = false;
    return true;
  }
  for (const Unit& unit : kUnits) {
    if (unit.word != words[0]) continue;
    const double metres = factor * unit.metres;
    if (!(metres >= kMinMetresPerUnit && metres <= kMaxMetresPerUnit)) return false;
    frame.metres_per_unit = metres;
    frame.unit_of_format = false;
    return true;
  }
  return false;
}

bool read_origin(const std::vector<std::string_view>& words, AssetFrame& frame) {
  if (words.size() != 3) return false;
  Eigen::Vector3d origin;
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto number = number_of(words[axis]);
    if (!number || !(std::abs(*number) <= kMaxOrigin)) return false;
    origin[static_cast<int>(axis)] = *number;
  }
  frame.origin = origin;
  return true;
}

}  // namespace

std::vector<std::string> frame_lines(const AssetFrame& frame, bool metric_format) {
  std::vector<std::string> lines;
  if (!frame.up_axis.empty()) lines.push_back("Vertical Axis: " + frame.up_axis);
  if (frame.metres_per_unit == 0) {
    if (metric_format) lines.push_back("Unit: unknown");
  } else if (frame.metres_per_unit != 1 || !metric_format) {
    lines.push_back(format_text("Unit: %.17g m", frame.metres_per_unit));
  }
  if (!frame.origin.isZero(0))
    lines.push_back(
        format_text("Origin: %.17g %.17g %.17g", frame.origin.x(), frame.origin.y(), frame.origin.z()));
  return lines;
}

std::vector<std::string> y_up_frame_lines(AssetFrame frame) {
  frame.up_axis.clear();
  return frame_lines(frame, true);
}

std::string read_frame_line(std::string_view line, AssetFrame& frame) {
  const size_t colon = line.find_first_of(":=");
  if (colon == line.npos) return "";
  const std::string lower = lower_case(line);
  const std::string_view text(lower);
  std::string key;
  for (const std::string_view word : words_of(text.substr(0, colon)))
    key += (key.empty() ? "" : " ") + std::string(word);
  const std::vector<std::string_view> words = words_of(text.substr(colon + 1));
  if (key == "vertical axis" || key == "up axis" || key == "up") {
    if (read_up(words, frame)) return "";
    return "the vertical axis '" + shown_text(line.substr(colon + 1), 40) +
           "' of the file is not supported; give --up";
  }
  if (key == "unit" || key == "units" || key == "length unit") {
    if (read_unit(words, frame)) return "";
    return "the unit '" + shown_text(line.substr(colon + 1), 40) +
           "' of the file is not supported; give the scale";
  }
  if (key == "origin") read_origin(words, frame);
  return "";
}

}  // namespace livegs
