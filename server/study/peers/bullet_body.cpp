// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/peers/bullet_body.h"

#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/nearest_rotation.h"
#include "study/harness/tetrahedral_box.h"
#include "study/peers/bullet_convert.h"

namespace livegs::study {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double tetrahedron_volume_m3(const TetrahedralBox& box, const std::array<int, 4>& t) {
  const Vector3d& o = box.nodes_m[t[0]];
  return (box.nodes_m[t[1]] - o).cross(box.nodes_m[t[2]] - o).dot(box.nodes_m[t[3]] - o) / 6.0;
}

// Point forces of the scene on nodes, constant over a step.
class NodeForces final : public btDeformableLagrangianForce {
 public:
  std::vector<Vector3d> newtons;  // per node

  void addScaledForces(btScalar scale, TVStack& force) override { addScaledExplicitForce(scale, force); }
  void addScaledExplicitForce(btScalar scale, TVStack& force) override {
    for (size_t i = 0; i < newtons.size(); ++i) {
      const btSoftBody::Node& node = m_softBodies[0]->m_nodes[static_cast<int>(i)];
      if (node.m_im > 0) force[node.index] += scale * to_bullet(newtons[i]);
    }
  }
  void addScaledElasticForceDifferential(btScalar, const TVStack&, TVStack&) override {}
  void addScaledDampingForceDifferential(btScalar, const TVStack&, TVStack&) override {}
  void addScaledDampingForce(btScalar, TVStack&) override {}
  void buildDampingForceDifferentialDiagonal(btScalar, TVStack&) override {}
  btDeformableLagrangianForceType getForceType() override { return BT_MOUSE_PICKING_FORCE; }
};

class BulletBody final : public ElasticBody {
 public:
  BulletBody(const ElasticBodyDescription& description, TetrahedralBox box, double rate_hz, int substeps);
  ~BulletBody() override { world_.removeSoftBody(&soft_); }

  int begin_substep(const SubstepContext&) override { return 1; }
  void begin_step(const SubstepPart&, const SubstepContext&) override {}
  void list_contacts(const SubstepPart&, const SubstepContext&, std::vector<ContactConstraint>&) override {}
  void end_step(const SubstepPart& part, const SubstepContext& context) override;
  void end_substep(const SubstepContext&) override {}
  void end_frame(double) override {}

  bool release_region(const std::string&) override { return false; }
  void set_material(const Material&) override {}
  const Material& material() const override { return material_; }
  bool asleep() const override { return false; }
  void wake() override {}

  RestBody rest_body() const override { return {}; }
  void write_drivers(ObjectDrivers&) const override {}
  Pose centre_pose() const override;
  Vector3d velocity_m_s() const override;
  Vector3d angular_velocity_rad_s() const override { return Vector3d::Zero(); }
  std::vector<ParticleState> particles() const override;
  BodyEnergy energy(const Vector3d& gravity_m_s2) const override;
  ElasticAccuracy accuracy() const override;
  Vector3d world_point(const Vector3d& rest_point_m) const override;
  Vector3d point_velocity_m_s(const Vector3d& rest_point_m) const override;
  std::optional<RayHit> ray_cast(const Vector3d&, const Vector3d&) const override { return std::nullopt; }

 private:
  // Trilinear interpolation in the cube from its eight nodes.
  template <class Value>
  Vector3d between(const TetrahedralBox::Place& place, const Value& value) const;
  Vector3d at_node(int i) const { return from_bullet(soft_.m_nodes[i].m_x); }
  Vector3d velocity_of_node(int i) const { return from_bullet(soft_.m_nodes[i].m_v); }

  Material material_;
  TetrahedralBox box_;
  std::vector<double> masses_kg_;
  std::vector<Vector3d> particles_m_;
  double rate_hz_;
  int substeps_;
  double density_kg_m3_ = 0.0;

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDeformableBodySolver body_solver_;
  btDeformableMultiBodyConstraintSolver constraint_solver_;
  btDeformableMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &constraint_solver_, &configuration_,
                                            &body_solver_};
  btSoftBody soft_{&world_.getWorldInfo()};
  btDeformableLinearElasticityForce elasticity_;
  btDeformableGravityForce gravity_{btVector3(0, 0, 0)};
  NodeForces forces_;
};

