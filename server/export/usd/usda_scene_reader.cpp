// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/file.h"
#include "export/model/message_text.h"
#include "export/usd/estimate_attributes.h"
#include "export/usd/usda_document.h"
#include "export/usda_scene.h"
#include "gaussian/asset/y_up.h"

namespace livegs {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Kind = PortableShape::Kind;

constexpr double kMaxUsdNumber = 1e15;

class StageReader {
 public:
  StageReader(const UsdaDocument& document, std::string_view name) : document_(document), name_(name) {}

  Result<PortableScene> read() {
    const auto setting = [&](const char* key) -> const UsdaValue* {
      const auto found = document_.metadata.find(key);
      return found == document_.metadata.end() ? nullptr : &found->second;
    };
    const UsdaValue* up = setting("upAxis");
    const UsdaValue* metre = setting("metersPerUnit");
    if (!up || up->texts != std::vector<std::string>{"Y"})
      return unsupported(name_ + ": upAxis is not \"Y\"; export the stage with y up");
    if (!metre || metre->numbers != std::vector<double>{1})
      return unsupported(name_ + ": metersPerUnit is not 1; export the stage in metres");
    for (const UsdaPrim& root : document_.roots) {
      if (auto visited = visit_bodies(root, {}); !visited) return visited.error();
    }
    for (const UsdaPrim& root : document_.roots) {
      if (auto visited = visit_parts(root, {}, std::nullopt); !visited) return visited.error();
    }
    for (const UsdaPrim* joint : joints_) {
      if (auto taken = take_joint(*joint); !taken) return taken.error();
    }
    if (times_s_) {
      PortableAnimation animation;
      animation.times_s = *times_s_;
      scene_.animation = std::move(animation);
      for (const auto& [path, body] : body_of_path_) {
        if (auto taken = take_track(*prims_.at(path), body); !taken) return taken.error();
      }
    }
    return std::move(scene_);
  }

 private:
  Error bad(const UsdaPrim& prim, const std::string& what) const {
    return with_remedy(invalid_data(name_ + ": " + prim.path + ": " + what), "export the file again");
  }

  Result<double> number(const UsdaPrim& prim, const char* property, double fallback) const {
    const UsdaValue* value = prim.value(property);
    if (!value) return fallback;
    if (value->numbers.size() != 1 || !(std::abs(value->numbers[0]) <= kMaxUsdNumber))
      return bad(prim, std::string(property) + " has no valid value");
    return value->numbers[0];
  }
  Result<Vector3d> vector(const UsdaPrim& prim, const char* property, const Vector3d& fallback) const {
    const UsdaValue* value = prim.value(property);
    if (!value) return fallback;
    const Vector3d read =
        value->numbers.size() == 3 ? Vector3d(value->numbers.data()) : Vector3d::Constant(NAN);
    if (!(read.cwiseAbs().maxCoeff() <= kMaxUsdNumber))
      return bad(prim, std::string(property) + " has no valid value");
    return read;
  }
  static std::optional<Quaterniond> quaternion_of(const UsdaValue& value) {
    if (value.numbers.size() != 4) return std::nullopt;
    const Quaterniond q(value.numbers[0], value.numbers[1], value.numbers[2], value.numbers[3]);
    if (!(q.norm() > 0.5 && q.norm() < 2)) return std::nullopt;
    return q.normalized();
  }
  Result<Quaterniond> quaternion(const UsdaPrim& prim, const char* property) const {
    const UsdaValue* value = prim.value(property);
    if (!value) return Quaterniond(Quaterniond::Identity());
    const auto read = quaternion_of(*value);
    if (!read) return bad(prim, std::string(property) + " has no valid value");
    return *read;
  }

