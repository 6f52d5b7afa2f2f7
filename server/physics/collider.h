// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <variant>
#include <vector>

#include "core/pose.h"
#include "geometry/field/distance_field.h"
#include "geometry/mesh/triangle_tree.h"
#include "physics/collision/bounding_sphere_tree.h"

// Static collision geometry.

namespace livegs {

struct ConvexPolyhedron;

struct PlaneShape {};  // the half-space y <= 0 of the collider's frame is solid
struct BoxShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();              // full edge lengths, centred on the origin
  std::shared_ptr<const ConvexPolyhedron> polyhedron = nullptr;  // the same box; created by the World
};
struct SphereShape {
  double radius_m = 0.5;
};
// The exact surface of a cylinder or capsule, of a rigid body only. A capsule's half length excludes its
// caps.
struct RoundShape {
  enum class Kind { Cylinder, Capsule };
  Kind kind = Kind::Cylinder;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  // unit
  double radius_m = 0.0, half_length_m = 0.0;
};
// Points along a mesh's convex edges, corners included, in the mesh's frame. They are tested against bodies
// because an edge may press into a face between the body's contact points.
struct RidgePoints {
  std::vector<Eigen::Vector3d> points_m;
  BoundingSphereTree tree;  // of points_m
};
struct FieldShape {
  // A mesh or the captured background; immutable, shared by threads.
  std::shared_ptr<const DistanceField> field;
  std::shared_ptr<const RidgePoints> ridges = nullptr;  // convex ridges; nullptr: none are tested
  // Open surfaces only: the field is the unsigned distance, the triangles give the exact distance near the
  // surface, and points closer than half_thickness_m are solid.
  std::shared_ptr<const TriangleTree> sheet = nullptr;
  double half_thickness_m = 0.0;
};
// Minimum thickness of the solid, m. A point that moves farther per substep may tunnel through.
double min_thickness_m(const FieldShape& shape);

// Safe fraction of a field's distance for one step of a sphere trace. Outside its grid the field returns the
// distance to the grid plus the distance from there, up to sqrt(2) times the true one. Larger: a trace may
// pass through a wall.
inline constexpr double kFieldMarchFactor = 0.7;

struct Collider {
  std::variant<PlaneShape, BoxShape, SphereShape, FieldShape> shape;
  Pose world_from_collider;
  double friction = 0.5;
  double restitution = 0.2;
};

// Signed distance from a world point to the collider's surface (negative inside) and the unit normal there
// (world frame, out of the solid).
struct SurfaceSample {
  double distance_m;
  Eigen::Vector3d normal;
};
SurfaceSample sample_surface(const Collider& collider, const Eigen::Vector3d& point_m);

// Samples one collider at many points. Keeps a reference to the collider.
class ColliderProbe {
 public:
  explicit ColliderProbe(const Collider& collider);
  SurfaceSample sample(const Eigen::Vector3d& point_m) const {
    if (plane_) return {up_.dot(point_m - collider_.world_from_collider.position_m), up_};
    return sample_shape(point_m);
  }
  const Collider& collider() const { return collider_; }

 private:
  SurfaceSample sample_shape(const Eigen::Vector3d& point_m) const;
  const Collider& collider_;
  Eigen::Matrix3d world_from_collider_;
  Eigen::Vector3d up_;  // the collider's y axis
  bool plane_;
};

// Material mixing of two bodies in contact: geometric mean of friction, maximum of restitution.
double mixed_friction(double a, double b);
double mixed_restitution(double a, double b);

}  // namespace livegs
