// SPDX-License-Identifier: GPL-3.0-or-later
#include "export/portable_scene.h"

#include "core/math/rotation_between.h"
#include "core/text/format_text.h"
#include "core/text/shown_text.h"

namespace livegs {

Pose joint_frame(const PortableJoint& joint) {
  Pose frame{joint.point_m, Eigen::Quaterniond::Identity()};
  if (joint.hinge) frame.orientation = rotation_between(Eigen::Vector3d::UnitX(), joint.axis);
  return frame;
}

const char* name_of(PortableShape::Kind kind) {
  switch (kind) {
    case PortableShape::Kind::Plane:
      return "plane";
    case PortableShape::Kind::Box:
      return "box";
    case PortableShape::Kind::Sphere:
      return "sphere";
    case PortableShape::Kind::Cylinder:
      return "cylinder";
    case PortableShape::Kind::Capsule:
      return "capsule";
    case PortableShape::Kind::Mesh:
      break;
  }
  return "mesh";
}

std::string body_line(const PortableBody& body) {
  std::string line =
      shown_line(body.name) + ": " +
      (body.drawn_only ? std::string("drawn only") : v1::Physics::Behavior_Name(body.behavior));
  if (body.kernel_count > 0) line += format_text(", %zu kernels", body.kernel_count);
  if (body.drawn_only) return line;
  if (body.mass_kg > 0)
    line += format_text(", %.6g kg, inertia %.4g %.4g %.4g kg m2", body.mass_kg, body.inertia_kg_m2.x(),
                        body.inertia_kg_m2.y(), body.inertia_kg_m2.z());
  line += format_text(", friction %.3g, restitution %.3g", body.friction, body.restitution);
  for (const PortableShape& shape : body.shapes) line += std::string(", ") + name_of(shape.kind);
  if (body.elastic)
    line += format_text("; E %.4g Pa, nu %.3g, damping %.3g, %zu nodes", body.elastic->youngs_modulus_pa,
                        body.elastic->poisson_ratio, body.elastic->damping,
                        body.elastic->lattice.node_coordinates.size());
  return line;
}

std::string joint_text(const PortableScene& scene, const PortableJoint& joint) {
  return std::string(joint.hinge ? "hinge " : "ball ") + shown_line(scene.bodies[joint.body].name) + " to " +
         (joint.other ? shown_line(scene.bodies[*joint.other].name) : std::string("the world"));
}

}  // namespace livegs