  struct Placement {
    Pose pose;
    Vector3d scale = Vector3d::Ones();
  };
  // The transform of a prim, in the order translate, orient, scale.
  Result<Placement> placement(const UsdaPrim& prim) const {
    Placement result;
    const UsdaValue* order = prim.value("xformOpOrder");
    if (!order) return result;
    int last = 0;
    for (const std::string& op : order->texts) {
      const int rank = op == "xformOp:translate" ? 1
                       : op == "xformOp:orient"  ? 2
                       : op == "xformOp:scale"   ? 3
                                                 : 0;
      if (op == "!resetXformStack!") continue;
      if (rank == 0 || rank <= last)
        return unsupported(name_ + ": " + prim.path +
                           ": has a transform other than translate, orient, scale; export it as these");
      last = rank;
      if (rank == 1) {
        const auto value = vector(prim, "xformOp:translate", Vector3d::Zero());
        if (!value) return value.error();
        result.pose.position_m = *value;
      } else if (rank == 2) {
        const auto value = quaternion(prim, "xformOp:orient");
        if (!value) return value.error();
        result.pose.orientation = *value;
      } else {
        const auto value = vector(prim, "xformOp:scale", Vector3d::Ones());
        if (!value) return value.error();
        result.scale = *value;
      }
    }
    return result;
  }

  Result<void> visit_bodies(const UsdaPrim& prim, const Pose& world_from_parent) {
    if (!prims_.emplace(prim.path, &prim).second) return bad(prim, "exists twice");
    const auto own = placement(prim);
    if (!own) return own.error();
    const Pose world_from_prim = world_from_parent * own->pose;
    if (prim.type == "PhysicsScene") {
      const auto direction = vector(prim, "physics:gravityDirection", Vector3d(0, -1, 0));
      const auto magnitude = number(prim, "physics:gravityMagnitude", 9.81);
      const auto rate = number(prim, "livegs:rate_hz", scene_.rate_hz);
      if (!direction) return direction.error();
      if (!magnitude) return magnitude.error();
      if (!rate) return rate.error();
      if (!(*rate > 0)) return bad(prim, "livegs:rate_hz has no valid value");
      scene_.gravity_m_s2 = *magnitude * direction->normalized();
      scene_.rate_hz = *rate;
      scene_.name = prim.text("livegs:name");
      if (const UsdaValue* times = prim.value("livegs:times_s")) {
        for (size_t i = 0; i < times->numbers.size(); ++i) {
          if (!std::isfinite(times->numbers[i]) || (i > 0 && !(times->numbers[i] > times->numbers[i - 1])))
            return bad(prim, "livegs:times_s does not increase");
        }
        times_s_ = times->numbers;
      }
    }
    const bool moves = prim.has_schema("PhysicsRigidBodyAPI");
    if (moves || prim.value("livegs:behavior")) {
      if (auto taken = take_body(prim, world_from_prim, moves); !taken) return taken;
    }
    for (const UsdaPrim& child : prim.children) {
      if (auto visited = visit_bodies(child, world_from_prim); !visited) return visited;
    }
    return {};
  }

