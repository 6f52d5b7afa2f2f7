// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "core/pose.h"
#include "core/result.h"
#include "geometry/triangle_mesh.h"

// From a cloud of kernels to a closed surface: LIVE-GS's alpha shape (CGAL), repaired or replaced until it is a body.

namespace livegs {

struct SurfaceOptions {
  // Alpha radius and voxel downsampling, in parts of the bounding-box diagonal (LIVE-GS: elastic 0.03, rigid voxels of
  // 0.02 and radius 0.1). downsample 0 keeps every point.
  double alpha_radius = 0.03;
  double downsample = 0.0;
};
SurfaceOptions elastic_surface_options();
SurfaceOptions rigid_surface_options();

enum class SurfaceSource { AlphaShape, LargerAlphaShape, ConvexHull, Box };

struct Surface {
  TriangleMesh mesh;  // closed, oriented outwards, volume > 0
  SurfaceSource source = SurfaceSource::AlphaShape;
  double alpha_radius_m = 0.0;  // the one that was used
  std::string note;             // one line: what was repaired or replaced and why; empty when nothing was
};

// The kernels that make up the body: opaque enough, not far from the rest. Positions in the object frame, metres.
std::vector<Eigen::Vector3d> body_points(const GaussianAsset& asset, const Similarity& object_from_asset);

// Any point cloud ends in a body: an alpha shape that is open, empty or in pieces is tried with a larger radius, then
// replaced by the convex hull, then by a box; `note` says which. Fails only for no points or values that are not
// finite. Deterministic.
Result<Surface> reconstruct_surface(std::span<const Eigen::Vector3d> points_m, const SurfaceOptions& options);

}  // namespace livegs
