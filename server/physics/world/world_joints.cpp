// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "core/disjoint_sets.h"
#include "physics/check/check_values.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

// Rigid object of a joint, or an error.
Result<RigidObject*> rigid_part(WorldObject* object, uint32_t object_id) {
  const std::string name = object_name(object_id);
  if (!object) return not_found("joint: " + name + " is unknown; give the id of an object in the world");
  if (object->elastic())
    return invalid_argument("joint: " + name + " is elastic; joints hold rigid objects only");
  if (object->fixed()) return invalid_argument("joint: " + name + " is static; name the moving object first");
  return object->rigid();
}

}  // namespace

Result<void> World::State::add_joint(const HingeJointDescription& description, bool hinge) {
  auto part = rigid_part(find(description.object_id), description.object_id);
  if (!part) return part.error();
  const std::string name = object_name(description.object_id);
  if (!description.point_m.allFinite())
    return invalid_argument("joint of " + name + ": point_m is not finite");
  if (!(description.axis.norm() > 1e-9) || !description.axis.allFinite())
    return invalid_argument("joint of " + name + ": axis is zero or not finite");
  ActiveJoint held;
  held.object_id = description.object_id;
  held.declared_id = description.other_id;
  held.point_m = description.point_m;
  held.axis = description.axis.normalized();
  held.joint.id = joints.empty() ? 1 : joints.back().joint.id + 1;
  held.joint.hinge = hinge;
  RigidBody& body = (*part)->body_with(held.point_m);
  held.other_point_m = body.world_from_body.position_m + body.arm_of(held.point_m);
  held.other_axis = body.world_from_body.orientation * held.axis;
  if (description.other_id) {
    if (*description.other_id == description.object_id)
      return invalid_argument("joint: " + name + " cannot be joined to itself; name another object");
    WorldObject* other = find(*description.other_id);
    if (!other || !other->fixed()) {
      auto other_part = rigid_part(other, *description.other_id);
      if (!other_part) return other_part.error();
      held.other_id = description.other_id;
      RigidObject& object = **other_part;
      // Fragments keep their object's axes, so the body that contains the point follows from its rest
      // position.
      const RigidBody& first = *object.bodies[0];
      const Pose from_world = first.world_from_body.inverse();
      held.other_point_m = from_world * held.other_point_m + first.rest_centre_m;
      held.other_axis = from_world.orientation * held.other_axis;
      other->wake();
    }
  }
  joints.push_back(std::move(held));
  find(description.object_id)->wake();
  link_joints();
  return {};
}

const RigidJoint& World::State::running(const ActiveJoint& held) const {
  if (held.group) {
    for (const RigidJoint& joint : held.group->joints()) {
      if (joint.id == held.joint.id) return joint;
    }
  }
  return held.joint;
}

void World::State::link_joints() {
  std::erase_if(joints, [&](const ActiveJoint& held) {
    WorldObject* const object = find(held.object_id);
    WorldObject* const other = held.other_id ? find(*held.other_id) : nullptr;
    if (object && (other || !held.other_id)) return false;
    for (WorldObject* left : {object, other}) {
      if (left) left->wake();
    }
    return true;
  });
  for (ActiveJoint& held : joints) {
    RigidJoint& joint = held.joint;
    joint = running(held);  // including its impulses
    RigidBody& a = find(held.object_id)->rigid()->body_with(held.point_m);
    joint.a = &a;
    joint.anchor_a_m = held.point_m - a.rest_centre_m;
    joint.axis_a = held.axis;
    joint.b = nullptr;
    joint.anchor_b_m = held.other_point_m;
    joint.axis_b = held.other_axis;
    if (held.other_id) {
      joint.b = &find(*held.other_id)->rigid()->body_with(held.other_point_m);
      joint.anchor_b_m -= joint.b->rest_centre_m;
    }
    held.group = nullptr;
  }
  for (RigidBody* body : rigid_bodies) body->joints = nullptr;
  joint_groups.clear();

  const auto index_of = [&](const RigidBody* body) {
    return static_cast<uint32_t>(rigid_index(body->body_id()));
  };
  DisjointSets sets(rigid_bodies.size());
  for (const ActiveJoint& held : joints) {
    if (held.joint.b) sets.join(index_of(held.joint.a), index_of(held.joint.b));
  }
  std::map<uint32_t, std::vector<ActiveJoint*>> members;
  for (ActiveJoint& held : joints) members[sets.find(index_of(held.joint.a))].push_back(&held);
  for (const auto& [root, held] : members) {
    std::vector<RigidJoint> rows;
    for (const ActiveJoint* one : held) rows.push_back(one->joint);
    joint_groups.push_back(std::make_unique<JointGroup>(std::move(rows)));
    for (ActiveJoint* one : held) one->group = joint_groups.back().get();
    for (RigidBody* body : joint_groups.back()->bodies()) body->joints = joint_groups.back().get();
  }
}

Result<void> World::add_ball_joint(const BallJointDescription& description) {
  return state_->add_joint({description.object_id, description.other_id, description.point_m}, false);
}

Result<void> World::add_hinge_joint(const HingeJointDescription& description) {
  return state_->add_joint(description, true);
}

std::vector<JointState> World::joints() const {
  std::vector<JointState> states;
  for (const ActiveJoint& held : state_->joints) {
    const RigidJoint& joint = state_->running(held);
    JointState state{held.object_id, held.declared_id, joint.hinge, joint.world_anchor_a(),
                     joint.hinge ? joint.world_axis_a() : Eigen::Vector3d::Zero().eval()};
    state.error_m = (joint.world_anchor_a() - joint.world_anchor_b()).norm();
    if (joint.hinge) {
      const Eigen::Vector3d a = joint.world_axis_a(), b = joint.world_axis_b();
      state.error_rad = std::atan2(a.cross(b).norm(), a.dot(b));
    }
    if (!joint.a->asleep) state.force_n = joint.force_n.norm();
    states.push_back(state);
  }
  return states;
}

}  // namespace livegs
