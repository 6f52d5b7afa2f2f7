// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/peers/ode_rigid.h"

#include <ode/ode.h>

#include <array>
#include <cmath>

namespace livegs::study {
namespace {

using Eigen::Vector3d;

class OdeRigid final : public RigidSolver {
 public:
  OdeRigid(const RigidSetup& setup, const RigidConditions& conditions)
      : quick_(setup.engine == RigidEngine::OdeQuick),
        substep_s_(1.0 / (setup.rate_hz * setup.substeps)),
        substeps_(setup.substeps) {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    dRandSetSeed(0);
    world_ = dWorldCreate();
    space_ = dSimpleSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    dWorldSetGravity(world_, conditions.gravity_m_s2.x(), conditions.gravity_m_s2.y(),
                     conditions.gravity_m_s2.z());
    dWorldSetAutoDisableFlag(world_, conditions.sleep ? 1 : 0);
  }
  ~OdeRigid() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }

  void add_floor(const Pose& world_from_floor, double friction) override {
    const Vector3d n = world_from_floor.orientation * Vector3d::UnitY();
    keep(dCreatePlane(space_, n.x(), n.y(), n.z(), n.dot(world_from_floor.position_m)), friction);
  }

  Result<void> add(const RigidPart& part) override {
    if (!part.corners_m.empty()) return Error{ErrorCode::Unavailable, "ode: convex bodies are not supported"};
    const dBodyID body = dBodyCreate(world_);
    dMass mass;
    dGeomID geometry;
    if (part.radius_m > 0.0) {
      dMassSetSphereTotal(&mass, part.mass_kg, part.radius_m);
      geometry = dCreateSphere(space_, part.radius_m);
    } else {
      dMassSetBoxTotal(&mass, part.mass_kg, part.size_m.x(), part.size_m.y(), part.size_m.z());
      geometry = dCreateBox(space_, part.size_m.x(), part.size_m.y(), part.size_m.z());
    }
    if (part.moments_kg_m2) {
      const Vector3d& i = *part.moments_kg_m2;
      dMassSetParameters(&mass, part.mass_kg, 0, 0, 0, i.x(), i.y(), i.z(), 0, 0, 0);
    }
    dBodySetMass(body, &mass);
    dGeomSetBody(geometry, body);
    keep(geometry, part.friction);
    const Vector3d& p = part.world_from_part.position_m;
    const Eigen::Quaterniond& q = part.world_from_part.orientation;
    const dQuaternion wxyz = {q.w(), q.x(), q.y(), q.z()};
    dBodySetPosition(body, p.x(), p.y(), p.z());
    dBodySetQuaternion(body, wxyz);
    const Vector3d &v = part.velocity_m_s, &w = part.angular_velocity_rad_s;
    dBodySetLinearVel(body, v.x(), v.y(), v.z());
    dBodySetAngularVel(body, w.x(), w.y(), w.z());
    bodies_.push_back(body);
    forces_n_.push_back(Vector3d::Zero());
    return {};
  }

  Result<void> join(size_t part, std::optional<size_t> other, const Vector3d& point_m) override {
    const dJointID joint = dJointCreateBall(world_, nullptr);
    dJointAttach(joint, bodies_[part], other ? bodies_[*other] : nullptr);
    dJointSetBallAnchor(joint, point_m.x(), point_m.y(), point_m.z());
    return {};
  }

  void push(size_t part, const Vector3d& force_n) override { forces_n_[part] = force_n; }

  void frame() override {
    for (int i = 0; i < substeps_; ++i) {
      for (size_t b = 0; b < bodies_.size(); ++b) {
        const Vector3d& f = forces_n_[b];
        if (!f.isZero()) dBodyAddForce(bodies_[b], f.x(), f.y(), f.z());
      }
      dSpaceCollide(space_, this, &OdeRigid::meet);
      if (quick_)
        dWorldQuickStep(world_, substep_s_);
      else
        dWorldStep(world_, substep_s_);
      dJointGroupEmpty(contacts_);
    }
  }

  std::vector<RigidMotion> motions() const override {
    std::vector<RigidMotion> motions;
    for (const dBodyID body : bodies_) {
      const dReal *p = dBodyGetPosition(body), *q = dBodyGetQuaternion(body), *v = dBodyGetLinearVel(body),
                  *w = dBodyGetAngularVel(body);
      motions.push_back(
          {{Vector3d(p[0], p[1], p[2]), Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized()},
           Vector3d(v[0], v[1], v[2]),
           Vector3d(w[0], w[1], w[2]),
           dBodyIsEnabled(body) == 0});
    }
    return motions;
  }

 private:
  void keep(dGeomID geometry, double friction) {
    frictions_.push_back(std::make_unique<double>(friction));
    dGeomSetData(geometry, frictions_.back().get());
  }

  static void meet(void* self, dGeomID a, dGeomID b) {
    auto& solver = *static_cast<OdeRigid*>(self);
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (body_a && body_b && dAreConnectedExcluding(body_a, body_b, dJointTypeContact)) return;
    std::array<dContact, 8> contacts{};
    const int count = dCollide(a, b, static_cast<int>(contacts.size()), &contacts[0].geom, sizeof(dContact));
    const double friction =
        std::sqrt(*static_cast<double*>(dGeomGetData(a)) * *static_cast<double*>(dGeomGetData(b)));
    for (int i = 0; i < count; ++i) {
      contacts[i].surface.mode = dContactApprox1;
      contacts[i].surface.mu = friction;
      dJointAttach(dJointCreateContact(solver.world_, solver.contacts_, &contacts[i]), body_a, body_b);
    }
  }

  bool quick_;
  double substep_s_;
  int substeps_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::vector<dBodyID> bodies_;
  std::vector<std::unique_ptr<double>> frictions_;  // the data pointer of a geometry refers to one
  std::vector<Vector3d> forces_n_;
};

}  // namespace

std::unique_ptr<RigidSolver> make_ode_rigid(const RigidSetup& setup, const RigidConditions& conditions) {
  return std::make_unique<OdeRigid>(setup, conditions);
}

}  // namespace livegs::study
