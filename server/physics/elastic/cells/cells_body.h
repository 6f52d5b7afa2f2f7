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
#include "physics/elastic/resolution/lattice_resolution.h"
#include "physics/elastic_body.h"
#include "physics/lattice/lattice.h"
#include "physics/motion/free_rotation.h"
#include "physics/motion/momentum.h"
#include "physics/motion/sleep_timer.h"

// The `cells` solver: an embedded lattice of eight-node cells, one sweep a substep, BDF2 (elastic-study.md).
//
// One substep, in cells_step.cpp unless said:
//   predict   velocities and positions by BDF2; damping; the momentum of the body as a whole is set exactly
//   regions   nodes of moved regions go where they are told; loads push              cells_regions.cpp
//   sweep     elasticity, cell by cell, into corrections that start at zero          cell_kernels.h
//   regions   particles of held regions that their nodes do not already hold
//   contact   with rigid and elastic bodies that move, both ways                     cells_touch.cpp
//             surface points against colliders; after elasticity, so that nothing is cells_contact.cpp
//             left inside
//   advance   velocity = predicted + corrections / h_e, never a difference of positions; momentum ledger
// Once a frame: plastic flow (cells_flow.cpp), the body's own untangling (cells_untangle.cpp), whether it
// is stuck on another (cells_impaled.cpp) and rest (cells_rest.cpp).

namespace livegs {

class CellsBody final : public ElasticBody {
  using Vector3d = Eigen::Vector3d;
  using Matrix3d = Eigen::Matrix3d;
  using Quaterniond = Eigen::Quaterniond;

 public:
  // Preconditions: a description that make_elastic_body has checked.
  CellsBody(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep);

  int begin_substep(const SubstepContext& context) override;
  void begin_step(const SubstepPart& part, const SubstepContext& context) override;
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
  ContactParticipant& contact_participant(double step_s) override;
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
  // A node with more mass than its own (regularise_node_masses), and the heaviest near.
  struct LightNode {
    uint32_t node, parent;
    double added_mass_fraction;                            // part of its mass
    Eigen::Vector3d parent_m_s = Eigen::Vector3d::Zero();  // after the last step
  };
  // A region that holds or moves some of the body.
  struct ConstrainedRegion {
    BodyRegion region;
    std::vector<uint32_t> nodes;                         // that it holds
    std::vector<NodeSample> particles;                   // that it holds by themselves
    std::vector<Vector3d> node_rest_m, particle_rest_m;  // object frame
    bool released = false;
  };
  void hold_face(const ParticleSet& particles, ConstrainedRegion& held);
  struct Load {
    NodeSample sample;
    Vector3d force_n;  // world
    PointSpring* spring = nullptr;
    Vector3d from_m = Vector3d::Zero();  // where it was before the step
  };
  struct SurfaceCell {
    std::array<uint32_t, 8> nodes;
    uint32_t begin, end;         // surface_
    Eigen::AlignedBox3f points;  // in the cell, of those
  };
  struct Ball {
    Vector3d centre_m;  // from the origin
    double radius_m;
  };
  struct Candidate {
    uint32_t cell, collider;
  };
  struct Side {  // of a collider, that a surface point was on when it last touched it
    uint32_t collider = UINT32_MAX;
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  };
  struct ColliderContact {
    uint32_t sample;  // surface_
    Vector3d impulse_n_s;
  };
  struct DynamicContact {
    NodeSample sample;
    Vector3d impulse_n_s;
  };
  // A body whose contact pushes this one from opposite sides while it is strained beyond all proportion.
  struct StuckContact {
    uint64_t body_id = 0;
    // In this frame: sizes of impulses and their sum, sizes and impulses times points.
    double pushed_n_s = 0.0, apart = 0.0;
    Vector3d net_n_s = Vector3d::Zero(), moment = Vector3d::Zero();
    double stuck_s = 0.0;
    bool separating = false, overlaps = false;  // no contact with it until they no longer overlap
  };
  // A body that flies without deforming visibly moves as a rigid one.
  struct RigidMotion {
    Pose world_from_body;                  // of the shape frozen in shape_m
    std::vector<Eigen::Vector3f> shape_m;  // nodes about the centre of mass
    PrincipalAxes axes;
    Matrix3d inverse_inertia;  // body axes
  };

  void set_up_materials();
  void choose(double cell_width_m);
  void set_masses();
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
  bool in_region(const LatticeCell& cell, const BodyRegion& region) const;
  void load_regions(const ElasticBodyDescription& description);
  Vector3d region_target_m(const ConstrainedRegion& held, const Vector3d& rest_m, double time_s) const;
  bool driven(double from_s, double to_s) const;  // whether a motion moves anything in that time
  void move_regions(double time_s, double h);
  void hold_particles(double time_s);

  double step_of(double h) const { return second_order_ ? 2.0 * h / 3.0 : h; }  // h_e
  void predict(double h, const SubstepContext& context);
  void advance(double h);
  void measure(const NodeSums& sums, double h);

