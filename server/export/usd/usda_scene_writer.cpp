// SPDX-License-Identifier: GPL-3.0-or-later
// OpenUSD: pxr/usd/usdPhysics/schema.usda and pxr/usd/usdVol/schema.usda (ParticleField3DGaussianSplat).
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/file.h"
#include "core/text/format_text.h"
#include "export/model/message_text.h"
#include "export/usd/estimate_attributes.h"
#include "export/usd/usda_text.h"
#include "export/usda_scene.h"
#include "gaussian/asset/y_up.h"

namespace livegs {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Kind = PortableShape::Kind;

constexpr const char* kOrder = "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]";

class StageWriter {
 public:
  explicit StageWriter(const PortableScene& scene) : scene_(scene) {}

  std::string write() {
    write_head();
    out_.open("def Xform \"World\"");
    out_.open("def PhysicsScene \"physicsScene\"");
    const double gravity = scene_.gravity_m_s2.norm();
    const Vector3d down = gravity > 0 ? Vector3d(scene_.gravity_m_s2 / gravity) : Vector3d(0, -1, 0);
    out_.line("vector3f physics:gravityDirection = " + usda_tuple(down));
    out_.line("float physics:gravityMagnitude = " + usda_number(gravity));
    out_.line("custom string livegs:name = " + usda_string(scene_.name));
    out_.line("custom double livegs:rate_hz = " + usda_number(scene_.rate_hz));
    if (scene_.animation) write_times(*scene_.animation);
    out_.close();
    write_materials();
    names_ = {"physicsScene", "Materials", "Joints", "Surroundings"};
    for (const PortableBody& body : scene_.bodies) paths_.push_back("/World/" + fresh(body.name));
    for (size_t i = 0; i < scene_.bodies.size(); ++i) write_body(i);
    if (!scene_.fixed.empty()) {
      out_.open("def Scope \"Surroundings\"");
      for (size_t i = 0; i < scene_.fixed.size(); ++i) write_collider(scene_.fixed[i], i, false);
      out_.close();
    }
    write_joints();
    out_.close();
    return out_.take();
  }

 private:
  void write_head() {
    out_.line("#usda 1.0");
    out_.line("(");
    out_.line("    defaultPrim = \"World\"");
    out_.line("    doc = \"Written by LiveGS\"");
    if (scene_.animation) {
      out_.line("    endTimeCode = " + usda_number(code_of(scene_.animation->times_s.back())));
      out_.line("    framesPerSecond = " + usda_number(scene_.rate_hz));
    }
    out_.line("    kilogramsPerUnit = 1");
    out_.line("    metersPerUnit = 1");
    if (scene_.animation) {
      out_.line("    startTimeCode = 0");
      out_.line("    timeCodesPerSecond = " + usda_number(scene_.rate_hz));
    }
    out_.line("    upAxis = \"Y\"");
    out_.line(")");
  }

  // A time code is a tick.
  double code_of(double time_s) const {
    const double ticks = time_s * scene_.rate_hz;
    return std::abs(ticks - std::round(ticks)) < 1e-3 ? std::round(ticks) : ticks;
  }

  void write_times(const PortableAnimation& animation) {
    std::string text;
    for (const double time : animation.times_s) text += (text.empty() ? "" : ", ") + usda_number(time);
    out_.line("custom double[] livegs:times_s = [" + text + "]");
  }

  std::string fresh(const std::string& name) {
    const std::string wanted = usda_identifier(name);
    std::string result = wanted;
    for (int n = 2; !names_.insert(result).second; ++n) result = wanted + "_" + std::to_string(n);
    return result;
  }

  std::string material_path(double friction, double restitution) const {
    return "/World/Materials/material_" + std::to_string(materials_.at({friction, restitution}));
  }

