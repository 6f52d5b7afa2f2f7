// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/peers/bullet_rigid.h"

#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "study/peers/bullet_convert.h"

namespace livegs::study {
namespace {

using Eigen::Vector3d;

// Margin of hulls, m. Bullet adds a margin of 40 mm by default. This value is small, and the faces are moved
// inwards by it, so that the body keeps its size.
constexpr btScalar kHullMargin_m = 5e-4f;
std::unique_ptr<btConvexHullShape> hull_around(const std::vector<Vector3d>& corners_m) {
  std::vector<btVector3> corners;
  for (const Vector3d& corner : corners_m) corners.push_back(to_bullet(corner));
  btConvexHullComputer computer;
  const btScalar drawn_in = computer.compute(&corners[0].m_floats[0], sizeof(btVector3),
                                             static_cast<int>(corners.size()), kHullMargin_m, 0.25f);
  auto hull = std::make_unique<btConvexHullShape>();
  if (drawn_in < 0)
    computer.compute(&corners[0].m_floats[0], sizeof(btVector3), static_cast<int>(corners.size()), 0, 0);
  for (int i = 0; i < computer.vertices.size(); ++i) hull->addPoint(computer.vertices[i], false);
  hull->setMargin(std::max(btScalar(0), drawn_in));
  hull->recalcLocalAabb();
  hull->initializePolyhedralFeatures();
  return hull;
}

class BulletRigid final : public RigidSolver {
 public:
  BulletRigid(const RigidSetup& setup, const RigidConditions& conditions)
      : substep_s_(1.0 / (setup.rate_hz * setup.substeps)),
        substeps_(setup.substeps),
        sleep_(conditions.sleep) {
    world_.setGravity(to_bullet(conditions.gravity_m_s2));
    configuration_.setPlaneConvexMultipointIterations();
  }
  ~BulletRigid() override {
    for (const auto& joint : joints_) world_.removeConstraint(joint.get());
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    for (const auto& body : floors_) world_.removeRigidBody(body.get());
  }

  void add_floor(const Pose& world_from_floor, double friction) override {
    const Vector3d normal = world_from_floor.orientation * Vector3d::UnitY();
    shapes_.push_back(std::make_unique<btStaticPlaneShape>(
        to_bullet(normal), static_cast<btScalar>(normal.dot(world_from_floor.position_m))));
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes_.back().get());
    info.m_friction = pair_share(friction);
    info.m_restitution = 0;
    floors_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(floors_.back().get());
  }

  Result<void> add(const RigidPart& part) override {
    if (part.radius_m > 0.0) {
      shapes_.push_back(std::make_unique<btSphereShape>(static_cast<btScalar>(part.radius_m)));
    } else if (!part.corners_m.empty()) {
      shapes_.push_back(hull_around(part.corners_m));
    } else {
      shapes_.push_back(std::make_unique<btBoxShape>(to_bullet(0.5 * part.size_m)));
    }
    const auto mass = static_cast<btScalar>(part.mass_kg);
    btVector3 moments;
    if (part.moments_kg_m2)
      moments = to_bullet(*part.moments_kg_m2);
    else
      shapes_.back()->calculateLocalInertia(mass, moments);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes_.back().get(), moments);
    info.m_startWorldTransform = to_bullet(part.world_from_part);
    info.m_friction = pair_share(part.friction);
    info.m_restitution = 0;
    info.m_linearDamping = info.m_angularDamping = 0;
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    body.setLinearVelocity(to_bullet(part.velocity_m_s));
    body.setAngularVelocity(to_bullet(part.angular_velocity_rad_s));
    if (!sleep_) body.setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(&body);
    forces_n_.push_back(Vector3d::Zero());
    break_impulses_n_s_.push_back(part.break_impulse_n_s);
    broken_.push_back(false);
    return {};
  }

  Result<bool> broken(size_t part) const override { return broken_[part]; }

  Result<void> join(size_t part, std::optional<size_t> other, const Vector3d& point_m) override {
    const btVector3 point = to_bullet(point_m);
    btRigidBody& a = *bodies_[part];
    const btVector3 in_a = a.getWorldTransform().inverse() * point;
    if (other) {
      btRigidBody& b = *bodies_[*other];
      joints_.push_back(
          std::make_unique<btPoint2PointConstraint>(a, b, in_a, b.getWorldTransform().inverse() * point));
    } else {
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(a, in_a));
    }
    world_.addConstraint(joints_.back().get(), true);  // true: jointed parts do not collide
    return {};
  }

  void push(size_t part, const Vector3d& force_n) override { forces_n_[part] = force_n; }

  void frame() override {
    std::vector<double> given_n_s(bodies_.size(), 0.0);
    for (int i = 0; i < substeps_; ++i) {
      for (size_t b = 0; b < bodies_.size(); ++b) {
        if (!forces_n_[b].isZero()) bodies_[b]->applyCentralForce(to_bullet(forces_n_[b]));
      }
      world_.stepSimulation(static_cast<btScalar>(substep_s_), 0);
      for (size_t b = 0; b < bodies_.size(); ++b) {
        if (break_impulses_n_s_[b] > 0.0) given_n_s[b] += contact_impulse_n_s(*bodies_[b]);
      }
    }
    for (size_t b = 0; b < bodies_.size(); ++b) {
      if (break_impulses_n_s_[b] > 0.0 && given_n_s[b] >= break_impulses_n_s_[b]) broken_[b] = true;
    }
  }

  std::vector<RigidMotion> motions() const override {
    std::vector<RigidMotion> motions;
    for (const auto& body : bodies_) {
      const btQuaternion q = body->getOrientation();
      RigidMotion motion;
      motion.world_from_part.position_m = from_bullet(body->getCenterOfMassPosition());
      motion.world_from_part.orientation = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized();
      motion.velocity_m_s = from_bullet(body->getLinearVelocity());
      motion.angular_velocity_rad_s = from_bullet(body->getAngularVelocity());
      motion.asleep = body->getActivationState() == ISLAND_SLEEPING;
      motions.push_back(motion);
    }
    return motions;
  }

 private:
  // Sum of contact impulses of the last step.
  double contact_impulse_n_s(const btRigidBody& body) {
    double sum = 0.0;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      if (manifold.getBody0() != &body && manifold.getBody1() != &body) continue;
      for (int p = 0; p < manifold.getNumContacts(); ++p)
        sum += manifold.getContactPoint(p).getAppliedImpulse();
    }
    return sum;
  }

  // Bullet multiplies the frictions of a pair; square roots give the geometric mean.
  static btScalar pair_share(double friction) { return static_cast<btScalar>(std::sqrt(friction)); }

  double substep_s_;
  int substeps_;
  bool sleep_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_, floors_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::vector<Vector3d> forces_n_;
  std::vector<double> break_impulses_n_s_;  // per part; 0: not fragile
  std::vector<bool> broken_;

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

}  // namespace

std::unique_ptr<RigidSolver> make_bullet_rigid(const RigidSetup& setup, const RigidConditions& conditions) {
  return std::make_unique<BulletRigid>(setup, conditions);
}

}  // namespace livegs::study
