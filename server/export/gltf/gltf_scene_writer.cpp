// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0; KHR_gaussian_splatting (ratified form); KHR_physics_rigid_bodies (draft, KhronosGroup/glTF#2424);
// KHR_implicit_shapes (release candidate).
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/text/path_ending.h"
#include "export/gltf_scene.h"
#include "export/model/message_text.h"
#include "gaussian/asset_file.h"
#include "gaussian/gltf_splats.h"

namespace livegs {
namespace {

using Json = nlohmann::json;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Kind = PortableShape::Kind;
using Bounds = GltfBuffer::Bounds;
using Use = GltfBuffer::Use;

constexpr const char* kBodies = "KHR_physics_rigid_bodies";
constexpr const char* kShapes = "KHR_implicit_shapes";
constexpr const char* kOwn = "LIVEGS_physics";

Json list_of(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json list_of(const Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

// The JSON form of a message with the field names of its .proto file.
Json json_of(const google::protobuf::Message& message) {
  return Json::parse(message_text(message), nullptr, false);
}

void place(Json& node, const Pose& pose) {
  if (!pose.position_m.isZero(0)) node["translation"] = list_of(pose.position_m);
  if (!pose.orientation.coeffs().isApprox(Quaterniond::Identity().coeffs(), 0))
    node["rotation"] = list_of(pose.orientation);
}

class SceneEncoder {
 public:
  SceneEncoder(const PortableScene& scene, const GltfWriteOptions& options)
      : scene_(scene), options_(options) {}

  Result<Json> encode() {
    Json roots = Json::array();
    body_nodes_.assign(scene_.bodies.size(), 0);
    for (size_t i = 0; i < scene_.bodies.size(); ++i) {
      auto node = add_body(scene_.bodies[i]);
      if (!node) return node.error();
      body_nodes_[i] = *node;
      roots.push_back(*node);
    }
    for (size_t i = 0; i < scene_.fixed.size(); ++i)
      roots.push_back(add_collider(scene_.fixed[i], "collider " + std::to_string(i + 1)));
    for (const PortableJoint& joint : scene_.joints) add_joint(joint, roots);
    if (scene_.animation) add_animation(*scene_.animation);

    Json& own = extensions_[kOwn];
    used_.insert(kOwn);
    own["version"] = 1;
    own["gravity_m_s2"] = list_of(scene_.gravity_m_s2);
    own["rate_hz"] = scene_.rate_hz;
    if (!shapes_.empty()) extensions_[kShapes]["shapes"] = shapes_;
    if (!materials_.empty()) extensions_[kBodies]["physicsMaterials"] = materials_;
    if (!joints_.empty()) extensions_[kBodies]["physicsJoints"] = joints_;

    const Json asset{{"version", "2.0"}, {"generator", "LiveGS"}};
    Json document{{"asset", asset}, {"extensionsUsed", used_}, {"extensions", extensions_}, {"scene", 0}};
    Json root{{"name", scene_.name}};
    if (!roots.empty()) {
      root["nodes"] = roots;
      document["nodes"] = nodes_;
    }
    document["scenes"].push_back(std::move(root));
    if (!meshes_.empty()) document["meshes"] = meshes_;
    if (!animations_.empty()) document["animations"] = animations_;
    if (buffer_.size() > 0) {
      document["accessors"] = buffer_.accessors();
      document["bufferViews"] = buffer_.views();
    }
    return document;
  }

  std::vector<std::byte> take_bytes() { return buffer_.take_bytes(); }

 private:
  size_t add_node(Json node) {
    nodes_.push_back(std::move(node));
    return nodes_.size() - 1;
  }
  void add_child(size_t parent, size_t child) { nodes_[parent]["children"].push_back(child); }

  Result<size_t> add_body(const PortableBody& body) {
    Json node{{"name", body.name}};
    place(node, body.world_from_object);
    Json& own = node["extensions"][kOwn];
    own["behavior"] = v1::Physics::Behavior_Name(body.behavior);
    if (body.drawn_only) own["drawn_only"] = true;
    if (body.hidden) own["hidden"] = true;
    if (body.estimates.ByteSizeLong() > 0) own["estimates"] = json_of(body.estimates);
    if (body.elastic) own["elastic"] = elastic(*body.elastic);
    if (body.mass_kg > 0) {
      const Quaterniond object_from_world = body.world_from_object.orientation.conjugate();
      Json motion{{"mass", body.mass_kg},
                  {"centerOfMass", list_of(body.centre_m)},
                  {"inertiaDiagonal", list_of(body.inertia_kg_m2)},
                  {"inertiaOrientation", list_of(body.object_from_inertia)}};
      if (!body.velocity_m_s.isZero(0))
        motion["linearVelocity"] = list_of(Vector3d(object_from_world * body.velocity_m_s));
      if (!body.angular_velocity_rad_s.isZero(0))
        motion["angularVelocity"] = list_of(Vector3d(object_from_world * body.angular_velocity_rad_s));
      node["extensions"][kBodies]["motion"] = std::move(motion);
      used_.insert(kBodies);
    }
    const size_t index = add_node(std::move(node));
    if (body.asset && body.asset->size() > 0) {
      auto mesh = splat_mesh(*body.asset);
      if (!mesh) return mesh.error();
      // The kernels are stored with y up, half a turn about x from the frame of the asset.
      const Similarity& similarity = body.object_from_asset;
      const Quaterniond turn = (similarity.rotation * Quaterniond(0, 1, 0, 0).conjugate()).normalized();
      Json splats{{"name", body.name + " splats"}, {"mesh", *mesh}};
      const bool straight = turn.vec().cwiseAbs().maxCoeff() < 1e-12;
      place(splats, {similarity.translation_m, straight ? Quaterniond::Identity() : turn});
      if (similarity.scale != 1) splats["scale"] = list_of(Vector3d::Constant(similarity.scale).eval());
      if (body.hidden) {
        splats["extensions"]["KHR_node_visibility"]["visible"] = false;
        used_.insert("KHR_node_visibility");
      }
      add_child(index, add_node(std::move(splats)));
    }
    for (const PortableShape& shape : body.shapes)
      add_child(index, add_collider(shape, body.name + " collider"));
    return index;
  }

  Json elastic(const PortableElastic& elastic) {
    const RestBody& lattice = elastic.lattice;
    std::vector<float> nodes;
    for (const Eigen::Vector3i& node : lattice.node_coordinates) {
      for (int axis = 0; axis < 3; ++axis) nodes.push_back(static_cast<float>(node[axis]));
    }
    std::vector<uint32_t> cells, fills;
    for (const auto& cell : lattice.cells) cells.insert(cells.end(), cell.begin(), cell.end());
    for (const uint64_t fill : lattice.cell_fills) {
      fills.push_back(static_cast<uint32_t>(fill));
      fills.push_back(static_cast<uint32_t>(fill >> 32));
    }
    Json json{{"accuracy", json_of(elastic.accuracy)}};
    for (const ElasticNumber& one : kElasticNumbers) json[one.name] = elastic.*one.value;
    for (const v1::Region& region : elastic.regions) json["regions"].push_back(json_of(region));
    if (nodes.empty()) return json;
    Json& own = json["lattice"];
    own["cell_width_m"] = lattice.cell_width_m;
    own["translation"] = list_of(lattice.object_from_lattice.position_m);
    own["rotation"] = list_of(lattice.object_from_lattice.orientation);
    own["nodes"] = buffer_.add_floats(nodes, 3, Bounds::None, Use::Values);
    if (!cells.empty()) own["cells"] = buffer_.add_indices(cells, Use::Values);
    if (!fills.empty()) own["cell_fills"] = buffer_.add_indices(fills, Use::Values);
    return json;
  }

  // The attributes of the primitive; equal assets are stored once.
  Result<size_t> splat_mesh(const GaussianAsset& original) {
    const std::vector<std::byte> bytes = encode_ply(original);
    const std::string key = content_hash(bytes) + (original.antialiased ? "a" : "");
    if (const auto known = splat_meshes_.find(key); known != splat_meshes_.end()) return known->second;
    auto primitive = gltf_splat_primitive(original, options_.spz, buffer_, used_);
    if (!primitive) return primitive.error();
    meshes_.push_back({{"primitives", Json::array({std::move(*primitive)})}});
    return splat_meshes_[key] = meshes_.size() - 1;
  }

  size_t material_of(double friction, double restitution) {
    const auto [at, fresh] = material_index_.try_emplace({friction, restitution}, materials_.size());
    if (fresh) {
      materials_.push_back({{"staticFriction", friction},
                            {"dynamicFriction", friction},
                            {"restitution", restitution},
                            {"frictionCombine", "average"},
                            {"restitutionCombine", "maximum"}});
    }
    return at->second;
  }

  size_t add_collider(const PortableShape& shape, const std::string& name) {
    Json geometry;
    if (shape.kind == Kind::Mesh) {
      std::vector<float> vertices;
      for (const Vector3d& vertex : shape.mesh->vertices_m) {
        for (int axis = 0; axis < 3; ++axis) vertices.push_back(static_cast<float>(vertex[axis]));
      }
      std::vector<uint32_t> indices;
      for (const auto& triangle : shape.mesh->triangles)
        indices.insert(indices.end(), triangle.begin(), triangle.end());
      const Json attributes{{"POSITION", buffer_.add_floats(vertices, 3, Bounds::Stated, Use::Vertices)}};
      const Json primitive{
          {"mode", 4}, {"attributes", attributes}, {"indices", buffer_.add_indices(indices, Use::Indices)}};
      meshes_.push_back({{"name", name}, {"primitives", Json::array({primitive})}});
      // Drafts up to 2025 name a node with the mesh, later ones the mesh. The node is in no scene, so that
      // the surface is not drawn.
      geometry["mesh"] = meshes_.size() - 1;
      geometry["node"] = add_node({{"name", name + " mesh"}, {"mesh", meshes_.size() - 1}});
      geometry["convexHull"] = shape.convex;
    } else {
      const char* type = name_of(shape.kind);
      Json measures = Json::object();
      if (shape.kind == Kind::Box) measures["size"] = list_of(shape.size_m);
      if (shape.kind == Kind::Sphere) measures["radius"] = shape.radius_m;
      if (shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule)
        measures = {
            {"height", shape.height_m}, {"radiusBottom", shape.radius_m}, {"radiusTop", shape.radius_m}};
      shapes_.push_back({{"type", type}, {type, measures}});
      geometry["shape"] = shapes_.size() - 1;
      used_.insert(kShapes);
    }
    Json node{{"name", name}};
    place(node, shape.owner_from_shape);
    node["extensions"][kBodies]["collider"] = {
        {"geometry", geometry}, {"physicsMaterial", material_of(shape.friction, shape.restitution)}};
    used_.insert(kBodies);
    return add_node(std::move(node));
  }

  void add_joint(const PortableJoint& joint, Json& roots) {
    const size_t kind = joint.hinge ? 1 : 0;
    if (!joint_index_[kind]) {
      Json limits = Json::array({{{"linearAxes", {0, 1, 2}}, {"min", 0}, {"max", 0}}});
      // A hinge turns about the x axis of its frames.
      if (joint.hinge) limits.push_back({{"angularAxes", {1, 2}}, {"min", 0}, {"max", 0}});
      joints_.push_back({{"limits", limits}});
      joint_index_[kind] = joints_.size() - 1;
    }
    const Pose frame = joint_frame(joint);
    const Pose world_from_frame = scene_.bodies[joint.body].world_from_object * frame;
    Json other{{"name", "joint frame"}};
    place(other, joint.other ? scene_.bodies[*joint.other].world_from_object.inverse() * world_from_frame
                             : world_from_frame);
    const size_t other_node = add_node(std::move(other));
    if (joint.other) {
      add_child(body_nodes_[*joint.other], other_node);
    } else {
      roots.push_back(other_node);
    }
    Json own{{"name", "joint"}};
    place(own, frame);
    own["extensions"][kBodies]["joint"] = {
        {"connectedNode", other_node}, {"joint", *joint_index_[kind]}, {"enableCollision", false}};
    used_.insert(kBodies);
    add_child(body_nodes_[joint.body], add_node(std::move(own)));
  }

  size_t times_of(const std::vector<float>& times) {
    const auto known = times_.find(times);
    if (known != times_.end()) return known->second;
    return times_[times] = buffer_.add_floats(times, 1, Bounds::Stated, Use::Values);
  }

  void add_animation(const PortableAnimation& animation) {
    std::vector<float> all;
    for (const double time : animation.times_s) all.push_back(static_cast<float>(time));
    extensions_[kOwn]["times"] = times_of(all);
    Json samplers = Json::array(), channels = Json::array();
    const auto add = [&](size_t input, const std::vector<float>& values, size_t components, const char* path,
                         const char* interpolation, size_t node) {
      const size_t output = buffer_.add_floats(values, components, Bounds::None, Use::Values);
      samplers.push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
      channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
    };
    for (const PortableTrack& track : animation.tracks) {
      const size_t node = body_nodes_[track.body], size = track.world_from_object.size();
      const std::vector<float> times(all.begin() + static_cast<std::ptrdiff_t>(track.first_key),
                                     all.begin() + static_cast<std::ptrdiff_t>(track.first_key + size));
      const bool partial = size < all.size();
      if (size > 0) {
        std::vector<float> positions, rotations;
        Quaterniond before = Quaterniond::Identity();
        for (const Pose& pose : track.world_from_object) {
          for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(pose.position_m[axis]));
          // The nearer of the two quaternions of a rotation, for interpolation.
          const double sign = before.dot(pose.orientation) < 0 ? -1 : 1;
          before.coeffs() = sign * pose.orientation.coeffs();
          for (int k = 0; k < 4; ++k) rotations.push_back(static_cast<float>(before.coeffs()[k]));
        }
        const size_t input = times_of(times);
        add(input, positions, 3, "translation", "LINEAR", node);
        add(input, rotations, 4, "rotation", "LINEAR", node);
        nodes_[node]["extensions"][kOwn]["track"] = {{"first_key", track.first_key}, {"keys", size}};
      } else {
        nodes_[node]["extensions"][kOwn]["track"] = {{"first_key", 0}, {"keys", 0}};
      }
      if (partial) add_presence(animation, track, all, node, add);
      if (!track.nodes_m.empty()) {
        std::vector<float> cache;
        cache.reserve(track.nodes_m.size() * track.nodes_m[0].size() * 3);
        for (const auto& nodes : track.nodes_m) {
          for (const Vector3f& position : nodes)
            cache.insert(cache.end(), {position.x(), position.y(), position.z()});
        }
        nodes_[node]["extensions"][kOwn]["point_cache"] = {
            {"times", times_of(times)},
            {"positions", buffer_.add_floats(cache, 3, Bounds::None, Use::Values)}};
      }
    }
    if (!channels.empty())
      animations_.push_back({{"name", "recording"}, {"samplers", samplers}, {"channels", channels}});
  }

  // A body that does not exist all the time has size zero for the rest of it. One that a recording adds has
  // it without the animation too.
  template <class Add>
  void add_presence(const PortableAnimation& animation, const PortableTrack& track,
                    const std::vector<float>& all, size_t node, const Add& add) {
    const size_t end = track.first_key + track.world_from_object.size();
    std::vector<float> times, sizes;
    const auto set = [&](size_t key, float size) {
      times.push_back(all[key]);
      sizes.insert(sizes.end(), 3, size);
    };
    if (track.world_from_object.empty()) {
      set(0, 0);
    } else {
      if (track.first_key > 0) set(0, 0);
      set(track.first_key, 1);
      if (end < animation.times_s.size()) set(end, 0);
    }
    add(times_of(times), sizes, 3, "scale", "STEP", node);
    if (scene_.bodies[track.body].drawn_only && track.first_key > 0) nodes_[node]["scale"] = {0, 0, 0};
  }

  const PortableScene& scene_;
  const GltfWriteOptions& options_;
  GltfBuffer buffer_;
  std::set<std::string> used_;
  Json extensions_ = Json::object();
  Json nodes_ = Json::array(), meshes_ = Json::array(), animations_ = Json::array();
  Json shapes_ = Json::array(), materials_ = Json::array(), joints_ = Json::array();
  std::vector<size_t> body_nodes_;
  std::map<std::string, size_t> splat_meshes_;
  std::map<std::pair<double, double>, size_t> material_index_;
  std::optional<size_t> joint_index_[2];
  std::map<std::vector<float>, size_t> times_;
};

}  // namespace

Result<GltfFiles> encode_gltf_scene(const PortableScene& scene, std::string_view binary_name,
                                    const GltfWriteOptions& options) {
  SceneEncoder encoder(scene, options);
  auto document = encoder.encode();
  if (!document) return document.error();
  GltfFiles files;
  files.binary = encoder.take_bytes();
  if (files.binary.size() >= UINT32_MAX)
    return Error{ErrorCode::TooLarge,
                 "the scene has more than 4 GiB of splats and motion; write fewer objects, or use --spz"};
  if (!files.binary.empty()) {
    Json buffer{{"byteLength", files.binary.size()}};
    if (!binary_name.empty()) buffer["uri"] = std::string(binary_name);
    (*document)["buffers"].push_back(std::move(buffer));
  }
  files.json = document->dump(binary_name.empty() ? -1 : 1, ' ', false, Json::error_handler_t::replace);
  return files;
}

Result<std::vector<std::byte>> encode_glb(const GltfFiles& files) {
  return join_glb(files.json, files.binary);
}

Result<std::vector<std::filesystem::path>> write_gltf_scene(const std::filesystem::path& path,
                                                            const PortableScene& scene,
                                                            const GltfWriteOptions& options) {
  const bool one_file = has_ending(path.string(), ".glb");
  std::filesystem::path binary = path;
  binary.replace_extension(".bin");
  // A URI: letters beyond the unreserved ones are percent-encoded.
  std::string uri;
  for (const char c : binary.filename().string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::strchr("-._~", c) != nullptr;
    static constexpr char kDigits[] = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    if (plain) {
      uri += c;
    } else {
      uri += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
  }
  const auto files = encode_gltf_scene(scene, one_file ? "" : uri, options);
  if (!files) return Error{files.error().code, path.string() + ": " + files.error().message};
  if (one_file) {
    const auto glb = encode_glb(*files);
    if (!glb) return Error{glb.error().code, path.string() + ": " + glb.error().message};
    if (auto written = write_file_atomically(path, *glb); !written) return written.error();
    return std::vector{path};
  }
  std::vector<std::filesystem::path> written{path};
  if (!files->binary.empty()) {
    if (auto done = write_file_atomically(binary, files->binary); !done) return done.error();
    written.push_back(binary);
  }
  if (auto done = write_file_atomically(path, files->json); !done) return done.error();
  return written;
}

}  // namespace livegs
