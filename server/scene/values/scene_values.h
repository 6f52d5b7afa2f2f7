// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <google/protobuf/repeated_field.h>

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "core/pose.h"
#include "core/result.h"
#include "livegs/v1/scene.pb.h"

// Converts the values of scene files, lists of numbers, to vectors, rotations and poses. `field` names the
// value in errors: "objects[2].pose.position_m".

namespace livegs {

using Numbers = google::protobuf::RepeatedField<double>;

// Reads three finite numbers of magnitude at most `largest`. Returns `fallback` for an empty list.
inline constexpr double kMaxCoordinate = 1e6;
Result<Eigen::Vector3d> vector_value(const Numbers& numbers, const Eigen::Vector3d& fallback,
                                     std::string_view field, double largest = kMaxCoordinate);
Result<Eigen::Quaterniond> quaternion_value(const Numbers& numbers, std::string_view field);
Result<Pose> pose_value(const v1::PlacedAt& pose, std::string_view field);

// Reads nine numbers, row by row, each within ±kMaxDeformation. Returns the identity for an empty list.
inline constexpr double kMaxDeformation = 100.0;
Result<Eigen::Matrix3d> matrix_value(const Numbers& numbers, std::string_view field);

// Returns `number` if it is finite and within [low, high].
Result<double> number_value(double number, double low, double high, std::string_view field);

// Returns the rotation from an asset's up axis ("-y" if empty) to +Y. For "-y" the rotation is about x, so
// that the x axis of an RDF asset is kept.
Result<Eigen::Quaterniond> up_value(std::string_view axis, std::string_view field);

}  // namespace livegs
