// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "geometry/fracture/voronoi_pieces.h"

// Prepares the kernels of an asset for the pieces that its body breaks into. Runs once after the cut, on any
// thread. A break only swaps in the prepared asset.
//
// Use the fine surface (elastic_surface_options). If a coarse mesh extends beyond the kernels, as in the
// handle of a cup, the kernels of its cut faces would be visible.

namespace livegs {

// Source index of a kernel that was made for a cut face.
inline constexpr uint32_t kInteriorKernel = ~0u;

struct PieceKernelOptions {
  // Maximum extent of a kernel across a cut at three standard deviations, metres; 0: a 200th of the diagonal
  // of the body. Larger kernels are first replaced by several narrower ones with the same moments.
  double max_overhang_m = 0.0;
  // Spacing of the kernels on cut faces, metres; 0: the median size of the surface kernels, with at most
  // max_interior kernels in all.
  double interior_spacing_m = 0.0;
  size_t max_interior = 60000;
  // Colour of the inside, 0 … 1. Without it, a mix of the nearest surface colours and their mean over the
  // face.
  std::optional<Eigen::Vector3f> interior_rgb;
  std::stop_token stop;
};

// `asset` starts with the original kernels in their order. A kernel that is crossed by a cut is replaced by
// its part on its own side. The other parts follow, then the kernels of the cut faces. Arrays are per kernel.
struct PieceKernels {
  GaussianAsset asset;
  std::vector<uint32_t> piece;    // piece that the kernel moves with
  std::vector<uint32_t> source;   // index of the original kernel, or kInteriorKernel
  std::vector<uint32_t> changed;  // indices of original kernels that were modified
  size_t original_count = 0;
  size_t interior_begin = 0;  // first kernel of the cut faces
};

// Binds each kernel to the piece at its centre (VoronoiPieces::locate) and splits those whose ellipsoid at
// three standard deviations crosses the plane between two pieces.
//
// A part has the moments of the Gaussian truncated at the plane. Let a be the plane's distance in standard
// deviations along its normal n, p(a) and P(a) the normal density and distribution, h = p/P and s² = nᵀΣn.
// The part below the plane has
//   mass P, mean μ - h Σn/s, covariance Σ - (a h + h²) Σn nᵀΣ/s²,
// (Cartinhour 1990, one-dimensional marginals of truncated normals). Its peak opacity is P·sqrt(|Σ|/|Σ'|)
// times the original's, which keeps the integral of opacity, limited to 0.998. Parts with an opacity below
// 1/255 are dropped, because renderers skip them.
//
// Deterministic for any thread count. If cancelled, returns ErrorCode::Unavailable.
Result<PieceKernels> make_piece_kernels(const GaussianAsset& asset, const Similarity& object_from_asset,
                                        const VoronoiPieces& pieces, const PieceKernelOptions& options = {});

}  // namespace livegs