  Result<void> take_body(const UsdaPrim& prim, const Pose& world_from_prim, bool moves) {
    PortableBody body;
    body.name = prim.value("livegs:name") ? prim.text("livegs:name") : prim.name;
    body.behavior = moves ? v1::Physics::RIGID : v1::Physics::STATIC;
    const std::string word = prim.text("livegs:behavior");
    if (!word.empty() && !v1::Physics::Behavior_Parse(word, &body.behavior))
      return bad(prim, "livegs:behavior is unknown");
    body.world_from_object = world_from_prim;
    const auto drawn_only = number(prim, "livegs:drawn_only", 0);
    if (!drawn_only) return drawn_only.error();
    body.drawn_only = *drawn_only != 0;
    body.hidden = prim.text("visibility") == "invisible" && !prim.samples.contains("visibility");
    const auto mass = number(prim, "physics:mass", 0);
    const auto centre = vector(prim, "physics:centerOfMass", Vector3d::Zero());
    const auto inertia = vector(prim, "physics:diagonalInertia", Vector3d::Zero());
    const auto axes = quaternion(prim, "physics:principalAxes");
    const auto velocity = vector(prim, "physics:velocity", Vector3d::Zero());
    const auto spin = vector(prim, "physics:angularVelocity", Vector3d::Zero());
    if (!mass) return mass.error();
    if (!centre) return centre.error();
    if (!inertia) return inertia.error();
    if (!axes) return axes.error();
    if (!velocity) return velocity.error();
    if (!spin) return spin.error();
    if (*mass < 0 || inertia->minCoeff() < 0) return bad(prim, "has a negative mass or inertia");
    body.mass_kg = *mass;
    body.centre_m = *centre;
    body.inertia_kg_m2 = *inertia;
    body.object_from_inertia = *axes;
    body.velocity_m_s = *velocity;
    body.angular_velocity_rad_s = *spin * (std::numbers::pi / 180);
    auto estimates = read_estimates(prim);
    if (!estimates)
      return with_remedy({estimates.error().code, name_ + ": " + estimates.error().message},
                         "export the file again");
    body.estimates = std::move(*estimates);
    if (prim.value("livegs:elastic:youngs_modulus_pa")) {
      if (auto taken = take_elastic(prim, body); !taken) return taken;
    }
    body_of_path_[prim.path] = scene_.bodies.size();
    scene_.bodies.push_back(std::move(body));
    return {};
  }

  Result<void> take_elastic(const UsdaPrim& prim, PortableBody& body) const {
    PortableElastic elastic;
    for (const ElasticNumber& one : kElasticNumbers) {
      const std::string key = std::string("livegs:elastic:") + one.name;
      const auto read = number(prim, key.c_str(), elastic.*one.value);
      if (!read) return read.error();
      elastic.*one.value = *read;
    }
    const std::string accuracy = prim.text("livegs:elastic:accuracy");
    if (!accuracy.empty() && !read_message_text(accuracy, elastic.accuracy))
      return bad(prim, "livegs:elastic:accuracy has no valid value");
    if (const UsdaValue* regions = prim.value("livegs:elastic:regions")) {
      for (const std::string& region : regions->texts) {
        if (!read_message_text(region, elastic.regions.emplace_back()))
          return bad(prim, "livegs:elastic:regions has no valid value");
      }
    }
    body.elastic = std::move(elastic);
    return {};
  }

  Result<void> visit_parts(const UsdaPrim& prim, const Pose& world_from_parent, std::optional<size_t> body) {
    const auto own = placement(prim);
    if (!own) return own.error();
    const Pose world_from_prim = world_from_parent * own->pose;
    if (const auto found = body_of_path_.find(prim.path); found != body_of_path_.end()) body = found->second;
    if (prim.type == "PhysicsRevoluteJoint" || prim.type == "PhysicsSphericalJoint") joints_.push_back(&prim);
    if (prim.has_schema("PhysicsCollisionAPI")) {
      if (auto taken = take_collider(prim, world_from_prim, own->scale, body); !taken) return taken;
    }
    if (prim.type == "ParticleField3DGaussianSplat" && body) {
      if (auto taken = take_splats(prim, *own, scene_.bodies[*body]); !taken) return taken;
    }
    if (prim.value("livegs:cell_width_m") && body && scene_.bodies[*body].elastic) {
      if (auto taken = take_lattice(prim, scene_.bodies[*body].elastic->lattice); !taken) return taken;
    }
    for (const UsdaPrim& child : prim.children) {
      if (auto visited = visit_parts(child, world_from_prim, body); !visited) return visited;
    }
    return {};
  }

