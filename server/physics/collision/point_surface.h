// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

// The surface of a deformed body as points with normals, to ask how deep something is inside it: the signed
// distance is the weighted mean of the distances to the tangent planes of nearby points (implicit moving
// least squares, Kolluri 2008). Points of faces that meet in an edge are kept apart: within a convex edge the
// distance is the largest of the faces' (their intersection). Exact on flat faces and edges however coarse;
// on a surface of curvature k it is off by up to k s²/8, s the spacing of the points.

namespace livegs {

struct SurfaceElement {
  Eigen::Vector3d position_m;  // world
  Eigen::Vector3d normal;      // unit, outwards; zero: the element is a ball of `radius_m`
  double radius_m = 0.0;
  uint32_t index = 0;  // the body's own
};

// What is known of a place near the surface.
struct SurfaceDepth {
  double distance_m;       // negative inside
  Eigen::Vector3d normal;  // outwards
  uint32_t element;        // the nearest one's index
};

// Elements in a regular grid. Immutable after building.
class PointSurface {
 public:
  // `reach_m`: how far from an element it speaks for the surface; 1.5 spacings leave no gap. Keeps a view of
  // `elements`.
  PointSurface(const std::vector<SurfaceElement>& elements, double reach_m);

  // Nothing where no element is within reach. `own` are the faces of the asking point, if it lies on a
  // surface: inside an edge the face it is measured from is one that they look at, and there is nothing where
  // they look at none.
  std::optional<SurfaceDepth> depth(const Eigen::Vector3d& point_m,
                                    std::span<const SurfaceElement> own = {}) const;
  // The same for a point that comes along `displacement_m`: followed in steps of half the reach, so that it
  // meets the side it came from; the distance is that of its end.
  std::optional<SurfaceDepth> swept_depth(const Eigen::Vector3d& end_m, const Eigen::Vector3d& displacement_m,
                                          std::span<const SurfaceElement> own = {}) const;

 private:
  const std::vector<SurfaceElement>& elements_;
  double reach_m_, cell_m_;
  Eigen::Vector3d low_m_;
  Eigen::Vector3i counts_;
  std::vector<uint32_t> begins_, sorted_;
};

}  // namespace livegs