  void write_materials() {
    const auto add = [&](const PortableShape& shape) {
      materials_.try_emplace({shape.friction, shape.restitution}, materials_.size());
    };
    for (const PortableBody& body : scene_.bodies) {
      for (const PortableShape& shape : body.shapes) add(shape);
    }
    for (const PortableShape& shape : scene_.fixed) add(shape);
    if (materials_.empty()) return;
    out_.open("def Scope \"Materials\"");
    for (const auto& [values, index] : materials_) {
      out_.open("def Material \"material_" + std::to_string(index) +
                "\" (prepend apiSchemas = [\"PhysicsMaterialAPI\"])");
      out_.line("float physics:dynamicFriction = " + usda_number(values.first));
      out_.line("float physics:restitution = " + usda_number(values.second));
      out_.line("float physics:staticFriction = " + usda_number(values.first));
      out_.close();
    }
    out_.close();
  }

  void place(const Pose& pose, std::string_view order = kOrder) {
    out_.line("double3 xformOp:translate = " + usda_tuple(pose.position_m));
    out_.line("quatd xformOp:orient = " + usda_tuple(pose.orientation));
    out_.line(order);
  }

  const PortableTrack* track_of(size_t body) const {
    if (!scene_.animation) return nullptr;
    for (const PortableTrack& track : scene_.animation->tracks) {
      if (track.body == body) return &track;
    }
    return nullptr;
  }

  void write_body(size_t index) {
    const PortableBody& body = scene_.bodies[index];
    const std::string name = paths_[index].substr(paths_[index].rfind('/') + 1);
    out_.open(
        "def Xform \"" + name + "\"" +
        (body.mass_kg > 0 ? " (prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"])" : ""));
    out_.line("custom string livegs:name = " + usda_string(body.name));
    out_.line("custom token livegs:behavior = " + usda_string(v1::Physics::Behavior_Name(body.behavior)));
    if (body.drawn_only) out_.line("custom bool livegs:drawn_only = 1");
    if (body.mass_kg > 0) {
      out_.line("point3f physics:centerOfMass = " + usda_tuple(body.centre_m));
      out_.line("float3 physics:diagonalInertia = " + usda_tuple(body.inertia_kg_m2));
      out_.line("float physics:mass = " + usda_number(body.mass_kg));
      out_.line("quatf physics:principalAxes = " + usda_tuple(body.object_from_inertia));
      // In the space of the parent, whose axes are those of the world; degrees per second.
      if (!body.velocity_m_s.isZero(0))
        out_.line("vector3f physics:velocity = " + usda_tuple(body.velocity_m_s));
      if (!body.angular_velocity_rad_s.isZero(0))
        out_.line("vector3f physics:angularVelocity = " +
                  usda_tuple(Vector3d(body.angular_velocity_rad_s * (180 / std::numbers::pi))));
    }
    const PortableTrack* track = track_of(index);
    if (body.hidden) out_.line("token visibility = \"invisible\"");
    if (track) write_presence(*track, body.hidden);
    place(body.world_from_object);
    if (track && !track->world_from_object.empty()) write_motion(*track);
    write_estimates(body.estimates, out_);
    if (body.elastic) write_elastic(*body.elastic);
    if (body.asset && body.asset->size() > 0) write_splats(body);
    for (size_t i = 0; i < body.shapes.size(); ++i) write_collider(body.shapes[i], i, body.mass_kg > 0);
    if (body.elastic && !body.elastic->lattice.node_coordinates.empty()) write_lattice(body.elastic->lattice);
    if (track && !track->nodes_m.empty()) write_cache(*track);
    out_.close();
  }

  std::string code_at(size_t key) const { return usda_number(code_of(scene_.animation->times_s[key])); }

  void write_presence(const PortableTrack& track, bool hidden) {
    const size_t end = track.first_key + track.world_from_object.size();
    const size_t keys = scene_.animation->times_s.size();
    out_.line("custom int livegs:first_key = " + std::to_string(track.first_key));
    if (hidden || (track.first_key == 0 && end == keys)) return;
    std::string samples;
    const auto set = [&](size_t key, const char* value) {
      samples += (samples.empty() ? "" : ", ") + code_at(key) + ": \"" + value + "\"";
    };
    if (track.first_key > 0 || track.world_from_object.empty()) set(0, "invisible");
    if (!track.world_from_object.empty()) set(track.first_key, "inherited");
    if (!track.world_from_object.empty() && end < keys) set(end, "invisible");
    if (scene_.bodies[track.body].drawn_only && track.first_key > 0)
      out_.line("token visibility = \"invisible\"");
    out_.line("token visibility.timeSamples = { " + samples + " }");
  }

