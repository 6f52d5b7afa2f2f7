// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <google/protobuf/repeated_field.h>

#include <Eigen/Core>
#include <string>
#include <string_view>

#include "core/pose.h"
#include "core/result.h"
#include "livegs/v1/scene.pb.h"

// The value forms of scene files: lists of numbers to vectors and poses. `field` is what an error calls the
// value: "objects[2].pose.position_m".

namespace livegs {

using Numbers = google::protobuf::RepeatedField<double>;

// Three finite numbers no larger than `largest`; `fallback` when the list is empty.
inline constexpr double kMaxCoordinate = 1e6;
Result<Eigen::Vector3d> vector_value(const Numbers& numbers, const Eigen::Vector3d& fallback,
                                     std::string_view field, double largest = kMaxCoordinate);
Result<Eigen::Quaterniond> quaternion_value(const Numbers& numbers, std::string_view field);
Result<Pose> pose_value(const v1::PlacedAt& pose, std::string_view field);

// Nine numbers row by row, each from -kMaxDeformation to it; the identity when the list is empty.
inline constexpr double kMaxDeformation = 100.0;
Result<Eigen::Matrix3d> matrix_value(const Numbers& numbers, std::string_view field);

// Finite and within [low, high].
Result<double> number_value(double number, double low, double high, std::string_view field);

// The rotation that turns an asset's up axis ("-y" when empty) to +Y. About x for "-y", so that an RDF
// asset's x stays.
Result<Eigen::Quaterniond> up_value(std::string_view axis, std::string_view field);

}  // namespace livegs