  // The whole numbers of a list; empty if there is none.
  Result<std::vector<int64_t>> whole_numbers(const UsdaPrim& prim, const char* property) const {
    std::vector<int64_t> result;
    const UsdaValue* value = prim.value(property);
    if (!value) return result;
    for (const double number : value->numbers) {
      if (!(std::abs(number) < 9e15 && number == std::floor(number)))
        return bad(prim, std::string(property) + " has no valid value");
      result.push_back(static_cast<int64_t>(number));
    }
    return result;
  }
  Result<std::vector<Vector3d>> points(const UsdaPrim& prim, const char* property) const {
    std::vector<Vector3d> result;
    const UsdaValue* value = prim.value(property);
    if (!value) return result;
    if (value->numbers.size() % 3 != 0) return bad(prim, std::string(property) + " has no valid value");
    for (size_t i = 0; i < value->numbers.size(); i += 3) {
      result.emplace_back(value->numbers[i], value->numbers[i + 1], value->numbers[i + 2]);
      if (!(result.back().cwiseAbs().maxCoeff() <= kMaxUsdNumber))
        return bad(prim, std::string(property) + " has no valid value");
    }
    return result;
  }

  Result<void> take_collider(const UsdaPrim& prim, const Pose& world_from_shape, const Vector3d& scale,
                             std::optional<size_t> body) {
    PortableShape shape;
    static const std::map<std::string, Kind> kKinds = {
        {"Plane", Kind::Plane},       {"Cube", Kind::Box},        {"Sphere", Kind::Sphere},
        {"Cylinder", Kind::Cylinder}, {"Capsule", Kind::Capsule}, {"Mesh", Kind::Mesh}};
    const auto kind = kKinds.find(prim.type);
    if (kind == kKinds.end()) {
      scene_.notes.push_back(prim.path + ": collides as a " + prim.type +
                             ", which is not supported; left out");
      return {};
    }
    shape.kind = kind->second;
    if (shape.kind != Kind::Box && scale != Vector3d(Vector3d::Ones()))
      return unsupported(name_ + ": " + prim.path + ": is a scaled shape; apply the scale to its measures");
    const bool round =
        shape.kind == Kind::Plane || shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule;
    if (round && prim.text("axis") != "Y")
      return unsupported(name_ + ": " + prim.path + ": its axis is not Y; turn the prim instead");
    const auto size = number(prim, "size", 2),
               radius = number(prim, "radius", shape.kind == Kind::Capsule ? 0.5 : 1),
               height = number(prim, "height", shape.kind == Kind::Capsule ? 1 : 2);
    if (!size) return size.error();
    if (!radius) return radius.error();
    if (!height) return height.error();
    if (shape.kind == Kind::Box) shape.size_m = *size * scale;
    if (shape.kind == Kind::Sphere || shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule)
      shape.radius_m = *radius;
    if (shape.kind == Kind::Cylinder || shape.kind == Kind::Capsule) shape.height_m = *height;
    if (shape.kind == Kind::Mesh) {
      if (auto taken = take_mesh(prim, shape); !taken) return taken;
    }
    const std::string material = prim.text("material:binding:physics");
    if (!material.empty()) {
      const auto found = prims_.find(material);
      if (found == prims_.end()) return bad(prim, "its physics material does not exist");
      const auto friction = number(*found->second, "physics:dynamicFriction", 0);
      const auto restitution = number(*found->second, "physics:restitution", 0);
      if (!friction) return friction.error();
      if (!restitution) return restitution.error();
      shape.friction = *friction;
      shape.restitution = *restitution;
    }
    shape.owner_from_shape = world_from_shape;
    if (!body) {
      scene_.fixed.push_back(std::move(shape));
      return {};
    }
    PortableBody& owner = scene_.bodies[*body];
    shape.owner_from_shape = owner.world_from_object.inverse() * world_from_shape;
    owner.friction = shape.friction;
    owner.restitution = shape.restitution;
    owner.shapes.push_back(std::move(shape));
    return {};
  }

