// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/elastic/cells/cells_state.h"
#include "physics/elastic_body.h"

// The `cells` solver: an embedded lattice of eight-node cells, one sweep per substep, BDF2. Its accuracy:
// server/physics/ACCURACY.md; the phases of a step: ../README.md.

namespace livegs::cells {

class CellsBody final : public ElasticBody, public FlatBody {
 public:
  // Precondition: make_elastic_body has checked the description.
  CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep);

  int begin_substep(const SubstepContext& context) override;
  void begin_step(const SubstepPart& part, const SubstepContext& context) override;
  void prepare_contact_step(double step_s) override;
  void list_contacts(const SubstepPart& part, const SubstepContext& context,
                     std::vector<ContactConstraint>& rows) override;
  void separate(const SubstepPart& part, const SubstepContext& context,
                std::vector<ContactConstraint>& rows) override;
  void read_contact_impulses(std::span<const ContactConstraint> rows) override;
  void end_step(const SubstepPart& part, const SubstepContext& context) override;
  void end_substep(const SubstepContext& context) override;
  void end_frame(double frame_s) override;

  bool release_region(const std::string& name) override;
  void set_material(const Material& material) override;
  void set_node_substep_budget(double node_substeps) override;
  double node_substeps() const override { return accuracy_.resolution.node_substeps; }
  const Material& material() const override { return materials_.own; }
  bool asleep() const override { return rest_.sleep_timer.asleep(); }
  int recovery_count() const override { return recovery_count_; }
  bool place(const Pose& world_from_object, const Vector3d& velocity_m_s,
             const Vector3d& angular_velocity_rad_s) override;
  void wake() override;
  bool frozen() const override { return rest_.rigid.has_value(); }

  RestBody rest_body() const override;
  void write_drivers(ObjectDrivers& drivers) const override;
  Pose centre_pose() const override;
  Vector3d centre_m() const override { return origin_m_ + ledger_.motion.centre_m; }
  double mass_kg() const override { return mass_kg_; }
  ContactTotal take_contact_total() override { return std::exchange(loads_.contact_total, {}); }
  bool takes_springs() const override { return true; }
  double reach_m() const override { return reach_m_; }
  AlignedBox3d bounds_m() const override;
  void prepare_bounds() override;
  AlignedBox3d surface_bounds_m(const AlignedBox3d& within) const override;
  void prepare_for_contact() override { become_elastic(); }
  void surface_elements(const AlignedBox3d& within, std::vector<SurfaceElement>& elements) const override;
  double element_reach_m() const override;
  ContactAnchor anchor_at(uint32_t element, const Vector3d& point_m) const override;
  ContactParticipant& contact_participant() override { return *participant_; }
  bool is_separating(uint64_t body_id) const override;
  void apply_uniform_impulse(const Vector3d& impulse_n_s, double step_s) override;
  void defer_sleep(bool wait) override { rest_.sleep_timer.defer(wait); }
  bool can_sleep() const override { return rest_.sleep_timer.can_sleep(); }
  void sleep() override;
  Vector3d velocity_m_s() const override;
  Vector3d angular_velocity_rad_s() const override;
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Vector3d world_point(const Vector3d& rest_point_m) const override;
  Vector3d point_velocity_m_s(const Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Vector3d& origin_m, const Vector3d& direction) const override;

  uint64_t flat_revision() const override { return flat_revision_; }
  size_t flat_node_count() const override { return nodes_.count(); }
  int flat_steps() const override { return accuracy_.resolution.substeps; }
  const char* flat_obstacle() const override;
  void write_flat(FlatLattice& lattice) override;
  const char* begin_flat_tick(const FlatTick& tick, FlatState& state) override;
  void end_flat_tick(const FlatTick& tick, const FlatState& state) override;

 private:
  struct Ball {
    Vector3d centre_m;  // relative to the origin
    double radius_m;
  };

  void number_held_nodes(ConstrainedRegion& held) const;
  void hold_face(const ParticleSet& particles, ConstrainedRegion& held);

