// SPDX-License-Identifier: GPL-3.0-or-later
// The extensions of gltf_scene_writer.cpp. Nodes are visited from the roots of the scene; every index and
// number is checked.
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/file.h"
#include "export/gltf/gltf_values.h"
#include "export/gltf_scene.h"
#include "gaussian/gltf/gltf_mesh.h"

namespace livegs {
namespace {

using namespace gltf;
using Eigen::Affine3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kUnitTolerance = 1e-4;  // of the scale of a body

class SceneDecoder {
 public:
  SceneDecoder(const GltfDocument& document, const GltfReadOptions& options)
      : document_(document), options_(options), values_(document), mesh_reader_(document) {}

  Result<PortableScene> decode() {
    const Json& own = extension_of(document_.json(), "LIVEGS_physics");
    if (!own.is_null()) {
      const auto gravity = values_.vector(own, "gravity_m_s2", scene_.gravity_m_s2, "LIVEGS_physics");
      if (!gravity) return gravity.error();
      scene_.gravity_m_s2 = *gravity;
      const auto rate = values_.number(own, "rate_hz", scene_.rate_hz, "LIVEGS_physics");
      if (!rate) return rate.error();
      scene_.rate_hz = *rate;
    }
    if (auto walked = walk(); !walked) return walked.error();
    for (const Visit& visit : visits_) {
      if (auto taken = take_body(visit); !taken) return taken.error();
    }
    for (const Visit& visit : visits_) {
      if (auto taken = take_parts(visit); !taken) return taken.error();
    }
    auto animation = read_animation(values_, own, scene_.bodies, body_of_node_);
    if (!animation) return animation.error();
    scene_.animation = std::move(*animation);
    return std::move(scene_);
  }

 private:
  struct Visit {
    size_t node = 0;
    std::optional<size_t> parent;  // index in visits_
    Affine3d world_from_node = Affine3d::Identity();
    std::optional<size_t> body;  // of the node or its nearest ancestor with one
  };

  Result<Affine3d> placement(const Json& node, size_t index) const {
    const std::string where = name_of_node(index);
    Affine3d result = Affine3d::Identity();
    if (node.contains("matrix")) {
      const auto matrix = values_.numbers<16>(node, "matrix", Eigen::Matrix<double, 16, 1>::Zero(), where);
      if (!matrix) return matrix.error();
      result.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix->data());
      result.makeAffine();
      return result;
    }
    const auto translation = values_.vector(node, "translation", Vector3d::Zero(), where);
    const auto rotation = values_.quaternion(node, "rotation", where);
    const auto scale = values_.vector(node, "scale", Vector3d::Ones(), where);
    if (!translation) return translation.error();
    if (!rotation) return rotation.error();
    if (!scale) return scale.error();
    // A body that is there only for a time has size zero without the animation.
    const Vector3d sizes = scale->isZero(0) ? Vector3d(Vector3d::Ones()) : *scale;
    result.translate(*translation);
    result.rotate(*rotation);
    result.scale(sizes);
    return result;
  }

  Result<void> walk() {
    const Json& nodes = part_of(document_.json(), "nodes");
    const Json& scenes = part_of(document_.json(), "scenes");
    if (!nodes.is_array() || !scenes.is_array() || scenes.empty()) return {};
    const Json first = 0;
    const auto scene =
        document_.entry("scenes", document_.json().contains("scene") ? document_.json()["scene"] : first);
    if (!scene) return scene.error();
    scene_.name = text_of(**scene, "name");
    visit_of_node_.assign(nodes.size(), std::nullopt);
    std::vector<std::pair<size_t, std::optional<size_t>>> open;  // node, index of its parent in visits_
    std::vector<bool> seen(nodes.size(), false);
    const auto add = [&](const Json& list, std::optional<size_t> parent) -> Result<void> {
      if (!list.is_array()) return {};
      for (auto index = list.rbegin(); index != list.rend(); ++index) {
        const auto node = document_.entry("nodes", *index);
        if (!node) return node.error();
        const auto at = static_cast<size_t>(index->get<double>());
        if (seen[at]) return values_.problem(name_of_node(at) + " has two parents");
        seen[at] = true;
        open.emplace_back(at, parent);
      }
      return {};
    };
    if (auto added = add(part_of(**scene, "nodes"), std::nullopt); !added) return added;
    while (!open.empty()) {
      const auto [at, parent] = open.back();
      open.pop_back();
      const auto own = placement(nodes[at], at);
      if (!own) return own.error();
      Visit visit;
      visit.node = at;
      visit.parent = parent;
      visit.world_from_node = parent ? visits_[*parent].world_from_node * *own : *own;
      if (!visit.world_from_node.matrix().allFinite())
        return values_.bad(name_of_node(at), "lies too far away");
      visit_of_node_[at] = visits_.size();
      visits_.push_back(visit);
      if (auto added = add(part_of(nodes[at], "children"), visits_.size() - 1); !added) return added;
    }
    return {};
  }

