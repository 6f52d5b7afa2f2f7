// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "physics/collision/point_contact.h"
#include "physics/elastic_body.h"
#include "physics/motion/momentum.h"
#include "physics/motion/sleep_timer.h"

// LIVE-GS's own elastic method, the baseline of every chart: particles in overlapping shape-matching clusters
// (Müller et al. 2005), pulled toward their goals by the same blend every substep,
//   x = (1 - d_R) x_pre + d_R x_goal,
// with d_R from the stiffness table. Because the blend knows no step, apparent stiffness grows with the
// square of the substep rate and falls with the square of the spacing (physics.md 0): a known defect that
// charts show. The steady variant blends by what d_R stands for at the paper's own step instead (material.h),
// and keeps all else.
//
// One substep:
//   drive     held particles to where their regions are; forces, traction, gravity; damping relative to rigid
//   motion match     clusters to their rest shapes, plastic flow, the blend contact   particles against what
//   moves, and against colliders advance   velocities from positions

namespace livegs {

class LivegsV1Body final : public ElasticBody {
 public:
  // Preconditions: a description that make_elastic_body has checked.
  LivegsV1Body(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep,
               bool steady);

  int begin_substep(const SubstepContext& context) override;
  void begin_step(const SubstepPart& part, const SubstepContext& context) override;
  void list_contacts(const SubstepPart& part, const SubstepContext& context,
                     std::vector<ContactConstraint>& rows) override;
  void end_step(const SubstepPart& part, const SubstepContext& context) override;
  void end_substep(const SubstepContext& context) override;
  void end_frame(double frame_s) override;
  ContactTotal take_contact_total() override { return std::exchange(contact_total_, {}); }

  double reach_m() const override { return reach_m_; }
  Eigen::AlignedBox3d bounds_m() const override;
  void surface_elements(const Eigen::AlignedBox3d& within,
                        std::vector<SurfaceElement>& elements) const override;
  double element_reach_m() const override;
  ContactAnchor anchor_at(uint32_t element, const Eigen::Vector3d& point_m) const override;
  ContactParticipant& contact_participant(double step_s) override;
  void defer_sleep(bool wait) override { sleep_timer_.defer(wait); }
  bool can_sleep() const override { return sleep_timer_.can_sleep(); }
  void sleep() override;

  bool release_region(const std::string& name) override;
  void set_material(const Material& material) override;
  const Material& material() const override { return material_; }
  bool asleep() const override { return sleep_timer_.asleep(); }
  void wake() override { sleep_timer_.wake(); }

  RestBody rest_body() const override;
  void write_drivers(ObjectDrivers& drivers) const override;
  Pose centre_pose() const override;
  Eigen::Vector3d velocity_m_s() const override { return motion_.velocity_m_s(); }
  Eigen::Vector3d angular_velocity_rad_s() const override { return motion_.angular_velocity_rad_s(); }
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const override;
  Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m,
                                 const Eigen::Vector3d& direction) const override;

 private:
  using Vector3d = Eigen::Vector3d;
  using Matrix3d = Eigen::Matrix3d;

  // One cluster a particle: itself and its neighbours.
  struct Cluster {
    uint32_t begin, end;  // members_
    double mass_kg;
    Vector3d rest_centre_m;
    Matrix3d rest_moment_inverse;  // of sum m r rᵀ, pseudo-inverse for flat clusters
    Eigen::Quaterniond rotation;
    Matrix3d flat;  // projects on the directions a flat cluster has no particles along; zero for a full one
    Matrix3d
        deformation;  // mean, world from rest, its plastic part included; turns with the cluster along `flat`
    Matrix3d plastic_part = Matrix3d::Identity();  // D_p, which the goal stretches the rest shape by
    Matrix3d plastic_inverse = Matrix3d::Identity();
  };
  struct Load {
    uint32_t particle;
    Vector3d force_n;  // world
  };

  // livegs_v1_clusters.cpp
  void make_clusters();
  void match_shapes(double blend);

  // livegs_v1_regions.cpp
  void load_regions();
  void hold_regions();
  bool held(size_t particle) const { return holders_[particle] >= 0; }
  bool driven(double start_s, double end_s) const;  // whether a motion moves anything in that time
  Vector3d prescribed_m(size_t particle, double time_s) const;  // as positions_m_

  // livegs_v1_step.cpp
  int steps_of(const SubstepContext& context);
  void drive(const SubstepContext& context, double end_s, double h);
  void resolve_contacts(const SubstepContext& context, double h);

  // livegs_v1_touch.cpp
  class Participant;
  double mobility(uint32_t particle) const { return held(particle) ? 0.0 : 1.0 / masses_kg_[particle]; }
  void push_particle(uint32_t particle, const Vector3d& impulse_n_s);
  void record_contact_impulse(const Vector3d& point_m, double impulse_n_s);
  bool may_touch_awake(const SubstepContext& context) const;

  double blend(double h) const;
  double apparent_modulus_pa(double h) const;
  double damping_rate(double h) const;
  size_t nearest_particle(const Vector3d& rest_point_m) const;

  Material material_;
  uint32_t object_id_;
  double rate_hz_;
  int substeps_;
  bool steady_;
  double spacing_m_, volume_m3_ = 0.0;
  Vector3d low_m_, high_m_;       // of the particles' voxels, object frame
  std::vector<Vector3d> rest_m_;  // object frame
  std::vector<double> volumes_m3_, masses_kg_;
  std::vector<bool> on_surface_;
  std::vector<SurfacePoint> surface_;         // outer particles
  std::vector<SurfacePoint> contact_points_;  // those and the inner ones, by their centres: nothing sinks in
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> members_;
  std::vector<uint32_t> cluster_counts_;  // clusters a particle is in

  std::vector<BodyRegion> regions_;
  std::vector<bool> released_;    // by region
  std::vector<int> holders_;      // the region that holds a particle, or -1
  std::vector<uint32_t> driven_;  // particles of moved regions
  std::vector<Load> loads_;
  bool held_ = false, anchored_ = false;  // some of it is held; and some of that does not move

  Pose world_from_object_;                // at the start, which prescribed motions are placed by
  Vector3d origin_m_ = Vector3d::Zero();  // positions are relative to it; it follows the body
  std::vector<Vector3d> positions_m_, predicted_m_, goals_m_, velocities_m_s_;
  BodyMomentum motion_;
  double reach_m_ = 0.0;
  std::vector<const Collider*> reachable_;
  ContactTotal contact_total_;
  std::unique_ptr<ContactParticipant> participant_;
  bool in_step_ = false;
  bool touching_ = false, forced_ = false, supported_ = false;
  bool warned_of_step_ = false;
  Eigen::Quaterniond orientation_;
  SleepTimer sleep_timer_;
};

}  // namespace livegs
