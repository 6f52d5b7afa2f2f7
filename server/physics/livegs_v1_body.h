// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "physics/elastic_body.h"
#include "physics/mass_motion.h"
#include "physics/point_contact.h"
#include "physics/rest_clock.h"

// LIVE-GS's own elastic method, the baseline of every chart: particles in overlapping shape-matching clusters (Müller
// et al. 2005), pulled toward their goals by the same blend every substep,
//   x = (1 - d_R) x_pre + d_R x_goal,
// with d_R from the stiffness table. Because the blend knows no step, apparent stiffness grows with the square of the
// substep rate and falls with the square of the spacing (physics.md 0): a known defect that charts show.

namespace livegs {

class LivegsV1Body final : public ElasticBody {
 public:
  // Preconditions: a description that make_elastic_body has checked.
  LivegsV1Body(const ElasticBodyDescription& description, double rate_hz, int substeps, bool may_sleep);

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
  Eigen::Vector3d velocity_m_s() const override { return motion_.velocity_m_s(); }
  Eigen::Vector3d angular_velocity_rad_s() const override { return motion_.angular_velocity_rad_s(); }
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Eigen::Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Eigen::Vector3d world_point(const Eigen::Vector3d& rest_point_m) const override;
  Eigen::Vector3d point_velocity_m_s(const Eigen::Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction) const override;

 private:
  using Vector3d = Eigen::Vector3d;

  // One cluster a particle: itself and its neighbours.
  struct Cluster {
    uint32_t begin, end;         // members_
    double mass_kg;
    Vector3d rest_centre_m;
    Eigen::Matrix3d rest_moment_inverse;  // of sum m r rᵀ, pseudo-inverse for flat clusters
    Eigen::Quaterniond rotation;
    Eigen::Matrix3d deformation;
  };

  void make_clusters(const ElasticBodyDescription& description);
  void match_shapes();
  void resolve_contacts(double h, std::span<MovingSphere> spheres);
  void push(size_t particle, const Vector3d& correction_m);
  size_t nearest_particle(const Vector3d& rest_point_m) const;

  Material material_;
  uint32_t object_id_;
  double rate_hz_;
  int substeps_;
  double spacing_m_, resistance_;
  std::vector<Vector3d> rest_m_;  // object frame
  std::vector<double> volumes_m3_, masses_kg_;
  std::vector<bool> fixed_;
  bool held_ = false;
  std::vector<SurfacePoint> surface_;
  std::vector<Cluster> clusters_;
  std::vector<uint32_t> members_;
  std::vector<uint32_t> cluster_counts_;  // clusters a particle is in

  Vector3d origin_m_ = Vector3d::Zero();  // positions are relative to it; it follows the body
  std::vector<Vector3d> positions_m_, predicted_m_, goals_m_, velocities_m_s_;
  MassMotion motion_;
  double reach_m_ = 0.0;
  std::vector<const Collider*> reachable_;
  bool touching_ = false, forced_ = false, supported_ = false;
  Eigen::Quaterniond orientation_;
  RestClock rest_clock_;
};

}  // namespace livegs
