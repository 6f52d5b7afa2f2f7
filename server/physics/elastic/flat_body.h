// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/collider.h"
#include "physics/elastic_body.h"
#include "physics/motion/momentum_ledger.h"

// An elastic body as flat arrays, for a device that takes all steps of a tick at once (server/device). The
// body prepares a tick and takes over its result; everything between ticks (end_frame) stays with the body.

namespace livegs {

using FlatVector = std::array<float, 4>;

// Layout of the `cells` solver between steps: position and inverse mass (0: held), velocity and mass.
struct FlatNode {
  FlatVector place, speed;
};

// Fixed as long as FlatBody::flat_revision.
struct FlatLattice {
  struct Cell {
    uint32_t nodes[8];
    uint32_t colour;     // ascending; cells of one colour share no node
    uint32_t constants;  // row of `constants` and `gains`
  };
  struct SurfaceCell {
    uint32_t nodes[8];
    uint32_t begin, end;  // range of points
    uint32_t colour;      // as Cell::colour
  };
  struct SurfacePoint {
    float weights[8];
    float mobility;  // 1/kg
  };
  size_t node_count = 0;
  std::vector<Cell> cells;
  // Centroid (3), mobility G (6: 11, 22, 33, 23, 13, 12), mode coupling (4 x 3), unused.
  using Constants = std::array<float, 24>;
  std::vector<Constants> constants;
  // H (21, upper triangle by rows, Mandel), volume compliance, mode gains (4 x 3), unused: of the body's own
  // steps of first and second order, then of its impact steps (empty: it has none).
  using Gains = std::array<float, 36>;
  std::array<std::vector<Gains>, 4> gains;
  std::vector<SurfaceCell> surface_cells;
  std::vector<SurfacePoint> surface_points;
};

// A plane, box or sphere near the body, positions relative to the body's origin.
struct FlatCollider {
  enum class Kind : uint8_t { Plane, Box, Sphere } kind = Kind::Plane;
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d world_from_collider = Eigen::Matrix3d::Identity();
  Eigen::Vector3d half_m = Eigen::Vector3d::Zero();  // sphere: the radius
  double thickness_m = 0.0;                          // 0: nothing tunnels through
  double friction = 0.0;                             // with the body
};

// Loads on a body in a tick.
struct FlatTick {
  double start_s = 0.0, duration_s = 0.0;
  int substeps = 0;  // of the scene
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  std::span<const Collider> colliders;
  std::span<const PointForce> forces;  // constant over the tick
};

// What a step takes over from the last one.
struct StepMemory {
  bool first = true, strained = false, touching = false, backward = false;
  double deviation_m_s = 0;  // root mean square velocity relative to the rigid motion
};

// State of a body at the start of a tick and, after its steps, at the end.
struct FlatState : StepMemory {
  int steps = 0;
  double step_s = 0.0;
  bool impact = false;  // the steps are impact steps
  bool held = false, may_be_second_order = true;
  double mass_kg = 0, damping_per_s = 0, weight_n = 0, moving_part = 0, friction = 0, loss_factor = 0;
  double inverse_four_widths = 0, slow_m_s = 0, stiffness_pa = 0;
  Eigen::Vector3d load_n = Eigen::Vector3d::Zero(), load_torque = Eigen::Vector3d::Zero();
  std::vector<FlatVector> loads_n;  // by node; empty: none
  std::vector<FlatCollider> colliders;

  std::vector<FlatNode> now, before;  // the current and the previous state
  std::vector<FlatVector> rotations;  // by cell: x, y, z, w
  bool uneven = false;
  double pressed_n = 0, carried_n = 0;
  MomentumLedger ledger;

  // Of the steps.
  bool second_order = false, slow = false, ever_strained = false;
  double strain_squared = 0, bent_squared = 0;
  double contact_n_s = 0;                                    // sum of impulse magnitudes
  Eigen::Vector3d contact_moment = Eigen::Vector3d::Zero();  // sum of magnitude times point
};

class FlatBody {
 public:
  virtual ~FlatBody() = default;
  // Changes with the lattice, its masses, constants and gains.
  virtual uint64_t flat_revision() const = 0;
  virtual size_t flat_node_count() const = 0;
  virtual int flat_steps() const = 0;  // of a tick without an impact
  // Null, or why no tick of this body can be taken elsewhere until the revision changes.
  virtual const char* flat_obstacle() const = 0;
  virtual void write_flat(FlatLattice& lattice) = 0;  // precondition: no obstacle
  // Prepares the steps of a tick. Null, or why this tick cannot be taken elsewhere; the body is then stepped
  // as usual. Precondition: no obstacle, and no moving body is near in this tick.
  virtual const char* begin_flat_tick(const FlatTick& tick, FlatState& state) = 0;
  // Takes over the state after its steps, before end_frame.
  virtual void end_flat_tick(const FlatTick& tick, const FlatState& state) = 0;
};

}  // namespace livegs
