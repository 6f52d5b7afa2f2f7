// SPDX-License-Identifier: GPL-3.0-or-later
// The extensions of gltf_scene_writer.cpp. Nodes are visited from the roots of the scene; every index and
// number is checked.
#include <google/protobuf/util/json_util.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/file.h"
#include "export/gltf_scene.h"
#include "gaussian/gltf/gltf_document.h"

namespace livegs {
namespace {

using Json = nlohmann::json;
using Eigen::Affine3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Kind = PortableShape::Kind;

constexpr double kMaxNumber = 1e15;  // of a node, a mass, a measure
// Nodes may share meshes and accessors: the numbers of all together take at most this many times the bytes of
// the file.
constexpr uint64_t kMaxRepeats = 32;
constexpr double kUnitTolerance = 1e-4;  // of the scale of a body

const Json& part_of(const Json& object, const char* key) {
  static const Json kNone;
  const auto found = object.is_object() ? object.find(key) : object.end();
  return object.is_object() && found != object.end() ? *found : kNone;
}

const Json& extension_of(const Json& object, const char* name) {
  return part_of(part_of(object, "extensions"), name);
}

bool flag_of(const Json& object, const char* key) {
  const Json& value = part_of(object, key);
  return value.is_boolean() && value.get<bool>();
}

std::string text_of(const Json& object, const char* key) {
  const Json& value = part_of(object, key);
  return value.is_string() ? value.get<std::string>() : std::string();
}

// Deeper values are refused: their text is made by a function that calls itself.
bool nests_within(const Json& json, int depth) {
  if (!json.is_structured()) return true;
  return depth > 0 &&
         std::all_of(json.begin(), json.end(), [&](const Json& one) { return nests_within(one, depth - 1); });
}

template <class Message>
bool read_message(const Json& json, Message& message) {
  if (!nests_within(json, 16)) return false;
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  return google::protobuf::util::JsonStringToMessage(
             json.dump(-1, ' ', false, Json::error_handler_t::replace), &message, options)
      .ok();
}

class SceneDecoder {
 public:
  explicit SceneDecoder(const GltfDocument& document) : document_(document) {}

