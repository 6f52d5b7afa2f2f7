// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// Surface of a deformed body as points with normals, for penetration depth queries. The signed distance is
// the weighted mean of the distances to the tangent planes of nearby points (implicit moving least squares,
// Kolluri 2008). Points of faces that meet at an edge are kept apart: inside a convex edge the distance is
// the maximum over the faces (their intersection). Exact on flat faces and edges at any spacing; on a surface
// of curvature k the error is at most k s²/8 with point spacing s.

namespace livegs {

struct SurfaceElement {
  Eigen::Vector3d position_m;  // world frame
  Eigen::Vector3d normal;      // outward unit normal; zero: the element is a ball of `radius_m`
  double radius_m = 0.0;
  uint32_t index = 0;  // index within the body
};

// Result of a depth query.
struct SurfaceDepth {
  double distance_m;       // negative inside
  Eigen::Vector3d normal;  // outward
  uint32_t element;        // index of the nearest element
};

// Uniform grid of surface elements. Immutable after construction.
class PointSurface {
 public:
  // `reach_m` is the support radius of an element; 1.5 spacings leave no gap. Keeps a reference to
  // `elements`.
  PointSurface(const std::vector<SurfaceElement>& elements, double reach_m);

  // Signed distance at a point; nullopt if no element is within reach. `own` are the faces at the querying
  // point if it lies on a surface. Inside an edge, only faces opposite to one of `own` are considered, and
  // the result is nullopt if there are none; just behind another face, the distance grows from zero.
  std::optional<SurfaceDepth> depth(const Eigen::Vector3d& point_m,
                                    std::span<const SurfaceElement> own = {}) const;
  // The same for a point that moved by `displacement_m`: samples the path in steps of half the reach, so that
  // the side of first contact is found. The distance is that of the end point.
  std::optional<SurfaceDepth> swept_depth(const Eigen::Vector3d& end_m, const Eigen::Vector3d& displacement_m,
                                          std::span<const SurfaceElement> own = {}) const;

 private:
  // Calls visit(index, square of the distance) for the elements within reach.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& point_m, const Visit& visit) const;

  const std::vector<SurfaceElement>& elements_;
  double reach_m_, cell_m_;
  Eigen::Vector3d low_m_;
  Eigen::Vector3i counts_;
  std::vector<uint32_t> begins_, sorted_;  // elements by cell
  std::vector<double> x_m_, y_m_, z_m_;    // positions of sorted_
};

}  // namespace livegs