  void set_up_materials();
  void choose(double cell_width_m);
  void normalise_densities();
  void set_masses();
  void set_moment_map();
  double density_of(const LatticeCell& cell) const;  // kg/m³, mean of its materials
  void regularise_node_masses();
  void rebuild_cells();
  void predict_accuracy();
  double material_friction(size_t material) const;
  double friction_at(
      uint32_t point) const;  // of a surface point: that of its cell's materials by their shares
  double max_friction() const;
  const GaussSeidelGains& gains_of(double h, bool second_order);
  void start_motion(const ElasticBodyDescription& description);
  std::vector<Vector3d> node_velocities(std::span<const Vector3d> velocities_m_s,
                                        const Vector3d& rest_centre_m, const Matrix3d& world_from_rest) const;
  void make_surface(const std::vector<SurfacePatch>& patches);

  void hold_node(ConstrainedRegion& held, uint32_t node);
  void hold_regions(const ElasticBodyDescription& description);
  void measure_held_reach();
  bool in_region(const LatticeCell& cell, const BodyRegion& region) const;
  void load_regions(const ElasticBodyDescription& description);
  Vector3d region_target_m(const ConstrainedRegion& held, const Vector3d& rest_m, double time_s) const;
  bool driven(double from_s, double to_s) const;  // whether a motion displaces anything in that time
  void move_regions(double time_s, double h);
  void hold_particles(double time_s);

  double slow_speed_m_s(const Vector3d& gravity_m_s2) const;                         // kMaxSlowSpeedRatio
  double step_of(double h) const { return step_.second_order ? 2.0 * h / 3.0 : h; }  // h_e
  void predict(double h, const SubstepContext& context);
  void advance(double h);
  void measure(const NodeSums& sums, double h);
  bool has_material_inertia() const;
  Matrix3d moment_map_now() const;
  Matrix3d centrifugal_correction() const;
  // Sets the inertia of the material, and the angular momentum with the spin of the nodes.
  void use_material_inertia();
  // Angular momentum of the material for that of the nodes.
  Vector3d material_angular(const Vector3d& of_nodes) const {
    return ledger_.motion.inertia * solve_inertia(ledger_.node_inertia, of_nodes);
  }

  void gather_point_loads(const SubstepContext& context);
  void solve_springs(const SubstepPart& part);
  double grip_factor(const NodeSample& sample) const;  // 0 ... 1, factor on the force of a hand at this point
  bool in_impact(const SubstepContext& context);
  // How far the patch of a surface point may reach beyond it.
  double patch_depth_m(uint32_t i) const {
    return surface_.patches.empty() ? 0.0 : surface_.patches[i].lowest_m;
  }
  // The material point at which a surface point's patch touches a surface with the outward normal `normal`.
  NodeSample touching_sample(uint32_t i, const Vector3d& normal) const;
  Ball ball_around(const SurfaceCell& cell) const;
  void find_candidates(const SubstepContext& context);
  void resolve_colliders(double step_s, const SubstepContext& context);

  // cells_dynamic_contact.cpp
  class Participant;
  Vector3d place_now_m(const NodeSample& sample) const;  // as node_now
  Vector3d node_now(uint32_t node) const;                // world frame; during a step the corrected position
  void list_boxes() const;
  void push_anchor(const ContactAnchor& anchor, const Vector3d& point_m, const Vector3d& impulse_n_s);
  void settle_anchor(const ContactAnchor& anchor, const Vector3d& point_m, const Vector3d& impulse_n_s);
  void record_contact_impulse(const Vector3d& point_m, double impulse_n_s);
  double node_speed_m_s() const;  // relative to the centre of mass: a bound for nearly all nodes
  void start_from_last_force(ContactConstraint& row) const;
  void find_elastic_contacts(CellsBody& other, double h, ElasticContacts& contacts);
  void collide_surface_with_elastic(CellsBody& other, double h, ElasticContacts& contacts,
                                    std::vector<ContactConstraint>& rows);
  // cells_rigid_contact.cpp
  template <class Visit>
  void visit_cells_near(const RigidProxy& body, double margin_m, const Visit& visit) const;
  bool may_touch_awake(const SubstepContext& context) const;
  void find_rigid_candidates(const SubstepContext& context, double speed_m_s);
  std::vector<char> update_rigid_contacts(const SubstepPart& part, const SubstepContext& context);
  void collide_surface_with_rigid(const SubstepContext& context, std::vector<ContactConstraint>& rows);
  void find_rigid_contacts(RigidProxy& body, RigidContacts& contacts);
  bool folds_on(const RigidProxy& body) const;
  void collide_rigid_points(RigidProxy& body, const RigidContacts& contacts,
                            std::vector<ContactConstraint>& rows);
  // cells_stuck_contacts.cpp
  StuckContact& stuck_contact(uint64_t body_id);
  bool is_separating() const;  // from any body
  void update_stuck_contacts(double frame_s);
  void record_push(const ContactImpulse& impulse);
  // cells_rolling_resistance.cpp: on colliders, by colliders_.contacts from `first_contact` on; then on
  // bodies.
  void apply_rolling_resistance(size_t first_contact, double step_s);
  void apply_rolling_resistance(std::span<const ContactConstraint> rows);
  double plane_strain_modulus_pa() const;  // of the body's own material, as simulated
  void apply_collider_contact(uint32_t index, const NodeSample& sample, const Vector3d& point_m,
                              const Vector3d& pull_kg_m, double step_s);

