// SPDX-License-Identifier: Apache-2.0
#include "server/export/scene_difference.h"

#include <google/protobuf/util/message_differencer.h>

#include <cmath>
#include <map>

namespace livegs {
namespace {

using Eigen::Vector3d;
using google::protobuf::util::MessageDifferencer;

bool near(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::max(std::abs(a), std::abs(b)) || a == b;
}
bool near(const Vector3d& a, const Vector3d& b, double tolerance) {
  return (a - b).norm() <= tolerance * std::max(1.0, a.norm());
}
bool near(const Pose& a, const Pose& b, double tolerance) {
  return near(a.position_m, b.position_m, tolerance) &&
         (a.orientation.toRotationMatrix() - b.orientation.toRotationMatrix()).norm() <= 3 * tolerance;
}

std::string difference(const PortableShape& a, const PortableShape& b, double tolerance) {
  if (a.kind != b.kind) return "kind of shape";
  if (!near(a.owner_from_shape, b.owner_from_shape, tolerance)) return "pose of a shape";
  if (!near(a.size_m, b.size_m, tolerance) || !near(a.radius_m, b.radius_m, tolerance) ||
      !near(a.height_m, b.height_m, tolerance))
    return "size of a shape";
  if (!near(a.friction, b.friction, tolerance) || !near(a.restitution, b.restitution, tolerance))
    return "material of a shape";
  if (!a.mesh != !b.mesh) return "mesh of a shape";
  if (!a.mesh) return "";
  if (a.convex != b.convex || a.mesh->triangles != b.mesh->triangles ||
      a.mesh->vertices_m.size() != b.mesh->vertices_m.size())
    return "mesh of a shape";
  for (size_t i = 0; i < a.mesh->vertices_m.size(); ++i) {
    if (!near(a.mesh->vertices_m[i], b.mesh->vertices_m[i], tolerance)) return "vertex of a shape";
  }
  return "";
}

std::string difference(const PortableElastic& a, const PortableElastic& b, double tolerance) {
  if (!near(a.youngs_modulus_pa, b.youngs_modulus_pa, tolerance)) return "youngs_modulus_pa";
  if (!near(a.poisson_ratio, b.poisson_ratio, tolerance)) return "poisson_ratio";
  if (!near(a.structure_coefficient, b.structure_coefficient, tolerance)) return "structure_coefficient";
  if (!near(a.plasticity, b.plasticity, tolerance)) return "plasticity";
  if (!near(a.damping, b.damping, tolerance)) return "damping";
  if (!MessageDifferencer::Equals(a.accuracy, b.accuracy)) return "accuracy";
  if (a.regions.size() != b.regions.size()) return "number of regions";
  for (size_t i = 0; i < a.regions.size(); ++i) {
    if (!MessageDifferencer::Equals(a.regions[i], b.regions[i])) return "region";
  }
  if (a.lattice.node_coordinates != b.lattice.node_coordinates) return "lattice nodes";
  if (a.lattice.cells != b.lattice.cells) return "lattice cells";
  if (a.lattice.cell_fills != b.lattice.cell_fills) return "lattice fills";
  if (!near(a.lattice.cell_width_m, b.lattice.cell_width_m, tolerance)) return "cell width";
  if (!near(a.lattice.object_from_lattice, b.lattice.object_from_lattice, tolerance))
    return "pose of the lattice";
  return "";
}

std::string difference(const PortableBody& a, const PortableBody& b, double tolerance,
                       const KernelSteps& steps) {
  if (a.behavior != b.behavior) return "behavior";
  if (a.hidden != b.hidden) return "hidden";
  if (a.drawn_only != b.drawn_only) return "drawn_only";
  if (!near(a.world_from_object, b.world_from_object, tolerance)) return "pose";
  if (!near(a.velocity_m_s, b.velocity_m_s, tolerance)) return "velocity";
  if (!near(a.angular_velocity_rad_s, b.angular_velocity_rad_s, tolerance)) return "angular velocity";
  if (!near(a.mass_kg, b.mass_kg, tolerance)) return "mass";
  if (!near(a.centre_m, b.centre_m, tolerance)) return "centre of mass";
  const Eigen::Matrix3d inertia = a.inertia_tensor_kg_m2();
  if (!((inertia - b.inertia_tensor_kg_m2()).norm() <= tolerance * inertia.norm())) return "inertia";
  if (!a.shapes.empty() && !near(a.friction, b.friction, tolerance)) return "friction";
  if (!a.shapes.empty() && !near(a.restitution, b.restitution, tolerance)) return "restitution";
  if (!MessageDifferencer::Equals(a.estimates, b.estimates)) return "estimates";
  if (a.kernel_count != b.kernel_count) return "number of kernels";
  if (a.kernel_count > 0) {
    if (!a.asset || !b.asset) return "kernels";
    if (auto found = kernel_difference(*a.asset, *b.asset, steps); !found.empty()) return found;
    const Similarity &from = a.object_from_asset, &to = b.object_from_asset;
    if (!near(from.scale, to.scale, tolerance) ||
        !near(Pose{from.translation_m, from.rotation}, Pose{to.translation_m, to.rotation}, tolerance))
      return "place of the kernels";
  }
  if (a.shapes.size() != b.shapes.size()) return "number of shapes";
  for (size_t i = 0; i < a.shapes.size(); ++i) {
    if (auto found = difference(a.shapes[i], b.shapes[i], tolerance); !found.empty()) return found;
  }
  if (a.elastic.has_value() != b.elastic.has_value()) return "elastic";
  return a.elastic ? difference(*a.elastic, *b.elastic, tolerance) : "";
}

std::string difference(const PortableTrack& a, const PortableTrack& b, double tolerance) {
  if (a.world_from_object.size() != b.world_from_object.size()) return "number of keys";
  if (!a.world_from_object.empty() && a.first_key != b.first_key) return "first key";
  for (size_t i = 0; i < a.world_from_object.size(); ++i) {
    if (!near(a.world_from_object[i], b.world_from_object[i], tolerance)) return "pose of a key";
  }
  if (a.nodes_m != b.nodes_m) return "point cache";  // both are floats
  return "";
}

}  // namespace

std::string kernel_difference(const GaussianAsset& a, const GaussianAsset& b, const KernelSteps& steps) {
  if (a.antialiased != b.antialiased) return "antialiased mark";
  if (a.size() != b.size()) return "number of kernels";
  if (a.sh_degree != b.sh_degree) return "degree of the harmonics";
  const auto far = [](const auto& x, const auto& y, float step) {
    return !((x - y).cwiseAbs().maxCoeff() <= step);
  };
  const auto opacity = [](float logit) { return 1 / (1 + std::exp(-logit)); };
  const size_t rest = a.sh_rest_count();
  for (size_t i = 0; i < a.size(); ++i) {
    const auto found = [&](const char* what) {
      return std::string(what) + " of kernel " + std::to_string(i);
    };
    if (far(a.positions[i], b.positions[i], steps.position)) return found("position");
    if (far(a.log_scales[i], b.log_scales[i], steps.log_scale)) return found("scale");
    if (!(std::abs(opacity(a.opacity_logits[i]) - opacity(b.opacity_logits[i])) <= steps.opacity))
      return found("opacity");
    const float turn_deg = a.rotations[i].angularDistance(b.rotations[i]) * 180 / static_cast<float>(M_PI);
    if (!(turn_deg <= steps.rotation_deg)) return found("orientation");
    if (far(a.sh_dc[i], b.sh_dc[i], steps.sh_dc)) return found("colour");
    for (size_t k = 0; k < rest; ++k) {
      if (far(a.sh_rest[i * rest + k], b.sh_rest[i * rest + k], k < 3 ? steps.sh_rest_1 : steps.sh_rest))
        return found("harmonics");
    }
  }
  return "";
}

std::string scene_difference(const PortableScene& a, const PortableScene& b, double tolerance,
                             double motion_tolerance, const KernelSteps& steps) {
  if (a.name != b.name && !b.name.empty()) return "name";
  if (!near(a.gravity_m_s2, b.gravity_m_s2, tolerance)) return "gravity";
  if (!near(a.rate_hz, b.rate_hz, tolerance)) return "rate";
  if (a.bodies.size() != b.bodies.size()) return "number of bodies";
  std::map<std::string, size_t> by_name;
  for (size_t i = 0; i < b.bodies.size(); ++i) by_name[b.bodies[i].name] = i;
  for (const PortableBody& body : a.bodies) {
    const auto found = by_name.find(body.name);
    if (found == by_name.end()) return body.name + ": missing";
    if (auto what = difference(body, b.bodies[found->second], tolerance, steps); !what.empty())
      return body.name + ": " + what;
  }
  if (a.fixed.size() != b.fixed.size()) return "number of colliders";
  for (size_t i = 0; i < a.fixed.size(); ++i) {
    if (auto what = difference(a.fixed[i], b.fixed[i], tolerance); !what.empty()) return what;
  }
  if (a.joints.size() != b.joints.size()) return "number of joints";
  std::vector<bool> used(b.joints.size(), false);
  for (const PortableJoint& joint : a.joints) {  // formats list them in another order
    bool found = false;
    for (size_t i = 0; i < b.joints.size() && !found; ++i) {
      const PortableJoint& other = b.joints[i];
      found = !used[i] && joint.hinge == other.hinge &&
              a.bodies[joint.body].name == b.bodies[other.body].name &&
              joint.other.has_value() == other.other.has_value() &&
              (!joint.other || a.bodies[*joint.other].name == b.bodies[*other.other].name) &&
              near(joint.point_m, other.point_m, tolerance) &&
              (!joint.hinge || near(joint.axis, other.axis, tolerance));
      if (found) used[i] = true;
    }
    if (!found) return "joint of " + a.bodies[joint.body].name;
  }
  if (a.animation.has_value() != b.animation.has_value()) return "animation";
  if (!a.animation) return "";
  if (a.animation->times_s.size() != b.animation->times_s.size()) return "number of times";
  for (size_t i = 0; i < a.animation->times_s.size(); ++i) {
    if (std::abs(a.animation->times_s[i] - b.animation->times_s[i]) > motion_tolerance) return "time";
  }
  if (a.animation->tracks.size() != b.animation->tracks.size()) return "number of tracks";
  for (const PortableTrack& track : a.animation->tracks) {
    bool found = false;
    for (const PortableTrack& other : b.animation->tracks) {
      if (a.bodies[track.body].name != b.bodies[other.body].name) continue;
      found = true;
      if (auto what = difference(track, other, motion_tolerance); !what.empty())
        return "track of " + a.bodies[track.body].name + ": " + what;
    }
    if (!found) return "track of " + a.bodies[track.body].name;
  }
  return "";
}

}  // namespace livegs
