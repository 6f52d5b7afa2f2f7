// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/scene_values.h"

#include <cmath>
#include <numbers>

#include "core/math/rotation_between.h"

namespace livegs {
namespace {

Result<void> check_list(const Numbers& numbers, int wanted, std::string_view field, double largest) {
  if (numbers.size() != wanted) {
    return invalid_argument(std::string(field) + ": has " + std::to_string(numbers.size()) +
                            " numbers; give " + std::to_string(wanted));
  }
  for (int i = 0; i < wanted; ++i) {
    if (auto number =
            number_value(numbers[i], -largest, largest, std::string(field) + "[" + std::to_string(i) + "]");
        !number) {
      return number.error();
    }
  }
  return {};
}

}  // namespace

Result<double> number_value(double number, double low, double high, std::string_view field) {
  if (std::isfinite(number) && number >= low && number <= high) return number;
  char range[96];
  std::snprintf(range, sizeof range, ": is %g; it must be between %g and %g", number, low, high);
  return invalid_argument(std::string(field) + range);
}

Result<Eigen::Vector3d> vector_value(const Numbers& numbers, const Eigen::Vector3d& fallback,
                                     std::string_view field, double largest) {
  if (numbers.empty()) return fallback;
  if (auto checked = check_list(numbers, 3, field, largest); !checked) return checked.error();
  return Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
}

Result<Eigen::Quaterniond> quaternion_value(const Numbers& numbers, std::string_view field) {
  if (numbers.empty()) return Eigen::Quaterniond::Identity();
  if (auto checked = check_list(numbers, 4, field, kMaxCoordinate); !checked) return checked.error();
  Eigen::Quaterniond quaternion(numbers[0], numbers[1], numbers[2], numbers[3]);
  if (quaternion.norm() < 1e-6)
    return invalid_argument(std::string(field) + ": is zero; give [w, x, y, z] of unit length");
  return quaternion.normalized();
}

Result<Eigen::Matrix3d> matrix_value(const Numbers& numbers, std::string_view field) {
  if (numbers.empty()) return Eigen::Matrix3d::Identity().eval();
  if (auto checked = check_list(numbers, 9, field, kMaxDeformation); !checked) return checked.error();
  return Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data()));
}

Result<Pose> pose_value(const v1::PlacedAt& pose, std::string_view field) {
  auto position =
      vector_value(pose.position_m(), Eigen::Vector3d::Zero(), std::string(field) + ".position_m");
  if (!position) return position.error();
  auto orientation = quaternion_value(pose.orientation(), std::string(field) + ".orientation");
  if (!orientation) return orientation.error();
  return Pose{*position, *orientation};
}

Result<Eigen::Quaterniond> up_value(std::string_view axis, std::string_view field) {
  using Eigen::Quaterniond;
  using Eigen::Vector3d;
  if (axis.empty() || axis == "-y")
    return Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  if (axis == "y" || axis == "+y") return Quaterniond::Identity();
  const Vector3d y = Vector3d::UnitY();
  if (axis == "x" || axis == "+x") return rotation_between(Vector3d::UnitX(), y);
  if (axis == "-x") return rotation_between(-Vector3d::UnitX(), y);
  if (axis == "z" || axis == "+z") return rotation_between(Vector3d::UnitZ(), y);
  if (axis == "-z") return rotation_between(-Vector3d::UnitZ(), y);
  return invalid_argument(std::string(field) + ": is \"" + std::string(axis) +
                          "\"; give one of x -x y -y z -z");
}

}  // namespace livegs