  void write_motion(const PortableTrack& track) {
    std::string moved, turned;
    Quaterniond before = Quaterniond::Identity();
    for (size_t i = 0; i < track.world_from_object.size(); ++i) {
      const Pose& pose = track.world_from_object[i];
      const double sign = before.dot(pose.orientation) < 0 ? -1 : 1;
      before.coeffs() = sign * pose.orientation.coeffs();
      const std::string code = (i > 0 ? ", " : "") + code_at(track.first_key + i) + ": ";
      moved += code + usda_tuple(pose.position_m);
      turned += code + usda_tuple(before);
    }
    out_.line("double3 xformOp:translate.timeSamples = { " + moved + " }");
    out_.line("quatd xformOp:orient.timeSamples = { " + turned + " }");
  }

  void write_elastic(const PortableElastic& elastic) {
    for (const ElasticNumber& one : kElasticNumbers)
      out_.line(std::string("custom double livegs:elastic:") + one.name + " = " +
                usda_number(elastic.*one.value));
    out_.line("custom string livegs:elastic:accuracy = " + usda_string(message_text(elastic.accuracy)));
    if (elastic.regions.empty()) return;
    std::string list;
    for (const v1::Region& region : elastic.regions)
      list += (list.empty() ? "" : ", ") + usda_string(message_text(region));
    out_.line("custom string[] livegs:elastic:regions = [" + list + "]");
  }

  void write_lattice(const RestBody& lattice) {
    std::vector<int64_t> nodes, cells;
    std::string fills;
    std::vector<float> points;
    for (const Eigen::Vector3i& node : lattice.node_coordinates) {
      const Vector3f point =
          (lattice.object_from_lattice * (lattice.cell_width_m * node.cast<double>())).cast<float>();
      for (int axis = 0; axis < 3; ++axis) {
        nodes.push_back(node[axis]);
        points.push_back(point[axis]);
      }
    }
    for (const auto& cell : lattice.cells) cells.insert(cells.end(), cell.begin(), cell.end());
    for (const uint64_t fill : lattice.cell_fills)
      fills +=
          (fills.empty() ? "\"" : ", \"") + format_text("%llx", static_cast<unsigned long long>(fill)) + '"';
    const std::vector<float> widths(lattice.node_coordinates.size(),
                                    static_cast<float>(0.1 * lattice.cell_width_m));
    out_.open("def Points \"lattice\"");
    out_.floats("point3f[] points", points, 3);
    out_.floats("float[] widths", widths, 1);
    out_.line("uniform token purpose = \"guide\"");
    out_.line("custom double livegs:cell_width_m = " + usda_number(lattice.cell_width_m));
    out_.line("custom double3 livegs:translation = " + usda_tuple(lattice.object_from_lattice.position_m));
    out_.line("custom quatd livegs:rotation = " + usda_tuple(lattice.object_from_lattice.orientation));
    out_.integers("custom int3[] livegs:nodes", nodes, 3);
    out_.integers("custom int[] livegs:cells", cells);
    if (!fills.empty()) out_.line("custom string[] livegs:cell_fills = [" + fills + "]");
    out_.close();
  }