  Result<void> take_mesh(const UsdaPrim& prim, PortableShape& shape) const {
    auto vertices = points(prim, "points");
    const auto counts = whole_numbers(prim, "faceVertexCounts");
    const auto indices = whole_numbers(prim, "faceVertexIndices");
    if (!vertices) return vertices.error();
    if (!counts) return counts.error();
    if (!indices) return indices.error();
    auto mesh = std::make_shared<TriangleMesh>();
    size_t at = 0;
    for (const int64_t count : *counts) {
      if (count < 3 || static_cast<size_t>(count) > indices->size() - at)
        return bad(prim, "has a face without indices");
      const auto vertex = [&](int64_t i) { return (*indices)[at + static_cast<size_t>(i)]; };
      for (int64_t i = 0; i < count; ++i) {
        if (vertex(i) < 0 || static_cast<size_t>(vertex(i)) >= vertices->size())
          return bad(prim, "has a face of a point that does not exist");
      }
      for (int64_t i = 2; i < count; ++i)
        mesh->triangles.push_back({static_cast<uint32_t>(vertex(0)), static_cast<uint32_t>(vertex(i - 1)),
                                   static_cast<uint32_t>(vertex(i))});
      at += static_cast<size_t>(count);
    }
    if (mesh->triangles.empty()) return bad(prim, "has no faces");
    mesh->vertices_m = std::move(*vertices);
    shape.mesh = std::move(mesh);
    shape.convex = prim.text("physics:approximation") == "convexHull";
    return {};
  }

  Result<void> take_splats(const UsdaPrim& prim, const Placement& placed, PortableBody& body) const {
    const auto list = [&](const char* property) -> const std::vector<double>& {
      static const std::vector<double> kNone;
      const UsdaValue* value = prim.value(property);
      return value ? value->numbers : kNone;
    };
    const auto degree = number(prim, "radiance:sphericalHarmonicsDegree", 3);
    const auto antialiased = number(prim, "livegs:antialiased", 0);
    if (!degree) return degree.error();
    if (!antialiased) return antialiased.error();
    if (!(*degree == 0 || *degree == 1 || *degree == 2 || *degree == 3))
      return unsupported(name_ + ": " + prim.path +
                         ": has harmonics of a degree above 3; export at most degree 3");
    auto asset = std::make_shared<GaussianAsset>();
    asset->sh_degree = static_cast<int>(*degree);
    asset->antialiased = *antialiased != 0;
    const std::vector<double>&positions = list("positions"), &orientations = list("orientations"),
          &scales = list("scales"), &opacities = list("opacities"),
          &harmonics = list("radiance:sphericalHarmonicsCoefficients");
    const size_t count = positions.size() / 3, own = 3 * (asset->sh_rest_count() + 1);
    if (count == 0 || positions.size() != 3 * count || orientations.size() != 4 * count ||
        scales.size() != 3 * count || opacities.size() != count || harmonics.size() != own * count)
      return bad(prim, "has lists of different lengths");
    asset->resize(count);
    const auto vector_at = [](const std::vector<double>& values, size_t i) {
      return Vector3f(Vector3d(values[i], values[i + 1], values[i + 2]).cast<float>());
    };
    for (size_t i = 0; i < count; ++i) {
      asset->positions[i] = vector_at(positions, 3 * i);
      asset->log_scales[i] = vector_at(scales, 3 * i).array().log();
      asset->rotations[i] = Quaterniond(orientations[4 * i], orientations[4 * i + 1], orientations[4 * i + 2],
                                        orientations[4 * i + 3])
                                .cast<float>();
      const double opacity = std::clamp(opacities[i], 0.0, 1.0);
      asset->opacity_logits[i] =
          static_cast<float>(std::clamp(std::log(opacity / (1 - opacity)), -16.0, 16.0));
      asset->sh_dc[i] = vector_at(harmonics, own * i);
      for (size_t k = 0; k < asset->sh_rest_count(); ++k)
        asset->sh_rest[i * asset->sh_rest_count() + k] = vector_at(harmonics, own * i + 3 + 3 * k);
      const bool valid = asset->positions[i].allFinite() && asset->log_scales[i].allFinite() &&
                         std::abs(asset->rotations[i].norm() - 1) < 1e-3f &&
                         std::isfinite(asset->opacity_logits[i]) && asset->sh_dc[i].allFinite();
      if (!valid) return bad(prim, "has a kernel with invalid values");
    }
    turn_half_about_x(*asset);
    body.kernel_count = count;
    body.asset = std::move(asset);
    body.object_from_asset = {placed.scale.x(),
                              (placed.pose.orientation * Quaterniond(0, 1, 0, 0)).normalized(),
                              placed.pose.position_m};
    return {};
  }

