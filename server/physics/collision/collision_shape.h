// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/revision.h"
#include "geometry/field/distance_field.h"
#include "geometry/triangle_mesh.h"
#include "physics/collider.h"
#include "physics/collision/bounding_sphere_tree.h"
#include "physics/collision/convex_polyhedron.h"

// Contact geometry of a rigid body: contact points, tested against other surfaces, and a distance field,
// tested by the points of others. A ball has only a radius.

namespace livegs {

// Maximum number of contact points per body. Larger: finer contact, more time (400 samples of a collider take
// about 10 µs).
inline constexpr size_t kMaxContactPoints = 400;
// Spacing of contact points, relative to the longest side of the bounding box. Smaller: finer bumps collide,
// more points.
inline constexpr double kContactPointSpacing = 1.0 / 16.0;

// All lengths in the body frame: origin at the centre of mass, axes parallel to the object's at rest.
struct RigidShape {
  double sphere_radius_m = 0.0;  // > 0: a ball; of the fields below only the bounds are set
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> contact_points_m;
  BoundingSphereTree contact_tree;  // over contact_points_m
  double contact_spacing_m = 0.0;
  // Set if the mesh is convex: exact, replaces the field. Both are shared by copies.
  std::shared_ptr<const ConvexPolyhedron> convex;
  std::shared_ptr<const DistanceField> field;
  // Compound shape, replaces the field: the distance is the minimum over the parts. Inside, it is the
  // distance to the nearest face of a part, whether that face is open or not.
  struct Part;
  std::vector<Part> parts;
  // Exact surface of a cylinder or capsule (mesh_shape leaves it out).
  std::optional<RoundShape> round;
  Eigen::Vector3d min_m, max_m;
  double bounding_radius_m = 0.0;  // about the centre of mass
  double wall_m = INFINITY;        // mean wall thickness of a non-convex shape
  // Radius of the largest ball about the centre of mass inside the shape; 0: the centre is outside.
  double inner_radius_m = 0.0;
  uint64_t revision = new_revision();  // of the surface; copies share it

  bool is_ball() const { return sphere_radius_m > 0.0; }
  // Signed distance to the surface. Outside it is a lower bound of the true distance, so it is safe for
  // marching.
  DistanceField::Sample sample(const Eigen::Vector3d& point_m) const;
  // Upper bound of the error of a sampled distance: one cell of the field.
  double sample_error_m() const;
};

struct RigidShape::Part {
  std::shared_ptr<const RigidShape> shape;
  Eigen::Vector3d offset_m;
};

// Resolution of a contact shape. Each of many small bodies needs less.
struct ShapeDetail {
  double field_cells = 32.0;  // of its distance field, along the longest side of its bounding box
  double point_spacing = kContactPointSpacing;  // relative to that side
  size_t max_points = kMaxContactPoints;
  DistanceField::Thin thin = DistanceField::Thin::Exact;
};

// Contact shape of a mesh. Precondition: the mesh is closed and has a volume.
RigidShape mesh_shape(const TriangleMesh& object_mesh, const Eigen::Vector3d& centre_of_mass_m,
                      const ShapeDetail& detail = {});
RigidShape ball_shape(double radius_m);
// Computes RigidShape::inner_radius_m of a shape that is not a ball.
double inner_radius_m(const RigidShape& shape);

// Distance of a point to the nearest triangle of the mesh.
double triangle_distance_m(const RigidShape& shape, const Eigen::Vector3d& point_m);
double surface_area_m2(const TriangleMesh& mesh);

// Axis-aligned box around a shape that is turned and then moved.
struct ShapeBox {
  Eigen::Vector3d middle_m, half_m;
};
ShapeBox turned_box(const RigidShape& shape, const Eigen::Matrix3d& turn, const Eigen::Vector3d& position_m);

// Contact points of a surface. If there are few vertices (up to 3/4 of `max_points`), all are kept: a round
// body rolls on them and would lose speed at a missing facet. Otherwise vertices at least `spacing_m` apart
// are kept, the farthest from the origin first; the extremes along 26 directions are always kept. Long edges
// and large triangles are filled with points `spacing_m` apart.
// Preconditions: the mesh has a triangle, spacing_m > 0.
std::vector<Eigen::Vector3d> contact_points(const TriangleMesh& mesh, double spacing_m,
                                            size_t max_points = kMaxContactPoints);

}  // namespace livegs
