// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// The alpha complexes of one point cloud (Edelsbrunner and Mücke 1994): which tetrahedra and triangles of its
// Delaunay triangulation an eraser ball of a given radius cannot sweep away. The triangulation is made once,
// any radius can be asked for afterwards.
//
// The body of a cloud of kernels is what such a ball cannot reach *from outside*: kernels lie on the surface
// of a thing, so the plain alpha shape of a ball is a hollow skin, or nothing. Everything behind the skin
// belongs to the body.
//
// Not thread-safe. Lengths in the units of the points, best near 1.
class AlphaComplex {
 public:
  // Duplicates are allowed; values must be finite.
  explicit AlphaComplex(std::span<const Eigen::Vector3d> points);
  ~AlphaComplex();
  AlphaComplex(const AlphaComplex&) = delete;
  AlphaComplex& operator=(const AlphaComplex&) = delete;

  // 3, or less when all points lie in a plane (2), on a line (1) or in one place (0). Below 3 nothing else
  // may be asked but thicken_plane.
  int dimension() const;

  // Median over the points of the distance to the nearest other.
  double median_gap() const;

  // Gives a cloud of dimension 2 the given thickness.
  void thicken_plane(double thickness);

  // Sheets and threads of points that bound no volume at this radius get a thickness, by further points on
  // both sides. Returns how many points were thickened.
  size_t thicken_sheets(double radius, double thickness);

  struct Body {
    TriangleMesh
        mesh;  // closed, manifold, outwards; parts that touch in an edge or vertex are separate pieces
    double covered = 0.0;  // part of the cloud that lies in it or on it
  };
  // What the ball cannot reach. May be empty. The order of vertices and triangles depends on the points
  // alone.
  Body body(double radius);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace livegs
