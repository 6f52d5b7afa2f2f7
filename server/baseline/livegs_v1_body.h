// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "physics/collision/point_contact.h"
#include "physics/collision/surface_points.h"
#include "physics/elastic/elastic_sleep_timer.h"
#include "physics/elastic_body.h"
#include "physics/motion/momentum.h"

// The elastic method of LIVE-GS, the baseline of all charts. Particles in overlapping shape-matching clusters
// (Müller et al. 2005) are pulled towards their goals by the same blend in every substep,
//   x = (1 - d_R) x_pre + d_R x_goal,
// with d_R from the stiffness table. The blend does not depend on the step. Apparent stiffness therefore
// grows with the squares of the substep rate and of the spacing (apparent_modulus_pa): a known defect that
// the charts show. The steady variant converts d_R to a stiffness at the paper's own step and is
// otherwise the same.
//
// One substep:
//   drive     held particles follow their regions; forces, traction, gravity; damping of relative motion
//   match     clusters to their rest shapes, plastic flow, blend
//   contact   particles against moving bodies, then against colliders
//   advance   velocities from positions

namespace livegs {

// Plasticity of one cluster as published in LIVE-GS (its D_p and p). If |S - I| > 1 - p (Frobenius),
//   D_p <- (I + p (S - I)) D_p,  then, if |D_p - I| > p,  D_p <- I + p (D_p - I) / |D_p - I|.
// S is the stretch of the cluster without its plastic part. Volume and symmetry are not preserved, and the
// result depends on the number of substeps (unlike return_mapping.h). One safeguard is added because the
// inverse of D_p is needed: a D_p with a determinant below 0.001 is rejected. Returns true if D_p changed.
bool creep_plastically(const Eigen::Matrix3d& stretch, double plasticity, Eigen::Matrix3d& plastic_part);

// Stiffness per mass for d_R: omega² = d_R / ((1 - d_R) h_ref²) in 1/s², 0 … infinity (rigid). d_R is the
// fraction of the distance to its goal that a particle moves in one substep, so the effective stiffness
// depends on the substep. h_ref is the paper's substep: 60 Hz with 4 substeps.
inline constexpr double kPaperSubstep_s = 1.0 / 240.0;
double resistance_stiffness_per_s2(double deformation_resistance);
// Blend factor for any substep h: omega² h² / (1 + omega² h²), the implicit step of the spring; 1 if omega²
// is infinite. Equals d_R at kPaperSubstep_s.
double resistance_blend(double stiffness_per_s2, double substep_s);

class LivegsV1Body final : public ElasticBody {
 public:
  // Precondition: check_elastic_body has passed.
  LivegsV1Body(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep,
               bool steady);

  int begin_substep(const SubstepContext& context) override;
  void begin_step(const SubstepPart& part, const SubstepContext& context) override;
  void prepare_contact_step(double step_s) override;
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
  ContactParticipant& contact_participant() override { return *participant_; }
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

  // One cluster per particle: the particle and its neighbours.
  struct Cluster {
    uint32_t begin, end;  // range of members_
    double mass_kg;
    Vector3d rest_centre_m;
    Matrix3d rest_moment_inverse;  // inverse of sum m r rᵀ; pseudo-inverse for flat clusters
    Eigen::Quaterniond rotation;
    Matrix3d flat;  // projector on the directions without extent; zero for a full cluster
    // Mean deformation, world from rest, with the plastic part; rotates with the cluster along `flat`.
    Matrix3d deformation;
    Matrix3d plastic_part = Matrix3d::Identity();  // D_p; stretches the rest shape
    Matrix3d plastic_inverse = Matrix3d::Identity();
  };
  struct Load {
    uint32_t particle;
    Vector3d force_n;  // world frame
  };

  // livegs_v1_clusters.cpp
  void make_clusters();
  void match_shapes(double blend);

  // livegs_v1_regions.cpp
  void load_regions();
  void hold_regions();
  bool held(size_t particle) const { return holders_[particle] >= 0; }
  bool driven(double start_s, double end_s) const;  // whether a motion displaces anything in that time
  Vector3d prescribed_m(size_t particle, double time_s) const;  // relative to the origin, as positions_m_

  // livegs_v1_step.cpp
  int steps_of(const SubstepContext& context);
  void drive(const SubstepContext& context, double end_s, double h);
  void resolve_contacts(const SubstepContext& context, double h);

  // livegs_v1_contact.cpp
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
  Vector3d low_m_, high_m_;       // bounds of the particles' voxels, object frame
  std::vector<Vector3d> rest_m_;  // object frame
  std::vector<double> volumes_m3_, masses_kg_;
  std::vector<bool> on_surface_;
  std::vector<SurfacePoint> surface_;  // outer particles
  // The outer particles as balls and the centres of the inner ones, which prevent deep overlap.
  std::vector<SurfacePoint> contact_points_;
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> members_;
  std::vector<uint32_t> cluster_counts_;  // number of clusters that contain a particle

  std::vector<BodyRegion> regions_;
  std::vector<bool> released_;    // by region
  std::vector<int> holders_;      // region that holds a particle, or -1
  std::vector<uint32_t> driven_;  // particles of moved regions
  std::vector<Load> loads_;
  bool held_ = false, anchored_ = false;  // any particle is held; any held particle is fixed

  Pose world_from_object_;                // initial pose; places the prescribed motions
  Vector3d origin_m_ = Vector3d::Zero();  // origin of the positions; follows the body
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