  struct CellShape {
    Matrix3d f, rotation;
    std::array<Vector3d, kModeCount> modes;
  };
  CellShape unturned_shape_of(size_t index) const;
  void turn(size_t index, CellShape& shape) const;
  CellShape shape_of(size_t index) const;
  double energy_of(size_t index, const CellShape& shape) const;
  void flow();
  void begin_plastic();
  void discard_plastic_flow();
  void set_all_plastic();
  void set_plastic_lanes(size_t index);
  void recover_shape(double frame_s);
  double elastic_j() const;
  double elastic_f32_j() const;  // in single precision for most cells
  double overstrained_volume_fraction() const;
  double thickness_m() const;
  BodyMomentum node_motion() const;  // of the nodes as point masses
  // After nodes were set: recomputes the motion of the body; the next step is first order.
  void restart_motion();
  bool rigid_substep(const SubstepContext& context);
  void become_rigid();
  void become_elastic();
  void place_rigid();
  void rest(double frame_s);
  bool is_stationary(double frame_s);
  bool has_finite_motion() const;
  bool limit_energy();
  void restore_last_valid_state();
  Vector3d rest_centre_m() const;  // centre of mass, object frame
  // All nodes at the rest shape, with the motion of a rigid body; clears flow, contacts and loads.
  void set_rest_shape(const Pose& world_from_object, const Vector3d& velocity_m_s,
                      const Vector3d& angular_velocity_rad_s);
  bool has_moved(double distance_m);

  NodeSample sample_at(const EmbeddedPoint& point) const;
  Vector3d velocity_of(const NodeSample& sample) const;
  std::vector<Matrix3d> node_gradients() const;
  void match_momentum(std::vector<ParticleState>& states) const;
  Vector3d node_velocity(size_t node) const;  // with the correction of the momentum ledger
  double mobility(const NodeSample& sample) const;
  bool free() const { return !holding_.held; }
  Vector3d size_m() const { return extent_.max_m - extent_.min_m; }
  double damping_rate() const;
  double lowest_rate_rad_s() const;  // of the vibrations
  void update_carried_load(const SubstepPart& part);

  CellsOptions options_;
  uint32_t object_id_;
  Lattice lattice_;
  NodeNeighboursPtr neighbours_;  // of the nodes, for the sender
  BodyExtent extent_;
  std::vector<Vector3d> particle_rest_m_;
  std::vector<double> particle_volumes_m3_;
  std::vector<EmbeddedPoint> particle_points_;
  double volume_m3_ = 0.0, mass_kg_ = 0.0;

  CellNodes nodes_;
  std::vector<double> masses_kg_, inverse_masses_;  // inverse 0: held
  CellBatches batches_;
  Vector3d origin_m_ = Vector3d::Zero();  // origin of the node positions
  double reach_m_ = 0.0;                  // radius about the centre of mass that encloses every node
  Quaterniond orientation_;               // of the whole body, world from object
  Pose whole_;                            // of the whole body, after the last frame with finite motion
  int recovery_count_ = 0;                // number of resets
  uint64_t flat_revision_ = 0;            // unique for each rebuild of the cells

  Materials materials_;
  Accuracy accuracy_;
  Gains gains_;
  Plasticity plastic_;
  Holding holding_;
  Loads loads_;
  MomentumLedger ledger_;
  Surface surface_;
  ColliderContacts colliders_;
  BodyContacts bodies_;
  StepState step_;
  EnergyLimiter limiter_;
  ShapeRecovery recovery_;
  Rest rest_;
  std::unique_ptr<ContactParticipant> participant_;
};

}  // namespace livegs::cells