  Result<void> take_lattice(const UsdaPrim& prim, RestBody& lattice) const {
    const auto width = number(prim, "livegs:cell_width_m", 0);
    const auto position = vector(prim, "livegs:translation", Vector3d::Zero());
    const auto orientation = quaternion(prim, "livegs:rotation");
    const auto nodes = whole_numbers(prim, "livegs:nodes"), cells = whole_numbers(prim, "livegs:cells");
    if (!width) return width.error();
    if (!position) return position.error();
    if (!orientation) return orientation.error();
    if (!nodes) return nodes.error();
    if (!cells) return cells.error();
    if (!(*width > 0) || nodes->size() % 3 != 0 || cells->size() % 8 != 0)
      return bad(prim, "is not a valid lattice");
    lattice.kind = DriverKind::Lattice;
    lattice.cell_width_m = *width;
    lattice.object_from_lattice = {*position, *orientation};
    for (size_t i = 0; i < nodes->size(); i += 3) {
      for (size_t k = 0; k < 3; ++k) {
        if (std::abs((*nodes)[i + k]) > 1'000'000) return bad(prim, "is not a valid lattice");
      }
      lattice.node_coordinates.emplace_back(static_cast<int>((*nodes)[i]), static_cast<int>((*nodes)[i + 1]),
                                            static_cast<int>((*nodes)[i + 2]));
    }
    for (size_t i = 0; i < cells->size(); ++i) {
      const int64_t node = (*cells)[i];
      if (node < 0 || static_cast<size_t>(node) >= lattice.node_coordinates.size())
        return bad(prim, "has a cell of a node that does not exist");
      if (i % 8 == 0) lattice.cells.emplace_back();
      lattice.cells.back()[i % 8] = static_cast<uint32_t>(node);
    }
    if (const UsdaValue* fills = prim.value("livegs:cell_fills")) {
      if (fills->texts.size() != lattice.cells.size()) return bad(prim, "has the wrong number of cell_fills");
      for (const std::string& fill : fills->texts) {
        uint64_t bits = 0;
        if (fill.empty() || fill.size() > 16 || fill.find_first_not_of("0123456789abcdef") != fill.npos)
          return bad(prim, "has invalid cell_fills");
        for (const char c : fill) bits = bits << 4 | static_cast<uint64_t>(c <= '9' ? c - '0' : c - 'a' + 10);
        lattice.cell_fills.push_back(bits);
      }
    }
    return {};
  }