  void gather_point_loads(const SubstepContext& context);
  void solve_springs(const SubstepPart& part);
  double grip_factor(const NodeSample& sample) const;  // 0 ... 1, of the force of a hand that holds it there
  bool in_impact(const SubstepContext& context);
  Ball ball_around(const SurfaceCell& cell) const;
  void find_candidates(const SubstepContext& context);
  void resolve_colliders(double step_s, const SubstepContext& context);

  // cells_touch.cpp
  class Participant;
  Vector3d node_now(uint32_t node) const;  // world; in the middle of a step where it has come to
  void list_boxes() const;
  void push_anchor(const ContactAnchor& anchor, const Vector3d& point_m, const Vector3d& impulse_n_s);
  void settle_anchor(const ContactAnchor& anchor, const Vector3d& point_m, const Vector3d& impulse_n_s);
  template <class Visit>
  void visit_cells_near(const RigidProxy& body, double margin_m, const Visit& visit) const;
  void record_contact_impulse(const Vector3d& point_m, double impulse_n_s);
  bool may_touch_awake(const SubstepContext& context) const;
  double max_node_speed_m_s() const;  // no node is faster, but for few
  void find_rigid_candidates(const SubstepContext& context);
  void collide_surface_with_rigid(ContactParticipant& participant, const SubstepContext& context,
                                  std::vector<ContactConstraint>& rows);
  void collide_rigid_points(RigidProxy& body, ContactParticipant& participant,
                            std::vector<ContactConstraint>& rows);
  void collide_surface_with_elastic(const ElasticNeighbour& other, ContactParticipant& participant, double h,
                                    std::vector<ContactConstraint>& rows);
  // cells_impaled.cpp
  StuckContact& stuck_contact(uint64_t body_id);
  bool is_separating() const;  // any
  void update_stuck_contacts(double frame_s);
  void separate(const SubstepPart& part, const SubstepContext& context, size_t begin,
                std::vector<ContactConstraint>& rows);
  // By what it touches from this one of collider_contacts_ on, which does not move.
  void apply_rolling_resistance(size_t first_contact, double step_s);
  void apply_rolling_resistance(std::span<const ContactConstraint> rows);
  void apply_collider_contact(uint32_t sample, const Vector3d& point_m, const Vector3d& pull_kg_m,
                              double step_s);

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
  double elastic_f32_j() const;  // in single precision where most cells are
  double overstrained_volume_fraction() const;
  double thickness_m() const;
  void restart_motion();  // after nodes were set: the motion of the whole anew, a first-order step next
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
  double fastest_m_s(
      double still_m_s) const;  // or as much as tells that it is faster, or slower, than still_m_s

  NodeSample sample_at(const EmbeddedPoint& point) const;
  Vector3d velocity_of(const NodeSample& sample) const;
  Vector3d node_velocity(size_t node) const;  // with what the ledger owes
  double mobility(const NodeSample& sample) const;
  bool free() const { return !held_; }
  double damping_rate() const;
  double lowest_rate_rad_s() const;  // of its vibrations
  void update_carried_load(const SubstepPart& part);

  Material material_;
  CellsOptions options_;
  Lattice lattice_;
  NodeNeighboursPtr neighbours_;  // of its nodes, for who sends them
  BodyExtent extent_;
  std::vector<Vector3d> particle_rest_m_;
  std::vector<double> particle_volumes_m3_;
  std::vector<EmbeddedPoint> particle_points_;
  std::vector<RegionMaterial> region_materials_;
  std::vector<std::string> region_names_;  // of those
  CellMaterials cell_materials_;
  std::vector<double> densities_kg_m3_, plasticities_;  // by material
  double volume_m3_ = 0.0, mass_kg_ = 0.0;
  uint32_t object_id_;

  double rate_hz_;
  int scene_substeps_;
  double max_node_substeps_, scene_node_substeps_;  // a frame; the first is infinite where cells were given
  LatticeResolution resolution_;
  std::optional<LatticeResolution> unbudgeted_;  // where the scene's budget left it less than this
  std::vector<ModulusBand> bands_;               // by material, of what is simulated
  double thin_part_ = 0.0;                       // ElasticAccuracy

  CellNodes nodes_;
  std::vector<double> masses_kg_, inverse_masses_;  // inverse 0: held
  std::vector<LightNode> light_nodes_;
  Vector3d origin_m_ = Vector3d::Zero();  // of the nodes' positions
  CellBatches batches_;
  // What steps of one length multiply by, first-order and second-order ones; each made when it is first asked
  // for.
  struct StepGains {
    double step_s = 0.0;  // h; 0: none
    std::optional<GaussSeidelGains> of_order[2];
  };
  // Of its own steps, of those while it is struck, and of those that it last took beside bodies that need
  // others.
  StepGains own_gains_, impact_gains_, neighbour_gains_;
  double last_step_s_ = 0.0;  // h; 0: none, or its cells were others
  std::vector<PlasticCells> plastic_,
      thin_plastic_;                     // as batches_.cut and .thin; empty while nothing has flowed
  std::vector<Matrix3d> plastic_parts_;  // by cell
  std::vector<std::array<Vector3d, kModeCount>> plastic_modes_;  // amplitudes at rest, turned frame
  double plastic_work_j_ = 0.0;

