// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>

// Parts of an elastic body that are held, moved, loaded, or made of another material. A region selects
// material once, at rest, by a box in the object's rest frame.

namespace livegs {

// Prescribed motions map a rest position X and a time t to a position in the rest frame; the object's initial
// pose then maps it to the world. Times are in seconds of simulation. After its end, a motion holds its final
// position until the region is released.

// X + s d; s rises linearly from 0 at start_s to 1 at end_s.
struct DisplacementRamp {
  Eigen::Vector3d displacement_m = Eigen::Vector3d::Zero();
  double start_s = 0.0, end_s = 0.0;
};
// about + (I + s (A - I)) (X - about); s rises from 0 to 1 over start_s ... end_s. If return_end_s > end_s, s
// then falls back to 0 over end_s ... return_end_s.
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

// Position of the material point `rest_m` at `time_s`; rest frame.
Eigen::Vector3d moved_point(const RegionMotion& motion, const Eigen::Vector3d& rest_m, double time_s);
// Whether the motion displaces any point between the two times.
bool moves_between(const RegionMotion& motion, double from_s, double to_s);

// Material of a region. Unset values are taken from the body's own material.
struct RegionMaterial {
  std::optional<double> youngs_modulus_pa;  // E* of the region
  std::optional<double> poisson_ratio;
  std::optional<double> density_kg_m3;  // changes the body's mass
  std::optional<double> plasticity;
  std::optional<double> friction;  // of the surface, 0 … kMaxFriction
  // Factors on the body's own modulus, density and friction where the region has none: they follow a change
  // of the body's material. Above 0; that of friction may be 0. Densities by factors are scaled together, so
  // that they keep the body's mass.
  double youngs_modulus_factor = 1.0, density_factor = 1.0, friction_factor = 1.0;
};

struct BodyRegion {
  std::string name;
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();
  bool boundary = false;               // selects all outer particles instead of the box; only for motions
  bool fixed = false;                  // the material does not move
  std::optional<RegionMotion> motion;  // excludes `fixed`
  std::optional<RegionMaterial> material;
  // Force per area, world axes. Acts on the body's faces in the box across its shortest edge: the outer one
  // of the two.
  Eigen::Vector3d traction_pa = Eigen::Vector3d::Zero();

  bool contains(const Eigen::Vector3d& rest_m, double margin_m) const {
    return ((rest_m - min_m).array() >= -margin_m).all() && ((max_m - rest_m).array() >= -margin_m).all();
  }
};

// A region with `fixed` set and no other property.
BodyRegion fixed_box(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m);

}  // namespace livegs
