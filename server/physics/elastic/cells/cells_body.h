// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "physics/collision/point_contact.h"
#include "physics/elastic/cells/cell_batches.h"
#include "physics/elastic/cells/cell_nodes.h"
#include "physics/elastic/elastic_sleep_timer.h"
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/momentum.h"

// The `cells` solver: an embedded lattice of eight-node cells, one sweep per substep, BDF2. Its accuracy:
// server/physics/ACCURACY.md.
//
// One substep, in cells_step.cpp unless another file is given:
//   predict   velocities and positions by BDF2; damping; exact momentum of the whole body
//   regions   prescribed motion of held nodes; loads                            cells_regions.cpp
//   sweep     elasticity, cell by cell; corrections start at zero               kernels/cell_kernels.h
//   regions   held particles that are not fixed by their nodes                  cells_regions.cpp
//   contact   two-way, with rigid and elastic bodies                            cells_dynamic_contact.cpp
//             surface points against colliders, after elasticity, so that no    cells_contact.cpp
//             penetration remains
//   advance   velocity = predicted + corrections / h_e, never a difference of positions; momentum ledger
// Once per frame: energy limiter (cells_energy_limiter.cpp), detection of stuck contacts
// (cells_stuck_contacts.cpp), plastic flow (cells_plasticity.cpp), shape recovery (cells_shape_recovery.cpp)
// and sleep (cells_sleep.cpp).

namespace livegs {

// Strain |S - I|² of a cell, including bending, above which it is overstrained in contact or after plastic
// flow.
inline constexpr double kOverstrainSquared = 1.0;

class CellsBody final : public ElasticBody {
  using Vector3d = Eigen::Vector3d;
  using Matrix3d = Eigen::Matrix3d;
  using Quaterniond = Eigen::Quaterniond;

 public:
  // Precondition: make_elastic_body has checked the description.
  CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep);

  int begin_substep(const SubstepContext& context) override;
  void begin_step(const SubstepPart& part, const SubstepContext& context) override;
  void prepare_contact_step(double step_s) override;
  void list_contacts(const SubstepPart& part, const SubstepContext& context,
                     std::vector<ContactConstraint>& rows) override;
  void read_contact_impulses(std::span<const ContactConstraint> rows) override;
  void end_step(const SubstepPart& part, const SubstepContext& context) override;
  void end_substep(const SubstepContext& context) override;
  void end_frame(double frame_s) override;

  bool release_region(const std::string& name) override;
  void set_material(const Material& material) override;
  void set_node_substep_budget(double node_substeps) override;
  double node_substeps() const override { return resolution_.node_substeps; }
  const Material& material() const override { return material_; }
  bool asleep() const override { return sleep_timer_.asleep(); }
  int recovery_count() const override { return recovery_count_; }
  void wake() override;
  bool frozen() const override { return rigid_.has_value(); }

