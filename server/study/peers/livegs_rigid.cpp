// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/peers/livegs_rigid.h"

#include "geometry/mesh/convex_hull.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/world.h"
#include "prepare/prepare_pieces.h"
#include "study/harness/block.h"

namespace livegs::study {
namespace {

// Typical for fragile objects of this size.
constexpr size_t kPieces = 16;

// Cached, because the scenes drop the same box a hundred times.
Result<std::shared_ptr<const BreakablePieces>> pieces_of_box(const Eigen::Vector3d& size_m) {
  thread_local Eigen::Vector3d cut_size_m = Eigen::Vector3d::Zero();
  thread_local std::shared_ptr<const BreakablePieces> cut;
  if (cut && cut_size_m == size_m) return cut;
  auto pieces = prepare_pieces(box_mesh(size_m), Fill::Solid, {.piece_count = kPieces});
  if (!pieces) return pieces.error();
  cut_size_m = size_m;
  cut = *pieces;
  return cut;
}

class LivegsRigid final : public RigidSolver {
 public:
  LivegsRigid(const RigidSetup& setup, const RigidConditions& conditions)
      : world_({.gravity_m_s2 = conditions.gravity_m_s2,
                .rate_hz = setup.rate_hz,
                .substeps = setup.substeps,
                .sleep = conditions.sleep}) {}

  void add_floor(const Pose& world_from_floor, double friction) override {
    world_.add_collider({PlaneShape{}, world_from_floor, friction, 0.0});
  }
  Result<void> add(const RigidPart& part) override;
  Result<void> join(size_t part, std::optional<size_t> other, const Eigen::Vector3d& point_m) override {
    BallJointDescription joint;
    joint.object_id = id_of(part);
    if (other) joint.other_id = id_of(*other);
    joint.point_m = motions()[part].world_from_part.inverse() * point_m;
    return world_.add_ball_joint(joint);
  }
  void push(size_t part, const Eigen::Vector3d& force_n) override {
    // At the rest centre, which is the centre of mass of every part.
    world_.set_force(part, id_of(part), {Eigen::Vector3d::Zero(), force_n});
  }
  Result<void> add_soft(const SoftPart& part) override;
  Result<bool> broken(size_t part) const override { return world_.revision(id_of(part)) > 0; }
  void frame() override { world_.step(); }
  std::vector<RigidMotion> motions() const override;

 private:
  static uint32_t id_of(size_t part) { return static_cast<uint32_t>(part) + 1; }

  World world_;
  uint32_t parts_ = 0, soft_parts_ = 0;
};

// First object id of soft blocks.
constexpr uint32_t kFirstSoft = 1'000'000;

Result<void> LivegsRigid::add(const RigidPart& part) {
  const uint32_t id = id_of(parts_);
  Result<void> added;
  if (part.radius_m > 0.0) {
    BallDescription ball;
    ball.object_id = id;
    ball.position_m = part.world_from_part.position_m;
    ball.velocity_m_s = part.velocity_m_s;
    ball.radius_m = part.radius_m;
    ball.mass_kg = part.mass_kg;
    ball.friction = part.friction;
    ball.restitution = 0.0;
    added = world_.add_ball(ball);
  } else {
    RigidBodyDescription body;
    body.object_id = id;
    body.mesh = part.corners_m.empty() ? box_mesh(part.size_m) : convex_hull(part.corners_m);
    body.properties = solid_mass_properties(body.mesh);
    if (part.moments_kg_m2) body.properties.inertia_m2 = (*part.moments_kg_m2 / part.mass_kg).asDiagonal();
    body.material.behavior = Behavior::Rigid;
    body.material.mass_kg = part.mass_kg;
    body.material.friction = part.friction;
    body.material.restitution = 0.0;
    body.world_from_object = part.world_from_part;
    body.velocity_m_s = part.velocity_m_s;
    body.angular_velocity_rad_s = part.angular_velocity_rad_s;
    body.material.fragile = part.break_impulse_n_s > 0.0 && part.corners_m.empty();
    body.material.break_impulse_n_s = part.break_impulse_n_s;
    added = world_.add_rigid(body);
    if (added && body.material.fragile) {
      auto pieces = pieces_of_box(part.size_m);
      if (!pieces) return pieces.error();
      added = world_.set_pieces(id, *pieces);
    }
  }
  if (added) ++parts_;
  return added;
}

Result<void> LivegsRigid::add_soft(const SoftPart& part) {
  Setup setup;
  setup.spacing_m = part.spacing_m;
  setup.cell_width_m = part.cell_width_m;
  setup.youngs_modulus_pa = part.youngs_modulus_pa;
  setup.poisson_ratio = part.poisson_ratio;
  setup.density_kg_m3 = part.mass_kg / part.size_m.prod();
  ElasticBodyDescription body = describe_box(setup, -0.5 * part.size_m, 0.5 * part.size_m);
  body.object_id = kFirstSoft + soft_parts_++;
  body.material.loss_factor = part.loss_factor;
  body.material.friction = part.friction;
  body.material.restitution = 0.0;
  body.world_from_object.position_m = part.position_m;
  return world_.add_elastic(body);
}

std::vector<RigidMotion> LivegsRigid::motions() const {
  std::vector<RigidMotion> motions;
  for (const BodyState& state : world_.bodies()) {  // ascending id
    motions.push_back(
        {state.world_from_body, state.velocity_m_s, state.angular_velocity_rad_s, state.asleep});
  }
  return motions;
}

}  // namespace

std::unique_ptr<RigidSolver> make_livegs_rigid(const RigidSetup& setup, const RigidConditions& conditions) {
  return std::make_unique<LivegsRigid>(setup, conditions);
}

}  // namespace livegs::study