BulletBody::BulletBody(const ElasticBodyDescription& description, TetrahedralBox box, double rate_hz,
                       int substeps)
    : material_(description.material),
      box_(std::move(box)),
      particles_m_(description.particles.positions_m),
      rate_hz_(rate_hz),
      substeps_(substeps) {
  double volume = 0.0;
  for (const double v : description.particles.volumes_m3) volume += v;
  density_kg_m3_ = material_.mass_kg / volume;

  masses_kg_.assign(box_.nodes_m.size(), 0.0);
  for (const auto& t : box_.tetrahedra) {
    for (const int i : t) masses_kg_[i] += 0.25 * density_kg_m3_ * tetrahedron_volume_m3(box_, t);
  }
  constraint_solver_.setDeformableSolver(&body_solver_);
  world_.setGravity(btVector3(0, 0, 0));
  world_.getWorldInfo().m_gravity = btVector3(0, 0, 0);
  world_.setImplicit(true);
  world_.setLineSearch(false);
  world_.setUseProjection(true);

  soft_.appendMaterial();
  bool held = false;
  for (size_t i = 0; i < box_.nodes_m.size(); ++i) {
    soft_.appendNode(to_bullet(box_.nodes_m[i]), static_cast<btScalar>(masses_kg_[i]));
    for (const BodyRegion& region : description.regions) {
      if (!region.fixed || !region.contains(box_.nodes_m[i], 1e-6)) continue;
      soft_.setMass(static_cast<int>(i), 0);
      held = true;
    }
  }
  for (const auto& t : box_.tetrahedra) soft_.appendTetra(t[0], t[1], t[2], t[3]);
  btSoftBodyHelpers::generateBoundaryFaces(&soft_);
  soft_.initializeDmInverse();
  soft_.m_tetraScratches.resize(soft_.m_tetras.size());
  soft_.m_tetraScratchesTn.resize(soft_.m_tetras.size());
  soft_.setSelfCollision(false);
  soft_.m_cfg.collisions = 0;
  soft_.m_cfg.drag = 0;
  soft_.m_cfg.kDP = 0;
  soft_.m_sleepingThreshold = 0;
  soft_.setActivationState(DISABLE_DEACTIVATION);
  world_.addSoftBody(&soft_);

  // The lowest free or clamped mode of a beam, as `cells` uses for its damping.
  Vector3d size = box_.cells.cast<double>() * box_.cell_width_m;
  const double length = size.maxCoeff(), thickness = size.minCoeff();
  const double wave_m_s = std::sqrt(material_.effective_youngs_modulus_pa() / density_kg_m3_);
  const double lowest = std::min((held ? M_PI_2 : M_PI) / length,
                                 (held ? 3.516 : 22.37) / std::sqrt(12.0) * thickness / (length * length));
  elasticity_.setYoungsModulus(static_cast<btScalar>(material_.effective_youngs_modulus_pa()));
  elasticity_.setPoissonRatio(static_cast<btScalar>(material_.poisson_ratio));
  elasticity_.setDamping(static_cast<btScalar>(material_.loss_factor * wave_m_s * lowest), 0);
  world_.addForce(&soft_, &elasticity_);
  world_.addForce(&soft_, &gravity_);
  world_.addForce(&soft_, &forces_);

  Vector3d centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i)
    centre += masses_kg_[i] / material_.mass_kg * box_.nodes_m[i];
  for (int i = 0; i < soft_.m_nodes.size(); ++i) {
    btSoftBody::Node& node = soft_.m_nodes[i];
    if (node.m_im == 0) continue;
    const Vector3d r = box_.nodes_m[i] - centre;
    const Vector3d offset = description.world_from_object.orientation * (description.initial_deformation * r);
    node.m_x = node.m_q = to_bullet(description.world_from_object * centre + offset);
    node.m_v = node.m_vn =
        to_bullet(description.velocity_m_s + description.angular_velocity_rad_s.cross(offset));
  }
  if (!description.particle_velocities_m_s.empty()) {
    std::vector<Vector3d> sum(masses_kg_.size(), Vector3d::Zero());
    std::vector<double> shares(masses_kg_.size(), 0.0);
    for (size_t p = 0; p < particles_m_.size(); ++p) {
      const auto place = box_.find(particles_m_[p]);
      for (int c = 0; c < 8; ++c) {
        sum[place.nodes[c]] += place.weight(c) * description.particle_velocities_m_s[p];
        shares[place.nodes[c]] += place.weight(c);
      }
    }
    for (int i = 0; i < soft_.m_nodes.size(); ++i) {
      btSoftBody::Node& node = soft_.m_nodes[i];
      if (node.m_im == 0 || shares[i] == 0.0) continue;
      node.m_v += to_bullet(sum[i] / shares[i]);
      node.m_vn = node.m_v;
    }
  }
  soft_.updateBounds();
}