  Pose world_from_object_;  // at the start, for regions
  std::vector<ConstrainedRegion> constrained_regions_;
  std::vector<Load> region_loads_, point_loads_;
  bool held_ = false;            // some of it does not move, or moves as it is told
  bool moved_ = false;           // as it is told
  bool boundary_moved_ = false;  // all of its outside is, at first

  // The body as a whole, and what acted on it in this substep. Moments are about the origin.
  BodyMomentum motion_;
  Vector3d momentum_before_ = Vector3d::Zero(),
           angular_before_ = Vector3d::Zero();  // of the last velocities, here
  Vector3d velocity_correction_ = Vector3d::Zero(),
           spin_correction_ = Vector3d::Zero();  // to the nodes, by the ledger
  ContactTotal contact_total_;
  Vector3d contact_impulse_ = Vector3d::Zero(), contact_moment_ = Vector3d::Zero();
  Vector3d between_steps_impulse_ = Vector3d::Zero();  // got between the last step and this one
  Vector3d contact_lag_m_ =
      Vector3d::Zero();  // how far the centre of mass is behind what contact impulses say
  Vector3d ledger_momentum_ = Vector3d::Zero(), ledger_angular_ = Vector3d::Zero();

  std::vector<NodeSample> surface_;  // by cell
  std::vector<float> surface_mobility_;
  std::vector<SurfaceCell> surface_cells_;
  std::vector<Candidate> candidates_;
  double candidate_margin_m_ = 0.0;  // how far any node may still go before they are found anew
  size_t candidate_colliders_ = 0;
  std::vector<ColliderContact> collider_contacts_;  // of this step
  std::vector<Side> sides_;                         // of surface_; empty before anything is near
  double step_contact_n_s_ = 0.0;                   // sizes of impulses of this step
  double carried_n_ = 0.0;  // force that goes through the body from one contact to another, a mean
  std::vector<Eigen::Vector3f> surface_local_;  // of surface_: in its cell
  std::vector<uint32_t> face_begins_;           // of surface_, and the end: its faces
  std::vector<Eigen::Vector3f> face_normals_;   // outwards, lattice axes
  std::vector<Candidate> rigid_candidates_;     // with rigid bodies
  std::vector<uint64_t> rigid_candidate_ids_;   // of those, as they were found
  double rigid_candidate_margin_m_ = 0.0;
  std::vector<DynamicContact> dynamic_contacts_;  // of this step, with what moves

  std::vector<StuckContact> stuck_contacts_;  // ascending id

  double reach_m_ = 0.0;        // radius about the centre that holds every node
  double kinetic_j_ = 0.0;      // of the last step
  double deviation_m_s_ = 0.0;  // root mean square of velocities relative to the body as a whole
  double spin_rad_s_ = 0.0;     // of the body as a whole
  double strain_squared_ = 0.0, bent_squared_ = 0.0;  // of the worst cell
  // Of surface_cells_ and all of them, with what rides outside; as the nodes are now, where they are known.
  mutable std::vector<Eigen::AlignedBox3d> cell_boxes_;
  mutable Eigen::AlignedBox3d surface_box_;
  mutable bool boxes_known_ = false;
  std::unique_ptr<ContactParticipant> participant_;
  bool second_order_ = false, is_slow_ = false, in_step_ = false;  // of the step that is being taken
  bool first_step_ = true, strained_ = false, degenerate_ = false, recovering_ = false, touching_ = false,
       backward_ = false;
  double gravity_m_s2_ = 0.0;  // of the last substep
  Vector3d gravity_ = Vector3d::Zero();
  // For its energy: the least since it was badly strained, what hands and bodies that move gave it in this
  // frame, and whether it touched something in the last.
  std::optional<double> energy_limit_j_;
  double work_j_ = 0.0;
  bool touched_last_frame_ = false;
  double impact_until_s_ = -1.0;
  bool supported_ = false, forced_ = false,
       driven_ = false;      // for the sleep test: held up or in no gravity; pushed; moved
  Quaterniond orientation_;  // world from object, of the body as a whole
  Pose whole_;               // of it, after the last frame that it moved finitely in
  int recovery_count_ = 0;   // times
  std::optional<RigidMotion> rigid_;
  double unstrained_time_s_ = 0.0, degenerate_s_ = 0.0;
  int recovered_count_ = 0;                                  // times
  Vector3d stationary_at_m_ = Vector3d::Constant(INFINITY);  // its centre of mass has been, for so long
  double stationary_s_ = 0.0;
  std::vector<Vector3d> jitter_origin_m_;  // surface_, where they have been near for jitter_time_s_; empty:
                                           // all are still, or it moves
  double jitter_time_s_ = 0.0;
  bool may_rest_;
  SleepTimer sleep_timer_;
};

}  // namespace livegs
