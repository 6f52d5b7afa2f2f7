// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "study/harness/rigid_setup.h"

// The solver interface of rigid scenes, implemented by World, Bullet and ODE. SI units, world axes. One
// thread.

namespace livegs::study {

struct RigidPart {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // full edge lengths of a box
  double radius_m = 0.0;                             // > 0: a ball instead of a box
  // not empty: a convex body instead of a box, relative to its centre of mass
  std::vector<Eigen::Vector3d> corners_m;
  double mass_kg = 1.0;
  std::optional<Eigen::Vector3d> moments_kg_m2;  // principal moments; default: those of the solid
  double friction = 0.5;           // the friction of a pair is the geometric mean; restitution is 0
  double break_impulse_n_s = 0.0;  // > 0: a fragile box, see RigidSolver::broken
  Pose world_from_part;            // the origin is the centre of mass
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
};

// A soft block about its centre, filled with a grid of particles.
struct SoftPart {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double mass_kg = 1.0, youngs_modulus_pa = 1e5, poisson_ratio = 0.3, loss_factor = 0.3, friction = 0.5;
  double spacing_m = 0.0;     // particle spacing; every edge is a multiple
  double cell_width_m = 0.0;  // 0: chosen by the body
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

struct RigidMotion {
  Pose world_from_part;
  Eigen::Vector3d velocity_m_s, angular_velocity_rad_s;
  bool asleep = false;
};

struct RigidConditions {
  Eigen::Vector3d gravity_m_s2{0, -kGravity_m_s2, 0};
  bool sleep = false;
};

class RigidSolver {
 public:
  virtual ~RigidSolver() = default;

  // Adds the half-space below the plane y = 0 of its frame.
  virtual void add_floor(const Pose& world_from_floor, double friction) = 0;
  // Parts are numbered from 0 in order of addition.
  virtual Result<void> add(const RigidPart& part) = 0;
  // Adds a ball joint at a world point, between `part` and `other`, or the world.
  virtual Result<void> join(size_t part, std::optional<size_t> other, const Eigen::Vector3d& point_m) = 0;
  // Applies a constant force to the centre of mass from now on.
  virtual void push(size_t part, const Eigen::Vector3d& force_n) = 0;
  // Adds an elastic block, which is not counted as a part. Fails if the engine's soft bodies are not
  // connected.
  virtual Result<void> add_soft(const SoftPart& part);
  // Whether a fragile part has broken. For peers, which have no breaking: whether all contacts of the part
  // reached its break_impulse_n_s in one frame. Fails if the engine does not report impulses.
  virtual Result<bool> broken(size_t part) const;

  virtual void frame() = 0;
  virtual std::vector<RigidMotion> motions() const = 0;
};

}  // namespace livegs::study
