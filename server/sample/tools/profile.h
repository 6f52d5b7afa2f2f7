// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs::sample {

// A smooth plane curve through given points (centripetal Catmull-Rom, 1974), parametrised by arc length. Used
// for surfaces of revolution. A point given twice makes a corner.
class Profile {
 public:
  // At least two distinct points; x is the radius and y the height of the surface of revolution.
  explicit Profile(const std::vector<Eigen::Vector2d>& points_m);

  // t in 0..1 is proportional to arc length.
  Eigen::Vector2d at(double t) const;
  double length_m() const { return length_m_; }

  // Returns the largest radius at this height between the two parameters; -1 if the curve does not reach it.
  double radius_at(double height_m, double t_from = 0.0, double t_to = 1.0) const;

  // Returns a point of the surface of revolution about y. t runs along the profile; the angle is from +z
  // towards +x.
  Eigen::Vector3d turned(double t, double angle_rad) const;

 private:
  std::vector<Eigen::Vector2d> points_m_;  // evenly spaced
  double length_m_ = 0.0;
};

}  // namespace livegs::sample
