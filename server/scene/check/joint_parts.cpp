// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check/joint_parts.h"

namespace livegs {

JointParts parts_of(const v1::Joint& joint) {
  if (joint.kind_case() == v1::Joint::kHinge) {
    const v1::Joint::Hinge& hinge = joint.hinge();
    return {"hinge", hinge.object(), hinge.other(), &hinge.point_m(), &hinge.axis()};
  }
  const v1::Joint::Ball& ball = joint.ball();
  return {"ball", ball.object(), ball.other(), &ball.point_m(), nullptr};
}

Result<void> check_joint(const v1::Joint& joint,
                         const std::function<const v1::Object*(const std::string&)>& find,
                         const std::string& field) {
  if (joint.kind_case() == v1::Joint::KIND_NOT_SET)
    return invalid_argument(field + ": has no type; give ball or hinge");
  const JointParts parts = parts_of(joint);
  const std::string name = field + "." + parts.kind;
  if (parts.object.empty()) return invalid_argument(name + ".object: is missing; name the object that moves");
  const v1::Object* const object = find(parts.object);
  if (!object)
    return invalid_argument(name + ".object: no object is called \"" + parts.object +
                            "\"; name an object of the scene");
  const v1::Object* const other = parts.other.empty() ? nullptr : find(parts.other);
  if (!parts.other.empty() && !other) {
    return invalid_argument(name + ".other: no object is called \"" + parts.other +
                            "\"; omit it to attach to the world");
  }
  if (object == other)
    return invalid_argument(name + ".other: is the same object; name another one, or omit it");
  if (object->physics().behavior() == v1::Physics::STATIC) {
    return invalid_argument(name + ".object: \"" + parts.object +
                            "\" is STATIC; name the moving object here, and this one as other");
  }
  for (const v1::Object* one : {object, other}) {
    if (one && one->physics().behavior() == v1::Physics::ELASTIC) {
      return invalid_argument(
          name + ": \"" + (one == object ? parts.object : parts.other) +
          "\" is ELASTIC, but joints need rigid objects; make it RIGID, or use a fixed region");
    }
  }
  if (auto point = vector_value(*parts.point_m, Eigen::Vector3d::Zero(), name + ".point_m"); !point)
    return point.error();
  if (!parts.axis) return {};
  if (parts.axis->empty()) return invalid_argument(name + ".axis: is missing; give [x, y, z]");
  auto axis = vector_value(*parts.axis, Eigen::Vector3d::Zero(), name + ".axis");
  if (!axis) return axis.error();
  if (axis->norm() < 1e-6) return invalid_argument(name + ".axis: is zero; give a direction");
  return {};
}

std::string joint_line(const v1::Joint& joint) {
  const JointParts parts = parts_of(joint);
  return parts.kind + " " + parts.object + " to " + (parts.other.empty() ? "the world" : parts.other);
}

}  // namespace livegs