  const Json& node_of(const Visit& visit) const { return document_.json()["nodes"][visit.node]; }

  // The rigid part of a placement.
  static Pose pose_of(const Affine3d& placement) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(placement.linear(),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d turn = svd.matrixU() * svd.matrixV().transpose();
    if (turn.determinant() < 0) turn = -turn;
    return {placement.translation(), Quaterniond(turn).normalized()};
  }

  static Affine3d affine_of(const Pose& pose) {
    return Eigen::Translation3d(pose.position_m) * Affine3d(pose.orientation);
  }

  // A body is a node with motion or with LIVEGS_physics; its nodes are those below it.
  Result<void> take_body(const Visit& visit) {
    const size_t at = static_cast<size_t>(&visit - visits_.data());
    const Json& node = node_of(visit);
    const Json& own = extension_of(node, "LIVEGS_physics");
    const Json& motion = part_of(extension_of(node, "KHR_physics_rigid_bodies"), "motion");
    if (visit.parent) visits_[at].body = visits_[*visit.parent].body;
    if (!own.is_object() && !motion.is_object()) return {};
    const std::string where = name_of_node(visit.node);
    PortableBody body;
    body.name = text_of(node, "name");
    body.world_from_object = pose_of(visit.world_from_node);
    if ((visit.world_from_node.linear() - body.world_from_object.orientation.toRotationMatrix()).norm() >
        kUnitTolerance)
      scene_.notes.push_back(where + ": is scaled; its mass and inertia are read as they are");
    v1::Physics::Behavior behavior = motion.is_object() ? v1::Physics::RIGID : v1::Physics::STATIC;
    const std::string word = text_of(own, "behavior");
    if (!word.empty() && !v1::Physics::Behavior_Parse(word, &behavior))
      return values_.bad(where, "has an unknown LIVEGS_physics.behavior");
    body.behavior = behavior;
    body.hidden = flag_of(own, "hidden");
    body.drawn_only = flag_of(own, "drawn_only");
    const Json& estimates = part_of(own, "estimates");
    if (!estimates.is_null() && !read_message(estimates, body.estimates))
      return values_.bad(where, "has no valid LIVEGS_physics.estimates");
    if (motion.is_object()) {
      if (auto taken = take_motion(motion, where, body); !taken) return taken;
    }
    const Json& elastic = part_of(own, "elastic");
    if (!elastic.is_null()) {
      auto read = read_elastic(values_, elastic, where);
      if (!read) return read.error();
      body.elastic = std::move(*read);
    }
    visits_[at].body = scene_.bodies.size();
    body_of_node_[visit.node] = scene_.bodies.size();
    scene_.bodies.push_back(std::move(body));
    return {};
  }

