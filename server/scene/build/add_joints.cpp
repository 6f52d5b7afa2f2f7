// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/add_joints.h"

#include "scene/check/joint_parts.h"
#include "scene/values/scene_values.h"

namespace livegs {

Result<void> add_joints(const v1::Scene& file,
                        const std::function<const SceneObject*(const std::string&)>& find, World& world) {
  for (int i = 0; i < file.joints_size(); ++i) {
    const JointParts parts = parts_of(file.joints(i));
    const std::string name = "joints[" + std::to_string(i) + "]." + parts.kind;
    HingeJointDescription hinge;
    for (const std::string& part : {parts.object, parts.other}) {
      if (part.empty()) continue;
      const SceneObject* object = find(part);
      // The behaviour of AUTO objects is known only after they are built.
      const v1::Physics::Behavior behavior = object->physics.behavior();
      if (behavior == v1::Physics::ELASTIC || (part == parts.object && behavior == v1::Physics::STATIC)) {
        return invalid_argument(name + ": \"" + part + "\" is " + v1::Physics::Behavior_Name(behavior) +
                                ", but joints need rigid objects; set its physics.behavior to RIGID");
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

}  // namespace livegs
