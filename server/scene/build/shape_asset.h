// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "gaussian/gaussian_asset.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

// Kernels for things that were not captured, so that they can be drawn: flat ones spread over a mesh, shaded
// by one fixed light. The asset's frame is the mesh's (metres, +Y up), so its object_from_asset is the
// identity.
GaussianAsset mesh_asset(const TriangleMesh& mesh, const Eigen::Vector3f& rgb, size_t kernel_count = 6000);

// One round kernel a point, its standard deviation half the spacing, so that neighbours just close.
GaussianAsset point_asset(std::span<const Eigen::Vector3d> points_m, double spacing_m,
                          const Eigen::Vector3f& rgb);

// A colour for the n-th object that has none: well apart from its neighbours' colours.
Eigen::Vector3f palette_rgb(size_t index);

}  // namespace livegs