  Result<void> take_motion(const Json& motion, const std::string& where, PortableBody& body) const {
    const auto mass = values_.number(motion, "mass", 0, where);
    const auto centre = values_.vector(motion, "centerOfMass", Vector3d::Zero(), where);
    const auto inertia = values_.vector(motion, "inertiaDiagonal", Vector3d::Zero(), where);
    const auto axes = values_.quaternion(motion, "inertiaOrientation", where);
    const auto velocity = values_.vector(motion, "linearVelocity", Vector3d::Zero(), where);
    const auto spin = values_.vector(motion, "angularVelocity", Vector3d::Zero(), where);
    if (!mass) return mass.error();
    if (!centre) return centre.error();
    if (!inertia) return inertia.error();
    if (!axes) return axes.error();
    if (!velocity) return velocity.error();
    if (!spin) return spin.error();
    if (*mass < 0 || inertia->minCoeff() < 0) return values_.bad(where, "has a negative mass or inertia");
    body.mass_kg = flag_of(motion, "isKinematic") ? 0 : *mass;
    body.centre_m = *centre;
    body.inertia_kg_m2 = *inertia;
    body.object_from_inertia = *axes;
    body.velocity_m_s = body.world_from_object.orientation * *velocity;
    body.angular_velocity_rad_s = body.world_from_object.orientation * *spin;
    return {};
  }

  // Colliders, kernels and joints of a node.
  Result<void> take_parts(const Visit& visit) {
    const Json& node = node_of(visit);
    const Json& bodies = extension_of(node, "KHR_physics_rigid_bodies");
    if (const Json& collider = part_of(bodies, "collider"); collider.is_object()) {
      if (auto taken = take_collider(collider, visit); !taken) return taken;
    }
    if (const Json& joint = part_of(bodies, "joint"); joint.is_object()) {
      if (auto taken = take_joint(joint, visit); !taken) return taken;
    }
    if (node.contains("mesh") && visit.body) return take_splats(node["mesh"], visit);
    return {};
  }

  struct MeshKernels {
    std::shared_ptr<const GaussianAsset> asset;  // null: counted only
    size_t count = 0;
  };

  Result<MeshKernels> kernels_of(const Json& mesh) {
    if (!options_.kernels) {
      const auto count = mesh_reader_.count(mesh);
      if (!count) return count.error();
      return MeshKernels{nullptr, *count};
    }
    auto asset = mesh_reader_.read(mesh);
    if (!asset) return asset.error();
    const size_t count = asset->size();
    return MeshKernels{std::make_shared<const GaussianAsset>(std::move(*asset)), count};
  }

  // The kernels of a mesh. Those of one node become the asset of the body.
  Result<void> take_splats(const Json& index, const Visit& visit) {
    const auto mesh = document_.entry("meshes", index);
    if (!mesh) return mesh.error();
    const auto [kept, fresh] = meshes_.try_emplace(*mesh);  // nodes may share a mesh
    if (fresh) {
      auto kernels = kernels_of(index);
      if (!kernels) return kernels.error();
      kept->second = std::move(*kernels);
    }
    const MeshKernels& kernels = kept->second;
    if (kernels.count == 0) return {};
    PortableBody& body = scene_.bodies[*visit.body];
    const Affine3d object_from_node = affine_of(body.world_from_object.inverse()) * visit.world_from_node;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(object_from_node.linear());
    const Vector3d sizes = svd.singularValues();
    const bool alone = body.kernel_count == 0;
    body.kernel_count += kernels.count;
    body.asset.reset();
    if (!alone || sizes[0] - sizes[2] > kUnitTolerance * sizes[0] ||
        object_from_node.linear().determinant() <= 0) {
      scene_.notes.push_back(name_of_node(visit.node) +
                             ": has kernels that are stretched, or not the only ones of their body; counted");
      return {};
    }
    const Pose pose = pose_of(object_from_node);
    body.asset = kernels.asset;
    body.object_from_asset = {sizes.mean(), (pose.orientation * Quaterniond(0, 1, 0, 0)).normalized(),
                              pose.position_m};
    return {};
  }

  Result<void> take_collider(const Json& collider, const Visit& visit) {
    auto shape = read_collider(values_, collider, name_of_node(visit.node));
    if (!shape) return shape.error();
    const Pose world_from_shape = pose_of(visit.world_from_node);
    if (!visit.body) {
      shape->owner_from_shape = world_from_shape;
      scene_.fixed.push_back(std::move(*shape));
      return {};
    }
    PortableBody& body = scene_.bodies[*visit.body];
    shape->owner_from_shape = body.world_from_object.inverse() * world_from_shape;
    body.friction = shape->friction;
    body.restitution = shape->restitution;
    body.shapes.push_back(std::move(*shape));
    return {};
  }