  Result<PortableScene> decode() {
    const Json& own = extension_of(document_.json(), "LIVEGS_physics");
    if (!own.is_null()) {
      const auto gravity = vector(own, "gravity_m_s2", scene_.gravity_m_s2, "LIVEGS_physics");
      if (!gravity) return gravity.error();
      scene_.gravity_m_s2 = *gravity;
      const auto rate = number(own, "rate_hz", scene_.rate_hz, "LIVEGS_physics");
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
    if (auto taken = take_animation(own); !taken) return taken.error();
    return std::move(scene_);
  }

 private:
  struct Visit {
    size_t node = 0;
    std::optional<size_t> parent;  // index in visits_
    Affine3d world_from_node = Affine3d::Identity();
    std::optional<size_t> body;  // of the node or its nearest ancestor with one
  };

  Error bad(const std::string& where, const std::string& what) const {
    return document_.problem(where + " " + what);
  }

  Result<double> number(const Json& object, const char* key, double fallback,
                        const std::string& where) const {
    const Json& value = part_of(object, key);
    if (value.is_null()) return fallback;
    const double got = value.is_number() ? value.get<double>() : NAN;
    if (!(std::abs(got) <= kMaxNumber)) return bad(where, std::string("has no valid ") + key);
    return got;
  }

  // Counts numbers that are kept.
  Result<void> spend(size_t count) const {
    spent_ += count;
    if (spent_ <= kMaxRepeats * document_.total_bytes()) return {};
    return document_.problem("repeats its numbers more often than a file of its size may");
  }

  template <int N>
  Result<Eigen::Matrix<double, N, 1>> numbers(const Json& object, const char* key,
                                              const Eigen::Matrix<double, N, 1>& fallback,
                                              const std::string& where) const {
    const Json& value = part_of(object, key);
    if (value.is_null()) return fallback;
    Eigen::Matrix<double, N, 1> got;
    bool valid = value.is_array() && value.size() == static_cast<size_t>(N);
    for (size_t i = 0; valid && i < static_cast<size_t>(N); ++i) {
      got[static_cast<int>(i)] = value[i].is_number() ? value[i].get<double>() : NAN;
      valid = std::abs(got[static_cast<int>(i)]) <= kMaxNumber;
    }
    if (!valid) return bad(where, std::string("has no valid ") + key);
    return got;
  }
  Result<Vector3d> vector(const Json& object, const char* key, const Vector3d& fallback,
                          const std::string& where) const {
    return numbers<3>(object, key, fallback, where);
  }
  Result<Quaterniond> quaternion(const Json& object, const char* key, const std::string& where) const {
    const auto read = numbers<4>(object, key, Eigen::Vector4d(0, 0, 0, 1), where);
    if (!read) return read.error();
    if (!(read->norm() > 0.5 && read->norm() < 2)) return bad(where, std::string("has no valid ") + key);
    return Quaterniond(read->normalized());
  }

  static std::string name_of_node(size_t index) { return "nodes[" + std::to_string(index) + "]"; }

  Result<Affine3d> placement(const Json& node, size_t index) const {
    const std::string where = name_of_node(index);
    Affine3d result = Affine3d::Identity();
    if (node.contains("matrix")) {
      const auto matrix = numbers<16>(node, "matrix", Eigen::Matrix<double, 16, 1>::Zero(), where);
      if (!matrix) return matrix.error();
      result.matrix() = Eigen::Map<const Eigen::Matrix4d>(matrix->data());
      result.makeAffine();
      return result;
    }
    const auto translation = vector(node, "translation", Vector3d::Zero(), where);
    const auto rotation = quaternion(node, "rotation", where);
    const auto scale = vector(node, "scale", Vector3d::Ones(), where);
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
        if (seen[at]) return document_.problem(name_of_node(at) + " has two parents");
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
      if (!visit.world_from_node.matrix().allFinite()) return bad(name_of_node(at), "lies too far away");
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
      return bad(where, "has an unknown LIVEGS_physics.behavior");
    body.behavior = behavior;
    body.hidden = flag_of(own, "hidden");
    body.drawn_only = flag_of(own, "drawn_only");
    const Json& estimates = part_of(own, "estimates");
    if (!estimates.is_null() && !read_message(estimates, body.estimates))
      return bad(where, "has no valid LIVEGS_physics.estimates");
    if (motion.is_object()) {
      if (auto taken = take_motion(motion, where, body); !taken) return taken;
    }
    const Json& elastic = part_of(own, "elastic");
    if (!elastic.is_null()) {
      if (auto taken = take_elastic(elastic, where, body); !taken) return taken;
    }
    visits_[at].body = scene_.bodies.size();
    body_of_node_[visit.node] = scene_.bodies.size();
    scene_.bodies.push_back(std::move(body));
    return {};
  }

  Result<void> take_motion(const Json& motion, const std::string& where, PortableBody& body) const {
    const auto mass = number(motion, "mass", 0, where);
    const auto centre = vector(motion, "centerOfMass", Vector3d::Zero(), where);
    const auto inertia = vector(motion, "inertiaDiagonal", Vector3d::Zero(), where);
    const auto axes = quaternion(motion, "inertiaOrientation", where);
    const auto velocity = vector(motion, "linearVelocity", Vector3d::Zero(), where);
    const auto spin = vector(motion, "angularVelocity", Vector3d::Zero(), where);
    if (!mass) return mass.error();
    if (!centre) return centre.error();
    if (!inertia) return inertia.error();
    if (!axes) return axes.error();
    if (!velocity) return velocity.error();
    if (!spin) return spin.error();
    if (*mass < 0 || inertia->minCoeff() < 0) return bad(where, "has a negative mass or inertia");
    body.mass_kg = flag_of(motion, "isKinematic") ? 0 : *mass;
    body.centre_m = *centre;
    body.inertia_kg_m2 = *inertia;
    body.object_from_inertia = *axes;
    body.velocity_m_s = body.world_from_object.orientation * *velocity;
    body.angular_velocity_rad_s = body.world_from_object.orientation * *spin;
    return {};
  }

  // The values of a scalar accessor of whole numbers.
  Result<std::vector<uint32_t>> whole_numbers(const Json& accessor) const {
    const auto list = document_.numbers(accessor, 1);
    if (!list) return list.error();
    if (auto within = spend(list->count); !within) return within.error();
    std::vector<uint32_t> values(list->count);
    for (size_t i = 0; i < values.size(); ++i) {
      const double value = list->at(i, 0);
      if (!(value >= 0 && value <= 4294967295.0 && value == std::floor(value)))
        return document_.problem("an accessor of whole numbers has others");
      values[i] = static_cast<uint32_t>(value);
    }
    return values;
  }

  Result<void> take_elastic(const Json& json, const std::string& where, PortableBody& body) const {
    PortableElastic elastic;
    const std::pair<const char*, double*> values[] = {
        {"youngs_modulus_pa", &elastic.youngs_modulus_pa},
        {"poisson_ratio", &elastic.poisson_ratio},
        {"structure_coefficient", &elastic.structure_coefficient},
        {"plasticity", &elastic.plasticity},
        {"damping", &elastic.damping}};
    for (const auto& [key, value] : values) {
      const auto read = number(json, key, *value, where);
      if (!read) return read.error();
      *value = *read;
    }
    if (json.contains("accuracy") && !read_message(json["accuracy"], elastic.accuracy))
      return bad(where, "has no valid elastic.accuracy");
    if (const Json& regions = part_of(json, "regions"); regions.is_array()) {
      for (const Json& region : regions) {
        if (!read_message(region, elastic.regions.emplace_back()))
          return bad(where, "has no valid elastic.regions");
      }
    }
    const Json& lattice = part_of(json, "lattice");
    if (lattice.is_object()) {
      RestBody& rest = elastic.lattice;
      rest.kind = DriverKind::Lattice;
      const auto width = number(lattice, "cell_width_m", 0, where);
      const auto position = vector(lattice, "translation", Vector3d::Zero(), where);
      const auto orientation = quaternion(lattice, "rotation", where);
      const auto nodes = document_.numbers(part_of(lattice, "nodes"), 3);
      if (!width) return width.error();
      if (!position) return position.error();
      if (!orientation) return orientation.error();
      if (!nodes) return nodes.error();
      if (auto within = spend(3 * nodes->count); !within) return within;
      if (!(*width > 0)) return bad(where, "has a lattice without a cell_width_m above 0");
      rest.cell_width_m = *width;
      rest.object_from_lattice = {*position, *orientation};
      for (size_t i = 0; i < nodes->count; ++i) {
        Eigen::Vector3i node;
        for (size_t axis = 0; axis < 3; ++axis) {
          const double value = nodes->at(i, axis);
          if (!(std::abs(value) <= 1e6 && value == std::floor(value)))
            return bad(where, "has a lattice node that is not a whole number");
          node[static_cast<int>(axis)] = static_cast<int>(value);
        }
        rest.node_coordinates.push_back(node);
      }
      if (lattice.contains("cells")) {
        const auto cells = whole_numbers(lattice["cells"]);
        if (!cells) return cells.error();
        if (cells->size() % 8 != 0) return bad(where, "has a lattice cell without eight nodes");
        for (const uint32_t node : *cells) {
          if (node >= rest.node_coordinates.size())
            return bad(where, "has a lattice cell of a node that does not exist");
        }
        for (size_t i = 0; i < cells->size(); i += 8) {
          std::copy_n(cells->begin() + static_cast<std::ptrdiff_t>(i), 8, rest.cells.emplace_back().begin());
        }
      }
      if (lattice.contains("cell_fills")) {
        const auto fills = whole_numbers(lattice["cell_fills"]);
        if (!fills) return fills.error();
        if (fills->size() != 2 * rest.cells.size()) return bad(where, "has another number of cell_fills");
        for (size_t i = 0; i < fills->size(); i += 2)
          rest.cell_fills.push_back((*fills)[i] | uint64_t{(*fills)[i + 1]} << 32);
      }
    }
    body.elastic = std::move(elastic);
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
    if (node.contains("mesh") && visit.body) {
      const auto mesh = document_.entry("meshes", node["mesh"]);
      if (!mesh) return mesh.error();
      const Json& primitives = part_of(**mesh, "primitives");
      if (!primitives.is_array()) return {};
      for (const Json& primitive : primitives) {
        if (extension_of(primitive, "KHR_gaussian_splatting").is_null()) continue;
        const auto accessor =
            document_.entry("accessors", part_of(part_of(primitive, "attributes"), "POSITION"));
        if (!accessor) return accessor.error();
        const auto count = number(**accessor, "count", 0, "an accessor");
        if (!count) return count.error();
        scene_.bodies[*visit.body].kernel_count += static_cast<size_t>(std::max(*count, 0.0));
      }
    }
    return {};
  }

  Result<void> take_collider(const Json& collider, const Visit& visit) {
    const std::string where = name_of_node(visit.node);
    PortableShape shape;
    const Json& geometry = part_of(collider, "geometry");
    if (geometry.contains("shape")) {
      if (auto taken = take_shape(geometry["shape"], where, shape); !taken) return taken;
    } else {
      Json mesh = part_of(geometry, "mesh");
      if (mesh.is_null()) {
        const auto node = document_.entry("nodes", part_of(geometry, "node"));
        if (!node) return node.error();
        mesh = part_of(**node, "mesh");
      }
      if (auto taken = take_mesh(mesh, where, shape); !taken) return taken;
      shape.convex = flag_of(geometry, "convexHull");
    }
    if (collider.contains("physicsMaterial")) {
      const Json& materials =
          part_of(extension_of(document_.json(), "KHR_physics_rigid_bodies"), "physicsMaterials");
      const auto material = entry_of(materials, collider["physicsMaterial"], where, "physicsMaterial");
      if (!material) return material.error();
      const auto friction = number(**material, "dynamicFriction", shape.friction, where);
      const auto restitution = number(**material, "restitution", shape.restitution, where);
      if (!friction) return friction.error();
      if (!restitution) return restitution.error();
      shape.friction = *friction;
      shape.restitution = *restitution;
    }
    const Pose world_from_shape = pose_of(visit.world_from_node);
    if (!visit.body) {
      shape.owner_from_shape = world_from_shape;
      scene_.fixed.push_back(std::move(shape));
      return {};
    }
    PortableBody& body = scene_.bodies[*visit.body];
    shape.owner_from_shape = body.world_from_object.inverse() * world_from_shape;
    body.friction = shape.friction;
    body.restitution = shape.restitution;
    body.shapes.push_back(std::move(shape));
    return {};
  }

  Result<const Json*> entry_of(const Json& list, const Json& index, const std::string& where,
                               const char* key) const {
    const double at = index.is_number() ? index.get<double>() : -1;
    if (!list.is_array() || !(at >= 0) || !(at < static_cast<double>(list.size())) || at != std::floor(at))
      return bad(where, std::string("has no valid ") + key);
    return &list[static_cast<size_t>(at)];
  }

  Result<void> take_shape(const Json& index, const std::string& where, PortableShape& shape) const {
    const Json& shapes = part_of(extension_of(document_.json(), "KHR_implicit_shapes"), "shapes");
    const auto entry = entry_of(shapes, index, where, "shape");
    if (!entry) return entry.error();
    const std::string type = text_of(**entry, "type");
    const Json& measures = part_of(**entry, type.c_str());
    static constexpr Kind kKinds[] = {Kind::Plane, Kind::Box, Kind::Sphere, Kind::Cylinder, Kind::Capsule};
    const auto* kind =
        std::find_if(std::begin(kKinds), std::end(kKinds), [&](Kind one) { return type == name_of(one); });
    if (kind == std::end(kKinds)) return bad(where, "has a shape of an unknown type");
    shape.kind = *kind;
    const auto size = vector(measures, "size", Vector3d::Ones(), where);
    const auto radius = number(measures, "radius", 0.5, where);
    const auto bottom = number(measures, "radiusBottom", 0.25, where);
    const auto top = number(measures, "radiusTop", 0.25, where);
    const auto height = number(measures, "height", 0.5, where);
    if (!size) return size.error();
    if (!radius) return radius.error();
    if (!bottom) return bottom.error();
    if (!top) return top.error();
    if (!height) return height.error();
    if (shape.kind == Kind::Box) shape.size_m = *size;
    if (shape.kind == Kind::Sphere) shape.radius_m = *radius;
    if (shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule) {
      if (*bottom != *top)
        return document_.missing(where + " has a shape with two radii, which is not supported; use a mesh");
      shape.radius_m = *bottom;
      shape.height_m = *height;
    }
    return {};
  }

  Result<void> take_mesh(const Json& index, const std::string& where, PortableShape& shape) const {
    const auto mesh = document_.entry("meshes", index);
    if (!mesh) return mesh.error();
    auto read = std::make_shared<TriangleMesh>();
    const Json& primitives = part_of(**mesh, "primitives");
    if (!primitives.is_array()) return bad(where, "has a collider mesh without primitives");
    for (const Json& primitive : primitives) {
      if (part_of(primitive, "mode").is_number() && primitive["mode"] != 4) continue;
      const auto positions = document_.numbers(part_of(part_of(primitive, "attributes"), "POSITION"), 3);
      if (!positions) return positions.error();
      if (auto within = spend(6 * positions->count); !within) return within;
      const auto first = static_cast<uint32_t>(read->vertices_m.size());
      for (size_t i = 0; i < positions->count; ++i)
        read->vertices_m.emplace_back(positions->at(i, 0), positions->at(i, 1), positions->at(i, 2));
      std::vector<uint32_t> indices(positions->count);
      for (size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<uint32_t>(i);
      if (primitive.contains("indices")) {
        auto listed = whole_numbers(primitive["indices"]);
        if (!listed) return listed.error();
        indices = std::move(*listed);
      }
      for (size_t i = 0; i + 2 < indices.size(); i += 3) {
        for (size_t k = 0; k < 3; ++k) {
          if (indices[i + k] >= positions->count) return bad(where, "has a collider mesh with a wrong index");
        }
        read->triangles.push_back({first + indices[i], first + indices[i + 1], first + indices[i + 2]});
      }
    }
    if (read->triangles.empty()) return bad(where, "has a collider mesh without triangles");
    for (const Vector3d& vertex : read->vertices_m) {
      if (!(vertex.cwiseAbs().maxCoeff() <= kMaxNumber))
        return bad(where, "has a collider mesh with a wrong vertex");
    }
    shape.kind = Kind::Mesh;
    shape.mesh = std::move(read);
    return {};
  }

  Result<void> take_joint(const Json& json, const Visit& visit) {
    const std::string where = name_of_node(visit.node);
    if (!visit.body || scene_.bodies[*visit.body].mass_kg <= 0) {
      scene_.notes.push_back(where + ": has a joint, but no body with motion; left out");
      return {};
    }
    const Json& list = part_of(extension_of(document_.json(), "KHR_physics_rigid_bodies"), "physicsJoints");
    const auto entry = entry_of(list, part_of(json, "joint"), where, "joint");
    if (!entry) return entry.error();
    const auto other = document_.entry("nodes", part_of(json, "connectedNode"));
    if (!other) return other.error();
    const auto other_at = visit_of_node_[static_cast<size_t>(json["connectedNode"].get<double>())];
    if (!other_at) return bad(where, "has a joint to a node outside of the scene");
    PortableJoint joint;
    joint.body = *visit.body;
    joint.other = visits_[*other_at].body;
    if (joint.other == joint.body) return bad(where, "has a joint of a body to itself");
    // Which axes are locked. Limits with a range, and drives, have no counterpart here.
    std::array<bool, 3> linear{}, angular{};
    const Json& limits = part_of(**entry, "limits");
    bool known = limits.is_array() && part_of(**entry, "drives").is_null();
    for (size_t i = 0; known && i < limits.size(); ++i) {
      const auto low = number(limits[i], "min", -1, where), high = number(limits[i], "max", 1, where);
      known = low && high && *low == 0 && *high == 0;
      for (const auto& [key, axes] : {std::pair{"linearAxes", &linear}, std::pair{"angularAxes", &angular}}) {
        const Json& locked = part_of(limits[i], key);
        for (size_t k = 0; locked.is_array() && k < locked.size(); ++k) {
          const double axis = locked[k].is_number() ? locked[k].get<double>() : -1;
          if (!(axis == 0 || axis == 1 || axis == 2)) return bad(where, "has a joint with an unknown axis");
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

  Result<void> take_animation(const Json& own) {
    const Json& index = part_of(own, "times");
    if (index.is_null()) return {};
    PortableAnimation animation;
    const auto times = document_.numbers(index, 1);
    if (!times) return times.error();
    for (size_t i = 0; i < times->count; ++i) {
      animation.times_s.push_back(times->at(i, 0));
      if (!std::isfinite(animation.times_s[i]) ||
          (i > 0 && !(animation.times_s[i] > animation.times_s[i - 1])))
        return document_.problem("the times of the animation do not increase");
    }
    // The samplers of each node by path.
    std::map<std::pair<size_t, std::string>, const Json*> outputs;
    const Json& animations = part_of(document_.json(), "animations");
    if (animations.is_array() && !animations.empty()) {
      const Json& channels = part_of(animations[0], "channels");
      const Json& samplers = part_of(animations[0], "samplers");
      for (size_t i = 0; channels.is_array() && i < channels.size(); ++i) {
        const auto sampler = entry_of(samplers, part_of(channels[i], "sampler"), "a channel", "sampler");
        if (!sampler) return sampler.error();
        const Json& target = part_of(channels[i], "target");
        const Json& node = part_of(target, "node");
        if (!document_.entry("nodes", node)) return document_.problem("a channel has no valid node");
        outputs[{static_cast<size_t>(node.get<double>()), text_of(target, "path")}] =
            &part_of(**sampler, "output");
      }
    }
    for (const auto& [node, body] : body_of_node_) {
      const std::string where = name_of_node(node);
      const Json& extension = extension_of(document_.json()["nodes"][node], "LIVEGS_physics");
      const Json& span = part_of(extension, "track");
      if (!span.is_object()) continue;
      const auto first = number(span, "first_key", 0, where), keys = number(span, "keys", 0, where);
      if (!first || !keys || *first < 0 || *keys < 0 || *first != std::floor(*first) ||
          *keys != std::floor(*keys) || *first + *keys > static_cast<double>(animation.times_s.size()))
        return bad(where, "has a track beyond the times of the animation");
      PortableTrack track;
      track.body = body;
      track.first_key = static_cast<size_t>(*first);
      const auto size = static_cast<size_t>(*keys);
      if (size > 0) {
        const auto moved = outputs.find({node, "translation"}), turned = outputs.find({node, "rotation"});
        if (moved == outputs.end() || turned == outputs.end())
          return bad(where, "has a track without channels");
        const auto positions = document_.numbers(*moved->second, 3);
        const auto rotations = document_.numbers(*turned->second, 4);
        if (!positions) return positions.error();
        if (!rotations) return rotations.error();
        if (auto within = spend(7 * size); !within) return within;
        if (positions->count != size || rotations->count != size)
          return bad(where, "has a track with another number of keys");
        for (size_t i = 0; i < size; ++i) {
          const Quaterniond q(rotations->at(i, 3), rotations->at(i, 0), rotations->at(i, 1),
                              rotations->at(i, 2));
          if (!(q.norm() > 0.5 && q.norm() < 2)) return bad(where, "has a key without a valid rotation");
          track.world_from_object.push_back(
              {{positions->at(i, 0), positions->at(i, 1), positions->at(i, 2)}, q.normalized()});
        }
      }
      const Json& cache = part_of(extension, "point_cache");
      if (cache.is_object() && size > 0) {
        const auto positions = document_.numbers(part_of(cache, "positions"), 3);
        if (!positions) return positions.error();
        const size_t nodes =
            scene_.bodies[body].elastic ? scene_.bodies[body].elastic->lattice.node_coordinates.size() : 0;
        if (nodes == 0 || positions->count != nodes * size)
          return bad(where, "has a point cache with another number of positions");
        if (auto within = spend(3 * positions->count); !within) return within;
        for (size_t key = 0; key < size; ++key) {
          auto& list = track.nodes_m.emplace_back();
          for (size_t i = key * nodes; i < (key + 1) * nodes; ++i)
            list.push_back(
                Eigen::Vector3d(positions->at(i, 0), positions->at(i, 1), positions->at(i, 2)).cast<float>());
        }
      }
      animation.tracks.push_back(std::move(track));
    }
    scene_.animation = std::move(animation);
    return {};
  }

  const GltfDocument& document_;
  mutable uint64_t spent_ = 0;
  PortableScene scene_;
  std::vector<Visit> visits_;  // parents before their children
  std::vector<std::optional<size_t>> visit_of_node_;
  std::map<size_t, size_t> body_of_node_;
};

}  // namespace

Result<PortableScene> decode_gltf_scene(std::span<const std::byte> bytes, const std::filesystem::path& folder,
                                        std::string_view name) {
  const auto document = GltfDocument::open(bytes, folder, name);
  if (!document) return document.error();
  return SceneDecoder(*document).decode();
}

Result<PortableScene> read_gltf_scene(const std::filesystem::path& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  return decode_gltf_scene(*bytes, path.parent_path().empty() ? "." : path.parent_path(),
                           path.filename().string());
}

}  // namespace livegs
