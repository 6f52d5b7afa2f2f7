// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

namespace livegs::sample {

// A smooth plane curve through given points (Catmull and Rom 1974, centripetal), by arc length: what a lathe
// turns. A point given twice makes a corner.
class Profile {
 public:
  // At least two different points; x is the radius and y the height when the curve is turned.
  explicit Profile(const std::vector<Eigen::Vector2d>& points_m);

  // t in 0..1, proportional to arc length.
  Eigen::Vector2d at(double t) const;
  double length_m() const { return length_m_; }

  // The largest radius of the curve at this height between the two parameters; -1 where it does not reach.
  double radius_at(double height_m, double t_from = 0.0, double t_to = 1.0) const;

  // The point of a surface of revolution about y. t runs along the profile, angle from +z towards +x.
  Eigen::Vector3d turned(double t, double angle_rad) const;

 private:
  std::vector<Eigen::Vector2d> points_m_;  // evenly spaced
  double length_m_ = 0.0;
};

}  // namespace livegs::sample
