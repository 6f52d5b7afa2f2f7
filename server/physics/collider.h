// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <variant>

#include "core/pose.h"
#include "geometry/field/distance_field.h"
#include "geometry/mesh/triangle_tree.h"

// What never moves and everything can touch.

namespace livegs {

struct ConvexPolyhedron;
struct RidgePoints;

struct PlaneShape {};  // the half-space y <= 0 of the collider's frame is solid
struct BoxShape {
  Eigen::Vector3d size_m = Eigen::Vector3d::Ones();              // full edge lengths, centred
  std::shared_ptr<const ConvexPolyhedron> polyhedron = nullptr;  // the same; the World makes it
};
struct SphereShape {
  double radius_m = 0.5;
};
struct FieldShape {
  std::shared_ptr<const DistanceField>
      field;  // a mesh or the captured background; immutable, shared by threads
  std::shared_ptr<const RidgePoints> ridges = nullptr;  // what of it sticks out; none are felt without
  // Of a surface that has no inside: the field is the distance to it on either side, the triangles give it
  // near by, and what is nearer than this is solid.
  std::shared_ptr<const TriangleTree> sheet = nullptr;
  double half_thickness_m = 0.0;
};
// What a point can jump over without being seen inside.
double min_thickness_m(const FieldShape& shape);

// A sphere trace advances by this part of a field's distance. Beyond its grid a field's distance is the way
// to the grid and on from there, which may exceed the straight line by a factor of sqrt(2). Larger: a trace
// may pass through a wall.
inline constexpr double kFieldMarchFactor = 0.7;

struct Collider {
  std::variant<PlaneShape, BoxShape, SphereShape, FieldShape> shape;
  Pose world_from_collider;
  double friction = 0.5;
  double restitution = 0.2;
};

// Signed distance from a world point to the collider's surface (negative inside) and the unit normal there,
// world frame, pointing out of the solid.
struct SurfaceSample {
  double distance_m;
  Eigen::Vector3d normal;
};
SurfaceSample sample_surface(const Collider& collider, const Eigen::Vector3d& point_m);

// The same of one collider for many points. Refers to the collider.
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

// Of two touching things: friction is the geometric mean, restitution the larger one.
double mixed_friction(double a, double b);
double mixed_restitution(double a, double b);

}  // namespace livegs
