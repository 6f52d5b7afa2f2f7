// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "physics/cell_choice.h"
#include "physics/cell_sweep.h"
#include "physics/elastic_body.h"
#include "physics/lattice.h"
#include "physics/mass_motion.h"
#include "physics/point_contact.h"
#include "physics/rest_clock.h"

// The `cells` solver: an embedded lattice of eight-node cells, one sweep a substep, BDF2 (elastic-study.md).
//
// One substep:
//   predict   velocities and positions by BDF2; damping; the momentum of the body as a whole is set exactly
//   sweep     elasticity, cell by cell, into corrections that start at zero
//   regions   particles of fixed regions that their nodes do not already hold
//   contact   surface points against colliders and balls; after elasticity, so that nothing is left inside
//   advance   velocity = predicted + corrections / h_e, never a difference of positions; momentum ledger

namespace livegs {

class CellsBody final : public ElasticBody {
 public:
  // Preconditions: a description that make_elastic_body has checked.
  CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep);

  void substep(const SubstepContext& context) override;
  void end_frame(double frame_s) override;

  bool release_region(const std::string&) override { return false; }
  void set_material(const Material& material) override;
  const Material& material() const override { return material_; }
  bool asleep() const override { return rest_clock_.asleep(); }
  void wake() override { rest_clock_.wake(); }

  RestBody rest_body() const override;
  void write_drivers(ObjectDrivers& drivers) const override;
  Pose centre_pose() const override;
  Eigen::Vector3d velocity_m_s() const override;
  Eigen::Vector3d angular_velocity_rad_s() const override;
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const override;
  Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const override;

 private:
  using Vector3d = Eigen::Vector3d;

  // A material point with its weights at hand.
  struct Sample {
    std::array<uint32_t, 8> nodes;
    std::array<double, 8> weights;
  };
  // The surface samples of one cell, to pass over them together.
  struct SurfaceCell {
    std::array<uint32_t, 8> nodes;
    uint32_t begin, end;  // surface_
  };
  struct Touch {
    const Sample* sample;
    Vector3d impulse_n_s;
  };
  struct HeldSample {
    Sample sample;
    Vector3d target_m;  // world
  };

  void choose_substeps(double cell_width_m);
  void set_masses();
  void set_gains(double step_s);
  void start_motion(const ElasticBodyDescription& description);
  void make_surface(const ParticleSet& particles);
  void hold_regions(const ElasticBodyDescription& description);

  void step(double h, const SubstepContext& context);
  void predict(double h, bool second_order, const SubstepContext& context);
  void hold_particles();
  void resolve_colliders(double step_s);
  void resolve_balls(double h, double step_s, std::span<MovingSphere> spheres);
  void advance(double step_s);

  Sample sample_at(const EmbeddedPoint& point) const;
  Vector3d at(const Sample& sample, const std::vector<Vector3d>& values) const;
  Vector3d corrected(const Sample& sample) const;  // where the sample is after the corrections so far
  Vector3d at(uint32_t node) const;                // and a node
  double mobility(const Sample& sample) const;
  void pull(const Sample& sample, const Vector3d& pull_kg_m);
  void take_contact(const Sample& sample, const Vector3d& point_m, const Vector3d& pull_kg_m, double step_s);
  bool free() const { return !held_; }
  double damping_rate() const;

  Material material_;
  Lattice lattice_;
  BodyExtent extent_;
  std::vector<Vector3d> particle_rest_m_;
  std::vector<double> particle_volumes_m3_;
  std::vector<EmbeddedPoint> particle_points_;
  std::vector<Sample> surface_;  // by cell
  std::vector<SurfaceCell> surface_cells_;
  std::vector<HeldSample> held_particles_;
  bool held_ = false;  // some of it does not move
  double volume_m3_ = 0.0;
  uint32_t object_id_;

  double rate_hz_;
  int scene_substeps_;
  CellChoice choice_;
  double gains_step_s_ = 0.0;  // the h that gains_ are for

  // Nodes. Positions are relative to origin_m_, which follows the body.
  Vector3d origin_m_ = Vector3d::Zero();
  std::vector<double> masses_kg_, inverse_masses_;  // inverse 0: held
  std::vector<Vector3d> positions_m_, previous_positions_m_, velocities_m_s_, previous_velocities_m_s_;
  std::vector<Vector3d> predicted_velocities_m_s_, accelerations_m_s2_;
  std::vector<NodeLanes> predicted_, corrections_;
  CellBatches batches_;
  std::vector<BatchGains> gains_[2];  // of first-order and second-order steps

  // The body as a whole, and what acted on it in this substep. Moments are about origin_m_.
  MassMotion motion_;
  Vector3d contact_impulse_ = Vector3d::Zero(), contact_moment_ = Vector3d::Zero();
  Vector3d ledger_momentum_ = Vector3d::Zero(), ledger_angular_ = Vector3d::Zero();

  std::vector<Touch> touches_;  // of this substep

  std::vector<const Collider*> reachable_;
  double reach_m_ = 0.0;        // radius about the centre that holds every node
  double deviation_m_s_ = 0.0;  // root mean square of velocities relative to the body as a whole
  bool first_step_ = true, strained_ = false, touching_ = false;
  bool supported_ = false, forced_ = false;  // for the sleep test: held up or in no gravity; pushed
  Eigen::Quaterniond orientation_;  // world from object, of the body as a whole
  RestClock rest_clock_;
};

}  // namespace livegs
