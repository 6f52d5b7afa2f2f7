// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <vector>

#include "geometry/field/distance_field.h"
#include "geometry/triangle_mesh.h"
#include "physics/collision/bounding_sphere_tree.h"
#include "physics/collision/convex_polyhedron.h"

// What a rigid body is for contact: points against the surfaces of others, and a distance field against their
// points. A ball is its radius alone.

namespace livegs {

// At most this many contact points a body: 400 samples of a collider are about 10 µs.
inline constexpr size_t kMaxContactPoints = 400;
// No point of the surface is much farther than this from a contact point, in parts of the longest side of the
// bounding box. Smaller: finer bumps are felt, more points.
inline constexpr double kContactPointSpacing = 1.0 / 16.0;
// Cells of a body's own distance field along the longest side of its bounding box.
inline constexpr double kBodyFieldCells = 32.0;

// All lengths in the body frame: origin at the centre of mass, axes parallel to the object's at rest.
struct RigidShape {
  double sphere_radius_m = 0.0;  // > 0: a ball, and nothing below is filled but the bounds
  TriangleMesh mesh;
  std::vector<Eigen::Vector3d> contact_points_m;
  BoundingSphereTree contact_tree;  // of contact_points_m
  double contact_spacing_m = 0.0;
  // Where the mesh is one: exact, and used in place of the field. Both are shared by copies.
  std::shared_ptr<const ConvexPolyhedron> convex;
  std::shared_ptr<const DistanceField> field;
  // Several shapes that hold together, in place of a field: the distance is the least of theirs. Within, it
  // is that to the nearest face of a part, open or not.
  struct Part;
  std::vector<Part> parts;
  Eigen::Vector3d min_m, max_m;
  double bounding_radius_m = 0.0;  // about the centre of mass
  double wall_m = INFINITY;        // how thick its material is on average, of one that is not convex
  double inner_radius_m =
      0.0;  // of a ball about the centre of mass that lies within; 0: that centre is outside

  bool is_ball() const { return sphere_radius_m > 0.0; }
  // Signed distance to the body's surface. Never more than the true distance away from it, so that it can be
  // marched.
  DistanceField::Sample sample(const Eigen::Vector3d& point_m) const;
  // How much farther from the surface than the true distance a sample may be: a cell of the field.
  double sample_error_m() const;
};

struct RigidShape::Part {
  std::shared_ptr<const RigidShape> shape;
  Eigen::Vector3d offset_m;
};

// How finely a body's surface is felt. Of many small ones each needs less.
struct ShapeDetail {
  double field_cells = kBodyFieldCells;         // along the longest side of its bounding box
  double point_spacing = kContactPointSpacing;  // in parts of that side
  size_t max_points = kMaxContactPoints;
  DistanceField::Thin thin = DistanceField::Thin::Exact;
};

// Precondition: a closed mesh with a volume.
RigidShape mesh_shape(const TriangleMesh& object_mesh, const Eigen::Vector3d& centre_of_mass_m,
                      const ShapeDetail& detail = {});
RigidShape ball_shape(double radius_m);
// RigidShape::inner_radius_m of a shape that is not a ball.
double inner_radius_m(const RigidShape& shape);

// Points of the surface. Few vertices (up to three quarters of `max_points`) are all kept: a round thing
// rolls on them, and every facet that is left out costs it speed. Of more, those at least `spacing_m` apart,
// the most exposed (farthest from the origin) first; the extremes along 26 directions always stay. Long edges
// and large triangles are filled, `spacing_m` apart.
std::vector<Eigen::Vector3d> contact_points(const TriangleMesh& mesh, double spacing_m,
                                            size_t max_points = kMaxContactPoints);

}  // namespace livegs