  RestBody rest_body() const override;
  void write_drivers(ObjectDrivers& drivers) const override;
  Pose centre_pose() const override;
  Vector3d centre_m() const override { return origin_m_ + motion_.centre_m; }
  double mass_kg() const override { return mass_kg_; }
  ContactTotal take_contact_total() override { return std::exchange(contact_total_, {}); }
  bool takes_springs() const override { return true; }
  double reach_m() const override { return reach_m_; }
  Eigen::AlignedBox3d bounds_m() const override;
  Eigen::AlignedBox3d surface_bounds_m(const Eigen::AlignedBox3d& within) const override;
  void prepare_for_contact() override { become_elastic(); }
  void surface_elements(const Eigen::AlignedBox3d& within,
                        std::vector<SurfaceElement>& elements) const override;
  double element_reach_m() const override;
  ContactAnchor anchor_at(uint32_t element, const Vector3d& point_m) const override;
  ContactParticipant& contact_participant() override { return *participant_; }
  bool is_separating(uint64_t body_id) const override;
  void apply_uniform_impulse(const Vector3d& impulse_n_s, double step_s) override;
  void defer_sleep(bool wait) override { sleep_timer_.defer(wait); }
  bool can_sleep() const override { return sleep_timer_.can_sleep(); }
  void sleep() override;
  Eigen::Vector3d velocity_m_s() const override;
  Eigen::Vector3d angular_velocity_rad_s() const override;
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const override;
  Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m,
                                 const Eigen::Vector3d& direction) const override;

 private:
  // A node with added mass (regularise_node_masses) and the heaviest node of its cells.
  struct LightNode {
    uint32_t node, parent;
    double added_mass_fraction;                            // added part of its mass
    Eigen::Vector3d parent_m_s = Eigen::Vector3d::Zero();  // velocity of the parent after the last step
  };
  // A region that holds or moves part of the body.
  struct ConstrainedRegion {
    BodyRegion region;
    std::vector<uint32_t> nodes;                         // held nodes
    std::vector<NodeSample> particles;                   // particles held individually
    std::vector<Vector3d> node_rest_m, particle_rest_m;  // object frame
    std::vector<uint32_t> particle_nodes;                // of `particles`
    std::vector<std::array<uint32_t, 8>> numbers;        // of each particle's nodes, in particle_nodes
    bool released = false;
  };
  void number_held_nodes(ConstrainedRegion& held) const;
  void hold_face(const ParticleSet& particles, ConstrainedRegion& held);
  struct Load {
    NodeSample sample;
    Vector3d force_n;  // world frame
    PointSpring* spring = nullptr;
    Vector3d from_m = Vector3d::Zero();  // position before the step
  };
  struct SurfaceCell {
    std::array<uint32_t, 8> nodes;
    uint32_t begin, end;         // range of surface_
    Eigen::AlignedBox3f points;  // bounds of these points, local coordinates
  };
  // The curvature about a surface point (SurfacePatch), lattice axes at rest.
  struct CurvedPatch {
    Eigen::Vector3f bulge = Eigen::Vector3f::Zero();
    Eigen::Matrix3f curvature = Eigen::Matrix3f::Zero(), flatten = Eigen::Matrix3f::Zero();
    float radius_m = 0.0f;  // mean of curvature
    float reach_m = 0.0f;   // 0: without curvature
    // How far the patch may reach beyond its point, against the other surface's normal.
    float lowest_m = 0.0f;
  };
  struct Ball {
    Vector3d centre_m;  // relative to the origin
    double radius_m;
  };
  struct Candidate {
    uint32_t cell, collider;
  };
  // The side of a collider that a surface point was on at its last contact.
  struct Side {
    uint32_t collider = UINT32_MAX;
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  };
  struct ColliderContact {
    uint32_t point;  // index in surface_
    NodeSample sample;
    Vector3d impulse_n_s;
  };
  struct DynamicContact {
    NodeSample sample;
    Vector3d impulse_n_s;
  };
  // Contacts of this body's points with another elastic body, found a few steps ago.
  struct ElasticContacts {
    uint64_t body_id = 0;
    double margin_m = 0.0;  // relative motion until they are found again
    int own_restarts = 0, other_restarts = 0;
    struct Point {
      uint32_t point;
      NodeSample own, other;  // material points that touch
      Vector3d normal;        // outward, of the other body
    };
    std::vector<Point> points;
  };
  // A contact with a body that pushes from opposite sides while the strain is far too large.
  struct StuckContact {
    uint64_t body_id = 0;
    // In this frame: sums of impulse magnitudes, impulses, magnitudes times points, and impulses dot points.
    double pushed_n_s = 0.0, apart = 0.0;
    Vector3d net_n_s = Vector3d::Zero(), moment = Vector3d::Zero();
    double stuck_s = 0.0;
    bool separating = false, overlaps = false;  // contact is off while separating, until no overlap remains
  };
  // State of a body that moves as a rigid body because it does not deform visibly.
  struct RigidMotion {
    Pose world_from_body;                  // pose of the frozen shape_m
    std::vector<Eigen::Vector3f> shape_m;  // nodes relative to the centre of mass
    PrincipalAxes axes;
    Matrix3d inverse_inertia;  // body axes
  };

  void set_up_materials();
  void choose(double cell_width_m);
  void set_masses();
  void set_moment_map();
  double density_of(const LatticeCell& cell) const;  // kg/m³, mean of its materials
  void regularise_node_masses();
  void damp_light_nodes(double step_s, const Eigen::Vector3d& gravity_m_s2);
  void rebuild_cells();
  void predict_accuracy();
  double asked_modulus_pa(size_t material) const;
  const GaussSeidelGains& gains_of(double h, bool second_order);
  void start_motion(const ElasticBodyDescription& description);
  std::vector<Eigen::Vector3d> node_velocities(std::span<const Eigen::Vector3d> velocities_m_s,
                                               const Eigen::Vector3d& rest_centre_m,
                                               const Eigen::Matrix3d& world_from_rest) const;
  void make_surface(const ParticleSet& particles);

  void hold_regions(const ElasticBodyDescription& description);
  void measure_held_reach();
  bool in_region(const LatticeCell& cell, const BodyRegion& region) const;
  void load_regions(const ElasticBodyDescription& description);
  Vector3d region_target_m(const ConstrainedRegion& held, const Vector3d& rest_m, double time_s) const;
  bool driven(double from_s, double to_s) const;  // whether a motion displaces anything in that time
  void move_regions(double time_s, double h);
  void hold_particles(double time_s);

  double step_of(double h) const { return second_order_ ? 2.0 * h / 3.0 : h; }  // h_e
  void predict(double h, const SubstepContext& context);
  void advance(double h);
  void measure(const NodeSums& sums, double h);
  Matrix3d moment_map_now() const;
  Matrix3d centrifugal_correction() const;
  // Sets the inertia of the material, and the angular momentum with the spin of the nodes.
  void use_material_inertia();
  // Angular momentum of the material for that of the nodes.
  Vector3d material_angular(const Vector3d& of_nodes) const {
    return motion_.inertia * solve_inertia(node_inertia_, of_nodes);
  }

  void gather_point_loads(const SubstepContext& context);
  void solve_springs(const SubstepPart& part);
  double grip_factor(const NodeSample& sample) const;  // 0 ... 1, factor on the force of a hand at this point
  bool in_impact(const SubstepContext& context);
  // How far the patch of a surface point may reach beyond it.
  double patch_depth_m(uint32_t i) const { return patches_.empty() ? 0.0 : patches_[i].lowest_m; }
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
  template <class Visit>
  void visit_cells_near(const RigidProxy& body, double margin_m, const Visit& visit) const;
  void record_contact_impulse(const Vector3d& point_m, double impulse_n_s);
  bool may_touch_awake(const SubstepContext& context) const;
  double max_node_speed_m_s() const;  // bound for nearly all nodes
  void find_rigid_candidates(const SubstepContext& context);
  void collide_surface_with_rigid(ContactParticipant& participant, const SubstepContext& context,
                                  std::vector<ContactConstraint>& rows);
  void collide_rigid_points(RigidProxy& body, ContactParticipant& participant,
                            std::vector<ContactConstraint>& rows);
  void find_elastic_contacts(CellsBody& other, double h, ElasticContacts& contacts);
  void collide_surface_with_elastic(const ElasticNeighbour& neighbour, double h,
                                    std::vector<ContactConstraint>& rows);
  // cells_stuck_contacts.cpp
  StuckContact& stuck_contact(uint64_t body_id);
  bool is_separating() const;  // from any body
  void update_stuck_contacts(double frame_s);
  void separate(const SubstepPart& part, const SubstepContext& context, size_t begin,
                std::vector<ContactConstraint>& rows);
  // cells_rolling_resistance.cpp: on colliders, by collider_contacts_ from `first_contact` on; then on
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
  // After nodes were set: recomputes the motion of the body; the next step is first order.
  void restart_motion();
  bool rigid_substep(const SubstepContext& context);
  void become_rigid();
  void become_elastic();
  void place_rigid();
  void rest(double frame_s);
  bool is_stationary(double frame_s);
  bool is_jittering(double seen_m_s, double frame_s);
  bool has_finite_motion() const;
  bool limit_energy();
  void restore_last_valid_state();
  // At least exact enough to compare with still_m_s.
  double fastest_m_s(double still_m_s) const;

  NodeSample sample_at(const EmbeddedPoint& point) const;
  Vector3d velocity_of(const NodeSample& sample) const;
  std::vector<Matrix3d> node_gradients() const;
  void match_momentum(std::vector<ParticleState>& states) const;
  Vector3d node_velocity(size_t node) const;  // with the correction of the momentum ledger
  double mobility(const NodeSample& sample) const;
  bool free() const { return !held_; }
  double damping_rate() const;
  double lowest_rate_rad_s() const;  // of the vibrations
  void update_carried_load(const SubstepPart& part);

  Material material_;
  CellsOptions options_;
  Lattice lattice_;
  NodeNeighboursPtr neighbours_;  // of the nodes, for the sender
  BodyExtent extent_;
  std::vector<Vector3d> particle_rest_m_;
  std::vector<double> particle_volumes_m3_;
  std::vector<EmbeddedPoint> particle_points_;
  std::vector<RegionMaterial> region_materials_;
  std::vector<std::string> region_names_;  // of region_materials_
  CellMaterials cell_materials_;
  std::vector<double> densities_kg_m3_, plasticities_;  // by material
  double volume_m3_ = 0.0, mass_kg_ = 0.0;
  uint32_t object_id_;

  double rate_hz_;
  int scene_substeps_, given_substeps_;  // per frame; the second 0: chosen
  // Per frame; the first is infinite if the cell width was given.
  double max_node_substeps_, scene_node_substeps_;
  LatticeResolution resolution_;
  std::optional<LatticeResolution> unbudgeted_;  // set if the scene's budget limits the body
  std::vector<ModulusBand> bands_;               // by material, of the simulated moduli
  double thin_part_ = 0.0;                       // as ElasticAccuracy::thin_part

  CellNodes nodes_;
  std::vector<double> masses_kg_, inverse_masses_;  // inverse 0: held
  std::vector<LightNode> light_nodes_;
  Vector3d origin_m_ = Vector3d::Zero();  // origin of the node positions
  CellBatches batches_;
  // Gains for steps of one length, by order (first, second); computed on first use.
  struct StepGains {
    double step_s = 0.0;  // h; 0: none
    std::optional<GaussSeidelGains> of_order[2];
  };
  // Gains for the body's own steps, for impact steps, and for the last other step length, imposed by
  // neighbours.
  StepGains own_gains_, impact_gains_, neighbour_gains_;
  double last_step_s_ = 0.0;  // h; 0: none, or the cells have changed
  // As batches_.cut and .thin; empty until plastic flow occurs.
  std::vector<PlasticCells> plastic_, thin_plastic_;
  std::vector<Matrix3d> plastic_parts_;                          // by cell
  std::vector<std::array<Vector3d, kModeCount>> plastic_modes_;  // rest amplitudes, rotated frame
  double plastic_work_j_ = 0.0;

  Pose world_from_object_;  // initial pose, for regions
  std::vector<ConstrainedRegion> constrained_regions_;
  std::vector<Load> region_loads_, point_loads_;
  bool held_ = false;            // part of the body is fixed or has a prescribed motion
  double held_reach_m_ = 0.0;    // from the held nodes to the farthest free one
  bool moved_ = false;           // part of the body has a prescribed motion
  bool boundary_moved_ = false;  // the whole boundary has a prescribed motion at the start

  // Motion of the whole body, and the impulses on it in this substep. Moments are about the origin. Its
  // inertia is that of the material, not of the nodes, and its angular momentum is inertia times spin.
  BodyMomentum motion_;
  Matrix3d node_inertia_ = Matrix3d::Zero();  // of the nodes as point masses, about the centre
  double moment_map_share_ =
      1.0;  // 1 ... 0 as the strain grows from half to all of that of first-order steps
  Matrix3d moment_map_ =
      Matrix3d::Identity();  // object frame, at rest; takes the moments of the nodes to the material's
  Quaterniond step_orientation_ = Quaterniond::Identity();  // orientation_ at the current step
  // From the previous velocities, at the current positions.
  Vector3d momentum_before_ = Vector3d::Zero(), angular_before_ = Vector3d::Zero();
  // Of the nodes, by the momentum ledger.
  Vector3d velocity_correction_ = Vector3d::Zero(), spin_correction_ = Vector3d::Zero();
  ContactTotal contact_total_;
  Vector3d contact_impulse_ = Vector3d::Zero(), contact_moment_ = Vector3d::Zero();
  Vector3d between_steps_impulse_ = Vector3d::Zero();  // received between the last step and this one
  // Lag of the centre of mass behind the contact impulses.
  Vector3d contact_lag_m_ = Vector3d::Zero();
  Vector3d ledger_momentum_ = Vector3d::Zero(), ledger_angular_ = Vector3d::Zero();

  std::vector<NodeSample> surface_;  // grouped by cell
  std::vector<float> surface_mobility_;
  std::vector<CurvedPatch> patches_;  // by surface_ index; empty if the whole surface is flat
  std::vector<SurfaceCell> surface_cells_;
  std::vector<Candidate> candidates_;
  double candidate_margin_m_ = 0.0;  // remaining motion of any node before a new search
  size_t candidate_colliders_ = 0;
  std::vector<ColliderContact> collider_contacts_;  // of this step
  std::vector<Side> sides_;                         // by surface_ index; empty until a collider is near
  double step_contact_n_s_ = 0.0;                   // sum of impulse magnitudes in this step
  double pressed_n_ = 0.0;                          // sum of the contact forces, moving average
  double carried_n_ = 0.0;  // force passed through the body between contacts, moving average
  std::vector<Eigen::Vector3f> surface_local_;  // local coordinates of surface_
  std::vector<uint32_t> face_begins_;           // first face of each surface_ point, and the end
  std::vector<Eigen::Vector3f> face_normals_;   // outward, lattice axes
  std::vector<Candidate> rigid_candidates_;     // with rigid bodies
  std::vector<uint64_t> rigid_candidate_ids_;   // ids at the time of the search
  double rigid_candidate_margin_m_ = 0.0;
  // By surface_ index: the contact force of the last step that listed contacts, from which the next solve
  // starts.
  struct LastForce {
    uint64_t body_id = 0, step = 0;
    Eigen::Vector3f friction_n = Eigen::Vector3f::Zero();
    float normal_n = 0.0f;
  };
  std::vector<ElasticContacts> elastic_contacts_;
  int restarts_ = 0;  // of the motion; contacts found before are void
  std::vector<LastForce> last_forces_;
  uint64_t contact_step_ = 0;
  double contact_step_s_ = 0.0;
  void start_from_last_force(ContactConstraint& row) const;
  std::vector<DynamicContact> dynamic_contacts_;  // of this step, with moving bodies

  std::vector<StuckContact> stuck_contacts_;  // ascending id

  double reach_m_ = 0.0;        // radius about the centre of mass that encloses every node
  double kinetic_j_ = 0.0;      // of the last step
  double deviation_m_s_ = 0.0;  // root mean square velocity relative to the rigid motion
  double spin_rad_s_ = 0.0;     // of the whole body
  double strain_squared_ = 0.0, bent_squared_ = 0.0;  // largest over the cells
  // Boxes of surface_cells_ and of all of them, at the current node positions; valid if boxes_known_.
  mutable std::vector<Eigen::AlignedBox3d> cell_boxes_;
  mutable Eigen::AlignedBox3d surface_box_;
  mutable bool boxes_known_ = false;
  std::unique_ptr<ContactParticipant> participant_;
  bool second_order_ = false, is_slow_ = false, in_step_ = false;  // of the current step
  bool first_step_ = true, strained_ = false, degenerate_ = false, recovering_ = false, touching_ = false,
       backward_ = false;
  double gravity_m_s2_ = 0.0;  // of the last substep
  Vector3d gravity_ = Vector3d::Zero();
  // Energy limiter: upper bound of the energy while badly strained, work of hands and moving bodies in this
  // frame, and whether there was contact in the last frame.
  std::optional<double> energy_limit_j_;
  double work_j_ = 0.0;
  bool touched_last_frame_ = false;
  double impact_until_s_ = -1.0;
  // For the sleep test: supported or without gravity; loaded; moved by a region.
  bool supported_ = false, forced_ = false, driven_ = false;
  Quaterniond orientation_;  // of the whole body, world from object
  Pose whole_;               // of the whole body, after the last frame with finite motion
  int recovery_count_ = 0;   // number of resets
  std::optional<RigidMotion> rigid_;
  double unstrained_time_s_ = 0.0, degenerate_s_ = 0.0;
  int recovered_count_ = 0;  // number of shape recoveries
  // Reference position of the centre of mass for stationary_s_.
  Vector3d stationary_at_m_ = Vector3d::Constant(INFINITY);
  double stationary_s_ = 0.0;
  // By surface_ index; reference points of the last jitter_time_s_; empty if all points are still, or the
  // body moves.
  std::vector<Vector3d> jitter_origin_m_;
  double jitter_time_s_ = 0.0;
  bool may_rest_;
  SleepTimer sleep_timer_;
};

}  // namespace livegs
