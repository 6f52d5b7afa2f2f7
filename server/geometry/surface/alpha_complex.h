// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// The alpha complexes of a point cloud (Edelsbrunner and Mücke 1994): the tetrahedra and triangles of its
// Delaunay triangulation that an eraser ball of a given radius cannot remove. One triangulation serves all
// radii.
//
// The body of a cloud of kernels is the region that such a ball cannot reach *from outside*. Kernels lie on
// the surface of an object, so the plain alpha shape is a hollow skin or empty. The region behind the skin is
// part of the body.
//
// Not thread-safe. Lengths are in the units of the points, preferably near 1.
class AlphaComplex {
 public:
  // Duplicates are allowed; values must be finite.
  explicit AlphaComplex(std::span<const Eigen::Vector3d> points);
  ~AlphaComplex();
  AlphaComplex(const AlphaComplex&) = delete;
  AlphaComplex& operator=(const AlphaComplex&) = delete;

  // Returns 3, or less if all points lie in a plane (2), on a line (1) or at one position (0). Below 3 only
  // thicken_plane may be called.
  int dimension() const;

  // Returns the median distance to the nearest other point.
  double median_gap() const;

  // Gives a cloud of dimension 2 the given thickness.
  void thicken_plane(double thickness);

  // Gives sheets and threads without volume at this radius a thickness, by adding points on both sides.
  // Returns the number of thickened points.
  size_t thicken_sheets(double radius, double thickness);

  struct Body {
    TriangleMesh mesh;     // closed, manifold, outward-facing; parts that touch only in an edge or vertex are
                           // separate pieces
    double covered = 0.0;  // fraction of the cloud that lies in or on the mesh
  };
  // Returns the region that the ball cannot reach; may be empty. The order of vertices and triangles depends
  // only on the points.
  Body body(double radius);

  // Fraction of the cloud within `distance` of a corner of the body that was last computed, along edges of
  // the triangulation. Near 1 for points on a closed skin, small for points throughout a body.
  double near_surface(double distance) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livegs
