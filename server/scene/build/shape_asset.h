// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "gaussian/gaussian_asset.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Makes kernels for a mesh that was not captured: flat kernels distributed over the surface and shaded by one
// fixed light. The asset uses the mesh's frame (metres, +Y up), so object_from_asset is the identity.
GaussianAsset mesh_asset(const TriangleMesh& mesh, const Eigen::Vector3f& rgb, size_t kernel_count = 6000);

// Makes one round kernel per point. The standard deviation is half the spacing, so that neighbours just close
// the gaps.
GaussianAsset point_asset(std::span<const Eigen::Vector3d> points_m, double spacing_m,
                          const Eigen::Vector3f& rgb);

// Returns the default colour of object n, distinct from the colours of its neighbours in the list.
Eigen::Vector3f palette_rgb(size_t index);

}  // namespace livegs
