// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace livegs {

// Axes, unit and place that a file states. They do not change the values of the asset: a scene places the
// asset.
struct AssetFrame {
  // Axis of the asset that is up: "x", "-x", "y", … . Empty: the file names none; -y is assumed.
  std::string up_axis;
  // Metres per unit of length, above 0. 0: the file states none, so the unit is a guess.
  double metres_per_unit = 0;
  // The unit is that of the format by convention (.spz, glTF), not a statement of the file.
  bool unit_of_format = false;
  // Position of the asset's zero in the frame of the file, in the asset's axes and unit. Subtracted in double
  // precision before the positions became floats.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};

// Stored form of a frame in files of any format: lines of text, one statement each, in PLY as comments.
//   Vertical Axis: -y            also written by other tools; up is a synonym
//   Unit: 0.01 m                 a number of metres, or m, cm, mm, km, in, ft; "unknown" for a guess
//   Origin: 500000 5400000 30
// `metric_format`: the format's unit is the metre by convention, so that an unknown unit must be stated.
std::vector<std::string> frame_lines(const AssetFrame& frame, bool metric_format);

// The same without the axis, for formats in metres whose up axis is y: writers turn the asset.
std::vector<std::string> y_up_frame_lines(AssetFrame frame);

// Reads one such line; keys and values in any letter case. Other lines are ignored. Returns a note for a
// known key whose value is not understood, else an empty text.
std::string read_frame_line(std::string_view line, AssetFrame& frame);

}  // namespace livegs
