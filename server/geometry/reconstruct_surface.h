// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/triangle_mesh.h"

// Reconstructs a closed surface from a cloud of kernels: the alpha shape of LIVE-GS (CGAL), repaired or
// replaced until it is a valid body.

namespace livegs {

struct SurfaceOptions {
  // Alpha radius and voxel downsampling, relative to the bounding-box diagonal (LIVE-GS: elastic 0.03; rigid
  // voxels of 0.02 and radius 0.1). With downsample 0, points are thinned to a third of the radius, which
  // keeps the shape.
  double alpha_radius = 0.03;
  double downsample = 0.0;
  // A skin of points with holes that let the ball in is closed by a larger ball. Off for rooms: their doors
  // are openings.
  bool close_leaks = true;
};
SurfaceOptions elastic_surface_options();
SurfaceOptions rigid_surface_options();

enum class SurfaceSource { AlphaShape, LargerAlphaShape, ConvexHull, Box };

struct Surface {
  TriangleMesh mesh;  // closed, outward-facing, volume > 0
  SurfaceSource source = SurfaceSource::AlphaShape;
  double alpha_radius_m = 0.0;  // the radius that was used
  std::string note;             // one line: what was repaired or replaced and why; empty if nothing was
};

// Returns the points that define a body, object frame, metres:
// - Centres of kernels with an opacity of at least 0.1.
// - For kernels larger than a hundredth of the diagonal, additional points up to one standard deviation.
// Small isolated groups are dropped: a 50th of the diagonal from all others, with less than a thousandth of
// the kernels.
std::vector<Eigen::Vector3d> body_points(const GaussianAsset& asset, const Similarity& object_from_asset);

// Makes a body of any point cloud: the region that a ball of the alpha radius cannot reach from outside.
// - Cavities behind a closed skin are filled.
// - Sheets and threads without volume get a thickness of a tenth of the radius.
// - A shape that is empty or omits a fifth of the points is retried with a larger radius. So is a shape in
// pieces,
//   if that joins them and increases the volume by at most a quarter (a plant keeps its separate leaves).
// - Otherwise the convex hull is used, then a box; `note` reports it.
// Fails only without points or on values that are not finite. Deterministic.
Result<Surface> reconstruct_surface(std::span<const Eigen::Vector3d> points_m, const SurfaceOptions& options);

}  // namespace livegs