  // The nodes in the world, whatever the transform of the body is.
  void write_cache(const PortableTrack& track) {
    out_.open("def Points \"cache\"");
    out_.line("uniform token[] xformOpOrder = [\"!resetXformStack!\"]");
    out_.line("uniform token purpose = \"guide\"");
    std::string samples;
    std::vector<float> values;
    for (size_t i = 0; i < track.nodes_m.size(); ++i) {
      values.clear();
      for (const Vector3f& node : track.nodes_m[i]) values.insert(values.end(), node.data(), node.data() + 3);
      samples += (i > 0 ? ", " : "") + code_at(track.first_key + i) + ": ";
      UsdaText::append_floats(samples, values, 3);
    }
    out_.line("point3f[] points.timeSamples = { " + samples + " }");
    out_.close();
  }

  void write_splats(const PortableBody& body) {
    GaussianAsset asset = *body.asset;
    turn_half_about_x(asset);
    const Similarity& similarity = body.object_from_asset;
    Quaterniond turn = (similarity.rotation * Quaterniond(0, 1, 0, 0).conjugate()).normalized();
    if (turn.vec().cwiseAbs().maxCoeff() < 1e-12) turn = Quaterniond::Identity();
    out_.open("def ParticleField3DGaussianSplat \"splats\"");
    const size_t count = asset.size(), rest = asset.sh_rest_count();
    std::vector<float> positions, orientations, scales, opacities, harmonics;
    Vector3f low = asset.positions[0], high = low;
    for (size_t i = 0; i < count; ++i) {
      const Vector3f size = asset.log_scales[i].array().exp();
      low = low.cwiseMin(asset.positions[i] - Vector3f::Constant(3 * size.maxCoeff()));
      high = high.cwiseMax(asset.positions[i] + Vector3f::Constant(3 * size.maxCoeff()));
      const Eigen::Quaternionf& q = asset.rotations[i];
      positions.insert(positions.end(), asset.positions[i].data(), asset.positions[i].data() + 3);
      orientations.insert(orientations.end(), {q.w(), q.x(), q.y(), q.z()});
      scales.insert(scales.end(), size.data(), size.data() + 3);
      opacities.push_back(1.0f / (1.0f + std::exp(-asset.opacity_logits[i])));
      harmonics.insert(harmonics.end(), asset.sh_dc[i].data(), asset.sh_dc[i].data() + 3);
      for (size_t k = 0; k < rest; ++k) {
        const Vector3f& one = asset.sh_rest[i * rest + k];
        harmonics.insert(harmonics.end(), one.data(), one.data() + 3);
      }
    }
    const float extent[] = {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
    out_.floats("float3[] extent", extent, 3);
    out_.floats("point3f[] positions", positions, 3);
    out_.floats("quatf[] orientations", orientations, 4);
    out_.floats("float3[] scales", scales, 3);
    out_.floats("float[] opacities", opacities, 1);
    out_.line("uniform int radiance:sphericalHarmonicsDegree = " + std::to_string(asset.sh_degree));
    out_.floats("float3[] radiance:sphericalHarmonicsCoefficients", harmonics, 3);
    out_.line("uniform token projectionModeHint = \"perspective\"");
    out_.line("uniform token sortingModeHint = \"cameraDistance\"");
    if (asset.antialiased) out_.line("custom bool livegs:antialiased = 1");
    out_.line("double3 xformOp:scale = " + usda_tuple(Vector3d(Vector3d::Constant(similarity.scale))));
    place({similarity.translation_m, turn},
          "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\", \"xformOp:scale\"]");
    out_.close();
  }

  void write_collider(const PortableShape& shape, size_t index, bool moves) {
    static const std::map<Kind, const char*> kTypes = {
        {Kind::Plane, "Plane"},       {Kind::Box, "Cube"},        {Kind::Sphere, "Sphere"},
        {Kind::Cylinder, "Cylinder"}, {Kind::Capsule, "Capsule"}, {Kind::Mesh, "Mesh"}};
    const std::string schemas = std::string("\"PhysicsCollisionAPI\", ") +
                                (shape.kind == Kind::Mesh ? "\"PhysicsMeshCollisionAPI\", " : "") +
                                "\"MaterialBindingAPI\"";
    out_.open(std::string("def ") + kTypes.at(shape.kind) + " \"collider_" + std::to_string(index) +
              "\" (prepend apiSchemas = [" + schemas + "])");
    out_.line("rel material:binding:physics = <" + material_path(shape.friction, shape.restitution) + ">");
    out_.line("uniform token purpose = \"guide\"");
    switch (shape.kind) {
      case Kind::Plane:
        out_.line("uniform token axis = \"Y\"");
        break;
      case Kind::Box:
        out_.line("double size = 1");
        out_.line("double3 xformOp:scale = " + usda_tuple(shape.size_m));
        break;
      case Kind::Cylinder:
      case Kind::Capsule:
        out_.line("uniform token axis = \"Y\"");
        out_.line("double height = " + usda_number(shape.height_m));
        [[fallthrough]];
      case Kind::Sphere:
        out_.line("double radius = " + usda_number(shape.radius_m));
        break;
      case Kind::Mesh:
        write_mesh(shape, moves);
        break;
    }
    place(
        shape.owner_from_shape,
        shape.kind == Kind::Box
            ? "uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\", \"xformOp:scale\"]"
            : kOrder);
    out_.close();
  }

  void write_mesh(const PortableShape& shape, bool moves) {
    std::vector<float> points;
    for (const Vector3d& vertex : shape.mesh->vertices_m) {
      for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(vertex[axis]));
    }
    std::vector<int64_t> indices, counts(shape.mesh->triangles.size(), 3);
    for (const auto& triangle : shape.mesh->triangles)
      indices.insert(indices.end(), triangle.begin(), triangle.end());
    // Few solvers can move a triangle mesh; they divide it into convex parts.
    out_.line(std::string("uniform token physics:approximation = \"") +
              (shape.convex ? "convexHull"
               : moves      ? "convexDecomposition"
                            : "none") +
              "\"");
    out_.line("uniform token subdivisionScheme = \"none\"");
    out_.integers("int[] faceVertexCounts", counts);
    out_.integers("int[] faceVertexIndices", indices);
    out_.floats("point3f[] points", points, 3);
  }