void BulletBody::end_step(const SubstepPart&, const SubstepContext& context) {
  gravity_.m_gravity = to_bullet(context.gravity_m_s2);
  forces_.newtons.assign(masses_kg_.size(), Vector3d::Zero());
  for (const PointForce& force : context.forces) {
    const auto place = box_.find(force.point_m);
    for (int c = 0; c < 8; ++c) forces_.newtons[place.nodes[c]] += place.weight(c) * force.force_n;
  }
  world_.stepSimulation(static_cast<btScalar>(context.duration_s), 0);
}

template <class Value>
Vector3d BulletBody::between(const TetrahedralBox::Place& place, const Value& value) const {
  Vector3d sum = Vector3d::Zero();
  for (int c = 0; c < 8; ++c) sum += place.weight(c) * value(place.nodes[c]);
  return sum;
}

Vector3d BulletBody::world_point(const Vector3d& rest_point_m) const {
  return between(box_.find(rest_point_m), [&](int i) { return at_node(i); });
}
Vector3d BulletBody::point_velocity_m_s(const Vector3d& rest_point_m) const {
  return between(box_.find(rest_point_m), [&](int i) { return velocity_of_node(i); });
}

std::vector<ParticleState> BulletBody::particles() const {
  std::vector<ParticleState> states;
  for (const Vector3d& rest : particles_m_) {
    const auto place = box_.find(rest);
    ParticleState state{between(place, [&](int i) { return at_node(i); }),
                        between(place, [&](int i) { return velocity_of_node(i); }),
                        material_.mass_kg / static_cast<double>(particles_m_.size()), Matrix3d::Zero()};
    for (int c = 0; c < 8; ++c) {
      Vector3d gradient = Vector3d::Constant(1.0 / box_.cell_width_m);
      for (int d = 0; d < 3; ++d) {
        for (int e = 0; e < 3; ++e) {
          if (d == e)
            gradient[e] *= c >> d & 1 ? 1.0 : -1.0;
          else
            gradient[e] *= c >> d & 1 ? place.local[d] : 1.0 - place.local[d];
        }
      }
      state.deformation_gradient += at_node(place.nodes[c]) * gradient.transpose();
    }
    states.push_back(state);
  }
  return states;
}

Pose BulletBody::centre_pose() const {
  Pose pose;
  Vector3d rest_centre = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    pose.position_m += masses_kg_[i] / material_.mass_kg * at_node(static_cast<int>(i));
    rest_centre += masses_kg_[i] / material_.mass_kg * box_.nodes_m[i];
  }
  Matrix3d match = Matrix3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    match += masses_kg_[i] * (at_node(static_cast<int>(i)) - pose.position_m) *
             (box_.nodes_m[i] - rest_centre).transpose();
  }
  pose.orientation = Eigen::Quaterniond(nearest_rotation(match));
  return pose;
}

Vector3d BulletBody::velocity_m_s() const {
  Vector3d momentum = Vector3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i)
    momentum += masses_kg_[i] * velocity_of_node(static_cast<int>(i));
  return momentum / material_.mass_kg;
}

BodyEnergy BulletBody::energy(const Vector3d& gravity_m_s2) const {
  BodyEnergy energy;
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    const Vector3d x = at_node(static_cast<int>(i)), v = velocity_of_node(static_cast<int>(i));
    energy.kinetic_j += 0.5 * masses_kg_[i] * v.squaredNorm();
    energy.gravity_j -= masses_kg_[i] * gravity_m_s2.dot(x);
    energy.linear_momentum += masses_kg_[i] * v;
    energy.angular_momentum += masses_kg_[i] * x.cross(v);
  }
  return energy;
}

ElasticAccuracy BulletBody::accuracy() const {
  ElasticAccuracy accuracy;
  accuracy.cell_width_m = box_.cell_width_m;
  accuracy.substeps = substeps_;
  const double modulus = material_.effective_youngs_modulus_pa();
  accuracy.courant = std::sqrt(modulus / density_kg_m3_) / (rate_hz_ * substeps_ * box_.cell_width_m);
  accuracy.youngs_modulus_pa = accuracy.reached_youngs_modulus_pa = modulus;
  accuracy.nodes = box_.nodes_m.size();
  accuracy.cells = box_.tetrahedra.size();
  accuracy.particles = particles_m_.size();
  return accuracy;
}

}  // namespace

Result<std::unique_ptr<ElasticBody>> make_bullet_body(const ElasticBodyDescription& description,
                                                      double rate_hz, int substeps) {
  auto box = make_tetrahedral_box(description.particles, description.cell_width_m);
  if (!box) return box.error();
  return std::unique_ptr<ElasticBody>(
      std::make_unique<BulletBody>(description, std::move(*box), rate_hz, substeps));
}

}  // namespace livegs::study
