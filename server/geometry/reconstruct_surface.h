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

// From a cloud of kernels to a closed surface: LIVE-GS's alpha shape (CGAL), repaired or replaced until it is
// a body.

namespace livegs {

struct SurfaceOptions {
  // Alpha radius and voxel downsampling, in parts of the bounding-box diagonal (LIVE-GS: elastic 0.03, rigid
  // voxels of 0.02 and radius 0.1). downsample 0 thins only as far as the shape does not change (a third of
  // the radius).
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

// Where the body is: the centres of kernels that are opaque enough (0.1) and not far from the rest (groups a
// 50th of the diagonal away from all others and with less than a thousandth of the kernels are left out), and
// further points out to one standard deviation of kernels larger than a hundredth of the diagonal. Object
// frame, metres.
std::vector<Eigen::Vector3d> body_points(const GaussianAsset& asset, const Similarity& object_from_asset);

// Any point cloud ends in a body, which is all that a ball of the alpha radius cannot reach from outside:
// hollows behind a closed skin are filled, sheets and threads that bound no volume get a thickness of a tenth
// of the radius. A shape that is empty or leaves a fifth of the points out is tried with a larger radius; one
// in pieces too, if that joins them without swelling it by more than a quarter (a plant keeps its separate
// leaves). Then comes the convex hull, then a box; `note` says which. Fails only for no points or values that
// are not finite. Deterministic.
Result<Surface> reconstruct_surface(std::span<const Eigen::Vector3d> points_m, const SurfaceOptions& options);

}  // namespace livegs