  Result<void> take_joint(const UsdaPrim& prim) {
    PortableJoint joint;
    joint.hinge = prim.type == "PhysicsRevoluteJoint";
    const auto body_at = [&](const char* property) -> Result<std::optional<size_t>> {
      const std::string path = prim.text(property);
      if (path.empty()) return std::optional<size_t>();
      const auto found = body_of_path_.find(path);
      if (found == body_of_path_.end()) return bad(prim, std::string(property) + " is not a body");
      return std::optional<size_t>(found->second);
    };
    const auto first = body_at("physics:body1"), other = body_at("physics:body0");
    if (!first) return first.error();
    if (!other) return other.error();
    const bool swapped = !*first;  // body1 is the world
    if (!*first && !*other) return bad(prim, "has no body");
    joint.body = swapped ? **other : **first;
    if (!swapped) joint.other = *other;
    if (joint.other == joint.body) return bad(prim, "is a joint of a body to itself");
    const auto point = vector(prim, swapped ? "physics:localPos0" : "physics:localPos1", Vector3d::Zero());
    const auto turn = quaternion(prim, swapped ? "physics:localRot0" : "physics:localRot1");
    if (!point) return point.error();
    if (!turn) return turn.error();
    joint.point_m = *point;
    if (joint.hinge) {
      const std::string axis = prim.text("physics:axis");
      joint.axis = *turn * Vector3d(Vector3d::Unit(axis == "Y" ? 1 : axis == "Z" ? 2 : 0));
    }
    scene_.joints.push_back(joint);
    return {};
  }

  Result<void> take_track(const UsdaPrim& prim, size_t body) {
    if (!prim.value("livegs:first_key")) return {};
    const auto first = number(prim, "livegs:first_key", 0);
    if (!first) return first.error();
    if (!(*first >= 0 && *first == std::floor(*first)))
      return bad(prim, "livegs:first_key has no valid value");
    PortableTrack track;
    track.body = body;
    track.first_key = static_cast<size_t>(*first);
    static const std::vector<std::pair<double, UsdaValue>> kNone;
    const auto samples_of = [](const UsdaPrim& of, const char* property) -> const auto& {
      const auto found = of.samples.find(property);
      return found == of.samples.end() ? kNone : found->second;
    };
    const auto& moved = samples_of(prim, "xformOp:translate");
    const auto& turned = samples_of(prim, "xformOp:orient");
    if (moved.size() != turned.size() || track.first_key + moved.size() > times_s_->size())
      return bad(prim, "has a track with the wrong number of keys");
    for (size_t i = 0; i < moved.size(); ++i) {
      const std::vector<double>& position = moved[i].second.numbers;
      const auto orientation = quaternion_of(turned[i].second);
      if (position.size() != 3 || !orientation) return bad(prim, "has a key without a valid pose");
      track.world_from_object.push_back({Vector3d(position.data()), *orientation});
    }
    for (const UsdaPrim& child : prim.children) {
      const size_t nodes =
          scene_.bodies[body].elastic ? scene_.bodies[body].elastic->lattice.node_coordinates.size() : 0;
      for (const auto& [time, sample] : samples_of(child, "points")) {
        if (sample.numbers.size() != 3 * nodes)
          return bad(child, "does not have the number of points of the lattice");
        auto& list = track.nodes_m.emplace_back();
        for (size_t i = 0; i < sample.numbers.size(); i += 3)
          list.push_back(
              Vector3d(sample.numbers[i], sample.numbers[i + 1], sample.numbers[i + 2]).cast<float>());
      }
    }
    if (!track.nodes_m.empty() && track.nodes_m.size() != track.world_from_object.size())
      return bad(prim, "has a point cache with the wrong number of keys");
    scene_.animation->tracks.push_back(std::move(track));
    return {};
  }

  const UsdaDocument& document_;
  std::string name_;
  PortableScene scene_;
  std::map<std::string, const UsdaPrim*> prims_;  // by path
  std::map<std::string, size_t> body_of_path_;
  std::vector<const UsdaPrim*> joints_;
  std::optional<std::vector<double>> times_s_;
};

}  // namespace

Result<PortableScene> decode_usda_scene(std::string_view text, std::string_view name) {
  const auto document = parse_usda(text, name);
  if (!document) return document.error();
  return StageReader(*document, name).read();
}

Result<PortableScene> read_usda_scene(const std::filesystem::path& path) {
  const auto text = read_text_file(path, kMaxFileBytes);
  if (!text) return text.error();
  return decode_usda_scene(*text, path.filename().string());
}

}  // namespace livegs