  void write_joints() {
    if (scene_.joints.empty()) return;
    out_.open("def Scope \"Joints\"");
    for (size_t i = 0; i < scene_.joints.size(); ++i) {
      const PortableJoint& joint = scene_.joints[i];
      const Pose frame = joint_frame(joint);
      const Pose world_from_frame = scene_.bodies[joint.body].world_from_object * frame;
      const Pose other = joint.other
                             ? scene_.bodies[*joint.other].world_from_object.inverse() * world_from_frame
                             : world_from_frame;
      out_.open(std::string("def ") + (joint.hinge ? "PhysicsRevoluteJoint" : "PhysicsSphericalJoint") +
                " \"joint_" + std::to_string(i) + "\"");
      if (joint.other) out_.line("rel physics:body0 = <" + paths_[*joint.other] + ">");
      out_.line("rel physics:body1 = <" + paths_[joint.body] + ">");
      if (joint.hinge) out_.line("uniform token physics:axis = \"X\"");
      out_.line("point3f physics:localPos0 = " + usda_tuple(other.position_m));
      out_.line("point3f physics:localPos1 = " + usda_tuple(frame.position_m));
      out_.line("quatf physics:localRot0 = " + usda_tuple(other.orientation));
      out_.line("quatf physics:localRot1 = " + usda_tuple(frame.orientation));
      out_.close();
    }
    out_.close();
  }

  const PortableScene& scene_;
  UsdaText out_;
  std::set<std::string> names_;
  std::vector<std::string> paths_;  // of the bodies
  std::map<std::pair<double, double>, size_t> materials_;
};

}  // namespace

std::string encode_usda_scene(const PortableScene& scene) { return StageWriter(scene).write(); }

Result<std::vector<std::filesystem::path>> write_usda_scene(const std::filesystem::path& path,
                                                            const PortableScene& scene) {
  if (auto written = write_file_atomically(path, encode_usda_scene(scene)); !written) return written.error();
  return std::vector{path};
}

}  // namespace livegs
