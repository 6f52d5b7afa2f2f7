// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>

// Parts of an elastic body that are held, moved, loaded or made of something else. A region is chosen once,
// at rest, by a box of the object's rest frame.

namespace livegs {

// Prescribed motions give where a material point with rest position X is at time t, in the object's rest
// frame placed by the pose the object started with. Times are seconds of simulation. A motion holds its end
// until it is released.

// X + s d, s from 0 at start_s to 1 at end_s, linear.
struct DisplacementRamp {
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();
  double start_s = 0.0, end_s = 0.0;
};
// about + (I + s (A - I)) (X - about); s from 0 to 1 over start_s ... end_s, and, where return_end_s > end_s,
// back to 0 over end_s ... return_end_s.
struct AffineRamp {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Eigen::Vector3d about_m = Eigen::Vector3d::Zero();
  double start_s = 0.0, end_s = 0.0, return_end_s = 0.0;
};
// X + d sin(pi (t - start) / width) within the width, X outside it.
struct HalfSinePulse {
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();
  double start_s = 0.0, width_s = 0.0;
};
// X + v (t - start) between start_s and end_s.
struct ConstantVelocity {
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double start_s = 0.0, end_s = 0.0;
};
using RegionMotion = std::variant<DisplacementRamp, AffineRamp, HalfSinePulse, ConstantVelocity>;

// Where the material point `rest_m` of a moved region is at `time_s`; rest frame.
Eigen::Vector3d moved_point(const RegionMotion& motion, const Eigen::Vector3d& rest_m, double time_s);
// Whether it takes any point elsewhere from one time to the other.
bool moves_between(const RegionMotion& motion, double from_s, double to_s);

// What a region is made of instead of the body's own material. Unset values are the body's.
struct RegionMaterial {
  std::optional<double> youngs_modulus_pa;  // E* of the region
  std::optional<double> poisson_ratio;
  std::optional<double> density_kg_m3;  // the body's mass changes with it
  std::optional<double> plasticity;
};

struct BodyRegion {
  std::string name;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();
  bool boundary = false;               // all outer particles in place of the box; only for motions
  bool fixed = false;                  // its material does not move
  std::optional<RegionMotion> motion;  // excludes `fixed`
  std::optional<RegionMaterial> material;
  // Force per area, world axes, on the body's faces in the box across the box's shortest edge: on the outer
  // of the two.
  Eigen::Vector3d traction_pa = Eigen::Vector3d::Zero();

  bool contains(const Eigen::Vector3d& rest_m, double margin_m) const {
    return ((rest_m - min_m).array() >= -margin_m).all() && ((max_m - rest_m).array() >= -margin_m).all();
  }
};

// A region that is only fixed.
BodyRegion fixed_box(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m);

}  // namespace livegs