  Result<void> take_joint(const Json& json, const Visit& visit) {
    const std::string where = name_of_node(visit.node);
    if (!visit.body || scene_.bodies[*visit.body].mass_kg <= 0) {
      scene_.notes.push_back(where + ": has a joint, but no body with motion; left out");
      return {};
    }
    const Json& list = part_of(extension_of(document_.json(), "KHR_physics_rigid_bodies"), "physicsJoints");
    const auto entry = values_.entry_of(list, part_of(json, "joint"), where, "joint");
    if (!entry) return entry.error();
    const auto other = document_.entry("nodes", part_of(json, "connectedNode"));
    if (!other) return other.error();
    const auto other_at = visit_of_node_[static_cast<size_t>(json["connectedNode"].get<double>())];
    if (!other_at) return values_.bad(where, "has a joint to a node outside of the scene");
    PortableJoint joint;
    joint.body = *visit.body;
    joint.other = visits_[*other_at].body;
    if (joint.other == joint.body) return values_.bad(where, "has a joint of a body to itself");
    // Which axes are locked. Limits with a range, and drives, have no counterpart here.
    std::array<bool, 3> linear{}, angular{};
    const Json& limits = part_of(**entry, "limits");
    bool known = limits.is_array() && part_of(**entry, "drives").is_null();
    for (size_t i = 0; known && i < limits.size(); ++i) {
      const auto low = values_.number(limits[i], "min", -1, where),
                 high = values_.number(limits[i], "max", 1, where);
      known = low && high && *low == 0 && *high == 0;
      for (const auto& [key, axes] : {std::pair{"linearAxes", &linear}, std::pair{"angularAxes", &angular}}) {
        const Json& locked = part_of(limits[i], key);
        for (size_t k = 0; locked.is_array() && k < locked.size(); ++k) {
          const double axis = locked[k].is_number() ? locked[k].get<double>() : -1;
          if (!(axis == 0 || axis == 1 || axis == 2))
            return values_.bad(where, "has a joint with an unknown axis");
          (*axes)[static_cast<size_t>(axis)] = true;
        }
      }
    }
    const auto turning = std::count(angular.begin(), angular.end(), false);
    known = known && std::count(linear.begin(), linear.end(), true) == 3 && (turning == 3 || turning == 1);
    if (!known) {
      scene_.notes.push_back(where + ": has a joint that is neither a ball nor a free hinge; left out");
      return {};
    }
    const Pose frame = scene_.bodies[joint.body].world_from_object.inverse() * pose_of(visit.world_from_node);
    joint.hinge = turning == 1;
    joint.point_m = frame.position_m;
    const auto free = std::find(angular.begin(), angular.end(), false) - angular.begin();
    joint.axis =
        joint.hinge ? frame.orientation * Vector3d(Vector3d::Unit(free)) : Vector3d(Vector3d::UnitX());
    scene_.joints.push_back(joint);
    return {};
  }

  const GltfDocument& document_;
  GltfReadOptions options_;
  Values values_;
  PortableScene scene_;
  std::vector<Visit> visits_;  // parents before their children
  std::vector<std::optional<size_t>> visit_of_node_;
  std::map<size_t, size_t> body_of_node_;
  std::map<const Json*, MeshKernels> meshes_;
  GltfMeshReader mesh_reader_;
};

}  // namespace

Result<PortableScene> decode_gltf_scene(std::span<const std::byte> bytes, const std::filesystem::path& folder,
                                        std::string_view name, const GltfReadOptions& options) {
  const auto document = GltfDocument::open(bytes, folder, name);
  if (!document) return document.error();
  return SceneDecoder(*document, options).decode();
}

Result<PortableScene> read_gltf_scene(const std::filesystem::path& path, const GltfReadOptions& options) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return decode_gltf_scene(*bytes, path.parent_path().empty() ? "." : path.parent_path(),
                           path.filename().string(), options);
}

}  // namespace livegs
