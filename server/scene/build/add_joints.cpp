// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/add_joints.h"

#include "scene/values/scene_values.h"

namespace livegs {
namespace {

struct JointParts {
  std::string kind, object, other;
  const Numbers* point_m = nullptr;
  const Numbers* axis = nullptr;  // of a hinge
};

JointParts parts_of(const v1::Joint& joint) {
  if (joint.kind_case() == v1::Joint::kHinge) {
    const v1::Joint::Hinge& hinge = joint.hinge();
    return {"hinge", hinge.object(), hinge.other(), &hinge.point_m(), &hinge.axis()};
  }
  const v1::Joint::Ball& ball = joint.ball();
  return {"ball", ball.object(), ball.other(), &ball.point_m(), nullptr};
}

}  // namespace

Result<void> check_joint(const v1::Joint& joint, const std::function<const v1::Object*(const std::string&)>& find,
                         const std::string& field) {
  if (joint.kind_case() == v1::Joint::KIND_NOT_SET) return invalid_argument(field + ": is neither; give ball or hinge");
  const JointParts parts = parts_of(joint);
  const std::string name = field + "." + parts.kind;
  if (parts.object.empty()) return invalid_argument(name + ".object: is missing; name the object that moves");
  const v1::Object* const object = find(parts.object);
  if (!object) return invalid_argument(name + ".object: no object is called \"" + parts.object + "\"");
  const v1::Object* const other = parts.other.empty() ? nullptr : find(parts.other);
  if (!parts.other.empty() && !other) {
    return invalid_argument(name + ".other: no object is called \"" + parts.other + "\"; leave it out for the world");
  }
  if (object == other) return invalid_argument(name + ".other: is the object itself");
  if (object->physics().behavior() == v1::Physics::STATIC) {
    return invalid_argument(name + ".object: \"" + parts.object +
                            "\" is STATIC and never moves; name the object that does, and this one as other");
  }
  for (const v1::Object* one : {object, other}) {
    if (one && one->physics().behavior() == v1::Physics::ELASTIC) {
      return invalid_argument(name + ": \"" + (one == object ? parts.object : parts.other) +
                              "\" is ELASTIC; joints hold rigid objects: make it RIGID, or hold it by a fixed region");
    }
  }
  if (auto point = vector_value(*parts.point_m, Eigen::Vector3d::Zero(), name + ".point_m"); !point) return point.error();
  if (!parts.axis) return {};
  if (parts.axis->empty()) return invalid_argument(name + ".axis: is missing; give [x, y, z]");
  auto axis = vector_value(*parts.axis, Eigen::Vector3d::Zero(), name + ".axis");
  if (!axis) return axis.error();
  if (axis->norm() < 1e-6) return invalid_argument(name + ".axis: is zero; give a direction");
  return {};
}

Result<void> add_joints(const v1::Scene& file, const std::function<const SceneObject*(const std::string&)>& find,
                        World& world) {
  for (int i = 0; i < file.joints_size(); ++i) {
    const JointParts parts = parts_of(file.joints(i));
    const std::string name = "joints[" + std::to_string(i) + "]." + parts.kind;
    HingeJointDescription hinge;
    for (const std::string& part : {parts.object, parts.other}) {
      if (part.empty()) continue;
      const SceneObject* object = find(part);
      // Of AUTO objects it is known only now.
      const v1::Physics::Behavior behavior = object->physics.behavior();
      if (behavior == v1::Physics::ELASTIC || (part == parts.object && behavior == v1::Physics::STATIC)) {
        return invalid_argument(name + ": \"" + part + "\" was found to be " + v1::Physics::Behavior_Name(behavior) +
                                "; joints hold rigid objects: set its physics.behavior to RIGID");
      }
      if (part == parts.object) {
        hinge.object_id = object->id;
      } else {
        hinge.other_id = object->id;
      }
    }
    hinge.point_m = vector_value(*parts.point_m, Eigen::Vector3d::Zero(), "").value();
    if (parts.axis) hinge.axis = vector_value(*parts.axis, Eigen::Vector3d::UnitX(), "").value();
    auto added = parts.axis ? world.add_hinge_joint(hinge)
                            : world.add_ball_joint({hinge.object_id, hinge.other_id, hinge.point_m});
    if (!added) return Error{added.error().code, name + ": " + added.error().message};
  }
  return {};
}

std::string joint_line(const v1::Joint& joint) {
  const JointParts parts = parts_of(joint);
  return parts.kind + " " + parts.object + " to " + (parts.other.empty() ? "the world" : parts.other);
}

}  // namespace livegs
