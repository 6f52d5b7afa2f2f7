// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/pose.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/triangle_mesh.h"
#include "livegs/v1/physics.pb.h"
#include "livegs/v1/scene.pb.h"
#include "skin/rest_body.h"

// A scene in the form for other programs: bodies with splats, mass, contact surfaces, joints and motion, in
// the state before the first tick. The writers and readers of both formats use it. SI units, right-handed, +Y
// up. Plain values; any thread.

namespace livegs {

// A contact surface in its own frame. Cylinder and capsule are along y; the solid of a plane is y <= 0.
struct PortableShape {
  enum class Kind { Plane, Box, Sphere, Cylinder, Capsule, Mesh };
  Kind kind = Kind::Box;
  Pose owner_from_shape;                             // owner: the body, or the world
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // box: full edge lengths
  double radius_m = 0;                               // sphere, cylinder, capsule
  double height_m = 0;                               // cylinder; capsule: between the centres of its caps
  std::shared_ptr<const TriangleMesh> mesh;
  bool convex = false;  // mesh: equals its convex hull
  double friction = 0.5, restitution = 0.2;
};

struct PortableElastic {
  double youngs_modulus_pa = 0, poisson_ratio = 0;
  double structure_coefficient = 1;  // the body as a whole has this times the modulus
  double plasticity = 0;             // 0 to 1
  double damping = 0;                // loss factor
  v1::ElasticAccuracy accuracy;      // cells, substeps and the stiffness that LiveGS reaches
  std::vector<v1::Region> regions;
  // Fields of RestBody: object_from_lattice, cell_width_m, node_coordinates, cells and cell_fills.
  RestBody lattice;
};
// Its numbers, by the names of both formats.
struct ElasticNumber {
  const char* name;
  double PortableElastic::*value;
};
inline constexpr ElasticNumber kElasticNumbers[] = {
    {"youngs_modulus_pa", &PortableElastic::youngs_modulus_pa},
    {"poisson_ratio", &PortableElastic::poisson_ratio},
    {"structure_coefficient", &PortableElastic::structure_coefficient},
    {"plasticity", &PortableElastic::plasticity},
    {"damping", &PortableElastic::damping}};

struct PortableBody {
  std::string name;  // any text; unique among bodies
  v1::Physics::Behavior behavior = v1::Physics::STATIC;
  bool hidden = false;
  bool drawn_only = false;  // the background, and objects that exist only in a recording: no mass, no contact
  Pose world_from_object;
  // World frame, of the centre of mass.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();
  double mass_kg = 0;                                       // 0: does not move
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();       // centre of mass, object frame
  Eigen::Vector3d inertia_kg_m2 = Eigen::Vector3d::Zero();  // about the centre of mass, principal
  Eigen::Quaterniond object_from_inertia = Eigen::Quaterniond::Identity();
  double friction = 0.5, restitution = 0.2;
  std::vector<PortableShape> shapes;
  v1::PhysicalParameters estimates;  // ranges, sources and reasons; empty if not estimated
  std::optional<PortableElastic> elastic;
  std::shared_ptr<const GaussianAsset> asset;  // may be null
  size_t kernel_count = 0;                     // of the asset; a reader may leave the asset out
  Similarity object_from_asset;

  Eigen::Matrix3d inertia_tensor_kg_m2() const {
    const Eigen::Matrix3d axes = object_from_inertia.toRotationMatrix();
    return axes * inertia_kg_m2.asDiagonal() * axes.transpose();
  }
};

// A joint of a body to another one or to the world, closed in the poses of the scene. Point and axis are in
// the frame of `body`.
struct PortableJoint {
  bool hinge = false;  // else a ball joint
  size_t body = 0;
  std::optional<size_t> other;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // hinges; unit
};

// The motion of a body, over the keys first_key to first_key + size - 1 of the animation. Outside of them the
// body does not exist.
struct PortableTrack {
  size_t body = 0;
  size_t first_key = 0;
  std::vector<Pose> world_from_object;                // by key; elastic: the nearest rigid motion
  std::vector<std::vector<Eigen::Vector3f>> nodes_m;  // by key; elastic only: lattice nodes, world frame
};

struct PortableAnimation {
  std::vector<double> times_s;  // ascending, from 0
  std::vector<PortableTrack> tracks;
};

struct PortableScene {
  std::string name;
  Eigen::Vector3d gravity_m_s2{0, -9.81, 0};
  double rate_hz = 90;
  std::vector<PortableBody> bodies;
  std::vector<PortableShape> fixed;  // contact surfaces of the surroundings; owner: the world
  std::vector<PortableJoint> joints;
  std::optional<PortableAnimation> animation;
  std::vector<std::string> notes;  // about data that could not be converted, one line each
};

// The poses of the axes x of a joint and of its point, in the frame of its first body: the frame of the
// joint in both formats.
Pose joint_frame(const PortableJoint& joint);

// Lines for `livegs info`: a body, its mass, inertia and material, a joint.
std::string body_line(const PortableBody& body);
std::string joint_text(const PortableScene& scene, const PortableJoint& joint);

// Name of a value of PortableShape::Kind: "box".
const char* name_of(PortableShape::Kind kind);

}  // namespace livegs
